// The program before and after, side by side, with the line in step.

import { useState } from "preact/hooks";
import type { Job } from "../../api/types";
import { useAsked } from "../../api/use";
import { Card, Got } from "../../parts/parts";
import { texts } from "../../texts";
import { align } from "./align";
import { ProgramText } from "./ProgramText";
import { keepIf, sources } from "./sources";
import { ofFile, ofJob, Text } from "./text";

interface Props {
  job: Job;
  worst: number | null;
  line: number | null;
  toLine: (line: number) => void;
}

export function Programs({ job, worst, line, toLine }: Props) {
  const t = texts.value.result;
  const [wrong, setWrong] = useState(false);
  const file = sources.value.get(job.input_sha256);
  const source = useAsked(async (signal) => (file ? Text.of(ofFile(file), signal) : null), [file]);
  const output = useAsked((signal) => Text.of(ofJob(job.id), signal), [job.id]);
  const aligned = useAsked(
    async (signal) => (source.data && output.data ? align(source.data, output.data, signal) : null),
    [source.data, output.data],
  );
  const step = aligned.data;
  const back = (number: number) => {
    const found = step?.back(number);
    if (found) toLine(found);
  };
  const choose = async (chosen: File | undefined) => {
    if (chosen) setWrong(!(await keepIf(job.input_sha256, chosen)));
  };
  return (
    <Card
      title={t.programs}
      class="noprint programs"
      tools={
        worst !== null && (
          <button type="button" onClick={() => toLine(worst)}>
            {t.toWorst}
          </button>
        )
      }
    >
      <div class="two" id="programs">
        <div>
          <h3>{t.source}</h3>
          {file ? (
            <Got asked={source}>
              {(text) => text && <ProgramText label={t.source} text={text} focus={line === null ? null : [line, line]} worst={worst} onLine={toLine} />}
            </Got>
          ) : (
            <div class="empty">
              <p>{t.noSource}</p>
              <label class="filebutton">
                {t.chooseSource}
                <input type="file" onChange={(event) => void choose(event.currentTarget.files?.[0])} />
              </label>
              {wrong && (
                <p class="fault" role="alert">
                  {t.otherSource}
                </p>
              )}
            </div>
          )}
        </div>
        <div>
          <h3>{t.output}</h3>
          <Got asked={output}>
            {(text) => (
              <ProgramText
                label={t.output}
                text={text}
                focus={line === null ? null : (step?.of(line) ?? null)}
                {...(step ? { changed: (number: number) => step.changed(number) } : {})}
                onLine={back}
              />
            )}
          </Got>
        </div>
      </div>
    </Card>
  );
}
