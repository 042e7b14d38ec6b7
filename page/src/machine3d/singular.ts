// Where a machine is singular: the tool axis is parallel to the rotary axis next to the workpiece, so that this axis
// turns without moving the tool axis. The interface does not state the direction; it follows from the lines of the axes.

import { Vector3 } from "three";
import type { Kinematics, RotaryAxis, Words } from "../api/types";
import { axesOf, type ChainAxis, machineFromTable, motionOf } from "./chain";

/** The service calls a motion singular this near to the pole, if a request states nothing else. */
export const ZONE_DEG = 3;

const Z = new Vector3(0, 0, 1);
const DEGREES = 180 / Math.PI;
/** A tool axis that comes no nearer than this never reaches the pole. */
const REACHED_DEG = 0.01;

export interface Pole {
  /** The axis that turns without effect. */
  idle: RotaryAxis;
  /** The axis that tilts the tool away from the pole, and its word there. */
  tilting: RotaryAxis;
  word_deg: number;
}

/** The axis next to the workpiece, and the one next to the tool: a profile has them in the order of the chain. */
function chainOf(kinematics: Kinematics): [ChainAxis, ChainAxis] | null {
  const tables = axesOf(kinematics, "table").toReversed();
  const [first, second] = [...tables, ...axesOf(kinematics, "head")];
  return first && second ? [first, second] : null;
}

/** The pole within the travel, or null if the tool axis never comes there. The tool may point along the axis or against it. */
export function poleOf(kinematics: Kinematics): Pole | null {
  const chain = chainOf(kinematics);
  if (!chain) return null;
  const [idle, tilting] = chain;
  const [low, high] = tilting.axis.limits_deg ?? [-180, 180];
  const across = (from: Vector3) => from.clone().projectOnPlane(tilting.direction);
  const tool = across(Z);
  if (tool.lengthSq() < 1e-12) return null;
  for (const direction of [idle.direction, idle.direction.clone().negate()]) {
    const least = Math.abs(Z.angleTo(tilting.direction) - direction.angleTo(tilting.direction)) * DEGREES;
    if (least > REACHED_DEG) continue;
    const wanted = across(direction);
    const angle = Math.atan2(tool.clone().cross(wanted).dot(tilting.direction), tool.dot(wanted)) * DEGREES;
    const word_deg = Math.round(angle * (tilting.axis.reversed ? -1 : 1) * 1e6) / 1e6 || 0;
    if (word_deg >= low && word_deg <= high) return { idle: idle.axis, tilting: tilting.axis, word_deg };
  }
  return null;
}

/** The singular direction in the machine, with the axes at these words: of both, the one that is nearer to the tool. */
export function poleDirection(kinematics: Kinematics, words: Words): Vector3 {
  const [idle] = chainOf(kinematics) ?? [];
  const direction = idle?.direction.clone() ?? Z.clone();
  if (idle?.axis.side === "table") direction.transformDirection(machineFromTable(kinematics, words));
  return direction.dot(toolDirection(kinematics, words)) < 0 ? direction.negate() : direction;
}

/** The direction from the tip along the tool, with the axes at these words. */
export function toolDirection(kinematics: Kinematics, words: Words): Vector3 {
  return axesOf(kinematics, "head").reduceRight((direction, axis) => direction.transformDirection(motionOf(axis, words)), Z.clone());
}

/** The angle between tool and pole. */
export const fromPole_deg = (kinematics: Kinematics, words: Words): number =>
  toolDirection(kinematics, words).angleTo(poleDirection(kinematics, words)) * DEGREES;

export interface Near {
  pole: Pole | null;
  angle_deg: number;
  zone_deg: number;
}

export const nearOf = (kinematics: Kinematics, words: Words): Near => ({
  pole: poleOf(kinematics),
  angle_deg: fromPole_deg(kinematics, words),
  zone_deg: ZONE_DEG,
});
