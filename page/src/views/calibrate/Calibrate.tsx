import { calibrations, machine as machineOf } from "../../api/machines";
import type { Machine } from "../../api/types";
import { useAsked } from "../../api/use";
import { day } from "../../parts/format";
import { Num } from "../../parts/Num";
import { Card, Empty, Got, Head } from "../../parts/parts";
import { Table } from "../../parts/Table";
import { to } from "../../router";
import { texts } from "../../texts";
import { MachineChoice } from "../MachineChoice";
import { ReportView } from "./ReportView";
import { RunView } from "./RunView";
import { TrendCard } from "./TrendCard";
import { NewRun } from "./NewRun";

interface Props {
  id: string | undefined;
  run: string | undefined;
  /** Whether its report is shown. */
  report: boolean;
}

export function Calibrate({ id, run, report }: Props) {
  const t = texts.value.calibrate;
  if (id && run) return report ? <ReportView id={id} run={run} /> : <RunView id={id} run={run} />;
  return (
    <>
      <Head title={t.title} lead={t.lead} />
      <MachineChoice view="calibrate" chosen={id}>
        {(machine) => <Runs key={machine.machine_id} machine={machine} />}
      </MachineChoice>
    </>
  );
}

function Runs({ machine }: { machine: Machine }) {
  const t = texts.value.calibrate;
  const id = machine.machine_id;
  const asked = useAsked(async () => {
    const [runs, tagged] = await Promise.all([calibrations(id), machineOf(id)]);
    return { runs: runs.items, applied: tagged.calibration };
  }, [id]);
  return (
    <Got asked={asked}>
      {({ runs, applied }) => (
        <>
          <Card>
            {runs.length === 0 ? (
              <Empty what={t.none} cure={t.noneCure} />
            ) : (
              <Table
                label={t.title}
                rows={runs}
                keyOf={(run) => run.id}
                data="run"
                columns={[
                  {
                    head: t.measured,
                    cell: (run) => (
                      <>
                        <a href={to("calibrate", id, run.id)}>{day(run.measured_at)}</a>{" "}
                        {run.id === applied && <span class="badge ok">{t.applied}</span>}
                      </>
                    ),
                    class: "nowrap",
                  },
                  { head: t.kind, cell: (run) => t.kinds[run.kind] },
                  { head: t.instrument, cell: (run) => run.instrument ?? "–" },
                  { head: t.operator, cell: (run) => run.operator ?? "–" },
                  {
                    head: t.temperature,
                    cell: (run) => <Num value={run.temperature_c} unit="°C" text={(value) => value.toFixed(1)} />,
                    class: "right",
                  },
                  { head: t.rank, cell: (run) => `${run.rank} / ${run.unknowns}`, class: "num right" },
                  { head: t.residual, cell: (run) => <Num value={run.residual_rms_um} unit="µm" />, class: "right" },
                ]}
              />
            )}
          </Card>
          <NewRun machine={machine} />
          {runs.length > 1 && runs[0] && <TrendCard machine={machine} run={runs[0]} applied={applied} />}
        </>
      )}
    </Got>
  );
}
