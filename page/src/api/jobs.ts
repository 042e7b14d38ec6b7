import { ask, json, query } from "./client";
import type { Job, JobState, List } from "./types";

export interface JobFilter {
  machine_id?: string;
  state?: string;
  operation?: string;
  external_id?: string;
  limit?: number;
  cursor?: string;
}

export const jobs = (filter: JobFilter, signal?: AbortSignal) =>
  json<List<Job>>(`/v1/jobs${query({ ...filter })}`, signal ? { signal } : {});
export const job = (id: string, signal?: AbortSignal) => json<Job>(`/v1/jobs/${encodeURIComponent(id)}`, signal ? { signal } : {});
export const cancel = (id: string) => json<Job>(`/v1/jobs/${id}`, { method: "DELETE" });

export async function createJob(request: object, program: File | Blob, name: string, surface?: File | null): Promise<Job> {
  const form = new FormData();
  form.append("job", JSON.stringify(request));
  form.append("program", program, name);
  if (surface) form.append("surface", surface, surface.name);
  return json<Job>("/v1/jobs", { method: "POST", body: form });
}

export const isOver = (state: JobState) => state !== "queued" && state !== "running";

interface Seen {
  state?: JobState;
  progress: number;
}

/** Follows a job until it ends: by its stream of events, or by asking again if there is no stream. */
export async function follow(id: string, see: (seen: Seen) => void, signal: AbortSignal): Promise<Job> {
  try {
    const response = await ask(`/v1/jobs/${id}/events`, { accept: "text/event-stream", signal });
    const reader = response.body?.pipeThrough(new TextDecoderStream()).getReader();
    let rest = "";
    for (;;) {
      const part = await reader?.read();
      if (!part || part.done) break;
      const events = (rest + part.value).split("\n\n");
      rest = events.pop() ?? "";
      for (const event of events) {
        const data = event.split("\n").find((line) => line.startsWith("data:"));
        if (data) see(JSON.parse(data.slice(5)) as Seen);
      }
    }
  } catch (fault) {
    if (signal.aborted) throw fault;
  }
  for (let wait_ms = 150; ; wait_ms = Math.min(2000, wait_ms * 1.5)) {
    const now = await job(id, signal);
    see(now);
    if (isOver(now.state)) return now;
    await new Promise((resolve) => setTimeout(resolve, wait_ms));
  }
}
