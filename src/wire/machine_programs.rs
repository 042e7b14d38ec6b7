//! The parts of a profile about the programs that run on the machine, and about the machine as the shop's
//! property.

use serde::{Deserialize, Serialize};

use super::{CcParameters, Fault, FaultList, MachineProfile};
use crate::description::ToSchema;
use crate::motion::StartModes;
use crate::units::LengthUnit;

/// Unit of the lengths if the program does not state one. If it is absent, the machine's
/// `program_unit` is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ProgramUnit {
    /// Millimetres.
    Mm,
    /// Inches.
    Inch,
}

impl ProgramUnit {
    /// The unit in the core's terms.
    #[must_use]
    pub const fn to_core(self) -> LengthUnit {
        match self {
            Self::Mm => LengthUnit::Millimetre,
            Self::Inch => LengthUnit::Inch,
        }
    }
}

impl From<LengthUnit> for ProgramUnit {
    fn from(core: LengthUnit) -> Self {
        match core {
            LengthUnit::Millimetre => Self::Mm,
            LengthUnit::Inch => Self::Inch,
        }
    }
}

/// Which of two rotary positions the control takes when both tilt the tool in the same way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneRule {
    /// The position in which the named axis is positive.
    PositiveFirst,
    /// The position in which the named axis is negative.
    NegativeFirst,
    /// The position with the shorter way from the present one.
    Shortest,
}

/// Which of the two solutions CYCLE800, PLANE or G53.1 takes on this machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneSolution {
    /// The rule.
    pub rule: PlaneRule,
    /// The rotary axis that the rule looks at; null if the control does not name one.
    #[serde(default)]
    #[schema(pattern = "^[ABC]$", example = "A")]
    pub axis: Option<String>,
}

/// Longest name, serial number and asset id \[characters\].
const MAX_TEXT: usize = 200;
/// Smallest feed that is accepted \[mm/min\].
const MIN_FEED_MM_PER_MIN: f64 = 1e-6;
/// Times for one block that are accepted \[ms\]: from a tenth of the fastest control's time up to a time that
/// stops every machine between blocks.
const BLOCK_TIME_MS: [f64; 2] = [0.01, 1000.0];
/// Longest time between two calibrations that is accepted \[d\]: a hundred years.
const MAX_CALIBRATION_DUE_DAYS: f64 = 36_500.0;

/// How many characters of a wrong letter an error shows.
const SHOWN: usize = 16;

/// Checks a line of text for people: 1 to 200 characters, no control characters. A fault is added to
/// `faults`.
pub(super) fn check_line(pointer: &str, what: &str, text: &str, faults: &mut FaultList) {
    let length = text.chars().count();
    if !(1..=MAX_TEXT).contains(&length) || text.chars().any(char::is_control) {
        faults.push(|| {
            let detail = format!(
                "{what} has 1 to {MAX_TEXT} characters, none of them a control character; this one has {length} characters"
            );
            Fault::new(pointer, detail)
        });
    }
}

impl MachineProfile {
    /// Checks the members about programs and about the machine as property; faults are added to `faults`.
    pub(super) fn check_programs(&self, faults: &mut FaultList) {
        check_line("/name", "a name", &self.name, faults);
        if let Some(serial_number) = &self.serial_number {
            check_line("/serial_number", "a serial number", serial_number, faults);
        }
        if let Some(asset_id) = &self.asset_id {
            check_line("/asset_id", "an asset id", asset_id, faults);
        }
        if let Some(codes) = &self.start_codes
            && let Err(fault) = StartModes::from_codes(codes)
        {
            faults.push(|| {
                let detail = format!(
                    "{fault}; give at most one code of each group, separated by blanks: G1 G17 G90 G94"
                );
                Fault::new("/start_codes", detail)
            });
        }
        if let Some(offsets) = &self.work_offsets_mm {
            offsets.check("/work_offsets_mm", faults);
        }
        if let Some(feed) = self.max_feed_mm_per_min {
            let at = || "/max_feed_mm_per_min".to_owned();
            faults.check_range(at, feed, MIN_FEED_MM_PER_MIN, CcParameters::MAX_FEED_MM_PER_MIN);
        }
        if let Some(time_ms) = self.block_time_ms {
            let [least, most] = BLOCK_TIME_MS;
            faults.check_range(|| "/block_time_ms".to_owned(), time_ms, least, most);
        }
        if let Some(days) = self.calibration_due_days
            && !(days > 0.0 && days <= MAX_CALIBRATION_DUE_DAYS)
        {
            faults.push(|| {
                let detail = format!(
                    "{days} days is wrong: it must be above 0 and at most {MAX_CALIBRATION_DUE_DAYS} days"
                );
                Fault::new("/calibration_due_days", detail)
            });
        }
        if let Some(limits) = &self.calibration_limits {
            let letters = self.kinematics.rotary_axes.iter().map(|axis| axis.name.as_str());
            limits.check("/calibration_limits", &letters, faults);
        }
        if let Some(coordinates) = &self.machine_coordinates {
            let letters: Vec<_> =
                self.kinematics.rotary_axes.iter().map(|axis| axis.name.as_str()).take(2).collect();
            coordinates.check(&letters, faults);
        }
        let axes = || self.kinematics.rotary_axes.iter().map(|axis| axis.name.as_str());
        if let Some(PlaneSolution { axis: Some(axis), .. }) = &self.plane_solution
            && !axes().any(|name| name == axis)
        {
            faults.push(|| {
                let given: String = axis.chars().take(SHOWN).collect();
                let there: Vec<_> = axes().take(2).collect();
                let there = there.join(" and ");
                let detail = format!(
                    "{given:?} is not a rotary axis of this machine; it has {there}. Name one of them, or use null"
                );
                Fault::new("/plane_solution/axis", detail)
            });
        }
    }
}
