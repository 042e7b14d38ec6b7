// The shapes a machine is drawn with: matt bodies with their edges, as in a technical drawing.

import {
  BoxGeometry,
  type BufferGeometry,
  CanvasTexture,
  CylinderGeometry,
  EdgesGeometry,
  Group,
  Line,
  BufferGeometry as Geometry,
  LineBasicMaterial,
  LineDashedMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  SRGBColorSpace,
  Sprite,
  SpriteMaterial,
  Vector3,
} from "three";
import { colour } from "../settings/theme";
import { fromZ } from "./chain";

export interface Paint {
  body: string;
  opacity?: number;
}

/** A body with its edges. */
export function solid(geometry: BufferGeometry, { body, opacity = 1 }: Paint): Group {
  const material = new MeshLambertMaterial({
    color: colour(body),
    transparent: opacity < 1,
    opacity,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
  const edges = new LineSegments(
    new EdgesGeometry(geometry, 30),
    new LineBasicMaterial({ color: colour("stageedge"), transparent: true, opacity: 0.55 }),
  );
  return new Group().add(new Mesh(geometry, material), edges);
}

/** A cylinder along a direction, with the middle at a place. */
export function cylinder(at: Vector3, along: Vector3, radius: number, length: number, paint: Paint, tip = radius): Group {
  const geometry = new CylinderGeometry(radius, tip, length, 48).rotateX(Math.PI / 2);
  const body = solid(geometry, paint);
  body.position.copy(at);
  body.quaternion.copy(fromZ(along));
  return body;
}

export function box(at: Vector3, size: Vector3, paint: Paint): Group {
  const body = solid(new BoxGeometry(size.x, size.y, size.z), paint);
  body.position.copy(at);
  return body;
}

/** The line of an axis, with its letter at the lower end, where no spindle is. */
export function axisLine(letter: string, point: Vector3, towards: Vector3, reach: number, below = false): Group {
  const direction = towards.clone().multiplyScalar(below && towards.z > 0.3 ? -1 : 1);
  const ends = [-reach, reach].map((at) => point.clone().addScaledVector(direction, at));
  const line = new Line(
    new Geometry().setFromPoints(ends),
    new LineDashedMaterial({ color: colour("accent"), dashSize: reach / 12, gapSize: reach / 28 }),
  );
  line.computeLineDistances();
  const name = label(letter);
  name.position.copy(point).addScaledVector(direction, reach * 1.09);
  return new Group().add(line, name);
}

/** A share of the height of the picture. */
const LABEL = 0.035;

function label(text: string): Sprite {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 96;
  const context = canvas.getContext("2d");
  if (context) {
    context.fillStyle = colour("accent");
    context.beginPath();
    context.arc(48, 48, 42, 0, 2 * Math.PI);
    context.fill();
    context.fillStyle = colour("onaccent");
    context.font = "600 52px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(text, 48, 51);
  }
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
  sprite.scale.setScalar(LABEL);
  sprite.renderOrder = 2;
  return sprite;
}
