//! The posted program read back as a control would read it, point by point against the source.

use std::collections::VecDeque;

use super::super::ProgramSetup;
use super::points::Point;
use super::{PostForm, PostParameters};
use crate::contact::Station;
use crate::geometry::angle_between;
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::motion::{Interpolation, Motion, MotionKind};
use crate::process::Fault;
use crate::process::read_back::{Awaited, MachineWord, ReadBack, failed};
use crate::program::{Address, Dialect};

/// Beyond the rounding of the words nothing may be lost [mm, rad].
const ARITHMETIC: f64 = 1e-6;

/// What the next motion has to be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    pub(super) point: Point,
    /// F as written.
    pub(super) feed: Option<f64>,
    /// How far the axes at best miss the point's axis \[rad\].
    pub(super) residual_rad: f64,
}

impl Awaited for Expected {
    fn line(&self) -> u64 {
        self.point.line
    }

    fn missing(&self) -> &'static str {
        "a motion is missing"
    }
}

/// Reads what is written and measures how far it is off.
pub(super) struct PostedAgain<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    read_back: ReadBack<Expected>,
    /// Words for the machine that have to come next.
    words: VecDeque<MachineWord>,
    /// Points that were written.
    points: u64,
    mode: Interpolation,
    tip_mm: f64,
    axis_rad: f64,
    pub(super) largest_tip_mm: f64,
    pub(super) largest_axis_rad: f64,
}

impl<'a> PostedAgain<'a> {
    pub(super) fn new(machine: &'a Machine, kinematics: &'a Kinematics, parameters: &PostParameters) -> Self {
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
            // Three linear words, and two rotary ones, each off by half its last digit.
            tip_mm: 3_f64.sqrt() * half(parameters.linear_decimals) + ARITHMETIC,
            axis_rad: 2.0 * half(parameters.rotary_decimals).to_radians() + ARITHMETIC,
            largest_tip_mm: 0.0,
            largest_axis_rad: 0.0,
        }
    }

    pub(super) fn await_next(&mut self, next: Expected) {
        self.read_back.await_next(next);
        self.points += 1;
    }

    /// These words for the machine, parted by blanks, come next.
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
                return Err(failed(0, "a word for the machine is missing, one too many or elsewhere"));
            }
        }
        // What is written here has nothing in it that a reader could wonder at.
        self.read_back.has_no_warning()
    }

    fn check(&mut self, read: &Motion, next: &Expected) -> Result<(), Fault> {
        let line = next.point.line;
        let kind = if next.point.rapid { MotionKind::Rapid } else { MotionKind::Linear };
        let Some(words) = read.end else { return Err(failed(line, "a point has no known end")) };
        if read.kind != kind || read.unfollowable.is_some() || read.interpolation != self.mode {
            return Err(failed(line, "a point is reached by another kind of motion"));
        }
        if !next.point.rapid && next.feed != read.feed.value {
            return Err(failed(line, "a point is reached at another feed"));
        }
        let pose = Station::new(self.machine, self.kinematics, self.mode, words).pose;
        let tip_mm = (pose.tip_mm - next.point.pose.tip_mm).norm();
        let axis_rad = angle_between(pose.axis, next.point.pose.axis);
        self.largest_tip_mm = self.largest_tip_mm.max(tip_mm);
        self.largest_axis_rad = self.largest_axis_rad.max(axis_rad);
        if !(tip_mm <= self.tip_mm && axis_rad <= self.axis_rad + next.residual_rad) {
            return Err(failed(line, "a point stands elsewhere than in the source"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec3;
    use crate::kinematics::{Setup, ToolPose};
    use crate::machine::Preset;

    fn tables() -> Machine {
        Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap()
    }

    /// Two points with words between and behind them, read back as `text`.
    fn read_back(text: &str) -> Result<(), Fault> {
        let (machine, parameters) =
            (tables(), PostParameters::new(ProgramSetup::in_mm(&crate::kinematics::Setup::default())));
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let mut again = PostedAgain::new(&machine, &kinematics, &parameters);
        again.await_words("S1200 M3");
        for (line, x_mm) in [(1, 0.0), (2, 10.0)] {
            let pose = ToolPose { tip_mm: Vec3::new(x_mm, 0.0, 5.0), axis: Vec3::z() };
            let point = Point { line, rapid: true, pose, from_mm: None, feed: None };
            again.await_next(Expected { point, feed: None, residual_rad: 0.0 });
            again.await_words("G4 P250");
        }
        again.await_words("M30");
        again.take(text.as_bytes())?;
        again.finish()
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
