// What a job that ended well has made.

import { useMemo, useState } from "preact/hooks";
import { download, json } from "../../api/client";
import { type JobPath, jobPath } from "../../api/path";
import type { Job, Report } from "../../api/types";
import { type Asked, useAsked, useDoing } from "../../api/use";
import { Figure } from "../../parts/Figure";
import { Card, Got } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";
import { DeviationChart } from "./DeviationChart";
import { Provenance, Used, Warnings } from "./Notes";
import { BeforeAfter, Blocks, Budget, Headline } from "./Numbers";
import { Others } from "./Others";
import { Programs } from "./Programs";
import { read } from "./reading";
import { ResidualMap } from "./ResidualMap";
import { ToolPath } from "./ToolPath";

const NO_PATH: JobPath = { rows: [], together: 1, chords: 0 };
const CORRECTING = ["cc-compensation", "wear-compensation", "compensation"];

export function JobResult({ job }: { job: Job }) {
  const asked = useAsked((signal) => json<Report>(`/v1/jobs/${job.id}/report`, { signal }), [job.id]);
  const corrects = CORRECTING.includes(job.operation);
  const path = useAsked(async (signal) => (corrects ? jobPath(job.id, signal) : NO_PATH), [job.id]);
  return (
    <Got asked={asked}>
      {(report) =>
        corrects ? <Corrected job={job} report={report} path={path} /> : <Other job={job} report={report} />
      }
    </Got>
  );
}

function Corrected({ job, report, path }: { job: Job; report: Report; path: Asked<JobPath> }) {
  const t = texts.value;
  const reading = useMemo(() => read(job, report), [job, report]);
  const [line, setLine] = useState<number | null>(reading.worstBefore);
  // The text is read after the picture is there.
  const [drawn, setDrawn] = useState(false);
  const toText = (to: number) => {
    setLine(to);
    document.getElementById("programs")?.scrollIntoView({ block: "nearest" });
  };
  return (
    <div class="result">
      <div class="split">
        <Headline job={job} report={report} reading={reading} />
        <Files job={job} />
      </div>
      <DeviationChart reading={reading} line={line} toLine={setLine} />
      <ToolPath job={job} report={report} reading={reading} path={path} line={line} toLine={setLine} drawn={() => setDrawn(true)} />
      <div class="pair">
        <div class="column">
          <BeforeAfter report={report} toLine={toText} />
          <Budget report={report} toLine={toText} />
          <Warnings report={report} toLine={toText} />
        </div>
        <div class="column">
          <Blocks report={report} />
          <Used report={report} />
        </div>
      </div>
      {drawn && <Programs job={job} worst={reading.worstBefore} line={line} toLine={setLine} />}
      <Provenance job={job} />
      <p class="hint noscreen">{t.nav.version(job.software_version)}</p>
    </div>
  );
}

function Files({ job }: { job: Job }) {
  const t = texts.value.result;
  const doing = useDoing();
  const path = `/v1/jobs/${job.id}`;
  const save = (part: string, accept: string, name: string) => () => doing.run(() => download(`${path}/${part}`, accept, name));
  const name = job.id.slice(0, 13);
  return (
    <div class="files noprint">
      {job.operation === "verification" ? (
        <button type="button" class="primary" disabled={doing.busy} onClick={save("residuals", "text/csv", `${name}.csv`)}>
          {t.residualTable}
        </button>
      ) : job.output_sha256 ? (
        <button type="button" class="primary" disabled={doing.busy} onClick={save("program", "text/plain", `${name}.nc`)}>
          {t.download}
        </button>
      ) : null}
      <div class="row">
        <button type="button" onClick={save("report", "application/json", `${name}.json`)}>
          {t.report}
        </button>
        {job.operation !== "posting" && (
          <button type="button" onClick={save("plot", "image/svg+xml", `${name}.svg`)}>
            {t.figure}
          </button>
        )}
        {job.changes_sha256 && (
          <button type="button" onClick={save("changes", "text/csv", `${name}.csv`)}>
            {t.changes}
          </button>
        )}
        <button type="button" onClick={() => print()}>
          {texts.value.common.print}
        </button>
      </div>
      {doing.problem && <ProblemBox problem={doing.problem} />}
    </div>
  );
}

function Other({ job, report }: { job: Job; report: Report }) {
  const t = texts.value;
  return (
    <div class="result">
      <div class="split">
        <Others job={job} report={report} />
        <Files job={job} />
      </div>
      {job.operation === "verification" && <ResidualMap job={job} />}
      {job.operation !== "posting" && (
        <Card title={t.common.picture}>
          <Figure path={`/v1/jobs/${job.id}/plot`} alt={t.operations[job.operation]} />
        </Card>
      )}
      <div class="pair">
        <Warnings report={{ ...report, warnings: report.warnings ?? [] }} toLine={() => undefined} />
        <Used report={report} />
      </div>
      <Provenance job={job} />
    </div>
  );
}
