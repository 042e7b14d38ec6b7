// The frame: header, the view of the address, and the foot.

import { render } from "preact";
import { useEffect, useErrorBoundary } from "preact/hooks";
import { json } from "./api/client";
import { useAsked } from "./api/use";
import { Header } from "./Header";
import { Empty } from "./parts/parts";
import { place, to } from "./router";
import { texts } from "./texts";
import { Guide } from "./tour/Guide";
import { Calibrate } from "./views/calibrate/Calibrate";
import { Compensate } from "./views/compensate/Compensate";
import { Jobs } from "./views/jobs/Jobs";
import { JobView } from "./views/jobs/JobView";
import { MachinePage } from "./views/machines/MachinePage";
import { Machines } from "./views/machines/Machines";
import { NewMachine } from "./views/machines/NewMachine";
import { Overview } from "./views/overview/Overview";
import { Servo } from "./views/servo/Servo";
import { Wear } from "./views/wear/Wear";

function View() {
  const t = texts.value;
  const [view, first, second, third] = place.value.parts;
  useEffect(() => {
    const name = view && view in t.nav ? t.nav[view as "jobs"] : t.nav.overview;
    document.title = `${name} · Trunnion`;
  }, [view, t]);
  switch (view) {
    case undefined:
      return <Overview />;
    case "compensate":
      return <Compensate />;
    case "machines":
      return first === "+" ? <NewMachine /> : first ? <MachinePage key={first} id={first} /> : <Machines />;
    case "jobs":
      return first ? <JobView key={first} id={first} /> : <Jobs />;
    case "calibrate":
      return <Calibrate id={first} run={second} report={third === "report"} />;
    case "servo":
      return <Servo id={first} />;
    case "wear":
      return <Wear id={first} tool={second} />;
    default:
      return (
        <Empty what={t.common.unknownView}>
          <a class="button" href={to()}>
            {t.common.toOverview}
          </a>
        </Empty>
      );
  }
}

/** A fault of one view leaves the others. */
function Guarded() {
  const t = texts.value.common;
  const [fault, again] = useErrorBoundary((error) => console.warn(error));
  const { parts } = place.value;
  useEffect(() => {
    if (fault) again();
  }, [parts]);
  if (!fault) return <View />;
  return (
    <div class="notice bad" role="alert">
      <p class="title">{t.broken}</p>
      <p>
        <code>{String(fault)}</code>
      </p>
      <p class="row">
        <button type="button" onClick={again}>
          {t.again}
        </button>
      </p>
    </div>
  );
}

function Foot() {
  const t = texts.value.nav;
  const asked = useAsked((signal) => json<{ version: string }>("/v1/version", { signal }), []);
  return (
    <footer class="foot noprint">
      <span>{asked.data ? t.version(asked.data.version) : "Trunnion"}</span>
      <a href="/docs/">{t.docs}</a>
      <a href="/problems">{t.problems}</a>
      <a href="/metrics">{t.metrics}</a>
      <a href="/page/LICENSES.txt">{t.licences}</a>
    </footer>
  );
}

function Page() {
  return (
    <>
      <Header />
      <main id="main" tabIndex={-1}>
        <Guarded />
      </main>
      <Foot />
      <Guide />
    </>
  );
}

const root = document.getElementById("page");
if (root) render(<Page />, root);

// When the first view is there and nothing else is to be done.
const makeReady = () => void import("./machine3d/renderer").then(({ prepare }) => prepare());
if ("requestIdleCallback" in window) requestIdleCallback(makeReady);
else setTimeout(makeReady, 1000);
