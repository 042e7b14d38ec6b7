import { useState } from "preact/hooks";
import { ask } from "../../api/client";
import { useDoing } from "../../api/use";
import { Card, Field, NumberInput, read } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";

/** A measurement of wear. Nothing is assumed: what is left empty is refused by the service with its reason. */
export function Enter({ path, cutter, entered }: { path: string; cutter: string; entered: () => void }) {
  const t = texts.value.wear;
  const doing = useDoing();
  const [entry, setEntry] = useState({ cutter, parts: "", radius: "", note: "" });
  const set = (name: keyof typeof entry) => (value: string) => setEntry({ ...entry, [name]: value });
  const [when, setWhen] = useState(() => new Date(Date.now() - new Date().getTimezoneOffset() * 60_000).toISOString().slice(0, 16));
  const save = () =>
    doing.run(async () => {
      await ask(`${path}/wear-entries`, {
        method: "POST",
        json: {
          ...((entry.cutter || cutter) && { cutter_id: entry.cutter || cutter }),
          measured_at: new Date(when).toISOString(),
          parts_cut: read(entry.parts),
          radius_wear_um: read(entry.radius),
          ...(entry.note && { note: entry.note }),
        },
      });
      setEntry({ ...entry, parts: "", radius: "", note: "" });
      entered();
    });
  return (
    <Card title={t.enter} class="noprint">
      <form
        class="fields"
        onSubmit={(event) => {
          event.preventDefault();
          save();
        }}
      >
        <Field label={t.cutter}>
          <input type="text" value={entry.cutter} placeholder={cutter} onInput={(event) => set("cutter")(event.currentTarget.value)} />
        </Field>
        <Field label={t.when}>
          <input type="datetime-local" value={when} onInput={(event) => setWhen(event.currentTarget.value)} />
        </Field>
        <Field label={t.parts}>
          <NumberInput value={entry.parts} set={set("parts")} />
        </Field>
        <Field label={t.radiusWear}>
          <NumberInput value={entry.radius} set={set("radius")} unit="µm" />
        </Field>
        <Field label={t.note} class="wide">
          <input type="text" value={entry.note} onInput={(event) => set("note")(event.currentTarget.value)} />
        </Field>
        <div class="field end">
          <button type="submit" disabled={doing.busy}>
            {texts.value.common.save}
          </button>
        </div>
      </form>
      {doing.problem && <ProblemBox problem={doing.problem} />}
    </Card>
  );
}
