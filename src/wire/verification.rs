//! Virtual cutting of a part: parameters and report.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::statements::program_parameters;
use super::{
    AnySurface, Dialect, Fault, FaultList, LeftOutDoc, LocationErrors, NominalSurfaceDoc, ResolvedInputs,
    SurfaceMeshDoc, SurfaceReading, ToolDoc, Warning,
};
use crate::geometry::Vec3;
use crate::process::{
    self, Extreme, Histogram, ProgramSetup, Verification, VerificationFault, VerificationQuantity,
};
use crate::surface::{MeshReport, SurfacePoint};
use crate::units::Length;

program_parameters! {
/// What the virtual cutting of a part needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct VerificationParameters {
    /// The cutter that cuts, as measured; each section's own from the machine's tool table when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<ToolDoc>,
    /// How far above the tip the cutter cuts; four times its radius unless said, and at least 30.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutting_length_mm: Option<f64>,
    /// The nominal surface, where it is not uploaded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<NominalSurfaceDoc>,
    /// Millimetres of one unit of the uploaded surface: 25.4 for inches; 1 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// How far facets of the uploaded surface may stand off the smooth one that they stand for; 10 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// How many points of the surface are looked at.
    #[serde(default = "fifty_thousand")]
    #[schema(default = 50_000, minimum = 1, maximum = 2_000_000)]
    pub samples: usize,
    /// Height of the stock above the surface. Needles end there, and a cutter counts only where it contains that end.
    #[serde(default = "one")]
    #[schema(default = 1.0)]
    pub stock_mm: f64,
    /// More than this, above the surface or below it, is counted.
    #[serde(default = "thirty_um")]
    #[schema(default = 30.0)]
    pub limit_um: f64,
    /// Largest distance between a motion and the straight pieces that stand for it.
    #[serde(default = "half_um")]
    #[schema(default = 0.5)]
    pub resolution_um: f64,
    /// Whether measured errors of the machine count: whether it cuts as it is, or as it should be.
    #[serde(default)]
    pub location_errors: LocationErrors,
}
}

fn one() -> f64 {
    1.0
}

fn half_um() -> f64 {
    0.5
}

fn thirty_um() -> f64 {
    30.0
}

fn fifty_thousand() -> usize {
    50_000
}

impl VerificationParameters {
    /// Most samples of one verification.
    pub const MAX_SAMPLES: usize = 2_000_000;

    /// How an uploaded surface is read.
    #[must_use]
    pub fn surface_reading(&self) -> SurfaceReading {
        SurfaceReading {
            unit_mm: self.surface_unit_mm,
            chordal_tolerance_um: self.chordal_tolerance_um,
            contact_gap_um: None,
        }
    }

    /// The parameters in the core's terms, the program's set-up apart, and the surface where it is none that was uploaded; `is_uploaded` says
    /// whether one was.
    ///
    /// # Errors
    /// Every bad value, with its pointer.
    pub fn to_core(
        &self,
        is_uploaded: bool,
    ) -> Result<(process::VerificationParameters, Option<AnySurface>), Vec<Fault>> {
        let mut faults = FaultList::default();
        let tool = self.tool.and_then(|tool| tool.to_core("/tool", &mut faults));
        if self.tool.is_some_and(|tool| tool.length_mm.is_some()) {
            faults.push(|| Fault::new("/tool/length_mm", "where the length matters it is tool_length_mm"));
        }
        self.statements().check(&mut faults);
        let detail = match (&self.surface, is_uploaded) {
            (None, false) => Some("missing: give the surface here, or upload it in the field surface"),
            (Some(_), true) => Some("the surface is uploaded: one of them is enough"),
            _ => None,
        };
        if let Some(detail) = detail {
            faults.push(|| Fault::new("/surface", detail));
        }
        let surface = self.surface.as_ref().and_then(|surface| surface.to_core("/surface", &mut faults));
        self.surface_reading().check(is_uploaded, &mut faults);
        if !(1..=Self::MAX_SAMPLES).contains(&self.samples) {
            let detail = format!("{} is not between 1 and {}", self.samples, Self::MAX_SAMPLES);
            faults.push(|| Fault::new("/samples", detail));
        }
        let core = process::VerificationParameters {
            cutting_length: self.cutting_length_mm.map(Length::from_mm),
            stock: Length::from_mm(self.stock_mm),
            resolution: Length::from_um(self.resolution_um),
            limit: Length::from_um(self.limit_um),
            ..process::VerificationParameters::new(tool, ProgramSetup::default())
        };
        let anywhere = [SurfacePoint { point_mm: Vec3::zeros(), normal: Vec3::z() }];
        for fault in core.faults(&anywhere) {
            faults.push(|| verification_fault(&fault));
        }
        faults.into_result()?;
        Ok((core, surface))
    }
}

/// A fault of the core under the member it is about.
#[must_use]
pub fn verification_fault(fault: &VerificationFault) -> Fault {
    let pointer = match fault {
        VerificationFault::CutterBody(_) => "/cutting_length_mm",
        VerificationFault::OutOfRange { quantity, .. } => match quantity {
            VerificationQuantity::Stock => "/stock_mm",
            VerificationQuantity::Resolution => "/resolution_um",
            VerificationQuantity::Limit => "/limit_um",
        },
        VerificationFault::NoSamples | VerificationFault::Samples { .. } => "/surface",
    };
    Fault::new(pointer, fault.to_string())
}

/// What is left at the worst sample of one sign.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = WorstResidual)]
pub struct WorstResidualDoc {
    /// What stands above the surface along the normal, − below.
    pub residual_um: f64,
    /// Index of the sample: its row in the table of residuals, from 0.
    pub sample: u64,
    /// Place on the nominal surface, in W.
    pub x_mm: f64,
    /// Likewise.
    pub y_mm: f64,
    /// Likewise.
    pub z_mm: f64,
    /// Line of the upload that left it.
    pub line: u64,
}

/// Samples by what is left there: `counts[i]` of them from `edges_um[i]` up to `edges_um[i + 1]`, the bins within four
/// limits either way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ResidualHistogram)]
pub struct HistogramDoc {
    /// Edges of the bins, rising, one more than bins.
    pub edges_um: Vec<f64>,
    /// Samples in each bin.
    pub counts: Vec<u64>,
    /// Samples below the first edge.
    pub below: u64,
    /// Samples at or above the last one.
    pub above: u64,
}

/// How far residuals move when cut eight times as finely.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Convergence)]
pub struct ConvergenceDoc {
    /// Samples cut again: those with the largest residuals, and evenly chosen ones.
    pub samples: u64,
    /// The finer resolution.
    pub resolution_um: f64,
    /// Largest change of a residual.
    pub max_change_um: f64,
    /// Samples that a tool reaches at one of both resolutions only.
    pub cut_once: u64,
}

/// Motions that were cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = MotionsCut)]
pub struct MotionsCutDoc {
    /// Straight ones at feed.
    pub linear: u64,
    /// Arcs and helices.
    pub arcs: u64,
    /// Rapids, taken as straight.
    pub rapids: u64,
}

/// What a program leaves on the part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct VerificationReport {
    /// Revision of the machine it was computed on.
    pub machine_revision: i64,
    /// Version of the service.
    pub software_version: String,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// SHA-256 of the part's surface, where it was uploaded.
    pub surface_sha256: Option<String>,
    /// SHA-256 of the table of residuals.
    pub residuals_sha256: String,
    /// What it rests on beside its parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// Form the text was read in.
    pub dialect: Dialect,
    /// Blocks of the upload.
    pub blocks: u64,
    /// Motions that were cut.
    pub motions_cut: MotionsCutDoc,
    /// Motions whose course is not known.
    pub left_out: Vec<LeftOutDoc>,
    /// Samples of the surface.
    pub samples: u64,
    /// Side of the square that a sample stands for.
    pub sample_spacing_mm: f64,
    /// Area of the surface.
    pub area_mm2: f64,
    /// What was found in the file of an uploaded surface.
    pub surface_mesh: Option<SurfaceMeshDoc>,
    /// Samples that no tool reaches: they keep their stock.
    pub uncut: u64,
    /// Samples with more than `limit_um` left above the surface.
    pub excess_over_limit: u64,
    /// Samples cut deeper than `limit_um` below it.
    pub gouge_over_limit: u64,
    /// … of which by a rapid.
    pub gouged_by_rapid: u64,
    /// What may be left.
    pub limit_um: f64,
    /// Most above the surface; null where nothing is.
    pub max_excess: Option<WorstResidualDoc>,
    /// Deepest below it; null where nothing is.
    pub max_gouge: Option<WorstResidualDoc>,
    /// Line of the upload with the larger of both.
    pub worst_line: Option<u64>,
    /// Root mean square of what is left where a tool came; null where none did.
    pub rms_um: Option<f64>,
    /// Its mean.
    pub mean_um: Option<f64>,
    /// How many samples have how much left.
    pub histogram: HistogramDoc,
    /// Height of the stock.
    pub stock_mm: f64,
    /// Largest distance between a motion and the straight pieces that stood for it.
    pub resolution_um: f64,
    /// How sure the residuals are.
    pub convergence: ConvergenceDoc,
    /// Straight pieces that the motions were divided into.
    pub pieces: u64,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
}

impl WorstResidualDoc {
    fn of(extreme: &Extreme) -> Self {
        let Extreme { index, point_mm, residual } = extreme;
        Self {
            residual_um: Length::from_mm(residual.residual_mm).um(),
            sample: *index as u64,
            x_mm: point_mm.x,
            y_mm: point_mm.y,
            z_mm: point_mm.z,
            line: residual.line,
        }
    }
}

impl HistogramDoc {
    fn of(histogram: &Histogram) -> Self {
        Self {
            edges_um: histogram.edges_mm.iter().map(|edge_mm| Length::from_mm(*edge_mm).um()).collect(),
            counts: histogram.counts.clone(),
            below: histogram.below,
            above: histogram.above,
        }
    }
}

/// What a verification was made of.
#[derive(Debug, Clone, PartialEq)]
pub struct VerificationSources {
    /// Revision of the machine.
    pub machine_revision: i64,
    /// SHA-256 of the program.
    pub input_sha256: String,
    /// SHA-256 of the part's surface, where it was uploaded.
    pub surface_sha256: Option<String>,
    /// SHA-256 of the table of residuals.
    pub residuals_sha256: String,
    /// Side of the square that a sample stands for.
    pub sample_spacing_mm: f64,
    /// Area of the surface.
    pub area_mm2: f64,
    /// What was found in the file of an uploaded one.
    pub mesh: Option<MeshReport>,
    /// What it rests on beside its parameters.
    pub resolved: ResolvedInputs,
}

impl VerificationReport {
    /// The report of a verification.
    #[must_use]
    pub fn of(
        sources: VerificationSources,
        parameters: &process::VerificationParameters,
        verification: &Verification,
    ) -> Self {
        let Verification { summary, convergence, motions, .. } = verification;
        let contradicting = sources.mesh.map_or(0, |mesh| mesh.contradicting_normals);
        let contradiction = (contradicting > 0).then(|| Warning {
            kind: "contradicting_normals".to_owned(),
            detail: "the file states normals against the winding of its facets; the winding says where the part is"
                .to_owned(),
            count: contradicting,
            line: None,
            worst_line: None,
            max_distance_um: None,
            min_time_ms: None,
        });
        let of_cut = |length_mm: f64| (summary.cut > 0).then(|| Length::from_mm(length_mm).um());
        Self {
            machine_revision: sources.machine_revision,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            input_sha256: sources.input_sha256,
            surface_sha256: sources.surface_sha256,
            residuals_sha256: sources.residuals_sha256,
            resolved: Some(sources.resolved),
            dialect: verification.dialect.into(),
            blocks: verification.blocks,
            motions_cut: MotionsCutDoc { linear: motions.linear, arcs: motions.arcs, rapids: motions.rapids },
            left_out: verification.left_out.iter().map(Into::into).collect(),
            samples: summary.cut + summary.uncut,
            sample_spacing_mm: sources.sample_spacing_mm,
            area_mm2: sources.area_mm2,
            surface_mesh: sources.mesh.as_ref().map(Into::into),
            uncut: summary.uncut,
            excess_over_limit: summary.over_excess,
            gouge_over_limit: summary.over_gouge,
            gouged_by_rapid: summary.gouged_by_rapid,
            limit_um: parameters.limit.um(),
            max_excess: summary.max_excess.as_ref().map(WorstResidualDoc::of),
            max_gouge: summary.max_gouge.as_ref().map(WorstResidualDoc::of),
            worst_line: summary.worst_line,
            rms_um: of_cut(summary.rms_mm),
            mean_um: of_cut(summary.mean_mm),
            histogram: HistogramDoc::of(&summary.histogram),
            stock_mm: parameters.stock.mm(),
            resolution_um: parameters.resolution.um(),
            convergence: ConvergenceDoc {
                samples: convergence.samples,
                resolution_um: convergence.resolution.um(),
                max_change_um: convergence.max_change.um(),
                cut_once: convergence.cut_once,
            },
            pieces: verification.effort.pieces,
            warnings: verification.warnings.iter().map(Into::into).chain(contradiction).collect(),
        }
    }
}
