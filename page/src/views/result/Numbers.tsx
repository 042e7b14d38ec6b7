import type { DeviationSummary, Job, Report } from "../../api/types";
import { BUDGET } from "../../api/types";
import { whole } from "../../parts/format";
import { Facts } from "../../parts/Facts";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { Table } from "../../parts/Table";
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
  const size = (name: "max_um" | "rms_um" | "max_excess_um" | "max_gouge_um", words: string) => ({
    name,
    words,
    of: (summary: DeviationSummary) => <Num value={summary[name]} unit="µm" />,
  });
  const rows = [
    size("max_um", t.result.max),
    size("rms_um", t.result.rms),
    size("max_excess_um", t.result.excess),
    size("max_gouge_um", t.result.gouge),
    {
      name: "worst_line",
      words: t.result.worst,
      of: (summary: DeviationSummary) => <LineLink line={summary.worst_line} toLine={toLine} />,
    },
  ];
  return (
    <Card title={t.result.numbers}>
      <Table
        label={t.result.numbers}
        class="numbers"
        rows={rows}
        keyOf={(row) => row.name}
        data="row"
        columns={[
          { head: t.result.quantity, cell: (row) => row.words, names: true },
          { head: t.common.before, cell: (row) => row.of(before) },
          { head: t.common.after, cell: (row) => row.of(after) },
        ]}
      />
    </Card>
  );
}

export function Budget({ report, toLine }: { report: Report; toLine: ToLine }) {
  const t = texts.value;
  const budget = report.error_budget;
  if (!budget) return null;
  return (
    <Card title={t.result.budget}>
      <Table
        label={t.result.budget}
        class="numbers"
        rows={[...BUDGET]}
        keyOf={(name) => name}
        data="row"
        rowClass={(name) => (name === "sum" ? "total" : "")}
        columns={[
          { head: t.result.quantity, cell: (name) => t.result.budgetOf[name], names: true },
          { head: t.common.before, cell: (name) => <Num value={budget[name].before_um} unit="µm" /> },
          { head: t.result.worst, cell: (name) => <LineLink line={budget[name].before_line} toLine={toLine} /> },
          { head: t.common.after, cell: (name) => <Num value={budget[name].after_um} unit="µm" /> },
          { head: t.result.worst, cell: (name) => <LineLink line={budget[name].after_line} toLine={toLine} /> },
        ]}
      />
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
      <Facts
        facts={[
          ...rows
            .filter(([, , value]) => value !== undefined)
            .map(([row, name, value]) => ({ row, name, value: <Num value={value} text={whole} /> })),
          typeof findings.cc_path_length_mm === "number" && {
            row: "cc_path_length_mm",
            name: t.length,
            value: <Num value={findings.cc_path_length_mm} unit="mm" />,
          },
        ]}
      />
    </Card>
  );
}
