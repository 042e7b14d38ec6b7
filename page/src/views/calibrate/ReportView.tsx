// The report of a run, fetched with the key and shown within the page. The page's policy allows no styles inside a
// document, so they are taken out of it and given to the place where the report is shown.

import { useEffect, useRef } from "preact/hooks";
import { textOf } from "../../api/client";
import { machinePath } from "../../api/machines";
import { useAsked } from "../../api/use";
import { Got } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";

export function ReportView({ id, run }: { id: string; run: string }) {
  const t = texts.value.calibrate;
  const asked = useAsked(
    (signal) => textOf(`${machinePath(id)}/calibrations/${encodeURIComponent(run)}`, { accept: "text/html", signal }),
    [id, run],
  );
  return (
    <>
      <div class="row noprint">
        <p class="crumbs">
          <a href={to("calibrate", id, run)}>{t.backToRun}</a>
        </p>
        <span class="gap" />
        <button type="button" onClick={() => print()}>
          {texts.value.common.print}
        </button>
      </div>
      <Got asked={asked}>{(html) => <Sheet html={html} />}</Got>
    </>
  );
}

const STYLE = /<style[^>]*>([\s\S]*?)<\/style>/g;

function Sheet({ html }: { html: string }) {
  const place = useRef<HTMLDivElement>(null);
  const picture = texts.value.common.picture;
  useEffect(() => {
    const host = place.current;
    if (!host) return;
    const styles: string[] = [];
    const plain = html.replace(STYLE, (_all, style: string) => (styles.push(style), ""));
    const report = new DOMParser().parseFromString(plain, "text/html");
    for (const unwanted of report.querySelectorAll("script, link, meta, title")) unwanted.remove();
    report.querySelectorAll("svg[role=img]").forEach((figure, index) => figure.setAttribute("aria-label", `${picture} ${index + 1}`));
    // The page has its own main part.
    const body = document.createElement("div");
    body.className = "body";
    const parts = [...(report.querySelector("main") ?? report.body).childNodes];
    const main = document.createElement("div");
    main.className = "main";
    main.append(...parts.map((node) => document.importNode(node, true)));
    body.append(main);
    const root = host.shadowRoot ?? host.attachShadow({ mode: "open" });
    root.adoptedStyleSheets = styles.map(sheetOf);
    root.replaceChildren(body);
  }, [html, picture]);
  return <div class="sheet" ref={place} />;
}

/** A style sheet of a whole document for a part of one. It stays light, as paper is. */
function sheetOf(text: string): CSSStyleSheet {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text.replaceAll(":root", ":host").replace(/(^|[\s,}])(body|main)(?=[\s,{])/g, "$1.$2"));
  for (let index = sheet.cssRules.length - 1; index >= 0; index -= 1) {
    const rule = sheet.cssRules[index];
    if (rule instanceof CSSMediaRule && rule.conditionText.includes("prefers-color-scheme")) sheet.deleteRule(index);
  }
  return sheet;
}
