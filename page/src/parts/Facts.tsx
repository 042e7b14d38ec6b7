import type { ComponentChildren } from "preact";

export interface Fact {
  name: ComponentChildren;
  value: ComponentChildren;
  /** The member of the answer that it shows. */
  row?: string;
  /** It has the width of the place. */
  long?: boolean;
}

/** Names with their values. The caller leaves out a fact without a value. */
export function Facts({ facts, class: kind = "" }: { facts: (Fact | false | null | undefined | "" | 0)[]; class?: string }) {
  const shown = facts.filter((fact): fact is Fact => Boolean(fact));
  return (
    <dl class={`facts ${kind}`}>
      {shown.map(({ name, value, row, long }, index) => (
        <div key={row ?? index} class={long ? "long" : ""} {...(row ? { "data-row": row } : {})}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}
