// The path of a job's program: a table with a row for each pose.

import { ask } from "./client";
import type { Axis, Vector, Words } from "./types";

export interface PathRow {
  line: number;
  rapid: boolean;
  arc: boolean;
  words: Words;
  tip: Vector;
  before: number | null;
  after: number | null;
}

export interface JobPath {
  rows: PathRow[];
  /** Motions that a row stands for at most. */
  together: number;
  /** Arcs of which only the ends are known. */
  chords: number;
}

/** Where the words of the axes begin, and where the tip does. */
const WORDS = 2;
const TIP = 7;
const ERRORS = 13;

export async function jobPath(id: string, signal: AbortSignal): Promise<JobPath> {
  const response = await ask(`/v1/jobs/${id}/path`, { accept: "text/csv", signal });
  const together = Number(response.headers.get("trunnion-motions-per-pose") ?? 1);
  const [head = "", ...lines] = (await response.text()).trimEnd().split(/\r?\n/);
  const letters = head.split(",").slice(WORDS, TIP) as Axis[];
  const rows = lines.map((line): PathRow => {
    const cells = line.split(",");
    const number = (at: number) => (cells[at] ? Number(cells[at]) : null);
    return {
      line: Number(cells[0]),
      rapid: cells[1] === "rapid",
      arc: cells[1] === "arc",
      words: Object.fromEntries(letters.map((letter, index) => [letter, number(WORDS + index)])) as Words,
      tip: [Number(cells[TIP]), Number(cells[TIP + 1]), Number(cells[TIP + 2])],
      before: number(ERRORS),
      after: number(ERRORS + 1),
    };
  });
  const isChord = (row: PathRow, at: number) => row.arc && [at - 1, at + 1].every((beside) => rows[beside]?.line !== row.line);
  return { rows, together, chords: together > 1 ? 0 : rows.filter(isChord).length };
}
