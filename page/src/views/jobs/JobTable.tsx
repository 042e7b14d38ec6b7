import type { Job } from "../../api/types";
import { moment, seconds } from "../../parts/format";
import { State } from "../../parts/parts";
import { Table } from "../../parts/Table";
import { to } from "../../router";
import { texts } from "../../texts";

/** Jobs, newest first. The reason of a refusal is said in the row. */
export function JobTable({ jobs }: { jobs: Job[] }) {
  const t = texts.value;
  return (
    <Table
      label={t.jobs.title}
      rows={jobs}
      keyOf={(job) => job.id}
      data="job"
      columns={[
        {
          head: t.common.state,
          cell: (job) => (
            <>
              <State state={job.state} />
              {job.state === "running" && <progress max={1} value={job.progress} aria-label={t.states.running} />}
            </>
          ),
        },
        {
          head: t.jobs.operation,
          cell: (job) => (
            <>
              <a href={to("jobs", job.id)}>{t.operations[job.operation]}</a>
              {job.problem && <div class="hint reason">{job.problem.title}</div>}
            </>
          ),
        },
        { head: t.jobs.reference, cell: (job) => job.external_id ?? <span class="hint">{job.id.slice(0, 13)}</span> },
        { head: t.common.machine, cell: (job) => job.machine_id, class: "nowrap" },
        { head: t.common.made, cell: (job) => moment(job.created_at), class: "nowrap" },
        {
          head: t.jobs.duration,
          cell: (job) => (job.started_at && job.finished_at ? seconds(job.started_at, job.finished_at) : "–"),
          class: "num right",
        },
      ]}
    />
  );
}
