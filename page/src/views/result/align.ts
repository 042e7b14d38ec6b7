// Which lines of the result come from which line of the source.

import type { Text } from "./text";

const COMMENT = /\([^)]*\)|;.*$/g;
const bare = (line: string) => line.replace(COMMENT, "").trim();
const labelOf = (line: string) => /^\s*\/?\s*(N\d+)\b/i.exec(bare(line))?.[1]?.toUpperCase() ?? "";
const placeOf = (line: string) => (bare(line).match(/[XYZABC][-+]?[\d.]+/gi) ?? []).join(" ").toUpperCase();

/** How far the beginning of a block is looked for. */
const AHEAD = 400;
const NOWHERE = 0xffff_ffff;

/** A line of the result, with what it is found by. Both are made only if the text differs. */
class Line {
  #label: string | undefined;
  #place: string | undefined;
  constructor(readonly text: string) {}
  get label(): string {
    return (this.#label ??= labelOf(this.text));
  }
  get place(): string {
    return (this.#place ??= placeOf(this.text));
  }
}

export class Alignment {
  constructor(
    /** For each line of the source, the first line of the result, both from zero. */
    private readonly starts: Uint32Array,
    private readonly isSame: Uint8Array,
    private readonly lines: number,
  ) {}

  /** The first and the last line of the result (1-based) of a line of the source (1-based). */
  of(line: number): [number, number] | null {
    const start = this.starts[line - 1] ?? NOWHERE;
    if (start === NOWHERE) return null;
    let next = line;
    while (next < this.starts.length && this.starts[next] === NOWHERE) next += 1;
    return [start + 1, Math.max(start + 1, this.starts[next] ?? this.lines)];
  }

  /** The line of the source (1-based) of a line of the result (1-based). */
  back(line: number): number | null {
    // Starts grow, but for lines that are nowhere.
    let low = 0;
    let high = this.starts.length;
    while (low < high) {
      const middle = (low + high) >>> 1;
      let known = middle;
      while (known > low && this.starts[known] === NOWHERE) known -= 1;
      if ((this.starts[known] ?? NOWHERE) === NOWHERE) low = middle + 1;
      else if ((this.starts[known] as number) <= line - 1) low = middle + 1;
      else high = known;
    }
    while (low > 0 && this.starts[low - 1] === NOWHERE) low -= 1;
    return low > 0 ? low : null;
  }

  /** Whether a line of the result (1-based) is not in the source as it is. */
  changed(line: number): boolean {
    return this.isSame[line - 1] !== 1;
  }
}

/** Lines are found by their text, by their block number, or by the place where the motion ends. */
export async function align(source: Text, result: Text, signal: AbortSignal): Promise<Alignment> {
  const starts = new Uint32Array(source.length).fill(NOWHERE);
  const isSame = new Uint8Array(result.length);
  const coming = result.batches(signal);
  /** Lines of the result from `at` on. */
  let window: Line[] = [];
  let used = 0;
  let at = 0;
  let ended = false;
  const fill = async () => {
    window = window.slice(used);
    used = 0;
    while (!ended && window.length <= 2 * AHEAD) {
      const next = await coming.next();
      if (next.done) ended = true;
      else window = window.concat(next.value.map((text) => new Line(text)));
    }
  };
  let index = -1;
  for await (const batch of source.batches(signal)) {
    for (const text of batch) {
      index += 1;
      if (!ended && window.length - used <= 2 * AHEAD) await fill();
      const line = new Line(text);
      const most = Math.min(window.length - used, AHEAD);
      let found = -1;
      for (let ahead = 0; ahead < most && found < 0; ahead += 1) {
        const other = window[used + ahead] as Line;
        if (other.text === text || (line.label && line.label === other.label)) found = ahead;
        // The last part of a divided block: its first part is the next line that was not used.
        else if (!line.label && line.place && line.place === other.place) found = 0;
      }
      if (found < 0) continue;
      const first = window[used + found] as Line;
      starts[index] = at + found;
      if (first.text === text) isSame[at + found] = 1;
      let past = found + 1;
      if (!line.label && line.place) while (past < most && window[used + past - 1]?.place !== line.place) past += 1;
      used += past;
      at += past;
    }
  }
  return new Alignment(starts, isSame, result.length);
}
