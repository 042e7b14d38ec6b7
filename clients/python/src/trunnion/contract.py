"""The documents of the service, generated from openapi/trunnion.json by tools/contract.py."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, Literal, TypeAlias, TypedDict

from typing_extensions import NotRequired

AdviceKind: TypeAlias = Literal["keep", "compensate", "reduce-stepover", "change-tool"]
"""The recommended action."""


class AssumedContacts(TypedDict):
    """How much of a program an assumed contact covers: the motions at feed, and their length."""

    compensated: int
    """Motions at whose end a contact is assumed; only there can the cutter's residual be compensated."""
    compensated_path_mm: float
    """Path length of the tip in the compensated cuts."""
    cuts: int
    """Straight motions at feed."""
    not_turning: int
    """Motions next to whose end no rotary axis turns; nothing is assumed there."""
    open: int
    """
    Motions whose feed direction does not determine the contact: the tool plunges, or moves across its
    axis, as along a wall or on a floor.
    """
    path_mm: float
    """Path length of the tip in all of these cuts."""


AuditAction: TypeAlias = Literal[
    "machine-created",
    "machine-replaced",
    "machine-deleted",
    "tool-created",
    "tool-replaced",
    "tool-deleted",
    "calibration-created",
    "calibration-applied",
    "wear-entries-created",
    "wear-entry-withdrawn",
    "job-created",
    "job-cancelled",
    "job-removed",
    "delivery-requested",
    "webhook-secret-created",
    "webhook-secret-rotated",
    "key-created",
    "key-revoked",
]
"""What was done."""


AuditFilters = TypedDict(
    "AuditFilters",
    {
        "machine_id": NotRequired[str],
        "key_id": NotRequired[str],
        "action": NotRequired[AuditAction],
        "from": NotRequired[str | datetime],
        "to": NotRequired[str | datetime],
    },
)


AuditOrigin: TypeAlias = Literal["http", "command-line", "service"]
"""Where a change came from."""


BarDirection: TypeAlias = Literal["radial", "tangential", "axial"]
"""Direction in which the bar points at zero."""


class Blind(TypedDict):
    """A combination of errors that the run cannot see."""

    offsets_of_tests: Sequence[int]
    """Tests whose offset (the bar's zero) is part of the combination."""
    parts_um_urad: Mapping[str, float]
    """Share of each error in a combination that changes no reading (µm, µrad); the largest share is 1."""
    separated_by: NotRequired[str | None]
    """The run that would separate these errors, in words; null if no ball-bar test would help."""
    words: str
    """The combination in words."""


class BudgetLine(TypedDict):
    """One source of error over the whole program: its largest value as programmed and as written."""

    after_line: NotRequired[int | None]
    """Line of the upload with this value."""
    after_um: float
    """Largest value as written."""
    before_line: NotRequired[int | None]
    """Line of the upload with this value."""
    before_um: float
    """Largest value as programmed."""


CalibrationKind: TypeAlias = Literal["rtcp-ballbar", "rotary-sphere"]
"""How the machine was measured."""


CalibrationLimits: TypeAlias = Mapping[str, float]
"""
The largest magnitude of each location error against the machine's frame, under its name in `iso_230` of a run
(µm or µrad).
"""


class ChangeSeries(TypedDict):
    """
    Changes along the program, down-sampled. Each point holds the largest values of the motions that it
    represents. All arrays have the same length.
    """

    cc_um: Sequence[float]
    """Largest correction between the ends of a motion."""
    error_after_um: Sequence[float]
    """Largest sum of one motion's errors as written."""
    error_before_um: Sequence[float]
    """Largest sum of one motion's errors as programmed."""
    line: Sequence[int]
    """Line of the upload with the largest sum."""
    location_errors_um: Sequence[float]
    """Largest move for location errors."""
    wear_um: Sequence[float]
    """Largest move for the worn cutter."""


Contact: TypeAlias = Literal["auto", "program", "normals", "surface", "feed-plane", "tip"]
"""Where the cutter contact comes from."""


class Convergence(TypedDict):
    """Change of the residuals when the cut is repeated with an eight times finer resolution."""

    cut_once: int
    """Samples that a tool reaches at only one of the two resolutions."""
    max_change_um: float
    """Largest change of a residual."""
    resolution_um: float
    """The finer resolution."""
    samples: int
    """Samples that were cut again: those with the largest residuals, and evenly chosen ones."""


Correction: TypeAlias = Literal["even", "foot", "seed"]
"""How a deviating block is corrected."""


class Covariance(TypedDict):
    """Covariance of the identified errors (µm², µm·µrad, µrad²)."""

    matrix_um_urad: Sequence[Sequence[float]]
    """Matrix, row by row."""
    names: Sequence[str]
    """Names of the rows and columns."""


class CurvatureAcrossFeed(TypedDict):
    """The tightest curvature of the part across the feed."""

    concave_line: NotRequired[int | None]
    """Line of the upload whose motion ends there."""
    concave_radius_mm: NotRequired[float | None]
    """Smallest radius where the part is concave; null if it is nowhere concave."""
    convex_line: NotRequired[int | None]
    """Line of the upload whose motion ends there."""
    convex_radius_mm: NotRequired[float | None]
    """Smallest radius where the part is convex; null if it is nowhere convex."""


CutcomPoints: TypeAlias = Literal["centre"]
"""The points under `CUTCOM/`."""


class DeviationSeries(TypedDict):
    """Deviation along the path, down-sampled; all arrays have the same length."""

    after_um: Sequence[float]
    """Distance after, from the text that was written."""
    before_um: Sequence[float]
    """Distance before."""
    line: Sequence[int]
    """Line of the upload."""
    path_mm: Sequence[float]
    """Path length up to the sample."""


class DeviationSummary(TypedDict):
    """Deviation of the CC path over all checked motions."""

    max_excess_um: float
    """Largest distance on the side of too much material."""
    max_gouge_um: float
    """Largest distance on the side of too little material (gouge)."""
    max_um: float
    """Largest distance from the line."""
    rms_um: float
    """Root of the mean square along the path."""
    worst_line: NotRequired[int | None]
    """Line of the upload with the largest distance; null if no motion was checked."""


Dialect: TypeAlias = Literal["auto", "iso", "siemens", "heidenhain", "apt", "csv", "okuma"]
"""Dialect of the program text."""


class Difference(TypedDict):
    """How an error differs between two runs, in the unit of its name."""

    difference: float
    """This run's value minus the other's."""
    significant: NotRequired[bool | None]
    """
    Whether the difference is more than twice its standard uncertainty; about one in twenty is so by
    chance. Null without a standard uncertainty. Also null if one of the runs does not determine the
    error: an error that cannot be separated from it may have changed instead.
    """
    standard_uncertainty: NotRequired[float | None]
    """
    Standard uncertainty of the difference; the runs count as independent. Null if one of the runs has
    none.
    """


class Eccentricities(TypedDict):
    """
    Eccentricities of each test (µm), in the order of the tests: (x, y) of a C axis, (y, z) of an A axis, (z,
    x) of a B axis. Null if the angles do not determine them.
    """

    after_all: Sequence[Sequence[float] | None]
    """Predicted eccentricities if the control compensates all errors."""
    after_linear: Sequence[Sequence[float] | None]
    """Predicted eccentricities if the control compensates only the linear errors."""
    before: Sequence[Sequence[float] | None]
    """Eccentricities as measured."""


class EdgeBasis(TypedDict):
    """What the entries of one edge say about the measurement and about how steadily the edge wears."""

    correlation: float
    """Correlation of the errors of neighbouring entries, 0 to 0.7."""
    edge: NotRequired[str | None]
    """Name of the edge; null if the cutter was measured as a whole."""
    entries: int
    """Number of entries that were used."""
    first_parts: int
    """Parts at the first part count."""
    last_parts: int
    """Parts at the last part count; the measured range is from the first to the last."""
    numbers_of_parts: int
    """Number of different part counts among these entries."""
    rate_drift: float
    """Standard deviation of the rate over the measured range, as a share of the reference rate."""
    reference_rate_um_per_part: float
    """The mean rate, to which drift and stages refer."""
    scatter_um: float
    """Standard deviation of a typical entry about the fitted course."""


class Estimate(TypedDict):
    """A value with its standard uncertainty, both in the unit of its name."""

    standard_uncertainty: NotRequired[float | None]
    """Standard uncertainty; null if the readings do not give it."""
    value: float
    """Value."""


FactorsByAxis: TypeAlias = Mapping[str, float]


class Fault(TypedDict):
    """One bad value and its location."""

    detail: str
    """Description of the fault."""
    pointer: str
    """JSON pointer into the body. For a query parameter: the pointer that its dotted name represents."""


class FeedLimit(TypedDict):
    """Fastest feed of the path for one target."""

    matched_beyond_range: bool
    """True if even the fastest feed in the range keeps the target."""
    matched_mm_per_min: NotRequired[float | None]
    """Feed limit with the matched gains; null if even the slowest feed in the range exceeds the target."""
    present_beyond_range: bool
    """True if even the fastest feed in the range keeps the target."""
    present_mm_per_min: NotRequired[float | None]
    """Feed limit with the present gains; null if even the slowest feed in the range exceeds the target."""
    target_um: float
    """Largest contour error allowed."""


class FeedProfile(TypedDict):
    """Limits of a jerk-limited feed along the path."""

    acceleration_mm_per_s2: float
    """Acceleration along the path."""
    jerk_mm_per_s3: float
    """Jerk along the path."""
    stop_at_corners_above_deg: NotRequired[float]
    """A corner of the tip's path that is sharper than this is an exact stop."""


Feedback: TypeAlias = Literal["load", "motor"]
"""Where the position of an axis is measured."""


FormulaKind: TypeAlias = Literal["plane", "sphere", "cylinder", "saddle", "blade"]
"""Which formula."""


Interpolation: TypeAlias = Literal["machine", "tcp"]
"""What the control interpolates linearly."""


JobOperation: TypeAlias = Literal[
    "cc-compensation", "servo-simulation", "wear-compensation", "verification", "compensation", "posting"
]
"""The computation of a job."""


JobState: TypeAlias = Literal["queued", "running", "succeeded", "failed", "cancelled"]
"""State of a job."""


class JointWords(TypedDict):
    """Axis words: mm for X Y Z, degrees for the two rotary axes of the machine (out of A B C)."""

    A: NotRequired[float | None]
    """A word, on a machine that has A."""
    B: NotRequired[float | None]
    """B word, on a machine that has B."""
    C: NotRequired[float | None]
    """C word, on a machine that has C."""
    X: float
    """X word."""
    Y: float
    """Y word."""
    Z: float
    """Z word."""
    conditioning: NotRequired[float | None]
    """
    How well the rotary axes can turn the tool at this pose: 1 is best, 0 is at the pole or at the reach
    limit. The service returns it and ignores it in a request.
    """


class LeftOut(TypedDict):
    """Motions that were left out for one reason."""

    count: int
    """Number of motions."""
    detail: str
    """The reason in words."""
    kind: str
    """A stable word for the reason."""
    line: int
    """First line of the upload, 1-based."""


LengthInControl: TypeAlias = Literal["nominal", "measured"]
"""Length that the control has while the written program runs."""


class Limit(TypedDict):
    """A limit."""

    environment: str
    """Name of its environment variable."""
    meaning: str
    """Meaning of the limit."""
    problem: NotRequired[str | None]
    """Type of the problem if the limit is exceeded; null if the connection is closed or the item waits instead."""
    setting: str
    """Name of the setting, as in the settings file."""
    status: NotRequired[int | None]
    """Status of the answer if the limit is exceeded; null if the connection is closed or the item waits instead."""
    unit: str
    """Unit of the value; `1` for a number of things."""
    value: float
    """Value of the limit, in its unit."""


LinearLetter: TypeAlias = Literal["X", "Y", "Z"]
"""A linear axis."""


class LocationError(TypedDict):
    """A small displacement of an axis's own frame, cascaded outward."""

    e_a_urad: NotRequired[float]
    """Rotation about X."""
    e_b_urad: NotRequired[float]
    """Rotation about Y."""
    e_c_urad: NotRequired[float]
    """Rotation about Z."""
    e_x_um: NotRequired[float]
    """Shift along X."""
    e_y_um: NotRequired[float]
    """Shift along Y."""
    e_z_um: NotRequired[float]
    """Shift along Z."""


class LocationErrorFindings(TypedDict):
    """Result of posting the program again for the calibrated machine."""

    held_at_pole: int
    """
    Motions that end inside the cone around the pole, where the axis next to the workpiece keeps its
    correction.
    """
    machine_has_errors: bool
    """Whether the machine has any location error or squareness error; without one, nothing is moved."""
    max_axis_left_line: NotRequired[int | None]
    """Line of the upload with this angle."""
    max_axis_left_urad: float
    """
    Largest angle that remains between the written tool axis and the upload's: from rounding, and near the
    pole.
    """
    max_axis_line: NotRequired[int | None]
    """Line of the upload with this angle."""
    max_axis_urad: float
    """Largest angle between the tool axes on the two machines."""
    max_tip_line: NotRequired[int | None]
    """Line of the upload with this distance."""
    max_tip_um: float
    """Largest distance between the tool tip on the calibrated machine and on the nominal machine."""
    max_turn_deg: float
    """Largest change of a rotary word; near the pole it is far larger than the errors themselves."""
    max_turn_line: NotRequired[int | None]
    """Line of the upload with this change."""
    motions_posted: int
    """Motions whose end was computed again."""
    motions_turned: int
    """Posted motions whose rotary words changed."""


LocationErrors: TypeAlias = Literal["apply", "ignore"]
"""Whether measured errors are applied."""


class MatchedGain(TypedDict):
    """A gain to set at the control."""

    position_gain_per_s: float
    """The position gain."""
    scale: float
    """New gain divided by the present gain."""


Milling: TypeAlias = Literal["end", "side"]
"""Part of the cutter that makes the surface."""


class MotionChange(TypedDict):
    """Changes that each step made to one motion of the upload."""

    blocks_out: int
    """Number of blocks that the motion became."""
    cc_um: float
    """Largest correction between the ends of the motion."""
    line: int
    """Line of the upload."""
    location_errors_um: float
    """Distance by which the end of the motion was moved for the location errors."""
    tool_axis_urad: float
    """Angle by which the tool axis at the end was turned for the location errors."""
    wear_um: float
    """Distance by which the end was moved for the worn cutter."""


class MotionError(TypedDict):
    """Errors of one motion, by source."""

    interpolation_um: float
    """Largest deviation of the contact from its line between the ends."""
    location_errors_um: float
    """Distance at the end between the contact and its place on the nominal machine."""
    rounding_um: float
    """Error from the decimals of the written words."""
    servo_um: float
    """Largest distance of the tip from its path, caused by the drives."""
    sum_um: float
    """Sum of all errors, as if all pointed in the same direction."""
    tool_axis_urad: float
    """Angle between the tool axis and the intended one."""
    wear_um: float
    """Distance between the contact of the worn cutter and that of the nominal cutter."""


MotionKind: TypeAlias = Literal["rapid", "linear", "arc"]
"""The kind of a motion."""


class MotionLeftAlone(TypedDict):
    """A motion that the service does not understand; every compensation leaves it unchanged."""

    file: NotRequired[str | None]
    """The file that contains the line, if it is not the main program."""
    line: int
    """Line of its file, 1-based."""
    reason: str
    """The reason."""


class MotionsCut(TypedDict):
    """Motions that were cut."""

    arcs: int
    """Arcs and helices."""
    linear: int
    """Straight motions at feed."""
    rapids: int
    """Rapids, treated as straight."""


class NotModelled(TypedDict):
    """An effect that the budget does not contain."""

    count: NotRequired[int | None]
    """Number of motions, if the effect belongs to some motions."""
    detail: str
    """The effect in words."""
    kind: str
    """A stable word for the effect."""
    line: NotRequired[int | None]
    """First line of the upload, if the effect belongs to some motions."""


NumbersOrNull: TypeAlias = float | Sequence[float | None] | None


NumbersOrOne: TypeAlias = float | Sequence[float]


class Outlier(TypedDict):
    """A reading that was left out."""

    reading: int
    """Index of the reading, from 0."""
    residual_um: float
    """Measured minus fitted."""
    test: int
    """Index of the test, from 0."""


Output: TypeAlias = Literal["minimal", "interpolated"]
"""Which blocks the answer has."""


class Oval(TypedDict):
    """Second harmonic of the radius error over the commanded φ."""

    amplitude_um: float
    """Half of the peak-to-peak value."""
    major_axis_deg: float
    """Direction of the major axis, in [0, 180)."""


Pair: TypeAlias = Sequence[float]


class PartsInterval(TypedDict):
    """Numbers of parts; the true number is between the earliest and the latest with 95 %."""

    earliest: NotRequired[int | None]
    """Early end; null if it is beyond the reach."""
    estimate: NotRequired[int | None]
    """Median estimate, if the wear continues as now; null if no estimate is possible."""
    latest: NotRequired[int | None]
    """Late end; null if it is beyond the reach."""


PartsOutlookKind: TypeAlias = Literal["predicted", "no-rise", "beyond-reach", "passed", "too-few-entries"]
"""What the entries say about the parts that are left."""


Plane: TypeAlias = Literal["xy", "yz", "zx"]
"""
A plane that gives the contour error a sign: positive to the right of travel, seen from the plane's
normal.
"""


PlaneRule: TypeAlias = Literal["positive-first", "negative-first", "shortest"]
"""Which of two rotary positions the control takes when both tilt the tool in the same way."""


class PlaneSolution(TypedDict):
    """Which of the two solutions CYCLE800, PLANE or G53.1 takes on this machine."""

    axis: NotRequired[str | None]
    """The rotary axis that the rule looks at; null if the control does not name one."""
    rule: PlaneRule
    """The rule."""


class Pole(TypedDict):
    """A pole of the closed loop (1/s)."""

    im_per_s: float
    """Imaginary part."""
    re_per_s: float
    """Real part."""


class PolylinePoint(TypedDict):
    """A corner of a polyline: the tip (mm) and the tool axis, which is +Z if it is not given."""

    i: NotRequired[float]
    """X component of the tool axis; give i j k together or leave out all three."""
    j: NotRequired[float]
    """Y component of the tool axis."""
    k: NotRequired[float]
    """Z component of the tool axis."""
    x: float
    """X of the tip."""
    y: float
    """Y of the tip."""
    z: float
    """Z of the tip."""


class Pose(TypedDict):
    """A tool pose in the workpiece: tip in mm, tool axis from the tip into the spindle."""

    i: float
    """X component of the tool axis."""
    j: float
    """Y component of the tool axis."""
    k: float
    """Z component of the tool axis."""
    x: float
    """X of the tip."""
    y: float
    """Y of the tip."""
    z: float
    """Z of the tip."""


PoseWarningKind: TypeAlias = Literal["rewind", "pole_hold", "reach_limit"]
"""The kind of a warning about a solution."""


class PostingBetweenPoints(TypedDict):
    """Deviations between two points, which posting cannot correct: the largest values half way between them."""

    max_axis_line: NotRequired[int | None]
    """Line of the upload with this angle."""
    max_axis_urad: float
    """Angle of the tool axis from the great circle."""
    max_tip_line: NotRequired[int | None]
    """Line of the upload with this distance."""
    max_tip_um: float
    """Distance of the tip from the straight line; 0 with `tcp`, because the control keeps the tip on it."""


class PostingReadBack(TypedDict):
    """
    The written program, read back as a control reads it and put through the forward kinematics: largest
    distances from the points of the source.
    """

    max_axis_urad: float
    """Angle of a tool axis."""
    max_tip_um: float
    """Distance of a tool tip."""


class ProblemDocument(TypedDict):
    """A problem document (RFC 9457)."""

    block: NotRequired[str | None]
    """Text of that line."""
    detail: str
    """Details of this occurrence."""
    errors: NotRequired[Sequence[Fault]]
    """Every bad value."""
    line: NotRequired[int | None]
    """Line of the upload, 1-based."""
    pose: NotRequired[int | None]
    """Index of the pose, 0-based."""
    status: int
    """The HTTP status."""
    title: str
    """The kind of problem in a sentence."""
    type: str
    """Stable reference of the kind of problem; it resolves to a page that explains it."""


ProgramUnit: TypeAlias = Literal["mm", "inch"]
"""Unit of the lengths in a program."""


RadiusOffsets: TypeAlias = Mapping[str, float]
"""Radii by register: geometry and wear together"""


class Reading(TypedDict):
    """One reading of the bar."""

    angle_deg: float
    """Word of the axis that turns."""
    length_change_um: float
    """Bar length minus its length at the start; longer is positive."""


class RegionFigures(TypedDict):
    """Speeds, turns and deviations of the motions in a region."""

    axis_deviation_deg: float
    """Largest angle between the tool axis and the great circle of its block."""
    deviation_um: float
    """Largest distance of the contact from its line; of the tip if no contact is known."""
    motions_over_speed: int
    """Number of motions that need more than the largest speed."""
    rotary_deg_per_s: NotRequired[float | None]
    """Largest speed of a rotary axis, as the mean over a block; null if no block's time is known."""
    step_deg: float
    """Largest turn of a rotary axis in one block."""
    travel_deg: float
    """Sum of the turns of both rotary axes."""


class RegionsLeft(TypedDict):
    """Regions that were left unchanged for the same reason."""

    count: int
    """Number of regions."""
    detail: str
    """The reason in words."""
    line: int
    """First line of the first region."""
    reason: str
    """A stable word for the reason."""


class ReportWarning(TypedDict):
    """Something that the caller should know."""

    count: int
    """Number of motions or points that it concerns."""
    detail: str
    """The warning in words."""
    kind: str
    """A stable word for the kind of warning."""
    line: NotRequired[int | None]
    """First line of the upload that it concerns, 1-based."""
    max_distance_um: NotRequired[float | None]
    """Largest distance, if the warning has one."""
    min_time_ms: NotRequired[float | None]
    """Shortest time, if the warning has one."""
    worst_line: NotRequired[int | None]
    """Line with the largest distance, if the warning has a distance."""


class ResidualHistogram(TypedDict):
    """
    Histogram of the residuals: `counts[i]` samples have a residual from `edges_um[i]` up to
    `edges_um[i + 1]`. The bins reach four limits to either side.
    """

    above: int
    """Number of samples at or above the last edge."""
    below: int
    """Number of samples below the first edge."""
    counts: Sequence[int]
    """Number of samples in each bin."""
    edges_um: Sequence[float]
    """Edges of the bins in rising order; one more than bins."""


class ResolvedTool(TypedDict):
    """A tool of the program."""

    first_line: int
    """First line of the upload with such a motion, rapids included."""
    is_left_alone: bool
    """
    True: the motions with this tool are left unchanged. Another tool was requested, or neither the
    request nor the table gives its dimensions.
    """
    last_line: int
    """Last line of the upload with such a motion, rapids included."""
    motions: int
    """Number of such motions, rapids included."""
    name: NotRequired[str | None]
    """The name by which the program calls it."""
    number: NotRequired[int | None]
    """The number by which the program calls it."""
    tool_id: NotRequired[str | None]
    """Id in the machine's tool table, if any value was taken from there."""
    tool_revision: NotRequired[int | None]
    """Revision of that tool."""


class ResolvedWear(TypedDict):
    """The wear of a cutter from its entries."""

    age_days: float
    """Age of that measurement at the time of the request \\[d\\]."""
    cutter_id: str
    """Id of the cutter in the tool."""
    entry_ids: Sequence[str]
    """Ids of the entries that were used."""
    measured_at: str
    """Time of that measurement."""
    radius_wear_um: float
    """Amount by which the radius is smaller: the largest wear of its edges."""
    tool_id: str
    """Id of the tool."""


class Resonance(TypedDict):
    """A resonance between motor and load."""

    damping_ratio: float
    """Damping ratio."""
    frequency_hz: float
    """Natural frequency (Hz)."""


class RotarySweep(TypedDict):
    """First and last rotary words (deg)."""

    A: NotRequired[Sequence[float]]
    """Words of A."""
    B: NotRequired[Sequence[float]]
    """Words of B."""
    C: NotRequired[Sequence[float]]
    """Words of C."""


class RotaryWords(TypedDict):
    """Rotary words."""

    A: NotRequired[float]
    """A word."""
    B: NotRequired[float]
    """B word."""
    C: NotRequired[float]
    """C word."""


class RunWarning(TypedDict):
    """Something that a metrologist should check."""

    detail: str
    """The warning in words."""
    kind: str
    """A stable word for the kind of warning."""
    test: NotRequired[int | None]
    """Index of the test, from 0."""


class ScallopAnswer(TypedDict):
    """The scallop that the passes leave."""

    effective_radius_mm: NotRequired[NumbersOrNull]
    """Radius with which the cutter cuts across the feed; only if a corner radius was given."""
    max_stepover_mm: NotRequired[NumbersOrNull]
    """Largest step-over that keeps the allowed height."""
    min_tool_radius_mm: NotRequired[NumbersOrNull]
    """
    Smallest cutter radius that keeps the allowed height at this step-over, with the same corner radius
    and lead angle; null if no cutter does.
    """
    scallop_height_um: NumbersOrNull
    """Height of the scallop between neighbouring passes, above the surface."""


class ServoPathCircle(TypedDict):
    """Two linear axes make a circle, from the first axis towards the second."""

    axes: Sequence[LinearLetter]
    """Two different axes."""
    kind: Literal["circle"]
    radius_mm: float
    """Radius of the circle."""


class ServoPathPolyline(TypedDict):
    """Straight lines of the tip; the tool axis turns along great circles."""

    kind: Literal["polyline"]
    plane: NotRequired[Plane]
    """Plane that gives the contour error a sign."""
    points: Sequence[PolylinePoint]
    """At least two corners."""


class ServoPathXcCircle(TypedDict):
    """X and C make a circle about `(center_x_mm, 0)` on the table."""

    center_x_mm: float
    """
    Distance of the centre from the C axis. It must differ from the radius, or the circle would run
    through the axis.
    """
    kind: Literal["xc-circle"]
    radius_mm: float
    """Radius of the circle."""


class ServoSamples(TypedDict):
    """
    The whole run in at most 2000 points, as columns; each point is the worst of the samples that it
    represents.
    """

    axis_error_urad: NotRequired[Sequence[float]]
    """Angle between the tool axes."""
    contour_error_um: Sequence[float]
    """Contour error."""
    following_error_um: Mapping[str, Sequence[float]]
    """Following errors of linear axes, by letter."""
    following_error_urad: Mapping[str, Sequence[float]]
    """Following errors of rotary axes, by letter."""
    line: NotRequired[Sequence[int]]
    """Line of the upload; only for a program."""
    phi_deg: NotRequired[Sequence[float]]
    """φ of the command; only for a circle."""
    t_s: Sequence[float]
    """Time from the start."""


SetupErrorSource: TypeAlias = Literal["given", "measured", "held_at_zero"]
"""Where the set-up error came from."""


Side: TypeAlias = Literal["table", "head"]
"""What a rotary axis carries."""


class SingularRegion(TypedDict):
    """Consecutive motions near a singularity."""

    after: NotRequired[RegionFigures | None]
    axis_spent_deg: float
    """
    Largest angle between the written and the programmed tool axis at a point, computed from the written
    text.
    """
    before: RegionFigures
    """Values as uploaded."""
    blocks_changed: int
    """Blocks whose words changed or that were divided."""
    blocks_inserted: int
    """Number of inserted blocks."""
    first_line: int
    """Line of the upload with its first motion."""
    kind: str
    """`pole` or `reach_limit`."""
    last_line: int
    """Line of the upload with its last motion."""
    least_angle_deg: float
    """Smallest angle between the tool axis and the singularity."""
    least_gain: float
    """Smallest turn of the tool axis for a turn of the rotary axes by 1."""
    left_reason: NotRequired[str | None]
    """Why the region, or one of its motions, was left unchanged; null if none was."""
    motions: int
    """Number of motions."""
    treatment: str
    """`reported`, `left`, `densified` or `smoothed`."""


class SingularRegions(TypedDict):
    """How singular regions are found and treated."""

    axis_tolerance_deg: NotRequired[float]
    """Largest angle between the tool axis and the programmed one."""
    max_rotary_deg_per_s: NotRequired[float]
    """Motions that need a faster rotary axis than this are counted."""
    max_step_deg: NotRequired[float]
    """Largest turn of a rotary axis in one block that `densify` writes."""
    zone_deg: NotRequired[float]
    """A motion is singular if the tool axis comes within about this angle of a pole or of the reach limit."""


SingularityAction: TypeAlias = Literal["report", "densify", "smooth"]
"""Treatment of regions where a rotary axis turns far for a small turn of the tool."""


class SingularityFindings(TypedDict):
    """Singular regions of a program. All lines are lines of the upload."""

    action: SingularityAction
    """The requested treatment."""
    after: RegionFigures
    """Values of all regions as written."""
    axis_spent_deg: float
    """Largest angle between a written and a programmed tool axis at a point."""
    before: RegionFigures
    """Values of all regions as uploaded."""
    blocks_changed: int
    """Number of blocks whose words changed."""
    blocks_inserted: int
    """Number of inserted blocks."""
    left: Sequence[RegionsLeft]
    """Regions that were left unchanged, by reason."""
    motions_checked: int
    """Number of motions at feed that were checked."""
    motions_singular: int
    """Number of checked motions in singular regions."""
    regions: Sequence[SingularRegion]
    """The first regions, in the order of the program."""
    regions_found: int
    """Number of regions."""
    regions_treated: int
    """Number of regions in which anything changed."""
    warnings: Sequence[ReportWarning]
    """Warnings about the text."""


class SphereOutlier(TypedDict):
    """A centre that does not agree with the others. The fit still uses it."""

    centre: int
    """Index of the centre, from 0."""
    distance_um: float
    """Distance from the position that the other centres give."""


SpindleBar: TypeAlias = Literal["x", "y"]
"""Direction in which the bar points while the spindle turns."""


class Squareness(TypedDict):
    """Squareness of the linear axes; X is the reference."""

    e_a0z: NotRequired[float]
    """Rotation of Z about X."""
    e_b0z: NotRequired[float]
    """Rotation of Z about Y."""
    e_c0y: NotRequired[float]
    """Rotation of Y about Z."""


class Stability(TypedDict):
    """Distance of an axis from its stability limits."""

    bandwidth_hz: NotRequired[float | None]
    """Lowest frequency at which the closed loop's gain falls below 1/√2."""
    gain_margin: NotRequired[float | None]
    """
    Factor by which the position gain can grow before the loop oscillates; null if it can grow without
    limit.
    """
    kv_per_s: NotRequired[float | None]
    """Commanded speed divided by the following error of a ramp; null if feed-forward leaves no error."""
    phase_margin_deg: NotRequired[float | None]
    """Phase that is left at the frequency where the open loop's gain is 1."""
    poles: Sequence[Pole]
    """Poles of the closed loop, slowest first."""
    resonance_peak: float
    """Largest gain of the closed loop over all frequencies."""


class StageBasis(TypedDict):
    """
    Wear stages that may come, as the two ends take them into account. They are the same for every cutter; no
    entry shows them.
    """

    rate_ratios: Sequence[float]
    """Smallest and largest rate of any other new stage, divided by the reference rate."""
    stages_per_stretch: float
    """Mean number of new stages that begin in as many parts as the measured range."""
    standstill_of_age: float
    """Mean length of such a standstill, as a share of the parts since the cutter was new."""
    standstill_share: float
    """Share of the new stages in which wear nearly stops."""


StampForm: TypeAlias = Literal["comment", "none"]
"""Whether a changed program says so in its text."""


class StartWords(TypedDict):
    """Axis words before the first block; leave out words that are not known."""

    A: NotRequired[float]
    """Position of A before the first block, if the machine has this axis."""
    B: NotRequired[float]
    """Position of B before the first block, if the machine has this axis."""
    C: NotRequired[float]
    """Position of C before the first block, if the machine has this axis."""
    X: NotRequired[float]
    """Position of X before the first block, as a word in the program's first work offset."""
    Y: NotRequired[float]
    """Position of Y before the first block, as a word in the program's first work offset."""
    Z: NotRequired[float]
    """Position of Z before the first block, as a word in the program's first work offset."""


StatedBy: TypeAlias = Literal["program", "request", "profile", "tool_table", "rule"]
"""Who stated a value."""


StepName: TypeAlias = Literal["wear", "location_errors", "cc", "singularity"]
"""A step of a compensation."""


SurfaceKind: TypeAlias = Literal["convex", "concave", "flat"]
"""Form of the surface across the feed."""


class SweepFault(TypedDict):
    """A cell of a sweep without a result."""

    detail: str
    """The reason."""
    feed: int
    """Column, from 0."""
    gain: int
    """Row, from 0."""


class TestAnswer(TypedDict):
    """One test as it was evaluated."""

    bar_direction: BarDirection
    """Direction of the bar."""
    offset_um: NotRequired[float | None]
    """Fitted offset; null if no offset was fitted."""
    readings: int
    """Number of readings; 0 if eccentricities were posted."""
    residual_rms_um: float
    """Root of the mean square of the residuals."""
    rotary_axis: str
    """Letter of the axis."""


ToolChange: TypeAlias = Literal["m6"]
"""How tools change in the program."""


ToolKind: TypeAlias = Literal["ball", "bull-nose", "flat", "other"]
"""Form of the cutter's end."""


class ToolProfile(TypedDict):
    """A tool as the shop states it: its number and name in programs, and its nominal cutter."""

    corner_radius_mm: NotRequired[float]
    """
    Corner radius. The kind gives it for a ball (the radius) and for a flat cutter (0); for a bull-nose
    cutter it is required.
    """
    kind: ToolKind
    """Form of the cutter's end."""
    length_mm: NotRequired[float]
    """Length, measured in the same way as `tool_length_mm` in a request."""
    name: NotRequired[str]
    """Name in programs, as in `T="BALL_10"` or `TOOL CALL "BALL_10"`. Upper and lower case are the same."""
    number: NotRequired[int]
    """Number in programs, as in `T12` or `TOOL CALL 12`. A tool has a number, a name or both."""
    radius_mm: NotRequired[float]
    """Cutter radius. Only a tool of the kind `other` may leave it out."""


class Transmission(TypedDict):
    """The transmission between motor and load."""

    gear_ratio: NotRequired[float | None]
    """Motor turns for each table turn; rotary axes."""
    lead_mm: NotRequired[float | None]
    """Travel for each motor turn (mm); linear axes."""
    resonance: NotRequired[Resonance | None]


class TrendFilters(TypedDict):
    """The query of `get_calibration_trend`."""

    limit: NotRequired[int]
    """Largest number of runs; the newest are taken."""
    tolerance_um: NotRequired[float]
    """Largest allowed size of a linear error: the figure has lines at plus and minus this value."""
    tolerance_urad: NotRequired[float]
    """The same for an angle."""
    measured_from: NotRequired[str | datetime]
    """Only runs measured at this time or later (RFC 3339)."""
    measured_to: NotRequired[str | datetime]
    """Only runs measured at this time or earlier (RFC 3339)."""


class TrendPoint(TypedDict):
    """One run of a trend."""

    calibration_id: str
    """Id of the run."""
    identifiable: bool
    """Whether the run determines the error."""
    machine_revision: int
    """Revision of the machine at that time."""
    measured_at: str
    """Time of the measurement."""
    standard_uncertainty: NotRequired[float | None]
    """Standard uncertainty; null if the run does not give it."""
    value: float
    """Value of the error, in the unit of the trend."""


Vector: TypeAlias = Sequence[float]


class Version(TypedDict):
    """The running version."""

    name: str
    """`trunnion`."""
    version: str
    """The version that reports and jobs name."""


class WearEntryRequest(TypedDict):
    """A measured wear, either of the radius or of the flank."""

    cutter_id: NotRequired[str]
    """Id of the cutter in the tool's holder; a new or reground cutter gets a new id."""
    edge: NotRequired[str]
    """Name of the edge, if several are measured."""
    flank_wear_um: NotRequired[float]
    """Width of the wear land on the flank."""
    measured_at: str
    """Time of the measurement (RFC 3339); not in the future."""
    note: NotRequired[str]
    """Any note."""
    parts_cut: int
    """Parts cut since this cutter was new."""
    radius_wear_um: NotRequired[float]
    """Decrease of the radius against the new cutter."""
    standard_uncertainty_um: NotRequired[float]
    """Standard uncertainty of the wear."""


class WearFit(TypedDict):
    """What the entries of an edge say about it at the last entry."""

    is_rising: bool
    """True if it is more than 90 % sure that the wear grows."""
    rate_um_per_part: float
    """Rate of growth."""
    scatter_um: float
    """Standard deviation of a typical entry about the fit."""
    wear_um: float
    """Fitted wear."""


WearFrom: TypeAlias = Literal["entries"]
"""Source of a cutter's wear."""


class WearOffset(TypedDict):
    """Smallest and largest offset."""

    max_um: float
    """Largest offset."""
    min_um: float
    """Smallest offset."""


class WearOutlook(TypedDict):
    """The scallop that one cutter leaves."""

    max_stepover_mm: float
    """Largest step-over that keeps the allowed height."""
    scallop_height_um: NotRequired[float | None]
    """Scallop at the program's step-over; null if neighbouring passes do not meet."""


WearQuantity: TypeAlias = Literal["radius", "flank"]
"""The quantity that was measured on a cutter."""


WearSource = TypedDict(
    "WearSource",
    {
        "cutter_id": str,
        "from": WearFrom,
    },
)


class WearTable(TypedDict):
    """Wear that varies along the corner: deviations over the contact angle, linear between the entries."""

    contact_angle_deg: Sequence[float]
    """Angles between surface normal and tool axis, rising from 0 to at most 90."""
    deviation_um: Sequence[float]
    """How far the cutter's surface is outside the nominal corner; negative for wear."""


class WearTool(TypedDict):
    """A cutter, nominal or as measured."""

    corner_radius_mm: NotRequired[float]
    """Corner radius: equal to the radius for a ball (the default), 0 for a flat cutter."""
    length_mm: NotRequired[float]
    """
    Length. If both cutters have one, the control keeps the nominal length; else it has the measured
    length.
    """
    radius_mm: float
    """Cutter radius."""


class WearTrendPoint(TypedDict):
    """One entry of a trend."""

    fitted_um: NotRequired[float | None]
    """Fitted wear at this entry, from all entries of the edge; null without a fit."""
    id: str
    """Id of the entry."""
    measured_at: str
    """Time of the measurement."""
    parts_cut: int
    """Parts cut since the cutter was new."""
    standard_uncertainty_um: NotRequired[float | None]
    """Standard uncertainty of the wear; null if none was stated."""
    wear_um: float
    """The wear."""


class WearWarning(TypedDict):
    """Something that a person should check."""

    detail: str
    """The warning in words."""
    edge: NotRequired[str | None]
    """Name of the edge; null if the cutter was measured as a whole, or if the warning concerns all edges."""
    kind: str
    """`wear-falls`, `edge-without-fit`, `edge-behind`, `uncertainties-left-out`."""


class Withdrawal(TypedDict):
    """The withdrawal of a wrong entry."""

    reason: str
    """The reason."""
    withdrawn_at: str
    """Time of the withdrawal."""


WorkOffsets: TypeAlias = Mapping[str, Vector]
"""Work offsets by name: X Y Z of the programming zero in machine coordinates at zero pose"""


class WorstResidual(TypedDict):
    """The residual at the worst sample of one sign."""

    line: int
    """Line of the upload that left it."""
    residual_um: float
    """Material above the surface along the normal; negative below it."""
    sample: int
    """Index of the sample: its row in the table of residuals, from 0."""
    x_mm: float
    """X of the sample on the nominal surface, in W."""
    y_mm: float
    """Y of the sample."""
    z_mm: float
    """Z of the sample."""


class AuditEntry(TypedDict):
    """One change of the stored data."""

    action: AuditAction
    """What was done."""
    at: str
    """Time of the change."""
    key_id: NotRequired[str | None]
    """The key of the request; null if the service needs no keys, or if the change did not come by HTTP."""
    machine_id: NotRequired[str | None]
    """The machine that the change concerns."""
    method: NotRequired[str | None]
    """HTTP method of the request."""
    origin: AuditOrigin
    """Where the change came from."""
    request_id: NotRequired[str | None]
    """`X-Request-Id` of the answer; the log lines have it too."""
    resource: str
    """Address of the changed resource."""
    revision_after: NotRequired[int | None]
    """Revision of the machine or tool after the change."""
    revision_before: NotRequired[int | None]
    """
    Revision of the machine, or of the tool that `resource` names, before the change. Null if there was no
    revision before, or if the changed resource has no revisions.
    """
    route: NotRequired[str | None]
    """Path template of the request."""
    seq: int
    """Counts up with every change; gaps mean nothing."""
    sha256: str
    """SHA-256 of this entry and of the entry before it: the entries form a chain (`docs/security.md`)."""


class AxisResult(TypedDict):
    """Results of one axis: µm and mm/min for a linear axis, µrad and deg/min for a rotary axis."""

    max_following_error_um: NotRequired[float | None]
    """Largest following error over the evaluated samples."""
    max_following_error_urad: NotRequired[float | None]
    """Largest following error over the evaluated samples."""
    max_speed_deg_per_min: NotRequired[float | None]
    """Largest commanded speed."""
    max_speed_mm_per_min: NotRequired[float | None]
    """Largest commanded speed."""
    rms_following_error_um: NotRequired[float | None]
    """Root mean square of the following error."""
    rms_following_error_urad: NotRequired[float | None]
    """Root mean square of the following error."""
    stability: Stability
    """Margins, bandwidth and poles."""
    steady_state_following_error_um: NotRequired[float | None]
    """Following error in the steady state of a ramp at the largest commanded speed."""
    steady_state_following_error_urad: NotRequired[float | None]
    """Following error in the steady state of a ramp at the largest commanded speed."""


class BallBarTest(TypedDict):
    """
    One test: one axis turns while RTCP holds the ball; the other axis is at zero. It has either readings or
    the two eccentricities.
    """

    ball_mm: Vector
    """
    Position of the programmed spindle ball at zero, from the reference point of the table axis next to
    the workpiece (the C centre of an AC table).
    """
    bar_direction: BarDirection
    """Direction in which the bar points at zero."""
    eccentricity_um: NotRequired[Pair | None]
    reading_uncertainty_um: NotRequired[float | None]
    """
    Standard uncertainty u of one reading, if the tests differ: the weights are 1/u². Give it for all
    tests or for none.
    """
    readings: NotRequired[Sequence[Reading] | None]
    """Readings in the order of measurement: the forward sweep, then the sweep back."""
    rotary_axis: str
    """Letter of the axis that turns."""
    tool_length_mm: NotRequired[float | None]
    """
    Distance from the gauge point to the spindle ball; 0 by default. It matters only if the axis that
    turns is on the head.
    """


class BlockBudget(TypedDict):
    """One of the worst blocks."""

    after: MotionError
    """Errors as written."""
    before: MotionError
    """Errors as programmed."""
    line: int
    """Line of the upload."""


CalibrationDifference = TypedDict(
    "CalibrationDifference",
    {
        "errors": Mapping[str, Mapping[str, Difference]],
        "from": str,
        "id": str,
        "iso_230": Mapping[str, Difference],
        "machine_id": str,
    },
)


class CalibrationFilters(TypedDict):
    """The query of `list_calibrations`."""

    kind: NotRequired[CalibrationKind]
    """Only runs of this kind."""
    measured_from: NotRequired[str | datetime]
    """Only runs measured at this time or later (RFC 3339)."""
    measured_to: NotRequired[str | datetime]
    """Only runs measured at this time or earlier (RFC 3339)."""


class CcFindings(TypedDict):
    """What the compensation found and did."""

    after: DeviationSummary
    """Deviation of the answer, computed from its own text."""
    before: DeviationSummary
    """Deviation of the upload."""
    blocks_in: int
    """Number of blocks in the upload."""
    blocks_inserted: int
    """Number of inserted blocks."""
    blocks_out: int
    """Number of blocks in the answer."""
    cc_path_length_mm: float
    """Sum of the chords of the checked motions."""
    contact: Contact
    """Source of the cutter contact."""
    dialect: Dialect
    """Dialect in which the text was read."""
    feeds_restored: NotRequired[int]
    """Number of blocks that only got the source's F word back, after divided blocks."""
    interpolation: Interpolation
    """Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so."""
    motions_checked: int
    """Number of motions whose deviation was computed."""
    motions_left_over: NotRequired[int]
    """Number of motions over the tolerance that were not divided; a warning gives the reason."""
    motions_over_tolerance: int
    """Number of checked motions that exceeded the tolerance."""
    series: DeviationSeries
    """Deviation along the path."""
    singularity: NotRequired[SingularityFindings | None]
    warnings: Sequence[ReportWarning]
    """Warnings to the caller."""


class CcParameters(TypedDict):
    """Parameters of the compensation of the CC path."""

    allow_repeated: NotRequired[bool]
    """
    Apply the steps `cc` and `singularity` again to a program that already has their stamp, or is an earlier
    answer of theirs. A program that was smoothed before is not smoothed again. Steps that move ends are never
    repeated.
    """
    chordal_tolerance_um: NotRequired[float]
    """Largest distance of the uploaded facets from the smooth surface that they represent; default 10."""
    contact: NotRequired[Contact]
    """Where the cutter contact comes from."""
    contact_gap_um: NotRequired[float]
    """
    The cutter touches the uploaded surface if it is at most this far above or inside the facets; default
    100.
    """
    corner_radius_mm: NotRequired[float]
    """Corner radius r. If it is absent, it equals the cutter radius (a ball-end cutter)."""
    correction: NotRequired[Correction]
    """How a deviating block is corrected."""
    dialect: NotRequired[Dialect]
    """Dialect of the program text."""
    feed_mm_per_min: NotRequired[float]
    """Feed, if the program has none."""
    flatten: NotRequired[bool]
    """
    Write the loops and calls of the program out, and compensate the result: one program without loops and
    calls. Without it, motions after a call are left unchanged, and a program with loops is refused.
    """
    interpolation: NotRequired[Interpolation]
    """Interpolation of the control. If it is absent, the program decides."""
    max_feed_mm_per_min: NotRequired[float]
    """
    Largest F that the service writes; a block whose parts need a larger F stays as it is. If it is
    absent, the machine's `max_feed_mm_per_min` is used; without that, ten times the programmed feed.
    """
    output: NotRequired[Output]
    """Which blocks the answer has."""
    pass_break_deg: NotRequired[float]
    """
    If the feed direction turns by more than this angle, a new pass begins for an assumed contact
    (`feed-plane`).
    """
    radius_offsets_mm: NotRequired[RadiusOffsets]
    """Radii in the registers that G41 and G42 name, geometry and wear together."""
    singular_regions: NotRequired[SingularRegions]
    """
    How singular regions are found and treated; as query parameters one for each, such as
    `singular_regions.axis_tolerance_deg`.
    """
    singularity: NotRequired[SingularityAction]
    """Treatment of singular regions, before all other steps."""
    stamp: NotRequired[StampForm]
    """Whether a changed program gets a comment that says so."""
    start: NotRequired[StartWords]
    """Positions of the axes before the first block, as words in the program's first work offset."""
    surface_unit_mm: NotRequired[float]
    """Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1."""
    tolerance_um: NotRequired[float]
    """Largest allowed distance of the CC path from its line."""
    tool_length_mm: NotRequired[float]
    """
    Length of the tool, for head axes and machine coordinates. Zero is a valid answer. If it is absent,
    the machine's tool table is used.
    """
    tool_number: NotRequired[int]
    """
    Number of the tool to work on, if the program has several; motions with other tools are left
    unchanged. A program that calls no tool runs with this one. If it is absent, each section gets
    its tool from the machine's tool table.
    """
    tool_radius_mm: NotRequired[float]
    """
    Cutter radius R. If it is absent, the machine's tool table gives it. Only `contact=tip` needs no
    radius.
    """
    unit: NotRequired[ProgramUnit]
    """
    Unit of the lengths if the program does not state one. If it is absent, the machine's
    `program_unit` is used.
    """
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose, for a program that names at most
    one work offset. Zero is a valid answer. If it is absent, the machine's `work_offsets_mm` are
    used.
    """
    work_offsets_mm: NotRequired[WorkOffsets]
    """Origins of the work offsets that the program names. In a query: `work_offsets_mm.G54.1 P3`."""


class CcStep(TypedDict):
    """The step for the cutter-contact path; its members mean the same as in a cc compensation."""

    contact: NotRequired[Contact]
    """Where the cutter contact comes from."""
    corner_radius_mm: NotRequired[float]
    """Corner radius r. If it is absent, it equals the cutter radius (a ball-end cutter)."""
    correction: NotRequired[Correction]
    """How a deviating block is corrected."""
    output: NotRequired[Output]
    """Which blocks the answer has."""
    pass_break_deg: NotRequired[float]
    """
    If the feed direction turns by more than this angle, a new pass begins for an assumed contact
    (`feed-plane`).
    """
    tolerance_um: NotRequired[float]
    """Largest allowed distance of the CC path from its line."""
    tool_radius_mm: NotRequired[float]
    """
    Cutter radius R that the program was made for. If it is absent, the step `wear` gives it. A cutter other
    than `wear.nominal_tool` is refused.
    """


class Changes(TypedDict):
    """Changes that the steps made to the blocks. The job's table of changes has every motion."""

    changes_sha256: str
    """SHA-256 of the table of changes."""
    motions_changed: int
    """Number of motions that any step changed."""
    series: ChangeSeries
    """All changes, down-sampled."""
    worst: Sequence[MotionChange]
    """Motions with the largest sum of changes, largest first."""


class ContourError(TypedDict):
    """
    Contour error over the evaluated samples. On a circle it is the radius error, positive outside. On other
    paths it is the distance from the commanded path, with a sign if a plane is given.
    """

    axis_max_urad: NotRequired[float | None]
    """Largest angle between the actual and the commanded tool axis."""
    axis_rms_urad: NotRequired[float | None]
    """Root mean square of this angle."""
    max_abs_um: float
    """Largest absolute value."""
    max_um: float
    """Largest value."""
    min_um: float
    """Smallest value."""
    oval: NotRequired[Oval | None]
    rms_um: float
    """Root mean square."""
    worst_at_s: float
    """Time of the largest absolute value."""
    worst_line: NotRequired[int | None]
    """Line of the program at that time."""


class Drive(TypedDict):
    """The constants of one cascaded drive."""

    acceleration_feedforward: NotRequired[float]
    """Share of the commanded acceleration fed forward."""
    back_emf_v_s_per_rad: float
    """Back EMF constant (V s/rad)."""
    current_gain_v_per_a: float
    """Current gain (V/A)."""
    damping_nm_s_per_rad: float
    """Viscous damping (Nm s/rad)."""
    feedback: NotRequired[Feedback]
    """Where the position is measured."""
    inductance_h: float
    """Winding inductance (H)."""
    inertia_kg_m2: float
    """Inertia on the motor shaft (kg m²)."""
    load_inertia_kg_m2: NotRequired[float | None]
    """Load inertia on the motor shaft, if it is modelled separately (kg m²)."""
    load_torque_nm: NotRequired[float]
    """Constant load torque; it acts from t = 0 on (Nm)."""
    position_gain_per_s: float
    """Position gain (1/s)."""
    resistance_ohm: float
    """Winding resistance (Ω)."""
    torque_constant_nm_per_a: float
    """Torque constant (Nm/A)."""
    transmission: Transmission
    """The transmission between motor and load."""
    velocity_feedforward: NotRequired[float]
    """Share of the commanded velocity fed forward."""
    velocity_gain_a_s_per_rad: float
    """Velocity gain (A s/rad)."""
    velocity_integral_time_s: float
    """Integral time of the velocity loop (s)."""


class DrivePreset(TypedDict):
    """A drive, with the source of its numbers."""

    assumed: Sequence[str]
    """Constants that were assumed because no source gives them; all others are published values."""
    axes: Sequence[str]
    """Axes that the drive is made for."""
    drive: Drive
    """The constants."""
    id: str
    """Id of the drive."""
    title: str
    """Short title."""


class Drives(TypedDict):
    """Drives by axis letter."""

    A: NotRequired[Drive | None]
    B: NotRequired[Drive | None]
    C: NotRequired[Drive | None]
    X: NotRequired[Drive | None]
    Y: NotRequired[Drive | None]
    Z: NotRequired[Drive | None]


class ErrorBudget(TypedDict):
    """Contribution of each source to the error, as programmed and as written."""

    interpolation: BudgetLine
    """Error of the contact between the ends of blocks."""
    location_errors: BudgetLine
    """Error from location errors at the ends of blocks."""
    not_modelled: Sequence[NotModelled]
    """Effects that the budget does not contain."""
    rounding: BudgetLine
    """Error from the decimals of the written words."""
    servo: BudgetLine
    """Error from the drives, on the written program."""
    sum: BudgetLine
    """The largest sum of one block."""
    tool_axis_after_urad: float
    """Largest angle between the tool axis and the intended one, as written."""
    tool_axis_before_urad: float
    """Largest angle between the tool axis and the intended one, as programmed."""
    wear: BudgetLine
    """Error from the worn cutter at the ends of blocks."""
    worst: Sequence[BlockBudget]
    """Blocks with the largest sum as written, largest first."""


class ForwardAnswer(TypedDict):
    """Tool poses."""

    machine_revision: int
    """Revision of the machine that was used."""
    poses: Sequence[Pose]
    """Tool poses in the workpiece."""


class InterpretationParameters(TypedDict):
    """Parameters of the interpretation of a program."""

    dialect: NotRequired[Dialect]
    """Dialect of the program text."""
    feed_mm_per_min: NotRequired[float]
    """Feed, if the program has none."""
    interpolation: NotRequired[Interpolation]
    """Interpolation of the control. If it is absent, the program decides."""
    radius_offsets_mm: NotRequired[RadiusOffsets]
    """Radii in the registers that G41 and G42 name, geometry and wear together."""
    start: NotRequired[StartWords]
    """Positions of the axes before the first block, as words in the program's first work offset."""
    tool_length_mm: NotRequired[float]
    """
    Length of the tool, for head axes and machine coordinates. Zero is a valid answer. If it is absent,
    the machine's tool table is used.
    """
    tool_number: NotRequired[int]
    """
    Number of the tool to work on, if the program has several; motions with other tools are left
    unchanged. A program that calls no tool runs with this one. If it is absent, each section gets
    its tool from the machine's tool table.
    """
    unit: NotRequired[ProgramUnit]
    """
    Unit of the lengths if the program does not state one. If it is absent, the machine's
    `program_unit` is used.
    """
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose, for a program that names at most
    one work offset. Zero is a valid answer. If it is absent, the machine's `work_offsets_mm` are
    used.
    """
    work_offsets_mm: NotRequired[WorkOffsets]
    """Origins of the work offsets that the program names. In a query: `work_offsets_mm.G54.1 P3`."""


class InterpretedMotion(TypedDict):
    """
    A motion as the service understands it. Values that are not known are null. Units are millimetres and
    degrees, whatever the unit of the program.
    """

    axis: NotRequired[Sequence[float] | None]
    """Tool axis at the end of the motion in W, from the tip to the spindle."""
    centre_mm: NotRequired[Sequence[float] | None]
    """For an arc: its centre in W, at the height of the start."""
    feed_mm_per_min: NotRequired[float | None]
    """The tip's speed that F asks for; null for a rapid, and if F is per turn of the spindle."""
    file: NotRequired[str | None]
    """The file that contains the line; null for the main program."""
    joints: Mapping[str, float | None]
    """
    The words at the end of the motion by letter, absolute, as the control counts them. Under tool centre
    point control X Y Z belong to the tip.
    """
    kind: MotionKind
    """Kind of the motion."""
    line: int
    """Line of its file, 1-based."""
    normal: NotRequired[Sequence[float] | None]
    """For an arc: the direction in W about which it runs counter-clockwise."""
    tip_mm: NotRequired[Sequence[float] | None]
    """Tip position at the end of the motion in W; null if an offset or a rotary position is not known."""
    tool_name: NotRequired[str | None]
    """Name of the tool, if the program calls it by name."""
    tool_number: NotRequired[int | None]
    """
    Number of the tool in the spindle. If the program calls the tool by name, the machine's tool table
    gives the number.
    """
    turns: NotRequired[float | None]
    """For an arc: the number of turns."""
    work_offset: NotRequired[str | None]
    """The work offset in force, by the name in the program."""


class JobDocument(TypedDict):
    """A job: the operation, the machine, the uploaded bytes and the result."""

    attempts: int
    """Number of computations that were started; an orderly stop of the service does not count."""
    callback_url: NotRequired[str | None]
    """Address that gets a webhook when the job ends."""
    changes_sha256: NotRequired[str | None]
    """SHA-256 of the table of changes, if the operation makes one."""
    created_at: str
    """Time at which the job was accepted."""
    external_id: NotRequired[str | None]
    """The client's own id."""
    finished_at: NotRequired[str | None]
    """Time at which the job ended."""
    id: str
    """`UUIDv7`."""
    input_sha256: str
    """SHA-256 of the upload."""
    machine_id: str
    """The machine."""
    machine_revision: int
    """Revision of the machine that was used."""
    operation: JobOperation
    """The operation that was computed."""
    output_sha256: NotRequired[str | None]
    """SHA-256 of the resulting program, or of the table of residuals of a verification."""
    parameters: Mapping[str, Any]
    """Parameters of the operation, with defaults filled in."""
    problem: NotRequired[ProblemDocument | None]
    """Why it failed."""
    progress: float
    """Completed share, 0 to 1."""
    software_version: str
    """Version of the service."""
    started_at: NotRequired[str | None]
    """Time at which the computation started."""
    state: JobState
    """State of the job."""
    surface_sha256: NotRequired[str | None]
    """SHA-256 of the part's surface, if one was uploaded."""


class JobFilters(TypedDict):
    """The query of `list_jobs`."""

    machine_id: NotRequired[str]
    """Only jobs of this machine."""
    state: NotRequired[JobState]
    """Only jobs in this state."""
    external_id: NotRequired[str]
    """Only jobs with this client id."""
    operation: NotRequired[JobOperation]
    """Only jobs with this operation."""
    created_after: NotRequired[str | datetime]
    """Only jobs created at this time or later (RFC 3339, for example `2026-03-14T09:26:53.589Z`)."""
    created_before: NotRequired[str | datetime]
    """Only jobs created before this time (RFC 3339)."""
    input_sha256: NotRequired[str]
    """Only jobs that read a program with this SHA-256."""
    output_sha256: NotRequired[str]
    """Only jobs that wrote a program with this SHA-256."""


class LinearLimits(TypedDict):
    """Travel of the linear words; null for an axis without limits."""

    X: NotRequired[Pair | None]
    Y: NotRequired[Pair | None]
    Z: NotRequired[Pair | None]


class MachineCoordinates(TypedDict):
    """Where the control's machine coordinates count from."""

    external_offset_mm: NotRequired[Vector | None]
    reference_positions: NotRequired[Sequence[Mapping[str, float]]]
    """Machine coordinates of G28, then of G30 P2, P3 and P4, by axis letter: mm or degrees."""
    retract_z_mm: NotRequired[float | None]
    """Z in machine coordinates at which `M140 MB MAX` ends."""
    tool_length_counts: NotRequired[bool | None]
    """Whether the tool length in force counts in machine coordinates."""
    zero_mm: Vector
    """Place of the gauge point, with rotary axes at zero, when X Y Z stand at zero in machine coordinates."""


class MatchingAnswer(TypedDict):
    """Gains that reach the target."""

    feed_limits: Sequence[FeedLimit]
    """Feed limits, one for each target."""
    gains: Mapping[str, MatchedGain]
    """Gains by axis letter. All axes reach the same Kv, the smallest that keeps the first target."""
    largest_kv_per_s: float
    """Largest common Kv within the margins."""
    machine_revision: NotRequired[int | None]
    """Revision of the machine; null if the drives came with the request."""
    matched: ContourError
    """Contour error with these gains, at the feed of the request."""
    present: ContourError
    """Contour error with the present gains, at the feed of the request."""
    reached: bool
    """True if these gains keep the first target; otherwise they are the best within the margins."""
    software_version: str
    """Version of the service."""


class NominalSurface(TypedDict):
    """A surface given by a formula, in W. Members that do not belong to its `kind` are refused."""

    camber_deg: NotRequired[float]
    """Angle by which a blade's camber line turns."""
    camber_length_mm: NotRequired[float]
    """Length of a blade's camber line."""
    center_mm: NotRequired[Vector]
    """Position of the centre; for a blade the middle of the camber line at the root."""
    concave_radius_mm: NotRequired[float]
    """Concave radius of a saddle, along Y."""
    convex_radius_mm: NotRequired[float]
    """Convex radius of a saddle, along X."""
    half_angle_deg: NotRequired[float]
    """Half the angle that the patch spans; default 45."""
    kind: FormulaKind
    """Which formula."""
    leading_radius_mm: NotRequired[float]
    """Radius of a blade's leading edge."""
    length_mm: NotRequired[float]
    """Length of a plane, cylinder or saddle."""
    radius_mm: NotRequired[float]
    """Radius of a sphere or cylinder."""
    rotation_vector_deg: NotRequired[Vector]
    """Rotation about the centre: the direction is the axis, the length is the angle."""
    side: NotRequired[SurfaceKind]
    """Convex or concave, for a sphere or cylinder; default convex."""
    span_mm: NotRequired[float]
    """Height of a blade."""
    thickness_mm: NotRequired[float]
    """Largest thickness of a blade."""
    trailing_radius_mm: NotRequired[float]
    """Radius of a blade's trailing edge."""
    twist_deg: NotRequired[float]
    """Angle by which a blade's profile at the tip is turned against the profile at the root."""
    width_mm: NotRequired[float]
    """Width of a plane or saddle."""


class OutlookBasis(TypedDict):
    """The basis of the numbers of parts."""

    edges: Sequence[EdgeBasis]
    """The edges that the numbers come from."""
    model: str
    """The model: `straying-rate-with-stages`."""
    reach_parts: int
    """Number of parts up to which an outlook is given."""
    stages: StageBasis
    """The wear stages that may come."""


class PartsOutlook(TypedDict):
    """The parts left until the limit."""

    basis: NotRequired[OutlookBasis | None]
    first_edge: NotRequired[str | None]
    """
    The edge that most likely reaches the limit first, or has passed it; null also if the cutter was
    measured as a whole.
    """
    kind: PartsOutlookKind
    """What can be said."""
    parts_at_limit: NotRequired[PartsInterval | None]
    parts_at_limit_in_this_stage: NotRequired[PartsInterval | None]
    parts_left: NotRequired[PartsInterval | None]
    words: str
    """The outlook in words, with the reason if a number is missing."""


class PoseWarning(TypedDict):
    """A warning about one pose."""

    axis_residual_urad: NotRequired[float | None]
    """Angle between the requested tool axis and the one that was reached."""
    kind: PoseWarningKind
    """Kind of the warning."""
    pose: int
    """Index of the pose, from 0."""


class PostingParameters(TypedDict):
    """Parameters of a posting."""

    arc_tolerance_um: NotRequired[float]
    """Largest distance between an arc and the lines that replace it."""
    cutcom: NotRequired[CutcomPoints]
    """What the points under `CUTCOM/` are. If it is absent, they are refused."""
    dialect: NotRequired[Dialect]
    """Dialect of the upload: cutter location data, so `auto` or `apt`."""
    interpolation: NotRequired[Interpolation]
    """
    Meaning of X Y Z in the program: tool tips under G43.4 with the tip's feed (`tcp`), or axis positions
    with inverse-time feed (`machine`).
    """
    length_offset_number: NotRequired[int]
    """
    H of G43.4 (`machine`: of G43, only with this or `tool_change`). If absent, the length register or the
    number of the tool, else 1 with a warning.
    """
    linear_decimals: NotRequired[int]
    """Digits after the decimal point of X Y Z."""
    location_errors: NotRequired[LocationErrors]
    """Whether measured errors of the machine are applied."""
    rotary_decimals: NotRequired[int]
    """Digits after the decimal point of the rotary words."""
    start: NotRequired[RotaryWords]
    """Rotary words before the first point, one query parameter for each: `start.A`, `start.C`."""
    tool_change: NotRequired[ToolChange]
    """How tools change. If it is absent, the program has one tool and no change."""
    tool_length_mm: NotRequired[float]
    """
    Length of the tool; it matters only for head axes. Zero is a valid answer. If it is absent, the
    machine's tool table is used.
    """
    tool_number: NotRequired[int]
    """Number of the tool. If it is absent, it is the tool that the data load."""
    unit: NotRequired[ProgramUnit]
    """Unit of the lengths if the data state none. If it is absent, the machine's `program_unit` is used."""
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose. Zero is a valid answer; the member is
    needed if words depend on it.
    """


class ResolvedOffset(TypedDict):
    """A work offset of the program."""

    first_line: int
    """First line of the upload with such a motion."""
    is_left_alone: bool
    """
    True: the motions under this offset are left unchanged. Its position is not stated, or the program
    shifts it in a way that is not understood.
    """
    last_line: int
    """Last line of the upload with such a motion."""
    motions: int
    """Number of such motions."""
    name: NotRequired[str | None]
    """The name in the program; null before the program names one, and if it is not known."""
    origin_mm: NotRequired[Sequence[float] | None]
    """Origin of the workpiece in machine coordinates at zero pose; null if it is not stated."""
    stated_by: NotRequired[StatedBy | None]


class RotaryAxis(TypedDict):
    """One rotary axis."""

    direction: Vector
    """Direction at zero pose; the service normalises it."""
    limits_deg: NotRequired[Pair | None]
    location_error: NotRequired[LocationError]
    """Measured displacement of the axis's own frame."""
    name: str
    """Address letter: A, B or C."""
    point_mm: Vector
    """
    A point on the axis: in machine coordinates for a table axis, relative to the zero-pose gauge point for a
    head axis.
    """
    reversed: NotRequired[bool]
    """True if the control counts opposite to ISO 841."""
    side: Side
    """What the axis carries: the workpiece (table) or the tool (head)."""


class ScallopRequest(TypedDict):
    """
    Neighbouring passes of a cutter. Every number may be an array: all arrays have the same length, and a
    single number is used for every element.
    """

    allowed_scallop_um: NotRequired[NumbersOrOne]
    """Allowed height. If it is given, the answer also has the largest step-over and the smallest tool."""
    corner_radius_mm: NotRequired[NumbersOrOne]
    """Corner radius of a bull-nose cutter, 0 for a flat cutter; if it is absent, the cutter is a ball."""
    lead_deg: NotRequired[NumbersOrOne]
    """Inclination of the tool axis in the feed direction; needed if the cutter is not a ball."""
    stepover_mm: NumbersOrOne
    """Chord between neighbouring contact points on the surface."""
    surface: SurfaceKind
    """Form of the surface across the feed."""
    surface_radius_mm: NotRequired[NumbersOrOne]
    """Radius of the surface's normal curvature across the feed; leave it out for a flat surface."""
    tool_radius_mm: NumbersOrOne
    """Radius of the ball, or of the cutter."""


class ServoPathConeFrustum(TypedDict):
    """
    The bottom edge of a cone frustum, flank-milled: the tip is on a circle, the tool axis along the
    generatrix.
    """

    center_mm: NotRequired[Vector]
    """Centre of the bottom circle in the workpiece."""
    half_apex_deg: float
    """Angle between generatrix and cone axis."""
    kind: Literal["cone-frustum"]
    radius_mm: float
    """Radius of the bottom circle."""
    tilt_deg: NotRequired[float]
    """Tilt of the cone axis out of Z, about Y."""


class ServoPathProgram(TypedDict):
    """
    A program on its machine; the run is stored as a job. Post a larger program as a file to
    `/v1/machines/{machine_id}/servo-simulation`.
    """

    dialect: NotRequired[Dialect]
    """Dialect of the text."""
    file_name: NotRequired[str]
    """File name of the program."""
    interpolation: NotRequired[Interpolation]
    """Interpolation of the control. If it is absent, the program decides."""
    kind: Literal["program"]
    plane: NotRequired[Plane]
    """Plane that gives the contour error a sign."""
    start: NotRequired[StartWords]
    """Positions of the axes before the first block."""
    text: str
    """The program."""
    tool_number: NotRequired[int]
    """Number of the tool to simulate, if the program has several."""
    unit: NotRequired[ProgramUnit]
    """
    Unit of the lengths if the text does not state one. If it is absent, the machine's `program_unit`
    is used.
    """
    work_offsets_mm: NotRequired[WorkOffsets]
    """Origins of the work offsets that the program names."""


class ServoPathTipHold(TypedDict):
    """
    The tip rests on the workpiece while rotary axes go from one word to another and back. The feed then
    counts degrees per minute, along both axes together.
    """

    kind: Literal["tip-hold"]
    sweep_deg: RotarySweep
    """First and last words of the rotary axes; an axis that is not named stays at 0."""
    tip_mm: Vector
    """The tip in the workpiece."""


class ServoProgramParameters(TypedDict):
    """Parameters of the simulation of a program."""

    dialect: NotRequired[Dialect]
    """Dialect of the program text."""
    feed_mm_per_min: NotRequired[float]
    """Feed, if the program has none."""
    feed_profile: NotRequired[FeedProfile]
    """
    Jerk-limited feed, one query parameter for each limit: `feed_profile.acceleration_mm_per_s2`. Without
    it, every block runs at its own feed and no corner is a stop.
    """
    interpolation: NotRequired[Interpolation]
    """Interpolation of the control. If it is absent, the program decides."""
    location_errors: NotRequired[LocationErrors]
    """Whether measured errors of the machine are applied."""
    plane: NotRequired[Plane]
    """Plane that gives the contour error a sign."""
    position_gain_scale: NotRequired[FactorsByAxis]
    """Factors of the position gains, one query parameter for each: `position_gain_scale.C`."""
    radius_offsets_mm: NotRequired[RadiusOffsets]
    """Radii in the registers that G41 and G42 name, geometry and wear together."""
    sample_period_s: NotRequired[float]
    """Sample period of the command."""
    start: NotRequired[StartWords]
    """Positions of the axes before the first block, as words in the program's first work offset."""
    tool_length_mm: NotRequired[float]
    """
    Length of the tool, for head axes and machine coordinates. Zero is a valid answer. If it is absent,
    the machine's tool table is used.
    """
    tool_number: NotRequired[int]
    """
    Number of the tool to work on, if the program has several; motions with other tools are left
    unchanged. A program that calls no tool runs with this one. If it is absent, each section gets
    its tool from the machine's tool table.
    """
    unit: NotRequired[ProgramUnit]
    """
    Unit of the lengths if the program does not state one. If it is absent, the machine's
    `program_unit` is used.
    """
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose, for a program that names at most
    one work offset. Zero is a valid answer. If it is absent, the machine's `work_offsets_mm` are
    used.
    """
    work_offsets_mm: NotRequired[WorkOffsets]
    """Origins of the work offsets that the program names. In a query: `work_offsets_mm.G54.1 P3`."""


class SetupError(TypedDict):
    """
    Offset of the spindle ball from the spindle's line. Give either `e_xs` and `e_ys`, or the readings of a
    spindle turned with both axes at zero (`spindle_deg`, `bar_direction`, `length_change_um`).
    """

    bar_direction: NotRequired[SpindleBar | None]
    e_xs: NotRequired[float | None]
    """Offset along X, if it is known."""
    e_ys: NotRequired[float | None]
    """Offset along Y, if it is known."""
    length_change_um: NotRequired[Sequence[float] | None]
    """One reading for each spindle angle."""
    spindle_deg: NotRequired[Sequence[float] | None]
    """Spindle angles; positive about +Z."""


class SetupErrorAnswer(TypedDict):
    """The offset of the spindle ball from the spindle's line (µm)."""

    e_xs: Estimate
    """Offset along X."""
    e_ys: Estimate
    """Offset along Y."""
    source: SetupErrorSource
    """Where the two values came from."""


class SimulationAnswer(TypedDict):
    """Result of a servo simulation."""

    axes: Mapping[str, AxisResult]
    """Results of the axes that move, by letter."""
    contour_error: ContourError
    """Contour error on the part."""
    judged_from_s: float
    """Time at which the evaluated part begins."""
    machine_revision: NotRequired[int | None]
    """Revision of the machine; null if the drives came with the request."""
    sample_count: int
    """Number of samples."""
    samples: ServoSamples
    """The run, down-sampled."""
    software_version: str
    """Version of the service."""


class SphereCentre(TypedDict):
    """The centre of a sphere on the table, probed at one angle of the axis."""

    angle_deg: NotRequired[float | None]
    """Word of the axis, if it was recorded. Give it for all centres of an axis or for none."""
    centre_mm: Vector
    """Centre in machine coordinates."""
    sphere: NotRequired[int]
    """Index of the sphere, if there are several: 0, 1, …"""


class SphereCircle(TypedDict):
    """The circle of one sphere."""

    centre_mm: Vector
    """Centre of its circle, on the axis."""
    radius_mm: float
    """Radius of the circle."""
    sphere: int
    """Index of the sphere."""


class SurfaceMesh(TypedDict):
    """The properties of an uploaded surface file."""

    contradicting_normals: int
    """Facets whose stated normal contradicts their winding; the winding is used."""
    degenerate_facets: int
    """Facets that were dropped because they are too thin to have a normal."""
    facets: int
    """Number of facets in the file."""
    largest_mm: Vector
    """Largest coordinates."""
    least_mm: Vector
    """Smallest coordinates."""
    non_manifold_edges: int
    """Edges of more than two facets."""
    open_edges: int
    """Edges of only one facet: the rim of an open surface, or a gap."""
    sharp_edges: int
    """Edges across which the surface is not smooth within the chordal tolerance."""
    triangles: int
    """Number of facets with an area."""
    vertices: int
    """Number of different corners."""
    volume_mm3: NotRequired[float | None]
    """Enclosed volume; null for an open surface."""


class SweepAnswer(TypedDict):
    """One path with many gains and feeds."""

    contour_error: Sequence[Sequence[ContourError | None]]
    """Contour errors, row by row; null if a cell has no result."""
    faults: Sequence[SweepFault]
    """Reasons for null cells; the first hundred."""
    feed_mm_per_min: Sequence[float]
    """Feed of each column."""
    gains: Sequence[str]
    """Label of each row."""
    machine_revision: NotRequired[int | None]
    """Revision of the machine; null if the drives came with the request."""
    software_version: str
    """Version of the service."""


class ToolDocument(TypedDict):
    """A stored revision of a tool."""

    corner_radius_mm: NotRequired[float | None]
    """
    Corner radius. The kind gives it for a ball (the radius) and for a flat cutter (0); for a bull-nose
    cutter it is required.
    """
    created_at: str
    """Time at which this revision was stored."""
    kind: ToolKind
    """Form of the cutter's end."""
    length_mm: NotRequired[float | None]
    """Length, measured in the same way as `tool_length_mm` in a request."""
    machine_id: str
    """The machine."""
    name: NotRequired[str | None]
    """Name in programs, as in `T="BALL_10"` or `TOOL CALL "BALL_10"`. Upper and lower case are the same."""
    number: NotRequired[int | None]
    """Number in programs, as in `T12` or `TOOL CALL 12`. A tool has a number, a name or both."""
    radius_mm: NotRequired[float | None]
    """Cutter radius. Only a tool of the kind `other` may leave it out."""
    revision: int
    """Counts up from 1; a revision never changes."""
    tool_id: str
    """The tool's id, chosen by the client; its wear entries use the same id."""


class TrendDocument(TypedDict):
    """The trend of one error, oldest run first."""

    axis: str
    """Letter of the axis."""
    error: str
    """Name of the error."""
    machine_id: str
    """Id of the machine."""
    points: Sequence[TrendPoint]
    """The runs of the trend."""
    unit: str
    """Unit of the values and uncertainties: `um` or `urad`."""


class VerificationParameters(TypedDict):
    """Parameters of the virtual cutting of a part."""

    chordal_tolerance_um: NotRequired[float]
    """Largest distance of the uploaded facets from the smooth surface that they represent; default 10."""
    cutting_length_mm: NotRequired[float]
    """Height above the tip up to which the cutter cuts; default four times its radius, at least 30."""
    dialect: NotRequired[Dialect]
    """Dialect of the program text."""
    feed_mm_per_min: NotRequired[float]
    """Feed, if the program has none."""
    interpolation: NotRequired[Interpolation]
    """Interpolation of the control. If it is absent, the program decides."""
    limit_um: NotRequired[float]
    """Samples with a residual larger than this, above or below the surface, are counted."""
    location_errors: NotRequired[LocationErrors]
    """Whether measured errors of the machine are applied: the machine as it is, or the nominal machine."""
    radius_offsets_mm: NotRequired[RadiusOffsets]
    """Radii in the registers that G41 and G42 name, geometry and wear together."""
    resolution_um: NotRequired[float]
    """Largest distance between a motion and the straight pieces that replace it."""
    samples: NotRequired[int]
    """Number of sample points on the surface."""
    start: NotRequired[StartWords]
    """Positions of the axes before the first block, as words in the program's first work offset."""
    stock_mm: NotRequired[float]
    """
    Height of the stock above the surface. Needles end there; a cutter cuts a needle only if it contains
    this end.
    """
    surface: NotRequired[NominalSurface]
    """The nominal surface, if it is not uploaded."""
    surface_unit_mm: NotRequired[float]
    """Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1."""
    tool: NotRequired[WearTool]
    """The cutter, as measured. If it is absent, the machine's tool table gives each section its cutter."""
    tool_length_mm: NotRequired[float]
    """
    Length of the tool, for head axes and machine coordinates. Zero is a valid answer. If it is absent,
    the machine's tool table is used.
    """
    tool_number: NotRequired[int]
    """
    Number of the tool to work on, if the program has several; motions with other tools are left
    unchanged. A program that calls no tool runs with this one. If it is absent, each section gets
    its tool from the machine's tool table.
    """
    unit: NotRequired[ProgramUnit]
    """
    Unit of the lengths if the program does not state one. If it is absent, the machine's
    `program_unit` is used.
    """
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose, for a program that names at most
    one work offset. Zero is a valid answer. If it is absent, the machine's `work_offsets_mm` are
    used.
    """
    work_offsets_mm: NotRequired[WorkOffsets]
    """Origins of the work offsets that the program names. In a query: `work_offsets_mm.G54.1 P3`."""


class WearAdvice(TypedDict):
    """Advice, with the numbers that it is based on."""

    actual: NotRequired[WearOutlook | None]
    advice: AdviceKind
    """The cheapest action that keeps the allowed height."""
    detail: str
    """The advice in a sentence."""
    min_tool_radius_mm: NotRequired[float | None]
    """
    Wear limit: the smallest cutter radius, with the worn corner radius, that keeps the height at the
    program's step-over. Null if no cutter does.
    """
    nominal: WearOutlook
    """The nominal cutter."""
    offset: WearOffset
    """Offset along the normal that compensation removes: + excess, − gouge."""
    residual_after_um: NotRequired[float | None]
    """Largest residual if the advice is followed; after a tool change, the residual of the nominal cutter."""
    residual_before_um: NotRequired[float | None]
    """
    Largest residual of the unchanged program with the worn cutter, scallop included; null if the cutter
    cannot cut it.
    """
    stepover_mm: NotRequired[float | None]
    """Step-over for the worn cutter; null if it must be changed."""


class WearAdviceRequest(TypedDict):
    """A worn cutter in a program."""

    actual_tool: WearTool
    """The cutter as measured."""
    allowed_scallop_um: float
    """Scallop height that is allowed above the surface."""
    contact_angle_deg: NotRequired[Pair]
    """Smallest and largest angle between surface normal and tool axis in the program."""
    lead_deg: NotRequired[float]
    """Inclination of the tool axis in the feed direction; needed if a cutter is not a ball."""
    min_stepover_mm: NotRequired[float]
    """Smallest step-over that is worth running; default nine tenths of `stepover_mm`."""
    nominal_tool: WearTool
    """The cutter that the program was made for."""
    stepover_mm: float
    """Step-over of the program: chord between neighbouring contact points on the surface."""
    surface: SurfaceKind
    """Form of the surface across the feed."""
    surface_radius_mm: NotRequired[float]
    """Radius of the surface's normal curvature across the feed; leave it out for a flat surface."""


class WearEdge(TypedDict):
    """The wear of one edge."""

    edge: NotRequired[str | None]
    """Name of the edge; null if the cutter was measured as a whole."""
    entries: Sequence[WearTrendPoint]
    """Entries of the edge, ordered by the number of parts."""
    fit: NotRequired[WearFit | None]


class WearEntry(TypedDict):
    """A measured wear as it is stored."""

    created_at: str
    """Time at which the entry was stored."""
    cutter_id: str
    """Id of the cutter in the tool."""
    edge: NotRequired[str | None]
    """Name of the edge; null if the cutter was measured as a whole."""
    flank_wear_um: NotRequired[float | None]
    """Wear of the flank, if it was measured."""
    id: str
    """Id of the entry."""
    machine_id: str
    """Id of the machine."""
    measured_at: str
    """Time of the measurement."""
    note: NotRequired[str | None]
    """Any note."""
    parts_cut: int
    """Parts cut since the cutter was new."""
    radius_wear_um: NotRequired[float | None]
    """Wear of the radius, if it was measured."""
    standard_uncertainty_um: NotRequired[float | None]
    """Standard uncertainty of the wear; null if none was stated."""
    tool_id: str
    """Id of the tool."""
    withdrawn: NotRequired[Withdrawal | None]


class WearFindings(TypedDict):
    """Results of the compensation for a worn cutter."""

    advice: NotRequired[WearAdvice | None]
    after: DeviationSummary
    """
    Distance between the contacts of the worn and the nominal cutter, computed from the written text.
    Values that depend on an assumed contact are as in `before`.
    """
    after_if_assumed: NotRequired[DeviationSummary | None]
    assumption: NotRequired[AssumedContacts | None]
    before: DeviationSummary
    """Residual of the worn cutter along the normal with the unchanged program, without scallops."""
    blocks_changed: int
    """Number of blocks whose bytes changed."""
    blocks_in: int
    """Number of blocks in the upload."""
    blocks_out: int
    """Number of blocks in the answer; there are more only because of blocks with F alone before calls."""
    cc_path_length_mm: float
    """Sum of the chords between contacts."""
    contact: Contact
    """Source of the cutter contact."""
    contact_angle_deg: NotRequired[Pair | None]
    contacts_assumed: NotRequired[int]
    """Number of motions at whose end a contact was assumed from the feed and kept."""
    contacts_kept: int
    """Number of motions at whose end a contact was found and kept."""
    curvature: NotRequired[CurvatureAcrossFeed | None]
    dialect: Dialect
    """Dialect in which the text was read."""
    feeds_lowered: int
    """Number of blocks whose F was lowered, so that no block runs faster than in the source."""
    feeds_restored: int
    """Number of blocks that only got the source's F word back, after such blocks."""
    interpolation: Interpolation
    """Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so."""
    max_shift_line: NotRequired[int | None]
    """Line of the upload with this shift; null if nothing moved."""
    max_shift_um: float
    """Largest shift of a tip."""
    motions_shifted: int
    """Number of motions that end at another point in the answer."""
    series: DeviationSeries
    """Both deviations along the path."""
    warnings: Sequence[ReportWarning]
    """Warnings to the caller."""


class WearParameters(TypedDict):
    """Parameters of the compensation for a worn cutter."""

    actual_tool: NotRequired[WearTool]
    """The cutter as measured. Give `actual_tool`, `wear_table` or `wear`."""
    allow_repeated: NotRequired[bool]
    """
    Apply the steps `cc` and `singularity` again to a program that already has their stamp, or is an earlier
    answer of theirs. A program that was smoothed before is not smoothed again. Steps that move ends are never
    repeated.
    """
    allowed_scallop_um: NotRequired[float]
    """
    For the advice in the report, with `stepover_mm`: the scallop height that is allowed above the
    surface.
    """
    chordal_tolerance_um: NotRequired[float]
    """Largest distance of the uploaded facets from the smooth surface that they represent; default 10."""
    contact: NotRequired[Contact]
    """Where the cutter contact comes from; `tip` is not possible here."""
    contact_gap_um: NotRequired[float]
    """
    The cutter touches the uploaded surface if it is at most this far above or inside the facets; default
    100.
    """
    dialect: NotRequired[Dialect]
    """Dialect of the program text."""
    feed_mm_per_min: NotRequired[float]
    """Feed, if the program has none."""
    flatten: NotRequired[bool]
    """
    Write the loops and calls of the program out, and compensate the result: one program without loops and
    calls. Without it, motions after a call are left unchanged, and a program with loops is refused.
    """
    interpolation: NotRequired[Interpolation]
    """Interpolation of the control. If it is absent, the program decides."""
    lead_deg: NotRequired[float]
    """For the advice: inclination of the tool axis in the feed direction, if a cutter is not a ball."""
    length_in_control: NotRequired[LengthInControl]
    """Length that the control has; default `nominal` if both lengths are given."""
    max_feed_mm_per_min: NotRequired[float]
    """
    Largest F that the service writes; a block whose parts need a larger F stays as it is. If it is
    absent, the machine's `max_feed_mm_per_min` is used; without that, ten times the programmed feed.
    """
    milling: NotRequired[Milling]
    """Part of the cutter that makes the surface."""
    nominal_tool: NotRequired[WearTool]
    """The cutter that the program was made for. If it is absent, the machine's tool table gives it."""
    pass_break_deg: NotRequired[float]
    """
    If the feed direction turns by more than this angle, a new pass begins for an assumed contact
    (`feed-plane`).
    """
    radius_offsets_mm: NotRequired[RadiusOffsets]
    """Radii in the registers that G41 and G42 name, geometry and wear together."""
    stamp: NotRequired[StampForm]
    """Whether a changed program gets a comment that says so."""
    start: NotRequired[StartWords]
    """Positions of the axes before the first block, as words in the program's first work offset."""
    stepover_mm: NotRequired[float]
    """For the advice: step-over of the program."""
    surface: NotRequired[SurfaceKind]
    """
    For the advice: form of the surface across the feed. Default: as measured from the uploaded surface,
    else flat.
    """
    surface_radius_mm: NotRequired[float]
    """For the advice: radius of the surface across the feed."""
    surface_unit_mm: NotRequired[float]
    """Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1."""
    tool_length_mm: NotRequired[float]
    """
    Length of the tool, for head axes and machine coordinates. Zero is a valid answer. If it is absent,
    the machine's tool table is used.
    """
    tool_number: NotRequired[int]
    """
    Number of the tool to work on, if the program has several; motions with other tools are left
    unchanged. A program that calls no tool runs with this one. If it is absent, each section gets
    its tool from the machine's tool table.
    """
    unit: NotRequired[ProgramUnit]
    """
    Unit of the lengths if the program does not state one. If it is absent, the machine's
    `program_unit` is used.
    """
    wear: NotRequired[WearSource]
    """The wear from the machine's entries, instead of `actual_tool`; the tool table then gives both cutters."""
    wear_table: NotRequired[WearTable]
    """Wear along the corner; for end milling."""
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose, for a program that names at most
    one work offset. Zero is a valid answer. If it is absent, the machine's `work_offsets_mm` are
    used.
    """
    work_offsets_mm: NotRequired[WorkOffsets]
    """Origins of the work offsets that the program names. In a query: `work_offsets_mm.G54.1 P3`."""


WearStep = TypedDict(
    "WearStep",
    {
        "actual_tool": NotRequired[WearTool],
        "contact": NotRequired[Contact],
        "cutter_id": NotRequired[str],
        "from": NotRequired[WearFrom],
        "length_in_control": NotRequired[LengthInControl],
        "milling": NotRequired[Milling],
        "nominal_tool": NotRequired[WearTool],
        "pass_break_deg": NotRequired[float],
        "tool_number": NotRequired[int],
        "wear_table": NotRequired[WearTable],
    },
)


class WearTrendDocument(TypedDict):
    """The wear of a cutter over time."""

    cutter_id: NotRequired[str | None]
    """Id of the cutter; null if the tool has no entries."""
    edges: Sequence[WearEdge]
    """The edges of the cutter."""
    limit_um: NotRequired[float | None]
    """The requested limit."""
    machine_id: str
    """Id of the machine."""
    outlook: NotRequired[PartsOutlook | None]
    parts_now: NotRequired[int | None]
    """Parts at the newest entry; null without entries."""
    quantity: NotRequired[WearQuantity | None]
    tool_id: str
    """Id of the tool."""
    warnings: Sequence[WearWarning]
    """Points that a person should check."""


class CompensationParameters(TypedDict):
    """Parameters of a compensation in one pass: at least one of `wear`, `location_errors`, `cc`."""

    allow_repeated: NotRequired[bool]
    """
    Apply the steps `cc` and `singularity` again to a program that already has their stamp, or is an earlier
    answer of theirs. A program that was smoothed before is not smoothed again. Steps that move ends are never
    repeated.
    """
    cc: NotRequired[CcStep]
    """Compensate the cutter-contact path between the ends of blocks."""
    chordal_tolerance_um: NotRequired[float]
    """Largest distance of the uploaded facets from the smooth surface that they represent; default 10."""
    contact_gap_um: NotRequired[float]
    """
    The cutter touches the uploaded surface if it is at most this far above or inside the facets; default
    100.
    """
    dialect: NotRequired[Dialect]
    """Dialect of the program text."""
    feed_mm_per_min: NotRequired[float]
    """Feed, if the program has none."""
    flatten: NotRequired[bool]
    """
    Write the loops and calls of the program out, and compensate the result: one program without loops and
    calls. Without it, motions after a call are left unchanged, and a program with loops is refused.
    """
    interpolation: NotRequired[Interpolation]
    """Interpolation of the control. If it is absent, the program decides."""
    location_errors: NotRequired[bool]
    """True: the program was made for the nominal machine; its words are computed again for the calibrated machine."""
    max_feed_mm_per_min: NotRequired[float]
    """
    Largest F that the service writes; a block whose parts need a larger F stays as it is. If it is
    absent, the machine's `max_feed_mm_per_min` is used; without that, ten times the programmed feed.
    """
    radius_offsets_mm: NotRequired[RadiusOffsets]
    """Radii in the registers that G41 and G42 name, geometry and wear together."""
    servo_lag: NotRequired[bool]
    """
    Whether the written program is simulated with the machine's drives, if it has any. The error budget
    then contains the error of the drives.
    """
    singular_regions: NotRequired[SingularRegions]
    """How singular regions are found and treated."""
    singularity: NotRequired[SingularityAction]
    """Treatment of singular regions, before all other steps."""
    stamp: NotRequired[StampForm]
    """Whether a changed program gets a comment that says so."""
    start: NotRequired[StartWords]
    """Positions of the axes before the first block, as words in the program's first work offset."""
    surface_unit_mm: NotRequired[float]
    """Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1."""
    tool_length_mm: NotRequired[float]
    """
    Length of the tool, for head axes and machine coordinates. Zero is a valid answer. If it is absent,
    the machine's tool table is used.
    """
    tool_number: NotRequired[int]
    """
    Number of the tool to work on, if the program has several; motions with other tools are left
    unchanged. A program that calls no tool runs with this one. If it is absent, each section gets
    its tool from the machine's tool table.
    """
    unit: NotRequired[ProgramUnit]
    """
    Unit of the lengths if the program does not state one. If it is absent, the machine's
    `program_unit` is used.
    """
    wear: NotRequired[WearStep]
    """Move the program for a worn cutter."""
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose, for a program that names at most
    one work offset. Zero is a valid answer. If it is absent, the machine's `work_offsets_mm` are
    used.
    """
    work_offsets_mm: NotRequired[WorkOffsets]
    """Origins of the work offsets that the program names. In a query: `work_offsets_mm.G54.1 P3`."""


class InverseAnswer(TypedDict):
    """Axis words of poses."""

    candidates: NotRequired[Sequence[Sequence[JointWords]] | None]
    """Selection `all`: every solution of each pose."""
    joints: NotRequired[Sequence[JointWords] | None]
    """Selection `path`: one solution for each pose."""
    machine_revision: int
    """Revision of the machine that was used."""
    warnings: Sequence[PoseWarning]
    """Warnings about some poses."""


class Kinematics(TypedDict):
    """Axes, travel and errors."""

    linear_limits_mm: NotRequired[LinearLimits]
    """Travel of the linear words."""
    rotary_axes: Sequence[RotaryAxis]
    """Two different axes: table axes from the bed outward, head axes from the ram outward."""
    squareness_urad: NotRequired[Squareness]
    """Squareness of the linear axes."""


class MachineDocument(TypedDict):
    """A stored revision of a machine."""

    asset_id: NotRequired[str | None]
    """The machine's id in the shop's own lists."""
    block_time_ms: NotRequired[float | None]
    """Shortest time that the control needs for one block."""
    calibration_due_days: NotRequired[float | None]
    """Number of days after which the next calibration is due."""
    calibration_limits: NotRequired[CalibrationLimits | None]
    created_at: str
    """Time at which this revision was stored."""
    drives: NotRequired[Drives | None]
    interpolation_period_s: NotRequired[float]
    """The control's interpolation period."""
    kinematics: Kinematics
    """Axes, travel and errors."""
    machine_coordinates: NotRequired[MachineCoordinates | None]
    machine_id: str
    """The id that the client chose."""
    max_feed_mm_per_min: NotRequired[float | None]
    """Largest feed that a written F may ask for."""
    name: str
    """The shop's name for the machine."""
    plane_solution: NotRequired[PlaneSolution | None]
    program_unit: NotRequired[ProgramUnit | None]
    revision: int
    """Counts up from 1; a revision never changes."""
    rs274_control: NotRequired[bool | None]
    """Programs run as in RS274/NGC."""
    serial_number: NotRequired[str | None]
    """The builder's serial number."""
    start_codes: NotRequired[str | None]
    """G codes in force when a program begins."""
    work_offsets_mm: NotRequired[WorkOffsets | None]


class MachineProfile(TypedDict):
    """What the shop states about a machine."""

    asset_id: NotRequired[str | None]
    """The machine's id in the shop's own lists."""
    block_time_ms: NotRequired[float | None]
    """Shortest time that the control needs for one block."""
    calibration_due_days: NotRequired[float | None]
    """Number of days after which the next calibration is due."""
    calibration_limits: NotRequired[CalibrationLimits | None]
    drives: NotRequired[Drives | None]
    interpolation_period_s: NotRequired[float]
    """The control's interpolation period."""
    kinematics: Kinematics
    """Axes, travel and errors."""
    machine_coordinates: NotRequired[MachineCoordinates | None]
    max_feed_mm_per_min: NotRequired[float | None]
    """Largest feed that a written F may ask for."""
    name: str
    """The shop's name for the machine."""
    plane_solution: NotRequired[PlaneSolution | None]
    program_unit: NotRequired[ProgramUnit | None]
    rs274_control: NotRequired[bool | None]
    """Programs run as in RS274/NGC."""
    serial_number: NotRequired[str | None]
    """The builder's serial number."""
    start_codes: NotRequired[str | None]
    """G codes in force when a program begins."""
    work_offsets_mm: NotRequired[WorkOffsets | None]


class ResolvedInputs(TypedDict):
    """The inputs of a result beside its parameters."""

    max_feed_mm_per_min: NotRequired[float | None]
    """Largest F that the service writes; null if the limit is ten times the programmed feed."""
    max_feed_stated_by: NotRequired[StatedBy | None]
    tools: Sequence[ResolvedTool]
    """Tools that are in the spindle while the program moves, in the order of their first use."""
    unit: NotRequired[ProgramUnit | None]
    unit_stated_by: NotRequired[StatedBy | None]
    wear: Sequence[ResolvedWear]
    """Wear of these tools that was taken from the machine's wear entries."""
    work_offsets: Sequence[ResolvedOffset]
    """Work offsets under which the program moves, in the order of their first use."""


ServoPath: TypeAlias = (
    ServoPathXcCircle | ServoPathCircle | ServoPathConeFrustum | ServoPathTipHold | ServoPathProgram | ServoPathPolyline
)
"""
The path that the axes are commanded to follow. All kinds except the two circles need a machine with
drives.
"""


class ServoReport(TypedDict):
    """The report of a program's servo simulation."""

    axes: Mapping[str, AxisResult]
    """Results of the axes that move, by letter."""
    blocks: int
    """Number of blocks in the upload."""
    contour_error: ContourError
    """Contour error on the part."""
    dialect: Dialect
    """Dialect in which the text was read."""
    duration_s: float
    """Duration of the simulated motions."""
    input_sha256: str
    """SHA-256 of the upload."""
    left_out: Sequence[LeftOut]
    """Motions at feed that were not simulated."""
    machine_revision: int
    """Revision of the machine that was used."""
    motions_simulated: int
    """Number of motions at feed that were simulated."""
    passes: int
    """Number of passes: motions between two rapids. Each pass starts with the axes at rest."""
    resolved: NotRequired[ResolvedInputs | None]
    sample_count: int
    """Number of samples."""
    samples: ServoSamples
    """The run, down-sampled."""
    software_version: str
    """Version of the service."""


class SimulationRequest(TypedDict):
    """One path at one feed."""

    drives: NotRequired[Drives]
    """Drives by axis letter, without a machine; for the two circles."""
    feed_mm_per_min: NotRequired[float]
    """
    Feed along the path; in degrees per minute if the tip rests. For a program: the feed if the
    program has none.
    """
    feed_profile: NotRequired[FeedProfile]
    """Jerk-limited feed. Without it, the command starts and ends with a step in speed."""
    laps: NotRequired[int]
    """Number of laps on a closed path, default 2; the last lap is evaluated."""
    location_errors: NotRequired[LocationErrors]
    """Whether measured errors of the machine are applied."""
    machine_id: NotRequired[str]
    """The machine whose drives and kinematics are used; give either this or `drives`."""
    path: ServoPath
    """The path that the axes are commanded to follow."""
    position_gain_scale: NotRequired[Mapping[str, float]]
    """Factors of the position gains, by axis letter."""
    sample_period_s: NotRequired[float]
    """Sample period of the command."""
    tool_length_mm: NotRequired[float]
    """
    Tool length, added along the zero-pose tool axis; it matters only for head axes. The default
    is as for `work_offset_mm`.
    """
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose; default zero. For a program there
    is no default: it must be stated if a result depends on it.
    """


class SphereAxis(TypedDict):
    """The centres that were probed while one axis turned and the other was at zero."""

    centres: Sequence[SphereCentre]
    """Centres in the order of measurement."""
    rotary_axis: str
    """Letter of the table axis that turns."""


class SphereAxisAnswer(TypedDict):
    """One axis from the probed spheres."""

    axial_rms_um: float
    """Root of the mean square of the distances from the circles' planes."""
    centres: int
    """Number of centres."""
    direction: Vector
    """Unit direction, in the nominal sense."""
    outliers: Sequence[SphereOutlier]
    """Centres to check."""
    point_mm: Vector
    """
    Point where the line meets the plane through the nominal reference point, perpendicular to the nominal
    direction.
    """
    radial_rms_um: float
    """Root of the mean square of the radial distances."""
    rotary_axis: str
    """Letter of the axis."""
    spheres: Sequence[SphereCircle]
    """Circle of each sphere."""
    tangential_rms_um: NotRequired[float | None]
    """Root of the mean square of the distances along the circles; null if the angles are not known."""


class SweepRequest(TypedDict):
    """One path with many gains and feeds."""

    drives: NotRequired[Drives]
    """Drives by axis letter, without a machine; for the two circles."""
    feed_mm_per_min: Sequence[float]
    """Feeds along the path; in degrees per minute if the tip rests."""
    feed_profile: NotRequired[FeedProfile]
    """Jerk-limited feed. Without it, the command starts and ends with a step in speed."""
    laps: NotRequired[int]
    """Number of laps on a closed path, default 2; the last lap is evaluated."""
    location_errors: NotRequired[LocationErrors]
    """Whether measured errors of the machine are applied."""
    machine_id: NotRequired[str]
    """The machine whose drives and kinematics are used; give either this or `drives`."""
    path: ServoPath
    """The path that the axes are commanded to follow."""
    position_gain_scale: NotRequired[Mapping[str, Sequence[float]]]
    """Factors of the position gains, by axis letter: lists of equal length, which are stepped together."""
    sample_period_s: NotRequired[float]
    """Sample period of the command."""
    tool_length_mm: NotRequired[float]
    """
    Tool length, added along the zero-pose tool axis; it matters only for head axes. The default
    is as for `work_offset_mm`.
    """
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose; default zero. For a program there
    is no default: it must be stated if a result depends on it.
    """


class VerificationReport(TypedDict):
    """The result of a verification."""

    area_mm2: float
    """Area of the surface."""
    blocks: int
    """Number of blocks in the upload."""
    convergence: Convergence
    """Accuracy of the residuals."""
    dialect: Dialect
    """Dialect in which the text was read."""
    excess_over_limit: int
    """Number of samples with more than `limit_um` left above the surface."""
    gouge_over_limit: int
    """Number of samples that are cut deeper than `limit_um` below the surface."""
    gouged_by_rapid: int
    """Number of these samples that a rapid cut."""
    histogram: ResidualHistogram
    """Histogram of the residuals."""
    input_sha256: str
    """SHA-256 of the upload."""
    left_out: Sequence[LeftOut]
    """Motions that were not cut because their course is not known."""
    limit_um: float
    """Largest residual that is not counted."""
    machine_revision: int
    """Revision of the machine that was used."""
    max_excess: NotRequired[WorstResidual | None]
    max_gouge: NotRequired[WorstResidual | None]
    mean_um: NotRequired[float | None]
    """Mean of the same residuals."""
    motions_cut: MotionsCut
    """Motions that were cut."""
    pieces: int
    """Number of straight pieces that the motions were divided into."""
    residuals_sha256: str
    """SHA-256 of the table of residuals."""
    resolution_um: float
    """Largest distance between a motion and the straight pieces that replaced it."""
    resolved: NotRequired[ResolvedInputs | None]
    rms_um: NotRequired[float | None]
    """Root mean square of the residuals where a tool came; null if no tool came."""
    sample_spacing_mm: float
    """Side of the square that a sample represents."""
    samples: int
    """Number of samples on the surface."""
    software_version: str
    """Version of the service."""
    stock_mm: float
    """Height of the stock."""
    surface_mesh: NotRequired[SurfaceMesh | None]
    surface_sha256: NotRequired[str | None]
    """SHA-256 of the part's surface, if it was uploaded."""
    uncut: int
    """Number of samples that no tool reaches: they keep their stock."""
    warnings: Sequence[ReportWarning]
    """Warnings to the caller."""
    worst_line: NotRequired[int | None]
    """Line of the upload that left the larger of the two."""


class WearReport(TypedDict):
    """The report of a compensation for a worn cutter."""

    advice: NotRequired[WearAdvice | None]
    after: DeviationSummary
    """
    Distance between the contacts of the worn and the nominal cutter, computed from the written text.
    Values that depend on an assumed contact are as in `before`.
    """
    after_if_assumed: NotRequired[DeviationSummary | None]
    assumption: NotRequired[AssumedContacts | None]
    before: DeviationSummary
    """Residual of the worn cutter along the normal with the unchanged program, without scallops."""
    blocks_changed: int
    """Number of blocks whose bytes changed."""
    blocks_in: int
    """Number of blocks in the upload."""
    blocks_out: int
    """Number of blocks in the answer; there are more only because of blocks with F alone before calls."""
    cc_path_length_mm: float
    """Sum of the chords between contacts."""
    contact: Contact
    """Source of the cutter contact."""
    contact_angle_deg: NotRequired[Pair | None]
    contacts_assumed: NotRequired[int]
    """Number of motions at whose end a contact was assumed from the feed and kept."""
    contacts_kept: int
    """Number of motions at whose end a contact was found and kept."""
    curvature: NotRequired[CurvatureAcrossFeed | None]
    dialect: Dialect
    """Dialect in which the text was read."""
    feeds_lowered: int
    """Number of blocks whose F was lowered, so that no block runs faster than in the source."""
    feeds_restored: int
    """Number of blocks that only got the source's F word back, after such blocks."""
    input_sha256: str
    """SHA-256 of the upload."""
    interpolation: Interpolation
    """Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so."""
    machine_revision: int
    """Revision of the machine that was used."""
    max_shift_line: NotRequired[int | None]
    """Line of the upload with this shift; null if nothing moved."""
    max_shift_um: float
    """Largest shift of a tip."""
    motions_shifted: int
    """Number of motions that end at another point in the answer."""
    output_sha256: str
    """SHA-256 of the answer."""
    resolved: NotRequired[ResolvedInputs | None]
    series: DeviationSeries
    """Both deviations along the path."""
    software_version: str
    """Version of the service."""
    steps: NotRequired[Sequence[StepName] | None]
    """The steps that changed the program; null if an older version of the service did not record them."""
    warnings: Sequence[ReportWarning]
    """Warnings to the caller."""


class CalibrationDocument(TypedDict):
    """The result of a calibration run. It never changes."""

    axes: NotRequired[Sequence[SphereAxisAnswer] | None]
    """The axes found, if spheres were probed."""
    blind: Sequence[Blind]
    """Combinations of errors that the run cannot separate."""
    condition_number: NotRequired[float | None]
    """
    Largest singular value divided by the smallest, with columns of unit length; null if spheres were
    probed.
    """
    covariance: NotRequired[Covariance | None]
    created_at: str
    """Time at which the run was stored."""
    degrees_of_freedom: int
    """
    Number of observations minus the number of fitted values. For spheres without angles: of the planes
    and circles, each.
    """
    eccentricities_um: NotRequired[Eccentricities]
    """Eccentricities before and after compensation."""
    errors: Mapping[str, Mapping[str, Estimate]]
    """Location errors by axis, cascaded as in the profile: `apply` writes these values there."""
    id: str
    """Id of the run."""
    instrument: NotRequired[str | None]
    """Instrument that measured."""
    instrument_certificate: NotRequired[str | None]
    """The instrument's calibration certificate."""
    instrument_serial_number: NotRequired[str | None]
    """Serial number of the instrument."""
    iso_230: Mapping[str, Estimate]
    """The same errors against the machine's frame, with the symbols of ISO 230-7."""
    kind: CalibrationKind
    """How it was measured."""
    machine_id: str
    """Id of the machine."""
    machine_revision: int
    """Revision of the machine when it was measured."""
    measured_at: str
    """Time of the measurement."""
    note: NotRequired[str | None]
    """The operator's note."""
    operator: NotRequired[str | None]
    """Person who measured."""
    outliers: NotRequired[Sequence[Outlier]]
    """Readings that were left out because they are too far from all others; the first thousand."""
    rank: int
    """How many of `unknowns` the readings determine; offsets are not counted."""
    redundant: Sequence[str]
    """Components that change no line of this machine beyond the errors above; they stay zero."""
    residual_rms_um: float
    """Root of the mean square of the residuals."""
    run_sha256: str
    """SHA-256 of the stored run."""
    setup_error_um: NotRequired[SetupErrorAnswer]
    """Offset of the spindle ball."""
    software_version: str
    """Build of the service that evaluated the run."""
    temperature_c: NotRequired[float | None]
    """Temperature of the machine."""
    tests: NotRequired[Sequence[TestAnswer]]
    """Results of each test."""
    unidentifiable: Sequence[str]
    """
    Errors that the run does not determine: cascaded, against the machine's frame, or of the set-up. The
    value of such an error contains all errors that it cannot be separated from.
    """
    unknowns: int
    """Number of unknowns: the location errors, and the two set-up errors if they were not given."""
    warnings: Sequence[RunWarning]
    """Points that a metrologist should check."""


class CalibrationRun(TypedDict):
    """
    A calibration run: who measured, when, with what, and all readings. `instrument_uncertainty_um`,
    `bar_length_mm`, `offset_per_test`, `setup_error_um`, `tests` and the uncertainties of the set-up belong to
    `rtcp-ballbar`; `axes` belongs to `rotary-sphere`.
    """

    axes: NotRequired[Sequence[SphereAxis] | None]
    """The axes with probed spheres."""
    ball_uncertainty_mm: NotRequired[float | None]
    """Standard uncertainty of each coordinate of `ball_mm`. Tests with the same `ball_mm` count as one ball."""
    bar_length_mm: NotRequired[float | None]
    """Length of the bar at the start."""
    bar_length_uncertainty_mm: NotRequired[float | None]
    """Standard uncertainty of `bar_length_mm`."""
    instrument: NotRequired[str | None]
    """Instrument that measured."""
    instrument_certificate: NotRequired[str | None]
    """The instrument's calibration certificate: its number, its date or both."""
    instrument_serial_number: NotRequired[str | None]
    """Serial number of the instrument."""
    instrument_uncertainty_um: NotRequired[float | None]
    """Standard uncertainty of the instrument. If it is given, it widens the uncertainties in the answer."""
    kind: CalibrationKind
    """How the machine was measured."""
    measured_at: str
    """Time of the measurement (RFC 3339); not in the future."""
    note: NotRequired[str | None]
    """Any note of the operator."""
    offset_per_test: NotRequired[bool | None]
    """
    True: the bar's zero is arbitrary, and one offset per test is fitted. False: the length of the bar is
    known.
    """
    operator: NotRequired[str | None]
    """Person who measured."""
    setup_error_um: NotRequired[SetupError | None]
    setup_uncertainty_um: NotRequired[float | None]
    """Standard uncertainty of each of both components of the set-up error, if it was given or is held at 0."""
    temperature_c: NotRequired[float | None]
    """Temperature of the machine."""
    tests: NotRequired[Sequence[BallBarTest] | None]
    """The tests with the ball bar."""


class CcReport(TypedDict):
    """The report of a compensation of the CC path."""

    after: DeviationSummary
    """Deviation of the answer, computed from its own text."""
    before: DeviationSummary
    """Deviation of the upload."""
    blocks_in: int
    """Number of blocks in the upload."""
    blocks_inserted: int
    """Number of inserted blocks."""
    blocks_out: int
    """Number of blocks in the answer."""
    cc_path_length_mm: float
    """Sum of the chords of the checked motions."""
    contact: Contact
    """Source of the cutter contact."""
    dialect: Dialect
    """Dialect in which the text was read."""
    feeds_restored: NotRequired[int]
    """Number of blocks that only got the source's F word back, after divided blocks."""
    input_sha256: str
    """SHA-256 of the upload."""
    interpolation: Interpolation
    """Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so."""
    machine_revision: int
    """Revision of the machine that was used."""
    motions_checked: int
    """Number of motions whose deviation was computed."""
    motions_left_over: NotRequired[int]
    """Number of motions over the tolerance that were not divided; a warning gives the reason."""
    motions_over_tolerance: int
    """Number of checked motions that exceeded the tolerance."""
    output_sha256: str
    """SHA-256 of the answer."""
    resolved: NotRequired[ResolvedInputs | None]
    series: DeviationSeries
    """Deviation along the path."""
    singularity: NotRequired[SingularityFindings | None]
    software_version: str
    """Version of the service."""
    steps: NotRequired[Sequence[StepName] | None]
    """The steps that changed the program; null if an older version of the service did not record them."""
    warnings: Sequence[ReportWarning]
    """Warnings to the caller."""


class CompensationReport(TypedDict):
    """The report of a compensation in one pass."""

    blocks_in: int
    """Number of blocks in the upload."""
    blocks_inserted: int
    """Number of inserted blocks."""
    blocks_out: int
    """Number of blocks in the answer."""
    cc: NotRequired[CcFindings | None]
    changes: Changes
    """Changes that the steps made to the blocks."""
    dialect: Dialect
    """Dialect in which the text was read."""
    error_budget: ErrorBudget
    """Contribution of each source to the error."""
    input_sha256: str
    """SHA-256 of the upload."""
    interpolation: Interpolation
    """Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so."""
    location_errors: NotRequired[LocationErrorFindings | None]
    machine_revision: int
    """Revision of the machine that was used."""
    output_sha256: str
    """SHA-256 of the answer."""
    resolved: NotRequired[ResolvedInputs | None]
    singularity: NotRequired[SingularityFindings | None]
    software_version: str
    """Version of the service."""
    steps: NotRequired[Sequence[StepName] | None]
    """The steps that changed the program; null if an older version of the service did not record them."""
    warnings: Sequence[ReportWarning]
    """Warnings of the steps that move ends; the step `cc` has its own warnings."""
    wear: NotRequired[WearFindings | None]


class Interpretation(TypedDict):
    """The result of the interpretation of a program."""

    blocks: int
    """Number of blocks in the upload."""
    dialect: Dialect
    """Dialect in which the text was read."""
    input_sha256: str
    """SHA-256 of the upload."""
    left_alone: Sequence[MotionLeftAlone]
    """The motions that the service does not understand."""
    machine_revision: int
    """Revision of the machine."""
    motions: Sequence[InterpretedMotion]
    """The motions that the service understands, in the order of execution."""
    resolved: ResolvedInputs
    """Inputs that were resolved beside the parameters."""
    software_version: str
    """Version of the service."""
    warnings: Sequence[ReportWarning]
    """Warnings to the caller."""


class MachinePreset(TypedDict):
    """A common layout of a machine; fill in its numbers, then store it."""

    description: str
    """Which axis carries the workpiece and which carries the tool."""
    id: str
    """Id of the preset."""
    profile: MachineProfile
    """The profile."""
    title: str
    """Short title."""


class MatchingRequest(TypedDict):
    """Request for gains that reach a target."""

    drives: NotRequired[Drives]
    """Drives by axis letter, without a machine; for the two circles."""
    feed_mm_per_min: float
    """Feed at which the gains have to reach the first target."""
    feed_profile: NotRequired[FeedProfile]
    """Jerk-limited feed. Without it, the command starts and ends with a step in speed."""
    feed_range_mm_per_min: NotRequired[Pair]
    """Range of feeds in which the limit is searched."""
    laps: NotRequired[int]
    """Number of laps on a closed path, default 2; the last lap is evaluated."""
    least_gain_margin: NotRequired[float]
    """Factor by which the position gains stay below the stability limit."""
    least_phase_margin_deg: NotRequired[float]
    """Phase margin that the position loops keep."""
    location_errors: NotRequired[LocationErrors]
    """Whether measured errors of the machine are applied."""
    machine_id: NotRequired[str]
    """The machine whose drives and kinematics are used; give either this or `drives`."""
    path: ServoPath
    """The path that the axes are commanded to follow."""
    sample_period_s: NotRequired[float]
    """Sample period of the command."""
    target_um: Sequence[float]
    """
    Largest contour errors allowed. The gains are matched to the first; the feed limit is given for
    each.
    """
    tool_length_mm: NotRequired[float]
    """
    Tool length, added along the zero-pose tool axis; it matters only for head axes. The default
    is as for `work_offset_mm`.
    """
    work_offset_mm: NotRequired[Vector]
    """
    Origin of the workpiece in machine coordinates at zero pose; default zero. For a program there
    is no default: it must be stated if a result depends on it.
    """


class PostingReport(TypedDict):
    """The report of a posting."""

    arcs: int
    """Number of arcs that became lines."""
    between_points: PostingBetweenPoints
    """Deviations between the points."""
    blocks_in: int
    """Number of blocks in the upload."""
    blocks_out: int
    """Number of blocks in the program."""
    comments: int
    """Post-processor statements that became comments in the program."""
    dialect: Dialect
    """Dialect in which the upload was read."""
    input_sha256: str
    """SHA-256 of the upload."""
    interpolation: Interpolation
    """Meaning of X Y Z in the program."""
    linear_decimals: int
    """Digits after the decimal point of X Y Z."""
    machine_revision: int
    """Revision of the machine that was used."""
    output_dialect: Dialect
    """Dialect of the program."""
    output_sha256: str
    """SHA-256 of the answer."""
    points: int
    """Number of points in the program."""
    pole_holds: int
    """Points inside the cone around the pole, where the rotary axis next to the workpiece was held."""
    post_words: int
    """Post-processor statements that became words of the program: stops, dwells, spindle, coolant."""
    read_back: PostingReadBack
    """Result of reading the program back."""
    resolved: NotRequired[ResolvedInputs | None]
    rewinds: int
    """Points at which a rotary axis turns by more than 120°."""
    rotary_decimals: int
    """Digits after the decimal point of the rotary words."""
    software_version: str
    """Version of the service."""
    steps: NotRequired[Sequence[StepName] | None]
    """The steps that changed the program; null if an older version of the service did not record them."""
    warnings: Sequence[ReportWarning]
    """Warnings to the caller."""
    windows: int
    """
    Stretches of points over which the rotary solutions were chosen; each choice looks at least 1024
    points ahead.
    """


ServoAnswer: TypeAlias = SimulationAnswer | ServoReport
"""The answer for a path or for a program."""
