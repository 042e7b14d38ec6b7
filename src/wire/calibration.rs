//! A calibration run as it is posted.

use serde::{Deserialize, Serialize};

use super::Fixed;
use crate::description::ToSchema;

/// How the machine was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CalibrationKind {
    /// A ball bar between table and spindle while RTCP holds the spindle's ball.
    RtcpBallbar,
    /// Centres of spheres on the table, probed at several angles of one axis.
    RotarySphere,
}

impl CalibrationKind {
    /// The word in documents.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::RtcpBallbar => "rtcp-ballbar",
            Self::RotarySphere => "rotary-sphere",
        }
    }
}

/// Direction in which the bar points at zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = BarDirection)]
pub enum BarDirectionDoc {
    /// x for C, z for A and B.
    Radial,
    /// y for A and C, x for B.
    Tangential,
    /// Along the axis.
    Axial,
}

/// Direction in which the bar points while the spindle turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpindleBar {
    /// Along X.
    X,
    /// Along Y.
    Y,
}

/// One reading of the bar.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReadingDoc {
    /// Word of the axis that turns.
    #[schema(example = 90.0)]
    pub angle_deg: f64,
    /// Bar length minus its length at the start; longer is positive.
    #[schema(example = 8.6)]
    pub length_change_um: f64,
}

/// One test: one axis turns while RTCP holds the ball; the other axis is at zero. It has either readings or
/// the two eccentricities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BallBarTestDoc {
    /// Letter of the axis that turns.
    #[schema(example = "C")]
    pub rotary_axis: String,
    /// Direction in which the bar points at zero.
    pub bar_direction: BarDirectionDoc,
    /// Position of the programmed spindle ball at zero, from the reference point of the table axis next to
    /// the workpiece (the C centre of an AC table).
    #[schema(example = json!([150, 0, 60]))]
    pub ball_mm: Fixed<3>,
    /// Distance from the gauge point to the spindle ball; 0 by default. It matters only if the axis that
    /// turns is on the head.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_length_mm: Option<f64>,
    /// Standard uncertainty u of one reading, if the tests differ: the weights are 1/u². Give it for all
    /// tests or for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading_uncertainty_um: Option<f64>,
    /// Readings in the order of measurement: the forward sweep, then the sweep back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub readings: Option<Vec<ReadingDoc>>,
    /// Instead of readings: (x, y) of a C axis, (y, z) of an A axis, (z, x) of a B axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eccentricity_um: Option<Fixed<2>>,
}

/// Offset of the spindle ball from the spindle's line. Give either `e_xs` and `e_ys`, or the readings of a
/// spindle turned with both axes at zero (`spindle_deg`, `bar_direction`, `length_change_um`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetupErrorDoc {
    /// Offset along X, if it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_xs: Option<f64>,
    /// Offset along Y, if it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_ys: Option<f64>,
    /// Spindle angles; positive about +Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spindle_deg: Option<Vec<f64>>,
    /// Direction in which the bar points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bar_direction: Option<SpindleBar>,
    /// One reading for each spindle angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_change_um: Option<Vec<f64>>,
}

/// The centre of a sphere on the table, probed at one angle of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereCentreDoc {
    /// Centre in machine coordinates.
    #[schema(example = json!([-117.642, -81.681, -330.075]))]
    pub centre_mm: Fixed<3>,
    /// Word of the axis, if it was recorded. Give it for all centres of an axis or for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Index of the sphere, if there are several: 0, 1, …
    #[serde(default)]
    pub sphere: u32,
}

/// The centres that were probed while one axis turned and the other was at zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereAxisDoc {
    /// Letter of the table axis that turns.
    #[schema(example = "C")]
    pub rotary_axis: String,
    /// Centres in the order of measurement.
    pub centres: Vec<SphereCentreDoc>,
}

/// A calibration run: who measured, when, with what, and all readings. `instrument_uncertainty_um`,
/// `bar_length_mm`, `offset_per_test`, `setup_error_um`, `tests` and the uncertainties of the set-up belong to
/// `rtcp-ballbar`; `axes` belongs to `rotary-sphere`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = CalibrationRequest)]
pub struct CalibrationRequest {
    /// How the machine was measured.
    pub kind: CalibrationKind,
    /// Time of the measurement (RFC 3339); not in the future.
    #[schema(example = "2025-03-14T09:26:53Z", format = "date-time")]
    pub measured_at: String,
    /// Instrument that measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 200)]
    pub instrument: Option<String>,
    /// Serial number of the instrument.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "BB-4711", max_length = 200)]
    pub instrument_serial_number: Option<String>,
    /// The instrument's calibration certificate: its number, its date or both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "D-K-15133-2025-03", max_length = 200)]
    pub instrument_certificate: Option<String>,
    /// Person who measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 200)]
    pub operator: Option<String>,
    /// Temperature of the machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Any note of the operator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 2000)]
    pub note: Option<String>,
    /// Standard uncertainty of the instrument. If it is given, it widens the uncertainties in the answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument_uncertainty_um: Option<f64>,
    /// Standard uncertainty of each of both components of the set-up error, if it was given or is held at 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 1.0, minimum = 0)]
    pub setup_uncertainty_um: Option<f64>,
    /// Standard uncertainty of each coordinate of `ball_mm`. Tests with the same `ball_mm` count as one ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.5, minimum = 0)]
    pub ball_uncertainty_mm: Option<f64>,
    /// Standard uncertainty of `bar_length_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.05, minimum = 0)]
    pub bar_length_uncertainty_mm: Option<f64>,
    /// Length of the bar at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 100.0)]
    pub bar_length_mm: Option<f64>,
    /// True: the bar's zero is arbitrary, and one offset per test is fitted. False: the length of the bar is
    /// known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(default = true)]
    pub offset_per_test: Option<bool>,
    /// Offset of the spindle ball; null holds it at 0, and the answer says which errors that hides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup_error_um: Option<SetupErrorDoc>,
    /// The tests with the ball bar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tests: Option<Vec<BallBarTestDoc>>,
    /// The axes with probed spheres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<SphereAxisDoc>>,
}
