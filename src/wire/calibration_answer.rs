//! What a calibration run says about the machine.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::calibration::CalibrationKind;
use super::calibration_words::{blind_words, further_words, warning_words};
use super::{BarDirectionDoc, CalibrationRequest, SetupErrorDoc, SphereAxisAnswer};
use crate::calibration::{
    AbsoluteError, Blind, COMPONENT_NAMES, Eccentricities, ErrorParameter, FurtherRun, Identified,
    RunWarning, Unknown, iso_230_symbol, placing_parameters, told_per_unit,
};
use crate::machine::Machine;
use crate::units::UM_PER_MM;

/// A value with its standard uncertainty, both in the unit of its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard uncertainty; null where the readings give none.
    pub standard_uncertainty: Option<f64>,
}

/// Estimates by name, the unit in the name.
pub type Estimates = BTreeMap<String, Estimate>;

/// Where the set-up error came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SetupErrorSource {
    /// Posted.
    Given,
    /// From the spindle step.
    Measured,
    /// Not known, so held at zero.
    HeldAtZero,
}

/// The offset of the spindle ball from the spindle's line (µm).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SetupErrorAnswer {
    /// Along X.
    pub e_xs: Estimate,
    /// Along Y.
    pub e_ys: Estimate,
    /// Where they came from.
    pub source: SetupErrorSource,
}

/// Eccentricities by test (µm), in the order of the tests: (x, y) of a C axis, (y, z) of an A axis, (z, x) of a B axis;
/// null where the angles do not determine them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EccentricitiesDoc {
    /// As measured.
    pub before: Vec<Option<[f64; 2]>>,
    /// As predicted when the control compensates the linear errors alone.
    pub after_linear: Vec<Option<[f64; 2]>>,
    /// As predicted when it compensates all.
    pub after_all: Vec<Option<[f64; 2]>>,
}

/// Covariance of what was identified (µm², µm·µrad, µrad²).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CovarianceDoc {
    /// What the rows and columns are.
    pub names: Vec<String>,
    /// Row by row.
    pub matrix_um_urad: Vec<Vec<f64>>,
}

/// A combination that the run cannot see.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BlindDoc {
    /// How much of each changes no reading (µm, µrad); the largest is 1.
    #[schema(example = json!({"A.e_x_um": 1.0, "e_xs_um": 1.0}))]
    pub parts_um_urad: BTreeMap<String, f64>,
    /// The tests whose offset, the bar's zero, takes part.
    pub offsets_of_tests: Vec<usize>,
    /// In words.
    pub words: String,
    /// The run to add, in words; null where no ball-bar test would help.
    pub separated_by: Option<String>,
}

/// A reading that was left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OutlierDoc {
    /// Index of the test, from 0.
    pub test: usize,
    /// Index of the reading, from 0.
    pub reading: usize,
    /// Measured minus fitted.
    pub residual_um: f64,
}

/// One test as it was evaluated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TestAnswer {
    /// The axis.
    pub rotary_axis: String,
    /// The bar's direction.
    pub bar_direction: BarDirectionDoc,
    /// How many readings; 0 where eccentricities were posted.
    pub readings: usize,
    /// The fitted offset; null where none was.
    pub offset_um: Option<f64>,
    /// Root of the mean square of the residuals.
    pub residual_rms_um: f64,
}

/// Something to ask about.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct RunWarningDoc {
    /// The kind, for programs.
    #[schema(example = "single-sweep")]
    pub kind: String,
    /// Index of the test, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test: Option<usize>,
    /// In words.
    pub detail: String,
}

/// What only a ball-bar run has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BallBarAnswer {
    /// The spindle ball's offset.
    pub setup_error_um: SetupErrorAnswer,
    /// Before and after compensation.
    pub eccentricities_um: EccentricitiesDoc,
    /// By test.
    pub tests: Vec<TestAnswer>,
    /// What was left out as too far from all others; the first thousand.
    pub outliers: Vec<OutlierDoc>,
}

/// What a run says about a machine; the same for ever.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Calibration)]
pub struct CalibrationDocument {
    /// The run.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// The machine.
    pub machine_id: String,
    /// Its revision when it was measured.
    pub machine_revision: i64,
    /// How it was measured.
    pub kind: CalibrationKind,
    /// When it was measured.
    #[schema(example = "2025-03-14T09:26:53.000Z")]
    pub measured_at: String,
    /// When it was stored.
    #[schema(example = "2025-03-14T09:41:07.123Z")]
    pub created_at: String,
    /// With what.
    pub instrument: Option<String>,
    /// By whom.
    pub operator: Option<String>,
    /// Of the machine.
    pub temperature_c: Option<f64>,
    /// The operator's note.
    pub note: Option<String>,
    /// SHA-256 of the stored run.
    pub run_sha256: String,
    /// The build that evaluated it.
    pub software_version: String,
    /// The location errors by axis, cascaded as in the profile: what `apply` writes there.
    #[schema(example = json!({"A": {"e_y_um": {"value": -21.0, "standard_uncertainty": 0.1}}}))]
    #[schema(value_type = BTreeMap<String, BTreeMap<String, Estimate>>)]
    pub errors: BTreeMap<String, Estimates>,
    /// The same against the machine's frame, with the symbols of ISO 230-7.
    #[schema(example = json!({"E_Y0A_um": {"value": -21.0, "standard_uncertainty": 0.1}}))]
    #[schema(value_type = BTreeMap<String, Estimate>)]
    pub iso_230: Estimates,
    /// Components that place no line of this machine beyond those above; they stay zero.
    pub redundant: Vec<String>,
    /// What the run does not determine, whether cascaded, against the machine's frame, or of the set-up: the value
    /// carries whatever it cannot be told from.
    pub unidentifiable: Vec<String>,
    /// What cannot be told from what.
    pub blind: Vec<BlindDoc>,
    /// How many of `unknowns` the readings determine; offsets not counted.
    pub rank: usize,
    /// The location errors sought, and the two set-up errors where they were not given.
    pub unknowns: usize,
    /// Largest singular value over the smallest, columns at unit length; null where spheres were probed.
    pub condition_number: Option<f64>,
    /// Observations less what was fitted to them; of spheres without angles, of planes and circles each.
    pub degrees_of_freedom: usize,
    /// Root of the mean square of the residuals.
    pub residual_rms_um: f64,
    /// Null where nothing is left over to judge by.
    pub covariance: Option<CovarianceDoc>,
    /// What only a ball-bar run has.
    #[serde(flatten)]
    pub ball_bar: Option<BallBarAnswer>,
    /// The axes found, where spheres were probed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<SphereAxisAnswer>>,
    /// What a metrologist would ask about.
    pub warnings: Vec<RunWarningDoc>,
}

/// The name of a component.
#[must_use]
pub(super) fn component_name(component: usize) -> &'static str {
    COMPONENT_NAMES.get(component).copied().unwrap_or_default()
}

/// The ISO 230-7 symbol of an absolute error, with its unit: `E_Y0A_um`.
fn iso_name(machine: &Machine, error: &AbsoluteError) -> String {
    let letter = machine.rotary_axes()[error.axis].letter;
    let unit = if error.component < 3 { "um" } else { "urad" };
    format!("{}_{unit}", iso_230_symbol(letter, error.component))
}

/// The name of a cascaded error: `A.e_y_um`.
#[must_use]
pub(super) fn parameter_name(machine: &Machine, parameter: ErrorParameter) -> String {
    let letter = machine.rotary_axes().get(parameter.axis).map_or('?', |axis| axis.letter.as_char());
    format!("{letter}.{}", component_name(parameter.component))
}

/// The name of anything sought.
#[must_use]
pub(super) fn unknown_name(machine: &Machine, unknown: Unknown) -> String {
    match unknown {
        Unknown::Error(parameter) => parameter_name(machine, parameter),
        Unknown::SetupError(0) => "e_xs_um".to_owned(),
        Unknown::SetupError(_) => "e_ys_um".to_owned(),
    }
}

/// Most outliers listed in a document: a page of a list holds two hundred documents.
const MOST_OUTLIERS: usize = 1000;

/// Everything of a document that does not come from the evaluation.
#[derive(Debug, Clone)]
pub struct CalibrationHead<'a> {
    /// New.
    pub id: String,
    /// The machine.
    pub machine_id: &'a str,
    /// Its revision.
    pub machine_revision: i64,
    /// Normalised.
    pub measured_at: String,
    /// Now.
    pub created_at: String,
    /// Of the stored run.
    pub run_sha256: String,
}

impl CalibrationDocument {
    /// The document of a ball-bar run.
    #[must_use]
    pub fn of_ballbar(
        head: CalibrationHead<'_>,
        request: &CalibrationRequest,
        machine: &Machine,
        found: &Identified,
    ) -> Self {
        let mut document = Self::empty(head, request, machine);
        let sigma = |index: usize| {
            let open = found.undetermined.get(index).copied().unwrap_or(true);
            let variance = found.covariance.as_ref().filter(|_| !open).map(|matrix| matrix[(index, index)]);
            variance.map(f64::sqrt)
        };
        let mut setup = [0, 1].map(|component| Estimate {
            value: found.setup_error_mm[component] * UM_PER_MM,
            standard_uncertainty: None,
        });
        for (index, unknown) in found.unknowns.iter().copied().enumerate() {
            let unit = unknown.told_per_unit();
            let standard_uncertainty = sigma(index).map(|sigma| sigma * unit);
            match unknown {
                Unknown::Error(parameter) => {
                    let value = parameter.value(&found.errors) * unit;
                    document.set(machine, parameter, Estimate { value, standard_uncertainty });
                }
                Unknown::SetupError(component) => {
                    setup[component].standard_uncertainty = standard_uncertainty;
                }
            }
        }
        document.set_absolute(machine, &found.absolute);
        document.unidentifiable = unidentifiable(machine, found);
        document.blind = found.blind.iter().map(|blind| BlindDoc::of(machine, blind)).collect();
        document.rank = found.rank;
        document.unknowns = found.counted;
        document.condition_number = Some(found.condition_number);
        document.degrees_of_freedom = found.degrees_of_freedom;
        document.residual_rms_um = found.residual_rms_mm * UM_PER_MM;
        document.covariance =
            found.covariance.as_ref().map(|matrix| CovarianceDoc::of(machine, &found.unknowns, matrix));
        document.warnings = found.warnings.iter().map(RunWarningDoc::of).collect();
        let [e_xs, e_ys] = setup;
        let source = SetupErrorDoc::source(request.setup_error_um.as_ref());
        document.ball_bar = Some(BallBarAnswer {
            setup_error_um: SetupErrorAnswer { e_xs, e_ys, source },
            eccentricities_um: EccentricitiesDoc::of(&found.eccentricities),
            tests: tests(request, found),
            outliers: found
                .outliers
                .iter()
                .take(MOST_OUTLIERS)
                .map(|outlier| OutlierDoc {
                    test: outlier.test,
                    reading: outlier.reading,
                    residual_um: outlier.residual_mm * UM_PER_MM,
                })
                .collect(),
        });
        document
    }

    /// A document with nothing found yet.
    pub(super) fn empty(head: CalibrationHead<'_>, request: &CalibrationRequest, machine: &Machine) -> Self {
        let placing = placing_parameters(machine);
        Self {
            id: head.id,
            machine_id: head.machine_id.to_owned(),
            machine_revision: head.machine_revision,
            kind: request.kind,
            measured_at: head.measured_at,
            created_at: head.created_at,
            instrument: request.instrument.clone(),
            operator: request.operator.clone(),
            temperature_c: request.temperature_c,
            note: request.note.clone(),
            run_sha256: head.run_sha256,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            errors: BTreeMap::new(),
            iso_230: BTreeMap::new(),
            redundant: ErrorParameter::every()
                .filter(|parameter| !placing.contains(parameter))
                .map(|parameter| parameter_name(machine, parameter))
                .collect(),
            unidentifiable: Vec::new(),
            blind: Vec::new(),
            rank: 0,
            unknowns: 0,
            condition_number: None,
            degrees_of_freedom: 0,
            residual_rms_um: 0.0,
            covariance: None,
            ball_bar: None,
            axes: None,
            warnings: Vec::new(),
        }
    }

    /// Puts a cascaded error into the document.
    pub(super) fn set(&mut self, machine: &Machine, parameter: ErrorParameter, estimate: Estimate) {
        if let Some(axis) = machine.rotary_axes().get(parameter.axis) {
            let of_axis = self.errors.entry(axis.letter.as_char().to_string()).or_default();
            of_axis.insert(component_name(parameter.component).to_owned(), estimate);
        }
    }
}

impl CalibrationDocument {
    /// Puts the errors against the machine's frame into the document.
    pub(super) fn set_absolute(&mut self, machine: &Machine, absolute: &[AbsoluteError]) {
        for error in absolute {
            let unit = told_per_unit(error.component);
            let standard_uncertainty = error.variance.map(|variance| variance.max(0.0).sqrt() * unit);
            let estimate = Estimate { value: error.value * unit, standard_uncertainty };
            self.iso_230.insert(iso_name(machine, error), estimate);
        }
    }
}

impl CovarianceDoc {
    /// Of these unknowns, from the core's units.
    pub(super) fn of(machine: &Machine, unknowns: &[Unknown], matrix: &DMatrix<f64>) -> Self {
        let units: Vec<f64> = unknowns.iter().map(Unknown::told_per_unit).collect();
        let row = |row: usize| -> Vec<f64> {
            units.iter().enumerate().map(|(column, unit)| matrix[(row, column)] * units[row] * unit).collect()
        };
        Self {
            names: unknowns.iter().map(|unknown| unknown_name(machine, *unknown)).collect(),
            matrix_um_urad: (0..units.len()).map(row).collect(),
        }
    }
}

impl SetupErrorDoc {
    fn source(posted: Option<&Self>) -> SetupErrorSource {
        match posted {
            None => SetupErrorSource::HeldAtZero,
            Some(doc) if doc.spindle_deg.is_some() => SetupErrorSource::Measured,
            Some(_) => SetupErrorSource::Given,
        }
    }
}

impl EccentricitiesDoc {
    fn of(found: &[Eccentricities]) -> Self {
        let um = |pair: Option<[f64; 2]>| pair.map(|pair| pair.map(|mm| mm * UM_PER_MM));
        Self {
            before: found.iter().map(|one| um(one.before_mm)).collect(),
            after_linear: found.iter().map(|one| um(one.after_linear_mm)).collect(),
            after_all: found.iter().map(|one| um(one.after_all_mm)).collect(),
        }
    }
}

impl BlindDoc {
    fn of(machine: &Machine, blind: &Blind) -> Self {
        Self {
            parts_um_urad: blind
                .parts
                .iter()
                .map(|(unknown, part)| (unknown_name(machine, *unknown), *part))
                .collect(),
            offsets_of_tests: blind.offsets.clone(),
            words: blind_words(machine, blind),
            separated_by: blind.separated_by.map(|run: FurtherRun| further_words(machine, run)),
        }
    }
}

impl RunWarningDoc {
    fn of(warning: &RunWarning) -> Self {
        let (kind, test, detail) = warning_words(warning);
        Self { kind: kind.to_owned(), test, detail }
    }
}

/// Everything with a part in what the run cannot see.
fn unidentifiable(machine: &Machine, found: &Identified) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let in_blind = found.blind.iter().flat_map(|blind| blind.parts.iter().map(|(unknown, _)| *unknown));
    let open = found
        .unknowns
        .iter()
        .zip(&found.undetermined)
        .filter(|(_, open)| **open)
        .map(|(unknown, _)| *unknown);
    let mut unknowns: Vec<Unknown> = in_blind.chain(open).collect();
    unknowns.sort();
    unknowns.dedup();
    names.extend(unknowns.into_iter().map(|unknown| unknown_name(machine, unknown)));
    let absolute = found.absolute.iter().filter(|error| !error.identifiable);
    names.extend(absolute.map(|error| iso_name(machine, error)));
    names
}

fn tests(request: &CalibrationRequest, found: &Identified) -> Vec<TestAnswer> {
    let posted = request.tests.iter().flatten().enumerate();
    posted
        .map(|(index, test)| {
            let residuals = found.residuals_mm.get(index).map_or(&[] as &[f64], Vec::as_slice);
            // In the order of the readings, of which there may be very many.
            let out: Vec<usize> =
                found.outliers.iter().filter(|out| out.test == index).map(|out| out.reading).collect();
            let kept =
                residuals.iter().enumerate().filter(|(reading, _)| out.binary_search(reading).is_err());
            let (count, squares) =
                kept.fold((0.0, 0.0), |(count, squares), (_, value)| (count + 1.0, squares + value * value));
            TestAnswer {
                rotary_axis: test.rotary_axis.clone(),
                bar_direction: test.bar_direction,
                readings: test.readings.as_ref().map_or(0, Vec::len),
                offset_um: found.offsets_mm.get(index).copied().flatten().map(|mm| mm * UM_PER_MM),
                residual_rms_um: if count > 0.0 { f64::sqrt(squares / count) * UM_PER_MM } else { 0.0 },
            }
        })
        .collect()
}
