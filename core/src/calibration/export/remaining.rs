//! The errors that remain when a machine is described by a simplified model.

use crate::geometry::{Screw, Vec3, angle_between};
use crate::machine::{Machine, Side, Travel};

/// The remaining error when a control moves along simplified lines, with square linear axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RemainingError {
    /// Distance of the tool tip from the pivot \[mm\]. For a table machine it is in any direction from the point of
    /// the axis next to the workpiece that is nearest to the other axis; for a head it is below the gauge point.
    pub radius_mm: f64,
    /// Upper bound on the distance between the commanded and the real tip, in the workpiece \[mm\].
    pub tip_mm: f64,
    /// Largest angle between the commanded and the real tool axis \[rad\].
    pub axis_rad: f64,
}

/// Angles tried per axis, with the ends of the travel. Between them the maximum is missed by up to 1 − cos(3.75°),
/// 0.2 %.
const STEPS: u32 = 48;

impl RemainingError {
    /// Compares the machine's calibrated lines with `simplified` ones (profile's order) over a grid of angles
    /// within the travel, ±180° for an unlimited axis. Both give the same tip and tool axis at zero.
    ///
    /// At given angles a rigid motion leads from the commanded tip to the real tip. If it displaces the pivot by b
    /// and turns by φ, a tip at radius r around the pivot is displaced by at most `|b| + 2 r sin(φ/2)`.
    #[must_use]
    pub(super) fn of(machine: &Machine, simplified: &[Screw; 2], pivot_mm: Vec3, radius_mm: f64) -> Self {
        let real = machine.screws(true);
        let mut worst = Self { radius_mm, tip_mm: 0.0, axis_rad: 0.0 };
        let [first, second] = [0, 1].map(|index| angles_rad(machine, index));
        for angles in first.iter().flat_map(|a| second.iter().map(|c| [*a, *c])) {
            let chains =
                [&real, simplified].map(|lines| Chain { machine, lines, angles, tool_mm: radius_mm });
            let [is, commanded] = &chains;
            worst.axis_rad = worst.axis_rad.max(angle_between(is.axis(), commanded.axis()));
            let off_mm = |tip_mm: Vec3| is.tip_mm(commanded.linear_mm(tip_mm)) - tip_mm;
            let pivot_off_mm = off_mm(pivot_mm);
            // Sum of squares over three unit steps: 2 (2 sin(φ/2))².
            let squares: f64 = [Vec3::x(), Vec3::y(), Vec3::z()]
                .map(|step| (off_mm(pivot_mm + step * radius_mm) - pivot_off_mm).norm_squared())
                .iter()
                .sum();
            worst.tip_mm = worst.tip_mm.max(pivot_off_mm.norm() + (0.5 * squares).sqrt());
        }
        worst
    }
}

/// Kinematic angles over the travel of an axis \[rad\].
fn angles_rad(machine: &Machine, index: usize) -> Vec<f64> {
    let axis = &machine.rotary_axes()[index];
    let Travel { min, max } = axis.travel_deg.unwrap_or(Travel { min: -180.0, max: 180.0 });
    // More than a turn either way repeats.
    let (min, max) = (min.max(-180.0), max.min(180.0));
    (0..=STEPS).map(|k| axis.angle_rad(min + (max - min) * f64::from(k) / f64::from(STEPS))).collect()
}

/// Both axes at given angles, along given lines.
struct Chain<'a> {
    machine: &'a Machine,
    lines: &'a [Screw; 2],
    angles: [f64; 2],
    tool_mm: f64,
}

impl Chain<'_> {
    /// The axes on one side with their angles. The axis next to the part or the tool comes first.
    fn side(&self, side: Side) -> impl DoubleEndedIterator<Item = (Screw, f64)> {
        let axes = self.machine.rotary_axes().iter().zip(self.lines).zip(self.angles);
        axes.rev().filter(move |((axis, _), _)| axis.side == side).map(|((_, line), angle)| (*line, angle))
    }

    /// Position of the tip after the head axes \[mm\].
    fn head_mm(&self) -> Vec3 {
        let tool = Machine::TOOL_AXIS * self.tool_mm;
        self.side(Side::Head).fold(-tool, |p, (line, angle)| line.carry(angle, p)) + tool
    }

    /// `w = E_t⁻¹ (q + E_h·0)`.
    fn tip_mm(&self, linear_mm: Vec3) -> Vec3 {
        self.side(Side::Table).rev().fold(linear_mm + self.head_mm(), |p, (line, angle)| line.carry(angle, p))
    }

    /// `q = E_t w − E_h·0`.
    fn linear_mm(&self, tip_mm: Vec3) -> Vec3 {
        self.side(Side::Table).fold(tip_mm, |p, (line, angle)| line.carry(-angle, p)) - self.head_mm()
    }

    /// `t = R_t⁻¹ R_h t0`.
    fn axis(&self) -> Vec3 {
        let tool = self.side(Side::Head).fold(Machine::TOOL_AXIS, |t, (line, angle)| line.turn(angle, t));
        self.side(Side::Table).rev().fold(tool, |t, (line, angle)| line.turn(angle, t))
    }
}
