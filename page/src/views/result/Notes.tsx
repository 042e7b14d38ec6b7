// What the report says in words: warnings, what was used, and where everything comes from.

import type { Job, Report, Warning } from "../../api/types";
import { Facts } from "../../parts/Facts";
import { moment, sentence } from "../../parts/format";
import { Card } from "../../parts/parts";
import { Words } from "../../parts/Words";
import { to } from "../../router";
import { texts } from "../../texts";

export function warningsOf(report: Report): Warning[] {
  return [report, report.cc, report.wear].flatMap((part) => part?.warnings ?? []);
}

export function Warnings({ report, toLine }: { report: Report; toLine: (line: number) => void }) {
  const t = texts.value;
  const warnings = warningsOf(report);
  return (
    <Card title={t.result.warnings}>
      {warnings.length === 0 && <p class="hint">{t.result.noWarnings}</p>}
      <ul class="warnings">
        {warnings.map((warning) => (
          <li key={warning.kind + warning.detail}>
            <p>
              <Words text={sentence(warning.detail)} />
            </p>
            <p class="hint row">
              {[warning.line, warning.worst_line]
                .filter((line, index, all): line is number => typeof line === "number" && all.indexOf(line) === index)
                .map((line) => (
                  <button type="button" class="link" key={line} onClick={() => toLine(line)}>
                    {t.common.line(line)}
                  </button>
                ))}
              {warning.count > 1 && <span>{t.result.times(warning.count)}</span>}
              <code>{warning.kind}</code>
            </p>
          </li>
        ))}
      </ul>
    </Card>
  );
}

export function Used({ report }: { report: Report }) {
  const t = texts.value.result;
  const used = report.resolved;
  const from = (by: string | null | undefined) => (by ? <span class="hint">{t.from[by] ?? by}</span> : null);
  return (
    <Card title={t.used}>
      <Facts
        class="wide"
        facts={[
          used?.unit && {
            name: t.unit,
            value: (
              <>
                {used.unit} {from(used.unit_stated_by)}
              </>
            ),
          },
          ...(used?.work_offsets ?? []).map((offset) => ({
            name: `${t.offset} ${offset.name ?? ""}`,
            value: (
              <>
                {offset.origin_mm ? `${offset.origin_mm.join("  ")} mm` : "–"} {from(offset.stated_by)}
                {offset.is_left_alone && <span class="badge">{t.leftAlone}</span>}
              </>
            ),
          })),
          ...(used?.tools ?? []).map((tool) => ({
            name: t.tool,
            value: (
              <>
                {tool.name ?? tool.tool_id ?? (tool.number ? `T${tool.number}` : "–")}{" "}
                <span class="hint">
                  {tool.first_line}–{tool.last_line}
                </span>
                {tool.is_left_alone && <span class="badge">{t.leftAlone}</span>}
              </>
            ),
          })),
          report.contact && { name: t.contact, value: texts.value.compensate.contacts[report.contact as "auto"] ?? report.contact },
          { name: t.dialect, value: report.dialect },
          report.interpolation && { name: t.interpolation, value: report.interpolation },
        ]}
      />
    </Card>
  );
}

export function Provenance({ job }: { job: Job }) {
  const t = texts.value;
  return (
    <Card title={t.result.provenance} class="provenance">
      <Facts
        class="wide"
        facts={[
          { name: t.result.job, value: <code>{job.id}</code> },
          {
            name: t.common.machine,
            value: (
              <>
                <a href={to("machines", job.machine_id)}>{job.machine_id}</a>, {t.common.revision(job.machine_revision)}
              </>
            ),
          },
          job.finished_at && { name: t.result.finished, value: moment(job.finished_at) },
          { name: t.result.software, value: `Trunnion ${job.software_version}` },
          { name: t.result.inputDigest, value: <code>{job.input_sha256}</code>, long: true },
          job.output_sha256 && { name: t.result.outputDigest, value: <code>{job.output_sha256}</code>, long: true },
        ]}
      />
      <details>
        <summary>{t.result.parameters}</summary>
        <pre>{JSON.stringify(job.parameters, null, 2)}</pre>
      </details>
    </Card>
  );
}
