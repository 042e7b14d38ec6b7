// A run that is typed, or pasted from a spreadsheet.

import { useState } from "preact/hooks";
import type { Machine } from "../../api/types";
import { Choice, NumberField, PointField, TextField } from "../../parts/Form";
import { Card } from "../../parts/parts";
import { texts } from "../../texts";
import { COLUMNS, DIRECTIONS, faultsOf, type Method, type Part, partOf, requestOf, type RunRequest, typed } from "./draft";
import { Readings } from "./Readings";

const METHODS: Method[] = ["rtcp-ballbar", "rotary-sphere"];
/** More faults are not listed: they are marked in the table. */
const LISTED = 8;

export function EnterRun({ machine, preview, cancel }: { machine: Machine; preview: (run: RunRequest) => void; cancel: () => void }) {
  const t = texts.value.calibrate;
  const [asked, setAsked] = useState(false);
  const now = typed.value;
  const axes = machine.kinematics.rotary_axes.map(({ name }) => name);
  const set = (change: Partial<typeof now>) => (typed.value = { ...typed.value, ...change });
  const setPart = (at: number, change: Partial<Part>) =>
    set({ parts: now.parts.map((part, index) => (index === at ? { ...part, ...change } : part)) });
  const isBar = now.kind === "rtcp-ballbar";
  const faults = asked ? faultsOf(now, t) : [];
  const next = () => {
    // A bar test shows one direction of an axis; the next one that is free is suggested.
    const free = DIRECTIONS.slice(0, 2)
      .flatMap((direction) => axes.map((axis) => ({ axis, direction })))
      .find(({ axis, direction }) => !now.parts.some((part) => part.axis === axis && (!isBar || part.direction === direction)));
    const before = now.parts.at(-1);
    const made = partOf(free?.axis ?? axes[0] ?? "C", free?.direction);
    set({ parts: [...now.parts, before ? { ...made, ball: before.ball } : made] });
  };
  const heads = isBar
    ? [
        { name: t.angle, unit: "°" },
        { name: t.change, unit: "µm" },
      ]
    : [{ name: t.angle, unit: "°" }, ...["X", "Y", "Z"].map((name) => ({ name, unit: "mm" }))];
  return (
    <Card title={t.enter} hint={t.enterHint} class="enterrun noprint">
      <form
        onSubmit={(event) => {
          event.preventDefault();
          setAsked(true);
          if (faultsOf(now, t).length === 0) preview(requestOf(now));
        }}
      >
        <div class="fields">
          <Choice
            label={t.kind}
            value={now.kind}
            set={(kind) => set({ kind, parts: now.parts.map((part) => ({ ...part, rows: COLUMNS[kind] === COLUMNS[now.kind] ? part.rows : [] })) })}
            options={METHODS.map((method) => [method, t.kinds[method]])}
          />
          <TextField label={t.measured} type="datetime-local" value={now.when} set={(when) => set({ when })} />
          <TextField label={t.instrument} value={now.instrument} set={(instrument) => set({ instrument })} />
          <TextField label={t.operator} value={now.operator} set={(operator) => set({ operator })} />
          <NumberField label={t.temperature} value={now.temperature} set={(temperature) => set({ temperature })} unit="°C" />
          {isBar && (
            <>
              <NumberField label={t.barLength} value={now.bar} set={(bar) => set({ bar })} unit="mm" />
              <PointField label={t.setup} letters={["X", "Y"]} value={now.setup} set={(setup) => set({ setup })} unit="µm" hint={t.setupHint} />
            </>
          )}
          <TextField label={texts.value.wear.note} value={now.note} set={(note) => set({ note })} class="wide" />
        </div>
        {now.parts.map((part, at) => (
          <fieldset key={at} class="part">
            <legend>{t.part(at + 1, isBar)}</legend>
            <div class="fields">
              <Choice label={texts.value.machines.axis} value={part.axis} set={(axis) => setPart(at, { axis })} options={axes.map((axis) => [axis, axis])} />
              {isBar && (
                <>
                  <Choice
                    label={t.direction}
                    value={part.direction}
                    set={(direction) => setPart(at, { direction })}
                    options={DIRECTIONS.map((direction) => [direction, t.directions[direction]])}
                  />
                  <PointField label={t.ball} letters={["X", "Y", "Z"]} value={part.ball} set={(ball) => setPart(at, { ball })} unit="mm" class="wide" hint={t.ballHint} />
                </>
              )}
            </div>
            <Readings label={t.readingsOf(t.part(at + 1, isBar))} heads={heads} rows={part.rows} set={(rows) => setPart(at, { rows })} />
            <button type="button" onClick={() => set({ parts: now.parts.filter((_part, index) => index !== at) })}>
              {t.removePart(t.part(at + 1, isBar))}
            </button>
          </fieldset>
        ))}
        {faults.length > 0 && (
          <div class="fault" role="alert">
            <ul class="faults">
              {faults.slice(0, LISTED).map((fault) => (
                <li key={fault.words}>{fault.words}</li>
              ))}
              {faults.length > LISTED && <li>{t.faults.more(faults.length - LISTED)}</li>}
            </ul>
          </div>
        )}
        <div class="row">
          <button type="button" onClick={next}>
            {isBar ? t.addTest : t.addAxis}
          </button>
          <span class="gap" />
          <button type="button" onClick={cancel}>
            {texts.value.common.cancel}
          </button>
          <button type="submit" class="primary">
            {t.look}
          </button>
        </div>
      </form>
    </Card>
  );
}
