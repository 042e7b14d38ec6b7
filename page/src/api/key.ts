// The API key. It is kept for this tab and this session only.

import { signal } from "@preact/signals";
import type { Problem } from "./types";

const NAME = "trunnion-key";

export const key = signal(sessionStorage.getItem(NAME) ?? "");
/** The refusal that says a key is needed. While it is set, the page asks for one. */
export const keyWanted = signal<Problem | null>(null);

export function keepKey(value: string): void {
  key.value = value.trim();
  if (key.value) sessionStorage.setItem(NAME, key.value);
  else sessionStorage.removeItem(NAME);
  keyWanted.value = null;
}
