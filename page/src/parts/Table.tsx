// A table that is wider than its place is moved sideways, with the keyboard too.

import type { ComponentChildren } from "preact";

export interface Column<Row> {
  head: ComponentChildren;
  /** A unit beside the head. */
  unit?: string;
  cell: (row: Row, index: number) => ComponentChildren;
  /** The name of the row. */
  names?: boolean;
  class?: "right" | "nowrap" | "num right" | "num nowrap" | "bar";
}

interface Props<Row> {
  label: string;
  columns: Column<Row>[];
  rows: Row[];
  keyOf: (row: Row, index: number) => string | number;
  /** The member of `data-…` that has the key of a row. */
  data?: string;
  class?: string;
  rowClass?: (row: Row) => string;
}

export function Table<Row>({ label, columns, rows, keyOf, data, class: kind = "list", rowClass }: Props<Row>) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label={label}>
      <table class={kind}>
        <thead>
          <tr>
            {columns.map(({ head, unit, class: of }, index) => (
              <th scope="col" key={index} class={of?.includes("right") ? "right" : ""}>
                {head}
                {unit && <span class="unit"> {unit}</span>}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map((row, at) => (
            <tr key={keyOf(row, at)} class={rowClass?.(row) ?? ""} {...(data ? { [`data-${data}`]: keyOf(row, at) } : {})}>
              {columns.map(({ cell, names, class: of = "" }, index) =>
                names ? (
                  <th scope="row" key={index} class={of}>
                    {cell(row, at)}
                  </th>
                ) : (
                  <td key={index} class={of}>
                    {cell(row, at)}
                  </td>
                ),
              )}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
