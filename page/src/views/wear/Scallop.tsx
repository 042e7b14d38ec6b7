import { useState } from "preact/hooks";
import { json } from "../../api/client";
import type { Scallop as Answer } from "../../api/types";
import { useAsked } from "../../api/use";
import { Num } from "../../parts/Num";
import { Card, Field, NumberInput, read, Slider } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";

const SURFACES = ["flat", "convex", "concave"] as const;

/** The height of the ridges between neighbouring paths. */
export function Scallop() {
  const t = texts.value.wear;
  const [stepover, setStepover] = useState(0.4);
  const [radius, setRadius] = useState("5");
  const [surface, setSurface] = useState<(typeof SURFACES)[number]>("flat");
  const [surfaceRadius, setSurfaceRadius] = useState("40");
  const [allowed, setAllowed] = useState("5");
  const body = {
    stepover_mm: stepover,
    tool_radius_mm: read(radius),
    surface,
    ...(surface === "flat" ? {} : { surface_radius_mm: read(surfaceRadius) }),
    allowed_scallop_um: read(allowed),
  };
  const asked = useAsked((signal) => json<Answer>("/v1/scallop-height", { method: "POST", json: body, signal }), [JSON.stringify(body)]);
  return (
    <Card title={t.scallop}>
      <div class="scallop">
        <div class="fields">
          <Slider label={t.stepover} value={stepover} set={setStepover} min={0.05} max={3} step={0.01} unit="mm" shown={stepover.toFixed(2)} />
          <Field label={t.toolRadius}>
            <NumberInput value={radius} set={setRadius} unit="mm" />
          </Field>
          <Field label={t.surface}>
            <select value={surface} onChange={(event) => setSurface(event.currentTarget.value as "flat")}>
              {SURFACES.map((one) => (
                <option key={one} value={one}>
                  {t.surfaces[one]}
                </option>
              ))}
            </select>
          </Field>
          {surface !== "flat" && (
            <Field label={t.surfaceRadius}>
              <NumberInput value={surfaceRadius} set={setSurfaceRadius} unit="mm" />
            </Field>
          )}
          <Field label={t.allowed}>
            <NumberInput value={allowed} set={setAllowed} unit="µm" />
          </Field>
        </div>
        {asked.problem ? (
          <ProblemBox problem={asked.problem} />
        ) : (
          <dl class="facts result">
            <div data-row="scallop_height_um">
              <dt>{t.height}</dt>
              <dd>
                <Num value={asked.data?.scallop_height_um} unit="µm" />
              </dd>
            </div>
            <div data-row="max_stepover_mm">
              <dt>{t.widest}</dt>
              <dd>
                <Num value={asked.data?.max_stepover_mm} unit="mm" />
              </dd>
            </div>
          </dl>
        )}
      </div>
    </Card>
  );
}
