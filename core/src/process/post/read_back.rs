//! The posted program read back as a control would read it, point by point against the source.

use std::collections::VecDeque;

use super::points::Point;
use super::{PostForm, PostParameters};
use crate::contact::Station;
use crate::geometry::angle_between;
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::motion::{Interpolation, Interpreter, InterpreterOptions, Motion, MotionKind};
use crate::process::Fault;
use crate::process::read_back::failed;
use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader, Severity};

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

/// Reads what is written and measures how far it is off.
pub(super) struct ReadBack<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    reader: Reader,
    interpreter: Interpreter,
    batch: Batch,
    motions: Vec<Motion>,
    expected: VecDeque<Expected>,
    mode: Interpolation,
    tip_mm: f64,
    axis_rad: f64,
    pub(super) largest_tip_mm: f64,
    pub(super) largest_axis_rad: f64,
}

impl<'a> ReadBack<'a> {
    pub(super) fn new(machine: &'a Machine, kinematics: &'a Kinematics, parameters: &PostParameters) -> Self {
        let half = |decimals: u8| 0.5 / 10_f64.powi(i32::from(decimals));
        Self {
            machine,
            kinematics,
            reader: Reader::new(Some(Dialect::Iso), ReadLimits::default()),
            interpreter: Interpreter::new(machine, InterpreterOptions::default()),
            batch: Batch::new(),
            motions: Vec::new(),
            expected: VecDeque::new(),
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
        self.expected.push_back(next);
    }

    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.reader.feed(bytes);
        self.read()
    }

    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        self.reader.finish();
        self.read()?;
        match self.expected.front() {
            Some(next) => Err(failed(next.point.line, "a motion is missing")),
            None => Ok(()),
        }
    }

    fn read(&mut self) -> Result<(), Fault> {
        while self.reader.next_batch(&mut self.batch)? {
            let mut diagnostics = Diagnostics::new();
            self.motions.clear();
            self.interpreter.interpret(&mut self.batch, &mut self.motions, &mut diagnostics);
            let line = self.expected.front().map_or(0, |next| next.point.line);
            if diagnostics.count(Severity::Refusal) + diagnostics.count(Severity::Warning) > 0 {
                return Err(failed(line, "the written program is not readable"));
            }
            for motion in std::mem::take(&mut self.motions) {
                let next = self.expected.pop_front().ok_or(failed(motion.line, "a motion too many"))?;
                self.check(&motion, &next)?;
            }
        }
        Ok(())
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
