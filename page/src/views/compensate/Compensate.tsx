// From a program to its compensated form.

import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { cancel, createJob, follow } from "../../api/jobs";
import { machines as allMachines, tools as toolsOf } from "../../api/machines";
import type { Job, Tool } from "../../api/types";
import { problemOf, useAsked, useDoing } from "../../api/use";
import { usePictures } from "../../machine3d/ready";
import { Got, Head, State } from "../../parts/parts";
import { NoMachine } from "../MachineChoice";
import { ProblemBox } from "../../parts/Problem";
import { to } from "../../router";
import { texts } from "../../texts";
import { JobResult } from "../result/JobResult";
import { ProgramText } from "../result/ProgramText";
import { keepSource } from "../result/sources";
import { ofFile, Text } from "../result/text";
import { Drop } from "./Drop";
import { ProgramForm } from "./ProgramForm";
import { EMPTY, type Entered, faultsOf, requestOf } from "./request";

/** What is filled in stays while other views are looked at. */
export const entered = signal<Entered>(EMPTY);
export const program = signal<File | null>(null);
const surface = signal<File | null>(null);
export const done = signal<Job | null>(null);

interface Way {
  state: string;
  progress: number;
}

export function Compensate() {
  const t = texts.value.compensate;
  usePictures();
  const asked = useAsked((stop) => allMachines(stop), []);
  const doing = useDoing();
  const [way, setWay] = useState<Way | null>(null);
  const [running, setRunning] = useState<string | null>(null);
  const [tools, setTools] = useState<Tool[]>([]);
  const [hint, setHint] = useState("");
  const result = useRef<HTMLDivElement>(null);
  const left = useRef(new AbortController());
  useEffect(() => {
    left.current = new AbortController();
    return () => left.current.abort();
  }, []);
  const items = asked.data?.items ?? [];
  const machine = entered.value.machine || items[0]?.machine_id || "";
  useEffect(() => {
    if (machine) toolsOf(machine).then(({ items: found }) => setTools(found), () => setTools([]));
  }, [machine]);
  const set = (change: Partial<Entered>) => {
    setHint("");
    entered.value = { ...entered.value, ...change };
  };
  const job = done.value;
  const refusal = doing.problem ?? (job?.state === "failed" ? (job.problem ?? null) : null);
  const start = () => {
    const file = program.value;
    const now = { ...entered.value, machine };
    if (!file) return setHint(t.needProgram);
    if (!now.cc && !now.location && !now.wear) return setHint(t.needStep);
    setHint("");
    doing.run(async () => {
      done.value = null;
      setWay({ state: "sending", progress: 0 });
      try {
        const made = await createJob(requestOf(now), file, file.name, surface.value);
        keepSource(made.input_sha256, file);
        setRunning(made.id);
        const ended = await follow(
          made.id,
          (seen) => setWay((old) => ({ state: seen.state ?? old?.state ?? "running", progress: seen.progress })),
          left.current.signal,
        );
        done.value = ended;
        if (ended.state === "succeeded") requestAnimationFrame(() => result.current?.scrollIntoView({ block: "start" }));
      } finally {
        setWay(null);
        setRunning(null);
      }
    });
  };
  const reset = () => {
    done.value = null;
    program.value = null;
    surface.value = null;
    entered.value = EMPTY;
    doing.clear();
  };
  return (
    <>
      <Head title={t.title} lead={t.lead}>
        {(job || program.value) && (
          <button type="button" class="noprint" onClick={reset}>
            {t.reset}
          </button>
        )}
      </Head>
      <Got asked={asked}>
        {() =>
          items.length === 0 ? (
            <NoMachine />
          ) : (
            <form
              class="compensate noprint"
              onSubmit={(event) => {
                event.preventDefault();
                start();
              }}
            >
              <div class="column">
                <Drop
                  file={program.value}
                  choose={(file) => {
                    program.value = file;
                    done.value = null;
                    doing.clear();
                    setHint("");
                  }}
                />
                <div class="go">
                  <button type="submit" class="primary large" disabled={doing.busy}>
                    {t.start}
                  </button>
                  {hint && (
                    <p class="fault" role="alert">
                      {hint}
                    </p>
                  )}
                  {way && <Progress way={way} />}
                  {running && (
                    <button type="button" onClick={() => void cancel(running).catch((fault) => problemOf(fault))}>
                      {texts.value.common.cancel}
                    </button>
                  )}
                </div>
                {refusal && <ProblemBox problem={refusal} />}
                {refusal?.line && program.value && <Where file={program.value} line={refusal.line} />}
              </div>
              <div class="column">
                <ProgramForm
                  entered={{ ...entered.value, machine }}
                  set={set}
                  machines={items}
                  tools={tools}
                  faults={faultsOf(refusal)}
                  surface={surface.value}
                  setSurface={(file) => (surface.value = file)}
                />
              </div>
            </form>
          )
        }
      </Got>
      <div ref={result} class="results" aria-live="polite">
        {job?.state === "succeeded" && (
          <>
            <div class="row resulthead">
              <h2>{program.value?.name ?? texts.value.operations[job.operation]}</h2>
              <State state={job.state} />
              <a href={to("jobs", job.id)}>{t.openJob}</a>
            </div>
            <JobResult job={job} />
          </>
        )}
      </div>
    </>
  );
}

function Progress({ way }: { way: Way }) {
  const t = texts.value.compensate;
  const words =
    way.state === "sending" ? t.sending : way.state === "queued" ? t.waiting : t.computing(Math.round(100 * way.progress));
  return (
    <div class="progress" role="status">
      <progress max={1} {...(way.state === "running" ? { value: way.progress } : {})} aria-label={words} />
      <span class="hint">{words}</span>
    </div>
  );
}

/** The refused program at the line of its fault. */
function Where({ file, line }: { file: File; line: number }) {
  const asked = useAsked((signal) => Text.of(ofFile(file), signal), [file]);
  if (!asked.data) return null;
  return (
    <div class="where">
      <ProgramText label={file.name} text={asked.data} focus={[line, line]} />
    </div>
  );
}
