// Readings as a table of fields. A block of cells from a spreadsheet is pasted at any field.

import { useRef } from "preact/hooks";
import { read } from "../../parts/parts";
import { Table } from "../../parts/Table";
import { texts } from "../../texts";
import { cellsOf, isEmpty } from "./draft";

interface Props {
  label: string;
  heads: { name: string; unit: string }[];
  rows: string[][];
  set: (rows: string[][]) => void;
}

export function Readings({ label, heads, rows, set }: Props) {
  const t = texts.value.calibrate;
  const place = useRef<HTMLDivElement>(null);
  const columns = heads.length;
  const empty = () => heads.map(() => "");
  // The last row is always free, so that there is a place to go on.
  const last = rows.at(-1);
  const shown = last && isEmpty(last) ? rows : [...rows, empty()];
  const keep = (next: string[][]) => {
    const end = next.findLastIndex((row) => !isEmpty(row));
    set(next.slice(0, end + 1));
  };
  const put = (row: number, column: number, cells: string[][]) => {
    const next = shown.map((old) => [...old]);
    cells.forEach((values, down) => {
      const target = (next[row + down] ??= empty());
      values.slice(0, columns - column).forEach((value, right) => (target[column + right] = value));
    });
    keep(next);
  };
  const go = (row: number, column: number) =>
    place.current?.querySelector<HTMLInputElement>(`[data-cell="${row} ${column}"]`)?.focus();
  return (
    <div class="readings" ref={place}>
      <Table
        label={label}
        class="list numeric"
        rows={shown}
        keyOf={(_row, at) => at}
        columns={[
          { head: <span class="hidden">{t.row}</span>, cell: (_row, at) => at + 1, names: true },
          ...heads.map(({ name, unit }, column) => ({
            head: name,
            unit,
            cell: (row: string[], at: number) => {
              const value = row[column] ?? "";
              const isWrong = value.trim() !== "" && read(value) === undefined;
              return (
                <input
                  type="text"
                  inputMode="decimal"
                  autocomplete="off"
                  data-cell={`${at} ${column}`}
                  aria-label={`${label}, ${t.rowOf(at + 1)}, ${name} ${unit}`}
                  aria-invalid={isWrong ? "true" : "false"}
                  value={value}
                  onInput={(event) => put(at, column, [[event.currentTarget.value]])}
                  onPaste={(event) => {
                    const text = event.clipboardData?.getData("text") ?? "";
                    const cells = cellsOf(text, columns - column);
                    // A single value goes where the cursor is, as in any field.
                    if (cells.length < 2 && (cells[0]?.length ?? 0) < 2) return;
                    event.preventDefault();
                    put(at, column, cells);
                  }}
                  onKeyDown={(event) => {
                    const step = { ArrowUp: -1, ArrowDown: 1, Enter: 1 }[event.key];
                    if (step === undefined) return;
                    event.preventDefault();
                    go(at + step, column);
                  }}
                />
              );
            },
          })),
        ]}
      />
      <div class="row">
        <span class="hint">{t.count(rows.filter((row) => !isEmpty(row)).length)}</span>
        {rows.length > 0 && (
          <button type="button" onClick={() => set([])}>
            {t.clear}
          </button>
        )}
      </div>
    </div>
  );
}
