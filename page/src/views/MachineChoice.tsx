// The machine that a view is about: chosen in its head, kept in the address.

import type { ComponentChildren } from "preact";
import { machines as allMachines } from "../api/machines";
import type { Machine } from "../api/types";
import { useAsked } from "../api/use";
import { Empty, Field, Got } from "../parts/parts";
import { go } from "../router";
import { texts } from "../texts";

interface Props {
  view: string;
  chosen: string | undefined;
  children: (machine: Machine) => ComponentChildren;
}

/** Without a machine in the address: one that is in use, else the first. */
export function MachineChoice({ view, chosen, children }: Props) {
  const t = texts.value;
  const asked = useAsked((signal) => allMachines(signal), []);
  return (
    <Got asked={asked}>
      {({ items }) => {
        const machine = items.find((one) => one.machine_id === chosen) ?? items[0];
        if (!machine) return <Empty what={t.overview.noMachines} />;
        return (
          <>
            {items.length > 1 && (
              <div class="fields choice noprint">
                <Field label={t.common.machine}>
                  <select value={machine.machine_id} onChange={(event) => go(view, event.currentTarget.value)}>
                    {items.map((one) => (
                      <option key={one.machine_id} value={one.machine_id}>
                        {one.name} ({one.machine_id})
                      </option>
                    ))}
                  </select>
                </Field>
              </div>
            )}
            {children(machine)}
          </>
        );
      }}
    </Got>
  );
}
