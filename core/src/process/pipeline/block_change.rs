//! What the steps did to one motion of a program, and the errors it has before and after.

use crate::motion::MotionKind;

/// Errors of one motion \[mm\], by source.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorShares {
    /// Largest deviation of the contact from its line between the ends.
    pub interpolation_mm: f64,
    /// Distance of the contact (the tip where none is known) at the end from where it would be on the nominal machine.
    pub location_errors_mm: f64,
    /// Distance of the worn cutter's contact from the nominal one's along the normal; 0 where no contact is known.
    pub wear_mm: f64,
    /// What the decimals of the written words leave at the end, from reading them back.
    pub rounding_mm: f64,
    /// Largest distance of the tip from its path through the drives.
    pub servo_mm: f64,
}

impl ErrorShares {
    /// All of them added, as if they all pointed one way: never less than what they leave together.
    #[must_use]
    pub fn sum_mm(&self) -> f64 {
        self.interpolation_mm + self.location_errors_mm + self.wear_mm + self.rounding_mm + self.servo_mm
    }

    /// In the order of the members.
    #[must_use]
    pub fn list(&self) -> [f64; 5] {
        [self.interpolation_mm, self.location_errors_mm, self.wear_mm, self.rounding_mm, self.servo_mm]
    }
}

/// Errors of one motion as programmed and as written. Servo lag is that of the written program in both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlockError {
    /// As programmed.
    pub before: ErrorShares,
    /// As written.
    pub after: ErrorShares,
    /// Angle between the tool axis at the end and what was meant, as programmed \[rad\].
    pub axis_before_rad: f64,
    /// The same as written \[rad\].
    pub axis_after_rad: f64,
}

/// What became of one motion of the upload. Lengths are of the tool tip in W; ends are moved by location errors and
/// wear, the course between them by the cutter-contact step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockChange {
    /// 1-based line of the upload.
    pub line: u64,
    /// What kind of motion it is.
    pub kind: MotionKind,
    /// How far its end was moved because the machine is not the nominal one \[mm\].
    pub location_errors_mm: f64,
    /// By how much the tool axis at its end was turned for the same \[rad\].
    pub axis_rad: f64,
    /// How far its end was moved for the worn cutter \[mm\].
    pub wear_mm: f64,
    /// Largest correction of its course \[mm\].
    pub cc_mm: f64,
    /// How many blocks it became; 1 where it was not divided.
    pub blocks_out: u32,
    /// What is wrong with it before and after.
    pub error: BlockError,
}

impl BlockChange {
    /// A motion that nothing happened to.
    #[must_use]
    pub fn none(line: u64, kind: MotionKind) -> Self {
        Self {
            line,
            kind,
            location_errors_mm: 0.0,
            axis_rad: 0.0,
            wear_mm: 0.0,
            cc_mm: 0.0,
            blocks_out: 1,
            error: BlockError::default(),
        }
    }

    /// The same after a later step, which looks at the course between the ends.
    pub(super) fn and(mut self, later: &Self) -> Self {
        self.cc_mm = later.cc_mm;
        self.blocks_out = later.blocks_out;
        self.error.before.interpolation_mm = later.error.before.interpolation_mm;
        self.error.after.interpolation_mm = later.error.after.interpolation_mm;
        self
    }

    /// Whether any step did anything to it.
    #[must_use]
    pub fn is_change(&self) -> bool {
        self.blocks_out > 1
            || [self.location_errors_mm, self.axis_rad, self.wear_mm, self.cc_mm]
                .iter()
                .any(|share| *share > 0.0)
    }

    /// All shares of its change \[mm\].
    #[must_use]
    pub fn sum_mm(&self) -> f64 {
        self.location_errors_mm + self.wear_mm + self.cc_mm
    }
}
