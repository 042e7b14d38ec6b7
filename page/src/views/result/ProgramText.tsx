// A program as text. Only the lines in sight are in the document, and only their parts of the program in memory.

import { useEffect, useRef, useState } from "preact/hooks";
import { texts } from "../../texts";
import type { Text } from "./text";

const ROW = 22;
const SPARE = 12;
/** Browsers do not draw what is higher. A longer program is moved faster than the hand. */
const HIGHEST = 8_000_000;

interface Props {
  label: string;
  text: Text;
  /** The lines in focus, 1-based. */
  focus: [number, number] | null;
  worst?: number | null;
  changed?: (line: number) => boolean;
  onLine?: (line: number) => void;
}

interface Part {
  from: number;
  lines: string[];
}

export function ProgramText({ label, text, focus, worst, changed, onLine }: Props) {
  const place = useRef<HTMLDivElement>(null);
  const [scrolled, setScrolled] = useState(0);
  const [height, setHeight] = useState(420);
  const [part, setPart] = useState<Part>({ from: 0, lines: [] });
  const whole = text.length * ROW;
  const shown = Math.min(whole, HIGHEST);
  const faster = shown > height ? (whole - height) / (shown - height) : 1;
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
    const top = element.scrollTop * faster;
    if (at < top + ROW || at > top + element.clientHeight - 3 * ROW) element.scrollTop = (at - element.clientHeight / 2) / faster;
  }, [focus?.[0], focus?.[1], text]);
  const top = scrolled * faster;
  const from = Math.max(0, Math.floor(top / ROW) - SPARE);
  const until = Math.min(text.length, Math.ceil((top + height) / ROW) + SPARE);
  useEffect(() => {
    let wanted = true;
    // A part that does not come stays empty until it is looked at again.
    text.lines(from, until).then((lines) => wanted && setPart({ from, lines }), () => undefined);
    return () => {
      wanted = false;
    };
  }, [text, from, until]);
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
        if (!onLine || to < 1 || to > text.length) return;
        event.preventDefault();
        onLine(to);
      }}
      onScroll={(event) => setScrolled(event.currentTarget.scrollTop)}
    >
      <div class="lines" style={{ height: `${shown}px` }}>
        {part.lines.map((line, index) => {
          const number = part.from + index + 1;
          const kinds = [
            "codeline",
            focus && number >= focus[0] && number <= focus[1] ? "focus" : "",
            number === worst ? "worst" : "",
            changed?.(number) ? "changed" : "",
          ];
          return (
            <div
              key={number}
              class={kinds.join(" ")}
              style={{ top: `${(number - 1) * ROW - top + scrolled}px` }}
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
