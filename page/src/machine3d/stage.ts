// The picture: camera, light and the turn by hand. It is drawn only when something changes.

import {
  AmbientLight,
  Color,
  DirectionalLight,
  HemisphereLight,
  PerspectiveCamera,
  Scene,
  Sphere,
  Vector3,
  type WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { colour } from "../settings/theme";
import { renderer } from "./renderer";

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(32, 1, 1, 10_000);
  readonly renderer: WebGLRenderer;
  readonly controls: OrbitControls;
  /** Draws the picture, if it takes more than one pass. */
  passes: (() => void) | null = null;
  width = 1;
  height = 1;
  #asked = false;
  readonly #watch: ResizeObserver;

  /** Throws if the browser has no WebGL. */
  constructor(readonly place: HTMLElement) {
    this.renderer = renderer();
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    place.append(this.renderer.domElement);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => this.draw());
    this.scene.background = new Color(colour("stage"));
    this.scene.add(new HemisphereLight(0xffffff, 0x8a9690, 1.4), new AmbientLight(0xffffff, 0.5));
    const sun = new DirectionalLight(0xffffff, 1.9);
    sun.position.set(-0.6, -1, 1.4);
    this.scene.add(sun);
    this.#watch = new ResizeObserver(() => this.#resize());
    this.#watch.observe(place);
    this.#resize();
  }

  #resize(): void {
    this.width = Math.max(1, this.place.clientWidth);
    this.height = Math.max(1, this.place.clientHeight);
    this.renderer.setSize(this.width, this.height);
    this.camera.aspect = this.width / this.height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw(): void {
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      if (this.passes) this.passes();
      else this.renderer.render(this.scene, this.camera);
    });
  }

  /** Looks at this sphere from the front, the right and above. */
  look(at: Sphere, from = new Vector3(0.62, -1, 0.52)): void {
    const half = Math.min(this.camera.fov, this.camera.fov * this.camera.aspect) * (Math.PI / 360);
    const distance = at.radius / Math.sin(half);
    this.camera.position.copy(at.center).addScaledVector(from.clone().normalize(), distance);
    this.camera.near = distance / 100;
    this.camera.far = distance * 10;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(at.center);
    this.controls.update();
    this.draw();
  }

  end(): void {
    this.#watch.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    // A browser gives a page only a few pictures at a time.
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }
}
