import { calibrations, machine as machineOf } from "../../api/machines";
import type { Machine } from "../../api/types";
import { useAsked } from "../../api/use";
import { day } from "../../parts/format";
import { Num } from "../../parts/Num";
import { Card, Empty, Got, Head } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";
import { MachineChoice } from "../MachineChoice";
import { RunView } from "./RunView";
import { TrendCard } from "./TrendCard";
import { Upload } from "./Upload";

export function Calibrate({ id, run }: { id: string | undefined; run: string | undefined }) {
  const t = texts.value.calibrate;
  if (id && run) return <RunView id={id} run={run} />;
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
          <Card tools={null}>
            {runs.length === 0 ? (
              <Empty what={t.none} cure={t.noneCure} />
            ) : (
              <div class="scroll" tabIndex={0} role="region" aria-label={t.title}>
                <table class="list">
                  <thead>
                    <tr>
                      <th scope="col">{t.measured}</th>
                      <th scope="col">{t.kind}</th>
                      <th scope="col">{t.instrument}</th>
                      <th scope="col">{t.operator}</th>
                      <th scope="col" class="right">
                        {t.temperature}
                      </th>
                      <th scope="col" class="right">
                        {t.rank}
                      </th>
                      <th scope="col" class="right">
                        {t.residual}
                      </th>
                    </tr>
                  </thead>
                  <tbody>
                    {runs.map((run) => (
                      <tr key={run.id} data-run={run.id}>
                        <td class="nowrap">
                          <a href={to("calibrate", id, run.id)}>{day(run.measured_at)}</a>{" "}
                          {run.id === applied && <span class="badge ok">{t.applied}</span>}
                        </td>
                        <td>{t.kinds[run.kind]}</td>
                        <td>{run.instrument ?? "–"}</td>
                        <td>{run.operator ?? "–"}</td>
                        <td class="right">
                          <Num value={run.temperature_c} unit="°C" text={(value) => value.toFixed(1)} />
                        </td>
                        <td class="num right">
                          {run.rank} / {run.unknowns}
                        </td>
                        <td class="right">
                          <Num value={run.residual_rms_um} unit="µm" />
                        </td>
                      </tr>
                    ))}
                  </tbody>
                </table>
              </div>
            )}
            <Upload id={id} />
          </Card>
          {runs.length > 1 && runs[0] && <TrendCard machine={machine} run={runs[0]} applied={applied} />}
        </>
      )}
    </Got>
  );
}
