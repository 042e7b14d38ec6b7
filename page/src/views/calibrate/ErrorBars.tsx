// The errors of a run: as the profile has them, beside the values in the machine; and against the machine's frame, beside their limits.

import type { Calibration, Estimate, Machine } from "../../api/types";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { Table } from "../../parts/Table";
import { texts } from "../../texts";

const WIDTH = 360;
const HEIGHT = 26;

interface Row {
  name: string;
  value: number;
  /** Two standard uncertainties of the fit. */
  twice: number | null;
  now: number | null;
  limit: number | null;
  unit: "µm" | "µrad";
}

const rowOf = (name: string, member: string, estimate: Estimate): Row => ({
  name: name + member.replace(/_u(m|rad)$/, ""),
  value: estimate.value,
  twice: typeof estimate.standard_uncertainty === "number" ? 2 * estimate.standard_uncertainty : null,
  now: null,
  limit: null,
  unit: member.endsWith("_um") ? "µm" : "µrad",
});

export function ErrorBars({ run, machine }: { run: Calibration; machine: Machine }) {
  const t = texts.value.calibrate;
  const ofAxes = Object.entries(run.errors).flatMap(([name, errors]) => {
    const axis = machine.kinematics.rotary_axes.find((one) => one.name === name);
    const now = (axis?.location_error ?? {}) as Record<string, number>;
    return Object.entries(errors).map(([error, estimate]) => ({ ...rowOf(`${name}.`, error, estimate), now: now[error] ?? 0 }));
  });
  // The limits of the profile have the names of these.
  const inFrame = Object.entries(run.iso_230).map(([error, estimate]) => ({
    ...rowOf("", error, estimate),
    limit: machine.calibration_limits?.[error] ?? null,
  }));
  return (
    <>
      <Bars title={t.errors} hint={t.errorsHint} beside={t.inMachine} rows={ofAxes} shown={(row) => row.now} />
      <Bars title={t.frameErrors} hint={t.frameErrorsHint} beside={t.limit} rows={inFrame} shown={(row) => row.limit} />
    </>
  );
}

interface BarsProps {
  title: string;
  hint: string;
  /** What stands beside the value. */
  beside: string;
  rows: Row[];
  shown: (row: Row) => number | null;
}

function Bars({ title, hint, beside, rows, shown }: BarsProps) {
  const t = texts.value.calibrate;
  return (
    <Card title={title} hint={hint}>
      <Table
        label={title}
        class="list numeric bars"
        rows={rows}
        keyOf={(row) => row.name}
        data="error"
        columns={[
          { head: t.error, cell: (row) => row.name, names: true },
          { head: t.value, cell: (row) => <Num value={row.value} unit={row.unit} />, class: "right" },
          { head: t.uncertainty, cell: (row) => <Num value={row.twice} unit={row.unit} />, class: "right" },
          { head: beside, cell: (row) => <Num value={shown(row)} unit={row.unit} />, class: "right" },
          {
            head: <span class="hidden">{title}</span>,
            cell: (row) => <Bar row={row} reach={reachOf(rows, row.unit)} />,
            class: "bar",
          },
        ]}
      />
    </Card>
  );
}

const reachOf = (rows: Row[], unit: string) =>
  1.08 *
  Math.max(
    1e-9,
    ...rows
      .filter((row) => row.unit === unit)
      .flatMap((row) => [Math.abs(row.value) + (row.twice ?? 0), Math.abs(row.now ?? 0), row.limit ?? 0]),
  );

function Bar({ row, reach }: { row: Row; reach: number }) {
  const x = (value: number) => WIDTH / 2 + (value / reach) * (WIDTH / 2 - 6);
  const y = HEIGHT / 2;
  const half = Math.max(row.twice ?? 0, reach / 300);
  return (
    <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} class="errorbar" aria-hidden="true">
      <line x1={x(-reach)} x2={x(reach)} y1={y} y2={y} class="rail" />
      <line x1={x(0)} x2={x(0)} y1={3} y2={HEIGHT - 3} class="zero" />
      {row.limit !== null &&
        [-row.limit, row.limit].map((at) => <line key={at} x1={x(at)} x2={x(at)} y1={4} y2={HEIGHT - 4} class="limit" />)}
      <line x1={x(0)} x2={x(row.value)} y1={y} y2={y} class="stem" />
      <line x1={x(row.value - half)} x2={x(row.value + half)} y1={y} y2={y} class="u" />
      {row.now !== null && <circle cx={x(row.now)} cy={y} r={5.5} class="now" />}
      <circle cx={x(row.value)} cy={y} r={3.2} class="value" />
    </svg>
  );
}
