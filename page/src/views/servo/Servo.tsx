// Gains and feed as sliders; the circle follows the hand.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { json } from "../../api/client";
import type { Drive, List, Machine, Matching, Problem, Simulation } from "../../api/types";
import { problemOf, useDoing } from "../../api/use";
import { Figure } from "../../parts/Figure";
import { Num } from "../../parts/Num";
import { Facts } from "../../parts/Facts";
import { Choice } from "../../parts/Form";
import { Card, Empty, Head, NumberInput, read, Slider } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { Table } from "../../parts/Table";
import { texts } from "../../texts";
import { MachineChoice } from "../MachineChoice";
import { Polar } from "./Polar";

/** A pause of the hand that is worth a request. */
const PAUSE_MS = 40;
const FEEDS = [600, 1200, 1800, 2400, 3000, 3600];
const SCALES = [0.6, 0.8, 1, 1.2, 1.4];

export function Servo({ id }: { id: string | undefined }) {
  const t = texts.value.servo;
  return (
    <>
      <Head title={t.title} lead={t.lead} />
      <MachineChoice view="servo" chosen={id}>
        {(machine) => <Drives key={machine.machine_id} machine={machine} />}
      </MachineChoice>
    </>
  );
}

type Drives = Record<string, Drive>;

function Drives({ machine }: { machine: Machine }) {
  const t = texts.value.servo;
  const own = Object.fromEntries(Object.entries(machine.drives ?? {}).filter(([, drive]) => drive)) as Drives;
  const [reference, setReference] = useState<Drives | null>(null);
  const doing = useDoing();
  const drives = Object.keys(own).length > 0 ? own : reference;
  if (!drives)
    return (
      <Card>
        <Empty what={t.noDrives} cure={t.noDrivesCure}>
          <button
            type="button"
            disabled={doing.busy}
            onClick={() =>
              doing.run(async () => {
                const { items } = await json<List<{ id: string; drive: Drive }>>("/v1/drive-presets");
                const of = (id: string) => items.find((one) => one.id === id)?.drive as Drive;
                const rotary = machine.kinematics.rotary_axes.map((axis) => [axis.name, of("reference-rotary")]);
                setReference(Object.fromEntries([...["X", "Y", "Z"].map((axis) => [axis, of("reference-linear")]), ...rotary]));
              })
            }
          >
            {t.reference}
          </button>
        </Empty>
        {doing.problem && <ProblemBox problem={doing.problem} />}
      </Card>
    );
  return <Bench machine={machine} drives={drives} isOwn={reference === null} />;
}

interface Setting {
  kind: "xc-circle" | "circle";
  radius: number;
  centre: number;
  feed: number;
  scales: Record<string, number>;
}

function Bench({ machine, drives, isOwn }: { machine: Machine; drives: Drives; isOwn: boolean }) {
  const t = texts.value;
  const hasC = Boolean(drives["C"] && drives["X"]);
  const [setting, setSetting] = useState<Setting>({
    kind: hasC ? "xc-circle" : "circle",
    radius: 60,
    centre: 100,
    feed: 1800,
    scales: {},
  });
  const axes = setting.kind === "xc-circle" ? ["X", "C"] : ["X", "Y"];
  const set = (change: Partial<Setting>) => setSetting((old) => ({ ...old, ...change }));
  const path =
    setting.kind === "xc-circle"
      ? { kind: setting.kind, radius_mm: setting.radius, center_x_mm: setting.centre }
      : { kind: setting.kind, radius_mm: setting.radius, axes: ["X", "Y"] };
  const who = isOwn ? { machine_id: machine.machine_id } : { drives };
  const body = {
    ...who,
    path,
    feed_mm_per_min: setting.feed,
    position_gain_scale: Object.fromEntries(axes.map((axis) => [axis, setting.scales[axis] ?? 1])),
  };
  const { answer, problem, took } = useSimulation(body);
  return (
    <div class="bench">
      <Card class="controls">
        <div class="fields">
          <Choice
            label={t.servo.path}
            class="wide"
            value={setting.kind}
            set={(kind) => set({ kind })}
            options={[...(hasC ? [["xc-circle", t.servo.xc] as const] : []), ["circle", t.servo.circle]]}
          />
        </div>
        {axes.map((axis) => {
          const scale = setting.scales[axis] ?? 1;
          const gain = (drives[axis]?.position_gain_per_s ?? 0) * scale;
          return (
            <Slider
              key={axis}
              label={t.servo.gain(axis)}
              value={scale}
              set={(value) => set({ scales: { ...setting.scales, [axis]: value } })}
              min={0.3}
              max={3}
              step={0.01}
              unit="1/s"
              shown={gain.toFixed(1)}
            />
          );
        })}
        <Slider label={t.servo.feed} value={setting.feed} set={(feed) => set({ feed })} min={200} max={8000} step={50} unit="mm/min" />
        <Slider label={t.servo.radius} value={setting.radius} set={(radius) => set({ radius })} min={5} max={150} step={1} unit="mm" />
        {setting.kind === "xc-circle" && (
          <Slider label={t.servo.centre} value={setting.centre} set={(centre) => set({ centre })} min={0} max={300} step={1} unit="mm" />
        )}
        <Match who={who} path={path} feed={setting.feed} take={(scales) => set({ scales: { ...setting.scales, ...scales } })} />
      </Card>
      <div class="column">
        <Card title={t.servo.polar}>
          {problem && <ProblemBox problem={problem} />}
          {answer && <Polar simulation={answer} took={took} />}
        </Card>
        {answer && <Numbers simulation={answer} />}
        <Sweep who={who} path={path} axes={axes} />
      </div>
    </div>
  );
}

/** Asks after every pause of the hand; an answer that came too late is dropped. */
function useSimulation(body: object): { answer: Simulation | null; problem: Problem | null; took: number } {
  const [state, setState] = useState<{ answer: Simulation | null; problem: Problem | null; took: number }>({
    answer: null,
    problem: null,
    took: 0,
  });
  const text = JSON.stringify(body);
  const first = useRef(true);
  useEffect(() => {
    const stop = new AbortController();
    const timer = setTimeout(
      async () => {
        const began = performance.now();
        try {
          const answer = await json<Simulation>("/v1/servo-simulations", { method: "POST", json: body, signal: stop.signal });
          if (!stop.signal.aborted) setState({ answer, problem: null, took: Math.round(performance.now() - began) });
        } catch (fault) {
          if (!stop.signal.aborted) setState((old) => ({ ...old, problem: problemOf(fault) }));
        }
      },
      first.current ? 0 : PAUSE_MS,
    );
    first.current = false;
    return () => {
      clearTimeout(timer);
      stop.abort();
    };
  }, [text]);
  return state;
}

function Numbers({ simulation }: { simulation: Simulation }) {
  const t = texts.value.servo;
  const error = simulation.contour_error;
  return (
    <Card title={t.result}>
      <Facts
        facts={[
          { row: "max_abs_um", name: t.max, value: <Num value={error.max_abs_um} unit="µm" /> },
          { row: "rms_um", name: t.rms, value: <Num value={error.rms_um} unit="µm" /> },
          error.oval && { row: "oval", name: t.oval, value: <Num value={error.oval.amplitude_um} unit="µm" /> },
          error.oval && { name: t.ovalAxis, value: <Num value={error.oval.major_axis_deg} unit="°" /> },
        ]}
      />
      <Table
        label={t.axes}
        class="list numeric"
        rows={Object.entries(simulation.axes)}
        keyOf={([axis]) => axis}
        columns={[
          { head: t.axis, cell: ([axis]) => axis, names: true },
          {
            head: t.lag,
            cell: ([, result]) =>
              typeof result.max_following_error_um === "number" ? (
                <Num value={result.max_following_error_um} unit="µm" />
              ) : (
                <Num value={result.max_following_error_urad} unit="µrad" />
              ),
            class: "right",
          },
          { head: t.phase, cell: ([, result]) => <Num value={result.stability.phase_margin_deg} unit="°" />, class: "right" },
          { head: t.bandwidth, cell: ([, result]) => <Num value={result.stability.bandwidth_hz} unit="Hz" />, class: "right" },
        ]}
      />
    </Card>
  );
}

interface Asked {
  who: object;
  path: object;
}

function Match({ who, path, feed, take }: Asked & { feed: number; take: (scales: Record<string, number>) => void }) {
  const t = texts.value.servo;
  const doing = useDoing();
  const [target, setTarget] = useState("5");
  const [answer, setAnswer] = useState<Matching | null>(null);
  useEffect(() => setAnswer(null), [JSON.stringify(path), feed, target]);
  const run = () =>
    doing.run(async () => {
      const target_um = [read(target) ?? 5];
      setAnswer(await json<Matching>("/v1/servo-matching", { method: "POST", json: { ...who, path, feed_mm_per_min: feed, target_um } }));
    });
  return (
    <div class="match">
      <h2>{t.match}</h2>
      <p class="hint">{t.matchHint}</p>
      <div class="row">
        <NumberInput label={t.target} value={target} set={setTarget} unit="µm" />
        <button type="button" disabled={doing.busy} onClick={run}>
          {t.match}
        </button>
      </div>
      {doing.problem && <ProblemBox problem={doing.problem} />}
      {answer && (
        <div role="status">
          <p class={answer.reached ? "ok" : "warn"}>{answer.reached ? t.reached : t.notReached}</p>
          <Facts
            facts={[
              ...Object.entries(answer.gains).map(([axis, gain]) => ({
                name: t.gain(axis),
                value: <Num value={gain.position_gain_per_s} unit="1/s" />,
              })),
              { name: `${t.max}, ${t.matched}`, value: <Num value={answer.matched.max_abs_um} unit="µm" /> },
            ]}
          />
          <button
            type="button"
            onClick={() => take(Object.fromEntries(Object.entries(answer.gains).map(([axis, gain]) => [axis, gain.scale])))}
          >
            {t.take}
          </button>
        </div>
      )}
    </div>
  );
}

function Sweep({ who, path, axes }: Asked & { axes: string[] }) {
  const t = texts.value.servo;
  const [asked, setAsked] = useState<object | null>(null);
  const body = useMemo(
    () => ({ ...who, path, feed_mm_per_min: FEEDS, position_gain_scale: { [axes.at(-1) ?? "C"]: SCALES } }),
    [JSON.stringify(path), axes.join()],
  );
  useEffect(() => setAsked(null), [body]);
  return (
    <Card title={t.sweep} hint={t.sweepHint} class="noprint">
      {asked ? (
        <Figure path="/v1/servo-sweeps?plot=map" alt={t.sweep} body={asked} />
      ) : (
        <button type="button" onClick={() => setAsked(body)}>
          {t.sweepRun}
        </button>
      )}
    </Card>
  );
}
