import type uPlot from "uplot";
import { useCallback, useMemo } from "preact/hooks";
import { Chart, type Line } from "../../parts/Chart";
import { Card } from "../../parts/parts";
import { colour } from "../../settings/theme";
import { texts } from "../../texts";
import type { Reading } from "./reading";

interface Props {
  reading: Reading;
  line: number | null;
  toLine: (line: number) => void;
}

export function DeviationChart({ reading, line, toLine }: Props) {
  const t = texts.value;
  const { series, tolerance } = reading;
  const values = useMemo(() => (series ? [series.before, series.after] : []), [series]);
  const over = useCallback(
    (u: uPlot) => {
      if (tolerance === null) return;
      const y = u.valToPos(tolerance, "y", true);
      if (y < u.bbox.top) return;
      const context = u.ctx;
      context.save();
      context.strokeStyle = colour("dim");
      context.lineWidth = devicePixelRatio;
      context.setLineDash([6 * devicePixelRatio, 5 * devicePixelRatio]);
      context.beginPath();
      context.moveTo(u.bbox.left, y);
      context.lineTo(u.bbox.left + u.bbox.width, y);
      context.stroke();
      const words = `${t.compensate.tolerance} ${tolerance} µm`;
      context.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
      context.textBaseline = "middle";
      context.textAlign = "left";
      // On the line, with room of its own, so that curves behind it do not cross the words.
      const half = 8 * devicePixelRatio;
      const left = u.bbox.left + half;
      context.fillStyle = colour("card");
      context.fillRect(left - half / 2, y - half, context.measureText(words).width + half, 2 * half);
      context.fillStyle = colour("dim");
      context.fillText(words, left, y);
      context.restore();
    },
    [tolerance, t],
  );
  if (!series) return null;
  const lines: Line[] = [
    { label: t.common.before, colour: "before", dash: [6, 3] },
    { label: t.common.after, colour: "after", fill: true },
  ];
  const at = line === null ? -1 : series.line.findLastIndex((one) => one <= line);
  return (
    <Card title={t.result.chart}>
      <Chart
        label={t.result.chart}
        x={series.x}
        xLabel={series.byPath ? t.result.chartX : t.result.chartLine}
        yLabel="µm"
        lines={lines}
        values={values}
        height={280}
        mark={at >= 0 ? (series.x[at] ?? null) : null}
        over={over}
        onPick={(index) => {
          const picked = series.line[index];
          if (picked !== undefined) toLine(picked);
        }}
      />
    </Card>
  );
}
