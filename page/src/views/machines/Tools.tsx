import { useState } from "preact/hooks";
import { ask } from "../../api/client";
import { machinePath, tools as toolsOf } from "../../api/machines";
import { useAsked, useDoing } from "../../api/use";
import { Num } from "../../parts/Num";
import { Card, Empty, Field, Got, NumberInput, read } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
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
            <div class="scroll" tabIndex={0} role="region" aria-label={t.tools}>
              <table class="list numeric">
                <thead>
                  <tr>
                    <th scope="col">{t.tool}</th>
                    <th scope="col">{texts.value.common.name}</th>
                    <th scope="col">{t.kind}</th>
                    <th scope="col" class="right">
                      {t.radius} <span class="unit">mm</span>
                    </th>
                    <th scope="col" class="right">
                      {t.corner} <span class="unit">mm</span>
                    </th>
                    <th scope="col" class="right">
                      {t.length} <span class="unit">mm</span>
                    </th>
                  </tr>
                </thead>
                <tbody>
                  {items.map((tool) => (
                    <tr key={tool.tool_id}>
                      <th scope="row">
                        <a href={to("wear", id, tool.tool_id)}>{tool.tool_id}</a>
                      </th>
                      <td>{tool.name ?? "–"}</td>
                      <td>{t.kinds[tool.kind]}</td>
                      <td class="right">
                        <Num value={tool.radius_mm} text={plain} />
                      </td>
                      <td class="right">
                        <Num value={tool.corner_radius_mm} text={plain} />
                      </td>
                      <td class="right">
                        <Num value={tool.length_mm} text={plain} />
                      </td>
                    </tr>
                  ))}
                </tbody>
              </table>
            </div>
          )
        }
      </Got>
      <AddTool id={id} added={asked.again} />
    </Card>
  );
}

function AddTool({ id, added }: { id: string; added: () => void }) {
  const t = texts.value.machines;
  const doing = useDoing();
  const [tool, setTool] = useState({ id: "", radius: "", corner: "", length: "" });
  const set = (name: keyof typeof tool) => (value: string) => setTool({ ...tool, [name]: value });
  return (
    <details>
      <summary>{t.addTool}</summary>
      <form
        class="fields"
        onSubmit={(event) => {
          event.preventDefault();
          doing.run(async () => {
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
            setTool({ id: "", radius: "", corner: "", length: "" });
            added();
          });
        }}
      >
        <Field label={t.tool}>
          <input type="text" required placeholder="T12" value={tool.id} onInput={(event) => set("id")(event.currentTarget.value)} />
        </Field>
        <Field label={t.radius}>
          <NumberInput value={tool.radius} set={set("radius")} unit="mm" />
        </Field>
        <Field label={t.corner} hint={texts.value.compensate.cornerHint}>
          <NumberInput value={tool.corner} set={set("corner")} unit="mm" />
        </Field>
        <Field label={t.length}>
          <NumberInput value={tool.length} set={set("length")} unit="mm" />
        </Field>
        <div class="field end">
          <button type="submit" disabled={doing.busy}>
            {texts.value.common.save}
          </button>
        </div>
      </form>
      {doing.problem && <ProblemBox problem={doing.problem} />}
    </details>
  );
}
