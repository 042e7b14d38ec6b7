// Which lines of the result come from which line of the source.

const COMMENT = /\([^)]*\)|;.*$/g;
const bare = (line: string) => line.replace(COMMENT, "").trim();
const label = (line: string) => /^\s*\/?\s*(N\d+)\b/i.exec(bare(line))?.[1]?.toUpperCase() ?? null;
const place = (line: string) => (bare(line).match(/[XYZABC][-+]?[\d.]+/gi) ?? []).join(" ").toUpperCase();

/** How far the beginning of a block is looked for. */
const AHEAD = 400;

export interface Alignment {
  /** For each line of the source, the first and the last line of the result (1-based), or null. */
  of: ([number, number] | null)[];
  /** Lines of the result that are not in the source as they are. */
  changed: Set<number>;
}

/** Lines are found by their text, by their block number, or by the place where the motion ends. */
export function align(source: string[], result: string[]): Alignment {
  const starts: (number | null)[] = [];
  let at = 0;
  for (const line of source) {
    let found: number | null = null;
    const name = label(line);
    const end = place(line);
    for (let ahead = at; ahead < Math.min(result.length, at + AHEAD); ahead += 1) {
      const other = result[ahead] ?? "";
      if (other === line || (name && name === label(other))) {
        found = ahead;
        break;
      }
      if (!name && end && end === place(other)) {
        // The last part of a divided block: its first part is the next line that was not used.
        found = at;
        break;
      }
    }
    starts.push(found);
    if (found === null) continue;
    at = found + 1;
    if (!name && end) while (at < result.length && place(result[at - 1] ?? "") !== end && at - found < AHEAD) at += 1;
  }
  const of: ([number, number] | null)[] = starts.map((start, index) => {
    if (start === null) return null;
    let next: number | null = null;
    for (let ahead = index + 1; ahead < starts.length && next === null; ahead += 1) next = starts[ahead] ?? null;
    return [start + 1, Math.max(start + 1, next ?? result.length)];
  });
  const changed = new Set(result.map((_line, index) => index + 1));
  starts.forEach((start, index) => {
    if (start !== null && result[start] === source[index]) changed.delete(start + 1);
  });
  return { of, changed };
}
