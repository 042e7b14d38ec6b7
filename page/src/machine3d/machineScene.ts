// A machine whose axes are moved by hand.

import { Box3, ConeGeometry, DoubleSide, Group, Line, BufferGeometry, LineBasicMaterial, Mesh, MeshBasicMaterial, Sphere, Vector3 } from "three";
import type { Kinematics, Words } from "../api/types";
import { colour } from "../settings/theme";
import { Body } from "./body";
import { fromZ } from "./chain";
import { fromPole_deg, poleDirection, poleOf, ZONE_DEG } from "./singular";
import { Stage } from "./stage";

export const SIZE = 140;

export class MachineScene {
  readonly stage: Stage;
  readonly body: Body;
  readonly #cone: Cone | null;

  constructor(place: HTMLElement, kinematics: Kinematics) {
    this.stage = new Stage(place);
    this.body = new Body(kinematics, SIZE, -SIZE * 0.1, { radius: SIZE * 0.045, corner: SIZE * 0.045 });
    this.stage.scene.add(this.body.all);
    this.#cone = poleOf(kinematics) ? new Cone() : null;
    this.body.pose({}, new Vector3(0, 0, SIZE * 0.4));
    this.body.all.updateMatrixWorld(true);
    const around = new Box3().setFromObject(this.body.all).getBoundingSphere(new Sphere());
    around.radius *= 0.92;
    if (this.#cone) this.stage.scene.add(this.#cone.all);
    this.stage.look(around);
  }

  pose(words: Words, magnified: number): void {
    const tip = new Vector3(words.X ?? 0, words.Y ?? 0, words.Z ?? 0);
    const { kinematics } = this.body;
    this.body.pose(words, tip, magnified);
    this.#cone?.pose(tip, poleDirection(kinematics, words), fromPole_deg(kinematics, words) < ZONE_DEG);
    this.stage.draw();
  }

  end(): void {
    this.stage.end();
  }
}

/** The directions at the tip in which a tool is singular. It is seen through the machine. */
class Cone {
  readonly all = new Group();
  readonly #paint = new MeshBasicMaterial({ transparent: true, opacity: 0.35, side: DoubleSide, depthTest: false, depthWrite: false });
  readonly #line = new LineBasicMaterial({ depthTest: false });

  constructor() {
    const height = SIZE * 1.9;
    // The apex at the tip, open along Z.
    const geometry = new ConeGeometry(height * Math.tan((ZONE_DEG * Math.PI) / 180), height, 48, 1, true)
      .rotateX(-Math.PI / 2)
      .translate(0, 0, height / 2);
    const middle = new BufferGeometry().setFromPoints([new Vector3(), new Vector3(0, 0, height * 1.06)]);
    this.all.add(new Mesh(geometry, this.#paint), new Line(middle, this.#line));
    this.all.children.forEach((part) => (part.renderOrder = 1));
  }

  pose(tip: Vector3, direction: Vector3, isInside: boolean): void {
    this.all.position.copy(tip);
    this.all.quaternion.copy(fromZ(direction));
    const shown = colour(isInside ? "bad" : "before");
    this.#paint.color.set(shown);
    this.#line.color.set(shown);
  }
}
