// Programs that were chosen in this tab. The service does not hand out what was uploaded, so the page keeps it.

import { signal } from "@preact/signals";

export interface Source {
  name: string;
  file: Blob;
  text: string;
}

/** By digest, so that a program is found for every job that was made from it. */
export const sources = signal<ReadonlyMap<string, Source>>(new Map());
/** Digests of programs that were chosen and are too long to be shown. */
export const tooLong = signal<ReadonlySet<string>>(new Set());
/** Larger programs are computed, but not shown. */
export const SHOWN_MB = 4;

export async function keepSource(file: Blob, name: string): Promise<string> {
  const digest = await sha256(file);
  if (file.size <= SHOWN_MB * 1e6) {
    const text = await file.text();
    sources.value = new Map(sources.value).set(digest, { name, file, text });
  } else tooLong.value = new Set(tooLong.value).add(digest);
  return digest;
}

/** SHA-256 in hexadecimal digits. Browsers have it only for addresses that they call secure, hence the second way. */
export async function sha256(file: Blob): Promise<string> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const digest = globalThis.crypto?.subtle
    ? new Uint8Array(await crypto.subtle.digest("SHA-256", bytes))
    : digestOf(bytes);
  return [...digest].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** FIPS 180-4. The constants are the fractional parts of the roots of the first primes. */
export function digestOf(message: Uint8Array): Uint8Array {
  const primes: number[] = [];
  for (let n = 2; primes.length < 64; n += 1) if (primes.every((p) => n % p !== 0)) primes.push(n);
  const part = (value: number) => ((value - Math.floor(value)) * 2 ** 32) >>> 0;
  const k = primes.map((p) => part(Math.cbrt(p)));
  const state = primes.slice(0, 8).map((p) => part(Math.sqrt(p)));
  const blocks = Math.ceil((message.length + 9) / 64);
  const padded = new Uint8Array(blocks * 64);
  padded.set(message);
  padded[message.length] = 0x80;
  const view = new DataView(padded.buffer);
  view.setUint32(padded.length - 8, Math.floor(message.length / 2 ** 29));
  view.setUint32(padded.length - 4, (message.length << 3) >>> 0);
  const w = new Uint32Array(64);
  const turn = (x: number, by: number) => (x >>> by) | (x << (32 - by));
  for (let block = 0; block < blocks; block += 1) {
    for (let i = 0; i < 16; i += 1) w[i] = view.getUint32(block * 64 + 4 * i);
    for (let i = 16; i < 64; i += 1) {
      const a = w[i - 15] as number;
      const b = w[i - 2] as number;
      const s0 = turn(a, 7) ^ turn(a, 18) ^ (a >>> 3);
      const s1 = turn(b, 17) ^ turn(b, 19) ^ (b >>> 10);
      w[i] = ((w[i - 16] as number) + s0 + (w[i - 7] as number) + s1) | 0;
    }
    let [a, b, c, d, e, f, g, h] = state as [number, number, number, number, number, number, number, number];
    for (let i = 0; i < 64; i += 1) {
      const s1 = turn(e, 6) ^ turn(e, 11) ^ turn(e, 25);
      const t1 = (h + s1 + ((e & f) ^ (~e & g)) + (k[i] as number) + (w[i] as number)) | 0;
      const t2 = ((turn(a, 2) ^ turn(a, 13) ^ turn(a, 22)) + ((a & b) ^ (a & c) ^ (b & c))) | 0;
      [h, g, f, e, d, c, b, a] = [g, f, e, (d + t1) | 0, c, b, a, (t1 + t2) | 0];
    }
    [a, b, c, d, e, f, g, h].forEach((value, i) => (state[i] = ((state[i] as number) + value) >>> 0));
  }
  const out = new DataView(new ArrayBuffer(32));
  state.forEach((value, i) => out.setUint32(4 * i, value));
  return new Uint8Array(out.buffer);
}
