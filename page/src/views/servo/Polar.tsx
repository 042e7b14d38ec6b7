// The radius error of a circle, magnified. It is drawn here, so that it follows the hand.

import type { Simulation } from "../../api/types";
import { fixed } from "../../parts/format";
import { texts } from "../../texts";

const SIZE = 468;
const MIDDLE = SIZE / 2;
/** Where no error is, and where the largest error is at most. */
const ZERO = 138;
const REACH = 66;

/** 1, 2 or 5 times a power of ten, so that at most two rings are on each side. */
function ringOf(largest: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(largest, 1e-3) / 2));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step * 2 >= largest) ?? 10 * power;
}

export function Polar({ simulation, took }: { simulation: Simulation; took: number }) {
  const t = texts.value.servo;
  const { phi_deg, contour_error_um } = simulation.samples;
  if (!phi_deg) return null;
  const largest = simulation.contour_error.max_abs_um;
  const ring = ringOf(largest);
  const scale = REACH / (2 * ring);
  const at = (phi: number, error: number): [number, number] => {
    const radius = ZERO + error * scale;
    const angle = (phi * Math.PI) / 180;
    return [MIDDLE + radius * Math.cos(angle), MIDDLE - radius * Math.sin(angle)];
  };
  const points = phi_deg.map((phi, index) => at(phi, contour_error_um[index] ?? 0));
  const line = points.map(([x, y], index) => `${index ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
  const oval = simulation.contour_error.oval;
  const shown = ring >= 1 ? String(ring) : ring.toFixed(3).replace(/0+$/, "");
  return (
    <figure class="polar">
      <svg viewBox={`0 0 ${SIZE} ${SIZE}`} role="img" aria-label={`${t.polar}: ${t.max} ${fixed(largest, 2)} µm`}>
        {[-2, -1, 1, 2].map((count) => (
          <circle key={count} cx={MIDDLE} cy={MIDDLE} r={ZERO + count * ring * scale} class="ring" />
        ))}
        {[0, 45, 90, 135].map((angle) => {
          const [x1, y1] = at(angle, 2 * ring);
          const [x2, y2] = at(angle + 180, 2 * ring);
          return <line key={angle} x1={x1} y1={y1} x2={x2} y2={y2} class="ring" />;
        })}
        <circle cx={MIDDLE} cy={MIDDLE} r={ZERO} class="none" />
        {oval && oval.amplitude_um > largest / 20 && (
          <line
            x1={at(oval.major_axis_deg, 2 * ring)[0]}
            y1={at(oval.major_axis_deg, 2 * ring)[1]}
            x2={at(oval.major_axis_deg + 180, 2 * ring)[0]}
            y2={at(oval.major_axis_deg + 180, 2 * ring)[1]}
            class="oval"
          />
        )}
        <path d={line} class="error" />
        {[0, 90, 180, 270].map((angle) => {
          const [x, y] = at(angle, 2 * ring + 16 / scale);
          return (
            <text key={angle} x={x} y={y} class="angle">
              {angle}°
            </text>
          );
        })}
        <text x={MIDDLE} y={MIDDLE - 6} class="middle">
          {fixed(largest, 2)} µm
        </text>
        <text x={MIDDLE} y={MIDDLE + 16} class="under">
          {t.max}
        </text>
      </svg>
      <figcaption class="hint">
        {t.polarHint(shown)} <span class="noprint">{t.took(took)}</span>
      </figcaption>
    </figure>
  );
}
