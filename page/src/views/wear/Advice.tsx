// What to do with the worn cutter, in sentences.

import { useState } from "preact/hooks";
import { json } from "../../api/client";
import type { Advice as Answer, Tool, WearTrend } from "../../api/types";
import { useAsked } from "../../api/use";
import { NumberField } from "../../parts/Form";
import { sentence, short } from "../../parts/format";
import { Card, Got, read } from "../../parts/parts";
import { texts } from "../../texts";
import { passes, passesAsked } from "./Scallop";

const UM_PER_MM = 1000;

/** The advice about the newest wear of a cutter, for the passes below. */
export function Advice({ tool, trend }: { tool: Tool; trend: WearTrend }) {
  const t = texts.value.wear;
  const fit = trend.edges[0]?.fit;
  const known = trend.quantity === "radius" && fit && typeof tool.radius_mm === "number";
  return (
    <Card title={t.advice} hint={t.adviceHint} class="advice">
      {known ? <Advised tool={tool} wear_mm={fit.wear_um / UM_PER_MM} /> : <p>{t.adviceUnknown}</p>}
    </Card>
  );
}

function Advised({ tool, wear_mm }: { tool: Tool; wear_mm: number }) {
  const t = texts.value.wear;
  const [lead, setLead] = useState("5");
  const radius = tool.radius_mm ?? 0;
  const corner = tool.corner_radius_mm ?? radius;
  const isBall = corner === radius;
  const worn = (size: number) => Math.max(0, size - wear_mm);
  const body = {
    ...passesAsked(passes.value),
    nominal_tool: { radius_mm: radius, corner_radius_mm: corner },
    actual_tool: { radius_mm: worn(radius), corner_radius_mm: worn(corner) },
    ...(isBall ? {} : { lead_deg: read(lead) }),
  };
  const asked = useAsked((signal) => json<Answer>("/v1/wear-advice", { method: "POST", json: body, signal }), [JSON.stringify(body)]);
  return (
    <>
      {!isBall && (
        <div class="fields">
          <NumberField label={t.leadAngle} value={lead} set={setLead} unit="°" />
        </div>
      )}
      <Got asked={asked}>{(answer) => <Sentences answer={answer} worn={worn(radius)} />}</Got>
    </>
  );
}

function Sentences({ answer, worn }: { answer: Answer; worn: number }) {
  const t = texts.value.wear;
  const { advice, residual_before_um: before, residual_after_um: after, stepover_mm, min_tool_radius_mm: least } = answer;
  const both = typeof before === "number" && typeof after === "number";
  return (
    <div role="status">
      <p class="verdict strong" data-name="advice" data-value={advice}>
        {t.advices[advice]}
      </p>
      {both && <p>{advice === "keep" ? t.leaves(short(before)) : t.falls(short(before), short(after))}</p>}
      {advice === "reduce-stepover" && typeof stepover_mm === "number" && <p>{t.newStepover(short(stepover_mm))}</p>}
      {typeof least === "number" ? <p>{t.leastRadius(least.toFixed(3), worn.toFixed(3))}</p> : <p>{t.noRadius}</p>}
      <p class="hint">{sentence(answer.detail)}</p>
    </div>
  );
}
