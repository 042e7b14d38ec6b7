// The residuals on a part: a point for every sample, coloured by what is left or cut too deep.

import { Box3, BufferAttribute, BufferGeometry, Color, Points, PointsMaterial, Sphere, SRGBColorSpace, Vector3 } from "three";
import { Stage } from "./stage";

export interface Sample {
  at: [number, number, number];
  normal: [number, number, number];
  residual: number;
}

export class CloudScene {
  readonly stage: Stage;

  constructor(place: HTMLElement, samples: Sample[], paint: (residual: number) => [number, number, number]) {
    this.stage = new Stage(place);
    const places = new Float32Array(samples.length * 3);
    const colours = new Float32Array(samples.length * 3);
    const mixed = new Color();
    samples.forEach(({ at, residual }, index) => {
      places.set(at, 3 * index);
      mixed.setRGB(...paint(residual), SRGBColorSpace);
      colours.set([mixed.r, mixed.g, mixed.b], 3 * index);
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setAttribute("color", new BufferAttribute(colours, 3));
    const around = new Box3().setFromBufferAttribute(geometry.getAttribute("position") as BufferAttribute).getBoundingSphere(new Sphere());
    // Points touch each other: each has its share of the area that the samples cover.
    const size = (around.radius * 4.2) / Math.sqrt(Math.max(1, samples.length));
    this.stage.scene.add(new Points(geometry, new PointsMaterial({ size, vertexColors: true })));
    const up = samples.reduce((sum, { normal }) => sum.add(new Vector3(...normal)), new Vector3()).normalize();
    this.stage.look(around, up.clone().multiplyScalar(0.9).add(new Vector3(0.5, -0.8, 0.25)));
  }

  end(): void {
    this.stage.end();
  }
}
