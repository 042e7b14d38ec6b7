//! The written program read back as a control would read it: every motion against what was planned, and the worn
//! cutter's contact against the nominal one's, from the words that were read.

use std::collections::VecDeque;

use super::super::inventory::Inventory;
use super::super::report::DeviationTotals;
use super::super::verify::{Meaning, failed};
use super::super::{Fault, Series, SeriesPoint};
use super::course::Point;
use super::parameters::WearParameters;
use crate::contact::{Sampled, Station};
use crate::geometry::Vec3;
use crate::kinematics::Kinematics;
use crate::machine::{Machine, Tool};
use crate::motion::{Interpreter, InterpreterOptions, Motion, MotionKind};
use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader, Severity};

/// Half a unit of the last decimal on three axes, which squareness errors stretch a little.
const ROUNDING: f64 = 1.732_050_808 * 1.1;
/// Arithmetic of inches and increments \[mm\].
const ARITHMETIC_MM: f64 = 1e-7;

/// What the next motion of the written program has to be.
#[derive(Debug)]
pub(super) struct Expected {
    /// The source's motion with the ends, the contact words and the F that were planned.
    pub(super) motion: Motion,
    /// Its rotary words are the source's to the bit.
    pub(super) point: Option<Point>,
    /// Half a unit of the last decimal \[mm\].
    pub(super) half_mm: f64,
}

/// Reads the output back and sums up what it leaves.
pub(super) struct WearVerifier<'a> {
    machine: &'a Machine,
    parameters: &'a WearParameters,
    written: &'a Kinematics,
    actual: Tool,
    reader: Reader,
    interpreter: Interpreter,
    batch: Batch,
    motions: Vec<Motion>,
    diagnostics: Diagnostics,
    expected: VecDeque<Expected>,
    /// The last contact of the source, where a motion at feed may go on from it.
    contact_mm: Option<Vec3>,
    pub(super) before: DeviationTotals,
    pub(super) after: DeviationTotals,
    pub(super) series: Series,
    pub(super) inventory: Inventory,
}

impl<'a> WearVerifier<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        parameters: &'a WearParameters,
        written: &'a Kinematics,
        dialect: Dialect,
        options: InterpreterOptions,
    ) -> Self {
        Self {
            machine,
            parameters,
            written,
            actual: parameters.cutter_wear().actual,
            reader: Reader::new(Some(dialect), ReadLimits::default()),
            interpreter: Interpreter::new(machine, options),
            batch: Batch::new(),
            motions: Vec::new(),
            diagnostics: Diagnostics::new(),
            expected: VecDeque::new(),
            contact_mm: None,
            before: DeviationTotals::default(),
            after: DeviationTotals::default(),
            series: Series::default(),
            inventory: Inventory::default(),
        }
    }

    /// What has to come next, in the order written.
    pub(super) fn await_next(&mut self, next: Expected) {
        self.expected.push_back(next);
    }

    /// Reads these bytes of the output.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.reader.feed(bytes);
        self.read()
    }

    /// Forgets what was to come: the program is refused.
    pub(super) fn abandon(&mut self) {
        self.expected.clear();
    }

    /// The output has ended: everything expected must have come, and nothing of the source be lost or doubled.
    pub(super) fn finish(&mut self, source: &Inventory) -> Result<(), Fault> {
        self.reader.finish();
        self.read()?;
        if let Some(missing) = self.expected.front() {
            return Err(failed(missing.motion.line, "a motion is missing"));
        }
        if !source.is_kept_by(&self.inventory) {
            return Err(failed(0, "blocks or words that are not to be changed were lost or doubled"));
        }
        Ok(())
    }

    fn read(&mut self) -> Result<(), Fault> {
        while self.reader.next_batch(&mut self.batch)? {
            self.inventory.see(&self.batch);
            self.motions.clear();
            self.interpreter.interpret(&self.batch, &mut self.motions, &mut self.diagnostics);
            if self.diagnostics.count(Severity::Refusal) > 0 {
                let line = self.expected.front().map_or(0, |next| next.motion.line);
                return Err(failed(line, "the written program is not readable"));
            }
            for index in 0..self.motions.len() {
                let motion = self.motions[index];
                let next = self.expected.pop_front().ok_or(failed(motion.line, "a motion too many"))?;
                self.check(&motion, &next)?;
            }
        }
        Ok(())
    }

    fn check(&mut self, read: &Motion, next: &Expected) -> Result<(), Fault> {
        let line = next.motion.line;
        Meaning::of(&next.motion).check(read)?;
        let rotary = |motion: &Motion| motion.end.map(|words| words.rotary_deg);
        if rotary(read) != rotary(&next.motion) {
            return Err(failed(line, "a rotary word changed"));
        }
        let (Some(point), Some(words)) = (&next.point, read.end) else {
            self.contact_mm = self.contact_mm.filter(|_| read.end.is_some());
            return Ok(());
        };
        let mode = self.parameters.interpolation.unwrap_or(read.interpolation);
        let mut pose = Station::new(self.machine, self.written, mode, words).pose;
        // Where the control believes in the nominal length, the worn tip stands ΔL behind.
        pose.tip_mm += pose.axis * self.parameters.unknown_to_control().mm();
        let hold = &point.contact.hold;
        let off_mm = hold.residual_mm(&self.parameters.nominal, &self.actual, &point.pose, &pose);
        let limit_mm = ROUNDING * next.half_mm + ARITHMETIC_MM;
        if off_mm.norm().is_nan() || off_mm.norm() > limit_mm {
            return Err(failed(line, "the worn cutter's contact is elsewhere"));
        }
        if !point.has_contact {
            self.contact_mm = None;
            return Ok(());
        }
        let contact_mm = point.pose.tip_mm + hold.offset_mm(&self.parameters.nominal, point.pose.axis);
        let from_mm = self.contact_mm.filter(|_| read.kind != MotionKind::Rapid).unwrap_or(contact_mm);
        let normal = hold.normal(point.pose.axis);
        let left_mm = -point.contact.shift_mm.dot(&normal);
        let path_mm = (contact_mm - from_mm).norm();
        self.contact_mm = Some(contact_mm);
        self.record(
            line,
            path_mm,
            &sampled(left_mm.abs(), left_mm),
            &sampled(off_mm.norm(), off_mm.dot(&normal)),
        );
        Ok(())
    }

    fn record(&mut self, line: u64, path_mm: f64, before: &Sampled, after: &Sampled) {
        self.before.add(line, path_mm, before);
        self.after.add(line, path_mm, after);
        let (path_mm, before_mm, after_mm) = (self.before.path_mm(), before.max_mm, after.max_mm);
        self.series.push(SeriesPoint { path_mm, line, before_mm, after_mm });
    }
}

/// One place's distance, and its part along the normal.
fn sampled(distance_mm: f64, along_mm: f64) -> Sampled {
    Sampled {
        max_mm: distance_mm,
        mean_square_mm2: distance_mm * distance_mm,
        max_excess_mm: along_mm.max(0.0),
        max_gouge_mm: (-along_mm).max(0.0),
        evaluations: 1,
    }
}
