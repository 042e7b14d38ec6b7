// What of a profile is changed most often, as a form. Everything else stays as it is.

import { useState } from "preact/hooks";
import { profileOf, putMachine, type Tagged } from "../../api/machines";
import type { MachineProfile, Vector } from "../../api/types";
import { Choice, Form, NumberField, PointField, TextField } from "../../parts/Form";
import { Card, read } from "../../parts/parts";
import { texts } from "../../texts";

export function Profile({ tagged, again }: { tagged: Tagged; again: () => void }) {
  const t = texts.value.machines;
  const { machine, tag } = tagged;
  const [name, setName] = useState(machine.name);
  const [unit, setUnit] = useState(machine.program_unit ?? "");
  const [feed, setFeed] = useState(String(machine.max_feed_mm_per_min ?? ""));
  const [due, setDue] = useState(String(machine.calibration_due_days ?? ""));
  const [serial, setSerial] = useState(machine.serial_number ?? "");
  const [asset, setAsset] = useState(machine.asset_id ?? "");
  const kept = machine.work_offsets_mm?.["G54"];
  const [offset, setOffset] = useState<string[]>((kept ?? ["", "", ""]).map(String));
  const send = async () => {
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
  };
  return (
    <Card title={t.profile}>
      <Form send={send} class="fields profileform" stale={t.stale}>
        <TextField label={texts.value.common.name} value={name} set={setName} />
        <Choice
          label={t.unit}
          value={unit}
          set={setUnit}
          options={[
            ["", t.notStated],
            ["mm", "mm"],
            ["inch", "inch"],
          ]}
        />
        <NumberField label={t.feedLimit} value={feed} set={setFeed} unit="mm/min" />
        <NumberField label={t.due} value={due} set={setDue} unit="d" />
        <TextField label={t.serial} value={serial} set={setSerial} />
        <TextField label={t.asset} value={asset} set={setAsset} />
        <PointField label={`${t.offsets}, G54`} of="G54" class="wide" letters={["X", "Y", "Z"]} value={offset} set={setOffset} unit="mm" />
      </Form>
      <details>
        <summary>{t.json}</summary>
        <pre>{JSON.stringify(profileOf(machine), null, 2)}</pre>
      </details>
    </Card>
  );
}
