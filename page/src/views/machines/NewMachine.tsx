import { useState } from "preact/hooks";
import { presets as allPresets, putMachine } from "../../api/machines";
import { useAsked, useDoing } from "../../api/use";
import { MachineView } from "../../machine3d/MachineView";
import { Card, Field, Got, Head } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { go, to } from "../../router";
import { texts } from "../../texts";

/** A new machine begins with a preset, and is then changed. */
export function NewMachine() {
  const t = texts.value.machines;
  const asked = useAsked(() => allPresets(), []);
  const doing = useDoing();
  const [chosen, choose] = useState("ac-table");
  const [id, setId] = useState("");
  const [name, setName] = useState("");
  return (
    <>
      <p class="crumbs">
        <a href={to("machines")}>{t.title}</a>
      </p>
      <Head title={t.add} />
      <Got asked={asked}>
        {({ items }) => {
          const preset = items.find((one) => one.id === chosen) ?? items[0];
          if (!preset) return null;
          return (
            <>
              <Card>
                <form
                  class="fields"
                  onSubmit={(event) => {
                    event.preventDefault();
                    doing.run(async () => {
                      await putMachine(id, { ...preset.profile, name: name || preset.title }, null);
                      go("machines", id);
                    });
                  }}
                >
                  <Field label={t.preset} hint={preset.description} class="wide">
                    <select value={chosen} onChange={(event) => choose(event.currentTarget.value)}>
                      {items.map((one) => (
                        <option key={one.id} value={one.id}>
                          {one.title}
                        </option>
                      ))}
                    </select>
                  </Field>
                  <Field label={t.id} hint={t.idHint}>
                    <input
                      type="text"
                      required
                      pattern="[a-z0-9][a-z0-9\-]{0,63}"
                      value={id}
                      onInput={(event) => setId(event.currentTarget.value)}
                    />
                  </Field>
                  <Field label={texts.value.common.name}>
                    <input type="text" placeholder={preset.title} value={name} onInput={(event) => setName(event.currentTarget.value)} />
                  </Field>
                  <div class="field end">
                    <button type="submit" class="primary" disabled={doing.busy}>
                      {t.create}
                    </button>
                  </div>
                </form>
                {doing.problem && <ProblemBox problem={doing.problem} />}
              </Card>
              <Card title={t.kinematics} hint={t.kinematicsHint}>
                <MachineView key={preset.id} kinematics={preset.profile.kinematics} />
              </Card>
            </>
          );
        }}
      </Got>
    </>
  );
}
