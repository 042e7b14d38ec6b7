//! A calibration run as it is posted.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Fixed;

/// How the machine was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CalibrationKind {
    /// A ball bar between table and spindle while RTCP holds the spindle's ball.
    RtcpBallbar,
    /// Centres of spheres on the table, probed at several angles of an axis.
    RotarySphere,
}

impl CalibrationKind {
    /// As it stands in documents.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::RtcpBallbar => "rtcp-ballbar",
            Self::RotarySphere => "rotary-sphere",
        }
    }
}

/// Which way the bar points at zero.
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

/// Which way the bar points while the spindle turns.
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
    /// Word of the axis.
    #[schema(example = 90.0)]
    pub angle_deg: f64,
    /// Bar length minus its length at the start, longer positive.
    #[schema(example = 8.6)]
    pub length_change_um: f64,
}

/// One test: an axis turned with the ball held by RTCP, the other axis at zero. Readings, or the two eccentricities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BallBarTestDoc {
    /// Letter of the axis that turns.
    #[schema(example = "C")]
    pub rotary_axis: String,
    /// Which way the bar points at zero.
    pub bar_direction: BarDirectionDoc,
    /// The programmed spindle ball at zero, from the reference point of the table axis next to the workpiece (the C
    /// centre of an AC table).
    #[schema(example = json!([150, 0, 60]))]
    pub ball_mm: Fixed<3>,
    /// From the gauge point to the spindle ball, 0 unless given; counts where the axis that turns is on the head.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_length_mm: Option<f64>,
    /// Standard uncertainty of one reading, where tests differ: weights are 1/u². All tests or none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading_uncertainty_um: Option<f64>,
    /// In the order of measurement; sweeps there and back one after the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub readings: Option<Vec<ReadingDoc>>,
    /// In place of readings: (x, y) of a C axis, (y, z) of an A axis, (z, x) of a B axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eccentricity_um: Option<Fixed<2>>,
}

/// The spindle ball's offset from the spindle's line: `e_xs` and `e_ys`, or the readings of a spindle turned at zero of
/// both axes (`spindle_deg`, `bar_direction`, `length_change_um`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetupErrorDoc {
    /// Along X, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_xs: Option<f64>,
    /// Along Y, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_ys: Option<f64>,
    /// Spindle angles, positive about +Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spindle_deg: Option<Vec<f64>>,
    /// Which way the bar points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bar_direction: Option<SpindleBar>,
    /// A reading for each spindle angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_change_um: Option<Vec<f64>>,
}

/// The centre of a sphere on the table, probed at one angle of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereCentreDoc {
    /// In machine coordinates.
    #[schema(example = json!([-117.642, -81.681, -330.075]))]
    pub centre_mm: Fixed<3>,
    /// Word of the axis, where it was noted; for all centres of an axis or none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Which sphere, where there are several: 0, 1, …
    #[serde(default)]
    pub sphere: u32,
}

/// What was probed while one axis turned, the other at zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereAxisDoc {
    /// Letter of the table axis that turns.
    #[schema(example = "C")]
    pub rotary_axis: String,
    /// In the order of measurement.
    pub centres: Vec<SphereCentreDoc>,
}

/// A run: who, when and with what, and everything that was read. `instrument_uncertainty_um`, `bar_length_mm`,
/// `offset_per_test`, `setup_error_um` and `tests` belong to `rtcp-ballbar`, `axes` to `rotary-sphere`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = CalibrationRequest)]
pub struct CalibrationRequest {
    /// How the machine was measured.
    pub kind: CalibrationKind,
    /// When (RFC 3339); not in the future.
    #[schema(example = "2025-03-14T09:26:53Z", format = "date-time")]
    pub measured_at: String,
    /// With what.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 200)]
    pub instrument: Option<String>,
    /// By whom.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 200)]
    pub operator: Option<String>,
    /// Of the machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// What else the operator wants to be remembered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 2000)]
    pub note: Option<String>,
    /// Standard uncertainty of the instrument; widens the answer where it is posted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument_uncertainty_um: Option<f64>,
    /// Length of the bar at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 100.0)]
    pub bar_length_mm: Option<f64>,
    /// Whether the bar's zero is arbitrary, so that one offset per test is fitted. False where its length is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(default = true)]
    pub offset_per_test: Option<bool>,
    /// The spindle ball's offset; null holds it at 0 and says what that hides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup_error_um: Option<SetupErrorDoc>,
    /// The tests with the ball bar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tests: Option<Vec<BallBarTestDoc>>,
    /// The axes with probed spheres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<SphereAxisDoc>>,
}
