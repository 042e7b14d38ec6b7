// A walk through the page on an example: five steps from a program to its proof. It uses what any visitor could use.

import { signal } from "@preact/signals";
import { machines, presets, putMachine } from "../api/machines";
import { go } from "../router";
import { done, entered, program } from "../views/compensate/Compensate";
import { EMPTY } from "../views/compensate/request";
import blade from "../../../docs/examples/blade.nc";

/** The step, from 1; 0 if there is no tour. */
export const step = signal(0);
export const STEPS = 5;
/** The machine that a new service has. */
export const EXAMPLE = "example-ac-table";

let machine = EXAMPLE;

export async function startTour(): Promise<void> {
  machine = await exampleMachine();
  done.value = null;
  program.value = new File([blade], "blade.nc", { type: "text/plain" });
  entered.value = {
    ...EMPTY,
    machine,
    byRadius: true,
    radius: "5",
    offset: ["12", "-7", "35"],
    reference: "tour",
  };
  goTo(1);
}

/** The machine that a new service has, or else any with A and C tables, or else a new one. */
async function exampleMachine(): Promise<string> {
  const { items } = await machines();
  const fits = items.filter((one) => one.kinematics.rotary_axes.map(({ name, side }) => name + side).join() === "Atable,Ctable");
  const found = fits.find((one) => one.machine_id === EXAMPLE) ?? fits[0];
  if (found) return found.machine_id;
  const preset = (await presets()).items.find((one) => one.id === "ac-table");
  if (preset) await putMachine(EXAMPLE, { ...preset.profile, program_unit: "mm" }, null);
  return EXAMPLE;
}

/** What a step is about, so that it can be brought into sight. */
const SIGHT = ["", ".machineview", ".go", ".headline", ".card.path", ".provenance"];

export function goTo(next: number): void {
  if (next > STEPS) return end();
  step.value = next;
  if (next === 1) go("machines", machine);
  else go("compensate");
  setTimeout(() => document.querySelector(SIGHT[next] ?? "")?.scrollIntoView({ block: "center" }), 350);
}

export function end(): void {
  step.value = 0;
}
