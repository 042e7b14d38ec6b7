// The answers of the interface, as far as the page reads them. `openapi/trunnion.json` describes them all.

export interface Fault {
  pointer: string;
  detail: string;
}

/** RFC 9457. */
export interface Problem {
  type: string;
  title: string;
  status: number;
  detail: string;
  line?: number | null;
  block?: string | null;
  pose?: number | null;
  errors?: Fault[] | null;
}

export interface List<T> {
  items: T[];
  next_cursor?: string | null;
}

export type Vector = [number, number, number];
export type Axis = "X" | "Y" | "Z" | "A" | "B" | "C";
export type Words = Partial<Record<Axis, number | null>>;

export interface LocationError {
  e_x_um?: number;
  e_y_um?: number;
  e_z_um?: number;
  e_a_urad?: number;
  e_b_urad?: number;
  e_c_urad?: number;
}

export interface RotaryAxis {
  name: "A" | "B" | "C";
  side: "table" | "head";
  direction: Vector;
  point_mm: Vector;
  limits_deg?: [number, number] | null;
  reversed?: boolean;
  location_error?: LocationError;
}

export interface Kinematics {
  rotary_axes: RotaryAxis[];
  linear_limits_mm?: Partial<Record<"X" | "Y" | "Z", [number, number] | null>>;
  squareness_urad?: Record<string, number>;
}

export interface Drive {
  position_gain_per_s: number;
  [member: string]: unknown;
}

export interface MachineProfile {
  name: string;
  kinematics: Kinematics;
  program_unit?: "mm" | "inch" | null;
  work_offsets_mm?: Record<string, Vector> | null;
  max_feed_mm_per_min?: number | null;
  block_time_ms?: number | null;
  interpolation_period_s?: number;
  calibration_due_days?: number | null;
  calibration_limits?: Record<string, number> | null;
  serial_number?: string | null;
  asset_id?: string | null;
  plane_solution?: unknown;
  machine_coordinates?: unknown;
  rs274_control?: boolean | null;
  drives?: Partial<Record<Axis, Drive | null>> | null;
}

export interface Machine extends MachineProfile {
  machine_id: string;
  revision: number;
  created_at: string;
}

export interface Preset {
  id: string;
  title: string;
  description: string;
  profile: MachineProfile;
}

export interface Tool {
  machine_id: string;
  tool_id: string;
  revision: number;
  created_at: string;
  kind: "ball" | "bull-nose" | "flat" | "other";
  number?: number | null;
  name?: string | null;
  radius_mm?: number | null;
  corner_radius_mm?: number | null;
  length_mm?: number | null;
}

export const OPERATIONS = [
  "cc-compensation",
  "compensation",
  "wear-compensation",
  "verification",
  "servo-simulation",
  "posting",
] as const;
export type Operation = (typeof OPERATIONS)[number];
export const STATES = ["queued", "running", "succeeded", "failed", "cancelled"] as const;
export type JobState = (typeof STATES)[number];

export interface Job {
  id: string;
  machine_id: string;
  machine_revision: number;
  operation: Operation;
  parameters: Record<string, unknown>;
  state: JobState;
  progress: number;
  input_sha256: string;
  output_sha256?: string | null;
  changes_sha256?: string | null;
  external_id?: string | null;
  callback_url?: string | null;
  attempts: number;
  problem?: Problem | null;
  software_version: string;
  created_at: string;
  started_at?: string | null;
  finished_at?: string | null;
}

export interface DeviationSummary {
  max_um: number;
  rms_um: number;
  max_excess_um: number;
  max_gouge_um: number;
  worst_line?: number | null;
}

export interface Series {
  path_mm: number[];
  line: number[];
  before_um: number[];
  after_um: number[];
}

export interface Warning {
  kind: string;
  detail: string;
  count: number;
  line?: number | null;
  worst_line?: number | null;
}

export interface Resolved {
  unit?: string | null;
  unit_stated_by?: string | null;
  work_offsets: {
    name?: string | null;
    origin_mm?: Vector | null;
    stated_by?: string | null;
    is_left_alone: boolean;
    first_line: number;
    last_line: number;
    motions: number;
  }[];
  tools: {
    number?: number | null;
    name?: string | null;
    tool_id?: string | null;
    tool_revision?: number | null;
    is_left_alone: boolean;
    first_line: number;
    last_line: number;
    motions: number;
  }[];
}

export interface Findings {
  blocks_in: number;
  blocks_out: number;
  blocks_inserted?: number;
  motions_checked?: number;
  motions_over_tolerance?: number;
  motions_left_over?: number;
  motions_shifted?: number;
  cc_path_length_mm?: number;
  before?: DeviationSummary;
  after?: DeviationSummary;
  series?: Series;
  warnings: Warning[];
}

export interface BudgetLine {
  before_um: number;
  before_line?: number | null;
  after_um: number;
  after_line?: number | null;
}

export const BUDGET = ["interpolation", "location_errors", "wear", "rounding", "servo", "sum"] as const;

export interface Report extends Findings {
  machine_revision: number;
  software_version: string;
  input_sha256: string;
  output_sha256?: string;
  dialect: string;
  interpolation: string;
  contact?: string;
  steps?: string[] | null;
  resolved?: Resolved | null;
  cc?: Findings | null;
  wear?: Findings | null;
  error_budget?: Record<(typeof BUDGET)[number], BudgetLine>;
  changes?: {
    motions_changed: number;
    series: { line: number[]; error_before_um: number[]; error_after_um: number[] };
  };
  // Servo simulation.
  contour_error?: ContourError;
  duration_s?: number;
  motions_simulated?: number;
  // Verification.
  max_excess?: { residual_um: number; line: number } | null;
  max_gouge?: { residual_um: number; line: number } | null;
  rms_um?: number | null;
  mean_um?: number | null;
  samples?: number | ServoSamples;
  uncut?: number;
  limit_um?: number;
  excess_over_limit?: number;
  gouge_over_limit?: number;
  // Posting.
  points?: number;
  rewinds?: number;
  pole_holds?: number;
}

export interface Estimate {
  value: number;
  standard_uncertainty?: number | null;
}
export type Estimates = Record<string, Record<string, Estimate>>;

export interface Calibration {
  id: string;
  machine_id: string;
  machine_revision: number;
  kind: "rtcp-ballbar" | "rotary-sphere";
  measured_at: string;
  created_at: string;
  instrument?: string | null;
  operator?: string | null;
  temperature_c?: number | null;
  note?: string | null;
  errors: Estimates;
  iso_230: Record<string, Estimate>;
  residual_rms_um: number;
  rank: number;
  unknowns: number;
  degrees_of_freedom: number;
  condition_number?: number | null;
  unidentifiable: string[];
  blind: { words: string; separated_by?: string | null }[];
  warnings: { kind: string; detail: string; test?: number | null }[];
  tests?: { rotary_axis: string; bar_direction: string; readings: number; residual_rms_um: number }[] | null;
  eccentricities_um?: {
    before: ([number, number] | null)[];
    after_linear: ([number, number] | null)[];
    after_all: ([number, number] | null)[];
  };
  run_sha256: string;
  software_version: string;
}

export interface Trend {
  axis: string;
  error: string;
  unit: "um" | "urad";
  points: {
    calibration_id: string;
    measured_at: string;
    machine_revision: number;
    value: number;
    standard_uncertainty?: number | null;
    identifiable: boolean;
  }[];
}

export interface ContourError {
  min_um: number;
  max_um: number;
  rms_um: number;
  max_abs_um: number;
  oval?: { amplitude_um: number; major_axis_deg: number } | null;
  worst_line?: number | null;
}

export interface ServoSamples {
  t_s: number[];
  phi_deg?: number[];
  contour_error_um: number[];
  following_error_um: Record<string, number[]>;
  following_error_urad: Record<string, number[]>;
}

export interface AxisResult {
  max_following_error_um?: number | null;
  max_following_error_urad?: number | null;
  steady_state_following_error_um?: number | null;
  steady_state_following_error_urad?: number | null;
  stability: {
    kv_per_s?: number | null;
    bandwidth_hz?: number | null;
    gain_margin?: number | null;
    phase_margin_deg?: number | null;
  };
}

export interface Simulation {
  axes: Record<string, AxisResult>;
  contour_error: ContourError;
  samples: ServoSamples;
}

export interface Matching {
  gains: Record<string, { position_gain_per_s: number; scale: number }>;
  matched: ContourError;
  present: ContourError;
  reached: boolean;
  largest_kv_per_s: number;
  feed_limits: { target_um: number; matched_mm_per_min?: number | null; present_mm_per_min?: number | null }[];
}

export interface WearEntry {
  id: string;
  tool_id: string;
  cutter_id: string;
  edge?: string | null;
  measured_at: string;
  parts_cut: number;
  radius_wear_um?: number | null;
  flank_wear_um?: number | null;
  standard_uncertainty_um?: number | null;
  note?: string | null;
  withdrawn?: { reason: string; withdrawn_at: string } | null;
}

export interface Interval {
  earliest?: number | null;
  estimate?: number | null;
  latest?: number | null;
}

export interface WearTrend {
  tool_id: string;
  cutter_id?: string | null;
  quantity?: "radius" | "flank" | null;
  parts_now?: number | null;
  limit_um?: number | null;
  edges: {
    edge?: string | null;
    entries: { parts_cut: number; wear_um: number; fitted_um?: number | null; measured_at: string }[];
    fit?: { wear_um: number; rate_um_per_part: number; is_rising: boolean; scatter_um: number } | null;
  }[];
  outlook?: {
    kind: string;
    words: string;
    parts_left?: Interval | null;
    parts_at_limit?: Interval | null;
  } | null;
  warnings: { kind: string; detail: string }[];
}

export interface Scallop {
  scallop_height_um: number | null;
  max_stepover_mm?: number | null;
}

export interface Advice {
  advice: "keep" | "compensate" | "reduce-stepover" | "change-tool";
  detail: string;
  stepover_mm?: number | null;
  min_tool_radius_mm?: number | null;
  residual_before_um?: number | null;
  residual_after_um?: number | null;
}

export interface Delivery {
  delivery?: { state: string; attempts: number; next_attempt_at?: string | null } | null;
  items: { started_at: string; outcome: string; detail: string; status?: number | null }[];
}
