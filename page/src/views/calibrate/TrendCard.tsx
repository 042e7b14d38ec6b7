import type uPlot from "uplot";
import { useCallback, useMemo, useState } from "preact/hooks";
import { json, query } from "../../api/client";
import { machinePath } from "../../api/machines";
import type { Calibration, Machine, Trend } from "../../api/types";
import { useAsked } from "../../api/use";
import { Chart } from "../../parts/Chart";
import { Card, Field, Got } from "../../parts/parts";
import { colour } from "../../settings/theme";
import { texts } from "../../texts";

/** One error over all runs, with its expanded uncertainty. A ring marks the run that is applied. */
export function TrendCard({ machine, run, applied }: { machine: Machine; run: Calibration; applied: string | null }) {
  const t = texts.value.calibrate;
  const names = Object.entries(run.errors).flatMap(([axis, errors]) => Object.keys(errors).map((error) => `${axis}.${error}`));
  const [chosen, choose] = useState(names.includes("A.e_y_um") ? "A.e_y_um" : (names[0] ?? ""));
  const [axis = "", member = ""] = chosen.split(".");
  const error = member.replace(/_u(m|rad)$/, "");
  const asked = useAsked(
    (signal) => json<Trend>(`${machinePath(machine.machine_id)}/calibrations/trend${query({ axis, error })}`, { signal }),
    [machine.machine_id, axis, error],
  );
  return (
    <Card
      title={t.trend}
      hint={t.trendHint}
      tools={
        <Field label={t.trendOf} class="inline">
          <select value={chosen} onChange={(event) => choose(event.currentTarget.value)}>
            {names.map((name) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </Field>
      }
    >
      <Got asked={asked}>{(trend) => <Plot trend={trend} machine={machine} member={member} applied={applied} />}</Got>
    </Card>
  );
}

interface PlotProps {
  trend: Trend;
  machine: Machine;
  member: string;
  applied: string | null;
}

function Plot({ trend, machine, member, applied }: PlotProps) {
  const t = texts.value.calibrate;
  const unit = trend.unit === "um" ? "µm" : "µrad";
  const axis = machine.kinematics.rotary_axes.find((one) => one.name === trend.axis);
  const now = (axis?.location_error as Record<string, number> | undefined)?.[member] ?? null;
  const x = useMemo(() => trend.points.map((point) => Date.parse(point.measured_at) / 1000), [trend]);
  const values = useMemo(
    () => [trend.points.map((point) => point.value), trend.points.map(() => now)],
    [trend, now],
  );
  const over = useCallback(
    (u: uPlot) => {
      const context = u.ctx;
      context.save();
      context.strokeStyle = colour("accent");
      context.lineWidth = 1.5 * devicePixelRatio;
      for (const point of trend.points) {
        if (typeof point.standard_uncertainty !== "number") continue;
        const at = u.valToPos(Date.parse(point.measured_at) / 1000, "x", true);
        const [low, high] = [-2, 2].map((k) => u.valToPos(point.value + k * (point.standard_uncertainty as number), "y", true)) as [number, number];
        const cap = 4 * devicePixelRatio;
        context.beginPath();
        context.moveTo(at, low);
        context.lineTo(at, high);
        for (const y of [low, high]) {
          context.moveTo(at - cap, y);
          context.lineTo(at + cap, y);
        }
        context.stroke();
      }
      for (const point of trend.points) {
        const at = u.valToPos(Date.parse(point.measured_at) / 1000, "x", true);
        const y = u.valToPos(point.value, "y", true);
        context.fillStyle = colour("accent");
        context.beginPath();
        context.arc(at, y, 3.5 * devicePixelRatio, 0, 2 * Math.PI);
        context.fill();
        if (point.calibration_id !== applied) continue;
        context.strokeStyle = colour("before");
        context.beginPath();
        context.arc(at, y, 7.5 * devicePixelRatio, 0, 2 * Math.PI);
        context.stroke();
      }
      context.restore();
    },
    [trend, applied],
  );
  return (
    <Chart
      label={`${t.trend} ${trend.axis} ${trend.error}`}
      x={x}
      time
      xLabel={t.measured}
      yLabel={unit}
      lines={[
        { label: `${trend.axis}.${trend.error}`, colour: "accent" },
        { label: t.inMachine, colour: "dim", dash: [6, 5], width: 1.25 },
      ]}
      values={values}
      over={over}
      height={260}
    />
  );
}
