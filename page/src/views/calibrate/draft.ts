// A calibration run before it is stored: entered by hand, or read from a file.

import { signal } from "@preact/signals";
import type { Calibration, Vector } from "../../api/types";
import { hereAndNow } from "../../parts/format";
import { read } from "../../parts/parts";
import type { Texts } from "../../texts";

export type Method = Calibration["kind"];

/** A run as the interface takes it, as far as the page looks into it. */
export interface RunRequest {
  kind: Method;
  measured_at: string;
  instrument?: string | undefined;
  operator?: string | undefined;
  temperature_c?: number | undefined;
  note?: string | undefined;
  bar_length_mm?: number | undefined;
  setup_error_um?: { e_xs?: number; e_ys?: number } | null;
  tests?: BarTest[];
  axes?: SphereAxis[];
  [member: string]: unknown;
}

interface BarTest {
  rotary_axis: string;
  bar_direction: string;
  ball_mm: Vector;
  readings?: { angle_deg: number; length_change_um: number }[];
  eccentricity_um?: [number, number];
}

interface SphereAxis {
  rotary_axis: string;
  centres: { angle_deg?: number; centre_mm: Vector }[];
}

export const DIRECTIONS = ["radial", "axial", "tangential"] as const;
export const COLUMNS = { "rtcp-ballbar": 2, "rotary-sphere": 4 } as const;

/** One test with the ball bar, or one axis with its probed spheres, as it is typed. */
export interface Part {
  axis: string;
  direction: (typeof DIRECTIONS)[number];
  ball: string[];
  rows: string[][];
}

export interface Typed {
  kind: Method;
  when: string;
  instrument: string;
  operator: string;
  temperature: string;
  note: string;
  bar: string;
  setup: string[];
  parts: Part[];
}

export const partOf = (axis: string, direction: Part["direction"] = "radial"): Part => ({
  axis,
  direction,
  ball: ["", "", ""],
  rows: [],
});

const nothing = (): Typed => ({
  kind: "rtcp-ballbar",
  when: hereAndNow(),
  instrument: "",
  operator: "",
  temperature: "",
  note: "",
  bar: "",
  setup: ["", ""],
  parts: [],
});

/** What is typed stays while other views are looked at. */
export const typed = signal<Typed>(nothing());
export const forget = () => (typed.value = nothing());

/** Where something is wrong, and what. */
export interface Fault {
  part: number;
  row: number;
  words: string;
}

export const isEmpty = (row: string[]) => row.every((cell) => cell.trim() === "");

/** What the service would not even read. Whether the run is good enough is for the service to say. */
export function faultsOf({ kind, when, parts, setup, bar, temperature }: Typed, t: Texts["calibrate"]): Fault[] {
  const faults: Fault[] = [];
  const isBar = kind === "rtcp-ballbar";
  const whole = (words: string) => faults.push({ part: -1, row: -1, words });
  if (Number.isNaN(Date.parse(when))) whole(t.faults.when);
  for (const [name, value] of [
    [t.barLength, bar],
    [t.temperature, temperature],
    ...setup.map((value) => [t.setup, value] as const),
  ] as const)
    if (value.trim() !== "" && read(value) === undefined) whole(t.faults.notNumber(name, value));
  if (setup.some((value) => value.trim()) && !setup.every((value) => value.trim())) whole(t.faults.setup);
  if (parts.length === 0) whole(t.faults.noPart(isBar));
  parts.forEach((part, at) => {
    const name = t.part(at + 1, isBar);
    if (isBar && part.ball.some((value) => read(value) === undefined))
      faults.push({ part: at, row: -1, words: t.faults.ball(name) });
    const rows = part.rows.filter((row) => !isEmpty(row));
    if (rows.length === 0) faults.push({ part: at, row: -1, words: t.faults.noReadings(name) });
    part.rows.forEach((row, index) => {
      if (isEmpty(row)) return;
      row.forEach((cell, column) => {
        if (read(cell) !== undefined) return;
        // The angle of a sphere may be left out.
        if (!isBar && column === 0 && cell.trim() === "") return;
        const words = cell.trim() ? t.faults.notNumber(t.faults.row(name, index + 1), cell.slice(0, 20)) : t.faults.missing(name, index + 1);
        faults.push({ part: at, row: index, words });
      });
    });
  });
  return faults;
}

const given = <T extends object>(from: T) =>
  Object.fromEntries(Object.entries(from).filter(([, value]) => value !== undefined && value !== "")) as Partial<T>;

const point = (texts: string[]) => texts.map((text) => read(text) ?? 0) as Vector;

/** Empty fields are not sent. */
export function requestOf({ kind, when, instrument, operator, temperature, note, bar, setup, parts }: Typed): RunRequest {
  const shared = {
    kind,
    measured_at: new Date(when).toISOString(),
    ...given({ instrument, operator, note, temperature_c: read(temperature) }),
  };
  const numbers = (part: Part) => part.rows.filter((row) => !isEmpty(row)).map((row) => row.map(read));
  if (kind === "rotary-sphere")
    return {
      ...shared,
      axes: parts.map((part) => ({
        rotary_axis: part.axis,
        centres: numbers(part).map(([angle_deg, x = 0, y = 0, z = 0]) => ({
          ...(angle_deg === undefined ? {} : { angle_deg }),
          centre_mm: [x, y, z] as Vector,
        })),
      })),
    };
  const [e_xs, e_ys] = setup.map(read);
  return {
    ...shared,
    ...given({ bar_length_mm: read(bar) }),
    ...(e_xs === undefined || e_ys === undefined ? {} : { setup_error_um: { e_xs, e_ys } }),
    tests: parts.map((part) => ({
      rotary_axis: part.axis,
      bar_direction: part.direction,
      ball_mm: point(part.ball),
      readings: numbers(part).map(([angle_deg = 0, length_change_um = 0]) => ({ angle_deg, length_change_um })),
    })),
  };
}

/** A comma parts cells only where it cannot be a decimal comma: beside a decimal point, or before a blank. */
function separatorOf(line: string, columns: number): RegExp {
  if (/[\t;]/.test(line)) return /[\t;]/;
  if (/\.|,\s/.test(line) && line.split(",").length === columns) return /,/;
  return /\s+/;
}

/** The cells of a text from a spreadsheet or a file. Lines without a number, such as headings, are left out. */
export function cellsOf(text: string, columns: number): string[][] {
  return text
    .split(/\r?\n/)
    .map((line) => {
      return line.trim() === "" ? [] : line.trim().split(separatorOf(line, columns)).map((cell) => cell.trim());
    })
    .filter((cells) => cells.some((cell) => read(cell) !== undefined));
}
