// The example of `trunnion demo`, loaded by the page: a machine with its tools, calibration runs over ten months with
// one of them applied, the wear of two cutters, and jobs. Everything goes through the public interface.

import { ask, json } from "../api/client";
import { createJob, follow } from "../api/jobs";
import { machine as machineOf, machinePath, profileOf, putMachine } from "../api/machines";
import type { Calibration, Machine, Operation } from "../api/types";
import { keepSource } from "../views/result/sources";
import blade from "../../../docs/examples/blade.nc";
import dome from "../../../docs/examples/dome.nc";
import flank from "../../../docs/examples/flank.apt";
import measured from "./runs.json";
import { EXAMPLE } from "./tour";

export const DEMO = "demo-ac-table";

const TOOLS = {
  T1: { number: 1, name: "BALL-10", kind: "ball", radius_mm: 5, length_mm: 98.4 },
  T12: { number: 12, name: "BALL-10-ROUGH", kind: "ball", radius_mm: 5, length_mm: 112.7 },
};

/** The tests of every run: the axis, the bar, the ball, and the angles there and back. */
const TESTS: [string, string, [number, number, number], number, number][] = [
  ["C", "radial", [150, 20, 60], 0, 360],
  ["C", "axial", [150, 20, 60], 0, 360],
  ["A", "radial", [30, 10, 160], -90, 90],
  ["A", "axial", [30, 10, 160], -90, 90],
];
const ANGLE_STEP = 30;
/** The last run but one is applied, so that the newest shows what has changed since. */
const APPLIED = -2;

interface Measured {
  measured_at: string;
  temperature_c: number;
  /** Length changes in µm, test by test. */
  tests: number[][];
}

function runOf({ measured_at, temperature_c, tests }: Measured): object {
  return {
    kind: "rtcp-ballbar",
    measured_at,
    temperature_c,
    instrument: "ball bar, 0.1 µm resolution",
    operator: "demo",
    note: "made by a simulation: errors that grow from run to run, up to 0.4 µm of noise",
    bar_length_mm: 100,
    setup_error_um: { e_xs: 4, e_ys: -6 },
    tests: TESTS.map(([rotary_axis, bar_direction, ball_mm, from, to], index) => {
      const there = Array.from({ length: (to - from) / ANGLE_STEP + 1 }, (_, step) => from + step * ANGLE_STEP);
      const angles = [...there, ...there.toReversed()];
      const readings = angles.map((angle_deg, at) => ({ angle_deg, length_change_um: tests[index]?.[at] ?? 0 }));
      return { rotary_axis, bar_direction, ball_mm, readings };
    }),
  };
}

/** Cutter, month, and radius wear in µm by parts. */
const WEAR: [string, number, [number, number][]][] = [
  ["1", 9, [[10, 12.4], [25, 17.9], [40, 21.2], [60, 26.8], [80, 31.1], [100, 36.3], [120, 41.5], [140, 47.9], [160, 55.6]]],
  ["2", 10, [[10, 11.8], [25, 17.2], [40, 20.6], [60, 26.1], [80, 31.2], [100, 35.9]]],
];
const two = (value: number) => String(value).padStart(2, "0");
const wearEntries = () =>
  WEAR.flatMap(([cutter_id, month, entries]) =>
    entries.map(([parts_cut, radius_wear_um], index) => ({
      measured_at: `2025-${two(month)}-${two(2 + 3 * index)}T14:30:00Z`,
      parts_cut,
      radius_wear_um,
      cutter_id,
      note: "tool setter",
    })),
  );

/** A turns past its end in the last line. */
const BEYOND = [
  "%",
  "(BEYOND THE END OF A)",
  "G21 G90 G17 G54",
  "T1 M6",
  "G0 X0.000 Y0.000 Z50.000 A0.000 C0.000",
  "G94 G1 X10.000 A60.000 C2.000 F800.",
  "X20.000 A125.000 C4.000",
  "M30",
  "%",
  "",
].join("\n");

const work_offset_mm = [12, -7, 35];
const JOBS: [string, Operation, object, string, string][] = [
  ["blade, contact path", "cc-compensation", { tool_radius_mm: 5, tolerance_um: 10 }, "blade.nc", blade],
  [
    "blade, all in one pass",
    "compensation",
    {
      wear: { nominal_tool: { radius_mm: 5 }, actual_tool: { radius_mm: 4.95 } },
      location_errors: true,
      cc: { tolerance_um: 5 },
    },
    "blade.nc",
    blade,
  ],
  ["blade, worn cutter", "wear-compensation", { nominal_tool: { radius_mm: 5 }, actual_tool: { radius_mm: 4.97 } }, "blade.nc", blade],
  ["blade, servo simulation", "servo-simulation", {}, "blade.nc", blade],
  [
    "dome, virtual cutting",
    "verification",
    { surface: { kind: "sphere", radius_mm: 20, half_angle_deg: 20 }, tool: { radius_mm: 4.5 } },
    "dome.nc",
    dome,
  ],
  ["flank, posted from APT", "posting", {}, "flank.apt", flank],
  ["a program out of travel, refused", "cc-compensation", { tool_radius_mm: 5, contact: "tip" }, "beyond.nc", BEYOND],
];

/** Loads the example. A machine of its name is never changed: then the service refuses. */
export async function loadDemo(): Promise<void> {
  const example = await json<Machine>(`${machinePath(EXAMPLE)}/revisions/1`);
  const profile = { ...profileOf(example), name: "Demo machine with an AC table", max_feed_mm_per_min: 15_000 };
  await putMachine(DEMO, profile, null);
  const path = machinePath(DEMO);
  for (const [id, tool] of Object.entries(TOOLS))
    await ask(`${path}/tools/${id}`, { method: "PUT", json: tool, headers: { "If-None-Match": "*" } });
  const runs: Calibration[] = [];
  for (const run of measured as Measured[])
    runs.push(await json<Calibration>(`${path}/calibrations`, { method: "POST", json: runOf(run) }));
  const { tag } = await machineOf(DEMO);
  await ask(`${path}/calibrations/${runs.at(APPLIED)?.id}/apply`, { method: "POST", json: {}, headers: { "If-Match": tag } });
  await ask(`${path}/tools/T12/wear-entries`, { method: "POST", json: wearEntries() });
  const ids: string[] = [];
  for (const [name, operation, parameters, fileName, text] of JOBS) {
    const file = new File([text], fileName, { type: "text/plain" });
    const request = { machine_id: DEMO, operation, parameters: { ...parameters, work_offset_mm }, external_id: `demo: ${name}` };
    const made = await createJob(request, file, fileName);
    keepSource(made.input_sha256, file);
    ids.push(made.id);
  }
  const forEver = new AbortController().signal;
  for (const id of ids) await follow(id, () => undefined, forEver);
}
