// The machine that a view is about: chosen in its head, kept in the address.

import type { ComponentChildren } from "preact";
import { machines as allMachines } from "../api/machines";
import type { Machine } from "../api/types";
import { useAsked } from "../api/use";
import { Choice } from "../parts/Form";
import { Empty, Got } from "../parts/parts";
import { go, to } from "../router";
import { texts } from "../texts";

interface Props {
  view: string;
  chosen: string | undefined;
  children: (machine: Machine) => ComponentChildren;
}

/** Machines to choose from: their names, with their ids. */
export const namesOf = (machines: Machine[]) =>
  machines.map(({ machine_id, name }) => [machine_id, `${name} (${machine_id})`] as const);

/** Said where nothing can be done without a machine. */
export function NoMachine() {
  const t = texts.value;
  return (
    <Empty what={t.overview.noMachines}>
      <a class="button" href={to("machines", "+")}>
        {t.machines.add}
      </a>
    </Empty>
  );
}

/** Without a machine in the address: one that is in use, else the first. */
export function MachineChoice({ view, chosen, children }: Props) {
  const t = texts.value;
  const asked = useAsked((signal) => allMachines(signal), []);
  return (
    <Got asked={asked}>
      {({ items }) => {
        const machine = items.find((one) => one.machine_id === chosen) ?? items[0];
        if (!machine) return <NoMachine />;
        return (
          <>
            {items.length > 1 && (
              <div class="fields choice noprint">
                <Choice
                  label={t.common.machine}
                  value={machine.machine_id}
                  set={(next) => go(view, next)}
                  options={namesOf(items)}
                />
              </div>
            )}
            {children(machine)}
          </>
        );
      }}
    </Got>
  );
}
