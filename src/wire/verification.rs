//! Virtual cutting of a part: parameters and report.

use serde::{Deserialize, Serialize};

use super::statements::program_parameters;
use super::{
    AnySurface, Dialect, Fault, FaultList, LeftOutDoc, LocationErrors, NominalSurfaceDoc, ResolvedInputs,
    SurfaceMeshDoc, SurfaceReading, ToolDoc, Warning,
};
use crate::description::ToSchema;
use crate::geometry::Vec3;
use crate::process::{
    self, Extreme, Histogram, ProgramSetup, Verification, VerificationFault, VerificationQuantity,
};
use crate::surface::{MeshReport, SurfacePoint};
use crate::units::Length;

program_parameters! {
/// Parameters of the virtual cutting of a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct VerificationParameters {
    /// The cutter, as measured. If it is absent, the machine's tool table gives each section its cutter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<ToolDoc>,
    /// Height above the tip up to which the cutter cuts; default four times its radius, at least 30.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutting_length_mm: Option<f64>,
    /// The nominal surface, if it is not uploaded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<NominalSurfaceDoc>,
    /// Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// Largest distance of the uploaded facets from the smooth surface; default 10.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// Number of sample points on the surface.
    #[serde(default = "fifty_thousand")]
    #[schema(default = 50_000, minimum = 1, maximum = 2_000_000)]
    pub samples: usize,
    /// Height of the stock above the surface. Needles end there; a cutter cuts a needle only if it contains
    /// this end.
    #[serde(default = "one")]
    #[schema(default = 1.0)]
    pub stock_mm: f64,
    /// Samples with a residual larger than this, above or below the surface, are counted.
    #[serde(default = "thirty_um")]
    #[schema(default = 30.0)]
    pub limit_um: f64,
    /// Largest distance between a motion and the straight pieces that replace it.
    #[serde(default = "half_um")]
    #[schema(default = 0.5)]
    pub resolution_um: f64,
    /// Whether measured errors of the machine are applied: the machine as it is, or the nominal machine.
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

    /// The parameters in the core's terms, without the set-up of the program, and the surface if it was not
    /// uploaded; `is_uploaded` says whether it was.
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
            faults.push(|| {
                Fault::new("/tool/length_mm", "the length has no place here; give it as tool_length_mm")
            });
        }
        self.statements().check(&mut faults);
        let detail = match (&self.surface, is_uploaded) {
            (None, false) => Some("missing: give the surface here, or upload it in the field surface"),
            (Some(_), true) => Some("a surface is uploaded and given here; leave one of them out"),
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

/// A fault of the core under the member that it concerns.
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

/// The residual at the worst sample of one sign.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = WorstResidual)]
pub struct WorstResidualDoc {
    /// Material above the surface along the normal; negative below it.
    pub residual_um: f64,
    /// Index of the sample: its row in the table of residuals, from 0.
    pub sample: u64,
    /// X of the sample on the nominal surface, in W.
    pub x_mm: f64,
    /// Y of the sample.
    pub y_mm: f64,
    /// Z of the sample.
    pub z_mm: f64,
    /// Line of the upload that left it.
    pub line: u64,
}

/// Histogram of the residuals: `counts[i]` samples have a residual from `edges_um[i]` up to
/// `edges_um[i + 1]`. The bins reach four limits to either side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ResidualHistogram)]
pub struct HistogramDoc {
    /// Edges of the bins in rising order; one more than bins.
    pub edges_um: Vec<f64>,
    /// Number of samples in each bin.
    pub counts: Vec<u64>,
    /// Number of samples below the first edge.
    pub below: u64,
    /// Number of samples at or above the last edge.
    pub above: u64,
}

/// Change of the residuals when the cut is repeated with an eight times finer resolution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Convergence)]
pub struct ConvergenceDoc {
    /// Samples that were cut again: those with the largest residuals, and evenly chosen ones.
    pub samples: u64,
    /// The finer resolution.
    pub resolution_um: f64,
    /// Largest change of a residual.
    pub max_change_um: f64,
    /// Samples that a tool reaches at only one of the two resolutions.
    pub cut_once: u64,
}

/// Motions that were cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = MotionsCut)]
pub struct MotionsCutDoc {
    /// Straight motions at feed.
    pub linear: u64,
    /// Arcs and helices.
    pub arcs: u64,
    /// Rapids, treated as straight.
    pub rapids: u64,
}

/// The result of a verification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct VerificationReport {
    /// Revision of the machine that was used.
    pub machine_revision: i64,
    /// Version of the service.
    pub software_version: String,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// SHA-256 of the part's surface, if it was uploaded.
    pub surface_sha256: Option<String>,
    /// SHA-256 of the table of residuals.
    pub residuals_sha256: String,
    /// Inputs that were resolved beside the parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// Dialect of the program text.
    pub dialect: Dialect,
    /// Number of blocks in the upload.
    pub blocks: u64,
    /// Motions that were cut.
    pub motions_cut: MotionsCutDoc,
    /// Motions that were not cut because their course is not known.
    pub left_out: Vec<LeftOutDoc>,
    /// Number of samples on the surface.
    pub samples: u64,
    /// Side of the square that a sample represents.
    pub sample_spacing_mm: f64,
    /// Area of the surface.
    pub area_mm2: f64,
    /// Properties of the uploaded surface file.
    pub surface_mesh: Option<SurfaceMeshDoc>,
    /// Number of samples that no tool reaches: they keep their stock.
    pub uncut: u64,
    /// Number of samples with more than `limit_um` left above the surface.
    pub excess_over_limit: u64,
    /// Number of samples that are cut deeper than `limit_um` below the surface.
    pub gouge_over_limit: u64,
    /// Number of these samples that a rapid cut.
    pub gouged_by_rapid: u64,
    /// Largest residual that is not counted.
    pub limit_um: f64,
    /// Largest residual above the surface; null if there is none.
    pub max_excess: Option<WorstResidualDoc>,
    /// Deepest cut below the surface; null if there is none.
    pub max_gouge: Option<WorstResidualDoc>,
    /// Line of the upload that left the larger of the two.
    pub worst_line: Option<u64>,
    /// Root mean square of the residuals where a tool came; null if no tool came.
    pub rms_um: Option<f64>,
    /// Mean of the same residuals.
    pub mean_um: Option<f64>,
    /// Histogram of the residuals.
    pub histogram: HistogramDoc,
    /// Height of the stock.
    pub stock_mm: f64,
    /// Largest distance between a motion and the straight pieces that replaced it.
    pub resolution_um: f64,
    /// Accuracy of the residuals.
    pub convergence: ConvergenceDoc,
    /// Number of straight pieces that the motions were divided into.
    pub pieces: u64,
    /// Warnings to the caller.
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

/// The sources of a verification.
#[derive(Debug, Clone, PartialEq)]
pub struct VerificationSources {
    /// Revision of the machine.
    pub machine_revision: i64,
    /// SHA-256 of the program.
    pub input_sha256: String,
    /// SHA-256 of the part's surface, if it was uploaded.
    pub surface_sha256: Option<String>,
    /// SHA-256 of the table of residuals.
    pub residuals_sha256: String,
    /// Side of the square that a sample represents.
    pub sample_spacing_mm: f64,
    /// Area of the surface.
    pub area_mm2: f64,
    /// Properties of the uploaded file.
    pub mesh: Option<MeshReport>,
    /// Inputs that were resolved beside the parameters.
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
            detail: "the file has normals that contradict the winding of their facets; the winding was used"
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
