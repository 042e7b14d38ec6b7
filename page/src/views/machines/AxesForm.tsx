// The lines of the rotary axes as a form: direction, a point, limits. Location errors come from calibration runs.

import { useState } from "preact/hooks";
import { profileOf, putMachine, type Tagged } from "../../api/machines";
import type { Kinematics, RotaryAxis, Vector } from "../../api/types";
import { useDoing } from "../../api/use";
import { NumberInput, read } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { texts } from "../../texts";

interface Typed {
  direction: string[];
  point: string[];
  limits: string[];
  reversed: boolean;
}

const typed = (axis: RotaryAxis): Typed => ({
  direction: axis.direction.map(String),
  point: axis.point_mm.map(String),
  limits: (axis.limits_deg ?? ["", ""]).map(String),
  reversed: axis.reversed ?? false,
});

/** The axis as it was typed. What cannot be read stays as it was. */
function axisOf(axis: RotaryAxis, { direction, point, limits, reversed }: Typed): RotaryAxis {
  const vector = (texts: string[], old: Vector) => texts.map((text, index) => read(text) ?? old[index] ?? 0) as Vector;
  const [low, high] = limits.map(read);
  return {
    ...axis,
    direction: vector(direction, axis.direction),
    point_mm: vector(point, axis.point_mm),
    limits_deg: low === undefined || high === undefined ? null : [low, high],
    reversed,
  };
}

interface Props {
  tagged: Tagged;
  /** Shows the machine as it is typed. */
  preview: (kinematics: Kinematics) => void;
  again: () => void;
}

export function AxesForm({ tagged, preview, again }: Props) {
  const t = texts.value.machines;
  const { machine, tag } = tagged;
  const axes = machine.kinematics.rotary_axes;
  const doing = useDoing();
  const [all, setAll] = useState(axes.map(typed));
  const kinematicsOf = (of: Typed[]): Kinematics => ({
    ...machine.kinematics,
    rotary_axes: axes.map((axis, index) => axisOf(axis, of[index] ?? typed(axis))),
  });
  const set = (index: number, change: Partial<Typed>) => {
    const next = all.map((one, at) => (at === index ? { ...one, ...change } : one));
    setAll(next);
    const lines = kinematicsOf(next);
    // A direction of no length has no line.
    if (lines.rotary_axes.every(({ direction }) => direction.some((part) => part !== 0))) preview(lines);
  };
  const numbers = (index: number, name: "direction" | "point" | "limits", label: string, letters: string[], unit?: string) => (
    <div class="field" role="group" aria-label={label}>
      <span class="label">{label}</span>
      <div class={letters.length === 3 ? "triple" : "double"}>
        {letters.map((letter, at) => (
          <NumberInput
            key={letter}
            label={`${axes[index]?.name} ${label} ${letter}`}
            placeholder={letter}
            value={all[index]?.[name][at] ?? ""}
            set={(value) => set(index, { [name]: (all[index]?.[name] ?? []).map((old, k) => (k === at ? value : old)) })}
            {...(unit ? { unit } : {})}
          />
        ))}
      </div>
    </div>
  );
  return (
    <details>
      <summary>{t.editAxes}</summary>
      <form
        class="axesform"
        onSubmit={(event) => {
          event.preventDefault();
          doing.run(async () => {
            await putMachine(machine.machine_id, { ...profileOf(machine), kinematics: kinematicsOf(all) }, tag);
            again();
          });
        }}
      >
        {axes.map((axis, index) => (
          <fieldset class="bare" key={axis.name}>
            <legend>
              {t.axis} {axis.name}
            </legend>
            {numbers(index, "direction", t.direction, ["x", "y", "z"])}
            {numbers(index, "point", t.point, ["X", "Y", "Z"], "mm")}
            {numbers(index, "limits", t.limits, ["−", "+"], "°")}
            <label class="check">
              <input
                type="checkbox"
                checked={all[index]?.reversed ?? false}
                onChange={(event) => set(index, { reversed: event.currentTarget.checked })}
              />
              <span>{t.reversed}</span>
            </label>
          </fieldset>
        ))}
        <button type="submit" disabled={doing.busy}>
          {texts.value.common.save}
        </button>
      </form>
      {doing.problem && (
        <>
          {doing.problem.status === 412 && <p class="fault">{t.stale}</p>}
          <ProblemBox problem={doing.problem} />
        </>
      )}
    </details>
  );
}
