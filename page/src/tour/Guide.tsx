import { texts } from "../texts";
import { done } from "../views/compensate/Compensate";
import { end, goTo, step, STEPS } from "./tour";

/** The words of the step, at the foot of the page. */
export function Guide() {
  const t = texts.value;
  const now = step.value;
  if (now === 0) return null;
  const waits = now === 2 && done.value?.state !== "succeeded";
  return (
    <aside class="guide noprint" aria-live="polite" aria-label={t.tour.step(now, STEPS)}>
      <div class="dots" aria-hidden="true">
        {Array.from({ length: STEPS }, (_, index) => (
          <i key={index} class={index < now ? "full" : ""} />
        ))}
      </div>
      <p>
        <strong>{t.tour.step(now, STEPS)}.</strong> {t.tour.steps[now - 1]}
      </p>
      <div class="row">
        <button type="button" onClick={end}>
          {t.tour.end}
        </button>
        <button type="button" class="primary" disabled={waits} onClick={() => goTo(now + 1)}>
          {now === STEPS ? t.tour.finish : t.tour.next}
        </button>
      </div>
    </aside>
  );
}
