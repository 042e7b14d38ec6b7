// The places of tool and axes along a program, from what the service understands of it.

import { Vector3 } from "three";
import type { Interpretation, Kinematics, Motion, Words } from "../api/types";
import { tipOf } from "./chain";

export interface Pose {
  tip: Vector3;
  words: Words;
  line: number;
  rapid: boolean;
}

const MOST_PARTS = 24;
/** A motion is drawn in parts that turn no more than this. */
const PART_DEG = 3;

export interface Way {
  kinematics: Kinematics;
  offset: readonly number[];
  toolLength: number;
  /** Whether the control interpolates the tip. */
  tcp: boolean;
}

/** Poses in the order of the program: the ends of motions, and places between them where an axis turns. */
export function posesOf(interpretation: Interpretation, way: Way): Pose[] {
  const poses: Pose[] = [];
  let last: Motion | null = null;
  for (const motion of interpretation.motions) {
    if (!motion.tip_mm || !motion.axis) continue;
    const tip = new Vector3(...motion.tip_mm);
    const rapid = motion.kind === "rapid";
    if (last?.tip_mm) between(poses, last, motion, way);
    poses.push({ tip, words: motion.joints, line: motion.line, rapid });
    last = motion;
  }
  return poses;
}

function between(poses: Pose[], from: Motion, to: Motion, way: Way): void {
  const turned = way.kinematics.rotary_axes.map(({ name }) => Math.abs((to.joints[name] ?? 0) - (from.joints[name] ?? 0)));
  const parts = Math.min(MOST_PARTS, Math.ceil(Math.max(0, ...turned) / PART_DEG));
  const start = new Vector3(...(from.tip_mm ?? [0, 0, 0]));
  const end = new Vector3(...(to.tip_mm ?? [0, 0, 0]));
  for (let part = 1; part < parts; part += 1) {
    const share = part / parts;
    const words: Words = {};
    for (const [name, word] of Object.entries(to.joints) as [keyof Words, number | null][]) {
      const before = from.joints[name];
      if (typeof word === "number") words[name] = (before ?? word) + share * (word - (before ?? word));
    }
    const tip = way.tcp ? start.clone().lerp(end, share) : tipOf(way.kinematics, words, way.offset, way.toolLength);
    poses.push({ tip, words, line: to.line, rapid: to.kind === "rapid" });
  }
}
