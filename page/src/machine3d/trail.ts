// The tool path as a coloured line, once with the deviation before and once with the deviation after.

import { Color, Group, SRGBColorSpace } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { colour } from "../settings/theme";
import type { Pose } from "./poses";
import { shade } from "./scale";

export class Trail {
  readonly all = new Group();
  readonly #before: LineSegments2;
  readonly #after: LineSegments2;

  constructor(poses: Pose[], top: number) {
    const cuts = poses.slice(1).map((to, index) => ({ from: poses[index] as Pose, to }));
    const feed = cuts.filter(({ to }) => !to.rapid);
    this.#before = segments(feed, ({ before }) => shade((before ?? 0) / top), 4);
    this.#after = segments(feed, ({ after }) => shade((after ?? 0) / top), 4);
    const grey = new Color(colour("dim"));
    const rapid = segments(cuts.filter(({ to }) => to.rapid), () => [grey.r, grey.g, grey.b], 1);
    this.all.add(this.#before, this.#after, rapid);
  }

  show(which: "before" | "after"): void {
    this.#before.visible = which === "before";
    this.#after.visible = which === "after";
  }
}

function segments(cuts: { from: Pose; to: Pose }[], paint: (pose: Pose) => [number, number, number], width: number): LineSegments2 {
  // Two ends of three numbers each.
  const places = new Float32Array(6 * cuts.length);
  const colours = new Float32Array(6 * cuts.length);
  const mixed = new Color();
  cuts.forEach(({ from, to }, index) => {
    from.tip.toArray(places, 6 * index);
    to.tip.toArray(places, 6 * index + 3);
    mixed.setRGB(...paint(to), SRGBColorSpace);
    mixed.toArray(colours, 6 * index);
    mixed.toArray(colours, 6 * index + 3);
  });
  const geometry = new LineSegmentsGeometry();
  if (places.length > 0) geometry.setPositions(places).setColors(colours);
  const line = new LineSegments2(geometry, new LineMaterial({ linewidth: width, vertexColors: true }));
  line.visible = places.length > 0;
  return line;
}
