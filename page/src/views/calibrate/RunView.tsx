import { download, json } from "../../api/client";
import { key } from "../../api/key";
import { machine as machineOf, machinePath } from "../../api/machines";
import type { Calibration } from "../../api/types";
import { useAsked, useDoing } from "../../api/use";
import { moment } from "../../parts/format";
import { Facts } from "../../parts/Facts";
import { Figure } from "../../parts/Figure";
import { Num } from "../../parts/Num";
import { Card, Got, Head } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { to } from "../../router";
import { texts } from "../../texts";
import { Apply } from "./Apply";
import { ErrorBars } from "./ErrorBars";
import { Residuals } from "./Residuals";

export function RunView({ id, run }: { id: string; run: string }) {
  const t = texts.value.calibrate;
  const path = `${machinePath(id)}/calibrations/${encodeURIComponent(run)}`;
  const asked = useAsked(
    async (signal) => {
      const [calibration, tagged] = await Promise.all([json<Calibration>(path, { signal }), machineOf(id, signal)]);
      return { calibration, tagged };
    },
    [id, run],
  );
  return (
    <>
      <p class="crumbs noprint">
        <a href={to("calibrate", id)}>{t.title}</a>
      </p>
      <Got asked={asked}>
        {({ calibration, tagged }) => (
          <>
            <Head
              title={`${t.kinds[calibration.kind]}, ${moment(calibration.measured_at)}`}
              lead={[tagged.machine.name, calibration.instrument, calibration.operator].filter(Boolean).join(" · ")}
            >
              {tagged.calibration === run && <span class="badge ok">{t.applied}</span>}
              <Report id={id} path={path} run={run} />
            </Head>
            <div class="grid">
              <Values run={calibration} />
              <Apply tagged={tagged} run={calibration} again={asked.again} />
              <Exports path={path} run={calibration} />
              <Blind run={calibration} />
            </div>
            <ErrorBars run={calibration} machine={tagged.machine} />
            <div class="figures">
              {calibration.eccentricities_um && (
                <Card title={t.eccentricities}>
                  <Figure path={`${path}?plot=eccentricities`} alt={t.eccentricities} />
                </Card>
              )}
              {calibration.tests && calibration.tests.length > 0 && <Residuals path={path} tests={calibration.tests} />}
            </div>
            <Provenance run={calibration} />
          </>
        )}
      </Got>
    </>
  );
}

/** The printed report. With a key its address alone does not open it, so the page shows it. */
function Report({ id, path, run }: { id: string; path: string; run: string }) {
  const t = texts.value.calibrate;
  return key.value ? (
    <a class="button noprint report" href={to("calibrate", id, run, "report")}>
      {t.report}
    </a>
  ) : (
    <a class="button noprint report" href={path} target="_blank" rel="noreferrer">
      {t.report}
    </a>
  );
}

const FORMATS = ["iso230", "linuxcnc", "siemens", "siemens-tool-carrier"] as const;

/** The errors as texts for controls. What does not fit the machine is refused with its reason. */
function Exports({ path, run }: { path: string; run: Calibration }) {
  const t = texts.value.calibrate;
  const doing = useDoing();
  return (
    <Card title={t.forControl} class="noprint">
      <div class="row">
        {FORMATS.map((format) => (
          <button
            key={format}
            type="button"
            disabled={doing.busy}
            onClick={() => doing.run(() => download(`${path}/export?format=${format}`, "text/plain", `${run.id.slice(0, 13)}-${format}.txt`))}
          >
            {t.exports[format]}
          </button>
        ))}
      </div>
      {doing.problem && <ProblemBox problem={doing.problem} />}
    </Card>
  );
}

function Values({ run }: { run: Calibration }) {
  const t = texts.value.calibrate;
  return (
    <Card title={texts.value.result.values}>
      <Facts
        facts={[
          { row: "residual_rms_um", name: t.residual, value: <Num value={run.residual_rms_um} unit="µm" /> },
          { name: t.rank, value: `${run.rank} / ${run.unknowns}` },
          { name: t.condition, value: <Num value={run.condition_number} /> },
          { name: t.temperature, value: <Num value={run.temperature_c} unit="°C" text={(value) => value.toFixed(1)} /> },
        ]}
      />
      {run.note && <p class="hint">{run.note}</p>}
    </Card>
  );
}

/** Where the numbers come from: on paper they are of no use without it. */
function Provenance({ run }: { run: Calibration }) {
  const t = texts.value;
  return (
    <Card title={t.result.provenance} class="provenance">
      <Facts
        class="wide"
        facts={[
          { name: t.calibrate.run, value: <code>{run.id}</code> },
          { name: t.common.machine, value: `${run.machine_id}, ${t.common.revision(run.machine_revision)}` },
          { name: t.calibrate.stored, value: moment(run.created_at) },
          { name: t.result.software, value: `Trunnion ${run.software_version}` },
          { name: t.calibrate.digest, value: <code>{run.run_sha256}</code>, long: true },
        ]}
      />
    </Card>
  );
}

function Blind({ run }: { run: Calibration }) {
  const t = texts.value.calibrate;
  if (run.blind.length === 0 && run.warnings.length === 0) return null;
  return (
    <Card title={run.blind.length > 0 ? t.cannot : t.warnings} class="blind">
      <ul class="warnings">
        {run.blind.map((blind) => (
          <li key={blind.words}>
            <p>{blind.words}</p>
            {blind.separated_by && (
              <p class="hint">
                {t.further}: {blind.separated_by}
              </p>
            )}
          </li>
        ))}
        {run.warnings.map((warning) => (
          <li key={warning.detail}>
            <p>{warning.detail}</p>
          </li>
        ))}
      </ul>
    </Card>
  );
}
