//! Decides into which parts a block over tolerance is divided.

use super::contact_finder;
use super::contact_finder::ContactFinder;
use super::parameters::OutputForm;
use crate::contact::{
    BlockTime, Carry, Correction, CutterContact, Effort, Node, Resolution, Segment, SourceBlock,
    block_time_s, divide, feed_direction, nodes, prove, segments, within_tolerance,
};
use crate::machine::Machine;
use crate::motion::{ContactWords, FeedMode, Motion};
use crate::process::divided::{Checked, Division, node_contact, resolution, unfit_feed};
use crate::process::fault::LineFaultKind;
use crate::process::pipeline::{FeedInTime, MIN_FEED};
use crate::process::text::Survey;
use crate::units::UM_PER_MM;

/// Plans leave this share of the tolerance free, so that errors of sampling and rounding cannot exceed the tolerance.
const RESERVE: f64 = 2e-4;
/// Largest number of parts of one block: two hundred seconds of two-millisecond steps.
const MAX_PARTS: f64 = 100_000.0;

/// The plan for a block over tolerance.
pub(in crate::process) enum DivisionPlan {
    /// It is divided.
    Divide(Division),
    /// It is left unchanged, because a part would need more feed than is allowed.
    TooFast,
    /// It is left unchanged, because its parts would have other contacts than the block and would again be over the
    /// tolerance.
    Unsettled,
}

/// Plans the division of a block over tolerance. The plan is meaningless if the effort has ended afterwards.
///
/// # Errors
/// The fault of the line.
pub(in crate::process) fn plan(
    finder: &ContactFinder<'_>,
    machine: &Machine,
    survey: Survey,
    checked: &Checked<'_>,
    motion: &Motion,
    effort: &mut Effort<'_>,
) -> Result<DivisionPlan, LineFaultKind> {
    if motion.feed.mode == Some(FeedMode::InverseTime) && motion.feed.value.is_none() {
        return Err(LineFaultKind::NoInverseTime);
    }
    if motion.extra.is_some_and(|extra| extra.start.is_none()) {
        return Err(LineFaultKind::ExtraUnknown);
    }
    let parameters = finder.parameters;
    let tolerance_mm = parameters.tolerance.mm();
    let own = resolution(checked, motion, motion.decimals.linear, motion.decimals.rotary);
    // Postprocessors strip trailing zeros. If the block's own decimals are too coarse, the finest of the program are
    // used.
    let finest = resolution(
        checked,
        motion,
        motion.decimals.linear.max(survey.linear_decimals),
        motion.decimals.rotary.max(survey.rotary_decimals),
    );
    let (mut reachable_mm, mut is_unsettled) = (f64::INFINITY, false);
    let tries: &[Resolution] = if own == finest { &[own] } else { &[own, finest] };
    for resolution in tries {
        match divided(finder, machine, checked, motion, resolution, effort)? {
            Divided::Unsettled => is_unsettled = true,
            Divided::At(nodes) => {
                let carries_feed = motion.feed.value.is_some() && survey.has_feed_column;
                if carries_feed {
                    match unfit_feed(checked, motion, &nodes, parameters.max_feed) {
                        None | Some(FeedInTime::Fits(_)) => {}
                        Some(FeedInTime::TooHigh(_)) => return Ok(DivisionPlan::TooFast),
                        Some(FeedInTime::TooLow(feed)) => {
                            return Err(LineFaultKind::FeedTooSmall { feed, min: MIN_FEED });
                        }
                    }
                }
                return Ok(DivisionPlan::Divide(Division { nodes, resolution: *resolution, carries_feed }));
            }
            Divided::OutOfReach { least_mm } => reachable_mm = reachable_mm.min(least_mm),
        }
    }
    if is_unsettled {
        return Ok(DivisionPlan::Unsettled);
    }
    Err(LineFaultKind::ToleranceOutOfReach {
        reachable_um: reachable_mm * UM_PER_MM,
        tolerance_um: tolerance_mm * UM_PER_MM,
    })
}

/// The result of an attempt to divide a block.
enum Divided {
    /// Its parts end here.
    At(Vec<Node>),
    /// Its parts would keep the block's own line of contacts. They would not keep the line of the contacts that a
    /// second compensation would find for them.
    Unsettled,
    /// No division keeps the block's line of contacts.
    OutOfReach {
        /// The smallest deviation that can be reached.
        least_mm: f64,
    },
}

impl From<Result<Vec<Node>, f64>> for Divided {
    fn from(found: Result<Vec<Node>, f64>) -> Self {
        found.map_or_else(|least_mm| Self::OutOfReach { least_mm }, Self::At)
    }
}

fn divided(
    finder: &ContactFinder<'_>,
    machine: &Machine,
    checked: &Checked<'_>,
    motion: &Motion,
    resolution: &Resolution,
    effort: &mut Effort<'_>,
) -> Result<Divided, LineFaultKind> {
    let parameters = finder.parameters;
    let (block, correction) = (&checked.block, parameters.correction);
    let within_mm = parameters.tolerance.mm() * (1.0 - RESERVE);
    Ok(match parameters.output {
        OutputForm::Minimal if correction == Correction::Seed => {
            let ratio = checked.before.max_mm / parameters.tolerance.mm();
            Divided::At(nodes(block, correction, count(ratio.sqrt())?, resolution, effort))
        }
        OutputForm::Minimal => {
            let sizes_mm = [checked.before.max_mm, within_mm];
            let again = Again { finder, checked, motion, within_mm };
            let first = divide(block, correction, sizes_mm, resolution, effort, |nodes, effort| {
                prove(block, nodes, within_mm, effort)?;
                again.prove(nodes, effort)
            });
            if let Ok(nodes) = first {
                return Ok(Divided::At(nodes));
            }
            let own = divide(block, correction, sizes_mm, resolution, effort, |nodes, effort| {
                prove(block, nodes, within_mm, effort)
            });
            own.map_or_else(|least_mm| Divided::OutOfReach { least_mm }, |_| Divided::Unsettled)
        }
        OutputForm::Interpolated => {
            let parts = interpolation_steps(machine, checked, motion)?;
            let nodes = nodes(block, correction, parts, resolution, effort);
            if correction == Correction::Seed {
                Divided::At(nodes)
            } else {
                prove(block, &nodes, within_mm, effort).map(|()| nodes).into()
            }
        }
    })
}

/// Checks the parts of a block as the blocks of a program that is compensated a second time. They must then be left
/// unchanged.
struct Again<'p, 'a> {
    finder: &'p ContactFinder<'p>,
    checked: &'p Checked<'a>,
    motion: &'p Motion,
    within_mm: f64,
}

impl Again<'_, '_> {
    /// Proves that each part keeps the tolerance to the line between its own contacts.
    ///
    /// # Errors
    /// The largest deviation found. Also fails if the effort has ended.
    fn prove(&self, nodes: &[Node], effort: &mut Effort<'_>) -> Result<(), f64> {
        let block = &self.checked.block;
        let mut start = Some(self.checked.contacts[0]);
        for (index, segment) in segments(block, nodes).enumerate() {
            effort.pass(1);
            if effort.is_over() {
                return Err(f64::INFINITY);
            }
            let end = if index + 1 == nodes.len() {
                Some(self.checked.contacts[1])
            } else {
                self.contact_at(&nodes[index], effort)?
            };
            let contacts = if self.finder.assumes() {
                Some(self.assumed(&segment))
            } else {
                start.zip(end).map(|(start, end)| [start, end])
            };
            // A motion without a contact is not checked.
            if let Some(contacts) = contacts {
                self.prove_part(&segment, &contacts, effort)?;
            }
            start = end;
        }
        Ok(())
    }

    fn prove_part(
        &self,
        segment: &Segment,
        contacts: &[CutterContact; 2],
        effort: &mut Effort<'_>,
    ) -> Result<(), f64> {
        let block = &self.checked.block;
        let axes = segment.ends.map(|end| end.pose.axis);
        let carry = Carry::between(&block.tool, [&contacts[0], &contacts[1]], axes);
        let part =
            SourceBlock::new(block.machine, &block.kinematics, block.tool, block.mode, segment.ends, carry);
        let found = within_tolerance(&part, &part.whole(), self.within_mm);
        let (Ok(sampled) | Err(sampled)) = found;
        effort.spend(sampled.evaluations);
        found.map(|_| ()).map_err(|sampled| sampled.max_mm)
    }

    /// The contact that a second compensation will find at a node, from its words as written.
    fn contact_at(&self, node: &Node, effort: &mut Effort<'_>) -> Result<Option<CutterContact>, f64> {
        let block = &self.checked.block;
        let words = node_contact(self.checked, self.motion, node).unwrap_or(ContactWords::None);
        let (kinematics, station) = (&block.kinematics, &node.station);
        let found = self.finder.find(kinematics, &block.tool, station, block.mode, words, effort);
        // An impossible contact would refuse the program.
        let touch = found.map_err(|_fault| f64::INFINITY)?;
        Ok(touch.map(|touch| touch.contact))
    }

    /// The contacts that a second compensation will assume at the ends of a part.
    fn assumed(&self, segment: &Segment) -> [CutterContact; 2] {
        let [start, end] = &segment.ends;
        let own = feed_direction(&self.checked.block.tool, [&start.pose, &end.pose]);
        let touches = contact_finder::assumed([start, end], own.or(self.checked.pass_feed));
        touches.map_or([CutterContact::Tip; 2], |touches| touches.map(|touch| touch.contact))
    }
}

/// P0's `n = max(1, ⌈τ/T⌉)`.
fn interpolation_steps(
    machine: &Machine,
    checked: &Checked<'_>,
    motion: &Motion,
) -> Result<u32, LineFaultKind> {
    let time = BlockTime::of(&checked.block, &checked.block.whole(), motion.mm_per_unit, motion.feed.paths);
    let (Some(mode), Some(_)) = (motion.feed.mode, motion.feed.value) else {
        return Err(LineFaultKind::NoFeed);
    };
    let tau_s = block_time_s(mode, motion.feed.raw, &time).ok_or(LineFaultKind::NoFeed)?;
    count(tau_s / machine.interpolation_period_s())
}

/// Rounds up to at least one. Refuses more parts than [`MAX_PARTS`].
fn count(parts: f64) -> Result<u32, LineFaultKind> {
    if !(0.0..=MAX_PARTS).contains(&parts) {
        return Err(LineFaultKind::TooManyParts { parts, max: MAX_PARTS });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 1 ..= MAX_PARTS")]
    Ok(parts.ceil().max(1.0) as u32)
}
