import { signal } from "@preact/signals";
import { json } from "../../api/client";
import type { Scallop as Answer } from "../../api/types";
import { useAsked } from "../../api/use";
import { Facts } from "../../parts/Facts";
import { Choice, NumberField } from "../../parts/Form";
import { Num } from "../../parts/Num";
import { Card, read, Slider } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";

const SURFACES = ["flat", "convex", "concave"] as const;

/** The passes on the surface. The advice asks about the same ones. */
export const passes = signal({
  stepover: 0.4,
  radius: "5",
  surface: "flat" as (typeof SURFACES)[number],
  surfaceRadius: "40",
  allowed: "5",
});

/** The passes as members of a request. */
export const passesAsked = ({ stepover, surface, surfaceRadius, allowed }: typeof passes.value) => ({
  stepover_mm: stepover,
  surface,
  ...(surface === "flat" ? {} : { surface_radius_mm: read(surfaceRadius) }),
  allowed_scallop_um: read(allowed),
});

/** The height of the ridges between neighbouring paths. */
export function Scallop() {
  const t = texts.value.wear;
  const now = passes.value;
  const set = (change: Partial<typeof now>) => (passes.value = { ...now, ...change });
  const body = { ...passesAsked(now), tool_radius_mm: read(now.radius) };
  const asked = useAsked((stop) => json<Answer>("/v1/scallop-height", { method: "POST", json: body, signal: stop }), [JSON.stringify(body)]);
  return (
    <Card title={t.scallop}>
      <div class="scallop">
        <div class="fields">
          <Slider
            label={t.stepover}
            value={now.stepover}
            set={(stepover) => set({ stepover })}
            min={0.05}
            max={3}
            step={0.01}
            unit="mm"
            shown={now.stepover.toFixed(2)}
          />
          <NumberField label={t.toolRadius} value={now.radius} set={(radius) => set({ radius })} unit="mm" />
          <Choice label={t.surface} value={now.surface} set={(surface) => set({ surface })} options={SURFACES.map((one) => [one, t.surfaces[one]])} />
          {now.surface !== "flat" && (
            <NumberField label={t.surfaceRadius} value={now.surfaceRadius} set={(surfaceRadius) => set({ surfaceRadius })} unit="mm" />
          )}
          <NumberField label={t.allowed} value={now.allowed} set={(allowed) => set({ allowed })} unit="µm" />
        </div>
        {asked.problem ? (
          <ProblemBox problem={asked.problem} />
        ) : (
          <Facts
            class="result"
            facts={[
              { row: "scallop_height_um", name: t.height, value: <Num value={asked.data?.scallop_height_um} unit="µm" /> },
              { row: "max_stepover_mm", name: t.widest, value: <Num value={asked.data?.max_stepover_mm} unit="mm" /> },
            ]}
          />
        )}
      </div>
    </Card>
  );
}
