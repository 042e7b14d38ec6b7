// What the report says in words: warnings, what was used, and where everything comes from.

import type { Job, Report, Warning } from "../../api/types";
import { moment } from "../../parts/format";
import { Card } from "../../parts/parts";
import { Words } from "../../parts/Words";
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

const sentence = (text: string) => `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;

export function Used({ report }: { report: Report }) {
  const t = texts.value.result;
  const used = report.resolved;
  const from = (by: string | null | undefined) => (by ? <span class="hint">{t.from[by] ?? by}</span> : null);
  return (
    <Card title={t.used}>
      <dl class="facts wide">
        {used?.unit && (
          <div>
            <dt>{t.unit}</dt>
            <dd>
              {used.unit} {from(used.unit_stated_by)}
            </dd>
          </div>
        )}
        {used?.work_offsets.map((offset) => (
          <div key={`${offset.name}${offset.first_line}`}>
            <dt>{`${t.offset} ${offset.name ?? ""}`}</dt>
            <dd>
              {offset.origin_mm ? `${offset.origin_mm.join("  ")} mm` : "–"} {from(offset.stated_by)}
              {offset.is_left_alone && <span class="badge">{t.leftAlone}</span>}
            </dd>
          </div>
        ))}
        {used?.tools.map((tool) => (
          <div key={`${tool.number}${tool.name}${tool.first_line}`}>
            <dt>{t.tool}</dt>
            <dd>
              {tool.name ?? tool.tool_id ?? (tool.number ? `T${tool.number}` : "–")}{" "}
              <span class="hint">
                {tool.first_line}–{tool.last_line}
              </span>
              {tool.is_left_alone && <span class="badge">{t.leftAlone}</span>}
            </dd>
          </div>
        ))}
        {report.contact && (
          <div>
            <dt>{t.contact}</dt>
            <dd>{texts.value.compensate.contacts[report.contact as "auto"] ?? report.contact}</dd>
          </div>
        )}
        <div>
          <dt>{t.dialect}</dt>
          <dd>{report.dialect}</dd>
        </div>
        {report.interpolation && (
          <div>
            <dt>{t.interpolation}</dt>
            <dd>{report.interpolation}</dd>
          </div>
        )}
      </dl>
    </Card>
  );
}

export function Provenance({ job }: { job: Job }) {
  const t = texts.value;
  return (
    <Card title={t.result.provenance} class="provenance">
      <dl class="facts wide">
        <div>
          <dt>{t.result.job}</dt>
          <dd>
            <code>{job.id}</code>
          </dd>
        </div>
        <div>
          <dt>{t.common.machine}</dt>
          <dd>
            <a href={`#/machines/${job.machine_id}`}>{job.machine_id}</a>, {t.common.revision(job.machine_revision)}
          </dd>
        </div>
        {job.finished_at && (
          <div>
            <dt>{t.result.finished}</dt>
            <dd>{moment(job.finished_at)}</dd>
          </div>
        )}
        <div>
          <dt>{t.result.software}</dt>
          <dd>Trunnion {job.software_version}</dd>
        </div>
        <div class="long">
          <dt>{t.result.inputDigest}</dt>
          <dd>
            <code>{job.input_sha256}</code>
          </dd>
        </div>
        {job.output_sha256 && (
          <div class="long">
            <dt>{t.result.outputDigest}</dt>
            <dd>
              <code>{job.output_sha256}</code>
            </dd>
          </div>
        )}
      </dl>
      <details>
        <summary>{t.result.parameters}</summary>
        <pre>{JSON.stringify(job.parameters, null, 2)}</pre>
      </details>
    </Card>
  );
}
