// The colours of a deviation: dark and cool is small, bright and warm is large. They can be told apart with any colour
// vision, and grow lighter in one direction, so a print without colour can be read too.

const STOPS: [number, number, number][] = [
  [0x1f, 0x4e, 0x8c],
  [0x1b, 0x8a, 0x9a],
  [0x4f, 0xb5, 0x78],
  [0xd9, 0xc2, 0x4a],
  [0xf0, 0x8a, 0x2c],
  [0xd8, 0x3a, 0x2e],
];

/** The colour at a share of the scale, as shares of red, green and blue. */
export function shade(share: number): [number, number, number] {
  const at = Math.min(1, Math.max(0, share)) * (STOPS.length - 1);
  const below = STOPS[Math.floor(at)] ?? STOPS[0] ?? [0, 0, 0];
  const above = STOPS[Math.ceil(at)] ?? below;
  const part = at - Math.floor(at);
  const mix = (index: 0 | 1 | 2) => (below[index] + part * (above[index] - below[index])) / 255;
  return [mix(0), mix(1), mix(2)];
}

export const css = (share: number) => `rgb(${shade(share).map((part) => Math.round(part * 255)).join(" ")})`;
