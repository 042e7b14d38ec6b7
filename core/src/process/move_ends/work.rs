//! Moves and writes a program, stretch after stretch.

use super::assumption::Assumption;
use super::check::{ASK_EVERY, EndsCheck, ExpectedEnd};
use super::contact::ContactAngles;
use super::feed::lowered_feed;
use super::moved::Moved;
use super::moves::Moves;
use super::pilot::{EndChoice, Goal, MovedPoint, Pilot};
use super::points::EndPoses;
use super::recalibration::Recalibration;
use super::report::{CurvatureAcross, WearReport};
use super::worn_tool::WornTool;
use super::written::{Axes, Resolution, Written};
use crate::contact::rotary_rad;
use crate::geometry::Vec3;
use crate::machine::Machine;
use crate::motion::{
    AxisWords, ContactWords, Interpolation, Motion, MotionKind, Unfollowable, rotary_addresses,
};
use crate::process::arc_path::{ABSOLUTE_CENTRES, INCREMENTAL_CENTRES};
use crate::process::fault::{Fault, LineFaultKind, LineFaults, WarningKind, Warnings, go_on};
use crate::process::pipeline::{Outgoing, Placed, Rewriter, StepWork, Surveyed};
use crate::process::set_up::{ContactSource, Stop, Travels};
use crate::process::text::{Inventory, LineMap, Passage, Passages, Stretch, Survey, naming_unknown_axes};
use crate::program::{Address, Batch, Keyword, NewWord, StepName, Steps};
use crate::units::Length;

/// The work in progress.
pub(super) struct EndsWork<'a> {
    survey: Survey,
    pilot: Pilot<'a>,
    /// The five axes and U V W of the written program.
    axes: Axes,
    points: Written<3>,
    /// U V W must be rewritten, because the words of every point mean another place.
    moves_points: bool,
    rewriter: Rewriter,
    faults: LineFaults,
    /// The number of blocks that were searched for codes that matter.
    scanned: usize,
    uses_tcp: bool,
    /// A motion at feed is in a tilted plane.
    uses_plane: bool,
    blocks_changed: u64,
    contacts_kept: u64,
    contacts_assumed: u64,
    motions_shifted: u64,
    /// Motions whose end was looked at, with any tool.
    motions_followed: u64,
    feeds_lowered: u64,
    max_shift: (f64, Option<u64>),
    contact_angles: ContactAngles,
    /// The new words of the present block, whose memory is used again.
    words: Vec<NewWord>,
    recalibration: Recalibration,
    stop: &'a Stop<'a>,
}

impl<'a> StepWork for EndsWork<'a> {
    type Expected = ExpectedEnd;
    type Checker = EndsCheck<'a>;

    fn write(&mut self, stretch: &Stretch, out: &mut Outgoing<ExpectedEnd>) -> Result<bool, Fault> {
        for (index, passage) in stretch.passages.iter().enumerate() {
            self.passage((index, passage), stretch.following(index), out)?;
        }
        Ok(true)
    }

    fn hear(&mut self, _check: &EndsCheck<'a>, _read: &Inventory) -> Result<(), Fault> {
        Ok(())
    }

    fn has_faults(&self) -> bool {
        self.faults.total > 0
    }

    fn refuse(&mut self, surveyed: &Surveyed<'_>, passages: &Passages<'_>) -> Result<(), Fault> {
        let moves = &self.pilot.moves;
        if self.has_faults() {
            let (faults, source) = (std::mem::take(&mut self.faults), surveyed.source);
            let (machine, program, lines) = (self.pilot.machine, &moves.source_program, passages.to_upload());
            let faults = naming_unknown_axes(faults, machine, program, source, lines, self.stop)?;
            return Err(Fault::Lines(faults));
        }
        let asks_for_nothing = !moves.has_worn_shape() && !self.pilot.moves_everything && !moves.recalibrates;
        if self.motions_followed == 0 && !asks_for_nothing {
            // The dialect may be wrong, for example. The caller would take an unchanged program for a compensated
            // one.
            return Err(Fault::NothingFollowed { first: self.pilot.warnings.first_left() });
        }
        Ok(())
    }

    fn warnings(&mut self) -> &mut Warnings {
        &mut self.pilot.warnings
    }

    fn rewriter(&self) -> &Rewriter {
        &self.rewriter
    }
}

impl<'a> EndsWork<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        moves: &Moves<'a>,
        surveyed: &Surveyed<'_>,
        stop: &'a Stop<'a>,
    ) -> Self {
        let Surveyed { survey, contact, .. } = *surveyed;
        let [source, written] = moves.set_ups(machine);
        let parameters = moves.parameters;
        let real = moves.recalibrates.then(|| written.clone());
        let mut pilot = Pilot {
            machine,
            moves: moves.clone(),
            parameters,
            worn: None,
            written,
            contact,
            points: EndPoses::new(machine, source, parameters.program.interpolation, real),
            absolute_centres: false,
            carried_mm: Vec3::zeros(),
            held_deg: 0.0,
            moves_everything: moves.moves_everything(machine),
            warnings: Warnings::default(),
            curvature: CurvatureAcross::default(),
            assumption: Assumption::default(),
            effort: parameters.budget.effort(stop),
        };
        pilot.take_tool();
        Self {
            survey,
            pilot,
            axes: Axes::new(rotary_addresses(machine)),
            points: Written::new([Address::U, Address::V, Address::W]),
            moves_points: moves.moves_points(machine),
            rewriter: Rewriter::default(),
            faults: LineFaults::default(),
            scanned: 0,
            uses_tcp: false,
            uses_plane: false,
            blocks_changed: 0,
            contacts_kept: 0,
            contacts_assumed: 0,
            motions_shifted: 0,
            motions_followed: 0,
            feeds_lowered: 0,
            max_shift: (0.0, None),
            contact_angles: ContactAngles::default(),
            words: Vec::new(),
            recalibration: Recalibration::default(),
            stop,
        }
    }

    fn passage(
        &mut self,
        passage: Placed<'_>,
        following: Option<&Motion>,
        out: &mut Outgoing<ExpectedEnd>,
    ) -> Result<(), Fault> {
        let Passage { batch, motions, .. } = passage.1;
        self.rewriter.begin(passage.1, out)?;
        self.pilot.points.prepare(motions);
        self.scanned = 0;
        for (index, motion) in motions.iter().enumerate() {
            if index % ASK_EVERY == 0 && (self.stop)().is_break() {
                return Err(Fault::Cancelled);
            }
            self.scan(batch, motion.block as usize);
            if let Some(frame) = motion.frame {
                self.turn_to_plane(frame.normal());
            }
            let resolutions = self.resolutions(motion);
            let choice = self.pilot.decide(motions, index, following, &self.axes, resolutions);
            go_on(&self.pilot.effort)?;
            let done = match choice {
                Ok(EndChoice::Leave) => Ok(self.leave(passage, motion, out)?),
                Ok(EndChoice::Move { goal, point }) => match self.foreign_tool(motion, point.is_some()) {
                    Some(kind) => Err(kind),
                    None => self.shift(passage, motion, &goal, point, out)?,
                },
                Err(kind) => Err(kind),
            };
            if let Err(kind) = done {
                let text = batch.blocks().get(motion.block as usize);
                let text = text.map_or(&[][..], |block| batch.block_text(block));
                self.faults.add(motion.line, text, kind);
                self.axes.leave(&self.axes.stated(batch, motion), motion.incremental);
            }
        }
        self.scan(batch, batch.blocks().len());
        self.rewriter.end(passage, out);
        if self.has_faults() {
            out.clear();
        }
        Ok(())
    }

    /// The reason why a motion of an unknown tool cannot be moved.
    fn foreign_tool(&mut self, motion: &Motion, is_looked_at: bool) -> Option<LineFaultKind> {
        let pilot = &mut self.pilot;
        if !is_looked_at
            || motion.kind == MotionKind::Rapid
            || !pilot.is_other_tool() && !pilot.written.now.is_foreign()
        {
            return None;
        }
        if pilot.moves.has_wear && pilot.written.tells_unknown_tools() {
            pilot.warnings.add(WarningKind::ToolUnknown, Some(motion.line));
        }
        let length_counts = pilot.moves.recalibrates && pilot.needs_length(motion);
        (length_counts && pilot.written.now.lacks_foreign_length()).then_some(LineFaultKind::OtherToolLength)
    }

    /// Searches the blocks up to and including this one for codes that make no motion.
    fn scan(&mut self, batch: &Batch, last: usize) {
        let blocks = batch.blocks().get(self.scanned..=last.min(batch.blocks().len().saturating_sub(1)));
        for block in blocks.unwrap_or_default() {
            if self.moves_points {
                let stated = self.points.stated_in(batch.words(block));
                self.points.leave(&stated, false);
            }
            if batch.words(block).iter().any(|word| word.keyword() == Some(Keyword::From)) {
                // This keyword states the tool's position, in both programs.
                self.axes.leave(&self.axes.stated_in(batch.words(block)), false);
            }
            for word in batch.words(block) {
                match (word.address, word.code_tenths()) {
                    (Address::G, Some(ABSOLUTE_CENTRES)) => self.pilot.absolute_centres = true,
                    (Address::G, Some(INCREMENTAL_CENTRES)) => self.pilot.absolute_centres = false,
                    _ => {}
                }
            }
        }
        self.scanned = (last + 1).min(batch.blocks().len());
    }

    /// The decimals and units of linear and rotary words that move. The decimals are the finest of the program, and
    /// no coarser than a control's increments.
    fn resolutions(&self, motion: &Motion) -> [Resolution; 2] {
        let [linear, rotary] = self.survey.written_decimals(motion.mm_per_unit);
        [
            Resolution { decimals: linear, unit: motion.mm_per_unit },
            Resolution { decimals: rotary, unit: 1.0 },
        ]
    }

    /// Copies a block, and restores its feed.
    fn leave(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        out: &mut Outgoing<ExpectedEnd>,
    ) -> Result<(), Fault> {
        let batch = &passage.1.batch;
        let start = motion.start.map(|words| self.axes.standing(motion, &words));
        let stated = self.axes.stated(batch, motion);
        match motion.unfollowable {
            Some(Unfollowable::Reference) => self.axes.meet(&stated),
            Some(Unfollowable::MachineCoordinates) => self.axes.meet_in_machine(batch, motion),
            Some(Unfollowable::TurnToPlane) => {
                motion.tool_axis.into_iter().for_each(|normal| self.turn_to_plane(normal));
            }
            _ => self.axes.leave(&stated, motion.incremental),
        }
        let end = motion.end.map(|words| self.axes.standing(motion, &words));
        self.foresee(motion, [start, end], motion.contact, None, None, out);
        self.blocks_changed += u64::from(self.rewriter.leave(passage, motion, out)?);
        Ok(())
    }

    /// The control has turned the rotary axes across a plane with this normal, in both programs. An axis that does not
    /// change the direction of the tool has stayed.
    fn turn_to_plane(&mut self, normal: [f64; 3]) {
        if !self.axes.rotary.is_off() {
            return;
        }
        let kinematics = &self.pilot.points.source.now.kinematics;
        let [next_to_workpiece, next_to_tool] = kinematics.workpiece_to_tool();
        self.axes.rotary.meet(next_to_tool);
        if !kinematics.leaves_first_free(Vec3::from(normal)) {
            self.axes.rotary.meet(next_to_workpiece);
        }
    }

    /// Writes a block with its moved end.
    fn shift(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        goal: &Goal,
        point: Option<MovedPoint>,
        out: &mut Outgoing<ExpectedEnd>,
    ) -> Result<Result<(), LineFaultKind>, Fault> {
        let batch = &passage.1.batch;
        let Some(source_end) = motion.end else { return Ok(Ok(())) };
        let [linear, rotary] = self.resolutions(motion);
        let start = motion.start.map(|words| self.axes.standing(motion, &words));
        let stated = self.axes.stated(batch, motion);
        let from = motion.start.unwrap_or(source_end);
        let in_block = |linear_mm: [f64; 3]| motion.stated(AxisWords { linear_mm, ..source_end }).linear_mm;
        let rotary_goal = match goal {
            Goal::Words(words) => words.rotary_deg,
            Goal::Point { rotary_deg } => *rotary_deg,
        };
        let incremental = motion.incremental;
        let source_deg = [&from.rotary_deg, &source_end.rotary_deg];
        let turned = self.axes.rotary.plan(incremental, &stated.rotary, source_deg, &rotary_goal, rotary);
        let target_mm = match (goal, &point) {
            (Goal::Point { .. }, Some(point)) => self.pilot.linear_mm(motion, turned.end, point),
            (Goal::Words(words), _) => words.linear_mm,
            (Goal::Point { .. }, None) => self.axes.standing(motion, &source_end).linear_mm,
        };
        let [from_mm, source_mm, target_mm] = [from.linear_mm, source_end.linear_mm, target_mm].map(in_block);
        let plan =
            self.axes.linear.plan(incremental, &stated.linear, [&from_mm, &source_mm], &target_mm, linear);
        let end = motion.placed(AxisWords { linear_mm: plan.end, rotary_deg: turned.end });
        if let Err(kind) = self.check_travel(motion, &end) {
            return Ok(Err(kind));
        }
        let mut words = std::mem::take(&mut self.words);
        words.clear();
        words.extend(plan.words.into_iter().chain(turned.words).flatten());
        let contact = self.move_points(batch, motion, [&source_end, &end], linear, &mut words);
        let lowered =
            match start.map(|start| lowered_feed(motion, [&start, &end], self.survey.has_feed_column)) {
                Some(Err(kind)) => return Ok(Err(kind)),
                Some(Ok(lowered)) => lowered,
                None => None,
            };
        let is_written = self.rewriter.rewrite(passage, motion, &mut words, lowered, out)?;
        self.blocks_changed += u64::from(is_written);
        self.words = words;
        self.feeds_lowered += u64::from(lowered.is_some());
        self.count(motion, point.as_ref());
        if let Some(point) = &point {
            self.recalibration.take(
                self.pilot.machine,
                motion,
                point,
                [&source_end, &end],
                self.pilot.moves.recalibrates,
            );
        }
        self.foresee(motion, [start, Some(end)], contact, lowered, point, out);
        Ok(Ok(()))
    }

    /// Plans U V W if the words of every point mean another place.
    fn move_points(
        &mut self,
        batch: &Batch,
        motion: &Motion,
        [source_end, end]: [&AxisWords; 2],
        resolution: Resolution,
        words: &mut Vec<NewWord>,
    ) -> ContactWords {
        let ContactWords::Point(point_mm) = motion.contact else { return motion.contact };
        if !self.moves_points || self.pilot.points.mode(motion) == Interpolation::Tcp {
            return motion.contact;
        }
        let machine = self.pilot.machine;
        let (source, written) = (&self.pilot.points.source.now, &self.pilot.written.now);
        let place_mm =
            source.kinematics.tip_mm(Vec3::from(point_mm), rotary_rad(machine, source_end.rotary_deg));
        let target_mm: [f64; 3] =
            written.kinematics.linear_mm(place_mm, rotary_rad(machine, end.rotary_deg)).into();
        let stated = self.points.stated(batch, motion);
        let standing = [&point_mm, &point_mm];
        let plan = self.points.plan(motion.incremental, &stated, standing, &target_mm, resolution);
        words.extend(plan.words.into_iter().flatten());
        ContactWords::Point(plan.end)
    }

    fn count(&mut self, motion: &Motion, point: Option<&MovedPoint>) {
        self.motions_followed += 1;
        if motion.kind != MotionKind::Rapid {
            let is_tcp = self.pilot.points.mode(motion) == Interpolation::Tcp;
            self.uses_plane |= motion.frame.is_some();
            self.uses_tcp |= is_tcp && motion.frame.is_none();
        }
        self.motions_shifted += u64::from(self.axes.is_off());
        let Some(point) = point else { return };
        let shift_mm = point.contact.shift_mm.norm();
        if shift_mm > self.max_shift.0 {
            self.max_shift = (shift_mm, Some(motion.line));
        }
        if !point.has_contact {
            return;
        }
        if point.is_assumed {
            self.contacts_assumed += 1;
        } else {
            self.contacts_kept += 1;
        }
        self.contact_angles.take(&point.contact, point.pose.axis);
    }

    fn foresee(
        &mut self,
        motion: &Motion,
        [start, end]: [Option<AxisWords>; 2],
        contact: ContactWords,
        lowered: Option<NewWord>,
        point: Option<MovedPoint>,
        out: &mut Outgoing<ExpectedEnd>,
    ) {
        if self.has_faults() {
            return;
        }
        let mut planned = Motion { start, end, contact, ..*motion };
        if let Some(feed) = lowered {
            planned.feed.raw = feed.value;
        }
        let resolutions = self.resolutions(motion);
        out.expected.push_back(ExpectedEnd { motion: planned, point, resolutions });
    }

    /// Checks the travel of the axes at the place to which the block leads.
    fn check_travel(&mut self, motion: &Motion, end: &AxisWords) -> Result<(), LineFaultKind> {
        let pilot = &mut self.pilot;
        let mut first = None;
        let check = pilot.written.now.travel_check(pilot.machine);
        let travels = check.see(pilot.points.mode(motion), end, |kind| {
            first.get_or_insert(kind);
        });
        if travels == Travels::NotChecked {
            pilot.warnings.add(WarningKind::TravelNotChecked, Some(motion.line));
        }
        first.map_or(Ok(()), Err)
    }

    pub(super) fn moved(mut self, verifier: EndsCheck<'_>, passages: &Passages<'_>) -> (Moved, LineMap) {
        let moves = self.pilot.moves.clone();
        let tools = moves.worn_tools();
        let is_larger = tools.iter().any(WornTool::is_larger);
        let warnings = &mut self.pilot.warnings;
        let contacts = self.contacts_kept + self.contacts_assumed;
        let needs_contact = moves.has_wear && moves.has_worn_shape();
        if is_larger && contacts > 0 {
            warnings.add(WarningKind::LargerCutter, None);
        }
        if needs_contact && contacts == 0 {
            warnings.add(WarningKind::NoContactKept, None);
        }
        if self.contacts_assumed > 0 {
            warnings.add(WarningKind::ContactAssumed, None).count = self.contacts_assumed;
        }
        if moves.has_wear && self.pilot.assumption.open > 0 {
            warnings.add(WarningKind::ContactOpen, None).count = self.pilot.assumption.open;
        }
        if moves.recalibrates && (self.uses_tcp || self.uses_plane) {
            warnings.add(WarningKind::ControlCalibrated, None);
        }
        self.recalibration.warn(warnings);
        let (max_shift_mm, max_shift_line) = self.max_shift;
        self.recalibration.left = verifier.ends.axis_left;
        // If bytes change only by rounding or by a feed, all requested steps are named.
        let did_wear = moves.has_wear && max_shift_mm > 0.0;
        let did_recalibrate = moves.recalibrates && self.recalibration.did_something();
        let steps = match (self.blocks_changed > 0, did_wear, did_recalibrate) {
            (false, ..) => Steps::NONE,
            (true, true, false) => Steps::of(&[StepName::Wear]),
            (true, false, true) => Steps::of(&[StepName::LocationErrors]),
            _ => moves.steps(),
        };
        let is_assumed = moves.has_wear && self.pilot.contact == ContactSource::FeedPlane;
        let wear = WearReport {
            dialect: passages.dialect(),
            interpolation: if self.uses_tcp { Interpolation::Tcp } else { Interpolation::Machine },
            contact: self.pilot.contact,
            steps,
            reading: passages.reading(),
            blocks_in: passages.blocks,
            blocks_out: verifier.blocks(),
            blocks_changed: self.blocks_changed,
            contacts_kept: self.contacts_kept,
            contacts_assumed: self.contacts_assumed,
            assumption: is_assumed.then_some(self.pilot.assumption),
            after_if_assumed: is_assumed.then(|| verifier.ends.if_assumed.summary()),
            motions_shifted: self.motions_shifted,
            feeds_lowered: self.feeds_lowered,
            feeds_restored: self.rewriter.feeds_restored(),
            max_shift: Length::from_mm(max_shift_mm),
            max_shift_line,
            contact_angles: self.contact_angles.range(),
            curvature: self.pilot.parameters.part.as_ref().map(|_| self.pilot.curvature),
            before: verifier.ends.found.before.summary(),
            after: verifier.ends.found.after.summary(),
            cc_path_length_mm: verifier.ends.found.before.path_mm(),
            series: verifier.ends.found.series,
            warnings: self.pilot.warnings.into_list(),
        };
        (Moved { wear, recalibration: self.recalibration }, self.rewriter.into_lines())
    }
}
