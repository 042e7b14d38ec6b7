// Programs that were chosen in this tab. The service does not hand out what was uploaded, so the page keeps the file.

import { signal } from "@preact/signals";
import { sha256 } from "./sha256";

/** By digest, so that a program is found for every job that was made from it. */
export const sources = signal<ReadonlyMap<string, Blob>>(new Map());

/** Keeps a file under its digest, which the service states for the program of a job. */
export function keepSource(digest: string, file: Blob): void {
  sources.value = new Map(sources.value).set(digest, file);
}

/** Keeps a file if it has this digest. */
export async function keepIf(digest: string, file: Blob): Promise<boolean> {
  const is = (await sha256(file)) === digest;
  if (is) keepSource(digest, file);
  return is;
}
