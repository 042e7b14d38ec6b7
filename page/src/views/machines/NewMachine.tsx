import { useState } from "preact/hooks";
import { presets as allPresets, putMachine } from "../../api/machines";
import type { Preset } from "../../api/types";
import { useAsked } from "../../api/use";
import { MachineView } from "../../machine3d/MachineView";
import { Choice, Form, TextField } from "../../parts/Form";
import { Card, Got, Head } from "../../parts/parts";
import { go, to } from "../../router";
import { texts } from "../../texts";

/** A new machine begins with a preset, and is then changed. */
export function NewMachine() {
  const t = texts.value.machines;
  const asked = useAsked(() => allPresets(), []);
  const [chosen, choose] = useState("ac-table");
  const [id, setId] = useState("");
  const [name, setName] = useState("");
  const create = async (preset: Preset) => {
    await putMachine(id, { ...preset.profile, name: name || preset.title }, null);
    go("machines", id);
  };
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
                <Form send={() => create(preset)} words={t.create} primary>
                  <Choice
                    label={t.preset}
                    hint={preset.description}
                    class="wide"
                    value={chosen}
                    set={choose}
                    options={items.map((one) => [one.id, one.title])}
                  />
                  <TextField label={t.id} hint={t.idHint} value={id} set={setId} required pattern="[a-z0-9][a-z0-9\-]{0,63}" />
                  <TextField label={texts.value.common.name} value={name} set={setName} placeholder={preset.title} />
                </Form>
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
