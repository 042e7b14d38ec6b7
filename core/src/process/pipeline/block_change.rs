//! The changes that the steps made to one motion of a program, and its errors before and after.

use crate::motion::MotionKind;

/// Errors of one motion \[mm\], by source.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorShares {
    /// Largest deviation of the contact from its line between the ends.
    pub interpolation_mm: f64,
    /// Distance of the contact (the tip if no contact is known) at the end from its position on the nominal
    /// machine.
    pub location_errors_mm: f64,
    /// Distance of the worn cutter's contact from the nominal one's along the normal; 0 if no contact is known.
    pub wear_mm: f64,
    /// Rounding error at the end from the decimals of the written words, found by reading them back.
    pub rounding_mm: f64,
    /// Largest distance of the tip from its path through the drives.
    pub servo_mm: f64,
}

impl ErrorShares {
    /// The sum of all shares, as if all pointed the same way: never less than their combined error.
    #[must_use]
    pub fn sum_mm(&self) -> f64 {
        self.interpolation_mm + self.location_errors_mm + self.wear_mm + self.rounding_mm + self.servo_mm
    }

    /// The shares in the order of the members.
    #[must_use]
    pub fn list(&self) -> [f64; 5] {
        [self.interpolation_mm, self.location_errors_mm, self.wear_mm, self.rounding_mm, self.servo_mm]
    }
}

/// Errors of one motion as programmed and as written. Both have the servo lag of the written program.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlockError {
    /// As programmed.
    pub before: ErrorShares,
    /// As written.
    pub after: ErrorShares,
    /// Angle between the intended tool axis at the end and the programmed one \[rad\].
    pub axis_before_rad: f64,
    /// The same for the written tool axis \[rad\].
    pub axis_after_rad: f64,
}

/// The changes of one motion of the upload. Lengths are of the tool tip in W. Location errors and wear move ends;
/// the cutter-contact step moves the course between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockChange {
    /// 1-based line of the upload.
    pub line: u64,
    /// The kind of the motion.
    pub kind: MotionKind,
    /// Distance by which its end moved for the location errors \[mm\].
    pub location_errors_mm: f64,
    /// Angle by which the tool axis at its end turned for the location errors \[rad\].
    pub axis_rad: f64,
    /// Distance by which its end moved for the worn cutter \[mm\].
    pub wear_mm: f64,
    /// Largest correction of its course \[mm\].
    pub cc_mm: f64,
    /// Number of blocks it became; 1 if it was not divided.
    pub blocks_out: u32,
    /// Its errors before and after.
    pub error: BlockError,
}

impl BlockChange {
    /// A motion without changes.
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

    /// The changes together with those of a later step, which works on the course between the ends.
    pub(super) fn and(mut self, later: &Self) -> Self {
        self.cc_mm = later.cc_mm;
        self.blocks_out = later.blocks_out;
        self.error.before.interpolation_mm = later.error.before.interpolation_mm;
        self.error.after.interpolation_mm = later.error.after.interpolation_mm;
        self
    }

    /// Whether a step changed the motion.
    #[must_use]
    pub fn is_change(&self) -> bool {
        self.blocks_out > 1
            || [self.location_errors_mm, self.axis_rad, self.wear_mm, self.cc_mm]
                .iter()
                .any(|share| *share > 0.0)
    }

    /// The sum of all shares of its change \[mm\].
    #[must_use]
    pub fn sum_mm(&self) -> f64 {
        self.location_errors_mm + self.wear_mm + self.cc_mm
    }
}
