//! Runs over time: the trend of an error, the changes between two runs, and the changes that applying a run
//! would make.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::calibration_answer::component_name;
use super::{CalibrationDocument, Estimate, Estimates, Fault, LocationErrorDoc, MachineProfile};
use crate::calibration::{COMPONENT_NAMES, ErrorParameter, absolute_errors, iso_230_symbol, told_per_unit};
use crate::description::ToSchema;
use crate::machine::Machine;

/// One run of a trend.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct TrendPoint {
    /// Id of the run.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub calibration_id: String,
    /// Time of the measurement.
    #[schema(example = "2025-03-14T09:26:53.000Z")]
    pub measured_at: String,
    /// Revision of the machine at that time.
    pub machine_revision: i64,
    /// Value of the error, in the unit of the trend.
    pub value: f64,
    /// Standard uncertainty; null if the run does not give it.
    pub standard_uncertainty: Option<f64>,
    /// Whether the run determines the error.
    pub identifiable: bool,
}

/// The trend of one error, oldest run first.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Trend {
    /// Id of the machine.
    pub machine_id: String,
    /// Letter of the axis.
    #[schema(example = "A")]
    pub axis: String,
    /// Name of the error.
    #[schema(example = "e_y")]
    pub error: String,
    /// Unit of the values and uncertainties: `um` or `urad`.
    #[schema(example = "um")]
    pub unit: String,
    /// The runs of the trend.
    pub points: Vec<TrendPoint>,
}

/// How an error differs between two runs, in the unit of its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct Difference {
    /// This run's value minus the other's.
    pub difference: f64,
    /// Standard uncertainty of the difference; the runs count as independent. Null if one of the runs has
    /// none.
    pub standard_uncertainty: Option<f64>,
    /// Whether the difference is more than twice its standard uncertainty; about one in twenty is so by
    /// chance. Null without a standard uncertainty. Also null if one of the runs does not determine the
    /// error: an error that cannot be separated from it may have changed instead.
    pub significant: Option<bool>,
}

/// How two runs differ.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CalibrationDifference {
    /// Id of the machine.
    pub machine_id: String,
    /// Id of this run.
    pub id: String,
    /// Id of the run that is subtracted.
    pub from: String,
    /// Cascaded errors by axis, where both runs have the axis.
    pub errors: BTreeMap<String, BTreeMap<String, Difference>>,
    /// Errors against the machine's frame that both runs have.
    pub iso_230: BTreeMap<String, Difference>,
}

/// A difference above this many standard uncertainties is significant: the usual coverage factor.
const SIGNIFICANT: f64 = 2.0;

impl Difference {
    fn of(here: &Estimate, there: &Estimate, identifiable: bool) -> Self {
        let difference = here.value - there.value;
        let standard_uncertainty =
            here.standard_uncertainty.zip(there.standard_uncertainty).map(|(here, there)| here.hypot(there));
        let significant =
            standard_uncertainty.filter(|_| identifiable).map(|sigma| difference.abs() > SIGNIFICANT * sigma);
        Self { difference, standard_uncertainty, significant }
    }
}

impl CalibrationDifference {
    /// `here` minus `there`.
    #[must_use]
    pub fn of(here: &CalibrationDocument, there: &CalibrationDocument) -> Self {
        let open = |name: &String| here.unidentifiable.contains(name) || there.unidentifiable.contains(name);
        // `prefix` comes before the name where a document lists the errors that it does not determine.
        let differences =
            |prefix: &str, here: &Estimates, there: &Estimates| -> BTreeMap<String, Difference> {
                here.iter()
                    .filter_map(|(name, here)| {
                        let identifiable = !open(&format!("{prefix}{name}"));
                        Some((name.clone(), Difference::of(here, there.get(name)?, identifiable)))
                    })
                    .collect()
            };
        Self {
            machine_id: here.machine_id.clone(),
            id: here.id.clone(),
            from: there.id.clone(),
            errors: here
                .errors
                .iter()
                .filter_map(|(axis, here)| {
                    let there = there.errors.get(axis)?;
                    Some((axis.clone(), differences(&format!("{axis}."), here, there)))
                })
                .collect(),
            iso_230: differences("", &here.iso_230, &there.iso_230),
        }
    }
}

/// Confirms a large change.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ApplyRequest {
    /// Apply the run even if a value changes by more than 0.2 mm or 1000 µrad, if the run leaves errors
    /// undetermined, or if the squareness that it was evaluated with has changed since.
    pub confirm: bool,
}

/// Largest change of a translation that needs no confirmation (µm).
const CONFIRM_ABOVE_UM: f64 = 200.0;
/// Largest change of a rotation that needs no confirmation (µrad).
const CONFIRM_ABOVE_URAD: f64 = 1000.0;

/// A profile with the errors of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedProfile {
    /// The profile.
    pub profile: MachineProfile,
    /// The changes that need a confirmation.
    pub to_confirm: Vec<Fault>,
}

/// Why the errors of a run have no meaning on the current profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherAxes {
    /// The nominal rotary axes are not the measured ones.
    Nominal,
    /// The run measured an axis but not the axis that carries it, and the location error of the carrier has
    /// changed since.
    Carrier,
}

impl CalibrationDocument {
    /// `current` with the location errors of this run. An axis that the run measured gets all six components;
    /// components that were not identified are zero. The other axes keep their errors.
    ///
    /// # Errors
    /// The nominal axes of `measured`, the profile at the time of the run, differ from those of `current`. Or
    /// an axis was measured without the axis that carries it, and the carrier now has another location error:
    /// cascaded values count from it.
    pub fn apply_to(
        &self,
        current: &MachineProfile,
        measured: &MachineProfile,
    ) -> Result<AppliedProfile, OtherAxes> {
        let nominal = |profile: &MachineProfile| -> Vec<_> {
            let axes = &profile.kinematics.rotary_axes;
            axes.iter()
                .map(|axis| (axis.name.clone(), axis.side, axis.direction, axis.point_mm, axis.reversed))
                .collect()
        };
        if nominal(current) != nominal(measured) {
            return Err(OtherAxes::Nominal);
        }
        if let [inner, outer] = current.kinematics.rotary_axes.as_slice()
            && inner.side == outer.side
            && self.errors.contains_key(&outer.name)
            && !self.errors.contains_key(&inner.name)
            && measured.kinematics.rotary_axes.first().map(|then| then.location_error)
                != Some(inner.location_error)
        {
            return Err(OtherAxes::Carrier);
        }
        let mut profile = current.clone();
        let mut to_confirm = Vec::new();
        for (index, axis) in profile.kinematics.rotary_axes.iter_mut().enumerate() {
            let Some(errors) = self.errors.get(&axis.name) else { continue };
            let before = components(&axis.location_error);
            let after: [f64; 6] = std::array::from_fn(|component| {
                errors.get(component_name(component)).map_or(0.0, |estimate| estimate.value)
            });
            for component in 0..6 {
                let change = after[component] - before[component];
                let (limit, unit) =
                    if component < 3 { (CONFIRM_ABOVE_UM, "um") } else { (CONFIRM_ABOVE_URAD, "urad") };
                if change.abs() > limit {
                    let name = component_name(component);
                    to_confirm.push(Fault::new(
                        format!("/kinematics/rotary_axes/{index}/location_error/{name}"),
                        format!(
                            "changes from {} to {} {unit}, by more than {limit} {unit}",
                            before[component], after[component]
                        ),
                    ));
                }
            }
            let [e_x_um, e_y_um, e_z_um, e_a_urad, e_b_urad, e_c_urad] = after;
            axis.location_error = LocationErrorDoc { e_x_um, e_y_um, e_z_um, e_a_urad, e_b_urad, e_c_urad };
        }
        let squareness_counts = self.ball_bar.is_some();
        if squareness_counts && current.kinematics.squareness_urad != measured.kinematics.squareness_urad {
            to_confirm.push(Fault::new(
                "/kinematics/squareness_urad",
                "has changed since the run was evaluated: the run's errors are valid for the squareness of that time",
            ));
        }
        for blind in &self.blind {
            // A combination hidden only by the set-up error is the usual case: the control needs only the
            // difference.
            if !blind.parts_um_urad.keys().any(|name| name.starts_with("e_xs") || name.starts_with("e_ys")) {
                to_confirm.push(Fault::new("", format!("the run does not determine this: {}", blind.words)));
            }
        }
        Ok(AppliedProfile { profile, to_confirm })
    }
}

fn components(error: &LocationErrorDoc) -> [f64; 6] {
    [error.e_x_um, error.e_y_um, error.e_z_um, error.e_a_urad, error.e_b_urad, error.e_c_urad]
}

/// Unit of an error by its name, cascaded or against the machine's frame; `None` if there is no such error.
#[must_use]
pub fn trend_unit(axis: &str, error: &str) -> Option<&'static str> {
    let of_letter = |letter: &str| match letter {
        "x" | "y" | "z" => Some("um"),
        "a" | "b" | "c" => Some("urad"),
        _ => None,
    };
    if let Some(letter) = error.strip_prefix("e_") {
        return of_letter(letter);
    }
    let motion = error.strip_prefix("E_")?.strip_suffix(axis)?.strip_suffix('0')?;
    motion
        .chars()
        .all(|letter| letter.is_ascii_uppercase())
        .then(|| of_letter(&motion.to_lowercase()))
        .flatten()
}

/// The value of an error in a machine's profile, in the unit of its trend; `None` if the machine has no such error.
#[must_use]
pub fn error_in_profile(machine: &Machine, axis: &str, error: &str) -> Option<f64> {
    let mut axes = machine.rotary_axes().iter().enumerate();
    let (index, found) = axes.find(|(_, found)| found.letter.as_char().to_string() == axis)?;
    let unit = trend_unit(axis, error)?;
    let is_wanted =
        |name: &str| name.strip_suffix(unit).and_then(|name| name.strip_suffix('_')) == Some(error);
    if let Some(component) = COMPONENT_NAMES.iter().position(|name| is_wanted(name)) {
        let errors = machine.rotary_axes().each_ref().map(|axis| axis.location_error);
        let value = ErrorParameter { axis: index, component }.value(&errors);
        return Some(value * told_per_unit(component));
    }
    let absolute = absolute_errors(machine);
    let of_axis = absolute.iter().filter(|absolute| absolute.axis == index);
    let mut wanted = of_axis.filter(|absolute| iso_230_symbol(found.letter, absolute.component) == error);
    wanted.next().map(|absolute| absolute.value * told_per_unit(absolute.component))
}

/// The runs of a trend as a table.
///
/// # Errors
/// The table cannot be written; this does not happen in memory.
pub fn trend_table(trend: &Trend) -> Result<Vec<u8>, csv::Error> {
    let Trend { error, unit, points, .. } = trend;
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record([
        "calibration_id",
        "measured_at",
        "machine_revision",
        &format!("{error}_{unit}"),
        &format!("standard_uncertainty_{unit}"),
        "identifiable",
    ])?;
    for point in points {
        table.write_record([
            &point.calibration_id,
            &point.measured_at,
            &point.machine_revision.to_string(),
            &point.value.to_string(),
            &point.standard_uncertainty.map(|sigma| sigma.to_string()).unwrap_or_default(),
            &point.identifiable.to_string(),
        ])?;
    }
    table.into_inner().map_err(|fault| fault.into_error().into())
}
