// Where the axes carry workpiece and tool. The signs are those of `docs/conventions.md`: a word is the motion of the
// tool relative to the workpiece, so a table turns by −θ, and a head by +θ.

import { Matrix4, Quaternion, Vector3 } from "three";
import type { Kinematics, RotaryAxis, Words } from "../api/types";

const vector = (from: readonly number[]) => new Vector3(from[0], from[1], from[2]);

export interface ChainAxis {
  axis: RotaryAxis;
  direction: Vector3;
  point: Vector3;
}

export function axesOf(kinematics: Kinematics, side: "table" | "head"): ChainAxis[] {
  return kinematics.rotary_axes
    .filter((axis) => axis.side === side)
    .map((axis) => ({ axis, direction: vector(axis.direction).normalize(), point: vector(axis.point_mm) }));
}

/** A turn about a line. */
export function about(point: Vector3, direction: Vector3, angle: number): Matrix4 {
  const turn = new Matrix4().makeRotationAxis(direction, angle);
  return new Matrix4()
    .makeTranslation(point.x, point.y, point.z)
    .multiply(turn)
    .multiply(new Matrix4().makeTranslation(-point.x, -point.y, -point.z));
}

/** The motion of one axis, with its location error enlarged by this factor. */
export function motionOf({ axis, direction, point }: ChainAxis, words: Words, magnified = 0): Matrix4 {
  const word = ((words[axis.name] ?? 0) * Math.PI) / 180;
  const angle = word * (axis.reversed ? -1 : 1) * (axis.side === "table" ? -1 : 1);
  const turn = about(point, direction, angle);
  const error = axis.location_error;
  if (!error || magnified === 0) return turn;
  const rotation = new Vector3(error.e_a_urad ?? 0, error.e_b_urad ?? 0, error.e_c_urad ?? 0).multiplyScalar(1e-6 * magnified);
  const shift = new Vector3(error.e_x_um ?? 0, error.e_y_um ?? 0, error.e_z_um ?? 0).multiplyScalar(1e-3 * magnified);
  const size = rotation.length();
  const misplaced = size > 0 ? about(point, rotation.clone().divideScalar(size), size) : new Matrix4();
  return new Matrix4().makeTranslation(shift.x, shift.y, shift.z).multiply(misplaced).multiply(turn);
}

/** From the table, on which the workpiece is, to the machine. */
export function machineFromTable(kinematics: Kinematics, words: Words): Matrix4 {
  return axesOf(kinematics, "table").reduce((all, axis) => all.multiply(motionOf(axis, words)), new Matrix4());
}

/** The tip in the workpiece, if X Y Z are the words of machine interpolation. */
export function tipOf(kinematics: Kinematics, words: Words, offset: readonly number[], toolLength: number): Vector3 {
  const tip = tipFromRam(kinematics, words, toolLength)
    .add(new Vector3(words.X ?? 0, words.Y ?? 0, words.Z ?? 0))
    .add(new Vector3(0, 0, toolLength))
    .add(vector(offset));
  return tip.applyMatrix4(machineFromTable(kinematics, words).invert()).sub(vector(offset));
}

/** The tip relative to the gauge point of the zero pose. */
export function tipFromRam(kinematics: Kinematics, words: Words, toolLength: number): Vector3 {
  const head = axesOf(kinematics, "head").reduce((all, axis) => all.multiply(motionOf(axis, words)), new Matrix4());
  return new Vector3(0, 0, -toolLength).applyMatrix4(head);
}

/** The turn that brings Z to this direction. */
export const fromZ = (direction: Vector3) =>
  new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), direction.clone().normalize());
