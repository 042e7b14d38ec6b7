// What of a report every operation has in common: the errors before and after, along the program.

import type { Job, Report, Series } from "../../api/types";

export interface Reading {
  beforeMax: number | null;
  afterMax: number | null;
  worstBefore: number | null;
  worstAfter: number | null;
  tolerance: number | null;
  series: { x: number[]; byPath: boolean; line: number[]; before: number[]; after: number[] } | null;
}

const member = (from: unknown, name: string): unknown =>
  from && typeof from === "object" ? (from as Record<string, unknown>)[name] : undefined;

export function toleranceOf(job: Job): number | null {
  const own = member(job.parameters, "tolerance_um") ?? member(member(job.parameters, "cc"), "tolerance_um");
  return typeof own === "number" ? own : null;
}

export function read(job: Job, report: Report): Reading {
  const sum = report.error_budget?.sum;
  const inPass = report.changes?.series;
  return {
    beforeMax: report.before?.max_um ?? sum?.before_um ?? null,
    afterMax: report.after?.max_um ?? sum?.after_um ?? null,
    worstBefore: report.before?.worst_line ?? sum?.before_line ?? null,
    worstAfter: report.after?.worst_line ?? sum?.after_line ?? null,
    tolerance: toleranceOf(job),
    series: report.series
      ? alongPath(report.series)
      : inPass
        ? { x: inPass.line, byPath: false, line: inPass.line, before: inPass.error_before_um, after: inPass.error_after_um }
        : null,
  };
}

const alongPath = (series: Series) => ({
  x: series.path_mm,
  byPath: true,
  line: series.line,
  before: series.before_um,
  after: series.after_um,
});
