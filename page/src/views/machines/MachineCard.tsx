import { jobs as jobsOf } from "../../api/jobs";
import { calibrations, machine as machineOf } from "../../api/machines";
import type { Machine } from "../../api/types";
import { useAsked } from "../../api/use";
import { moment } from "../../parts/format";
import { State } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";
import { judge } from "./light";

/** A machine with its light, and the reasons of the light in words. */
export function MachineCard({ machine }: { machine: Machine }) {
  const t = texts.value;
  const asked = useAsked(
    async (signal) => {
      const [runs, last, tagged] = await Promise.all([
        calibrations(machine.machine_id),
        jobsOf({ machine_id: machine.machine_id, limit: 10 }, signal),
        machineOf(machine.machine_id, signal),
      ]);
      const [newest] = runs.items.toSorted((a, b) => b.measured_at.localeCompare(a.measured_at));
      return { newest: newest ?? null, jobs: last.items, applied: tagged.calibration };
    },
    [machine],
  );
  const judged = asked.data ? judge(machine, asked.data.newest, asked.data.applied, asked.data.jobs, t) : null;
  const last = asked.data?.jobs[0];
  const named = (side: "table" | "head") =>
    machine.kinematics.rotary_axes.filter((axis) => axis.side === side).map((axis) => axis.name);
  const axes = (["table", "head"] as const)
    .filter((side) => named(side).length > 0)
    .map((side) => t.machines.carries[side](named(side).join(" ")))
    .join(" · ");
  return (
    <a class={`card machine ${judged?.light ?? ""}`} href={to("machines", machine.machine_id)}>
      <h3>{machine.name}</h3>
      <p class="hint">
        {machine.machine_id} · {t.common.revision(machine.revision)} · {axes}
      </p>
      {judged && (
        <p class={`light ${judged.light}`}>
          <span class="mark" aria-hidden="true" />
          {t.lights[judged.light]}
        </p>
      )}
      <ul class="reasons">{judged?.reasons.map((words) => <li key={words}>{words}</li>)}</ul>
      <p class="hint lastjob">
        {last ? (
          <>
            {t.overview.lastJob}: {t.operations[last.operation]}, {moment(last.created_at)} <State state={last.state} />
          </>
        ) : (
          asked.data && t.overview.noJobOfMachine
        )}
      </p>
    </a>
  );
}
