//! The machine with its set-up, ready for evaluation: forward kinematics and the linear words of a tip.

use super::pointing::Pointing;
use crate::geometry::{Mat3, Screw, Vec3, angle_between, trig};
use crate::machine::{Machine, Side, Travel};

/// A tool pose in the workpiece frame W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose {
    /// Tool tip w \[mm\].
    pub tip_mm: Vec3,
    /// Unit tool axis t, from the tip into the spindle.
    pub axis: Vec3,
}

/// Axis positions: programmed linear words q and kinematic angles θ (words with the control's counting direction
/// removed). The rotary axes are in the profile's order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joints {
    /// `(X, Y, Z)` \[mm\].
    pub linear_mm: Vec3,
    /// θ of the first and the second rotary axis of the profile \[rad\].
    pub rotary_rad: [f64; 2],
}

/// The parts mounted on the machine, and whether its errors are applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Work offset o: W's origin in M at zero pose \[mm\].
    pub work_offset_mm: Vec3,
    /// Tool length L, added along the zero-pose tool axis to head axis points \[mm\].
    pub tool_length_mm: f64,
    /// Whether location errors and squareness are applied.
    pub apply_errors: bool,
}

impl Default for Setup {
    fn default() -> Self {
        Self { work_offset_mm: Vec3::zeros(), tool_length_mm: 0.0, apply_errors: true }
    }
}

/// One machine with one set-up: the two screws u, v from the workpiece to the tool, and the position of the linear
/// axes between them. Everything is in closed form.
#[derive(Debug, Clone, PartialEq)]
pub struct Kinematics {
    /// u, v; head lines relative to the zero-pose tool tip.
    pub(super) screws: [Screw; 2],
    /// Index of u and of v in the profile.
    pub(super) profile_index: [usize; 2],
    /// Number of head axes among the two, counted from the tool. The linear axes come after them.
    pub(super) head_axes: usize,
    pub(super) work_offset_mm: Vec3,
    pub(super) linear_directions: Mat3,
    pub(super) linear_words: Mat3,
    /// Direction in which the control counts u and v: −1 is opposite to ISO 841.
    pub(super) sense: [f64; 2],
    /// Travel of the NC words of u and v \[deg\].
    pub(super) travel_deg: [Option<Travel>; 2],
    /// Travel of X Y Z \[mm\].
    pub(super) linear_travel_mm: [Option<Travel>; 3],
    /// Angles between nominal and calibrated direction of both axes, summed \[rad\].
    pub(super) tilt_rad: f64,
    /// The direction part of the inverse.
    pub(super) pointing: Pointing,
}

/// One machine without a set-up: most of what [`Kinematics::new`] computes, for use with many set-ups.
#[derive(Debug, Clone, PartialEq)]
pub struct BareKinematics(Kinematics);

impl BareKinematics {
    /// The machine with its measured errors, or the nominal machine.
    #[must_use]
    pub fn new(machine: &Machine, apply_errors: bool) -> Self {
        Self(Kinematics::bare(machine, apply_errors))
    }

    /// The machine with W's origin at `work_offset_mm` in M and a tool of this length \[mm\], along which head
    /// lines move away from the tip.
    #[must_use]
    pub fn set_up(&self, work_offset_mm: Vec3, tool_length_mm: f64) -> Kinematics {
        let mut kinematics = Kinematics { work_offset_mm, ..self.0.clone() };
        // Head axes are the last axes on the way from the workpiece to the tool.
        for screw in kinematics.screws.iter_mut().rev().take(kinematics.head_axes) {
            screw.point_mm += Machine::TOOL_AXIS * tool_length_mm;
        }
        kinematics
    }
}

impl Kinematics {
    /// The machine with its set-up. The calibrated lines are screws like any other: nothing is linearised.
    #[must_use]
    pub fn new(machine: &Machine, setup: &Setup) -> Self {
        BareKinematics::new(machine, setup.apply_errors).set_up(setup.work_offset_mm, setup.tool_length_mm)
    }

    /// The machine without work offset and tool length.
    fn bare(machine: &Machine, apply_errors: bool) -> Self {
        let profile_index = machine.workpiece_to_tool();
        let lines = machine.screws(apply_errors);
        let screws = profile_index.map(|index| lines[index]);
        let head_axes = machine.rotary_axes().iter().filter(|axis| axis.side == Side::Head).count();
        let linear_directions = if apply_errors { machine.squareness().matrix() } else { Mat3::identity() };
        // Columns are unit vectors within 0.05 rad of x, y, z, so the inverse always exists.
        let linear_words = linear_directions.try_inverse().unwrap_or_else(Mat3::identity);
        let axes = profile_index.map(|index| &machine.rotary_axes()[index]);
        let sense = axes.map(|axis| if axis.reversed { -1.0 } else { 1.0 });
        let nominal = machine.screws(false);
        let tilt_rad =
            (0..2).map(|index| angle_between(nominal[index].direction, lines[index].direction)).sum();
        let pointing = Pointing::new(screws[0].direction, screws[1].direction, Machine::TOOL_AXIS, sense);
        Self {
            screws,
            profile_index,
            head_axes,
            work_offset_mm: Vec3::zeros(),
            linear_directions,
            linear_words,
            sense,
            travel_deg: axes.map(|axis| axis.travel_deg),
            linear_travel_mm: *machine.linear_travel_mm(),
            tilt_rad,
            pointing,
        }
    }

    /// The pose of the tool in W: `w = E_t⁻¹(S q + o + E_h·0) − o`, `t = R_t⁻¹ R_h t0` (§1).
    #[must_use]
    pub fn forward(&self, joints: &Joints) -> ToolPose {
        let turns = self.turns(joints.rotary_rad);
        let axis = self.screws[0].turn_by(turns[0], self.screws[1].turn_by(turns[1], Machine::TOOL_AXIS));
        ToolPose { tip_mm: self.tip_at(joints.linear_mm, turns), axis }
    }

    /// Sine and cosine of the angles of u and v.
    fn turns(&self, rotary_rad: [f64; 2]) -> [(f64, f64); 2] {
        let [u, v] = self.profile_index;
        [trig::sin_cos(rotary_rad[u]), trig::sin_cos(rotary_rad[v])]
    }

    /// The tool axis t in W at these rotary angles (profile order) \[rad\]: `exp(θ_u û) exp(θ_v v̂) t0`.
    #[must_use]
    pub fn axis(&self, rotary_rad: [f64; 2]) -> Vec3 {
        let [u, v] = self.profile_index.map(|index| rotary_rad[index]);
        self.screws[0].turn(u, self.screws[1].turn(v, Machine::TOOL_AXIS))
    }

    /// The tool tip in W \[mm\] at linear words q \[mm\] and rotary angles \[rad\].
    #[must_use]
    pub fn tip_mm(&self, linear_mm: Vec3, rotary_rad: [f64; 2]) -> Vec3 {
        self.tip_at(linear_mm, self.turns(rotary_rad))
    }

    fn tip_at(&self, linear_mm: Vec3, turns: [(f64, f64); 2]) -> Vec3 {
        let mut p = Vec3::zeros();
        for (stage, k) in [1, 0].into_iter().enumerate() {
            if stage == self.head_axes {
                p += self.linear_directions * linear_mm + self.work_offset_mm;
            }
            p = self.screws[k].carry_by(turns[k], p);
        }
        if self.head_axes == 2 {
            p += self.linear_directions * linear_mm + self.work_offset_mm;
        }
        p - self.work_offset_mm
    }

    /// The linear words q \[mm\] that put the tip at `tip_mm` in W with these rotary angles \[rad\]:
    /// `q = S⁻¹(E_t(w + o) − o − E_h·0)` (§1), exact.
    #[must_use]
    pub fn linear_mm(&self, tip_mm: Vec3, rotary_rad: [f64; 2]) -> Vec3 {
        let mut from_workpiece = tip_mm + self.work_offset_mm;
        let mut from_tool = Vec3::zeros();
        for (count, k) in [1, 0].into_iter().enumerate() {
            if count < self.head_axes {
                from_tool = self.screws[k].carry(rotary_rad[self.profile_index[k]], from_tool);
            }
        }
        for k in 0..2 - self.head_axes {
            from_workpiece = self.screws[k].carry(-rotary_rad[self.profile_index[k]], from_workpiece);
        }
        self.linear_words * (from_workpiece - self.work_offset_mm - from_tool)
    }
}
