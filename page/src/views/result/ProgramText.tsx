// A program as text. Only the lines in sight are in the document, so a long program costs no more than a short one.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { texts } from "../../texts";

const ROW = 22;
const SPARE = 12;

interface Props {
  label: string;
  lines: string[];
  /** The lines in focus, 1-based. */
  focus: [number, number] | null;
  worst?: number | null;
  changed?: Set<number>;
  onLine?: (line: number) => void;
}

export function ProgramText({ label, lines, focus, worst, changed, onLine }: Props) {
  const place = useRef<HTMLDivElement>(null);
  const [top, setTop] = useState(0);
  const [height, setHeight] = useState(420);
  useEffect(() => {
    const element = place.current;
    if (!element) return;
    const watch = new ResizeObserver(() => setHeight(element.clientHeight));
    watch.observe(element);
    return () => watch.disconnect();
  }, []);
  useEffect(() => {
    const element = place.current;
    if (!element || !focus) return;
    const at = (focus[0] - 1) * ROW;
    if (at < element.scrollTop + ROW || at > element.scrollTop + element.clientHeight - 3 * ROW)
      element.scrollTop = at - element.clientHeight / 2;
  }, [focus?.[0], focus?.[1], lines]);
  const from = Math.max(0, Math.floor(top / ROW) - SPARE);
  const until = Math.min(lines.length, Math.ceil((top + height) / ROW) + SPARE);
  const shown = useMemo(() => lines.slice(from, until), [lines, from, until]);
  return (
    <div
      class="program"
      ref={place}
      tabIndex={0}
      role="region"
      aria-label={label}
      onKeyDown={(event) => {
        const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
        const to = step && focus ? (step < 0 ? focus[0] : focus[1]) + step : 0;
        if (!onLine || to < 1 || to > lines.length) return;
        event.preventDefault();
        onLine(to);
      }}
      onScroll={(event) => setTop(event.currentTarget.scrollTop)}
    >
      <div class="lines" style={{ height: `${lines.length * ROW}px` }}>
        {shown.map((line, index) => {
          const number = from + index + 1;
          const kinds = [
            "codeline",
            focus && number >= focus[0] && number <= focus[1] ? "focus" : "",
            number === worst ? "worst" : "",
            changed?.has(number) ? "changed" : "",
          ];
          return (
            <div
              key={number}
              class={kinds.join(" ")}
              style={{ top: `${(number - 1) * ROW}px` }}
              onClick={() => onLine?.(number)}
            >
              <span class="number">{number}</span>
              <span class="text">{line || " "}</span>
              {number === worst && <span class="tag">{texts.value.result.worst}</span>}
            </div>
          );
        })}
      </div>
    </div>
  );
}
