// Which lines of the result come from which line of the source.

import type { Text } from "./text";

const COMMENT = /\([^)]*\)|;.*$/g;
const bare = (line: string) => line.replace(COMMENT, "").trim();
const labelOf = (line: string) => /^\s*\/?\s*(N\d+)\b/i.exec(bare(line))?.[1]?.toUpperCase() ?? "";
const placeOf = (line: string) => (bare(line).match(/[XYZABC][-+]?[\d.]+/gi) ?? []).join(" ").toUpperCase();

/** How far the beginning of a block is looked for. */
const AHEAD = 400;
const NOWHERE = 0xffff_ffff;

/** A line with what it is found by. Both are made only if the bytes differ. */
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

/** Bytes that are kept in sight, if there are so many: they hold the lines among which a block is looked for. */
const SIGHT_BYTES = 128 * 1024;
const NEWLINE = 10;
const decoder = new TextDecoder();

/** A place in a text, always at the beginning of a line. */
class Place {
  /** The same memory all the time. */
  #memory = new Uint8Array(8 * SIGHT_BYTES);
  bytes = this.#memory.subarray(0, 0);
  at = 0;
  #ended = false;
  /** The lines from here on that were decoded, and where the next one begins. */
  #seen: Line[] = [];
  #next = 0;

  constructor(private readonly parts: AsyncGenerator<Uint8Array>) {}

  get isShort(): boolean {
    return !this.#ended && this.bytes.length - this.at < SIGHT_BYTES;
  }

  async fill(): Promise<void> {
    while (this.isShort) {
      const { done, value } = await this.parts.next();
      if (done) {
        this.#ended = true;
        return;
      }
      const rest = this.bytes.subarray(this.at);
      const length = rest.length + value.length;
      const memory = length > this.#memory.length ? new Uint8Array(2 * length) : this.#memory;
      memory.set(rest);
      memory.set(value, rest.length);
      this.#memory = memory;
      this.bytes = memory.subarray(0, length);
      this.#next = Math.max(0, this.#next - this.at);
      this.at = 0;
    }
  }

  /** Where the line that begins there ends: after its newline. */
  end(from = this.at): number {
    const found = this.bytes.indexOf(NEWLINE, from);
    return found < 0 ? this.bytes.length : found + 1;
  }

  /** A line ahead of this place, or none if it is not in sight. */
  ahead(count: number): Line | undefined {
    if (this.#seen.length === 0) this.#next = this.at;
    while (this.#seen.length <= count && this.#next < this.bytes.length) {
      const end = this.end(this.#next);
      this.#seen.push(new Line(decoder.decode(this.bytes.subarray(this.#next, end)).replace(/\r?\n$/, "")));
      this.#next = end;
    }
    return this.#seen[count];
  }

  pass(lines: number): void {
    for (let line = 0; line < lines; line += 1) this.at = this.end();
    if (this.#seen.length > 0) this.#seen = this.#seen.slice(lines);
  }
}

/** Whether the same line is at both places, to the byte. */
function isSameLine(a: Place, b: Place): boolean {
  const end = a.end();
  const length = end - a.at;
  if (b.at + length > b.bytes.length) return false;
  for (let index = 0; index < length; index += 1) if (a.bytes[a.at + index] !== b.bytes[b.at + index]) return false;
  return length > 0 && (a.bytes[end - 1] === NEWLINE || b.at + length === b.bytes.length);
}

/** Lines are found by their text, by their block number, or by the place where the motion ends. */
export async function align(source: Text, result: Text, signal: AbortSignal): Promise<Alignment> {
  const starts = new Uint32Array(source.length).fill(NOWHERE);
  const isSame = new Uint8Array(result.length);
  const from = new Place(source.parts(signal));
  const to = new Place(result.parts(signal));
  /** The line of the result at its place. */
  let at = 0;
  for (let index = 0; index < source.length; index += 1, from.pass(1)) {
    if (from.isShort) await from.fill();
    if (to.isShort) await to.fill();
    if (isSameLine(from, to)) {
      starts[index] = at;
      isSame[at] = 1;
      to.pass(1);
      at += 1;
      continue;
    }
    const line = from.ahead(0);
    if (!line) break;
    let found = -1;
    for (let ahead = 0; ahead < AHEAD && found < 0; ahead += 1) {
      const other = to.ahead(ahead);
      if (!other) break;
      if (other.text === line.text || (line.label && line.label === other.label)) found = ahead;
      // The last part of a divided block: its first part is the next line that was not used.
      else if (!line.label && line.place && line.place === other.place) found = 0;
    }
    if (found < 0) continue;
    const first = to.ahead(found);
    starts[index] = at + found;
    if (first?.text === line.text) isSame[at + found] = 1;
    let past = found + 1;
    if (!line.label && line.place)
      while (past < AHEAD && to.ahead(past - 1)?.place !== line.place && to.ahead(past)) past += 1;
    to.pass(past);
    at += past;
  }
  return new Alignment(starts, isSame, result.length);
}
