// Brings the errors of a run into the machine. Going back is applying an earlier run.

import { useEffect, useRef, useState } from "preact/hooks";
import { json } from "../../api/client";
import { machinePath, type Tagged } from "../../api/machines";
import type { Calibration, Machine } from "../../api/types";
import { useDoing } from "../../api/use";
import { daysSince } from "../../parts/format";
import { Card } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";

interface Props {
  tagged: Tagged;
  run: Calibration;
  again: () => void;
}

export function Apply({ tagged, run, again }: Props) {
  const t = texts.value.calibrate;
  const dialog = useRef<HTMLDialogElement>(null);
  const doing = useDoing();
  const [done, setDone] = useState<number | null>(null);
  const isApplied = tagged.calibration === run.id;
  // Ids grow with time: one that is smaller was stored earlier.
  const isEarlier = tagged.calibration !== null && run.id < tagged.calibration;
  // A large change is refused once; then the person confirms it knowingly.
  const large = doing.problem !== null && /confirm/.test(JSON.stringify(doing.problem));
  useEffect(() => () => dialog.current?.close(), []);
  const apply = () =>
    doing.run(async () => {
      const machine = await json<Machine>(`${machinePath(run.machine_id)}/calibrations/${run.id}/apply`, {
        method: "POST",
        json: large ? { confirm: true } : {},
        headers: { "If-Match": tagged.tag },
      });
      setDone(machine.revision);
      dialog.current?.close();
      again();
    });
  return (
    <Card title={texts.value.common.machine}>
      <p>
        {tagged.machine.name}, {texts.value.common.revision(tagged.machine.revision)}
      </p>
      <p class="hint">
        {t.measured}: {texts.value.common.ago(daysSince(run.measured_at))}
      </p>
      {done !== null && (
        <p role="status" class="ok">
          {t.done(done)}
        </p>
      )}
      <button type="button" class={isApplied ? "noprint" : "primary noprint"} disabled={isApplied} onClick={() => dialog.current?.showModal()}>
        {isApplied ? t.applied : isEarlier ? t.applyAgain : t.apply}
      </button>
      <dialog ref={dialog} aria-labelledby="applytitle">
        <h2 id="applytitle">{t.applyTitle}</h2>
        <p>{large ? t.applyLarge : t.applyWhat}</p>
        {doing.problem && <ProblemBox problem={doing.problem} />}
        <div class="row end">
          <button type="button" onClick={() => dialog.current?.close()}>
            {texts.value.common.cancel}
          </button>
          <button type="button" class="primary" disabled={doing.busy} onClick={apply}>
            {large ? t.confirmLarge : t.confirm}
          </button>
        </div>
      </dialog>
    </Card>
  );
}
