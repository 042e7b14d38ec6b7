// The tool path in 3D, coloured by the deviation before and after, with the machine at one place of it.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { json } from "../../api/client";
import { machinePath, tools as toolsOf } from "../../api/machines";
import type { JobPath } from "../../api/path";
import type { Job, Machine, Report } from "../../api/types";
import { type Asked, useAsked } from "../../api/use";
import type { PathScene } from "../../machine3d/pathScene";
import type { Pose } from "../../machine3d/poses";
import type { Stage } from "../../machine3d/stage";
import { css } from "../../machine3d/scale";
import { short } from "../../parts/format";
import { Busy, Card, Empty } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { isDark } from "../../settings/theme";
import { texts } from "../../texts";
import type { Reading } from "./reading";

interface Props {
  job: Job;
  report: Report;
  reading: Reading;
  path: Asked<JobPath>;
  line: number | null;
  toLine: (line: number) => void;
  /** Called when there is a picture, or when there will be none. */
  drawn: () => void;
}

interface Loaded {
  machine: Machine;
  path: JobPath;
  cutter: { radius: number; corner: number };
}

export function ToolPath(props: Props) {
  const { job, report, path } = props;
  const t = texts.value.result;
  const asked = useAsked(async (signal) => {
    const of = machinePath(job.machine_id);
    const [machine, table] = await Promise.all([
      json<Machine>(`${of}/revisions/${job.machine_revision}`, { signal }),
      toolsOf(job.machine_id).catch(() => ({ items: [] })),
    ]);
    const called = report.resolved?.tools[0]?.tool_id;
    const tool = table.items.find((one) => one.tool_id === called);
    const stated = radiusOf(job.parameters);
    const radius = stated?.radius ?? tool?.radius_mm ?? 5;
    return { machine, cutter: { radius, corner: stated?.corner ?? tool?.corner_radius_mm ?? radius } };
  }, [job.id]);
  const loaded = useMemo(() => (asked.data && path.data ? { ...asked.data, path: path.data } : null), [asked.data, path.data]);
  const problem = asked.problem ?? path.problem;
  const isWithout = problem !== null || path.data?.rows.length === 0;
  useEffect(() => {
    if (isWithout) props.drawn();
  }, [isWithout]);
  return (
    <Card title={t.path} hint={t.pathHint} class="path noprint">
      {problem ? (
        <ProblemBox problem={problem} again={() => (asked.again(), path.again())} />
      ) : isWithout ? (
        <Empty what={t.noPath} />
      ) : (
        <Picture {...props} loaded={loaded} />
      )}
    </Card>
  );
}

function radiusOf(parameters: Record<string, unknown>): { radius: number; corner: number } | null {
  const cc = (parameters["cc"] ?? parameters) as Record<string, unknown>;
  const wear = (parameters["wear"] ?? parameters) as Record<string, unknown>;
  const nominal = wear["nominal_tool"] as Record<string, number> | undefined;
  const radius = cc["tool_radius_mm"] ?? nominal?.["radius_mm"];
  if (typeof radius !== "number") return null;
  const corner = cc["corner_radius_mm"] ?? nominal?.["corner_radius_mm"];
  return { radius, corner: typeof corner === "number" ? corner : radius };
}

const STEPS_PER_S = 40;
/** Parts of the colour scale. */
const RAMP = 10;

function Picture({ job, report, reading, loaded, line, toLine, drawn }: Props & { loaded: Loaded | null }) {
  const t = texts.value;
  const place = useRef<HTMLDivElement>(null);
  const scene = useRef<PathScene | null>(null);
  const [stage, setStage] = useState<Stage | null>(null);
  const [poses, setPoses] = useState<Pose[]>([]);
  const [at, setAt] = useState(0);
  const [divider, setDivider] = useState(0.5);
  const [plays, setPlays] = useState(false);
  const [failed, setFailed] = useState(false);
  const dark = isDark.value;
  const top = Math.max(reading.beforeMax ?? 0, reading.afterMax ?? 0, reading.tolerance ?? 0, 1e-6);

  // The stage is made ready while the service computes the path.
  useEffect(() => {
    let made: Stage | null = null;
    let ended = false;
    Promise.all([import("../../machine3d/stage"), import("../../machine3d/pathScene")]).then(([{ Stage }]) => {
      if (ended || !place.current) return;
      try {
        made = new Stage(place.current);
        setStage(made);
      } catch {
        setFailed(true);
        drawn();
      }
    });
    return () => {
      ended = true;
      setStage(null);
      made?.end();
    };
  }, [dark]);

  useEffect(() => {
    if (!stage || !loaded) return;
    let ended = false;
    Promise.all([import("../../machine3d/pathScene"), import("../../machine3d/poses")]).then(
      ([{ PathScene }, { followsAxes, posesOf }]) => {
        if (ended) return;
        const { machine, path, cutter } = loaded;
        const offset = report.resolved?.work_offsets.find((one) => one.origin_mm)?.origin_mm ?? [0, 0, 0];
        const length = job.parameters["tool_length_mm"];
        const known = { kinematics: machine.kinematics, offset, toolLength: typeof length === "number" ? length : 0 };
        const way = { ...known, byAxes: path.together === 1 && followsAxes(path.rows, known) };
        const all = posesOf(path.rows, way);
        const made = (scene.current = new PathScene(stage, all, way, top, cutter));
        made.divide(divider);
        made.pose(at);
        setPoses(all);
        requestAnimationFrame(drawn);
      },
    );
    return () => {
      ended = true;
      scene.current?.end();
      scene.current = null;
    };
  }, [stage, loaded, top]);

  useEffect(() => scene.current?.pose(at), [at]);
  useEffect(() => scene.current?.divide(divider), [divider]);
  // A line that was chosen elsewhere moves the machine there.
  useEffect(() => {
    if (line === null || poses[at]?.line === line) return;
    const exact = poses.findLastIndex((pose) => pose.line === line);
    // In a long program the line may be one of several in a pose.
    const found = exact >= 0 ? exact : poses.findIndex((pose) => pose.line > line);
    if (found >= 0) setAt(found);
  }, [line, poses]);
  useEffect(() => {
    if (!plays) return;
    const timer = setInterval(() => setAt((now) => (now + 1 >= poses.length ? (setPlays(false), now) : now + 1)), 1000 / STEPS_PER_S);
    return () => clearInterval(timer);
  }, [plays, poses]);

  const pose = poses[at];
  const drag = (event: PointerEvent) => {
    const box = place.current?.getBoundingClientRect();
    if (box && event.buttons) setDivider(Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)));
  };
  const byKey = (event: KeyboardEvent) => {
    const step = { ArrowLeft: -0.05, ArrowRight: 0.05, Home: -1, End: 1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    setDivider((now) => Math.min(1, Math.max(0, now + step)));
  };
  return (
    <>
      <div class="stage tall">
        <div class="canvas" ref={place} />
        {failed && <p class="hint over">{t.common.noWebgl}</p>}
        {!failed && poses.length === 0 && (
          <div class="over">
            <Busy />
          </div>
        )}
        <span class="corner left" aria-hidden="true">
          {t.common.before}
        </span>
        <span class="corner right" aria-hidden="true">
          {t.common.after}
        </span>
        <div
          class="divider"
          role="slider"
          tabIndex={0}
          aria-label={t.result.divider}
          aria-valuemin={0}
          aria-valuemax={100}
          aria-valuenow={Math.round(divider * 100)}
          style={{ left: `${divider * 100}%` }}
          onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
          onPointerMove={drag}
          onKeyDown={byKey}
        >
          <span class="grip" aria-hidden="true" />
        </div>
      </div>
      <div class="legend" aria-label={t.result.scale}>
        <span class="num">0</span>
        <svg class="ramp" viewBox="0 0 320 10" preserveAspectRatio="none" aria-hidden="true">
          <linearGradient id="ramp">
            {Array.from({ length: RAMP + 1 }, (_, index) => (
              <stop key={index} offset={index / RAMP} stop-color={css(index / RAMP)} />
            ))}
          </linearGradient>
          <rect width="320" height="10" fill="url(#ramp)" />
        </svg>
        <span class="num">
          {short(top)} <span class="unit">µm</span>
        </span>
      </div>
      {loaded && loaded.path.together > 1 && <p class="hint">{t.result.together(loaded.path.together)}</p>}
      {loaded && loaded.path.chords > 0 && <p class="hint">{t.result.chords(loaded.path.chords)}</p>}
      <div class="scrub">
        <button type="button" onClick={() => (at + 1 >= poses.length && setAt(0), setPlays(!plays))}>
          {plays ? t.result.pause : t.result.play}
        </button>
        <input
          type="range"
          aria-label={t.result.along}
          min={0}
          max={Math.max(0, poses.length - 1)}
          value={at}
          onInput={(event) => {
            const index = Number(event.currentTarget.value);
            setAt(index);
            const to = poses[index]?.line;
            if (to !== undefined) toLine(to);
          }}
        />
        <button type="button" onClick={() => scene.current?.fit()}>
          {t.result.fit}
        </button>
      </div>
      {pose && (
        <dl class="readout">
          <div>
            <dt>{t.result.lineNow}</dt>
            <dd class="num">{pose.line}</dd>
          </div>
          {Object.entries(pose.words).map(([axis, word]) => (
            <div key={axis}>
              <dt>{axis}</dt>
              <dd class="num">{typeof word === "number" ? word.toFixed(3).replace("-", "−") : "–"}</dd>
            </div>
          ))}
          <div>
            <dt>{t.result.deviationNow}</dt>
            <dd class="num">
              {pose.before === null || pose.after === null ? "–" : `${short(pose.before)} → ${short(pose.after)} µm`}
            </dd>
          </div>
        </dl>
      )}
    </>
  );
}
