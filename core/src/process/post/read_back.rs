//! Reads the posted program back as a control would, and compares it with the source point by point.

use std::collections::VecDeque;

use super::approach::Coordinates;
use super::arc::ArcSeen;
use super::parameters::{PostForm, PostParameters};
use super::points::ClPoint;
use crate::contact::Station;
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::motion::{AxisWords, Interpolation, Motion, MotionKind};
use crate::process::fault::Fault;
use crate::process::pipeline::{Expected, MachineWord, ReadBack, failed};
use crate::process::set_up::ProgramSetup;
use crate::program::{Address, Dialect};

/// Largest arithmetic error on top of the rounding of the words [mm, rad].
const ARITHMETIC: f64 = 1e-6;

/// What the next motion must be.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExpectedPoint {
    pub(super) point: ClPoint,
    /// F as written.
    pub(super) feed: Option<f64>,
    /// Smallest angle that the axes can leave to the point's axis \[rad\].
    pub(super) residual_rad: f64,
    /// Its part of the first approach, if it is one.
    pub(super) part: Option<Part>,
}

/// A block of the first approach.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// The words of the first point.
    pub(super) words: AxisWords,
    /// The words that the block has. It has no others.
    pub(super) coordinates: Coordinates,
    /// The rotary axes turn while tool-centre-point control is off.
    pub(super) is_first: bool,
    /// The block that reaches the first point.
    pub(super) is_last: bool,
}

impl Expected for ExpectedPoint {
    fn line(&self) -> u64 {
        self.point.line
    }

    fn missing(&self) -> &'static str {
        "a motion is missing"
    }
}

/// Reads the written program and measures its errors.
pub(super) struct PostedAgain<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    read_back: ReadBack<ExpectedPoint>,
    /// Words for the machine that must come next.
    words: VecDeque<MachineWord>,
    /// Points that were written.
    points: u64,
    mode: Interpolation,
    /// Where the tip was, as read.
    at_mm: Option<Vec3>,
    arc_tolerance_mm: f64,
    tip_mm: f64,
    axis_rad: f64,
    pub(super) largest_tip_mm: f64,
    pub(super) largest_axis_rad: f64,
}

impl<'a> PostedAgain<'a> {
    pub(in crate::process) fn new(
        machine: &'a Machine,
        kinematics: &'a Kinematics,
        parameters: &PostParameters,
    ) -> Self {
        let half = |decimals: u8| 0.5 / 10_f64.powi(i32::from(decimals));
        Self {
            machine,
            kinematics,
            read_back: ReadBack::new(machine, Dialect::Iso, &ProgramSetup::default()).with_words(),
            words: VecDeque::new(),
            points: 0,
            mode: match parameters.form {
                PostForm::Tcp => Interpolation::Tcp,
                PostForm::Machine => Interpolation::Machine,
            },
            at_mm: None,
            arc_tolerance_mm: parameters.arc_tolerance.mm(),
            // Three linear words and two rotary words, each wrong by half its last digit.
            tip_mm: 3_f64.sqrt() * half(parameters.linear_decimals) + ARITHMETIC,
            axis_rad: 2.0 * half(parameters.rotary_decimals).to_radians() + ARITHMETIC,
            largest_tip_mm: 0.0,
            largest_axis_rad: 0.0,
        }
    }

    pub(super) fn await_next(&mut self, next: ExpectedPoint) {
        self.read_back.await_next(next);
        self.points += 1;
    }

    /// Expects these words for the machine next, separated by blanks.
    pub(super) fn await_words(&mut self, text: &str) {
        let words = text.split_ascii_whitespace().filter_map(|word| {
            let address = Address::from_letter(*word.as_bytes().first()?)?;
            Some(MachineWord { motions: self.points, address, value: word.get(1..)?.parse().ok()? })
        });
        self.words.extend(words);
    }

    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.read_back.feed(bytes);
        self.read()
    }

    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        self.read_back.end();
        self.read()?;
        self.read_back.has_all()?;
        if self.words.is_empty() { Ok(()) } else { Err(failed(0, "a word for the machine is missing")) }
    }

    fn read(&mut self) -> Result<(), Fault> {
        while let Some((motion, next)) = self.read_back.next()? {
            self.check(&motion, &next)?;
        }
        while let Some(read) = self.read_back.take_word() {
            if self.words.pop_front() != Some(read) {
                return Err(failed(0, "a word for the machine is missing, added or moved"));
            }
        }
        // The posted text has nothing that a reader warns of.
        self.read_back.has_no_warning()
    }

    fn check(&mut self, read: &Motion, next: &ExpectedPoint) -> Result<(), Fault> {
        let line = next.point.line;
        let kind = if next.point.rapid { MotionKind::Rapid } else { MotionKind::Linear };
        let turns_first = next.part.is_some_and(|part| part.is_first);
        let mode = if turns_first { Interpolation::Machine } else { self.mode };
        if read.kind != kind || read.unfollowable.is_some() || read.interpolation != mode {
            return Err(failed(line, "a point is reached by another kind of motion"));
        }
        if let Some(part) = next.part {
            self.check_part(line, read, &part)?;
        }
        if !next.point.rapid && next.feed != read.feed.value {
            return Err(failed(line, "a point is reached at another feed"));
        }
        if next.part.is_some_and(|part| !part.is_last) {
            return Ok(());
        }
        let Some(words) = read.end else { return Err(failed(line, "a point has no known end")) };
        let pose = Station::new(self.machine, self.kinematics, self.mode, words).pose;
        let tip_mm = (pose.tip_mm - next.point.pose.tip_mm).norm();
        let axis_rad = angle_between(pose.axis, next.point.pose.axis);
        self.largest_tip_mm = self.largest_tip_mm.max(tip_mm);
        self.largest_axis_rad = self.largest_axis_rad.max(axis_rad);
        if !(tip_mm <= self.tip_mm && axis_rad <= self.axis_rad + next.residual_rad) {
            return Err(failed(line, "a point is elsewhere than in the source"));
        }
        let from_mm = self.at_mm.replace(pose.tip_mm);
        let is_on_arc = |arc: ArcSeen| {
            from_mm.is_some_and(|from| arc.has_chord([from, pose.tip_mm], self.arc_tolerance_mm, self.tip_mm))
        };
        if next.point.on.is_some_and(|arc| !is_on_arc(arc)) {
            return Err(failed(line, "an arc goes elsewhere than in the source"));
        }
        Ok(())
    }

    /// A block of the first approach moves its axes and no others, from an unknown position.
    fn check_part(&self, line: u64, read: &Motion, part: &Part) -> Result<(), Fault> {
        let [first, second] = self.machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
        let [x, y, z] = part.words.linear_mm;
        let [a, b] = part.words.rotary_deg;
        let wanted = [('X', x), ('Y', y), ('Z', z), (first, a), (second, b)];
        let wanted = wanted.into_iter().zip(part.coordinates).filter(|(_, is_stated)| *is_stated);
        let wanted = wanted.map(|((letter, value), _)| (Some(letter), value));
        let stated = self.read_back.coordinates_read();
        let stated = stated.map(|word| (word.address.letter().map(char::from), word.value));
        if !wanted.eq(stated) || read.start.is_some() || read.end.is_some() != part.is_last {
            return Err(failed(line, "the first approach moves other axes than it should"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::{Setup, ToolPose};
    use crate::machine::Preset;

    fn tables() -> Machine {
        Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap()
    }

    /// Two points with words between and after them, read back as `text`.
    fn read_back(text: &str) -> Result<(), Fault> {
        let (machine, parameters) =
            (tables(), PostParameters::new(ProgramSetup::in_mm(&crate::kinematics::Setup::default())));
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let mut again = PostedAgain::new(&machine, &kinematics, &parameters);
        again.await_words("H1");
        again.await_words("S1200 M3");
        for (line, x_mm) in [(1, 0.0), (2, 10.0)] {
            let pose = ToolPose { tip_mm: Vec3::new(x_mm, 0.0, 5.0), axis: Vec3::z() };
            let point = ClPoint { line, rapid: true, pose, from_mm: None, feed: None, on: None };
            again.await_next(ExpectedPoint { point, feed: None, residual_rad: 0.0, part: None });
            again.await_words("G4 P250");
        }
        again.await_words("M30");
        again.take(text.as_bytes())?;
        again.finish()
    }

    /// The first approach to X10 Y20 Z5 A30 C40 under tool-centre-point control, read back as `text`.
    fn approach(text: &str) -> Result<(), Fault> {
        let (machine, parameters) = (tables(), PostParameters::new(ProgramSetup::default()));
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let words = AxisWords { linear_mm: [10.0, 20.0, 5.0], rotary_deg: [30.0, 40.0] };
        let pose = Station::new(&machine, &kinematics, Interpolation::Tcp, words).pose;
        let point = ClPoint { line: 1, rapid: true, pose, from_mm: None, feed: None, on: None };
        let mut again = PostedAgain::new(&machine, &kinematics, &parameters);
        for (index, stated) in ["AC", "XY", "Z"].into_iter().enumerate() {
            let coordinates = ["X", "Y", "Z", "A", "C"].map(|letter| stated.contains(letter));
            let part = Some(Part { words, coordinates, is_first: index == 0, is_last: index == 2 });
            again.await_next(ExpectedPoint { point, feed: None, residual_rad: 0.0, part });
            if index == 0 {
                again.await_words("H1");
            }
        }
        again.take(text.as_bytes())?;
        again.finish()
    }

    #[test]
    fn the_first_approach_is_what_was_meant_and_nothing_else() {
        let sound = "G21 G17 G90 G94\nG0 A30 C40\nG43.4 H1\nX10 Y20\nZ5\n";
        assert_eq!(approach(sound).map_err(|fault| fault.to_string()), Ok(()));
        for (from, to) in [
            ("G0 A30 C40", "G0 X10 A30 C40"),
            ("G0 A30 C40", "G0 A30"),
            ("G0 A30 C40", "G0 A30 C41"),
            ("G0 A30 C40", "G1 A30 C40 F100"),
            ("G0 A30 C40\nG43.4 H1", "G43.4 H1\nG0 A30 C40"),
            ("G43.4 H1\n", ""),
            ("G43.4 H1\n", "G43.4 H2\n"),
            ("X10 Y20\nZ5", "Z5\nX10 Y20"),
            ("X10 Y20\nZ5", "X10 Y20 Z5"),
            ("X10 Y20\nZ5", "X10 Y20\nZ6"),
            ("X10 Y20\nZ5", "X10 Y21\nZ5"),
            ("X10 Y20\nZ5", "X10 Y20 A30\nZ5"),
            ("X10 Y20\nZ5", "G91 X10 Y20\nG90 Z5"),
        ] {
            assert!(sound.contains(from));
            assert!(approach(&sound.replacen(from, to, 1)).is_err(), "{to}");
        }
    }

    #[test]
    fn no_word_for_the_machine_is_lost_doubled_moved_or_changed() {
        let [spindle, first, dwell] = ["S1200 M3\n", "G0 X0 Y0 Z5 A0 C0\n", "G4 P250\n"];
        let head = "%\nG21 G17 G90 G40 G80 G94\nG54\nG43.4 H1\n";
        let second = "X10 Y0 Z5 A0 C0\n";
        let program = |lines: &[&str]| format!("{head}{}G49\nM30\n%\n", lines.concat());
        let found = read_back(&program(&[spindle, first, dwell, second, dwell]));
        assert_eq!(found.map_err(|fault| fault.to_string()), Ok(()));
        for wrong in [
            &[spindle, first, second, dwell][..],
            &[spindle, first, dwell, second],
            &[first, dwell, second, dwell],
            &[spindle, first, dwell, dwell, second],
            &[spindle, first, dwell, second, dwell, dwell],
            &[first, spindle, dwell, second, dwell],
            &["S1200 M4\n", first, dwell, second, dwell],
            &["S120 M3\n", first, dwell, second, dwell],
            &[spindle, first, "G4 P25\n", second, dwell],
            &[spindle, first, "M1\n", dwell, second, dwell],
        ] {
            assert!(read_back(&program(wrong)).is_err(), "{wrong:?}");
        }
    }
}
