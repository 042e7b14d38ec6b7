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
    /// The number of shares.
    pub const COUNT: usize = 5;

    /// The sum of all shares, as if all pointed the same way: never less than their combined error.
    #[must_use]
    pub fn sum_mm(&self) -> f64 {
        self.list().iter().sum()
    }

    /// The shares of two steps. Where both have a share, as if both pointed the same way.
    fn and(self, later: Self) -> Self {
        let Self { interpolation_mm, location_errors_mm, wear_mm, rounding_mm, servo_mm } = later;
        Self {
            interpolation_mm: self.interpolation_mm + interpolation_mm,
            location_errors_mm: self.location_errors_mm + location_errors_mm,
            wear_mm: self.wear_mm + wear_mm,
            rounding_mm: self.rounding_mm + rounding_mm,
            servo_mm: self.servo_mm + servo_mm,
        }
    }

    /// The shares from this order of the members.
    pub(super) fn of_list(list: [f64; Self::COUNT]) -> Self {
        let [interpolation_mm, location_errors_mm, wear_mm, rounding_mm, servo_mm] = list;
        Self { interpolation_mm, location_errors_mm, wear_mm, rounding_mm, servo_mm }
    }

    /// The shares in the order of the members.
    #[must_use]
    pub fn list(&self) -> [f64; Self::COUNT] {
        let Self { interpolation_mm, location_errors_mm, wear_mm, rounding_mm, servo_mm } = *self;
        [interpolation_mm, location_errors_mm, wear_mm, rounding_mm, servo_mm]
    }
}

/// Errors of one motion as programmed and as written. Both have the servo lag of the written program.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionError {
    /// As programmed.
    pub before: ErrorShares,
    /// As written.
    pub after: ErrorShares,
    /// Angle between the intended tool axis at the end and the programmed one \[rad\].
    pub axis_before_rad: f64,
    /// The same for the written tool axis \[rad\].
    pub axis_after_rad: f64,
}

impl MotionError {
    /// The errors of two steps.
    fn and(self, later: Self) -> Self {
        let Self { before, after, axis_before_rad, axis_after_rad } = later;
        Self {
            before: self.before.and(before),
            after: self.after.and(after),
            axis_before_rad: self.axis_before_rad + axis_before_rad,
            axis_after_rad: self.axis_after_rad + axis_after_rad,
        }
    }
}

/// The changes of one motion of the upload. Lengths are of the tool tip in W. Location errors and wear move ends;
/// the cutter-contact step moves the course between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionChange {
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
    pub error: MotionError,
}

impl MotionChange {
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
            error: MotionError::default(),
        }
    }

    /// The changes of this motion together with those of a later step. A step leaves the members of other steps at 0.
    pub(super) fn and(self, later: &Self) -> Self {
        let &Self { line: _, kind: _, location_errors_mm, axis_rad, wear_mm, cc_mm, blocks_out, error } =
            later;
        Self {
            line: self.line,
            kind: self.kind,
            location_errors_mm: self.location_errors_mm + location_errors_mm,
            axis_rad: self.axis_rad + axis_rad,
            wear_mm: self.wear_mm + wear_mm,
            cc_mm: self.cc_mm + cc_mm,
            blocks_out: self.blocks_out.saturating_mul(blocks_out),
            error: self.error.and(error),
        }
    }

    /// Whether a step changed the motion.
    #[must_use]
    pub fn is_change(&self) -> bool {
        let Self { line: _, kind: _, location_errors_mm, axis_rad, wear_mm, cc_mm, blocks_out, error: _ } =
            *self;
        blocks_out > 1 || [location_errors_mm, axis_rad, wear_mm, cc_mm].iter().any(|share| *share > 0.0)
    }

    /// The sum of all shares of its change \[mm\].
    #[must_use]
    pub fn sum_mm(&self) -> f64 {
        let Self {
            line: _,
            kind: _,
            location_errors_mm,
            axis_rad: _,
            wear_mm,
            cc_mm,
            blocks_out: _,
            error: _,
        } = *self;
        location_errors_mm + wear_mm + cc_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_step_hides_what_another_did() {
        let mut moved = MotionChange::none(3, MotionKind::Linear);
        (moved.location_errors_mm, moved.axis_rad, moved.wear_mm) = (0.5, 0.25, 0.125);
        moved.error.before =
            ErrorShares { location_errors_mm: 0.5, wear_mm: 0.125, ..ErrorShares::default() };
        moved.error.after = ErrorShares { wear_mm: 0.125, rounding_mm: 0.0625, ..ErrorShares::default() };
        (moved.error.axis_before_rad, moved.error.axis_after_rad) = (0.25, 0.03125);
        let mut divided = MotionChange::none(3, MotionKind::Linear);
        (divided.cc_mm, divided.blocks_out) = (2.0, 4);
        divided.error.before.interpolation_mm = 2.0;
        divided.error.after.interpolation_mm = 0.5;
        let expected = MotionChange { cc_mm: 2.0, blocks_out: 4, ..moved };
        let expected = MotionChange {
            error: MotionError {
                before: ErrorShares { interpolation_mm: 2.0, ..moved.error.before },
                after: ErrorShares { interpolation_mm: 0.5, ..moved.error.after },
                ..moved.error
            },
            ..expected
        };
        assert_eq!(moved.and(&divided), expected);
        assert_eq!(divided.and(&moved), expected, "the order of two steps does not matter");
    }
}
