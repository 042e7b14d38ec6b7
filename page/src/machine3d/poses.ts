// The places of tool and axes along a program, from the table of a job's path.

import { Vector3 } from "three";
import type { Kinematics, Words } from "../api/types";
import type { PathRow } from "../api/path";
import { tipOf } from "./chain";

export interface Pose {
  tip: Vector3;
  words: Words;
  line: number;
  rapid: boolean;
  before: number | null;
  after: number | null;
}

const MOST_PARTS = 24;
/** A motion is drawn in parts that turn no more than this. */
const PART_DEG = 3;

export interface Way {
  kinematics: Kinematics;
  offset: readonly number[];
  toolLength: number;
  /** Whether the way between two poses is known: by the axes in machine interpolation, else straight. */
  byAxes: boolean;
}

/** Poses in the order of the program: the ends of motions, and places between them where an axis turns. */
export function posesOf(rows: PathRow[], way: Way): Pose[] {
  const poses: Pose[] = [];
  rows.forEach((row, index) => {
    const last = rows[index - 1];
    if (last && way.byAxes) between(poses, last, row, way);
    poses.push(poseAt(row, new Vector3(...row.tip), row.words));
  });
  return poses;
}

const poseAt = ({ line, rapid, before, after }: PathRow, tip: Vector3, words: Words): Pose => ({
  tip,
  words,
  line,
  rapid,
  before,
  after,
});

function between(poses: Pose[], from: PathRow, to: PathRow, way: Way): void {
  const turned = way.kinematics.rotary_axes.map(({ name }) => Math.abs((to.words[name] ?? 0) - (from.words[name] ?? 0)));
  const parts = Math.min(MOST_PARTS, Math.ceil(Math.max(0, ...turned) / PART_DEG));
  for (let part = 1; part < parts; part += 1) {
    const share = part / parts;
    const words: Words = {};
    for (const [name, word] of Object.entries(to.words) as [keyof Words, number | null][]) {
      const before = from.words[name];
      if (typeof word === "number") words[name] = (before ?? word) + share * (word - (before ?? word));
    }
    poses.push(poseAt(to, tipOf(way.kinematics, words, way.offset, way.toolLength), words));
  }
}

/** Whether the tip follows from the words: not under control of the tip, and not if a tool's length is unknown. */
export function followsAxes(rows: PathRow[], way: Omit<Way, "byAxes">): boolean {
  const row = rows.find(({ words }) => way.kinematics.rotary_axes.some(({ name }) => words[name]));
  if (!row) return false;
  const tip = tipOf(way.kinematics, row.words, way.offset, way.toolLength);
  return tip.distanceTo(new Vector3(...row.tip)) < 0.01;
}
