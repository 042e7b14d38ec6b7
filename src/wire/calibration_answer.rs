//! What a calibration run says about the machine.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::calibration::CalibrationKind;
use super::calibration_words::{blind_words, further_words, warning_words};
use super::{BarDirectionDoc, CalibrationRequest, SetupErrorDoc, SphereAxisAnswer};
use crate::calibration::{
    AbsoluteError, Blind, COMPONENT_NAMES, Eccentricities, ErrorParameter, FurtherRun, Identified,
    RunWarning, Unknown, iso_230_symbol, placing_parameters, told_per_unit,
};
use crate::description::ToSchema;
use crate::machine::Machine;
use crate::units::UM_PER_MM;

/// A value with its standard uncertainty, both in the unit of its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard uncertainty; null if the readings do not give it.
    pub standard_uncertainty: Option<f64>,
}

/// Estimates by name. The name contains the unit.
pub type Estimates = BTreeMap<String, Estimate>;

/// Where the set-up error came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SetupErrorSource {
    /// It was posted with the run.
    Given,
    /// It was measured with the spindle step.
    Measured,
    /// It is not known and is held at zero.
    HeldAtZero,
}

/// The offset of the spindle ball from the spindle's line (µm).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SetupErrorAnswer {
    /// Offset along X.
    pub e_xs: Estimate,
    /// Offset along Y.
    pub e_ys: Estimate,
    /// Where the two values came from.
    pub source: SetupErrorSource,
}

/// Eccentricities of each test (µm), in the order of the tests: (x, y) of a C axis, (y, z) of an A axis, (z,
/// x) of a B axis. Null if the angles do not determine them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EccentricitiesDoc {
    /// Eccentricities as measured.
    pub before: Vec<Option<[f64; 2]>>,
    /// Predicted eccentricities if the control compensates only the linear errors.
    pub after_linear: Vec<Option<[f64; 2]>>,
    /// Predicted eccentricities if the control compensates all errors.
    pub after_all: Vec<Option<[f64; 2]>>,
}

/// Covariance of the identified errors (µm², µm·µrad, µrad²).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CovarianceDoc {
    /// Names of the rows and columns.
    pub names: Vec<String>,
    /// Matrix, row by row.
    pub matrix_um_urad: Vec<Vec<f64>>,
}

/// A combination of errors that the run cannot see.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BlindDoc {
    /// Share of each error in a combination that changes no reading (µm, µrad); the largest share is 1.
    #[schema(example = json!({"A.e_x_um": 1.0, "e_xs_um": 1.0}))]
    pub parts_um_urad: BTreeMap<String, f64>,
    /// Tests whose offset (the bar's zero) is part of the combination.
    pub offsets_of_tests: Vec<usize>,
    /// The combination in words.
    pub words: String,
    /// The run that would separate these errors, in words; null if no ball-bar test would help.
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
    /// Letter of the axis.
    pub rotary_axis: String,
    /// Direction of the bar.
    pub bar_direction: BarDirectionDoc,
    /// Number of readings; 0 if eccentricities were posted.
    pub readings: usize,
    /// Fitted offset; null if no offset was fitted.
    pub offset_um: Option<f64>,
    /// Root of the mean square of the residuals.
    pub residual_rms_um: f64,
}

/// Something that a metrologist should check.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct RunWarningDoc {
    /// A stable word for the kind of warning.
    #[schema(example = "single-sweep")]
    pub kind: String,
    /// Index of the test, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test: Option<usize>,
    /// The warning in words.
    pub detail: String,
}

/// The results that only a ball-bar run has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BallBarAnswer {
    /// Offset of the spindle ball.
    pub setup_error_um: SetupErrorAnswer,
    /// Eccentricities before and after compensation.
    pub eccentricities_um: EccentricitiesDoc,
    /// Results of each test.
    pub tests: Vec<TestAnswer>,
    /// Readings that were left out because they are too far from all others; the first thousand.
    pub outliers: Vec<OutlierDoc>,
}

/// The result of a calibration run. It never changes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Calibration)]
pub struct CalibrationDocument {
    /// Id of the run.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// Id of the machine.
    pub machine_id: String,
    /// Revision of the machine when it was measured.
    pub machine_revision: i64,
    /// How it was measured.
    pub kind: CalibrationKind,
    /// Time of the measurement.
    #[schema(example = "2025-03-14T09:26:53.000Z")]
    pub measured_at: String,
    /// Time at which the run was stored.
    #[schema(example = "2025-03-14T09:41:07.123Z")]
    pub created_at: String,
    /// Instrument that measured.
    pub instrument: Option<String>,
    /// Serial number of the instrument.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument_serial_number: Option<String>,
    /// The instrument's calibration certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument_certificate: Option<String>,
    /// Person who measured.
    pub operator: Option<String>,
    /// Temperature of the machine.
    pub temperature_c: Option<f64>,
    /// The operator's note.
    pub note: Option<String>,
    /// SHA-256 of the stored run.
    pub run_sha256: String,
    /// Build of the service that evaluated the run.
    pub software_version: String,
    /// Location errors by axis, cascaded as in the profile: `apply` writes these values there.
    #[schema(example = json!({"A": {"e_y_um": {"value": -21.0, "standard_uncertainty": 0.1}}}))]
    #[schema(value_type = BTreeMap<String, BTreeMap<String, Estimate>>)]
    pub errors: BTreeMap<String, Estimates>,
    /// The same errors against the machine's frame, with the symbols of ISO 230-7.
    #[schema(example = json!({"E_Y0A_um": {"value": -21.0, "standard_uncertainty": 0.1}}))]
    #[schema(value_type = BTreeMap<String, Estimate>)]
    pub iso_230: Estimates,
    /// Components that change no line of this machine beyond the errors above; they stay zero.
    pub redundant: Vec<String>,
    /// Errors that the run does not determine: cascaded, against the machine's frame, or of the set-up. The
    /// value of such an error contains all errors that it cannot be separated from.
    pub unidentifiable: Vec<String>,
    /// Combinations of errors that the run cannot separate.
    pub blind: Vec<BlindDoc>,
    /// How many of `unknowns` the readings determine; offsets are not counted.
    pub rank: usize,
    /// Number of unknowns: the location errors, and the two set-up errors if they were not given.
    pub unknowns: usize,
    /// Largest singular value divided by the smallest, with columns of unit length; null if spheres were
    /// probed.
    pub condition_number: Option<f64>,
    /// Number of observations minus the number of fitted values. For spheres without angles: of the planes
    /// and circles, each.
    pub degrees_of_freedom: usize,
    /// Root of the mean square of the residuals.
    pub residual_rms_um: f64,
    /// Covariance of the identified errors; null if no degree of freedom is left to estimate it.
    pub covariance: Option<CovarianceDoc>,
    /// Results that only a ball-bar run has.
    #[serde(flatten)]
    pub ball_bar: Option<BallBarAnswer>,
    /// The axes found, if spheres were probed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<SphereAxisAnswer>>,
    /// Points that a metrologist should check.
    pub warnings: Vec<RunWarningDoc>,
}

/// The name of a component.
#[must_use]
pub(super) fn component_name(component: usize) -> &'static str {
    COMPONENT_NAMES.get(component).copied().unwrap_or_default()
}

/// The ISO 230-7 symbol of an absolute error, with its unit: `E_Y0A_um`.
pub(super) fn iso_name(machine: &Machine, error: &AbsoluteError) -> String {
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

/// The name of any unknown.
#[must_use]
pub(super) fn unknown_name(machine: &Machine, unknown: Unknown) -> String {
    match unknown {
        Unknown::Error(parameter) => parameter_name(machine, parameter),
        Unknown::SetupError(0) => "e_xs_um".to_owned(),
        Unknown::SetupError(_) => "e_ys_um".to_owned(),
    }
}

/// Most outliers in one document: a page of a list holds up to two hundred documents.
const MOST_OUTLIERS: usize = 1000;

/// The part of a document that does not come from the evaluation.
#[derive(Debug, Clone)]
pub struct CalibrationHead<'a> {
    /// A new id.
    pub id: String,
    /// Id of the machine.
    pub machine_id: &'a str,
    /// Revision of the machine.
    pub machine_revision: i64,
    /// Time of the measurement, normalised.
    pub measured_at: String,
    /// The current time.
    pub created_at: String,
    /// SHA-256 of the stored run.
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

    /// A document without results.
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
            instrument_serial_number: request.instrument_serial_number.clone(),
            instrument_certificate: request.instrument_certificate.clone(),
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
    /// The covariance of these unknowns, converted from the core's units.
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

/// All unknowns that are part of a combination that the run cannot see.
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
            // In the order of the readings; there may be very many.
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
