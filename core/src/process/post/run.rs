//! The course of a posting: points are gathered, paths through them are chosen window by window, written and read
//! back.

use std::io::Write;
use std::ops::ControlFlow;

use super::approach::{ALL, Approach};
use super::parameters::{PostForm, PostParameters};
use super::points::{ClPoint, ClPoints, Item};
use super::read_back::{ExpectedPoint, Part, PostedAgain};
use super::report::PostReport;
use super::write::{Writer, can_state, words};
use crate::contact::{Station, rotary_rad};
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::{InverseError, Kinematics, Path, PathOptions, ToolPose, WarningKind};
use crate::machine::{Machine, Side};
use crate::motion::{AxisWords, FeedMode, Interpolation};
use crate::process::fault::{Fault, LineFaultKind, LineFaults, NotPosted};
use crate::process::set_up::{Need, ProgramSetup, SetUps, Tools};
use crate::process::text::{Passage, Passages, ProgramSource};
use crate::program::Dialect;
use crate::units::Angle;

/// Points in one window: one path is chosen through them.
const WINDOW: usize = 4096;
/// Points at the end of a window that are looked at again with the next ones.
const OVERLAP: usize = 1024;
/// Written text is handed on when it reaches this size \[bytes\].
const FLUSH_BYTES: usize = 1 << 18;

/// No control accepts an F above this, in any unit. Controls do not have that many digits either.
const MAX_PER_MIN: f64 = 1e8;

/// H if it is not stated and the data name no tool by number.
const FIRST_LENGTH: u32 = 1;

/// Posts cutter location data to one machine as an ISO program (§1). Dynamic programming chooses the path over
/// windows of points, with as few rewinds as possible. Memory does not grow with the program. Rotary words are
/// rounded before the linear words are computed. Every point is read back and put through the forward kinematics
/// before this returns.
///
/// Statements for the post-processor become words if their form is plain, otherwise comments. A tool change is `T… M6`
/// and a new approach, if [`PostParameters::changes_tools`] asks for it. Otherwise the caller's frame puts one tool in,
/// and a tool change after a cut is refused. Drilling cycles become the motions that they are.
///
/// # Errors
/// All lines that cannot be posted; another dialect than cutter location data; the write fails. `output` then holds
/// text that must not be run.
pub fn post(
    machine: &Machine,
    parameters: &PostParameters,
    source: &dyn ProgramSource,
    output: &mut dyn Write,
    stop: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<PostReport, Fault> {
    let stated = &parameters.program.tools;
    let states_one = parameters.length_number.is_some() || stated.number.is_some() || stated.length.is_some();
    let program = parameters.program.with_surveyed_tools(None, Need::LENGTH, machine, source, stop)?;
    // The report shows the values used for each tool.
    // The text has no loops, and its cycles become motions.
    let mut passages = Passages::open(source, machine, &program)?.following_its_run(machine, &program);
    // Without tool changes a program has one tool, and a tool change after a cut is refused.
    let named_number = program.tools.number.filter(|number| PostParameters::LENGTH_NUMBERS.contains(number));
    let length = program.tools.tooling().only().and_then(|used| used.length);
    let program = ProgramSetup { tools: Tools::of_length(length), ..program };
    let parameters = &PostParameters { program, ..parameters.clone() };
    let set_up = SetUps::new(machine, &parameters.program).now;
    let kinematics = &*set_up.kinematics;
    let depends_on_length = hangs_on_set_up(machine, parameters) && has_head_axis(machine);
    let mut run = Posting {
        machine,
        kinematics,
        unstated: set_up.missing_for_place().filter(|_| hangs_on_set_up(machine, parameters)),
        parameters,
        points: ClPoints::new(states_one, depends_on_length),
        window: Vec::new(),
        start_words_deg: parameters.start_words_deg,
        last: None,
        cut_line: None,
        length_number: parameters.length_number,
        named_number,
        depends_on_length,
        writer: Writer::default(),
        read_back: PostedAgain::new(machine, kinematics, parameters),
        out: Vec::new(),
        faults: LineFaults::default(),
        report: PostReport::default(),
    };
    run.writer.open(&mut run.out);
    passages.work(stop, |passage, _, dialect| {
        if dialect != Dialect::Apt {
            return Err(Fault::NotCutterLocationData { dialect });
        }
        run.passage(passage, output, stop)
    })?;
    if passages.motions == 0 {
        return Err(Fault::NoMotion);
    }
    if let Some(line) = run.points.open_circle_line() {
        let endless = NotPosted::Arc { why: "its circle has no end" };
        run.faults.add(line, b"", LineFaultKind::NotPosted(endless));
    }
    run.settle(true, output, stop)?;
    if run.faults.total > 0 {
        return Err(Fault::Lines(run.faults));
    }
    run.writer.close(parameters, &mut run.out);
    run.read_back.await_words("M30");
    run.flush(output)?;
    run.read_back.finish()?;
    output.flush()?;
    let mut report = run.report;
    report.cut_at_end_line = run.cut_line;
    report.reading = passages.reading();
    report.blocks_in = passages.blocks;
    report.blocks_out = run.writer.blocks;
    (report.cutcoms, report.first_cutcom_line) = (run.points.cutcoms, run.points.first_cutcom_line);
    (report.arcs, report.notes, report.words) = (run.points.arcs, run.points.notes, run.points.words);
    (report.not_done, report.first_not_done_line) = (run.points.not_done, run.points.first_not_done_line);
    (report.blocks_after_end, report.end_line) = passages.behind_the_end();
    report.largest_tip_error_mm = run.read_back.largest_tip_mm;
    report.largest_axis_error = Angle::from_rad(run.read_back.largest_axis_rad);
    Ok(report)
}

/// Whether the words depend on the set-up. Axis positions do, and so does the choice of a path within the travel of
/// X Y Z.
fn hangs_on_set_up(machine: &Machine, parameters: &PostParameters) -> bool {
    parameters.form == PostForm::Machine || machine.linear_travel_mm().iter().any(Option::is_some)
}

fn has_head_axis(machine: &Machine) -> bool {
    machine.rotary_axes().iter().any(|axis| axis.side == Side::Head)
}

struct Posting<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    /// A value on which the words depend and that is not stated.
    unstated: Option<LineFaultKind>,
    parameters: &'a PostParameters,
    points: ClPoints,
    window: Vec<Item>,
    start_words_deg: Option<[f64; 2]>,
    /// The last point written: the position of the machine.
    last: Option<(AxisWords, ToolPose)>,
    /// Its line, if it was a cut.
    cut_line: Option<u64>,
    /// H, if the request or the tool change states it.
    length_number: Option<u32>,
    /// The number of the tool, if the request states it.
    named_number: Option<u32>,
    /// The words, or the choice of a path, depend on the length of the tool.
    depends_on_length: bool,
    writer: Writer,
    read_back: PostedAgain<'a>,
    out: Vec<u8>,
    faults: LineFaults,
    report: PostReport,
}

impl Posting<'_> {
    fn passage(
        &mut self,
        passage: &Passage,
        output: &mut dyn Write,
        stop: &(dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Result<(), Fault> {
        let Passage { batch, motions, .. } = passage;
        let mut motions = motions.iter().peekable();
        for (index, block) in batch.blocks().iter().enumerate() {
            let mut moves = false;
            while let Some(motion) = motions.next_if(|motion| motion.block as usize == index) {
                moves = true;
                if let Some(kind) = &self.unstated {
                    self.faults.add(motion.line, batch.block_text(block), kind.clone());
                }
                if let Err(why) = self.points.motion(self.parameters, batch, motion, &mut self.window) {
                    self.faults.add(motion.line, batch.block_text(block), LineFaultKind::NotPosted(why));
                }
            }
            if !moves {
                match self.points.statement(self.parameters, batch, block) {
                    Ok(item) => self.window.extend(item),
                    Err(why) => {
                        let kind = LineFaultKind::NotPosted(why);
                        self.faults.add(block.line, batch.block_text(block), kind);
                    }
                }
            }
            if self.window.len() >= WINDOW {
                self.settle(false, output, stop)?;
            }
        }
        Ok(())
    }

    /// Chooses the path through the points gathered and writes them, except the last ones of a window that
    /// continues.
    fn settle(
        &mut self,
        last: bool,
        output: &mut dyn Write,
        stop: &(dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Result<(), Fault> {
        if self.faults.total > 0 {
            // The program is read to its end, so that every fault is listed.
            return self.each_alone(stop);
        }
        let poses: Vec<ToolPose> =
            self.window.iter().filter_map(Item::point).map(|point| point.pose).collect();
        let options = PathOptions {
            start_words_deg: self.start_words_deg,
            rewind_deg: self.parameters.rewind_deg,
            ..PathOptions::default()
        };
        let path = if poses.is_empty() {
            Path::default()
        } else {
            self.report.windows += 1;
            match self.kinematics.path(&poses, &options, &|| stop()) {
                Ok(path) => path,
                Err(InverseError::Stopped) => return Err(Fault::Cancelled),
                Err(fault) => {
                    let at = self.window.iter().filter_map(Item::point).nth(fault.pose().unwrap_or(0));
                    let line = at.map_or(0, |point| point.line);
                    self.each_alone(stop)?;
                    if self.faults.total == 0 {
                        self.fault(line, fault);
                    }
                    return Ok(());
                }
            }
        };
        let keep = if last { 0 } else { OVERLAP.min(self.window.len() / 2) };
        let settled = self.window.len() - keep;
        // The window keeps its memory.
        let mut items = std::mem::take(&mut self.window);
        let done = self.write_all(items.get(..settled).unwrap_or_default(), &path, output);
        items.drain(..settled);
        self.window = items;
        done
    }

    /// Writes these items: the points in the positions of the path.
    fn write_all(&mut self, items: &[Item], path: &Path, output: &mut dyn Write) -> Result<(), Fault> {
        let mut warnings = path.warnings.iter().peekable();
        let mut index = 0;
        for item in items {
            let point = match item {
                Item::Note(note) => {
                    self.out.extend_from_slice(note);
                    self.out.push(b'\n');
                    continue;
                }
                Item::Words(words) => {
                    self.read_back.await_words(words);
                    self.writer.line(words, &mut self.out);
                    continue;
                }
                Item::ToolChange { number, length_number, line } => {
                    self.change_tool(*number, *length_number, *line);
                    continue;
                }
                Item::ClPoint(point) => point,
            };
            let Some(joints) = path.get(index) else { break };
            let mut residual_rad = 0.0;
            while let Some(warning) = warnings.next_if(|warning| warning.pose == index) {
                residual_rad = f64::max(residual_rad, warning.axis_residual_rad);
                self.report.pole_holds += u64::from(warning.kind == WarningKind::PoleHold);
                if warning.kind == WarningKind::Rewind {
                    self.report.rewinds += 1;
                    self.report.first_rewind_line.get_or_insert(point.line);
                    if !point.rapid {
                        self.report.cutting_rewind_line.get_or_insert(point.line);
                    }
                }
            }
            index += 1;
            let axes = self.machine.rotary_axes();
            let rotary_deg = [0, 1].map(|k: usize| axes[k].word_deg(joints.rotary_rad[k]));
            self.write(point, rotary_deg, residual_rad);
            if self.out.len() > FLUSH_BYTES {
                self.flush(output)?;
            }
        }
        self.flush(output)
    }

    /// Lists every gathered point that the machine cannot reach, independent of the points before it.
    fn each_alone(&mut self, stop: &(dyn Fn() -> ControlFlow<()> + Sync)) -> Result<(), Fault> {
        let options = PathOptions { rewind_deg: self.parameters.rewind_deg, ..PathOptions::default() };
        let mut named = None;
        for item in std::mem::take(&mut self.window) {
            // All chords of an arc have the same line.
            let Some(point) = item.point().filter(|point| named != Some(point.line)) else { continue };
            match self.kinematics.path(&[point.pose], &options, &|| stop()) {
                Ok(_) => {}
                Err(InverseError::Stopped) => return Err(Fault::Cancelled),
                Err(fault) => {
                    named = Some(point.line);
                    self.fault(point.line, fault);
                }
            }
        }
        Ok(())
    }

    fn fault(&mut self, line: u64, fault: InverseError) {
        let kind = match fault {
            InverseError::OutOfTravel { axis, commanded, min, max, .. } => {
                let axis = match axis {
                    crate::machine::Motion::Linear(k) => {
                        b"XYZ".get(k).map_or('?', |&letter| char::from(letter))
                    }
                    crate::machine::Motion::Rotary(k) => {
                        self.machine.rotary_axes().get(k).map_or('?', |axis| axis.letter.as_char())
                    }
                };
                LineFaultKind::OutOfTravel { axis, commanded, min, max }
            }
            InverseError::OutOfReach { tilt_deg, min_deg, max_deg, .. } => {
                LineFaultKind::NotPosted(NotPosted::OutOfReach { tilt_deg, min_deg, max_deg })
            }
            InverseError::NoWay { .. } => LineFaultKind::NotPosted(NotPosted::NoWay),
            other => LineFaultKind::NotPosted(NotPosted::Machine(other)),
        };
        self.faults.add(line, b"", kind);
    }

    fn write(&mut self, point: &ClPoint, rotary_deg: [f64; 2], residual_rad: f64) {
        let words = words(self.machine, self.kinematics, point, rotary_deg, self.parameters);
        let minutes = match (self.parameters.form, point.feed) {
            // The position before the first point is not known, even after FROM/.
            (PostForm::Machine, Some((FeedMode::PerMinute, feed))) if self.last.is_some() => {
                self.minutes(&words, point, feed)
            }
            _ => None,
        };
        if let Some((before, pose)) = self.last.filter(|_| !point.rapid) {
            self.swing(&before, &words, &pose, point);
        }
        let per_min = match (minutes, point.feed) {
            (Some(minutes), _) if minutes > 0.0 => 1.0 / minutes,
            (None, Some((_, feed))) => feed,
            _ => 0.0,
        };
        if per_min > MAX_PER_MIN {
            let too_quick = NotPosted::TooQuick { per_min };
            return self.faults.add(point.line, b"", LineFaultKind::NotPosted(too_quick));
        }
        if per_min > 0.0 && !can_state(per_min) {
            let too_slow = NotPosted::TooSlow { per_min };
            return self.faults.add(point.line, b"", LineFaultKind::NotPosted(too_slow));
        }
        // A cut of no length takes no time that could be written, so it gets no block.
        if minutes.is_some_and(|minutes| minutes <= 0.0) {
            // The machine stays at the previous point, and paths are measured from there.
            return;
        }
        if self.last.is_none() {
            self.approach(point, &words, residual_rad);
        } else {
            let (machine, parameters) = (self.machine, self.parameters);
            let written = self.writer.point(machine, &words, ALL, point, minutes, parameters, &mut self.out);
            let part = None;
            self.read_back.await_next(ExpectedPoint {
                point: *point,
                feed: written.feed,
                residual_rad,
                part,
            });
        }
        self.report.points += 1;
        self.cut_line = (!point.rapid).then_some(point.line);
        self.start_words_deg = Some(words.rotary_deg);
        self.last = Some((words, point.pose));
    }

    /// Another tool. The position of the machine after its change is not known, so a new approach follows.
    fn change_tool(&mut self, number: u32, length_number: u32, line: u64) {
        if self.depends_on_length && self.report.tool_changes > 0 {
            let several = LineFaultKind::NotPosted(NotPosted::SeveralLengths);
            return self.faults.add(line, b"", several);
        }
        if self.cut_line.take().is_some() {
            self.report.changes_after_cut += 1;
            self.report.first_change_after_cut_line.get_or_insert(line);
        }
        let has_moved = self.last.take().is_some();
        let text = self.writer.change_tool(number, self.parameters.form, has_moved, &mut self.out);
        self.read_back.await_words(&text);
        self.length_number = self.parameters.length_number.or(Some(length_number));
        self.report.tool_changes += 1;
    }

    /// The blocks that lead to the first point, and to the first point of each tool.
    fn approach(&mut self, point: &ClPoint, words: &AxisWords, residual_rad: f64) {
        let (machine, parameters) = (self.machine, self.parameters);
        let approach = Approach::of(machine, self.kinematics, parameters.form, &point.pose, words.rotary_deg);
        Writer::announce(approach, machine, self.report.points == 0, &mut self.out);
        // In machine coordinates the caller's frame may have switched the length on.
        if parameters.form == PostForm::Machine {
            match self.length_number {
                Some(number) => self.writer.take_length_with_z(number),
                None => self.report.length_is_left_out = true,
            }
            self.report.length_number = self.length_number;
        }
        for (index, coordinates) in approach.parts().into_iter().enumerate() {
            if let (true, PostForm::Machine, Some(number)) =
                (coordinates[2], parameters.form, self.length_number)
            {
                self.read_back.await_words(&format!("G43 H{number}"));
            }
            let written =
                self.writer.point(machine, words, coordinates, point, None, parameters, &mut self.out);
            let part = Some(Part { words: *words, coordinates, is_first: index == 0, is_last: index == 2 });
            self.read_back.await_next(ExpectedPoint {
                point: *point,
                feed: written.feed,
                residual_rad,
                part,
            });
            if index == 0 && parameters.form == PostForm::Tcp {
                // The number of a later tool is not that of this one.
                let of_data = |number: Option<u32>| number.filter(|_| !parameters.changes_tools);
                let known = self
                    .length_number
                    .or_else(|| of_data(self.points.length_register()))
                    .or(self.named_number)
                    .or_else(|| of_data(self.points.tool_number()));
                let number = known.unwrap_or(FIRST_LENGTH);
                self.read_back.await_words(&format!("H{number}"));
                self.writer.take_length(number, &mut self.out);
                self.report.length_number = Some(number);
                self.report.length_number_is_assumed = known.is_none();
            }
        }
    }

    /// Duration of the source's motion: the tip's path at its feed, or the turn in degrees if the tip rests. `None`
    /// if its start is not known: then there is no time, and the block keeps the feed. The path is the longer of
    /// two: from the source's start, and from the last point written, where the machine is. `FROM/` after a point
    /// changes the first and moves nothing.
    fn minutes(&self, words: &AxisWords, point: &ClPoint, feed: f64) -> Option<f64> {
        let said_mm = (point.pose.tip_mm - point.from_mm?).norm();
        let way_mm =
            self.last.map_or(said_mm, |(_, pose)| said_mm.max((point.pose.tip_mm - pose.tip_mm).norm()));
        let least_mm = 0.5 / 10_f64.powi(i32::from(self.parameters.linear_decimals));
        if way_mm > least_mm {
            return Some(way_mm / feed);
        }
        let (before, _) = self.last?;
        let turns = before.rotary_deg.iter().zip(&words.rotary_deg).map(|(a, b)| (b - a).abs());
        Some(turns.fold(0.0, f64::max) / feed)
    }

    /// Measures the errors half way between two points.
    fn swing(&mut self, before: &AxisWords, words: &AxisWords, from: &ToolPose, point: &ClPoint) {
        let half = |a: f64, b: f64| f64::midpoint(a, b);
        let rotary_deg = [0, 1].map(|k: usize| half(before.rotary_deg[k], words.rotary_deg[k]));
        let axis = self.kinematics.axis(rotary_rad(self.machine, rotary_deg));
        if let Some(middle) = (from.axis + point.pose.axis).try_normalize(1e-6) {
            let swing = Angle::from_rad(angle_between(axis, middle));
            if swing > self.report.largest_axis_swing {
                self.report.largest_axis_swing = swing;
                self.report.axis_swing_line = Some(point.line);
            }
        }
        if self.parameters.form == PostForm::Machine {
            let linear_mm = [0, 1, 2].map(|k: usize| half(before.linear_mm[k], words.linear_mm[k]));
            let middle = AxisWords { linear_mm, rotary_deg };
            let tip = Station::new(self.machine, self.kinematics, Interpolation::Machine, middle).pose.tip_mm;
            let straight: Vec3 = (from.tip_mm + point.pose.tip_mm) * 0.5;
            let swing_mm = (tip - straight).norm();
            if swing_mm > self.report.largest_tip_swing_mm {
                self.report.largest_tip_swing_mm = swing_mm;
                self.report.tip_swing_line = Some(point.line);
            }
        }
    }

    fn flush(&mut self, output: &mut dyn Write) -> Result<(), Fault> {
        if self.writer.blocks > self.parameters.max_blocks_out {
            return Err(Fault::TooCostly { what: "blocks written", limit: self.parameters.max_blocks_out });
        }
        self.read_back.take(&self.out)?;
        output.write_all(&self.out)?;
        self.out.clear();
        Ok(())
    }
}
