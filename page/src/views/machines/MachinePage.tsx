import { machine as machineOf } from "../../api/machines";
import { useAsked } from "../../api/use";
import { MachineView } from "../../machine3d/MachineView";
import { Card, Got, Head } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";
import { Lines } from "./Lines";
import { Profile } from "./Profile";
import { Revisions } from "./Revisions";
import { Tools } from "./Tools";

export function MachinePage({ id }: { id: string }) {
  const t = texts.value;
  const asked = useAsked((signal) => machineOf(id, signal), [id]);
  return (
    <>
      <p class="crumbs">
        <a href={to("machines")}>{t.machines.title}</a>
      </p>
      <Got asked={asked}>
        {(tagged) => (
          <>
            <Head
              title={tagged.machine.name}
              lead={`${tagged.machine.machine_id} · ${t.common.revision(tagged.machine.revision)}`}
            >
              <a class="button" href={to("calibrate", id)}>
                {t.nav.calibrate}
              </a>
            </Head>
            <Card title={t.machines.kinematics} hint={t.machines.kinematicsHint}>
              <MachineView kinematics={tagged.machine.kinematics} />
            </Card>
            <Lines machine={tagged.machine} calibration={tagged.calibration} />
            <div class="pair">
              <Profile key={tagged.tag} tagged={tagged} again={asked.again} />
              <div class="column">
                <Tools id={id} />
                <Revisions id={id} now={tagged.machine.revision} />
              </div>
            </div>
          </>
        )}
      </Got>
    </>
  );
}
