//! The predicted reading of a ball bar on a machine with given errors (shared notation §5, from the full rigid-body
//! model of §1).

use super::parameters::MovedLines;
use super::{BallBarRun, BallBarTest, ErrorParameter};
use crate::geometry::{Mat3, Screw, Vec3};
use crate::machine::{Machine, Side};

/// One test's geometry: everything that stays the same while the axis turns.
#[derive(Debug, Clone)]
pub(super) struct TestModel {
    pub(super) axis: usize,
    pub(super) on_table: bool,
    /// The programmed ball in W \[mm\]. W has its origin `o` in `center_mm`, the point that squareness does not
    /// move.
    pub(super) ball_mm: Vec3,
    /// The reference point of the table axis next to the workpiece in M \[mm\].
    center_mm: Vec3,
    /// Bar direction at zero.
    pub(super) bar: Vec3,
    pub(super) bar_length_mm: f64,
    tool_length_mm: f64,
    pub(super) squareness: Mat3,
}

/// The control that turns the axis: the lines it assumes, in the profile's order.
pub(super) type Control = [Screw; 2];

impl TestModel {
    pub(super) fn new(machine: &Machine, run: &BallBarRun, test: &BallBarTest) -> Self {
        let axes = machine.rotary_axes();
        let turned = &axes[test.axis];
        // Table axes are listed from the bed outward: the last one is next to the workpiece.
        let center_mm = axes
            .iter()
            .rev()
            .find(|axis| axis.side == Side::Table)
            .map_or_else(Vec3::zeros, |axis| axis.point_mm);
        Self {
            axis: test.axis,
            on_table: test.on_table(machine),
            ball_mm: test.ball_mm,
            center_mm,
            bar: test.bar.unit(turned.letter, turned.direction),
            bar_length_mm: run.bar_length_mm,
            tool_length_mm: test.tool_length_mm,
            squareness: machine.squareness().matrix(),
        }
    }

    /// The reading \[mm\] at an angle with given sine and cosine. `slopes` gets its derivatives by `parameters` and
    /// by the two components of the set-up error (as long as `parameters` and two more).
    ///
    /// By its own lines, the control holds the programmed ball at rest in W, `q(θ)`. The real lines carry the real
    /// ball, offset by e, to `s(θ)`. The ball on the table is at `s(0) − L u`. The reading is
    /// `|s(θ) − s(0) + L u| − L`, in the frame of the table. §5 writes it as `|E + R·L·u| − L` in the frame of the
    /// machine.
    pub(super) fn reading(
        &self,
        turn: (f64, f64),
        lines: &MovedLines,
        control: &Control,
        setup_error_mm: Vec3,
        parameters: &[ErrorParameter],
        slopes: &mut [f64],
    ) -> f64 {
        let (real, believed) = (self.placed(lines.screws[self.axis]), self.placed(control[self.axis]));
        let (sin, cos) = turn;
        // The position of the ball before the real axis turns it, and the motion that the slides add afterwards.
        let (ball_mm, slides_mm) = if self.on_table {
            (self.squareness * believed.carry_by((-sin, cos), self.ball_mm) + setup_error_mm, Vec3::zeros())
        } else {
            let slides_mm = self.ball_mm - believed.carry_by(turn, Vec3::zeros());
            (setup_error_mm, self.squareness * slides_mm)
        };
        let at_zero_mm = self.squareness * self.ball_mm + setup_error_mm;
        let arm_mm = ball_mm - real.point_mm;
        let carried_mm = real.point_mm + real.turn_by(turn, arm_mm) + slides_mm;
        let bar_mm = carried_mm - at_zero_mm + self.bar * self.bar_length_mm;
        let length_mm = bar_mm.norm();
        let along = bar_mm / length_mm;
        let along_arm = real.direction.dot(&arm_mm);
        for (parameter, slope) in parameters.iter().zip(slopes.iter_mut()) {
            let line = lines.slope(self.axis, *parameter);
            let shift = line.point_mm - real.turn_by(turn, line.point_mm);
            let tilt = (line.direction * along_arm + real.direction * line.direction.dot(&arm_mm))
                * (1.0 - cos)
                + line.direction.cross(&arm_mm) * sin;
            *slope = along.dot(&(shift + tilt));
        }
        for (component, slope) in slopes.iter_mut().skip(parameters.len()).enumerate().take(2) {
            let unit = Vec3::ith(component, 1.0);
            *slope = along.dot(&(real.turn_by(turn, unit) - unit));
        }
        length_mm - self.bar_length_mm
    }

    /// The line of a table axis in W, or of a head axis relative to the ball. Head lines are given from the gauge
    /// point.
    pub(super) fn placed(&self, mut line: Screw) -> Screw {
        if self.on_table {
            line.point_mm -= self.center_mm;
        } else {
            line.point_mm += Machine::TOOL_AXIS * self.tool_length_mm;
        }
        line
    }
}

/// The reading when the spindle turns by the angle with both axes at zero: `|(turn e − e) + L u| − L` \[mm\], and
/// its derivatives by the components of e.
pub(super) fn spindle_reading(
    turn: (f64, f64),
    bar: Vec3,
    bar_length_mm: f64,
    setup_error_mm: Vec3,
    slopes: &mut [f64; 2],
) -> f64 {
    let spindle = Screw { direction: Machine::TOOL_AXIS, point_mm: Vec3::zeros() };
    let bar_mm = spindle.turn_by(turn, setup_error_mm) - setup_error_mm + bar * bar_length_mm;
    let length_mm = bar_mm.norm();
    for (component, slope) in slopes.iter_mut().enumerate() {
        let unit = Vec3::ith(component, 1.0);
        *slope = bar_mm.dot(&(spindle.turn_by(turn, unit) - unit)) / length_mm;
    }
    length_mm - bar_length_mm
}
