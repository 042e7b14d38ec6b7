//! The first approach: from an unknown position to the first point.
//!
//! One block with all five words would swing the table and plunge at once, from any position of the machine. The
//! approach takes three blocks instead, and relies only on what the source states:
//!
//! 1. the rotary axes alone, before tool-centre-point control is on: with it on, they would take the linear axes along;
//! 2. the two linear axes that are more across the tool axis;
//! 3. the linear axis nearest to the tool axis last, so that the tool moves along its own axis as nearly as one
//!    word allows.

use super::parameters::PostForm;
use crate::contact::rotary_rad;
use crate::geometry::Vec3;
use crate::kinematics::{Kinematics, ToolPose};
use crate::machine::Machine;

/// Which of X Y Z and the rotary axes, in the profile's order, a block states.
pub(super) type Coordinates = [bool; 5];

/// A block that states all five.
pub(super) const ALL: Coordinates = [true; 5];
const ROTARY: Coordinates = [false, false, false, true, true];
/// Components nearer than this are equal. Then Z, or otherwise Y, comes last.
const SAME_COMPONENT: f64 = 1e-9;

/// The order of the first approach.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Approach {
    /// The linear axis that comes last.
    last: usize,
}

impl Approach {
    /// The approach to a pose with these rotary words.
    pub(super) fn of(
        machine: &Machine,
        kinematics: &Kinematics,
        form: PostForm,
        pose: &ToolPose,
        rotary_deg: [f64; 2],
    ) -> Self {
        // The tool axis in the frame of X Y Z: in W, or along the linear axes.
        let along: Vec3 = match form {
            PostForm::Tcp => pose.axis,
            PostForm::Machine => {
                let turned = rotary_rad(machine, rotary_deg);
                kinematics.linear_mm(pose.tip_mm + pose.axis, turned)
                    - kinematics.linear_mm(pose.tip_mm, turned)
            }
        };
        let mut last = 2;
        for axis in [1, 0] {
            if along[axis].abs() > along[last].abs() + SAME_COMPONENT {
                last = axis;
            }
        }
        Self { last }
    }

    /// The words stated by its blocks, in their order.
    pub(super) fn parts(self) -> [Coordinates; 3] {
        let linear = |is_last: bool| std::array::from_fn(|slot| slot < 3 && (slot == self.last) == is_last);
        [ROTARY, linear(false), linear(true)]
    }

    /// What the operator has to know before the approach, as comments.
    pub(super) fn notes(self, machine: &Machine, is_first: bool) -> [String; 2] {
        let [first, second] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
        let [before, between, last] = match self.last {
            0 => ['Y', 'Z', 'X'],
            1 => ['X', 'Z', 'Y'],
            _ => ['X', 'Y', 'Z'],
        };
        let before_it = if is_first {
            "(RETRACT THE TOOL BEFORE THE START. THE START POSITION IS NOT KNOWN)"
        } else {
            "(THE POSITION AFTER THE TOOL CHANGE IS NOT KNOWN)"
        };
        [
            before_it.to_owned(),
            format!(
                "({first} {second} TURN FIRST AND ALONE, THEN {before} {between} MOVE, {last} COMES LAST)"
            ),
        ]
    }
}
