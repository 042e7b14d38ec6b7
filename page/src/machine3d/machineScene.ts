// A machine whose axes are moved by hand.

import { Box3, Sphere, Vector3 } from "three";
import type { Kinematics, Words } from "../api/types";
import { Body } from "./body";
import { Stage } from "./stage";

export const SIZE = 140;

export class MachineScene {
  readonly stage: Stage;
  readonly body: Body;

  constructor(place: HTMLElement, kinematics: Kinematics) {
    this.stage = new Stage(place);
    this.body = new Body(kinematics, SIZE, -SIZE * 0.1, { radius: SIZE * 0.045, corner: SIZE * 0.045 });
    this.stage.scene.add(this.body.all);
    this.body.pose({}, new Vector3(0, 0, SIZE * 0.4));
    this.body.all.updateMatrixWorld(true);
    const around = new Box3().setFromObject(this.body.all).getBoundingSphere(new Sphere());
    around.radius *= 0.94;
    this.stage.look(around);
  }

  pose(words: Words, magnified: number): void {
    this.body.pose(words, new Vector3(words.X ?? 0, words.Y ?? 0, words.Z ?? 0), magnified);
    this.stage.draw();
  }

  end(): void {
    this.stage.end();
  }
}
