//! How much of the error of a part comes from what, before and after, and what nobody looked at.

use super::changes::{ChangeTotals, keep_worst};
use crate::process::pipeline::{BlockChange, BlockError};

/// One source over a whole program: its largest share, and where.
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
    pub error: BlockError,
}

/// What was not looked at, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NotModelledKind {
    /// Growth and bending by heat.
    Thermal,
    /// Bending of tool, part and machine under the cutting force.
    Deflection,
    /// Runout and seat of tool and holder.
    Holder,
    /// Errors of the linear axes along their travel, squareness apart, and of the rotary axes along their turn.
    ErrorMotions,
    /// The scallop between neighbouring passes, which a worn cutter makes higher.
    Scallop,
    /// Chords of the program against the surface it was made from.
    ProgramChords,
    /// Ends were not posted anew: the program is taken as made for the machine it runs on.
    LocationErrors,
    /// No worn cutter was named.
    Wear,
    /// The course between the ends was not looked at.
    Interpolation,
    /// The machine has no drives, or none were named.
    Drives,
    /// The drives were not run through: the program is too long, or they cannot follow it.
    ServoRefused,
    /// With TCP: that the control knows the calibrated lines of the axes is assumed.
    ControlCalibration,
    /// Contacts are assumed from the feed direction.
    ContactAssumed,
    /// Motions whose contact is not known: their tip stands for it.
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

    /// What it means, in a sentence.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Thermal => "growth and bending of machine, tool and part by heat",
            Self::Deflection => "bending of tool, part and machine under the cutting force",
            Self::Holder => "runout of the tool and the seat of its holder",
            Self::ErrorMotions => {
                "errors of the axes along their travel and turn; only where rotary axes lie and how square linear ones are is known"
            }
            Self::Scallop => "the scallop between neighbouring passes, which a worn cutter makes higher",
            Self::ProgramChords => "how far the program's own chords are from the surface it was made from",
            Self::LocationErrors => {
                "not asked for: the program is taken as made for the machine it runs on, with its location errors or without as the set-up says"
            }
            Self::Wear => "not asked for: the cutter is taken as the program has it",
            Self::Interpolation => "not asked for: the course between the ends of blocks is not looked at",
            Self::Drives => "no drives are known: servo lag is not looked at",
            Self::ServoRefused => {
                "the drives were not run through: the program is too long for it, or they cannot follow it"
            }
            Self::ControlCalibration => {
                "under tool-centre-point control the control itself is taken to know the calibrated axes; X Y Z are places of the workpiece there"
            }
            Self::ContactAssumed => "contacts are assumed from the feed direction",
            Self::ContactUnknown => "motions whose contact is not known: their tip stands for it",
            Self::Arcs => "arcs: their course between the ends is not looked at",
            Self::Rapids => "rapids: their course between the ends is not looked at",
            Self::NotFollowed => "motions that cannot be followed are left as they are",
            Self::ServoLeftOut => "motions left out of the simulation of the drives",
        }
    }
}

/// Something that was not looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotModelled {
    /// What.
    pub kind: NotModelledKind,
    /// How many motions, where it is about motions.
    pub count: Option<u64>,
    /// The first line of the upload, where it is about motions.
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
    /// Largest angle between the tool axis and what was meant, as programmed \[rad\].
    pub axis_before_rad: f64,
    /// The same as written \[rad\].
    pub axis_after_rad: f64,
    /// The blocks with the largest sum as written, the largest first.
    pub worst: Vec<BlockBudget>,
    /// What was not looked at.
    pub not_modelled: Vec<NotModelled>,
}

/// Sums up the errors of motion after motion.
#[derive(Debug, Default)]
pub(in crate::process) struct Tally {
    budget: ErrorBudget,
    worst: Vec<BlockChange>,
}

impl Tally {
    pub(in crate::process) fn take(&mut self, change: &BlockChange) {
        let BlockChange { line, error, .. } = *change;
        let budget = &mut self.budget;
        let lines = [
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
