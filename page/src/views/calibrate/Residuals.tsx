import { useState } from "preact/hooks";
import type { Calibration } from "../../api/types";
import { Figure } from "../../parts/Figure";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { texts } from "../../texts";

/** The residuals of one test as the service draws them: polar, there and back. */
export function Residuals({ path, tests }: { path: string; tests: NonNullable<Calibration["tests"]> }) {
  const t = texts.value.calibrate;
  const [chosen, choose] = useState(0);
  return (
    <Card title={t.residuals}>
      <div class="tabs" role="tablist" aria-label={t.residuals}>
        {tests.map((test, index) => (
          <button
            key={index}
            type="button"
            role="tab"
            aria-selected={index === chosen}
            class={index === chosen ? "chosen" : ""}
            onClick={() => choose(index)}
          >
            {t.test(test.rotary_axis, test.bar_direction)} <Num value={test.residual_rms_um} unit="µm" />
          </button>
        ))}
      </div>
      <Figure path={`${path}?plot=residuals&test=${chosen}`} alt={t.residuals} />
    </Card>
  );
}
