//! Where the cutter touches at the points of a region, if the program or the part states it.

use std::sync::Arc;

use super::pending::Pending;
use crate::contact::{Carry, CutterContact, Effort, SourceBlock, Station, stated_point_mm};
use crate::geometry::{Vec3, across};
use crate::kinematics::{Kinematics, ToolPose};
use crate::machine::{Machine, Tool};
use crate::motion::{ContactWords, Interpolation};
use crate::process::contact_path::{CcParameters, ContactFinder};
use crate::process::set_up::{ContactSource, SetUps};

/// Machine, set-up and cutter, and the source of contacts.
#[derive(Debug, Clone)]
pub(super) struct Cutting<'a> {
    pub(super) machine: &'a Machine,
    /// The machine with the set-up of the current motions.
    pub(super) kinematics: Arc<Kinematics>,
    /// The cutter of these motions. If it is not known, a placeholder on which nothing depends.
    pub(super) tool: Tool,
    /// Whether the positions of the axes are known under tool-centre-point control.
    pub(super) is_stated: bool,
    pub(super) parameters: &'a CcParameters,
    pub(super) contact: ContactSource,
}

impl<'a> Cutting<'a> {
    /// The state at the start of the program.
    pub(in crate::process) fn of(
        machine: &'a Machine,
        parameters: &'a CcParameters,
        contact: ContactSource,
    ) -> Self {
        let first = SetUps::new(machine, &parameters.program).now;
        let tool = first.cutter().unwrap_or(Tool::UNIT_BALL);
        let is_stated = first.is_stated();
        Self { machine, kinematics: first.kinematics, tool, is_stated, parameters, contact }
    }

    /// The contact at a point. `None` if the contact, or the side on which it is, is not known. The caller then takes
    /// the tip. Contacts that would be assumed from the feed are not used here.
    pub(super) fn touch(
        &self,
        station: &Station,
        mode: Interpolation,
        words: ContactWords,
        effort: &mut Effort<'_>,
    ) -> Option<CutterContact> {
        if matches!(self.contact, ContactSource::FeedPlane | ContactSource::Tip) {
            return None;
        }
        let found = self.finder().find(&self.kinematics, &self.tool, station, mode, words, effort);
        found.ok().flatten().filter(|touch| !touch.is_open).map(|touch| touch.contact)
    }

    fn finder(&self) -> ContactFinder<'a> {
        ContactFinder { machine: self.machine, parameters: self.parameters, source: self.contact }
    }

    /// The same, with the set-up and the cutter of this motion.
    pub(super) fn on(&self, pending: &Pending) -> Self {
        let Pending { kinematics, tool, is_stated, .. } = pending;
        Self { kinematics: Arc::clone(kinematics), tool: *tool, is_stated: *is_stated, ..self.clone() }
    }

    /// The place in W that U V W state \[mm\]. In machine interpolation they are linear words for the block's rotary
    /// words.
    pub(in crate::process) fn point_mm(
        &self,
        words_mm: [f64; 3],
        station: &Station,
        mode: Interpolation,
    ) -> Vec3 {
        stated_point_mm(self.machine, &self.kinematics, mode, words_mm, station.words.rotary_deg)
    }

    /// The block between two stations. The tip replaces the contact if a contact is not known at both ends, or if it
    /// runs across the tool's end in between.
    pub(super) fn block(
        &self,
        mode: Interpolation,
        ends: [Station; 2],
        contacts: [Option<CutterContact>; 2],
    ) -> SourceBlock<'a> {
        let tool = self.tool;
        let axes = ends.map(|end| end.pose.axis);
        let carry = match &contacts {
            [Some(start), Some(end)] if is_one_side(&tool, [start, end], axes) => {
                Carry::between(&tool, [start, end], axes)
            }
            _ => Carry::Tip,
        };
        SourceBlock::new(self.machine, &self.kinematics, tool, mode, ends, carry)
    }

    /// The tip \[mm\] with which a cutter along `axis` touches the point that it touched at this pose. Without a
    /// contact, the same tip.
    pub(in crate::process) fn kept_tip_mm(
        &self,
        pose: &ToolPose,
        contact: Option<&CutterContact>,
        axis: Vec3,
    ) -> Vec3 {
        let Some(contact) = contact else { return pose.tip_mm };
        let [before, now] = [pose.axis, axis].map(|axis| self.offset_mm(contact, pose.axis, axis));
        pose.tip_mm + before - now
    }

    /// The vector \[mm\] from the tip to a contact, with the tool along `axis`. The contact was found with the tool
    /// along `found_at`.
    pub(super) fn offset_mm(&self, contact: &CutterContact, found_at: Vec3, axis: Vec3) -> Vec3 {
        let tool = &self.tool;
        Carry::between(tool, [contact, contact], [found_at; 2]).at(tool, 0.0, axis).offset_mm
    }
}

/// Whether a bull-nose or flat cutter touches on the same side at both ends, within a right angle.
fn is_one_side(tool: &Tool, contacts: [&CutterContact; 2], axes: [Vec3; 2]) -> bool {
    if tool.is_ball() {
        return true;
    }
    let [a, b] = [0, 1].map(|k| across(contacts[k].offset_mm(tool, axes[k]), axes[k]));
    a.dot(&b) >= 0.0
}
