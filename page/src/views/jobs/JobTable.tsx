import type { Job } from "../../api/types";
import { moment, seconds } from "../../parts/format";
import { State } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";

/** Jobs, newest first. The reason of a refusal is said in the row. */
export function JobTable({ jobs }: { jobs: Job[] }) {
  const t = texts.value;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label={t.jobs.title}>
      <table class="list">
        <thead>
          <tr>
            <th scope="col">{t.common.state}</th>
            <th scope="col">{t.jobs.operation}</th>
            <th scope="col">{t.jobs.reference}</th>
            <th scope="col">{t.common.machine}</th>
            <th scope="col">{t.common.made}</th>
            <th scope="col" class="right">
              {t.jobs.duration}
            </th>
          </tr>
        </thead>
        <tbody>
          {jobs.map((job) => (
            <tr key={job.id} data-job={job.id}>
              <td>
                <State state={job.state} />
                {job.state === "running" && <progress max={1} value={job.progress} aria-label={t.states.running} />}
              </td>
              <td>
                <a href={to("jobs", job.id)}>{t.operations[job.operation]}</a>
                {job.problem && <div class="hint reason">{job.problem.title}</div>}
              </td>
              <td>{job.external_id ?? <span class="hint">{job.id.slice(0, 13)}</span>}</td>
              <td class="nowrap">{job.machine_id}</td>
              <td class="nowrap">{moment(job.created_at)}</td>
              <td class="num right">{job.started_at && job.finished_at ? seconds(job.started_at, job.finished_at) : "–"}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
