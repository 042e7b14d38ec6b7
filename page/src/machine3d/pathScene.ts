// The tool path on the machine: before left of the divider, after right of it, and the cutter at one place.

import { Box3, Sphere, Vector3 } from "three";
import { Body, type Cutter } from "./body";
import { axesOf, machineFromTable } from "./chain";
import type { Pose, Way } from "./poses";
import type { Stage } from "./stage";
import { Trail } from "./trail";

export class PathScene {
  readonly #body: Body;
  readonly #trail: Trail;
  readonly #sphere: Sphere;
  #divider = 0.5;

  constructor(
    readonly stage: Stage,
    readonly poses: Pose[],
    readonly way: Way,
    top: number,
    cutter: Cutter,
  ) {
    const offset = new Vector3(...(way.offset as [number, number, number]));
    const extent = new Box3().setFromPoints(poses.filter((pose) => !pose.rapid).map((pose) => pose.tip));
    if (extent.isEmpty()) extent.setFromPoints(poses.map((pose) => pose.tip));
    this.#sphere = extent.translate(offset).getBoundingSphere(new Sphere());
    const inner = axesOf(way.kinematics, "table").at(-1);
    const up = inner?.direction ?? new Vector3(0, 0, 1);
    const lowest = Math.min(...cornersOf(extent).map((corner) => corner.sub(inner?.point ?? new Vector3()).dot(up)));
    const radius = Math.max(this.#sphere.radius, cutter.radius, 1);
    const reach = this.#sphere.center.clone().sub(inner?.point ?? new Vector3()).projectOnPlane(up).length() + radius;
    this.#body = new Body(way.kinematics, Math.max(reach * 1.1, radius * 1.3), lowest - radius * 0.35, cutter);
    this.#trail = new Trail(poses, top);
    this.#trail.all.position.copy(offset);
    this.#body.table.add(this.#trail.all);
    this.stage.scene.add(this.#body.all);
    this.stage.passes = () => this.#render();
    this.pose(0);
    this.fit();
  }

  /** Looks at the path as it lies at the first pose. */
  fit(): void {
    const first = this.poses[0];
    const place = this.#sphere.clone();
    if (first) place.applyMatrix4(machineFromTable(this.way.kinematics, first.words));
    place.radius *= 1.75;
    this.stage.look(place);
  }

  pose(index: number): void {
    const pose = this.poses[Math.round(index)];
    if (!pose) return;
    const tip = pose.tip.clone().add(new Vector3(...(this.way.offset as [number, number, number])));
    this.#body.pose(pose.words, tip.applyMatrix4(machineFromTable(this.way.kinematics, pose.words)));
    this.stage.draw();
  }

  divide(share: number): void {
    this.#divider = share;
    this.stage.draw();
  }

  #render(): void {
    const { renderer, scene, camera, width, height } = this.stage;
    const left = Math.round(width * this.#divider);
    renderer.setScissorTest(true);
    for (const [which, from, until] of [
      ["before", 0, left],
      ["after", left, width],
    ] as const) {
      if (until <= from) continue;
      renderer.setScissor(from, 0, until - from, height);
      this.#trail.show(which);
      renderer.render(scene, camera);
    }
  }

  /** Leaves the stage empty. */
  end(): void {
    this.stage.passes = null;
    this.stage.scene.remove(this.#body.all);
  }
}

function cornersOf(box: Box3): Vector3[] {
  const ends = [box.min, box.max];
  return ends.flatMap((x) => ends.flatMap((y) => ends.map((z) => new Vector3(x.x, y.y, z.z))));
}
