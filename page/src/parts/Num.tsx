interface Props {
  value: number | null | undefined;
  unit?: string;
  text?: (value: number) => string;
}

import { short } from "./format";

/** A number of an answer. `data-value` and the tooltip have it with every digit. */
export function Num({ value, unit = "", text = short }: Props) {
  if (value === null || value === undefined) return <span class="num none">–</span>;
  return (
    <span class="num" data-value={value} title={`${value}${unit && ` ${unit}`}`}>
      {text(value)}
      {unit && <span class="unit"> {unit}</span>}
    </span>
  );
}
