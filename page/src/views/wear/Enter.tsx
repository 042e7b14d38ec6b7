import { useState } from "preact/hooks";
import { ask } from "../../api/client";
import { Form, NumberField, TextField } from "../../parts/Form";
import { hereAndNow } from "../../parts/format";
import { Card, read } from "../../parts/parts";
import { texts } from "../../texts";

/** A measurement of wear. Nothing is assumed: what is left empty is refused by the service with its reason. */
export function Enter({ path, cutter, entered }: { path: string; cutter: string; entered: () => void }) {
  const t = texts.value.wear;
  const [entry, setEntry] = useState({ cutter, parts: "", radius: "", note: "", when: hereAndNow() });
  const set = (name: keyof typeof entry) => (value: string) => setEntry({ ...entry, [name]: value });
  const send = async () => {
    await ask(`${path}/wear-entries`, {
      method: "POST",
      json: {
        ...((entry.cutter || cutter) && { cutter_id: entry.cutter || cutter }),
        measured_at: new Date(entry.when).toISOString(),
        parts_cut: read(entry.parts),
        radius_wear_um: read(entry.radius),
        ...(entry.note && { note: entry.note }),
      },
    });
    setEntry({ ...entry, parts: "", radius: "", note: "" });
    entered();
  };
  return (
    <Card title={t.enter} class="noprint">
      <Form send={send}>
        <TextField label={t.cutter} value={entry.cutter} set={set("cutter")} placeholder={cutter} />
        <TextField label={t.when} value={entry.when} set={set("when")} type="datetime-local" required />
        <NumberField label={t.partsCut} value={entry.parts} set={set("parts")} />
        <NumberField label={t.radiusWear} value={entry.radius} set={set("radius")} unit="µm" />
        <TextField label={t.note} value={entry.note} set={set("note")} class="wide" />
      </Form>
    </Card>
  );
}
