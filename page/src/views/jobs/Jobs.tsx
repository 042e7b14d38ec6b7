// The list of jobs. It asks again while it is looked at.

import { useEffect, useState } from "preact/hooks";
import { jobs as jobsOf } from "../../api/jobs";
import { machines as allMachines } from "../../api/machines";
import { OPERATIONS, STATES } from "../../api/types";
import { useAsked } from "../../api/use";
import { usePictures } from "../../machine3d/ready";
import { Choice, TextField } from "../../parts/Form";
import { Card, Empty, Got, Head } from "../../parts/parts";
import { texts } from "../../texts";
import { JobTable } from "./JobTable";

const EVERY_MS = 3000;
const PAGE = 50;

export function Jobs() {
  const t = texts.value;
  usePictures();
  const [filter, setFilter] = useState({ state: "", operation: "", machine_id: "", external_id: "" });
  const [cursors, setCursors] = useState<string[]>([]);
  const cursor = cursors.at(-1);
  const asked = useAsked(
    (signal) => jobsOf({ ...filter, limit: PAGE, ...(cursor ? { cursor } : {}) }, signal),
    [JSON.stringify(filter), cursor],
  );
  const machines = useAsked((signal) => allMachines(signal), []);
  useEffect(() => {
    const timer = setInterval(() => document.visibilityState === "visible" && !cursor && !asked.problem && asked.again(), EVERY_MS);
    return () => clearInterval(timer);
  }, [cursor, asked.problem]);
  const set = (change: Partial<typeof filter>) => {
    setCursors([]);
    setFilter({ ...filter, ...change });
  };
  const choice = (label: string, name: "state" | "operation" | "machine_id", options: [string, string][]) => (
    <Choice label={label} value={filter[name]} set={(value) => set({ [name]: value })} options={[["", t.jobs.all], ...options]} />
  );
  return (
    <>
      <Head title={t.jobs.title} lead={t.jobs.lead} />
      <Card>
        <div class="fields filters">
          {choice(t.common.state, "state", STATES.map((state) => [state, t.states[state]]))}
          {choice(t.jobs.operation, "operation", OPERATIONS.map((operation) => [operation, t.operations[operation]]))}
          {choice(t.common.machine, "machine_id", (machines.data?.items ?? []).map((one) => [one.machine_id, one.machine_id]))}
          <TextField
            label={t.jobs.reference}
            hint={t.jobs.referenceHint}
            type="search"
            value={filter.external_id}
            set={(external_id) => set({ external_id })}
          />
        </div>
        <Got asked={asked}>
          {({ items, next_cursor }) => (
            <>
              {items.length === 0 ? <Empty what={t.jobs.none} /> : <JobTable jobs={items} />}
              <div class="row pages">
                {cursors.length > 0 && (
                  <button type="button" onClick={() => setCursors([])}>
                    {t.common.newest}
                  </button>
                )}
                {next_cursor && (
                  <button type="button" onClick={() => setCursors([...cursors, next_cursor])}>
                    {t.common.older}
                  </button>
                )}
              </div>
            </>
          )}
        </Got>
      </Card>
    </>
  );
}
