// The residuals of virtual cutting on the part, in 3D.

import { useEffect, useRef, useState } from "preact/hooks";
import { textOf } from "../../api/client";
import type { Job } from "../../api/types";
import { useAsked } from "../../api/use";
import type { Sample } from "../../machine3d/cloudScene";
import { css, shade } from "../../machine3d/scale";
import { short } from "../../parts/format";
import { Card, Got } from "../../parts/parts";
import { isDark } from "../../settings/theme";
import { texts } from "../../texts";

/** More samples than a picture has points are thinned. */
const MOST = 60_000;

/** The columns of the table: x y z, the normal, the residual. */
function samplesOf(table: string): Sample[] {
  const lines = table.trimEnd().split(/\r?\n/).slice(1);
  const every = Math.ceil(lines.length / MOST);
  return lines
    .filter((_line, index) => index % every === 0)
    .map((line) => line.split(",").map((cell) => (cell === "" ? Number.NaN : Number(cell))))
    .filter((cells) => cells.slice(0, 7).every(Number.isFinite))
    .map(([x = 0, y = 0, z = 0, nx = 0, ny = 0, nz = 1, residual = 0]) => ({ at: [x, y, z], normal: [nx, ny, nz], residual }));
}

export function ResidualMap({ job }: { job: Job }) {
  const t = texts.value.result;
  const asked = useAsked(
    async (signal) => samplesOf(await textOf(`/v1/jobs/${job.id}/residuals`, { accept: "text/csv", signal })),
    [job.id],
  );
  return (
    <Card title={t.residualMap} hint={t.residualHint} class="noprint">
      <Got asked={asked}>{(samples) => <Map samples={samples} />}</Got>
    </Card>
  );
}

function Map({ samples }: { samples: Sample[] }) {
  const t = texts.value;
  const place = useRef<HTMLDivElement>(null);
  const [failed, setFailed] = useState(false);
  const dark = isDark.value;
  const residuals = samples.map(({ residual }) => residual);
  const least = residuals.reduce((a, b) => Math.min(a, b), Infinity);
  const most = residuals.reduce((a, b) => Math.max(a, b), -Infinity);
  useEffect(() => {
    let made: { end: () => void } | null = null;
    let ended = false;
    import("../../machine3d/cloudScene").then(({ CloudScene }) => {
      if (ended || !place.current) return;
      try {
        made = new CloudScene(place.current, samples, (residual) => shade((residual - least) / Math.max(most - least, 1e-9)));
      } catch {
        setFailed(true);
      }
    });
    return () => {
      ended = true;
      made?.end();
    };
  }, [samples, dark]);
  return (
    <>
      <div class="stage" ref={place} role="img" aria-label={t.result.residualMap}>
        {failed && <p class="hint over">{t.common.noWebgl}</p>}
      </div>
      <div class="legend">
        <span class="num">
          {short(least)} <span class="unit">µm</span>
        </span>
        <svg class="ramp" viewBox="0 0 320 10" preserveAspectRatio="none" aria-hidden="true">
          <linearGradient id="residuals">
            {[0, 1, 2, 3, 4, 5].map((step) => (
              <stop key={step} offset={step / 5} stop-color={css(step / 5)} />
            ))}
          </linearGradient>
          <rect width="320" height="10" fill="url(#residuals)" />
        </svg>
        <span class="num">
          {short(most)} <span class="unit">µm</span>
        </span>
      </div>
    </>
  );
}
