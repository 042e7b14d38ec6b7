import { ask, json, query } from "./client";
import type { Calibration, List, Machine, MachineProfile, Preset, Tool } from "./types";

export const machinePath = (id: string) => `/v1/machines/${encodeURIComponent(id)}`;

export const machines = (signal?: AbortSignal) => json<List<Machine>>("/v1/machines?limit=200", signal ? { signal } : {});

/** A machine, the tag that a change must state, and the run its errors come from. */
export interface Tagged {
  machine: Machine;
  tag: string;
  calibration: string | null;
}

export async function machine(id: string, signal?: AbortSignal): Promise<Tagged> {
  const response = await ask(machinePath(id), signal ? { signal } : {});
  return {
    machine: (await response.json()) as Machine,
    tag: response.headers.get("etag") ?? "",
    calibration: response.headers.get("trunnion-calibration"),
  };
}

export async function putMachine(id: string, profile: MachineProfile, tag: string | null): Promise<Machine> {
  const headers: Record<string, string> = tag ? { "If-Match": tag } : { "If-None-Match": "*" };
  return json<Machine>(machinePath(id), { method: "PUT", json: profile, headers });
}

/** A machine without what the service added. */
export function profileOf(machine: Machine): MachineProfile {
  const { machine_id: _id, revision: _revision, created_at: _at, ...profile } = machine;
  return profile;
}

export const presets = () => json<List<Preset>>("/v1/machine-presets");
export const revisions = (id: string) => json<List<Machine>>(`${machinePath(id)}/revisions?limit=50`);
export const tools = (id: string) => json<List<Tool>>(`${machinePath(id)}/tools?limit=200`);

export const calibrations = (id: string, limit = 50) =>
  json<List<Calibration>>(`${machinePath(id)}/calibrations${query({ limit })}`);
