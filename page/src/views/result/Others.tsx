// The numbers of operations that correct nothing: servo simulation, virtual cutting, posting.

import type { Job, Report } from "../../api/types";
import { whole } from "../../parts/format";
import { Facts } from "../../parts/Facts";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { texts } from "../../texts";

export function Others({ job, report }: { job: Job; report: Report }) {
  const t = texts.value;
  const rows: [string, number | null | undefined, string][] =
    job.operation === "servo-simulation"
      ? [
          [t.servo.max, report.contour_error?.max_abs_um, "µm"],
          [t.servo.rms, report.contour_error?.rms_um, "µm"],
          [t.result.worst, report.contour_error?.worst_line, ""],
          [t.jobs.duration, report.duration_s, "s"],
        ]
      : job.operation === "verification"
        ? [
            [t.result.excess, report.max_excess?.residual_um, "µm"],
            [t.result.gouge, report.max_gouge?.residual_um, "µm"],
            [t.result.rms, report.rms_um, "µm"],
            [t.result.worst, report.max_excess?.line, ""],
          ]
        : [
            [t.result.blocksIn, report.blocks_in, ""],
            [t.result.blocksOut, report.blocks_out, ""],
          ];
  return (
    <Card title={t.result.values}>
      <Facts
        facts={rows.map(([name, value, unit]) => ({
          name,
          value: unit ? <Num value={value} unit={unit} /> : <Num value={value} text={whole} />,
        }))}
      />
    </Card>
  );
}
