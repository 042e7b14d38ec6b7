//! The posted program read back as a control would read it, point by point against the source.

use super::points::Point;
use super::{PostForm, PostParameters};
use crate::contact::Station;
use crate::geometry::angle_between;
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::motion::{Interpolation, InterpreterOptions, Motion, MotionKind};
use crate::process::Fault;
use crate::process::read_back::{Awaited, ReadBack, failed};
use crate::program::Dialect;

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
            read_back: ReadBack::new(machine, Dialect::Iso, InterpreterOptions::default()),
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
    }

    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.read_back.feed(bytes);
        self.read()
    }

    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        self.read_back.end();
        self.read()?;
        self.read_back.has_all()
    }

    fn read(&mut self) -> Result<(), Fault> {
        while let Some((motion, next)) = self.read_back.next()? {
            self.check(&motion, &next)?;
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
