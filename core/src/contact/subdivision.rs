//! The number of blocks into which a source block is divided, and the words at each of their ends.

use super::{Correction, Effort, Segment, SourceBlock, Station, repaired_tip_mm, within_tolerance};
use crate::geometry::{PlaneFrame, Vec3};
use crate::motion::{AxisWords, Interpolation};
use crate::program::round_to_decimals;

use super::segment::rotary_rad;

/// The decimals and the unit in which words are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Decimals of linear words.
    pub linear_decimals: u8,
    /// Decimals of rotary words.
    pub rotary_decimals: u8,
    /// Decimals of the components of the tool axis, if it is written as a vector instead of rotary words.
    pub axis_decimals: Option<u8>,
    /// Millimetres in a program unit: 1 or 25.4.
    pub mm_per_unit: f64,
    /// The origin of written numbers: zero, or in G91 the point before the block. In a tilted plane, a place of it.
    pub origin: AxisWords,
    /// The tilted plane whose places are written. The rotary axes then stand, and are not written.
    pub frame: Option<PlaneFrame>,
}

impl Resolution {
    /// Words counted from zero.
    #[must_use]
    pub fn absolute(linear_decimals: u8, rotary_decimals: u8, mm_per_unit: f64) -> Self {
        let origin = AxisWords { linear_mm: [0.0; 3], rotary_deg: [0.0; 2] };
        Self { linear_decimals, rotary_decimals, axis_decimals: None, mm_per_unit, origin, frame: None }
    }

    /// The lengths that the control reads back when these are written \[mm\].
    #[must_use]
    pub fn linear_mm(&self, lengths_mm: [f64; 3]) -> [f64; 3] {
        let wanted_mm = self.frame.map_or(lengths_mm, |frame| frame.from_workpiece(lengths_mm));
        let written_mm = std::array::from_fn(|k| {
            let origin_mm = self.origin.linear_mm[k];
            let units = (wanted_mm[k] - origin_mm) / self.mm_per_unit;
            origin_mm + round_to_decimals(units, self.linear_decimals) * self.mm_per_unit
        });
        self.frame.map_or(written_mm, |frame| frame.to_workpiece(written_mm))
    }

    /// The angles that the control reads back when these are written \[deg\].
    #[must_use]
    pub fn rotary_deg(&self, angles_deg: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|k| {
            let origin_deg = self.origin.rotary_deg[k];
            origin_deg + round_to_decimals(angles_deg[k] - origin_deg, self.rotary_decimals)
        })
    }

    /// The angles to which the control turns when a point of this block is written with these \[deg\]. Also the
    /// tool axis as written, if it is written as a vector and turns.
    #[must_use]
    #[expect(clippy::float_cmp, reason = "words that did not move are equal to the bit")]
    pub fn turned(&self, block: &SourceBlock<'_>, angles_deg: [f64; 2]) -> ([f64; 2], Option<[f64; 3]>) {
        if self.frame.is_some() {
            return (block.ends[0].words.rotary_deg, None);
        }
        let Some(decimals) = self.axis_decimals else { return (self.rotary_deg(angles_deg), None) };
        let [start, end] = block.ends.each_ref().map(|end| end.words.rotary_deg);
        if start == end {
            return (start, None);
        }
        let axis: [f64; 3] = block.kinematics.axis(rotary_rad(block.machine, angles_deg)).into();
        let written = axis.map(|component| round_to_decimals(component, decimals));
        let near = block.kinematics.words_near(Vec3::from(written), angles_deg, 0.0);
        (near.map_or(angles_deg, |near| near.words_deg), Some(written))
    }
}

/// The end of an inserted block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Fraction of the source block.
    pub fraction: f64,
    /// Words as the control will read them, and the pose they give.
    pub station: Station,
    /// The intended contact point in W \[mm\].
    pub contact_mm: Vec3,
    /// The tool axis as written, if it is written as a vector and turns.
    pub written_axis: Option<[f64; 3]>,
}

/// Most parts that are tried. A block that needs more does not converge, or makes the program far too long.
const MAX_PARTS: u32 = 2048;
/// The cost of a node, in evaluations.
const NODE_EVALUATIONS: u64 = 4;
/// Most evaluations for one division. More are needed only if it samples a block without a bound everywhere.
const MAX_EVALUATIONS: u64 = 1_000_000;
/// The search for the number of parts is exact to one in this number: well within the 5 % that an optimal division
/// may save.
const FINENESS: u32 = 64;
/// This many numbers of parts, from the expected one upward, are tried one after the other …
const CLOSE_TRIES: u32 = 6;
/// … then the number is doubled, as long as two doublings reduce the deviation to this share or less.
const STAGNATION: f64 = 0.8;

/// The nodes of `parts` equal parts: rotary words are rounded first, then X Y Z are computed for the rounded words
/// (§2). Some nodes are missing if the effort has ended.
#[must_use]
pub fn nodes(
    block: &SourceBlock<'_>,
    correction: Correction,
    parts: u32,
    resolution: &Resolution,
    effort: &mut Effort<'_>,
) -> Vec<Node> {
    (1..=parts)
        .map_while(|index| {
            effort.pass(NODE_EVALUATIONS);
            if effort.is_over() {
                return None;
            }
            let fraction = f64::from(index) / f64::from(parts);
            if index == parts {
                let station = block.ends[1];
                let contact_mm = block.line.at_mm(1.0);
                return Some(Node { fraction, station, contact_mm, written_axis: None });
            }
            Some(node(block, correction, fraction, resolution))
        })
        .collect()
}

fn node(block: &SourceBlock<'_>, correction: Correction, fraction: f64, resolution: &Resolution) -> Node {
    let mut words = block.words_at(fraction);
    let (rotary_deg, written_axis) = resolution.turned(block, words.rotary_deg);
    words.rotary_deg = rotary_deg;
    let pose = Station::new(block.machine, &block.kinematics, block.mode, words).pose;
    let tip_mm = repaired_tip_mm(block, correction, fraction, &pose);
    let exact = match block.mode {
        Interpolation::Machine => {
            block.kinematics.linear_mm(tip_mm, rotary_rad(block.machine, words.rotary_deg))
        }
        Interpolation::Tcp => tip_mm,
    };
    let linear_mm = resolution.linear_mm(exact.into());
    let written = AxisWords { linear_mm, rotary_deg: words.rotary_deg };
    let station = Station::new(block.machine, &block.kinematics, block.mode, written);
    let contact_mm = tip_mm + block.carry.at(&block.tool, fraction, pose.axis).offset_mm;
    Node { fraction, station, contact_mm, written_axis }
}

/// The parts of a divided block as the machine will run them.
pub fn segments<'n>(block: &SourceBlock<'_>, nodes: &'n [Node]) -> impl Iterator<Item = Segment> + use<'n> {
    let contact_mm = block.line.start_mm;
    let first = Node { fraction: 0.0, station: block.ends[0], contact_mm, written_axis: None };
    let starts = std::iter::once(first).chain(nodes.iter().copied());
    starts.zip(nodes).map(|(from, to)| Segment {
        ends: [from.station, to.station],
        fraction: [from.fraction, to.fraction],
    })
}

/// The fewest equal parts that `proof` accepts, from `⌈√(ε_max/tol)⌉` upward (§2 "Output", `minimal`), with the
/// words rounded as written. [`prove`] proves that they keep the block within a tolerance of its source line.
///
/// # Errors
/// The smallest deviation of all divisions tried, if none was accepted: the decimals or the correction cannot reach
/// the tolerance. Or the effort has ended.
pub fn divide(
    block: &SourceBlock<'_>,
    correction: Correction,
    [max_deviation_mm, tolerance_mm]: [f64; 2],
    resolution: &Resolution,
    effort: &mut Effort<'_>,
    mut proof: impl FnMut(&[Node], &mut Effort<'_>) -> Result<(), f64>,
) -> Result<Vec<Node>, f64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped before the cast")]
    let first = (max_deviation_mm / tolerance_mm).sqrt().ceil().clamp(2.0, f64::from(MAX_PARTS) + 1.0) as u32;
    if first > MAX_PARTS {
        return Err(max_deviation_mm);
    }
    let mut attempt = |parts: u32| {
        let nodes = nodes(block, correction, parts, resolution, effort);
        proof(&nodes, effort).map(|()| nodes)
    };
    let mut reachable_mm = max_deviation_mm;
    let mut parts = first;
    for _ in 0..CLOSE_TRIES {
        match attempt(parts) {
            Ok(divided) => return Ok(divided),
            Err(found_mm) => reachable_mm = reachable_mm.min(found_mm),
        }
        parts = (parts + 1 + parts / FINENESS).min(MAX_PARTS);
    }
    // The square-root law does not hold here: the contact swings fast somewhere in the block, or the decimals are
    // too coarse. Doubling distinguishes the two cases.
    let mut failed = parts.saturating_sub(1).max(first);
    let mut earlier = [f64::INFINITY, reachable_mm];
    while failed < MAX_PARTS {
        let parts = failed.saturating_mul(2).min(MAX_PARTS);
        match attempt(parts) {
            Ok(divided) => return Ok(fewest_between(failed, parts, divided, attempt)),
            Err(found_mm) => reachable_mm = reachable_mm.min(found_mm),
        }
        if reachable_mm > STAGNATION * earlier[0] {
            break;
        }
        earlier = [earlier[1], reachable_mm];
        failed = parts;
    }
    Err(reachable_mm)
}

/// Halves the interval between a number of parts that failed and one that holds, down to the fineness of the
/// search.
fn fewest_between(
    mut failed: u32,
    mut holding: u32,
    mut best: Vec<Node>,
    mut attempt: impl FnMut(u32) -> Result<Vec<Node>, f64>,
) -> Vec<Node> {
    while holding - failed > 1 + failed / FINENESS {
        let middle = failed + (holding - failed) / 2;
        match attempt(middle) {
            Ok(divided) => (holding, best) = (middle, divided),
            Err(_) => failed = middle,
        }
    }
    best
}

/// Proves that every part of a divided block keeps `tolerance_mm`.
///
/// # Errors
/// The largest deviation seen over all parts, so that it can be reported; also if the effort has ended.
pub fn prove(
    block: &SourceBlock<'_>,
    nodes: &[Node],
    tolerance_mm: f64,
    effort: &mut Effort<'_>,
) -> Result<(), f64> {
    let mut worst_mm: f64 = 0.0;
    let mut kept = true;
    let before = effort.evaluations();
    for segment in segments(block, nodes) {
        let found = within_tolerance(block, &segment, tolerance_mm);
        kept &= found.is_ok();
        let (Ok(sampled) | Err(sampled)) = found;
        effort.spend(sampled.evaluations);
        worst_mm = worst_mm.max(sampled.max_mm);
        if effort.is_over() {
            return Err(worst_mm);
        }
        if !kept && effort.evaluations() - before > MAX_EVALUATIONS {
            break;
        }
    }
    if kept { Ok(()) } else { Err(worst_mm) }
}
