// What of a profile is changed most often, as a form. Everything else stays as it is.

import { useState } from "preact/hooks";
import { profileOf, putMachine, type Tagged } from "../../api/machines";
import type { MachineProfile, Vector } from "../../api/types";
import { useDoing } from "../../api/use";
import { Card, Field, NumberInput, read } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";

export function Profile({ tagged, again }: { tagged: Tagged; again: () => void }) {
  const t = texts.value.machines;
  const { machine, tag } = tagged;
  const doing = useDoing();
  const [name, setName] = useState(machine.name);
  const [unit, setUnit] = useState(machine.program_unit ?? "");
  const [feed, setFeed] = useState(String(machine.max_feed_mm_per_min ?? ""));
  const [due, setDue] = useState(String(machine.calibration_due_days ?? ""));
  const [serial, setSerial] = useState(machine.serial_number ?? "");
  const [asset, setAsset] = useState(machine.asset_id ?? "");
  const kept = machine.work_offsets_mm?.["G54"];
  const [offset, setOffset] = useState<string[]>((kept ?? ["", "", ""]).map(String));
  const save = () =>
    doing.run(async () => {
      const profile: MachineProfile = profileOf(machine);
      const values = offset.map(read);
      const G54 = values.every((value) => value !== undefined) ? (values as Vector) : undefined;
      const others = Object.entries(machine.work_offsets_mm ?? {}).filter(([of]) => of !== "G54");
      const offsets = G54 ? { ...Object.fromEntries(others), G54 } : Object.fromEntries(others);
      const changed = {
        ...profile,
        name,
        program_unit: unit || null,
        max_feed_mm_per_min: read(feed) ?? null,
        calibration_due_days: read(due) ?? null,
        serial_number: serial || null,
        asset_id: asset || null,
        work_offsets_mm: Object.keys(offsets).length > 0 ? offsets : null,
      };
      const stated = Object.entries(changed).filter(([, value]) => value !== null);
      await putMachine(machine.machine_id, Object.fromEntries(stated) as unknown as MachineProfile, tag);
      again();
    });
  const text = (label: string, value: string, set: (value: string) => void) => (
    <Field label={label}>
      <input type="text" value={value} onInput={(event) => set(event.currentTarget.value)} />
    </Field>
  );
  return (
    <Card title={t.profile}>
      <form
        class="fields profileform"
        onSubmit={(event) => {
          event.preventDefault();
          save();
        }}
      >
        {text(texts.value.common.name, name, setName)}
        <Field label={t.unit}>
          <select value={unit} onChange={(event) => setUnit(event.currentTarget.value as "mm")}>
            <option value="">{t.notStated}</option>
            <option value="mm">mm</option>
            <option value="inch">inch</option>
          </select>
        </Field>
        <Field label={t.feedLimit}>
          <NumberInput value={feed} set={setFeed} unit="mm/min" />
        </Field>
        <Field label={t.due}>
          <NumberInput value={due} set={setDue} unit="d" />
        </Field>
        {text(t.serial, serial, setSerial)}
        {text(t.asset, asset, setAsset)}
        <div class="field wide" role="group" aria-label={`${t.offsets} G54`}>
          <span class="label">{t.offsets}, G54</span>
          <div class="triple">
            {["X", "Y", "Z"].map((axis, index) => (
              <NumberInput
                key={axis}
                label={`G54 ${axis}`}
                placeholder={axis}
                unit="mm"
                value={offset[index] ?? ""}
                set={(value) => setOffset(offset.map((old, at) => (at === index ? value : old)))}
              />
            ))}
          </div>
        </div>
        <div class="field end">
          <button type="submit" disabled={doing.busy}>
            {texts.value.common.save}
          </button>
        </div>
      </form>
      {doing.problem && (
        <>
          {doing.problem.status === 412 && <p class="fault">{t.stale}</p>}
          <ProblemBox problem={doing.problem} />
        </>
      )}
      <details>
        <summary>{t.json}</summary>
        <pre>{JSON.stringify(profileOf(machine), null, 2)}</pre>
      </details>
    </Card>
  );
}
