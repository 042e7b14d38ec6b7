import { useState } from "preact/hooks";
import { ask } from "../../api/client";
import { machinePath, tools as toolsOf } from "../../api/machines";
import { useAsked } from "../../api/use";
import { Num } from "../../parts/Num";
import { Form, NumberField, TextField } from "../../parts/Form";
import { Card, Empty, Got, read } from "../../parts/parts";
import { Table } from "../../parts/Table";
import { to } from "../../router";
import { texts } from "../../texts";

const plain = (value: number) => String(Number(value.toFixed(4)));

export function Tools({ id }: { id: string }) {
  const t = texts.value.machines;
  const asked = useAsked(() => toolsOf(id), [id]);
  return (
    <Card title={t.tools}>
      <Got asked={asked}>
        {({ items }) =>
          items.length === 0 ? (
            <Empty what={t.noTools} />
          ) : (
            <Table
              label={t.tools}
              class="list numeric"
              rows={items}
              keyOf={(tool) => tool.tool_id}
              columns={[
                { head: t.tool, cell: (tool) => <a href={to("wear", id, tool.tool_id)}>{tool.tool_id}</a>, names: true },
                { head: texts.value.common.name, cell: (tool) => tool.name ?? "–" },
                { head: t.kind, cell: (tool) => t.kinds[tool.kind] },
                { head: t.radius, unit: "mm", cell: (tool) => <Num value={tool.radius_mm} text={plain} />, class: "right" },
                { head: t.corner, unit: "mm", cell: (tool) => <Num value={tool.corner_radius_mm} text={plain} />, class: "right" },
                { head: t.length, unit: "mm", cell: (tool) => <Num value={tool.length_mm} text={plain} />, class: "right" },
              ]}
            />
          )
        }
      </Got>
      <AddTool id={id} added={asked.again} />
    </Card>
  );
}

function AddTool({ id, added }: { id: string; added: () => void }) {
  const t = texts.value.machines;
  const empty = { id: "", radius: "", corner: "", length: "" };
  const [tool, setTool] = useState(empty);
  const set = (name: keyof typeof tool) => (value: string) => setTool({ ...tool, [name]: value });
  const send = async () => {
    const radius_mm = read(tool.radius);
    const corner_radius_mm = read(tool.corner) ?? radius_mm;
    const length_mm = read(tool.length);
    const kind = corner_radius_mm === radius_mm ? "ball" : corner_radius_mm === 0 ? "flat" : "bull-nose";
    const number = /^T(\d+)$/.exec(tool.id)?.[1];
    await ask(`${machinePath(id)}/tools/${encodeURIComponent(tool.id)}`, {
      method: "PUT",
      headers: { "If-None-Match": "*" },
      json: { kind, radius_mm, corner_radius_mm, length_mm, ...(number ? { number: Number(number) } : {}) },
    });
    setTool(empty);
    added();
  };
  return (
    <details>
      <summary>{t.addTool}</summary>
      <Form send={send}>
        <TextField label={t.tool} value={tool.id} set={set("id")} placeholder="T12" required />
        <NumberField label={t.radius} value={tool.radius} set={set("radius")} unit="mm" />
        <NumberField label={t.corner} value={tool.corner} set={set("corner")} unit="mm" hint={texts.value.compensate.cornerHint} />
        <NumberField label={t.length} value={tool.length} set={set("length")} unit="mm" />
      </Form>
    </details>
  );
}
