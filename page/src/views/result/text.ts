// The text of a program, wherever its bytes are: in a file of this computer, or with the service. Only the parts that
// are looked at are in memory, so a program of a million blocks costs no more than a short one.

import { ask } from "../../api/client";

export interface Bytes {
  /** From the first to before the last. */
  part(from: number, until: number): Promise<Uint8Array>;
  all(signal: AbortSignal): Promise<ReadableStream<Uint8Array>>;
}

export const ofFile = (file: Blob): Bytes => ({
  part: async (from, until) => new Uint8Array(await file.slice(from, until).arrayBuffer()),
  all: async () => file.stream() as ReadableStream<Uint8Array>,
});

export function ofJob(id: string): Bytes {
  const path = `/v1/jobs/${id}/program`;
  const accept = "text/plain";
  return {
    part: async (from, until) => {
      const answer = await ask(path, { accept, headers: { Range: `bytes=${from}-${until - 1}` } });
      return new Uint8Array(await answer.arrayBuffer());
    },
    all: async (signal) => (await ask(path, { accept, signal })).body ?? new Blob().stream(),
  };
}

/** The place of every so many lines is kept. */
const STEP = 512;
/** Parts that are kept after they were looked at. */
const KEPT = 12;
const NEWLINE = 10;
const decoder = new TextDecoder();

/** The text that is read now. */
let last: Promise<unknown> = Promise.resolve();

export class Text {
  #kept = new Map<number, Promise<string[]>>();

  private constructor(
    readonly bytes: Bytes,
    readonly length: number,
    readonly size: number,
    readonly starts: number[],
  ) {}

  /** Reads the bytes once to find where the lines are: one text after the other, so that their memory does not add up. */
  static of(bytes: Bytes, signal: AbortSignal): Promise<Text> {
    const turn = last.then(() => Text.#of(bytes, signal));
    last = turn.catch(() => undefined);
    return turn;
  }

  static async #of(bytes: Bytes, signal: AbortSignal): Promise<Text> {
    const starts = [0];
    let lines = 0;
    let size = 0;
    let end = NEWLINE;
    for await (const part of partsOf(await bytes.all(signal), signal)) {
      for (let at = part.indexOf(NEWLINE); at >= 0; at = part.indexOf(NEWLINE, at + 1)) {
        lines += 1;
        if (lines % STEP === 0) starts.push(size + at + 1);
      }
      size += part.length;
      end = part.at(-1) ?? end;
    }
    return new Text(bytes, end === NEWLINE ? lines : lines + 1, size, starts);
  }

  /** The lines of a range, counted from zero. */
  async lines(from: number, until: number): Promise<string[]> {
    const first = Math.floor(from / STEP);
    const parts: Promise<string[]>[] = [];
    for (let index = first; index * STEP < until; index += 1) parts.push(this.#part(index));
    return (await Promise.all(parts)).flat().slice(from - first * STEP, until - first * STEP);
  }

  #part(index: number): Promise<string[]> {
    let part = this.#kept.get(index);
    this.#kept.delete(index);
    part ??= this.#read(index);
    this.#kept.set(index, part);
    for (const old of this.#kept.keys()) {
      if (this.#kept.size <= KEPT) break;
      this.#kept.delete(old);
    }
    return part;
  }

  async #read(index: number): Promise<string[]> {
    const from = this.starts[index] ?? this.size;
    const until = this.starts[index + 1] ?? this.size;
    if (from >= until) return [];
    try {
      return linesOf(decoder.decode(await this.bytes.part(from, until)));
    } catch (fault) {
      // It is asked for again when it is looked at again.
      this.#kept.delete(index);
      throw fault;
    }
  }

  /** All bytes in their order. A part is to be used before the next is asked for. */
  async *parts(signal: AbortSignal): AsyncGenerator<Uint8Array> {
    yield* partsOf(await this.bytes.all(signal), signal);
  }
}

const linesOf = (text: string) => text.replace(/\r?\n$/, "").split(/\r?\n/);

/** A part is to be used before the next is asked for: all have the same memory, where the browser can do that. */
export async function* partsOf(stream: ReadableStream<Uint8Array>, signal?: AbortSignal): AsyncGenerator<Uint8Array> {
  const reader = readerOf(stream);
  try {
    for (let next = await reader.read(); !next.done; next = await reader.read()) {
      signal?.throwIfAborted();
      yield next.value;
    }
  } finally {
    void reader.cancel().catch(() => undefined);
  }
}

const PART_BYTES = 256 * 1024;

interface Reader {
  read(): Promise<{ done: true } | { done: false; value: Uint8Array }>;
  cancel(): Promise<void>;
}

function readerOf(stream: ReadableStream<Uint8Array>): Reader {
  let reader: ReadableStreamBYOBReader;
  try {
    reader = stream.getReader({ mode: "byob" });
  } catch {
    return stream.getReader() as Reader;
  }
  let memory = new ArrayBuffer(PART_BYTES);
  return {
    read: async () => {
      const { done, value } = await reader.read(new Uint8Array(memory));
      if (value) memory = value.buffer;
      return done || !value ? { done: true } : { done, value };
    },
    cancel: () => reader.cancel(),
  };
}
