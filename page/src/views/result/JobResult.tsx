// What a job that ended well has made.

import { useMemo, useState } from "preact/hooks";
import { download, json, textOf } from "../../api/client";
import type { Job, Report } from "../../api/types";
import { useAsked, useDoing } from "../../api/use";
import { Figure } from "../../parts/Figure";
import { Card, Empty, Got } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";
import { align } from "./align";
import { DeviationChart } from "./DeviationChart";
import { Provenance, Used, Warnings } from "./Notes";
import { BeforeAfter, Blocks, Budget, Headline } from "./Numbers";
import { Others } from "./Others";
import { ProgramText } from "./ProgramText";
import { read } from "./reading";
import { ResidualMap } from "./ResidualMap";
import { keepSource, SHOWN_MB, sources, tooLong } from "./sources";
import { ToolPath } from "./ToolPath";

const CORRECTING = ["cc-compensation", "wear-compensation", "compensation"];

export function JobResult({ job }: { job: Job }) {
  const asked = useAsked((signal) => json<Report>(`/v1/jobs/${job.id}/report`, { signal }), [job.id]);
  return (
    <Got asked={asked}>
      {(report) =>
        CORRECTING.includes(job.operation) ? <Corrected job={job} report={report} /> : <Other job={job} report={report} />
      }
    </Got>
  );
}

function Corrected({ job, report }: { job: Job; report: Report }) {
  const t = texts.value;
  const reading = useMemo(() => read(job, report), [job, report]);
  const [line, setLine] = useState<number | null>(reading.worstBefore);
  const toLine = (to: number) => {
    setLine(to);
  };
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
      <DeviationChart reading={reading} line={line} toLine={toLine} />
      <ToolPath job={job} report={report} reading={reading} line={line} toLine={toLine} />
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
      <Programs job={job} worst={reading.worstBefore} line={line} toLine={toLine} />
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

const linesOf = (text: string) => text.replace(/\r?\n$/, "").split(/\r?\n/);

interface ProgramsProps {
  job: Job;
  worst: number | null;
  line: number | null;
  toLine: (line: number) => void;
}

function Programs({ job, worst, line, toLine }: ProgramsProps) {
  const t = texts.value.result;
  const [wrong, setWrong] = useState(false);
  const source = sources.value.get(job.input_sha256);
  const output = useAsked(
    (signal) => textOf(`/v1/jobs/${job.id}/program`, { signal, headers: { Range: `bytes=0-${SHOWN_MB * 1e6}` } }),
    [job.id],
  );
  const before = useMemo(() => (source ? linesOf(source.text) : null), [source]);
  const after = useMemo(() => (output.data === null ? null : linesOf(output.data)), [output.data]);
  const aligned = useMemo(() => (before && after ? align(before, after) : null), [before, after]);
  const focus = line === null ? null : ([line, line] as [number, number]);
  const there = line === null ? null : (aligned?.of[line - 1] ?? null);
  const back = (number: number) => {
    const found = aligned?.of.findIndex((range) => range && number >= range[0] && number <= range[1]) ?? -1;
    if (found >= 0) toLine(found + 1);
  };
  const choose = async (file: File | undefined) => {
    if (file) setWrong((await keepSource(file, file.name)) !== job.input_sha256);
  };
  return (
    <Card
      title={t.programs}
      class="noprint programs"
      tools={
        worst !== null && (
          <button type="button" onClick={() => toLine(worst)}>
            {t.toWorst}
          </button>
        )
      }
    >
      <div class="two" id="programs">
        <div>
          <h3>{t.source}</h3>
          {before ? (
            <ProgramText label={t.source} lines={before} focus={focus} worst={worst} onLine={toLine} />
          ) : tooLong.value.has(job.input_sha256) ? (
            <Empty what={t.tooLong(SHOWN_MB)} />
          ) : (
            <div class="empty">
              <p>{t.noSource}</p>
              <label class="filebutton">
                {t.chooseSource}
                <input type="file" onChange={(event) => void choose(event.currentTarget.files?.[0])} />
              </label>
              {wrong && (
                <p class="fault" role="alert">
                  {t.otherSource}
                </p>
              )}
            </div>
          )}
        </div>
        <div>
          <h3>{t.output}</h3>
          <Got asked={output}>
            {() => (
              <ProgramText
                label={t.output}
                lines={after ?? []}
                focus={there}
                {...(aligned ? { changed: aligned.changed } : {})}
                onLine={back}
              />
            )}
          </Got>
        </div>
      </div>
    </Card>
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
