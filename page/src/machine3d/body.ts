// The machine as bodies: tables carry the workpiece, heads the tool. Everything follows from the lines of the rotary
// axes; a profile says nothing about sizes, so they are chosen to suit what is shown.

import { CapsuleGeometry, Group, Matrix4, SphereGeometry, Vector3 } from "three";
import type { Kinematics, Words } from "../api/types";
import { type ChainAxis, axesOf, motionOf, tipFromRam } from "./chain";
import { axisLine, box, cylinder, solid } from "./shapes";

export interface Cutter {
  radius: number;
  corner: number;
}

const Z = new Vector3(0, 0, 1);

export class Body {
  readonly all = new Group();
  /** What the workpiece lies on; its origin is at the machine's zero. */
  readonly table = new Group();
  readonly #tables: { axis: ChainAxis; group: Group }[] = [];
  readonly #heads: { axis: ChainAxis; group: Group }[] = [];
  readonly #ram = new Group();
  readonly #length: number;

  /** `size` is the radius of the table, `low` how far below the axis its face is. */
  constructor(
    readonly kinematics: Kinematics,
    size: number,
    low: number,
    cutter: Cutter,
  ) {
    this.#length = size * 0.95;
    this.#build(axesOf(kinematics, "table"), size, low);
    this.#buildHead(axesOf(kinematics, "head"), size, cutter);
  }

  #build(axes: ChainAxis[], size: number, low: number): void {
    let parent = this.all;
    axes.forEach((axis, index) => {
      const group = new Group();
      group.matrixAutoUpdate = false;
      parent.add(axisLine(axis.axis.name, axis.point, axis.direction, size * (index === 0 ? 1.75 : 1.2), true), group);
      this.#tables.push({ axis, group });
      parent = group;
    });
    parent.add(this.table);
    const inner = axes.at(-1);
    const up = inner?.direction ?? Z;
    const face = (inner?.point ?? new Vector3()).clone().addScaledVector(up, low);
    const thick = size * 0.14;
    const at = (below: number) => face.clone().addScaledVector(up, -below);
    if (!inner) {
      parent.add(box(at(thick / 2), new Vector3(size * 2.2, size * 1.7, thick), { body: "table" }));
      parent.add(box(at(thick * 2.2), new Vector3(size * 1.7, size * 1.4, thick * 2.4), { body: "bed" }));
      return;
    }
    parent.add(cylinder(at(thick / 2), up, size, thick, { body: "table" }));
    parent.add(cylinder(at(thick * 0.02), up, size * 0.985, thick * 0.06, { body: "tabletop" }));
    const outer = axes.length > 1 ? axes[0] : undefined;
    const carrier = outer ? this.#tables[0]?.group : this.all;
    carrier?.add(cylinder(at(thick * 1.5), up, size * 0.72, thick, { body: "carrier" }));
    if (outer && carrier) this.#cradle(outer, at(thick * 2.4), up, size, carrier);
    else carrier?.add(cylinder(at(thick * 3.4), up, size * 0.95, thick * 2.8, { body: "bed" }));
  }

  /** Two arms that hang on the outer axis and carry the table, and the bearings on the bed. */
  #cradle(outer: ChainAxis, beam: Vector3, up: Vector3, size: number, carrier: Group): void {
    const along = outer.direction;
    const across = up.clone().addScaledVector(along, -up.dot(along));
    if (across.lengthSq() < 0.05) {
      // Both axes are nearly parallel: one table stands on the other.
      carrier.add(cylinder(beam, up, size * 0.95, size * 0.12, { body: "carrier" }));
      this.all.add(cylinder(beam.clone().addScaledVector(up, -size * 0.3), along, size * 1.05, size * 0.4, { body: "bed" }));
      return;
    }
    across.normalize();
    const side = new Vector3().crossVectors(across, along);
    const frame = new Matrix4().makeBasis(along, side, across);
    const place = (group: Group) => {
      group.quaternion.setFromRotationMatrix(frame);
      return group;
    };
    const onAxis = outer.point.clone().addScaledVector(along, beam.clone().sub(outer.point).dot(along));
    const depth = Math.max(size * 0.25, onAxis.clone().sub(beam).dot(across));
    const floor = onAxis.clone().addScaledVector(across, -depth);
    const wide = size * 1.18;
    const thick = size * 0.16;
    carrier.add(place(box(floor, new Vector3(2 * wide + thick, size * 0.8, thick), { body: "carrier" })));
    for (const end of [-1, 1]) {
      const foot = floor.clone().addScaledVector(along, end * wide);
      const middle = foot.clone().addScaledVector(across, depth / 2);
      carrier.add(place(box(middle, new Vector3(thick, size * 0.55, depth + thick), { body: "carrier" })));
      const bearing = onAxis.clone().addScaledVector(along, end * (wide + thick * 0.7));
      carrier.add(cylinder(bearing, along, size * 0.24, thick * 2.2, { body: "tabletop" }));
      const post = bearing.clone().addScaledVector(along, end * thick * 1.6);
      const bottom = depth + size * 0.55;
      this.all.add(
        place(
          box(post.addScaledVector(across, -bottom / 2 + size * 0.16), new Vector3(thick * 1.6, size * 0.62, bottom + size * 0.32), {
            body: "bed",
          }),
        ),
      );
    }
  }

  #buildHead(axes: ChainAxis[], size: number, cutter: Cutter): void {
    this.all.add(this.#ram);
    let parent = this.#ram;
    axes.forEach((axis, index) => {
      const group = new Group();
      group.matrixAutoUpdate = false;
      parent.add(axisLine(axis.axis.name, axis.point, axis.direction, size * (index === 0 ? 1.05 : 0.8)));
      parent.add(cylinder(axis.point, axis.direction, size * (index === 0 ? 0.3 : 0.24), size * 0.62, { body: "bed" }));
      parent.add(group);
      this.#heads.push({ axis, group });
      parent = group;
    });
    // The tool hangs below the gauge point, the spindle sits above it.
    const radius = Math.max(cutter.radius, size * 0.012);
    const corner = Math.min(Math.max(cutter.corner, 0), radius);
    const length = this.#length;
    const at = (height: number) => new Vector3(0, 0, height);
    const shank = length * 0.42;
    parent.add(cylinder(at(-length + corner + (shank - corner) / 2), Z, radius, shank - corner, { body: "cutter" }));
    if (corner >= radius * 0.99) {
      const ball = solid(new SphereGeometry(radius, 32, 20), { body: "cutter" });
      ball.position.set(0, 0, -length + radius);
      parent.add(ball);
    } else if (corner > 0) {
      const nose = solid(new CapsuleGeometry(corner, Math.max(0.001, 2 * (radius - corner)), 8, 24), { body: "cutter" });
      nose.rotation.z = Math.PI / 2;
      nose.position.set(0, 0, -length + corner);
      parent.add(nose);
    }
    const holder = length - shank;
    const foot = Math.max(radius * 1.25, size * 0.07);
    parent.add(cylinder(at(-holder / 2), Z, Math.max(size * 0.15, foot * 1.2), holder, { body: "tabletop" }, foot));
    parent.add(cylinder(at(size * 0.24), Z, size * 0.27, size * 0.48, { body: "table" }));
    parent.add(cylinder(at(size * 0.62), Z, size * 0.33, size * 0.3, { body: axes.length ? "table" : "bed" }));
  }

  /** Puts the axes at these words and the tip at this place of the machine. */
  pose(words: Words, tip: Vector3, magnified = 0): void {
    for (const { axis, group } of [...this.#tables, ...this.#heads]) {
      group.matrix.copy(motionOf(axis, words, magnified));
      group.matrixWorldNeedsUpdate = true;
    }
    this.#ram.position.copy(tip).sub(tipFromRam(this.kinematics, words, this.#length));
  }
}
