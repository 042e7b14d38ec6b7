import type { Job, Report } from "../../api/types";
import { BUDGET } from "../../api/types";
import { whole } from "../../parts/format";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { texts } from "../../texts";
import type { Reading } from "./reading";

/** The largest deviation before and after, and what it means. */
export function Headline({ job, report, reading }: { job: Job; report: Report; reading: Reading }) {
  const t = texts.value.result;
  const left = report.motions_left_over ?? report.cc?.motions_left_over ?? 0;
  const verdict =
    job.operation === "cc-compensation" && reading.tolerance !== null
      ? left > 0
        ? t.beyond(left)
        : t.within(String(reading.tolerance))
      : job.operation === "compensation"
        ? t.sum
        : t.wearDone;
  return (
    <div class={`headline ${left > 0 ? "amber" : "green"}`}>
      <p class="label">{t.largest}</p>
      <p class="big">
        <span class="was" data-name="before-max">
          <Num value={reading.beforeMax} />
        </span>
        <span class="arrow" aria-hidden="true">
          →
        </span>
        <span class="is" data-name="after-max">
          <Num value={reading.afterMax} unit="µm" />
        </span>
      </p>
      <p class="verdict">{verdict}</p>
    </div>
  );
}

type ToLine = (line: number) => void;

function LineLink({ line, toLine }: { line: number | null | undefined; toLine: ToLine }) {
  if (typeof line !== "number") return <>–</>;
  return (
    <button type="button" class="link num" data-value={line} onClick={() => toLine(line)}>
      {line}
    </button>
  );
}

export function BeforeAfter({ report, toLine }: { report: Report; toLine: ToLine }) {
  const t = texts.value;
  const { before, after } = report;
  if (!before || !after) return null;
  const rows = [
    ["max_um", t.result.max],
    ["rms_um", t.result.rms],
    ["max_excess_um", t.result.excess],
    ["max_gouge_um", t.result.gouge],
  ] as const;
  return (
    <Card title={t.result.numbers}>
      <table class="numbers">
        <thead>
          <tr>
            <th scope="col">{t.result.quantity}</th>
            <th scope="col">{t.common.before}</th>
            <th scope="col">{t.common.after}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(([name, words]) => (
            <tr key={name} data-row={name}>
              <th scope="row">{words}</th>
              <td>
                <Num value={before[name]} unit="µm" />
              </td>
              <td>
                <Num value={after[name]} unit="µm" />
              </td>
            </tr>
          ))}
          <tr data-row="worst_line">
            <th scope="row">{t.result.worst}</th>
            <td>
              <LineLink line={before.worst_line} toLine={toLine} />
            </td>
            <td>
              <LineLink line={after.worst_line} toLine={toLine} />
            </td>
          </tr>
        </tbody>
      </table>
    </Card>
  );
}

export function Budget({ report, toLine }: { report: Report; toLine: ToLine }) {
  const t = texts.value;
  const budget = report.error_budget;
  if (!budget) return null;
  return (
    <Card title={t.result.budget}>
      <table class="numbers">
        <thead>
          <tr>
            <th scope="col">{t.result.quantity}</th>
            <th scope="col">{t.common.before}</th>
            <th scope="col">{t.result.worst}</th>
            <th scope="col">{t.common.after}</th>
            <th scope="col">{t.result.worst}</th>
          </tr>
        </thead>
        <tbody>
          {BUDGET.map((name) => (
            <tr key={name} data-row={name} class={name === "sum" ? "total" : ""}>
              <th scope="row">{t.result.budgetOf[name]}</th>
              <td>
                <Num value={budget[name].before_um} unit="µm" />
              </td>
              <td>
                <LineLink line={budget[name].before_line} toLine={toLine} />
              </td>
              <td>
                <Num value={budget[name].after_um} unit="µm" />
              </td>
              <td>
                <LineLink line={budget[name].after_line} toLine={toLine} />
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </Card>
  );
}

export function Blocks({ report }: { report: Report }) {
  const t = texts.value.result;
  const findings = report.cc ?? report;
  const rows: [string, string, number | undefined][] = [
    ["blocks_in", t.blocksIn, report.blocks_in],
    ["blocks_out", t.blocksOut, report.blocks_out],
    ["blocks_inserted", t.inserted, report.blocks_inserted],
    ["motions_checked", t.checked, findings.motions_checked],
    ["motions_over_tolerance", t.over, findings.motions_over_tolerance],
    ["motions_left_over", t.leftOver, findings.motions_left_over],
    ["motions_shifted", t.shifted, report.motions_shifted],
  ];
  return (
    <Card title={t.blocks}>
      <dl class="facts">
        {rows
          .filter(([, , value]) => value !== undefined)
          .map(([name, words, value]) => (
            <div key={name} data-row={name}>
              <dt>{words}</dt>
              <dd>
                <Num value={value} text={whole} />
              </dd>
            </div>
          ))}
        {typeof findings.cc_path_length_mm === "number" && (
          <div data-row="cc_path_length_mm">
            <dt>{t.length}</dt>
            <dd>
              <Num value={findings.cc_path_length_mm} unit="mm" />
            </dd>
          </div>
        )}
      </dl>
    </Card>
  );
}
