// A picture of the kinematic chain, and a slider for every axis.

import { useEffect, useRef, useState } from "preact/hooks";
import type { Axis, Kinematics, Words } from "../api/types";
import { fixed } from "../parts/format";
import { Slider } from "../parts/parts";
import { isDark } from "../settings/theme";
import { texts } from "../texts";
import type { MachineScene } from "./machineScene";
import type { Near } from "./singular";

const LINEAR: ("X" | "Y" | "Z")[] = ["X", "Y", "Z"];
const REACH = 140;
const REST: Words = { X: 0, Y: 0, Z: 60, A: 0, B: 0, C: 0 };

export function MachineView({ kinematics }: { kinematics: Kinematics }) {
  const t = texts.value;
  const place = useRef<HTMLDivElement>(null);
  const scene = useRef<MachineScene | null>(null);
  const [words, setWords] = useState<Words>(REST);
  const [magnified, setMagnified] = useState(0);
  const [failed, setFailed] = useState(false);
  const [near, setNear] = useState<Near | null>(null);
  const dark = isDark.value;
  useEffect(() => {
    let made: MachineScene | null = null;
    let ended = false;
    import("./machineScene").then(({ MachineScene }) => {
      if (ended || !place.current) return;
      try {
        made = scene.current = new MachineScene(place.current, kinematics);
        made.pose(words, magnified);
      } catch {
        setFailed(true);
      }
    });
    return () => {
      ended = true;
      made?.end();
      scene.current = null;
    };
  }, [kinematics, dark]);
  useEffect(() => scene.current?.pose(words, magnified), [words, magnified]);
  useEffect(() => {
    let wanted = true;
    void import("./singular").then(({ nearOf }) => wanted && setNear(nearOf(kinematics, words)));
    return () => {
      wanted = false;
    };
  }, [kinematics, words]);
  const set = (axis: Axis) => (value: number) => setWords((old) => ({ ...old, [axis]: value }));
  const hasErrors = kinematics.rotary_axes.some((axis) => Object.values(axis.location_error ?? {}).some((value) => value !== 0));
  return (
    <div class="machineview">
      <div class="stage" ref={place} role="img" aria-label={t.machines.kinematics}>
        {failed && <p class="hint over">{t.common.noWebgl}</p>}
      </div>
      <div class="sliders">
        {kinematics.rotary_axes.map((axis) => {
          const [low, high] = axis.limits_deg ?? [-180, 180];
          return (
            <Slider
              key={axis.name}
              label={axis.name}
              value={words[axis.name] ?? 0}
              set={set(axis.name)}
              min={low}
              max={high}
              step={0.5}
              unit="°"
              shown={(words[axis.name] ?? 0).toFixed(1)}
            />
          );
        })}
        {LINEAR.map((axis) => {
          const [low, high] = kinematics.linear_limits_mm?.[axis] ?? [-REACH, REACH];
          return (
            <Slider
              key={axis}
              label={axis}
              value={words[axis] ?? 0}
              set={set(axis)}
              min={Math.max(low, -4 * REACH)}
              max={Math.min(high, 4 * REACH)}
              step={1}
              unit="mm"
            />
          );
        })}
        {hasErrors && (
          <>
            <Slider
              label={t.machines.errorsTimes}
              value={magnified}
              set={setMagnified}
              min={0}
              max={2000}
              step={100}
              unit="×"
            />
            {magnified > 0 && <p class="hint">{t.machines.magnify(magnified)}</p>}
          </>
        )}
        {near && <Singular near={near} />}
        <button type="button" onClick={() => setWords(REST)}>
          {t.machines.zero}
        </button>
      </div>
    </div>
  );
}

/** What the cone in the picture says, in words. */
function Singular({ near: { pole, angle_deg, zone_deg } }: { near: Near }) {
  const t = texts.value.machines;
  if (!pole) return <p class="hint">{t.noPole}</p>;
  const word = fixed(pole.word_deg, 1);
  return (
    <div class="singular" data-name="pole">
      <p class={angle_deg < zone_deg ? "warn" : "hint"} role="status">
        {angle_deg < zone_deg ? t.inPole(pole.idle.name) : t.fromPole(fixed(angle_deg, 1))}
      </p>
      <p class="hint">{t.pole(pole.tilting.name, word, pole.idle.name, zone_deg)}</p>
    </div>
  );
}
