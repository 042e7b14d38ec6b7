import { useEffect, useRef } from "preact/hooks";
import { key, keyWanted, keepKey } from "./api/key";
import { Field } from "./parts/parts";
import { ProblemBox } from "./parts/Problem";
import { place, to } from "./router";
import { type Choice, choice } from "./settings/theme";
import { language, type Language, texts } from "./texts";

const VIEWS = ["overview", "compensate", "machines", "jobs", "calibrate", "servo", "wear"] as const;

export function Header() {
  const t = texts.value.nav;
  const here = place.value.parts[0] ?? "overview";
  return (
    <header class="top noprint">
      <a class="skip" href="#main" onClick={(event) => (event.preventDefault(), document.getElementById("main")?.focus())}>
        {t.skip}
      </a>
      <a class="brand" href={to()}>
        <svg viewBox="0 0 16 16" aria-hidden="true">
          <path d="M2 13.5h12M8 13.5V8.5" />
          <circle cx="8" cy="5.5" r="3" />
        </svg>
        Trunnion
      </a>
      <nav aria-label={t.main}>
        {VIEWS.map((view) => (
          <a key={view} href={view === "overview" ? to() : to(view)} {...(view === here ? { "aria-current": "page" as const } : {})}>
            {t[view]}
          </a>
        ))}
      </nav>
      <div class="settings" role="group" aria-label={t.settings}>
        <select aria-label={t.language} value={language.value} onChange={(event) => (language.value = event.currentTarget.value as Language)}>
          <option value="en">English</option>
          <option value="zh">中文</option>
        </select>
        <select aria-label={t.theme} value={choice.value} onChange={(event) => (choice.value = event.currentTarget.value as Choice)}>
          <option value="system">{t.system}</option>
          <option value="light">{t.light}</option>
          <option value="dark">{t.dark}</option>
        </select>
        <KeyButton />
      </div>
    </header>
  );
}

/** The key, asked for when the service wants one, and changed or forgotten at any time. */
function KeyButton() {
  const t = texts.value;
  const dialog = useRef<HTMLDialogElement>(null);
  const field = useRef<HTMLInputElement>(null);
  const wanted = keyWanted.value;
  useEffect(() => {
    if (wanted && !dialog.current?.open) dialog.current?.showModal();
  }, [wanted]);
  const use = () => {
    keepKey(field.current?.value ?? "");
    if (field.current) field.current.value = "";
    dialog.current?.close();
  };
  return (
    <>
      <button type="button" class={key.value ? "keyed" : ""} onClick={() => dialog.current?.showModal()}>
        {t.nav.key}
      </button>
      <dialog ref={dialog} aria-labelledby="keytitle">
        <form
          onSubmit={(event) => {
            event.preventDefault();
            use();
          }}
        >
          <h2 id="keytitle">{wanted ? t.key.title : t.nav.key}</h2>
          {wanted && key.value && <ProblemBox problem={wanted} />}
          {!wanted && <p>{key.value ? t.key.have : t.key.haveNone}</p>}
          <p class="hint">{t.key.why}</p>
          <Field label={t.key.field}>
            <input type="password" ref={field} autocomplete="off" spellcheck={false} autofocus />
          </Field>
          <div class="row end">
            <button type="button" onClick={() => dialog.current?.close()}>
              {t.common.cancel}
            </button>
            {key.value && (
              <button
                type="button"
                onClick={() => {
                  keepKey("");
                  dialog.current?.close();
                }}
              >
                {t.key.forget}
              </button>
            )}
            <button type="submit" class="primary">
              {t.key.enter}
            </button>
          </div>
        </form>
      </dialog>
    </>
  );
}
