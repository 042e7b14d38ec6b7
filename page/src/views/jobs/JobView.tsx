// One job: its state, its result or the reason of its refusal, its deliveries and its rows of the audit log.

import { useEffect, useState } from "preact/hooks";
import { json } from "../../api/client";
import { cancel, follow, isOver, job as jobOf } from "../../api/jobs";
import type { Delivery, Job, List } from "../../api/types";
import { useAsked, useDoing } from "../../api/use";
import { usePictures } from "../../machine3d/ready";
import { moment, seconds } from "../../parts/format";
import { Card, Got, Head, State } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { to } from "../../router";
import { texts } from "../../texts";
import { JobResult } from "../result/JobResult";
import { Provenance } from "../result/Notes";

export function JobView({ id }: { id: string }) {
  usePictures(0);
  const asked = useAsked((signal) => jobOf(id, signal), [id]);
  return <Got asked={asked}>{(job) => <Followed key={job.id} first={job} />}</Got>;
}

function Followed({ first }: { first: Job }) {
  const t = texts.value;
  const [job, setJob] = useState(first);
  const doing = useDoing();
  useEffect(() => {
    if (isOver(first.state)) return;
    const stop = new AbortController();
    follow(first.id, (seen) => setJob((old) => ({ ...old, state: seen.state ?? old.state, progress: seen.progress })), stop.signal).then(
      setJob,
      () => undefined,
    );
    return () => stop.abort();
  }, [first.id]);
  const took = job.started_at && job.finished_at ? ` · ${seconds(job.started_at, job.finished_at)}` : "";
  return (
    <>
      <p class="crumbs noprint">
        <a href={to("jobs")}>{t.jobs.title}</a>
      </p>
      <Head
        title={`${t.operations[job.operation]}${job.external_id ? `: ${job.external_id}` : ""}`}
        lead={`${job.machine_id}, ${t.common.revision(job.machine_revision)} · ${moment(job.created_at)}${took}`}
      >
        <State state={job.state} />
        {!isOver(job.state) && (
          <button type="button" disabled={doing.busy} onClick={() => doing.run(async () => setJob(await cancel(job.id)))}>
            {t.jobs.cancel}
          </button>
        )}
      </Head>
      {doing.problem && <ProblemBox problem={doing.problem} />}
      {!isOver(job.state) && <progress class="wide" max={1} value={job.progress} aria-label={t.states[job.state]} />}
      {job.problem && (
        <div class="result">
          <ProblemBox problem={job.problem} />
          <Provenance job={job} />
        </div>
      )}
      {job.state === "succeeded" && <JobResult job={job} />}
      <div class="grid after noprint">
        <Deliveries job={job} />
        <Audit job={job} />
      </div>
    </>
  );
}

function Deliveries({ job }: { job: Job }) {
  const t = texts.value.jobs;
  const asked = useAsked(
    async (signal) => (job.callback_url ? json<Delivery>(`/v1/jobs/${job.id}/deliveries`, { signal }) : null),
    [job.id, job.state],
  );
  return (
    <Card title={t.deliveries}>
      {!job.callback_url ? (
        <p class="hint">{t.noDeliveries}</p>
      ) : (
        <ul class="plainlist">
          {asked.data?.items.map((attempt) => (
            <li key={attempt.started_at}>
              {moment(attempt.started_at)}: {attempt.outcome} {attempt.status ?? ""} <span class="hint">{attempt.detail}</span>
            </li>
          ))}
        </ul>
      )}
    </Card>
  );
}

interface AuditEntry {
  seq: number;
  at: string;
  action: string;
  resource: string;
  key_id?: string | null;
  origin: string;
}

function Audit({ job }: { job: Job }) {
  const t = texts.value.jobs;
  const asked = useAsked(
    async (signal) => {
      const from = new Date(Date.parse(job.created_at) - 1000).toISOString();
      const query = new URLSearchParams({ machine_id: job.machine_id, from, limit: "200" });
      const { items } = await json<List<AuditEntry>>(`/v1/audit?${query}`, { signal });
      return items.filter((entry) => entry.resource.includes(job.id));
    },
    [job.id, job.state],
  );
  return (
    <Card title={t.audit}>
      {asked.problem?.status === 403 ? (
        <p class="hint">{t.auditNeedsAdmin}</p>
      ) : (
        <Got asked={asked}>
          {(entries) => (
            <ul class="plainlist">
              {entries.map((entry) => (
                <li key={entry.seq}>
                  {moment(entry.at)}: {entry.action} <span class="hint">{entry.key_id ?? entry.origin}</span>
                </li>
              ))}
            </ul>
          )}
        </Got>
      )}
    </Card>
  );
}
