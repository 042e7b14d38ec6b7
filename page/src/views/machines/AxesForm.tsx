// The lines of the rotary axes as a form: direction, a point, limits. Location errors come from calibration runs.

import { useState } from "preact/hooks";
import { profileOf, putMachine, type Tagged } from "../../api/machines";
import type { Kinematics, RotaryAxis, Vector } from "../../api/types";
import { Form, PointField } from "../../parts/Form";
import { read } from "../../parts/parts";
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
  const send = async () => {
    await putMachine(machine.machine_id, { ...profileOf(machine), kinematics: kinematicsOf(all) }, tag);
    again();
  };
  return (
    <details>
      <summary>{t.editAxes}</summary>
      <Form send={send} class="axesform" stale={t.stale}>
        {axes.map((axis, index) => {
          const numbers = (name: "direction" | "point" | "limits", label: string, letters: string[], unit?: string) => (
            <PointField
              label={label}
              of={`${axis.name} ${label}`}
              letters={letters}
              value={all[index]?.[name] ?? []}
              set={(value) => set(index, { [name]: value })}
              {...(unit ? { unit } : {})}
            />
          );
          return (
            <fieldset class="bare" key={axis.name}>
              <legend>
                {t.axis} {axis.name}
              </legend>
              {numbers("direction", t.direction, ["x", "y", "z"])}
              {numbers("point", t.point, ["X", "Y", "Z"], "mm")}
              {numbers("limits", t.limits, ["−", "+"], "°")}
              <label class="check">
                <input
                  type="checkbox"
                  checked={all[index]?.reversed ?? false}
                  onChange={(event) => set(index, { reversed: event.currentTarget.checked })}
                />
                <span>{t.reversed}</span>
              </label>
            </fieldset>
          );
        })}
      </Form>
    </details>
  );
}
