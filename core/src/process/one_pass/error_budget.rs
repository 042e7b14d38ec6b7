//! The sources of a part's error, before and after, and the sources that were not modelled.

use super::changes::{ChangeTotals, keep_worst};
use crate::process::pipeline::{ErrorShares, MotionChange, MotionError};

/// One source over a whole program: its largest shares, with their lines.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BudgetLine {
    /// Largest share as programmed \[mm\].
    pub before_mm: f64,
    /// Its line of the upload.
    pub before_line: Option<u64>,
    /// Largest share as written \[mm\].
    pub after_mm: f64,
    /// Its line of the upload.
    pub after_line: Option<u64>,
}

impl BudgetLine {
    fn take(&mut self, line: u64, before_mm: f64, after_mm: f64) {
        if before_mm > self.before_mm {
            (self.before_mm, self.before_line) = (before_mm, Some(line));
        }
        if after_mm > self.after_mm {
            (self.after_mm, self.after_line) = (after_mm, Some(line));
        }
    }
}

/// One of the worst blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockBudget {
    /// 1-based line of the upload.
    pub line: u64,
    /// Its errors.
    pub error: MotionError,
}

/// A source that was not modelled, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NotModelledKind {
    /// Growth and bending by heat.
    Thermal,
    /// Bending of tool, part and machine under the cutting force.
    Deflection,
    /// Runout and seat of tool and holder.
    Holder,
    /// Errors of the linear axes along their travel, except squareness, and of the rotary axes along their
    /// turn.
    ErrorMotions,
    /// The scallop between neighbouring passes, which a worn cutter makes higher.
    Scallop,
    /// Chords of the program against the surface it was made from.
    ProgramChords,
    /// Ends were not posted again: the program is assumed to be made for the machine that runs it.
    LocationErrors,
    /// No worn cutter was named.
    Wear,
    /// The course between the ends was not checked.
    Interpolation,
    /// The machine has no drives, or none were given.
    Drives,
    /// The drives were not simulated: the program is too long, or they cannot follow it.
    ServoRefused,
    /// With TCP: the control is assumed to know the calibrated lines of the axes.
    ControlCalibration,
    /// Contacts are assumed from the feed direction.
    ContactAssumed,
    /// Motions of unknown contact: their tip is used as the contact.
    ContactUnknown,
    /// Arcs.
    Arcs,
    /// Rapids: they cut nothing.
    Rapids,
    /// Motions that cannot be followed.
    NotFollowed,
    /// Motions left out of the simulation of the drives.
    ServoLeftOut,
}

impl NotModelledKind {
    /// The name in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Thermal => "thermal",
            Self::Deflection => "deflection",
            Self::Holder => "holder",
            Self::ErrorMotions => "error_motions",
            Self::Scallop => "scallop",
            Self::ProgramChords => "program_chords",
            Self::LocationErrors => "location_errors",
            Self::Wear => "wear",
            Self::Interpolation => "interpolation",
            Self::Drives => "drives",
            Self::ServoRefused => "servo_refused",
            Self::ControlCalibration => "control_calibration",
            Self::ContactAssumed => "contact_assumed",
            Self::ContactUnknown => "contact_unknown",
            Self::Arcs => "arcs",
            Self::Rapids => "rapids",
            Self::NotFollowed => "not_followed",
            Self::ServoLeftOut => "servo_left_out",
        }
    }

    /// The source in words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Thermal => "thermal expansion and bending of machine, tool and part",
            Self::Deflection => "bending of tool, part and machine under the cutting force",
            Self::Holder => "runout of the tool and the seat of its holder",
            Self::ErrorMotions => {
                "errors of the axes along their travel and turn; only the location of the rotary axes and the squareness of the linear axes are known"
            }
            Self::Scallop => "the scallop between neighbouring passes, which a worn cutter makes higher",
            Self::ProgramChords => {
                "the distance of the program's own chords from the surface it was made from"
            }
            Self::LocationErrors => {
                "not asked for: the program is assumed to be made for the machine that runs it, with or without location errors as the set-up states"
            }
            Self::Wear => "not asked for: the cutter is assumed to be the nominal one",
            Self::Interpolation => "not asked for: the path between the ends of blocks is not checked",
            Self::Drives => "no drives are known, so servo lag is not included",
            Self::ServoRefused => {
                "the drives were not simulated: the program is too long, or the drives cannot follow it"
            }
            Self::ControlCalibration => {
                "under tool-centre-point control the control itself is assumed to know the calibrated axes; X Y Z are positions on the workpiece"
            }
            Self::ContactAssumed => "contacts are assumed from the feed direction",
            Self::ContactUnknown => "motions whose contact is not known: their tip is used as the contact",
            Self::Arcs => "arcs: their path between the ends is not checked",
            Self::Rapids => "rapids: their path between the ends is not checked",
            Self::NotFollowed => "motions that cannot be followed are left unchanged",
            Self::ServoLeftOut => "motions left out of the simulation of the drives",
        }
    }
}

/// A source that was not modelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotModelled {
    /// The source.
    pub kind: NotModelledKind,
    /// Number of motions, if it concerns motions.
    pub count: Option<u64>,
    /// The first line of the upload, if it concerns motions.
    pub first_line: Option<u64>,
}

/// The error budget of a whole program.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ErrorBudget {
    /// Deviation between the ends.
    pub interpolation: BudgetLine,
    /// Location errors.
    pub location_errors: BudgetLine,
    /// Wear.
    pub wear: BudgetLine,
    /// Rounding of the written words.
    pub rounding: BudgetLine,
    /// Servo lag of the written program.
    pub servo: BudgetLine,
    /// Largest sum of one block, not the sum of the largest.
    pub sum: BudgetLine,
    /// Largest angle between the intended tool axis and the programmed one \[rad\].
    pub axis_before_rad: f64,
    /// The same for the written tool axis \[rad\].
    pub axis_after_rad: f64,
    /// The blocks with the largest sum as written, the largest first.
    pub worst: Vec<BlockBudget>,
    /// Sources that were not modelled.
    pub not_modelled: Vec<NotModelled>,
}

/// Sums up the errors of the motions.
#[derive(Debug, Default)]
pub(in crate::process) struct Tally {
    budget: ErrorBudget,
    worst: Vec<MotionChange>,
}

impl Tally {
    pub(in crate::process) fn take(&mut self, change: &MotionChange) {
        let MotionChange { line, error, .. } = *change;
        let budget = &mut self.budget;
        let lines: [_; ErrorShares::COUNT] = [
            &mut budget.interpolation,
            &mut budget.location_errors,
            &mut budget.wear,
            &mut budget.rounding,
            &mut budget.servo,
        ];
        for ((kept, before), after) in lines.into_iter().zip(error.before.list()).zip(error.after.list()) {
            kept.take(line, before, after);
        }
        budget.sum.take(line, error.before.sum_mm(), error.after.sum_mm());
        budget.axis_before_rad = budget.axis_before_rad.max(error.axis_before_rad);
        budget.axis_after_rad = budget.axis_after_rad.max(error.axis_after_rad);
        if error.after.sum_mm() > 0.0 {
            keep_worst(&mut self.worst, change, |kept| kept.error.after.sum_mm());
        }
    }

    pub(in crate::process) fn into_budget(self, mut not_modelled: Vec<NotModelled>) -> ErrorBudget {
        not_modelled.sort_by_key(|entry| entry.kind);
        let worst = self.worst.iter().take(ChangeTotals::WORST);
        ErrorBudget {
            worst: worst.map(|change| BlockBudget { line: change.line, error: change.error }).collect(),
            not_modelled,
            ..self.budget
        }
    }
}
