// Forms that send something to the service, and show why it was refused.

import type { ComponentChildren } from "preact";
import { useDoing } from "../api/use";
import { texts } from "../texts";
import { Field, NumberInput } from "./parts";
import { ProblemBox } from "./Problem";

interface FormProps {
  send: () => Promise<void>;
  children: ComponentChildren;
  /** What the button says, in place of "Save". */
  words?: string;
  class?: string;
  primary?: boolean;
  /** What is wrong with what is filled in: it is said, and nothing is sent. */
  fault?: string;
  /** The text after 412: another client changed it first. */
  stale?: string;
}

export function Form({ send, children, words, class: kind = "fields", primary, fault, stale }: FormProps) {
  const doing = useDoing();
  return (
    <>
      <form
        class={kind}
        onSubmit={(event) => {
          event.preventDefault();
          if (!fault) doing.run(send);
        }}
      >
        {children}
        <div class="field end">
          <button type="submit" class={primary ? "primary" : ""} disabled={doing.busy}>
            {words ?? texts.value.common.save}
          </button>
        </div>
      </form>
      {stale && doing.problem?.status === 412 && <p class="fault">{stale}</p>}
      {doing.problem && <ProblemBox problem={doing.problem} />}
    </>
  );
}

interface TextProps {
  label: string;
  value: string;
  set: (value: string) => void;
  hint?: string;
  class?: string;
  placeholder?: string;
  required?: boolean;
  pattern?: string;
  type?: "text" | "search" | "datetime-local";
}

export function TextField({ label, value, set, hint, class: kind, placeholder, required, pattern, type = "text" }: TextProps) {
  return (
    <Field label={label} hint={hint} {...(kind ? { class: kind } : {})}>
      <input
        {...({ type } as { type: "text" })}
        value={value}
        {...(placeholder ? { placeholder } : {})}
        {...(pattern ? { pattern } : {})}
        required={required ?? false}
        onInput={(event) => set(event.currentTarget.value)}
      />
    </Field>
  );
}

interface NumberFieldProps {
  label: string;
  value: string;
  set: (value: string) => void;
  unit?: string;
  hint?: string;
  fault?: string | undefined;
}

export function NumberField({ label, value, set, unit, hint, fault }: NumberFieldProps) {
  return (
    <Field label={label} hint={hint} fault={fault}>
      <NumberInput value={value} set={set} invalid={Boolean(fault)} {...(unit ? { unit } : {})} />
    </Field>
  );
}

interface ChoiceProps<Value extends string> {
  label: string;
  value: Value;
  set: (value: Value) => void;
  options: readonly (readonly [Value, string])[];
  hint?: string;
  fault?: string | undefined;
  class?: string;
}

export function Choice<Value extends string>({ label, value, set, options, hint, fault, class: kind }: ChoiceProps<Value>) {
  return (
    <Field label={label} hint={hint} fault={fault} {...(kind ? { class: kind } : {})}>
      <select value={value} onChange={(event) => set(event.currentTarget.value as Value)}>
        {options.map(([of, words]) => (
          <option key={of} value={of}>
            {words}
          </option>
        ))}
      </select>
    </Field>
  );
}

interface PointProps {
  label: string;
  /** The letters of its numbers. */
  letters: readonly string[];
  value: readonly string[];
  set: (value: string[]) => void;
  unit?: string;
  /** What stands before the letter in the name of a field, in place of the label. */
  of?: string;
  class?: string;
  hint?: string;
  fault?: ComponentChildren;
}

/** Several numbers under one name: a point, a direction, a pair of limits. */
export function PointField({ label, letters, value, set, unit, of, class: kind = "", hint, fault }: PointProps) {
  return (
    <div class={`field ${kind} ${fault ? "wrong" : ""}`} role="group" aria-label={label}>
      <span class="label">{label}</span>
      <div class={letters.length === 3 ? "triple" : "double"}>
        {letters.map((letter, index) => (
          <NumberInput
            key={letter}
            label={`${of ?? label} ${letter}`}
            placeholder={letter}
            value={value[index] ?? ""}
            set={(next) => set(letters.map((_letter, at) => (at === index ? next : (value[at] ?? ""))))}
            invalid={Boolean(fault)}
            {...(unit ? { unit } : {})}
          />
        ))}
      </div>
      {fault ? (
        <span class="fault" role="alert">
          {fault}
        </span>
      ) : (
        hint && <span class="hint">{hint}</span>
      )}
    </div>
  );
}
