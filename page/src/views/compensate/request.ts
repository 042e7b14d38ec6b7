// What a person filled in, as the request of a job. Empty fields are not sent: the service asks for them.

import type { Operation, Problem } from "../../api/types";
import { read } from "../../parts/parts";

export interface Entered {
  machine: string;
  cc: boolean;
  location: boolean;
  wear: boolean;
  byRadius: boolean;
  radius: string;
  corner: string;
  worn: string;
  contact: string;
  tolerance: string;
  offset: [string, string, string];
  unit: string;
  dialect: string;
  length: string;
  feed: string;
  toolNumber: string;
  reference: string;
}

export const EMPTY: Entered = {
  machine: "",
  cc: true,
  location: false,
  wear: false,
  byRadius: false,
  radius: "",
  corner: "",
  worn: "",
  contact: "auto",
  tolerance: "10",
  offset: ["", "", ""],
  unit: "",
  dialect: "auto",
  length: "",
  feed: "",
  toolNumber: "",
  reference: "",
};

/** Without members that have no value. */
const given = <T extends object>(from: T): Partial<T> | undefined => {
  const kept = Object.entries(from).filter(([, value]) => value !== undefined && value !== "");
  return kept.length > 0 ? (Object.fromEntries(kept) as Partial<T>) : undefined;
};

export function requestOf(entered: Entered): object {
  const offset = entered.offset.map(read);
  const shared = {
    work_offset_mm: offset.every((value) => value !== undefined) ? offset : undefined,
    unit: entered.unit,
    dialect: entered.dialect === "auto" ? undefined : entered.dialect,
    tool_length_mm: read(entered.length),
    feed_mm_per_min: read(entered.feed),
    tool_number: read(entered.toolNumber),
  };
  const radius = entered.byRadius ? read(entered.radius) : undefined;
  const corner = entered.byRadius ? read(entered.corner) : undefined;
  const cutter = { tool_radius_mm: radius, corner_radius_mm: corner };
  const contact = entered.contact;
  const tolerance_um = read(entered.tolerance);
  const onlyPath = entered.cc && !entered.location && !entered.wear;
  const operation: Operation = onlyPath ? "cc-compensation" : "compensation";
  const worn = read(entered.worn);
  const parameters = onlyPath
    ? { ...shared, ...cutter, contact, tolerance_um }
    : {
        ...shared,
        cc: entered.cc ? { ...given({ ...cutter, contact, tolerance_um }) } : undefined,
        location_errors: entered.location ? true : undefined,
        wear: entered.wear
          ? {
              ...given({
                nominal_tool: radius === undefined ? undefined : given({ radius_mm: radius, corner_radius_mm: corner }),
                actual_tool:
                  worn === undefined
                    ? undefined
                    : given({
                        radius_mm: worn,
                        corner_radius_mm: corner === undefined || radius === undefined ? undefined : Math.max(0, corner - radius + worn),
                      }),
                contact,
              }),
            }
          : undefined,
      };
  return {
    ...given({ external_id: entered.reference }),
    machine_id: entered.machine,
    operation,
    parameters: given(parameters) ?? {},
  };
}

/** The field of the form that a fault points at. */
const FIELDS: [RegExp, string][] = [
  [/work_offset/, "offset"],
  [/actual_tool/, "worn"],
  [/(tool_radius|nominal_tool|\/tool$)/, "tool"],
  [/corner_radius/, "corner"],
  [/tolerance/, "tolerance"],
  [/unit$/, "unit"],
  [/tool_length/, "length"],
  [/tool_number/, "toolNumber"],
  [/feed/, "feed"],
  [/contact/, "contact"],
  [/dialect/, "dialect"],
  [/machine_id/, "machine"],
];

export function faultsOf(problem: Problem | null | undefined): Record<string, string> {
  const faults: Record<string, string> = {};
  for (const fault of problem?.errors ?? []) {
    const field = FIELDS.find(([pattern]) => pattern.test(fault.pointer))?.[1];
    if (field && !faults[field]) faults[field] = fault.detail;
  }
  return faults;
}
