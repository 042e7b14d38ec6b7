import type { Machine, Tool } from "../../api/types";
import { Choice, NumberField, PointField, TextField } from "../../parts/Form";
import { Card, Field } from "../../parts/parts";
import { Words } from "../../parts/Words";
import { texts } from "../../texts";
import { namesOf } from "../MachineChoice";
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

type NumberName = "radius" | "corner" | "worn" | "tolerance" | "length" | "feed" | "toolNumber";

export function ProgramForm({ entered, set, machines, tools, faults, surface, setSurface }: Props) {
  const t = texts.value.compensate;
  const check = (name: "cc" | "location" | "wear") => (
    <label class="check" key={name}>
      <input type="checkbox" checked={entered[name]} onChange={(event) => set({ [name]: event.currentTarget.checked })} />
      <span>{t[name]}</span>
    </label>
  );
  const number = (name: NumberName, label: string, unit?: string, hint?: string) => (
    <NumberField
      label={label}
      value={entered[name]}
      set={(value) => set({ [name]: value })}
      fault={faults[name]}
      {...(unit ? { unit } : {})}
      {...(hint ? { hint } : {})}
    />
  );
  const choice = (name: "contact" | "unit" | "dialect", label: string, options: [string, string][], kind?: string) => (
    <Choice
      label={label}
      value={entered[name]}
      set={(value) => set({ [name]: value })}
      fault={faults[name]}
      options={options}
      {...(kind ? { class: kind } : {})}
    />
  );
  const known = tools.filter((tool) => typeof tool.radius_mm === "number");
  const chooseTool = (value: string) => {
    const tool = known.find((one) => `tool:${one.tool_id}` === value);
    if (!tool) return set({ byRadius: value === "radius" });
    const corner = tool.corner_radius_mm === tool.radius_mm ? "" : String(tool.corner_radius_mm ?? "");
    set({ byRadius: true, radius: String(tool.radius_mm), corner });
  };
  return (
    <>
      <Card title={t.what}>
        <fieldset class="bare">
          <legend class="hidden">{t.what}</legend>
          {(["cc", "location", "wear"] as const).map(check)}
        </fieldset>
        <div class="fields">
          <Choice
            label={t.machine}
            value={entered.machine}
            set={(machine) => set({ machine })}
            fault={faults["machine"]}
            options={namesOf(machines)}
            class="span2"
          />
          {entered.cc && number("tolerance", t.tolerance, "µm")}
          <PointField
            label={t.offset}
            letters={["X", "Y", "Z"]}
            value={entered.offset}
            set={(offset) => set({ offset: offset as Entered["offset"] })}
            unit="mm"
            class="wide"
            hint={t.offsetHint}
            fault={faults["offset"] && <Words text={faults["offset"]} />}
          />
        </div>
      </Card>
      <Card title={t.toolAndContact}>
        <div class="fields">
          <Choice
            label={t.tool}
            value={entered.byRadius ? "radius" : "table"}
            set={chooseTool}
            fault={faults["tool"]}
            class="wide"
            options={[
              ["table", t.byTable],
              ["radius", t.byRadius],
              ...known.map((tool): [string, string] => [`tool:${tool.tool_id}`, `${tool.tool_id} ${tool.name ?? ""}, R ${tool.radius_mm}`]),
            ]}
          />
          {entered.byRadius && (
            <>
              {number("radius", t.radius, "mm")}
              {number("corner", t.corner, "mm", t.cornerHint)}
            </>
          )}
          {entered.wear && number("worn", t.worn, "mm")}
          {choice("contact", t.contact, CONTACTS.map((contact) => [contact, t.contacts[contact]]), "wide")}
          {(entered.contact === "surface" || surface) && (
            <Field label={t.surface} class="wide">
              <input type="file" accept=".stl" onChange={(event) => setSurface(event.currentTarget.files?.[0] ?? null)} />
            </Field>
          )}
        </div>
        <details class="more" open={["unit", "dialect", "length", "feed", "toolNumber"].some((name) => faults[name])}>
          <summary>{texts.value.common.showMore}</summary>
          <div class="fields">
            {choice("unit", t.unit, [
              ["", t.unitAsStated],
              ["mm", "mm"],
              ["inch", "inch"],
            ])}
            {choice("dialect", t.dialect, [["auto", t.dialectAuto], ...DIALECTS.map((dialect): [string, string] => [dialect, dialect])])}
            {number("length", t.length, "mm")}
            {number("feed", t.feed, "mm/min")}
            {number("toolNumber", t.toolNumber)}
            <TextField label={t.externalId} value={entered.reference} set={(reference) => set({ reference })} />
          </div>
        </details>
      </Card>
    </>
  );
}
