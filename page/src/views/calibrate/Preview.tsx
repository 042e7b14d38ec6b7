// A run before it is stored. A stored run cannot be taken back, so it is looked at first.

import { json } from "../../api/client";
import { machinePath } from "../../api/machines";
import type { Calibration } from "../../api/types";
import { useDoing } from "../../api/use";
import { Facts } from "../../parts/Facts";
import { fixed, moment } from "../../parts/format";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { Table } from "../../parts/Table";
import { go } from "../../router";
import { texts } from "../../texts";
import type { RunRequest } from "./draft";

interface Row {
  axis: string;
  way: string;
  values: { angle: number | null; value: number | null }[];
  count: number;
}

/** The run may come from any file: nothing of it is sure. */
function rowsOf(run: RunRequest): Row[] {
  const number = (value: unknown) => (typeof value === "number" ? value : null);
  const list = <T,>(value: T[] | undefined): T[] => (Array.isArray(value) ? value : []);
  return [
    ...list(run.tests).map((test) => {
      const readings = list(test?.readings);
      return {
        axis: String(test?.rotary_axis ?? "–"),
        way: String(test?.bar_direction ?? "–"),
        values: readings.map((one) => ({ angle: number(one?.angle_deg), value: number(one?.length_change_um) })),
        count: readings.length || (test?.eccentricity_um ? 2 : 0),
      };
    }),
    ...list(run.axes).map((axis) => {
      const centres = list(axis?.centres);
      return {
        axis: String(axis?.rotary_axis ?? "–"),
        way: "–",
        values: centres.map((one) => ({ angle: number(one?.angle_deg), value: null })),
        count: centres.length,
      };
    }),
  ];
}

const range = (values: (number | null)[]): [number, number] | null => {
  const known = values.filter((value): value is number => value !== null);
  return known.length > 0 ? [Math.min(...known), Math.max(...known)] : null;
};

interface Props {
  id: string;
  run: RunRequest;
  stored: () => void;
  cancel: () => void;
}

export function Preview({ id, run, stored, cancel }: Props) {
  const t = texts.value.calibrate;
  const doing = useDoing();
  const rows = rowsOf(run);
  const said = (value: unknown) => (typeof value === "string" && value ? value : "–");
  const time = Date.parse(String(run.measured_at));
  const store = () =>
    doing.run(async () => {
      const made = await json<Calibration>(`${machinePath(id)}/calibrations`, { method: "POST", json: run });
      stored();
      go("calibrate", id, made.id);
    });
  return (
    <Card title={t.preview} hint={t.previewHint} class="preview noprint">
      <Facts
        facts={[
          { name: t.kind, value: t.kinds[run.kind] ?? said(run.kind) },
          { name: t.measured, value: Number.isNaN(time) ? said(run.measured_at) : moment(new Date(time).toISOString()) },
          { name: t.instrument, value: said(run.instrument) },
          { name: t.operator, value: said(run.operator) },
          { name: t.temperature, value: <Num value={typeof run.temperature_c === "number" ? run.temperature_c : null} unit="°C" /> },
        ]}
      />
      <Table
        label={t.preview}
        class="list numeric"
        rows={rows}
        keyOf={(_row, at) => at}
        data="test"
        columns={[
          { head: texts.value.machines.axis, cell: (row) => row.axis, names: true },
          { head: t.direction, cell: (row) => t.directions[row.way as "radial"] ?? row.way },
          { head: t.readings, cell: (row) => <Num value={row.count} text={String} />, class: "right" },
          { head: t.angles, cell: (row) => spread(range(row.values.map(({ angle }) => angle)), 0, "°"), class: "num right" },
          { head: t.changes, cell: (row) => spread(range(row.values.map(({ value }) => value)), 1, " µm"), class: "num right" },
          { head: <span class="hidden">{t.changes}</span>, cell: (row) => <Course row={row} />, class: "bar" },
        ]}
      />
      {doing.problem && <ProblemBox problem={doing.problem} />}
      <div class="row end">
        <button type="button" onClick={cancel}>
          {texts.value.common.cancel}
        </button>
        <button type="button" class="primary" disabled={doing.busy} onClick={store}>
          {t.store}
        </button>
      </div>
    </Card>
  );
}

const spread = (of: [number, number] | null, digits: number, unit: string) =>
  of ? `${fixed(of[0], digits)} … ${fixed(of[1], digits)}${unit}` : "–";

const WIDTH = 240;
const HEIGHT = 56;
const ROOM = 4;

/** The readings in their order over the angle: there and back lie on each other if the machine returns to its place. */
function Course({ row }: { row: Row }) {
  const points = row.values.filter((one): one is { angle: number; value: number } => one.angle !== null && one.value !== null);
  const angles = range(points.map(({ angle }) => angle));
  const values = range(points.map(({ value }) => value));
  if (!angles || !values || points.length < 2) return null;
  const place = (value: number, [low, high]: [number, number], size: number) =>
    ROOM + ((value - low) / Math.max(high - low, 1e-9)) * (size - 2 * ROOM);
  const line = points.map(({ angle, value }) => `${place(angle, angles, WIDTH).toFixed(1)},${(HEIGHT - place(value, values, HEIGHT)).toFixed(1)}`);
  return (
    <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} class="course" aria-hidden="true">
      <polyline points={line.join(" ")} />
    </svg>
  );
}
