import { machines as allMachines } from "../../api/machines";
import { useAsked } from "../../api/use";
import { Got, Head } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";
import { NoMachine } from "../MachineChoice";
import { MachineCard } from "./MachineCard";

export function Machines() {
  const t = texts.value;
  const asked = useAsked((signal) => allMachines(signal), []);
  return (
    <>
      <Head title={t.machines.title} lead={t.machines.lead}>
        <a class="button" href={to("machines", "+")}>
          {t.machines.add}
        </a>
      </Head>
      <h2 class="hidden">{t.machines.title}</h2>
      <Got asked={asked}>
        {({ items }) =>
          items.length === 0 ? (
            <NoMachine />
          ) : (
            <div class="cards">
              {items.map((machine) => (
                <MachineCard key={machine.machine_id} machine={machine} />
              ))}
            </div>
          )
        }
      </Got>
    </>
  );
}
