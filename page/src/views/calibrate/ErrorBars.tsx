// The errors of a run, each with its expanded uncertainty, its limit and the value that is in the machine.

import type { Calibration, Machine } from "../../api/types";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { texts } from "../../texts";

const WIDTH = 360;
const HEIGHT = 26;

interface Row {
  name: string;
  value: number;
  u: number | null;
  now: number;
  limit: number | null;
  unit: "µm" | "µrad";
}

export function ErrorBars({ run, machine }: { run: Calibration; machine: Machine }) {
  const t = texts.value.calibrate;
  const rows: Row[] = Object.entries(run.errors).flatMap(([name, errors]) => {
    const axis = machine.kinematics.rotary_axes.find((one) => one.name === name);
    const now = (axis?.location_error ?? {}) as Record<string, number>;
    return Object.entries(errors).map(([error, estimate]) => ({
      name: `${name}.${error.replace(/_u(m|rad)$/, "")}`,
      value: estimate.value,
      u: typeof estimate.standard_uncertainty === "number" ? 2 * estimate.standard_uncertainty : null,
      now: now[error] ?? 0,
      limit: machine.calibration_limits?.[`${name}.${error}`] ?? machine.calibration_limits?.[error] ?? null,
      unit: error.endsWith("_um") ? "µm" : "µrad",
    }));
  });
  return (
    <Card title={t.errors} hint={t.errorsHint}>
      <div class="scroll" tabIndex={0} role="region" aria-label={t.errors}>
        <table class="list numeric bars">
          <thead>
            <tr>
              <th scope="col">{t.error}</th>
              <th scope="col" class="right">
                {t.value}
              </th>
              <th scope="col" class="right">
                {t.uncertainty}
              </th>
              <th scope="col" class="right">
                {t.inMachine}
              </th>
              <th scope="col">
                <span class="hidden">{t.errors}</span>
              </th>
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <tr key={row.name} data-error={row.name}>
                <th scope="row">{row.name}</th>
                <td class="right">
                  <Num value={row.value} unit={row.unit} />
                </td>
                <td class="right">
                  <Num value={row.u} unit={row.unit} />
                </td>
                <td class="right">
                  <Num value={row.now} unit={row.unit} />
                </td>
                <td class="bar">
                  <Bar row={row} reach={reachOf(rows, row.unit)} />
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </Card>
  );
}

const reachOf = (rows: Row[], unit: string) =>
  1.08 *
  Math.max(
    1e-9,
    ...rows.filter((row) => row.unit === unit).flatMap((row) => [Math.abs(row.value) + (row.u ?? 0), Math.abs(row.now), row.limit ?? 0]),
  );

function Bar({ row, reach }: { row: Row; reach: number }) {
  const x = (value: number) => WIDTH / 2 + (value / reach) * (WIDTH / 2 - 6);
  const y = HEIGHT / 2;
  const u = Math.max(row.u ?? 0, reach / 300);
  return (
    <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} class="errorbar" aria-hidden="true">
      <line x1={x(-reach)} x2={x(reach)} y1={y} y2={y} class="rail" />
      <line x1={x(0)} x2={x(0)} y1={3} y2={HEIGHT - 3} class="zero" />
      {row.limit !== null &&
        [-row.limit, row.limit].map((at) => <line key={at} x1={x(at)} x2={x(at)} y1={4} y2={HEIGHT - 4} class="limit" />)}
      <line x1={x(0)} x2={x(row.value)} y1={y} y2={y} class="stem" />
      <line x1={x(row.value - u)} x2={x(row.value + u)} y1={y} y2={y} class="u" />
      <circle cx={x(row.now)} cy={y} r={5.5} class="now" />
      <circle cx={x(row.value)} cy={y} r={3.2} class="value" />
    </svg>
  );
}
