// A new run: from a file, or entered by hand. Both are looked at before they are stored.

import { useState } from "preact/hooks";
import type { Machine } from "../../api/types";
import { Card } from "../../parts/parts";
import { texts } from "../../texts";
import example from "../../../../docs/examples/ballbar.json";
import { forget, type RunRequest } from "./draft";
import { EnterRun } from "./EnterRun";
import { Preview } from "./Preview";

export function NewRun({ machine }: { machine: Machine }) {
  const t = texts.value.calibrate;
  const [wrong, setWrong] = useState(false);
  const [enters, setEnters] = useState(false);
  const [run, setRun] = useState<RunRequest | null>(null);
  const look = (from: unknown) => {
    setWrong(false);
    setRun(from as RunRequest);
  };
  const choose = async (file: File | undefined) => {
    if (!file) return;
    try {
      const read: unknown = JSON.parse(await file.text());
      if (read === null || typeof read !== "object" || Array.isArray(read)) throw new TypeError("no run");
      look(read);
    } catch {
      setRun(null);
      setWrong(true);
    }
  };
  const end = () => {
    forget();
    setRun(null);
    setEnters(false);
  };
  if (run) return <Preview id={machine.machine_id} run={run} stored={end} cancel={() => setRun(null)} />;
  if (enters) return <EnterRun machine={machine} preview={look} cancel={() => setEnters(false)} />;
  return (
    <Card title={t.newRun} class="upload noprint">
      <div class="row">
        <label class="filebutton">
          {t.upload}
          <input type="file" accept=".json,application/json" onChange={(event) => void choose(event.currentTarget.files?.[0])} />
        </label>
        <button type="button" class="byhand" onClick={() => setEnters(true)}>
          {t.enter}
        </button>
        <button type="button" onClick={() => look(example)}>
          {t.example}
        </button>
      </div>
      {wrong && (
        <p class="fault" role="alert">
          {t.notJson}
        </p>
      )}
    </Card>
  );
}
