//! Tilted working planes: the plane that a statement defines, the rotary positions on it, and the motions in it.
//!
//! In a plane X Y Z are places of the plane, and the tool stands on it. A motion there is one of the tip, in W, with the
//! rotary axes at rest. Operations that write give it words of the plane, and no words of the rotary axes.

use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::{ACROSS_G17, Modal, ToolLength, Transformation};
use super::plane::{Offsets, Standing, TiltedPlane};
use super::travel::{CONTACTS, VECTORS};
use super::{AxisWords, Interpolation, Motion, MotionKind, Unfollowable};
use crate::geometry::{PlaneFrame, Turn};
use crate::kinematics::{FreeAxis, PlaneSide, PlaneWish};
use crate::program::{Address, Batch, Block, FreeAxisWord, PlaneDirections, PlaneStatement, PlaneTurning};

/// The transformations that are planes.
const PLANES: [Transformation; 2] = [Transformation::Tilt, Transformation::Swivel];

/// Zeros of planes lie no farther from the zero of the program than this. Farther away, the places of a plane would be
/// rounded more than a machine is accurate \[mm\].
const FARTHEST_MM: f64 = 1e7;

impl Modal {
    /// Everything that decides where the zero of the program is.
    fn offsets(&self) -> Offsets {
        let Self { work_offset, shifts, program_offset_mm, datum_mm, .. } = *self;
        Offsets { work_offset, shifts, program_offset_mm, datum_mm }
    }

    /// Whether a tilted plane is on.
    pub(super) fn is_tilted(&self) -> bool {
        PLANES.iter().any(|which| self.transformations.get(*which as usize) == Some(&Some(true)))
    }

    /// Why no motion can be followed in this state besides its plane.
    fn obstacle_beside_plane(&self) -> Option<Unfollowable> {
        let mut level = *self;
        for which in PLANES {
            level.transformations[which as usize] = Some(false);
        }
        level.obstacle()
    }
}

impl Interpreter {
    /// The plane that the block defines, if the definition is understood.
    pub(super) fn stated_plane(
        &self,
        batch: &Batch,
        block: &Block,
        before: &Modal,
    ) -> Option<PlaneStatement> {
        let begins = |index| {
            matches!(
                self.meaning(index),
                Meaning::Transform(Transformation::Tilt, true) | Meaning::Swivel(true)
            )
        };
        if !(0..self.block.g_count).any(begins) || self.block.odd_code {
            return None;
        }
        let stated = (batch.dialect().rules().plane())(batch, block)?;
        let is_level = self.modal.offsets().program_offset_mm == Some([0.0; 3]);
        let is_first = stated.replaces || !before.is_tilted();
        (is_level && is_first && self.modal.plane == Some(ACROSS_G17) && self.modal.is_tilted())
            .then_some(stated)
    }

    /// The end of a block that has defined this plane. `stood_deg` are the words of the rotary axes before it.
    pub(super) fn enter_plane(&mut self, stated: &PlaneStatement, stood_deg: [Option<f64>; 2]) {
        self.modal.tilt = None;
        self.position.forget_axes();
        if !self.modal.is_tilted() {
            return self.find_obstacle();
        }
        if stated.turning != PlaneTurning::Here {
            self.position.axes[3..].copy_from_slice(&stood_deg);
        }
        if let Some(frame) = self.frame_of(stated) {
            let side = stated.side.map(|side| PlaneSide { positive: side.positive, or_other: side.or_other });
            let free_axis = match stated.free_axis {
                None => FreeAxis::ByRule,
                Some(FreeAxisWord::Stays) => FreeAxis::Stays,
                Some(FreeAxisWord::Turns) => FreeAxis::Unknown,
            };
            self.modal.tilt = Some(TiltedPlane {
                frame,
                wish: PlaneWish { side, free_axis },
                standing: Standing::Apart,
                offsets: self.modal.offsets(),
            });
            if stated.turning == PlaneTurning::Here {
                self.stand_on_plane(stood_deg);
            }
        }
        self.find_obstacle();
    }

    fn frame_of(&self, stated: &PlaneStatement) -> Option<PlaneFrame> {
        let unit = self.modal.mm_per_unit?;
        let has_lengths = stated.zero.iter().chain(&stated.shift).any(|length| length.abs() > 0.0);
        let is_metric = (unit - 1.0).abs() <= 0.0;
        if (has_lengths && !stated.counts_in_unit && !is_metric) || self.modal.incremental != Some(false) {
            return None;
        }
        let turn = match stated.directions {
            PlaneDirections::Turns(turns) => {
                turns.into_iter().fold(Turn::NONE, |turn, (axis, deg)| turn.then_about(axis, deg))
            }
            PlaneDirections::Axes { x, normal } => Turn::with_axes(x, normal)?,
        };
        let mm = |lengths: [f64; 3]| lengths.map(|length| length * unit);
        let is_near = |lengths: [f64; 3]| mm(lengths).iter().all(|at_mm| at_mm.abs() <= FARTHEST_MM);
        if !is_near(stated.zero) || !is_near(stated.shift) {
            return None;
        }
        Some(PlaneFrame::new(mm(stated.zero), turn).shifted(mm(stated.shift)))
    }

    /// Whether the control has turned the rotary axes to known words on the plane.
    pub(super) fn stands_on_plane(&self) -> bool {
        self.modal.tilt.is_some_and(|plane| matches!(plane.standing, Standing::On(_)))
    }

    /// Reports the motions of a block that has turned the rotary axes to known words, if the block has no `reason` of
    /// its own against being followed.
    pub(super) fn note_turn(&self, reason: Option<Unfollowable>, motions: &mut [Motion]) {
        let understood = [Unfollowable::TiltedPlane, Unfollowable::Transformation].map(Some);
        let Some(plane) = self.modal.tilt.filter(|_| reason.is_none() && self.stands_on_plane()) else {
            return;
        };
        for motion in motions.iter_mut().filter(|motion| understood.contains(&motion.unfollowable)) {
            motion.unfollowable = Some(Unfollowable::TurnToPlane);
            motion.tool_axis = Some(plane.frame.normal());
        }
    }

    /// G53.1 turns the rotary axes to the plane, and moves nothing else. Returns whether the plane is understood.
    pub(super) fn turn_to_plane(&mut self) -> bool {
        let is_plain = self.block.present & !(Address::N.bit() | Address::F.bit()) == 0;
        if self.modal.tilt.is_none() || !self.modal.is_tilted() || !is_plain {
            return false;
        }
        let [.., first, second] = self.position.axes;
        self.position.forget_axes();
        self.stand_on_plane([first, second]);
        self.find_obstacle();
        true
    }

    /// The control turns the rotary axes from these words to the plane.
    fn stand_on_plane(&mut self, from_deg: [Option<f64>; 2]) {
        let Some(plane) = &mut self.modal.tilt else { return };
        let on =
            self.planes.as_ref().and_then(|axes| axes.choose(plane.frame.normal(), from_deg, plane.wish));
        plane.standing = on.map_or(Standing::Undecided, Standing::On);
        self.position.axes[3..].copy_from_slice(&on.map_or([None; 2], |words| words.map(Some)));
    }

    /// The frame of the plane, if the tool stands on it and motions in it are followed.
    pub(super) fn plane_in_force(&self) -> Option<PlaneFrame> {
        let plane = self.modal.tilt.filter(|_| self.modal.is_tilted())?;
        let Standing::On(words_deg) = plane.standing else { return None };
        // On a machine with a head axis the tip is known if a length is in force.
        let has_length = !self.axes.has_head_axis() || self.rules.has_length(&self.modal);
        let is_clear = self.position.axes[3..] == words_deg.map(Some)
            && plane.offsets == self.modal.offsets()
            && self.modal.tool_length == Some(ToolLength::Plain)
            && self.modal.compensation == Some(false)
            && has_length
            && self.modal.obstacle_beside_plane().is_none();
        is_clear.then_some(plane.frame)
    }

    /// Gives a motion in a tilted plane its places in W. Returns whether it is followed.
    #[cold]
    pub(super) fn move_in_plane(&self, motion: &mut Motion, start: Option<AxisWords>) -> bool {
        let Some(frame) = self.plane_in_force() else { return false };
        let has_directions = self.block.present & (VECTORS | CONTACTS) != 0;
        let end = self.position.axis_words();
        let is_at = |words: AxisWords| plane_words(&words) == self.position.axes[3..];
        let turns = start.is_some_and(|start| !is_at(start));
        let is_known = matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear | MotionKind::Arc);
        if !is_known || has_directions || turns {
            return false;
        }
        (motion.start, motion.end) = (start, end);
        motion.linear_end_mm = self.position.linear_mm();
        place_in(frame, motion);
        true
    }

    /// Why a motion in a plane is left unchanged, if it is not followed there.
    pub(super) fn as_in_plane(&self, obstacle: Option<Unfollowable>) -> Option<Unfollowable> {
        if obstacle != Some(Unfollowable::TiltedPlane) || !self.stands_on_plane() {
            return obstacle;
        }
        let is_compensated = self.modal.compensation != Some(false);
        let compensated = is_compensated.then_some(Unfollowable::CutterCompensation);
        self.modal.obstacle_beside_plane().or(compensated).or(obstacle)
    }
}

/// The rotary words, as positions of the control.
fn plane_words(words: &AxisWords) -> [Option<f64>; 2] {
    words.rotary_deg.map(Some)
}

/// Turns the places of a motion from places of the plane to those in W. The control follows the tip there.
pub(super) fn place_in(frame: PlaneFrame, motion: &mut Motion) {
    let in_workpiece =
        |words: AxisWords| AxisWords { linear_mm: frame.to_workpiece(words.linear_mm), ..words };
    motion.start = motion.start.map(in_workpiece);
    motion.end = motion.end.map(in_workpiece);
    motion.linear_end_mm = motion.linear_end_mm.map(|at_mm| frame.to_workpiece(at_mm));
    motion.interpolation = Interpolation::Tcp;
    motion.frame = Some(frame);
}
