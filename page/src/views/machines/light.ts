// The traffic light of a machine: its calibration, and its last jobs.

import type { Calibration, Job, Machine } from "../../api/types";
import { daysSince } from "../../parts/format";
import type { Texts } from "../../texts";

export type Light = "green" | "amber" | "red";

export interface Judged {
  light: Light;
  reasons: string[];
}

/** A calibration that ends within so many days is announced. */
const SOON_DAYS = 14;

export function judge(machine: Machine, newest: Calibration | null, applied: string | null, jobs: Job[], t: Texts): Judged {
  const reasons: [Light, string][] = [];
  const due = machine.calibration_due_days;
  if (!newest) reasons.push(["amber", t.lights.neverCalibrated]);
  else {
    const age = daysSince(newest.measured_at);
    if (typeof due !== "number") reasons.push(["amber", t.lights.noInterval(age)]);
    else if (age > due) reasons.push(["red", t.lights.overdue(age - due)]);
    else if (due - age <= SOON_DAYS) reasons.push(["amber", t.lights.dueSoon(due - age)]);
    else reasons.push(["green", t.lights.fresh(age, due)]);
    if (applied !== newest.id) reasons.push(["amber", t.lights.notApplied]);
  }
  const ended = jobs.filter((job) => job.state === "succeeded" || job.state === "failed");
  const failed = ended.filter((job) => job.state === "failed").length;
  if (failed > 0) reasons.push([ended[0]?.state === "failed" ? "amber" : "green", t.lights.failedJobs(failed, ended.length)]);
  const order: Light[] = ["red", "amber", "green"];
  const light = order.find((one) => reasons.some(([of]) => of === one)) ?? "green";
  return { light, reasons: reasons.map(([, words]) => words) };
}
