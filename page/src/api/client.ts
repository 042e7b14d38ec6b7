// One request to the service, and its refusals as problems.

import { key, keyWanted } from "./key";
import type { Problem } from "./types";

/** A request that the service refused, or that did not reach it (status 0). */
export class Refusal extends Error {
  constructor(readonly problem: Problem) {
    super(problem.detail);
  }
}

export interface Asking {
  method?: string;
  body?: BodyInit;
  json?: unknown;
  accept?: string;
  headers?: Record<string, string>;
  signal?: AbortSignal;
}

export async function ask(path: string, asking: Asking = {}): Promise<Response> {
  const headers: Record<string, string> = { Accept: asking.accept ?? "application/json", ...asking.headers };
  if (key.value) headers["Authorization"] = `Bearer ${key.value}`;
  if (asking.json !== undefined) headers["Content-Type"] = "application/json";
  const body = asking.json === undefined ? asking.body : JSON.stringify(asking.json);
  let response: Response;
  try {
    response = await fetch(path, {
      method: asking.method ?? "GET",
      headers,
      ...(body === undefined ? {} : { body }),
      ...(asking.signal ? { signal: asking.signal } : {}),
      cache: "no-cache",
    });
  } catch (fault) {
    if (asking.signal?.aborted) throw fault;
    throw new Refusal({ type: "", title: "", status: 0, detail: String(fault) });
  }
  if (response.ok) return response;
  const problem = await problemOf(response);
  if (response.status === 401) keyWanted.value = problem;
  throw new Refusal(problem);
}

async function problemOf(response: Response): Promise<Problem> {
  const text = await response.text();
  try {
    const problem = JSON.parse(text) as Problem;
    if (typeof problem.title === "string") return problem;
  } catch {
    // Not from the service: a proxy between.
  }
  return { type: "", title: `${response.status} ${response.statusText}`, status: response.status, detail: text.slice(0, 300) };
}

export async function json<T>(path: string, asking?: Asking): Promise<T> {
  return (await ask(path, asking)).json() as Promise<T>;
}

export async function textOf(path: string, asking?: Asking): Promise<string> {
  return (await ask(path, { accept: "text/plain", ...asking })).text();
}

/** A query of those parameters that have a value. */
export function query(values: Record<string, string | number | null | undefined>): string {
  const given = Object.entries(values).filter(([, value]) => value !== undefined && value !== null && value !== "");
  return given.length ? `?${new URLSearchParams(given.map(([name, value]) => [name, String(value)]))}` : "";
}

/** Lets the browser save an answer of the service as a file. */
export async function download(path: string, accept: string, name: string): Promise<void> {
  const blob = await (await ask(path, { accept })).blob();
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
