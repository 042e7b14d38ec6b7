//! Parts that the reports of all operations on programs share.

use serde::{Deserialize, Serialize};

use super::StepName;
use crate::description::ToSchema;
use crate::process;
use crate::units::{Length, UM_PER_MM};

/// Deviation of the CC path over all checked motions.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DeviationSummary {
    /// Largest distance from the line.
    pub max_um: f64,
    /// Root of the mean square along the path.
    pub rms_um: f64,
    /// Largest distance on the side of too much material.
    pub max_excess_um: f64,
    /// Largest distance on the side of too little material (gouge).
    pub max_gouge_um: f64,
    /// Line of the upload with the largest distance; null if no motion was checked.
    pub worst_line: Option<u64>,
}

impl From<&process::DeviationSummary> for DeviationSummary {
    fn from(core: &process::DeviationSummary) -> Self {
        Self {
            max_um: core.max_mm * UM_PER_MM,
            rms_um: core.rms_mm * UM_PER_MM,
            max_excess_um: core.max_excess_mm * UM_PER_MM,
            max_gouge_um: core.max_gouge_mm * UM_PER_MM,
            worst_line: core.worst_line,
        }
    }
}

/// Deviation along the path, down-sampled; all arrays have the same length.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DeviationSeries {
    /// Path length up to the sample.
    pub path_mm: Vec<f64>,
    /// Line of the upload.
    pub line: Vec<u64>,
    /// Distance before.
    pub before_um: Vec<f64>,
    /// Distance after, from the text that was written.
    pub after_um: Vec<f64>,
}

impl From<&process::Series> for DeviationSeries {
    fn from(core: &process::Series) -> Self {
        let points = core.points();
        Self {
            path_mm: points.iter().map(|point| point.path_mm).collect(),
            line: points.iter().map(|point| point.line).collect(),
            before_um: points.iter().map(|point| point.before_mm * UM_PER_MM).collect(),
            after_um: points.iter().map(|point| point.after_mm * UM_PER_MM).collect(),
        }
    }
}

/// Something that the caller should know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Warning {
    /// A stable word for the kind of warning.
    #[schema(example = "contact_off_tool")]
    pub kind: String,
    /// The warning in words.
    pub detail: String,
    /// Number of motions or points that it concerns.
    pub count: u64,
    /// First line of the upload that it concerns, 1-based.
    pub line: Option<u64>,
    /// Line with the largest distance, if the warning has a distance.
    pub worst_line: Option<u64>,
    /// Largest distance, if the warning has one.
    pub max_distance_um: Option<f64>,
    /// Shortest time, if the warning has one.
    #[serde(default)]
    pub min_time_ms: Option<f64>,
}

impl Warning {
    /// A warning about the whole program.
    #[must_use]
    pub fn plain(kind: &str, detail: &str) -> Self {
        Self {
            kind: kind.to_owned(),
            detail: detail.to_owned(),
            count: 1,
            line: None,
            worst_line: None,
            max_distance_um: None,
            min_time_ms: None,
        }
    }
}

impl From<&process::Warning> for Warning {
    fn from(core: &process::Warning) -> Self {
        let text = core.kind.text();
        Self {
            kind: core.kind.name().to_owned(),
            detail: core.reason.map_or_else(|| text.to_owned(), |reason| format!("{text}: {reason}")),
            count: core.count,
            line: core.line,
            worst_line: core.worst_line,
            max_distance_um: core.max_distance_mm.map(|distance_mm| Length::from_mm(distance_mm).um()),
            min_time_ms: core.min_time_s.map(|time_s| time_s * MS_PER_S),
        }
    }
}

/// Milliseconds in a second.
const MS_PER_S: f64 = 1000.0;

/// The data that a result was computed from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Provenance {
    /// Revision of the machine that was used.
    pub machine_revision: i64,
    /// Version of the service.
    pub software_version: String,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// SHA-256 of the answer.
    pub output_sha256: String,
    /// The steps that changed the program; null if an older version of the service did not record them.
    #[serde(default)]
    #[schema(example = json!(["cc"]))]
    pub steps: Option<Vec<StepName>>,
}
