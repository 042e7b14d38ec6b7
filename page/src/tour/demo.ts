// Data to look at, on the example machine: a tool with its wear, calibration runs that grow, and a compensated program.
// Everything goes through the public interface.

import { ask, json } from "../api/client";
import { createJob } from "../api/jobs";
import { machinePath } from "../api/machines";
import type { Calibration } from "../api/types";
import { keepSource } from "../views/result/sources";
import blade from "../../../docs/examples/blade.nc";
import run from "../../../docs/examples/ballbar.json";
import { exampleMachine } from "./tour";

const TOOL = "T1";
const WEAR: [number, number][] = [
  [10, 6.2],
  [25, 10.9],
  [40, 14.1],
  [60, 19.6],
  [80, 24.2],
];
const DAY_MS = 86_400_000;
const ago = (days: number) => new Date(Date.now() - days * DAY_MS).toISOString();

interface Readings {
  readings?: { length_change_um: number }[];
}

export async function loadDemo(): Promise<void> {
  const machine = await exampleMachine();
  const path = machinePath(machine);
  const tool = { kind: "ball", number: 1, name: "BALL-10", radius_mm: 5, corner_radius_mm: 5, length_mm: 98.4 };
  await ask(`${path}/tools/${TOOL}`, { method: "PUT", json: tool, headers: { "If-None-Match": "*" } }).catch(() => undefined);
  await ask(`${path}/tools/${TOOL}/wear-entries`, {
    method: "POST",
    json: WEAR.map(([parts_cut, radius_wear_um], index) => ({
      measured_at: ago(30 - 5 * index),
      parts_cut,
      radius_wear_um,
      note: "demo",
    })),
  });
  // The same run with smaller errors stands for an earlier measurement.
  const measured = run as { tests: Readings[] };
  for (const [days, share] of [
    [180, 0.55],
    [90, 0.8],
    [5, 1],
  ] as const)
    await json<Calibration>(`${path}/calibrations`, {
      method: "POST",
      json: {
        ...measured,
        measured_at: ago(days),
        note: "demo",
        tests: measured.tests.map((test) => ({
          ...test,
          ...(test.readings && {
            readings: test.readings.map((one) => ({ ...one, length_change_um: Number((one.length_change_um * share).toFixed(1)) })),
          }),
        })),
      },
    });
  const file = new File([blade], "blade.nc", { type: "text/plain" });
  const parameters = { work_offset_mm: [12, -7, 35] };
  const made = await createJob({ machine_id: machine, operation: "cc-compensation", parameters, external_id: "demo: blade" }, file, file.name);
  keepSource(made.input_sha256, file);
}
