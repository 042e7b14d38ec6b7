import { useState } from "preact/hooks";
import { json } from "../../api/client";
import { machinePath } from "../../api/machines";
import type { Calibration } from "../../api/types";
import { useDoing } from "../../api/use";
import { ProblemBox } from "../../parts/Problem";
import { go } from "../../router";
import { texts } from "../../texts";
import example from "../../../../docs/examples/ballbar.json";

export function Upload({ id }: { id: string }) {
  const t = texts.value.calibrate;
  const doing = useDoing();
  const [wrong, setWrong] = useState(false);
  const post = (run: unknown) =>
    doing.run(async () => {
      const made = await json<Calibration>(`${machinePath(id)}/calibrations`, { method: "POST", json: run });
      go("calibrate", id, made.id);
    });
  const choose = async (file: File | undefined) => {
    setWrong(false);
    if (!file) return;
    try {
      post(JSON.parse(await file.text()));
    } catch {
      setWrong(true);
    }
  };
  return (
    <div class="upload noprint">
      <div class="row">
        <label class="filebutton">
          {t.upload}
          <input type="file" accept=".json,application/json" onChange={(event) => void choose(event.currentTarget.files?.[0])} />
        </label>
        <button type="button" disabled={doing.busy} onClick={() => post(example)}>
          {t.example}
        </button>
      </div>
      {wrong && (
        <p class="fault" role="alert">
          {t.notJson}
        </p>
      )}
      {doing.problem && <ProblemBox problem={doing.problem} />}
    </div>
  );
}
