import { Fragment } from "preact";
import { useMemo, useState } from "preact/hooks";
import { json, query } from "../../api/client";
import { machinePath, tools as toolsOf } from "../../api/machines";
import type { Interval, List, Machine, Tool, WearEntry, WearTrend } from "../../api/types";
import { useAsked } from "../../api/use";
import { day, sentence } from "../../parts/format";
import { Chart } from "../../parts/Chart";
import { Num } from "../../parts/Num";
import { Facts } from "../../parts/Facts";
import { Choice, NumberField } from "../../parts/Form";
import { Card, Empty, Got, Head, read } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { Table } from "../../parts/Table";
import { texts } from "../../texts";
import { go } from "../../router";
import { MachineChoice } from "../MachineChoice";
import { Advice } from "./Advice";
import { Enter } from "./Enter";
import { LastCut } from "./LastCut";
import { Scallop } from "./Scallop";

export function Wear({ id, tool }: { id: string | undefined; tool: string | undefined }) {
  const t = texts.value.wear;
  return (
    <>
      <Head title={t.title} lead={t.lead} />
      <MachineChoice view="wear" chosen={id}>
        {(machine) => (
          <Fragment key={machine.machine_id}>
            <Tools machine={machine} chosen={tool} />
            <Scallop />
            <LastCut id={machine.machine_id} />
          </Fragment>
        )}
      </MachineChoice>
    </>
  );
}

function Tools({ machine, chosen }: { machine: Machine; chosen: string | undefined }) {
  const t = texts.value.wear;
  const asked = useAsked(() => toolsOf(machine.machine_id), [machine.machine_id]);
  return (
    <Got asked={asked}>
      {({ items }) => {
        const tool = items.find((one) => one.tool_id === chosen) ?? items[0];
        if (!tool)
          return (
            <Card>
              <Empty what={t.noTools} />
            </Card>
          );
        return <History key={tool.tool_id} machine={machine} tool={tool} tools={items} />;
      }}
    </Got>
  );
}

const LIMIT_UM = "60";

function History({ machine, tool, tools }: { machine: Machine; tool: Tool; tools: Tool[] }) {
  const t = texts.value.wear;
  const path = `${machinePath(machine.machine_id)}/tools/${encodeURIComponent(tool.tool_id)}`;
  const entries = useAsked((signal) => json<List<WearEntry>>(`${path}/wear-entries?limit=200`, { signal }), [path]);
  const cutters = [...new Set((entries.data?.items ?? []).map((entry) => entry.cutter_id))];
  const [cutter, setCutter] = useState("");
  const [limit, setLimit] = useState(LIMIT_UM);
  const limit_um = read(limit) ?? null;
  const of = cutter || cutters[0] || "";
  const trend = useAsked(
    async (signal) => (of ? json<WearTrend>(`${path}/wear-trend${query({ cutter_id: of, limit_um })}`, { signal }) : null),
    [path, of, limit_um, entries.data],
  );
  return (
    <>
      <div class="fields choice noprint">
        <Choice
          label={t.tool}
          value={tool.tool_id}
          set={(next) => go("wear", machine.machine_id, next)}
          options={tools.map((one) => [one.tool_id, `${one.tool_id} ${one.name ?? ""}`])}
        />
        {cutters.length > 0 && (
          <Choice label={t.cutter} value={of} set={setCutter} options={cutters.map((one) => [one, one])} />
        )}
        <NumberField label={t.limit} value={limit} set={setLimit} unit="µm" />
      </div>
      <Got asked={entries}>
        {({ items }) =>
          items.length === 0 ? (
            <Card>
              <Empty what={t.noEntries} cure={t.noEntriesCure} />
            </Card>
          ) : (
            <>
              {trend.problem && <ProblemBox problem={trend.problem} />}
              {trend.data && <Shown trend={trend.data} tool={tool} />}
            </>
          )
        }
      </Got>
      <div class="grid">
        <Enter path={path} cutter={of} entered={entries.again} />
        {entries.data && entries.data.items.length > 0 && <Entries items={entries.data.items.filter((entry) => entry.cutter_id === of)} />}
      </div>
    </>
  );
}

function Shown({ trend, tool }: { trend: WearTrend; tool: Tool }) {
  const t = texts.value.wear;
  const edge = trend.edges[0];
  const points = edge?.entries ?? [];
  const x = useMemo(() => points.map((point) => point.parts_cut), [trend]);
  const limit = trend.limit_um ?? null;
  const values = useMemo(
    () => [points.map((point) => point.wear_um), points.map((point) => point.fitted_um ?? null), points.map(() => limit)],
    [trend, limit],
  );
  const outlook = trend.outlook;
  const left = outlook?.parts_left;
  return (
    <div class="grid wide">
      <Card title={t.history} class="span2" hint={trend.quantity === "flank" ? t.flankWear : t.radiusWear}>
        <Chart
          label={t.history}
          x={x}
          xLabel={t.parts}
          yLabel={t.wear}
          lines={[
            { label: t.measured, colour: "accent", points: true, width: 0 },
            { label: t.fitted, colour: "accent" },
            { label: t.limitLine, colour: "bad", dash: [6, 5], width: 1.25 },
          ]}
          values={values}
          height={300}
          fromZero
        />
      </Card>
      <Card title={t.outlook}>
        {typeof left?.estimate === "number" && (
          <div class="headline plain">
            <p class="label">{t.left}</p>
            <p class="big">
              <span class="is" data-name="parts-left">
                <Num value={left.estimate} text={String} />
              </span>
            </p>
            <p class="verdict">{between(left, t)}</p>
          </div>
        )}
        {outlook && <p>{sentence(outlook.words)}</p>}
        <Facts
          facts={[
            { row: "wear_um", name: t.now, value: <Num value={edge?.fit?.wear_um} unit="µm" /> },
            { row: "rate", name: t.rate, value: <Num value={edge?.fit?.rate_um_per_part} unit={t.perPart} /> },
          ]}
        />
        <ul class="warnings">
          {trend.warnings.map((warning) => (
            <li key={warning.detail}>{warning.detail}</li>
          ))}
        </ul>
      </Card>
      <Advice tool={tool} trend={trend} />
    </div>
  );
}

function between(left: Interval, t: { between: (early: string, late: string | null) => string }): string {
  return t.between(String(left.earliest ?? "–"), typeof left.latest === "number" ? String(left.latest) : null);
}

function Entries({ items }: { items: WearEntry[] }) {
  const t = texts.value.wear;
  return (
    <Card title={t.entries}>
      <Table
        label={t.entries}
        class="list numeric"
        rows={items}
        keyOf={(entry) => entry.id}
        rowClass={(entry) => (entry.withdrawn ? "gone" : "")}
        columns={[
          { head: t.when, cell: (entry) => day(entry.measured_at), class: "nowrap" },
          { head: t.partsCut, cell: (entry) => entry.parts_cut, class: "num right" },
          { head: t.wearOf, cell: (entry) => <Num value={entry.radius_wear_um ?? entry.flank_wear_um} />, class: "right" },
          {
            head: t.note,
            cell: (entry) => (entry.withdrawn ? `${t.withdrawn}: ${entry.withdrawn.reason}` : (entry.note ?? "–")),
          },
        ]}
      />
    </Card>
  );
}
