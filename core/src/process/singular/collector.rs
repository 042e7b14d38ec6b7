//! Decides which consecutive motions make a region.

use std::sync::Arc;

use super::contact::Cutting;
use super::pending::{Pending, StatedAxes};
use super::words::POINT;
use crate::contact::{Station, rotary_rad};
use crate::kinematics::SingularZone;
use crate::machine::Tool;
use crate::motion::{AxisWords, ContactWords, Interpolation, Motion, MotionKind, rotary_addresses};
use crate::process::fault::LineFaults;
use crate::process::set_up::{SetUps, may_roll_over};
use crate::program::{Address, Batch, Dialect, WordForm};

/// Rotary words that differ by less are the same \[deg\].
const TURNING_DEG: f64 = 1e-9;
/// The number of consecutive motions without a turn that may be in a region.
const MAX_QUIET: usize = 8;
/// A region is cut after this number of motions. The point between its two pieces is left unchanged.
pub(super) const MAX_MOTIONS: usize = 2000;

/// The effect of a motion on the current region.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seen {
    /// The motion belongs to the region.
    Added,
    /// The motion does not belong to the region, which is now complete.
    Closes,
}

/// Collects the motions of the current region.
#[derive(Debug)]
pub(super) struct Collector<'a> {
    cutting: Cutting<'a>,
    set_ups: SetUps,
    zone: SingularZone,
    dialect: Dialect,
    region: Vec<Pending>,
    quiet: usize,
    /// The last point, by its words, mode and contact.
    last: Option<(AxisWords, Interpolation, ContactWords)>,
    /// The last contact words stated.
    stated: ContactWords,
    pub(super) checked: u64,
    /// Motions whose path depends on a missing value.
    pub(super) faults: LineFaults,
}

impl<'a> Collector<'a> {
    pub(super) fn new(cutting: Cutting<'a>, zone: SingularZone, dialect: Dialect) -> Self {
        Self {
            set_ups: SetUps::new(cutting.machine, &cutting.parameters.program),
            faults: LineFaults::default(),
            cutting,
            zone,
            dialect,
            region: Vec::new(),
            quiet: 0,
            last: None,
            stated: ContactWords::None,
            checked: 0,
        }
    }

    pub(super) fn is_open(&self) -> bool {
        !self.region.is_empty()
    }

    pub(super) fn is_full(&self) -> bool {
        self.region.len() >= MAX_MOTIONS
    }

    /// Returns the region so far, without the motions at its end that do not turn. The collector is then empty.
    pub(super) fn take(&mut self) -> Vec<Pending> {
        let mut region = std::mem::take(&mut self.region);
        region.truncate(region.len() - self.quiet.min(region.len()));
        self.quiet = 0;
        region
    }

    /// Takes all these motions at once, if no region is open and a bound shows that none of them makes one. Otherwise
    /// returns false, and takes none.
    ///
    /// Most passages of most programs are far from every singularity. One bound for all their motions costs less than
    /// one for each of them.
    pub(super) fn pass_by(&mut self, batch: &Batch, motions: &[Motion]) -> bool {
        if self.is_open() || !motions.iter().all(|motion| self.set_ups.is_entered(motion)) {
            return false;
        }
        let Some(turning) = Turning::of(motions) else { return false };
        let machine = self.cutting.machine;
        // The words of a reversed axis fall where its angle rises.
        let [a, b] = turning.range.map(|words| rotary_rad(machine, words));
        let ranges = [[a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]];
        let turns_rad = turning.turn.map(f64::to_radians);
        if !self.set_ups.now.kinematics.all_stay_outside(&self.zone, ranges, turns_rad) {
            return false;
        }
        for motion in motions {
            self.count(batch, motion);
        }
        true
    }

    /// Takes the next motion. If the motion closes the region, it must be passed again after [`Collector::take`].
    pub(super) fn see(&mut self, batch: &Batch, motion: &Motion, index: u64) -> Seen {
        let mode = motion.mode(self.cutting.parameters.program.interpolation);
        self.set_ups.enter(motion);
        let found = self.pending(batch, motion, index, mode);
        if self.is_open() && found.is_none() {
            return Seen::Closes;
        }
        self.count(batch, motion);
        let Some(found) = found else { return Seen::Closes };
        self.quiet = if found.turns { 0 } else { self.quiet + 1 };
        self.region.push(found);
        Seen::Added
    }

    /// Notes what later motions and the report need of a motion.
    #[inline]
    fn count(&mut self, batch: &Batch, motion: &Motion) {
        let mode = motion.mode(self.cutting.parameters.program.interpolation);
        if motion.contact != ContactWords::None || motion.kind == MotionKind::Opaque {
            self.stated = motion.contact;
        }
        let rests = motion.start.is_some() && motion.start == motion.end;
        let stays = rests && motion.contact == ContactWords::None;
        if !stays {
            self.last = motion.end.map(|end| (end, mode, motion.contact));
        }
        if self.follows(motion) {
            self.checked += 1;
            if let Some(kind) = self.set_ups.now.missing_for_turning(mode, motion) {
                let block = batch.blocks().get(motion.block as usize);
                self.faults.add(motion.line, block.map_or(&[][..], |block| batch.block_text(block)), kind);
            }
        }
    }

    fn follows(&self, motion: &Motion) -> bool {
        is_followed(motion)
            && !may_roll_over(self.cutting.machine, self.dialect, motion)
            && !self.set_ups.now.is_foreign()
    }

    fn tool(&self) -> Tool {
        self.set_ups.now.cutter().unwrap_or(Tool::UNIT_BALL)
    }

    /// The motion, if it belongs to a region and, if a region is open, to that region.
    fn pending(&self, batch: &Batch, motion: &Motion, index: u64, mode: Interpolation) -> Option<Pending> {
        if !self.follows(motion) {
            return None;
        }
        let (start, end) = (motion.start?, motion.end?);
        let turns =
            start.rotary_deg.iter().zip(&end.rotary_deg).any(|(from, to)| (to - from).abs() > TURNING_DEG);
        let before = self.region.last();
        let goes_on = before.is_some_and(|before| {
            let same_unit = before.motion.mm_per_unit.to_bits() == motion.mm_per_unit.to_bits();
            let same_set_up = Arc::ptr_eq(&before.kinematics, &self.set_ups.now.kinematics);
            let goes_on = before.ends[1].words == start && before.mode == mode;
            goes_on && same_unit && same_set_up && before.tool == self.tool()
        });
        if before.is_some() && !goes_on || !turns && (before.is_none() || self.quiet >= MAX_QUIET) {
            return None;
        }
        let (machine, kinematics) = (self.cutting.machine, &self.set_ups.now.kinematics);
        let angles = [&start, &end].map(|words| rotary_rad(machine, words.rotary_deg));
        if kinematics.stays_outside(&self.zone, angles) {
            return None;
        }
        let station = |words| Station::new(machine, kinematics, mode, words);
        let ends = [before.map_or_else(|| station(start), |before| before.ends[1]), station(end)];
        let polar_rad = kinematics.polar_range_rad(angles, ends.map(|end| end.pose.axis));
        if !self.zone.is_entered(polar_rad) {
            return None;
        }
        let (axes, contact) = self.stated_in(batch, motion);
        let start_contact = self.last.filter(|last| last.0 == start && last.1 == mode);
        let start_contact = start_contact.map_or(ContactWords::None, |(_, _, contact)| contact);
        let standing = if start_contact == ContactWords::None { self.stated } else { start_contact };
        Some(Pending {
            motion: *motion,
            kinematics: Arc::clone(kinematics),
            tool: self.tool(),
            is_stated: self.set_ups.now.is_stated(),
            index,
            mode,
            ends,
            start_contact,
            standing,
            axes,
            contact,
            polar_rad,
            turns,
        })
    }

    /// How the block of this motion states axes and contact.
    fn stated_in(&self, batch: &Batch, motion: &Motion) -> ([StatedAxes; 5], [bool; 3]) {
        let rotary = rotary_addresses(self.cutting.machine);
        let addresses = [Address::X, Address::Y, Address::Z, rotary[0], rotary[1]];
        let (mut axes, mut contact) = ([StatedAxes::Absent; 5], [false; 3]);
        let block = batch.blocks().get(motion.block as usize);
        for word in block.map_or(&[][..], |block| batch.words(block)) {
            if let Some(k) = addresses.iter().position(|address| *address == word.address) {
                let modal = if motion.incremental { StatedAxes::Incremental } else { StatedAxes::Absolute };
                axes[k] = match word.form {
                    WordForm::Absolute => StatedAxes::Absolute,
                    WordForm::Incremental => StatedAxes::Incremental,
                    WordForm::Number | WordForm::Evaluated => modal,
                    WordForm::Comma | WordForm::Expression | WordForm::Name | WordForm::Keyword => axes[k],
                };
            }
            if let Some(k) = POINT.iter().position(|address| *address == word.address) {
                contact[k] = true;
            }
        }
        (axes, contact)
    }
}

/// The rotary words in some motions \[deg\].
struct Turning {
    /// The smallest and the largest words at an end.
    range: [[f64; 2]; 2],
    /// The largest turn of each axis within one motion.
    turn: [f64; 2],
}

impl Turning {
    /// `None` if no motion has known ends.
    fn of(motions: &[Motion]) -> Option<Self> {
        let [mut least, mut most, mut turn] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2], [0.0_f64; 2]];
        for motion in motions {
            let (Some(start), Some(end)) = (&motion.start, &motion.end) else { continue };
            for k in [0, 1] {
                let (from, to) = (start.rotary_deg[k], end.rotary_deg[k]);
                least[k] = least[k].min(from.min(to));
                most[k] = most[k].max(from.max(to));
                turn[k] = turn[k].max((to - from).abs());
            }
        }
        least[0].is_finite().then_some(Self { range: [least, most], turn })
    }
}

/// Whether this is a straight motion at feed between known ends that are different.
fn is_followed(motion: &Motion) -> bool {
    motion.kind == MotionKind::Linear
        && motion.unfollowable.is_none()
        && !motion.offset_changed
        && motion.start.is_some()
        && motion.end.is_some()
        && motion.start != motion.end
}
