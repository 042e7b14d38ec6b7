// A line chart that follows the theme and the width of its place.

import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { colour, isDark } from "../settings/theme";
import { day } from "./format";

export interface Line {
  label: string;
  /** A colour of the style sheet. */
  colour: string;
  dash?: number[];
  width?: number;
  points?: boolean;
  fill?: boolean;
}

interface Props {
  label: string;
  x: number[];
  xLabel: string;
  yLabel: string;
  lines: Line[];
  values: (number | null)[][];
  height?: number;
  time?: boolean;
  /** Both axes begin at zero. */
  fromZero?: boolean;
  /** A mark at this place of `x`. */
  mark?: number | null;
  onPick?: (index: number) => void;
  /** Draws over the chart. */
  over?: (chart: uPlot) => void;
}

export function Chart(props: Props) {
  const place = useRef<HTMLDivElement>(null);
  const chart = useRef<uPlot | null>(null);
  const latest = useRef(props);
  latest.current = props;
  const dark = isDark.value;

  useEffect(() => {
    const element = place.current;
    if (!element) return;
    const made = new uPlot(options(latest, element.clientWidth), [props.x, ...props.values] as uPlot.AlignedData, element);
    chart.current = made;
    const watch = new ResizeObserver(() =>
      made.setSize({ width: element.clientWidth, height: latest.current.height ?? 260 }),
    );
    watch.observe(element);
    return () => {
      watch.disconnect();
      made.destroy();
      chart.current = null;
    };
  }, [dark, props.lines.length, props.lines.map((line) => line.label).join(), props.xLabel, props.yLabel]);
  useEffect(() => chart.current?.setData([props.x, ...props.values] as uPlot.AlignedData), [props.x, props.values]);
  // Without new paths: before its first drawing a chart has no scale to make them from.
  useEffect(() => chart.current?.redraw(false), [props.mark, props.over]);
  return <div class="chart" ref={place} role="img" aria-label={props.label} />;
}

/** Room before the first and after the last point. */
function roomy(_u: uPlot, low: number, high: number): uPlot.Range.MinMax {
  const room = Math.max((high - low) * 0.03, 1);
  return [low - room, high + room];
}

const fromZero = (_u: uPlot, _low: number, high: number): uPlot.Range.MinMax => [0, high * 1.06];

const days = (_u: uPlot, at: number[]) => at.map((time) => day(new Date(time * 1000).toISOString()));

function options(latest: { current: Props }, width: number): uPlot.Options {
  const props = latest.current;
  const axis = {
    stroke: colour("dim"),
    font: "12px system-ui, sans-serif",
    labelFont: "12px system-ui, sans-serif",
    grid: { stroke: colour("edge"), width: 1 },
    ticks: { stroke: colour("edge"), width: 1, size: 4 },
  };
  return {
    width,
    height: props.height ?? 260,
    padding: [12, 16, 0, 0],
    scales: {
      x: { time: props.time ?? false, ...(props.time ? { range: roomy } : props.fromZero ? { range: fromZero } : {}) },
      ...(props.fromZero ? { y: { range: fromZero } } : {}),
    },
    cursor: { points: { size: 7 }, drag: { x: true, y: false } },
    legend: { live: true },
    axes: [
      { ...axis, label: props.xLabel, labelSize: 20, size: 34, ...(props.time ? { values: days, space: 90 } : {}) },
      { ...axis, label: props.yLabel, labelSize: 20, size: 56 },
    ],
    series: [
      {
        label: props.xLabel,
        value: (_u, value) => (value === null ? "–" : props.time ? day(new Date(value * 1000).toISOString()) : value.toFixed(1)),
      },
      ...props.lines.map((line) => ({
        label: line.label,
        stroke: colour(line.colour),
        width: line.width ?? 1.75,
        ...(line.dash ? { dash: line.dash } : {}),
        ...(line.fill ? { fill: `${colour(line.colour)}22` } : {}),
        points: { show: line.points ?? false, size: 7, fill: colour(line.colour) },
        spanGaps: true,
        value: (_u: uPlot, value: number | null) => (value === null ? "–" : value.toFixed(2)),
      })),
    ],
    hooks: {
      draw: [
        (u) => {
          const mark = latest.current.mark;
          if (mark !== null && mark !== undefined) {
            const x = u.valToPos(mark, "x", true);
            const context = u.ctx;
            context.save();
            context.strokeStyle = colour("accent");
            context.lineWidth = devicePixelRatio;
            context.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
            context.beginPath();
            context.moveTo(x, u.bbox.top);
            context.lineTo(x, u.bbox.top + u.bbox.height);
            context.stroke();
            context.restore();
          }
          latest.current.over?.(u);
        },
      ],
      ready: [
        (u) => {
          u.over.addEventListener("click", () => {
            const index = u.cursor.idx;
            if (typeof index === "number") latest.current.onPick?.(index);
          });
        },
      ],
    },
  };
}
