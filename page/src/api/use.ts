// Answers of the service in components.

import { useEffect, useRef, useState } from "preact/hooks";
import { Refusal } from "./client";
import { key } from "./key";
import type { Problem } from "./types";

export interface Asked<T> {
  data: T | null;
  problem: Problem | null;
  busy: boolean;
  again: () => void;
}

export const problemOf = (fault: unknown): Problem =>
  fault instanceof Refusal ? fault.problem : { type: "", title: "", status: 0, detail: String(fault) };

/** Loads when something of `deps` or the key changes. An answer that is no longer wanted is dropped. */
export function useAsked<T>(load: (signal: AbortSignal) => Promise<T>, deps: readonly unknown[]): Asked<T> {
  const [turn, setTurn] = useState(0);
  const [state, setState] = useState<{ data: T | null; problem: Problem | null; busy: boolean }>({
    data: null,
    problem: null,
    busy: true,
  });
  useEffect(() => {
    const stop = new AbortController();
    setState((old) => ({ ...old, busy: true }));
    load(stop.signal).then(
      (data) => stop.signal.aborted || setState({ data, problem: null, busy: false }),
      (fault) => stop.signal.aborted || setState({ data: null, problem: problemOf(fault), busy: false }),
    );
    return () => stop.abort();
  }, [...deps, turn, key.value]);
  return { ...state, again: () => setTurn((now) => now + 1) };
}

/** Something that a person starts: it runs once at a time, and its refusal is kept. */
export function useDoing(): { busy: boolean; problem: Problem | null; run: (work: () => Promise<void>) => void; clear: () => void } {
  const [busy, setBusy] = useState(false);
  const [problem, setProblem] = useState<Problem | null>(null);
  const running = useRef(false);
  const run = (work: () => Promise<void>) => {
    if (running.current) return;
    running.current = true;
    setBusy(true);
    setProblem(null);
    work()
      .catch((fault) => setProblem(problemOf(fault)))
      .finally(() => {
        running.current = false;
        setBusy(false);
      });
  };
  return { busy, problem, run, clear: () => setProblem(null) };
}
