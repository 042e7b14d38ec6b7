// Small parts that every view uses.

import type { ComponentChildren } from "preact";
import type { Asked } from "../api/use";
import type { JobState } from "../api/types";
import { texts } from "../texts";
import { ProblemBox } from "./Problem";
import { Words } from "./Words";

interface Content {
  children: ComponentChildren;
}

/** The head of a view, with what can be done there. */
export function Head({ title, lead, children }: { title: string; lead?: string; children?: ComponentChildren }) {
  return (
    <header class="head">
      <div>
        <h1>{title}</h1>
        {lead && <p class="lead">{lead}</p>}
      </div>
      {children && <div class="row">{children}</div>}
    </header>
  );
}

export function Card(props: Content & { title?: string; hint?: string; class?: string; tools?: ComponentChildren }) {
  return (
    <section class={`card ${props.class ?? ""}`}>
      {props.title && (
        <div class="cardhead">
          <h2>{props.title}</h2>
          {props.tools}
        </div>
      )}
      {props.hint && <p class="hint">{props.hint}</p>}
      {props.children}
    </section>
  );
}

export function Busy() {
  return (
    <p class="busy" role="status">
      <span class="spin" aria-hidden="true" /> {texts.value.common.loading}
    </p>
  );
}

export function Empty({ what, cure, children }: { what: string; cure?: string; children?: ComponentChildren }) {
  return (
    <div class="empty">
      <p>{what}</p>
      {cure && <p class="hint">{cure}</p>}
      {children}
    </div>
  );
}

/** What was asked for, or why it is not here (yet). */
export function Got<T>({ asked, children }: { asked: Asked<T>; children: (data: T) => ComponentChildren }) {
  if (asked.data !== null) return <>{children(asked.data)}</>;
  if (asked.problem) return <ProblemBox problem={asked.problem} again={asked.again} />;
  return <Busy />;
}

export function State({ state }: { state: JobState }) {
  return (
    <span class={`state ${state}`}>
      <span class="mark" aria-hidden="true" />
      {texts.value.states[state]}
    </span>
  );
}

interface FieldProps extends Content {
  label: string;
  hint?: string | undefined;
  fault?: string | undefined;
  class?: string;
}

/** A labelled control. The label wraps it, so both belong together for everybody. */
export function Field({ label, hint, fault, children, class: kind }: FieldProps) {
  return (
    <label class={`field ${kind ?? ""} ${fault ? "wrong" : ""}`}>
      <span class="label">{label}</span>
      {children}
      {hint && !fault && <span class="hint">{hint}</span>}
      {fault && (
        <span class="fault" role="alert">
          <Words text={fault} />
        </span>
      )}
    </label>
  );
}

interface NumberProps {
  value: string;
  set: (value: string) => void;
  unit?: string;
  id?: string;
  label?: string;
  invalid?: boolean;
  placeholder?: string;
}

export function NumberInput({ value, set, unit, id, label, invalid, placeholder }: NumberProps) {
  return (
    <span class="withunit">
      <input
        type="text"
        inputMode="decimal"
        autocomplete="off"
        {...(id ? { id } : {})}
        {...(label ? { "aria-label": label } : {})}
        {...(placeholder ? { placeholder } : {})}
        aria-invalid={invalid ? "true" : "false"}
        value={value}
        onInput={(event) => set(event.currentTarget.value)}
      />
      {unit && <span class="unit">{unit}</span>}
    </span>
  );
}

interface SliderProps {
  label: string;
  value: number;
  set: (value: number) => void;
  min: number;
  max: number;
  step: number;
  unit: string;
  shown?: string;
}

export function Slider({ label, value, set, min, max, step, unit, shown }: SliderProps) {
  return (
    <label class="slider">
      <span class="label">{label}</span>
      <output class="num">
        {shown ?? value}
        <span class="unit"> {unit}</span>
      </output>
      <input
        type="range"
        min={min}
        max={max}
        step={step}
        value={value}
        onInput={(event) => set(Number(event.currentTarget.value))}
      />
    </label>
  );
}

/** A number that a person typed, with a comma or a point. */
export function read(text: string): number | undefined {
  const value = Number(text.trim().replace(",", ".").replace("−", "-"));
  return text.trim() === "" || !Number.isFinite(value) ? undefined : value;
}
