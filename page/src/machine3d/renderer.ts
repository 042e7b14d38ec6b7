// The renderer of the next picture. A browser needs a tenth of a second to make one, and more than a second without a
// graphics card. So one is made while nobody waits.

import { WebGLRenderer } from "three";

let ready: WebGLRenderer | null = null;

const make = () => new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });

/** A renderer for one picture. Throws if the browser has no WebGL. */
export function renderer(): WebGLRenderer {
  const taken = ready ?? make();
  ready = null;
  return taken;
}

/** Makes the renderer of the next picture. */
export function prepare(): void {
  try {
    ready ??= make();
  } catch {
    // The view that needs it says that there is no WebGL.
  }
}
