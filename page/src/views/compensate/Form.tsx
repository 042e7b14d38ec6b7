import type { Machine, Tool } from "../../api/types";
import { Card, Field, NumberInput } from "../../parts/parts";
import { Words } from "../../parts/Words";
import { texts } from "../../texts";
import type { Entered } from "./request";

const CONTACTS = ["auto", "program", "normals", "surface", "feed-plane", "tip"] as const;
const DIALECTS = ["iso", "siemens", "heidenhain", "okuma", "apt", "csv"];

interface Props {
  entered: Entered;
  set: (change: Partial<Entered>) => void;
  machines: Machine[];
  tools: Tool[];
  faults: Record<string, string>;
  surface: File | null;
  setSurface: (file: File | null) => void;
}

export function Form({ entered, set, machines, tools, faults, surface, setSurface }: Props) {
  const t = texts.value.compensate;
  const check = (name: "cc" | "location" | "wear") => (
    <label class="check" key={name}>
      <input type="checkbox" checked={entered[name]} onChange={(event) => set({ [name]: event.currentTarget.checked })} />
      <span>{t[name]}</span>
    </label>
  );
  const number = (name: "radius" | "corner" | "worn" | "tolerance" | "length" | "feed" | "toolNumber", unit?: string) => (
    <NumberInput
      value={entered[name]}
      set={(value) => set({ [name]: value })}
      invalid={Boolean(faults[name])}
      {...(unit ? { unit } : {})}
    />
  );
  return (
    <>
      <Card title={t.what}>
        <fieldset class="bare">
          <legend class="hidden">{t.what}</legend>
          {(["cc", "location", "wear"] as const).map(check)}
        </fieldset>
        <div class="fields">
          <Field label={t.machine} fault={faults["machine"]} class="span2">
            <select value={entered.machine} onChange={(event) => set({ machine: event.currentTarget.value })}>
              {machines.map((machine) => (
                <option key={machine.machine_id} value={machine.machine_id}>
                  {machine.name} ({machine.machine_id})
                </option>
              ))}
            </select>
          </Field>
          {entered.cc && (
            <Field label={t.tolerance} fault={faults["tolerance"]}>
              {number("tolerance", "µm")}
            </Field>
          )}
          <div class={`field wide ${faults["offset"] ? "wrong" : ""}`} role="group" aria-label={t.offset}>
            <span class="label">{t.offset}</span>
            <div class="triple">
              {(["X", "Y", "Z"] as const).map((axis, index) => (
                <NumberInput
                  key={axis}
                  label={`${t.offset} ${axis}`}
                  placeholder={axis}
                  value={entered.offset[index] ?? ""}
                  set={(value) => {
                    const offset = [...entered.offset] as Entered["offset"];
                    offset[index] = value;
                    set({ offset });
                  }}
                  unit="mm"
                  invalid={Boolean(faults["offset"])}
                />
              ))}
            </div>
            {faults["offset"] ? (
              <span class="fault" role="alert">
                <Words text={faults["offset"]} />
              </span>
            ) : (
              <span class="hint">{t.offsetHint}</span>
            )}
          </div>
        </div>
      </Card>
      <Card title={t.toolAndContact}>
        <div class="fields">
          <Field label={t.tool} fault={faults["tool"]} class="wide">
            <select
              value={entered.byRadius ? "radius" : "table"}
              onChange={(event) => {
                const [kind, id] = event.currentTarget.value.split(":");
                const tool = tools.find((one) => one.tool_id === id);
                if (kind === "tool" && tool)
                  set({
                    byRadius: true,
                    radius: String(tool.radius_mm ?? ""),
                    corner: tool.corner_radius_mm === tool.radius_mm ? "" : String(tool.corner_radius_mm ?? ""),
                  });
                else set({ byRadius: kind === "radius" });
              }}
            >
              <option value="table">{t.byTable}</option>
              <option value="radius">{t.byRadius}</option>
              {tools
                .filter((tool) => typeof tool.radius_mm === "number")
                .map((tool) => (
                  <option key={tool.tool_id} value={`tool:${tool.tool_id}`}>
                    {tool.tool_id} {tool.name ?? ""}, R {tool.radius_mm}
                  </option>
                ))}
            </select>
          </Field>
          {entered.byRadius && (
            <>
              <Field label={t.radius}>{number("radius", "mm")}</Field>
              <Field label={t.corner} hint={t.cornerHint} fault={faults["corner"]}>
                {number("corner", "mm")}
              </Field>
            </>
          )}
          {entered.wear && (
            <Field label={t.worn} fault={faults["worn"]}>
              {number("worn", "mm")}
            </Field>
          )}
          <Field label={t.contact} fault={faults["contact"]} class="wide">
            <select value={entered.contact} onChange={(event) => set({ contact: event.currentTarget.value })}>
              {CONTACTS.map((contact) => (
                <option key={contact} value={contact}>
                  {t.contacts[contact]}
                </option>
              ))}
            </select>
          </Field>
          {(entered.contact === "surface" || surface) && (
            <Field label={t.surface} class="wide">
              <input type="file" accept=".stl" onChange={(event) => setSurface(event.currentTarget.files?.[0] ?? null)} />
            </Field>
          )}
        </div>
        <details class="more" open={["unit", "dialect", "length", "feed", "toolNumber"].some((name) => faults[name])}>
          <summary>{texts.value.common.showMore}</summary>
          <div class="fields">
            <Field label={t.unit} fault={faults["unit"]}>
              <select value={entered.unit} onChange={(event) => set({ unit: event.currentTarget.value })}>
                <option value="">{t.unitAsStated}</option>
                <option value="mm">mm</option>
                <option value="inch">inch</option>
              </select>
            </Field>
            <Field label={t.dialect} fault={faults["dialect"]}>
              <select value={entered.dialect} onChange={(event) => set({ dialect: event.currentTarget.value })}>
                <option value="auto">{t.dialectAuto}</option>
                {DIALECTS.map((dialect) => (
                  <option key={dialect}>{dialect}</option>
                ))}
              </select>
            </Field>
            <Field label={t.length} fault={faults["length"]}>
              {number("length", "mm")}
            </Field>
            <Field label={t.feed} fault={faults["feed"]}>
              {number("feed", "mm/min")}
            </Field>
            <Field label={t.toolNumber} fault={faults["toolNumber"]}>
              {number("toolNumber")}
            </Field>
            <Field label={t.externalId}>
              <input type="text" value={entered.reference} onInput={(event) => set({ reference: event.currentTarget.value })} />
            </Field>
          </div>
        </details>
      </Card>
    </>
  );
}
