//! The course of a wear compensation, streamed: read, move, write, read back.

use std::io::Write;
use std::ops::ControlFlow;

use super::super::emit::Emitter;
use super::super::fault::{LineFaultKind, LineFaults};
use super::super::inventory::Inventory;
use super::super::spindle::Spindle;
use super::super::stream::{Passage, Passages};
use super::super::survey::Survey;
use super::super::warnings::Warnings;
use super::super::{ContactSource, Fault, ProgramSource, WarningKind};
use super::contact::contact_angle;
use super::course::{Course, Pilot, Point};
use super::feed::lowered_feed;
use super::parameters::{LengthInControl, Milling, WearParameters};
use super::points::Points;
use super::report::{CurvatureAcross, WearReport};
use super::verify::{Expected, WearVerifier};
use super::written::Written;
use crate::contact::rotary_rad;
use crate::geometry::Vec3;
use crate::kinematics::{Kinematics, TRAVEL_SLACK};
use crate::machine::{Machine, Travel};
use crate::motion::{
    AxisWords, ContactWords, Interpolation, InterpreterOptions, Motion, MotionKind, Unfollowable,
};
use crate::program::{Address, Batch, Dialect, NewWord, print_changed};
use crate::units::{Angle, Length, MM_PER_INCH};

/// Fewest decimals of a word that was moved, in mm and in inches.
const LEAST_DECIMALS: [u8; 2] = [3, 4];
/// G90.1 and G91.1, in tenths.
const ABSOLUTE_CENTRES: u32 = 901;
const INCREMENTAL_CENTRES: u32 = 911;

/// Moves a program's points so that a worn cutter touches where the nominal one would (§4; P3 eq. (5), (6)).
///
/// Tool axis and rotary words never change, blocks are never divided, and those whose words stay are copied byte for
/// byte. What is written is read back with its own decimals, and the worn cutter's contact compared with the nominal
/// one's at every point, before this function returns; the report's `after` comes from that reading.
///
/// # Errors
/// Why the program is refused; `output` then holds text that must not be run and has to be thrown away.
pub fn compensate_wear(
    machine: &Machine,
    parameters: &WearParameters,
    source: &dyn ProgramSource,
    output: &mut dyn Write,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<WearReport, Fault> {
    let survey = Survey::of(machine, parameters.dialect, source, stop)?;
    let contact = survey.contact(parameters.contact, parameters.part.is_some())?;
    let side_by_feed = contact == ContactSource::FeedPlane && parameters.milling == Milling::Side;
    if contact == ContactSource::Tip || side_by_feed {
        return Err(Fault::UnfitContact { contact: contact.name(), milling: parameters.milling.name() });
    }
    let kinematics =
        [parameters.setup, parameters.written_setup()].map(|setup| Kinematics::new(machine, &setup));
    let options = InterpreterOptions {
        feed_mm_per_min: parameters.feed.map(crate::units::Feedrate::mm_per_min),
        interpolation_stated: parameters.interpolation.is_some(),
    };
    let mut passages = Passages::open(source, machine, parameters.dialect, options)?;
    let mut run: Option<Run<'_>> = None;
    passages.work(stop, |passage, following, dialect| {
        let run = run.get_or_insert_with(|| {
            Run::new(machine, &kinematics, parameters, survey, contact, dialect, options)
        });
        run.passage(passage, following, output)
    })?;
    let Some(mut run) = run.filter(|_| passages.motions > 0) else { return Err(Fault::NoMotion) };
    if run.faults.total > 0 {
        return Err(Fault::Lines(run.faults));
    }
    if let Some(number) = parameters.tool_number.filter(|_| run.motions_of_its_tool == 0) {
        return Err(Fault::NoSuchTool { number });
    }
    run.inventory.inserted += run.emitter.feed_blocks;
    run.verifier.finish(&run.inventory)?;
    output.flush()?;
    passages.warn(&mut run.pilot.warnings);
    Ok(run.report(passages.dialect(), passages.blocks))
}

/// The work in progress.
struct Run<'a> {
    survey: Survey,
    pilot: Pilot<'a>,
    /// X Y Z and U V W of the written program.
    axes: Written,
    points: Written,
    /// U V W have to be written anew, because the words of every point mean another place.
    moves_points: bool,
    emitter: Emitter,
    verifier: WearVerifier<'a>,
    faults: LineFaults,
    inventory: Inventory,
    out: Vec<u8>,
    /// Blocks looked through for codes that matter.
    scanned: usize,
    spindle: Spindle,
    uses_tcp: bool,
    blocks_changed: u64,
    contacts_kept: u64,
    motions_shifted: u64,
    /// Motions that are looked at: all, or those of the tool asked for.
    motions_of_its_tool: u64,
    feeds_lowered: u64,
    max_shift: (f64, Option<u64>),
    contact_angles: Option<[Angle; 2]>,
}

impl<'a> Run<'a> {
    fn new(
        machine: &'a Machine,
        kinematics: &'a [Kinematics; 2],
        parameters: &'a WearParameters,
        survey: Survey,
        contact: ContactSource,
        dialect: Dialect,
        options: InterpreterOptions,
    ) -> Self {
        let [source, written] = kinematics;
        let moves_everything = parameters.moves_everything(machine);
        let pilot = Pilot {
            machine,
            parameters,
            written,
            source,
            contact,
            points: Points::new(machine, source, parameters.interpolation),
            absolute_centres: false,
            is_its_tool: true,
            carried_mm: Vec3::zeros(),
            moves_everything,
            warnings: Warnings::default(),
            curvature: CurvatureAcross::default(),
        };
        Self {
            survey,
            pilot,
            axes: Written::new([Address::X, Address::Y, Address::Z]),
            points: Written::new([Address::U, Address::V, Address::W]),
            moves_points: moves_everything && parameters.length_in_control == LengthInControl::Measured,
            emitter: Emitter::default(),
            verifier: WearVerifier::new(machine, parameters, written, dialect, options),
            faults: LineFaults::default(),
            inventory: Inventory::default(),
            out: Vec::new(),
            scanned: 0,
            spindle: Spindle::default(),
            uses_tcp: false,
            blocks_changed: 0,
            contacts_kept: 0,
            motions_shifted: 0,
            motions_of_its_tool: 0,
            feeds_lowered: 0,
            max_shift: (0.0, None),
            contact_angles: None,
        }
    }

    /// Moves one batch, reads it back and writes it.
    fn passage(
        &mut self,
        passage: &Passage,
        following: Option<&Motion>,
        output: &mut dyn Write,
    ) -> Result<(), Fault> {
        let Passage { batch, motions } = passage;
        self.inventory.see(batch);
        self.pilot.points.prepare(motions);
        self.scanned = 0;
        let mut copied = 0;
        for (index, motion) in motions.iter().enumerate() {
            self.scan(batch, motion.block as usize);
            self.pilot.is_its_tool = self.spindle.holds(self.pilot.parameters.tool_number);
            let half_mm = self.half_mm(motion);
            let course = self.pilot.course(motions, index, following, &self.axes, half_mm);
            let done = match course {
                Ok(Course::Leave) => Ok(self.leave(batch, motion, &mut copied)?),
                Ok(Course::Move { point: Some(_), .. })
                    if motion.kind != MotionKind::Rapid && self.spindle.cuts_with_another() =>
                {
                    Err(LineFaultKind::AnotherTool)
                }
                Ok(Course::Move { target_mm, point }) => {
                    self.shift(batch, motion, &target_mm, point, &mut copied)?
                }
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
        self.out.extend_from_slice(batch.blocks_text(copied, batch.blocks().len()));
        // A faulty program is looked at to its end, so that every fault is named, but no longer written.
        if self.faults.total == 0 {
            self.verifier.take(&self.out)?;
            output.write_all(&self.out)?;
        } else {
            self.verifier.abandon();
        }
        self.out.clear();
        Ok(())
    }

    /// Looks for codes that make no motion in the blocks up to and with this one.
    fn scan(&mut self, batch: &Batch, last: usize) {
        let blocks = batch.blocks().get(self.scanned..=last.min(batch.blocks().len().saturating_sub(1)));
        for block in blocks.unwrap_or_default() {
            self.spindle.see(batch.words(block).iter());
            if self.moves_points {
                let stated = self.points.stated_in(batch.words(block));
                self.points.leave(&stated, false);
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

    /// Decimals of words that move: the finest of the program, at least what a control's increments want.
    fn decimals(&self, motion: &Motion) -> u8 {
        let inches = (motion.mm_per_unit - MM_PER_INCH).abs() < 1e-9;
        self.survey.linear_decimals.max(LEAST_DECIMALS[usize::from(inches)])
    }

    fn half_mm(&self, motion: &Motion) -> f64 {
        0.5 * 0.1_f64.powi(i32::from(self.decimals(motion))) * motion.mm_per_unit + 1e-9
    }

    /// Copies a block, but gives it its feed back.
    fn leave(&mut self, batch: &Batch, motion: &Motion, copied: &mut usize) -> Result<(), Fault> {
        let start = motion.start.map(|words| self.standing(&words));
        let stated = self.axes.stated(batch, motion);
        match motion.unfollowable {
            Some(Unfollowable::Reference | Unfollowable::MachineCoordinates) => self.axes.meet(&stated),
            _ => self.axes.leave(&stated, motion.incremental),
        }
        let end = motion.end.map(|words| self.standing(&words));
        self.foresee(motion, start, end, motion.contact, None, None);
        if self.emitter.owes_feed() {
            self.out.extend_from_slice(batch.blocks_text(*copied, motion.block as usize));
            *copied = motion.block as usize;
            let changed = self
                .emitter
                .restore_feed(batch, motion, &mut self.out)
                .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
            *copied += usize::from(changed);
            self.blocks_changed += u64::from(changed);
        }
        Ok(())
    }

    /// Where the written program stands when the source stands at `words`.
    fn standing(&self, words: &AxisWords) -> AxisWords {
        AxisWords { linear_mm: self.axes.standing_mm(&words.linear_mm), ..*words }
    }

    /// Writes a block with its moved end.
    fn shift(
        &mut self,
        batch: &Batch,
        motion: &Motion,
        target_mm: &[f64; 3],
        point: Option<Point>,
        copied: &mut usize,
    ) -> Result<Result<(), LineFaultKind>, Fault> {
        let Some(source_end) = motion.end else { return Ok(Ok(())) };
        let decimals = self.decimals(motion);
        let start = motion.start.map(|words| self.standing(&words));
        let stated = self.axes.stated(batch, motion);
        let from = motion.start.map_or(source_end.linear_mm, |words| words.linear_mm);
        let plan = self.axes.plan(motion, &stated, [&from, &source_end.linear_mm], target_mm, decimals);
        let end = AxisWords { linear_mm: plan.end_mm, ..source_end };
        if let Err(kind) = self.check_travel(motion, &end) {
            return Ok(Err(kind));
        }
        let mut words: Vec<NewWord> = plan.words.into_iter().flatten().collect();
        let contact = self.move_points(batch, motion, &source_end, decimals, &mut words);
        let lowered =
            match start.map(|start| lowered_feed(motion, [&start, &end], self.survey.has_feed_column)) {
                Some(Err(kind)) => return Ok(Err(kind)),
                Some(Ok(lowered)) => lowered,
                None => None,
            };
        let feed = self.feed_word(motion, lowered);
        let only_feed = words.is_empty();
        words.extend(feed);
        if !words.is_empty() {
            self.out.extend_from_slice(batch.blocks_text(*copied, motion.block as usize));
            print_changed(batch, motion.block as usize, &words, false, &mut self.out)
                .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
            *copied = motion.block as usize + 1;
            self.blocks_changed += 1;
            self.emitter.feeds_restored += u64::from(only_feed && lowered.is_none());
        }
        self.feeds_lowered += u64::from(lowered.is_some());
        self.count(motion, point.as_ref());
        self.foresee(motion, start, Some(end), contact, lowered, point);
        Ok(Ok(()))
    }

    /// The F word that the block needs: a lower one, or the source's where the written program has another.
    fn feed_word(&mut self, motion: &Motion, lowered: Option<NewWord>) -> Option<NewWord> {
        if motion.kind == MotionKind::Rapid {
            return None;
        }
        if lowered.is_none() {
            return self.emitter.take_owed(&motion.feed);
        }
        // Written even where it should stand already: an F between the blocks may have come in.
        self.emitter.owe(&motion.feed);
        lowered
    }

    /// U V W where the control's length makes every word mean another place.
    fn move_points(
        &mut self,
        batch: &Batch,
        motion: &Motion,
        end: &AxisWords,
        decimals: u8,
        words: &mut Vec<NewWord>,
    ) -> ContactWords {
        let ContactWords::Point(point_mm) = motion.contact else { return motion.contact };
        if !self.moves_points || self.pilot.points.mode(motion) == Interpolation::Tcp {
            return motion.contact;
        }
        let rotary_rad = rotary_rad(self.pilot.machine, end.rotary_deg);
        let place_mm = self.pilot.source.tip_mm(Vec3::from(point_mm), rotary_rad);
        let target_mm: [f64; 3] = self.pilot.written.linear_mm(place_mm, rotary_rad).into();
        let stated = self.points.stated(batch, motion);
        let plan = self.points.plan(motion, &stated, [&point_mm, &point_mm], &target_mm, decimals);
        words.extend(plan.words.into_iter().flatten());
        ContactWords::Point(plan.end_mm)
    }

    fn count(&mut self, motion: &Motion, point: Option<&Point>) {
        self.motions_of_its_tool += u64::from(self.pilot.is_its_tool);
        let is_tcp = self.pilot.points.mode(motion) == Interpolation::Tcp;
        self.uses_tcp |= is_tcp && motion.kind != MotionKind::Rapid;
        self.motions_shifted += u64::from(self.axes.is_off());
        let Some(point) = point else { return };
        let shift_mm = point.contact.shift_mm.norm();
        if shift_mm > self.max_shift.0 {
            self.max_shift = (shift_mm, Some(motion.line));
        }
        if !point.has_contact {
            return;
        }
        self.contacts_kept += 1;
        let angle = contact_angle(&point.contact, point.pose.axis);
        let [least, most] = self.contact_angles.unwrap_or([angle, angle]);
        self.contact_angles =
            Some([if angle < least { angle } else { least }, if angle > most { angle } else { most }]);
    }

    fn foresee(
        &mut self,
        motion: &Motion,
        start: Option<AxisWords>,
        end: Option<AxisWords>,
        contact: ContactWords,
        lowered: Option<NewWord>,
        point: Option<Point>,
    ) {
        if self.faults.total > 0 {
            return;
        }
        let mut planned = Motion { start, end, contact, ..*motion };
        if let Some(feed) = lowered {
            planned.feed.raw = feed.value;
        }
        let half_mm = self.half_mm(motion);
        self.verifier.await_next(Expected { motion: planned, point, half_mm });
    }

    /// The axes' travel, at the place the block leads to.
    fn check_travel(&self, motion: &Motion, end: &AxisWords) -> Result<(), LineFaultKind> {
        let machine = self.pilot.machine;
        let check = |axis: char, commanded: f64, travel: Option<Travel>| {
            LineFaultKind::outside(axis, commanded, travel, TRAVEL_SLACK).map_or(Ok(()), Err)
        };
        for (axis, word) in machine.rotary_axes().iter().zip(end.rotary_deg) {
            check(axis.letter.as_char(), word, axis.travel_deg)?;
        }
        let travel = *machine.linear_travel_mm();
        if travel.iter().all(Option::is_none) {
            return Ok(());
        }
        let linear_mm: [f64; 3] = match self.pilot.points.mode(motion) {
            Interpolation::Machine => end.linear_mm,
            Interpolation::Tcp => {
                let rotary_rad = rotary_rad(machine, end.rotary_deg);
                self.pilot.written.linear_mm(Vec3::from(end.linear_mm), rotary_rad).into()
            }
        };
        for ((letter, word), travel) in ['X', 'Y', 'Z'].into_iter().zip(linear_mm).zip(travel) {
            check(letter, word, travel)?;
        }
        Ok(())
    }

    fn report(mut self, dialect: Dialect, blocks_in: u64) -> WearReport {
        let is_larger = self.pilot.parameters.is_larger();
        let warnings = &mut self.pilot.warnings;
        if is_larger && self.contacts_kept > 0 {
            warnings.add(WarningKind::LargerCutter, None);
        }
        if self.contacts_kept == 0 {
            warnings.add(WarningKind::NoContactKept, None);
        } else if self.pilot.contact == ContactSource::FeedPlane {
            warnings.add(WarningKind::ContactAssumed, None).count = self.contacts_kept;
        }
        let (max_shift_mm, max_shift_line) = self.max_shift;
        WearReport {
            dialect,
            interpolation: if self.uses_tcp { Interpolation::Tcp } else { Interpolation::Machine },
            contact: self.pilot.contact,
            blocks_in,
            blocks_out: self.verifier.blocks(),
            blocks_changed: self.blocks_changed,
            contacts_kept: self.contacts_kept,
            motions_shifted: self.motions_shifted,
            feeds_lowered: self.feeds_lowered,
            feeds_restored: self.emitter.feeds_restored,
            max_shift: Length::from_mm(max_shift_mm),
            max_shift_line,
            contact_angles: self.contact_angles,
            curvature: self.pilot.parameters.part.as_ref().map(|_| self.pilot.curvature),
            before: self.verifier.found.before.summary(),
            after: self.verifier.found.after.summary(),
            cc_path_length_mm: self.verifier.found.before.path_mm(),
            series: self.verifier.found.series,
            warnings: self.pilot.warnings.into_list(),
        }
    }
}
