import { useState } from "preact/hooks";
import { machine as machineOf, type Tagged } from "../../api/machines";
import { useAsked } from "../../api/use";
import { MachineView } from "../../machine3d/MachineView";
import { Card, Got, Head } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";
import { AxesForm } from "./AxesForm";
import { Lines } from "./Lines";
import { Profile } from "./Profile";
import { Revisions } from "./Revisions";
import { Tools } from "./Tools";

export function MachinePage({ id }: { id: string }) {
  const asked = useAsked((signal) => machineOf(id, signal), [id]);
  return (
    <>
      <p class="crumbs">
        <a href={to("machines")}>{texts.value.machines.title}</a>
      </p>
      <Got asked={asked}>
        {(tagged) => <Shown key={tagged.tag} id={id} tagged={tagged} again={asked.again} />}
      </Got>
    </>
  );
}

function Shown({ id, tagged, again }: { id: string; tagged: Tagged; again: () => void }) {
  const t = texts.value;
  const { machine, calibration } = tagged;
  const [kinematics, preview] = useState(machine.kinematics);
  return (
    <>
      <Head title={machine.name} lead={`${machine.machine_id} · ${t.common.revision(machine.revision)}`}>
        <a class="button" href={to("calibrate", id)}>
          {t.nav.calibrate}
        </a>
      </Head>
      <Card title={t.machines.kinematics} hint={t.machines.kinematicsHint}>
        <MachineView kinematics={kinematics} />
      </Card>
      <Lines machine={machine} calibration={calibration}>
        <AxesForm tagged={tagged} preview={preview} again={again} />
      </Lines>
      <div class="pair">
        <Profile tagged={tagged} again={again} />
        <div class="column">
          <Tools id={id} />
          <Revisions id={id} now={machine.revision} />
        </div>
      </div>
    </>
  );
}
