//! How many blocks a source block becomes, and the words at each of their ends.

use super::{Correction, Sampled, Segment, SourceBlock, Station, repaired_tip_mm, within_tolerance};
use crate::geometry::Vec3;
use crate::motion::{AxisWords, Interpolation};
use crate::program::round_to_decimals;

use super::segment::rotary_rad;

/// With how many decimals, in which unit, words are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Decimals of linear words.
    pub linear_decimals: u8,
    /// Decimals of rotary words.
    pub rotary_decimals: u8,
    /// Millimetres in a program unit: 1 or 25.4.
    pub mm_per_unit: f64,
}

impl Resolution {
    /// The length that the control reads back when `length_mm` is written [mm].
    #[must_use]
    pub fn linear_mm(&self, length_mm: f64) -> f64 {
        round_to_decimals(length_mm / self.mm_per_unit, self.linear_decimals) * self.mm_per_unit
    }

    /// The angle that the control reads back when `angle_deg` is written [deg].
    #[must_use]
    pub fn rotary_deg(&self, angle_deg: f64) -> f64 {
        round_to_decimals(angle_deg, self.rotary_decimals)
    }
}

/// The end of an inserted block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Fraction of the source block.
    pub fraction: f64,
    /// Words as the control will read them, and the pose they give.
    pub station: Station,
    /// The contact point aimed at in W [mm].
    pub contact_mm: Vec3,
}

/// A source block divided: the nodes after its start, the last one being its end, and what was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Subdivision {
    /// Ends of the parts, in order; the last is the source block's own end, unchanged.
    pub nodes: Vec<Node>,
    /// The deviation left, over all parts.
    pub after: Sampled,
}

/// More parts than this are not tried: the block does not converge, or the program would drown.
const MAX_PARTS: u32 = 4096;
/// How far beyond the expected number the search goes before the decimals are blamed.
const SEARCH_FACTOR: u32 = 4;
/// … and at least so many more parts.
const SEARCH_EXTRA: u32 = 12;

/// The nodes of `parts` equal parts: rotary words rounded first, then X Y Z for the rounded ones (§2).
#[must_use]
pub fn nodes(
    block: &SourceBlock<'_>,
    correction: Correction,
    parts: u32,
    resolution: &Resolution,
) -> Vec<Node> {
    (1..=parts)
        .map(|index| {
            let fraction = f64::from(index) / f64::from(parts);
            if index == parts {
                let station = block.ends[1];
                return Node { fraction, station, contact_mm: block.line.at_mm(1.0) };
            }
            node(block, correction, fraction, resolution)
        })
        .collect()
}

fn node(block: &SourceBlock<'_>, correction: Correction, fraction: f64, resolution: &Resolution) -> Node {
    let mut words = block.words_at(fraction);
    words.rotary_deg = words.rotary_deg.map(|deg| resolution.rotary_deg(deg));
    let pose = Station::new(block.machine, block.kinematics, block.mode, words).pose;
    let tip_mm = repaired_tip_mm(block, correction, fraction, &pose);
    let exact = match block.mode {
        Interpolation::Machine => {
            block.kinematics.linear_mm(tip_mm, rotary_rad(block.machine, words.rotary_deg))
        }
        Interpolation::Tcp => tip_mm,
    };
    let linear_mm = std::array::from_fn(|k| resolution.linear_mm(exact[k]));
    let written = AxisWords { linear_mm, rotary_deg: words.rotary_deg };
    let station = Station::new(block.machine, block.kinematics, block.mode, written);
    let contact_mm = tip_mm + block.carry.at(&block.tool, fraction, pose.axis).offset_mm;
    Node { fraction, station, contact_mm }
}

/// The parts of a divided block as the machine will run them.
pub fn segments(block: &SourceBlock<'_>, nodes: &[Node]) -> impl Iterator<Item = Segment> {
    let first = Node { fraction: 0.0, station: block.ends[0], contact_mm: block.line.start_mm };
    let starts = std::iter::once(first).chain(nodes.iter().copied());
    starts.zip(nodes.to_vec()).map(|(from, to)| Segment {
        ends: [from.station, to.station],
        fraction: [from.fraction, to.fraction],
    })
}

/// The fewest equal parts that keep the block within `tolerance_mm` of its source line everywhere, from
/// `⌈√(ε_max/tol)⌉` upward (§2 "Output", `minimal`), with the words rounded as they will be written.
///
/// # Errors
/// The smallest deviation that any tried division reached, where none kept the tolerance: the decimals, or the
/// correction, cannot.
pub fn divide(
    block: &SourceBlock<'_>,
    correction: Correction,
    max_deviation_mm: f64,
    tolerance_mm: f64,
    resolution: &Resolution,
    evaluations: &mut u64,
) -> Result<Subdivision, f64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped before the cast")]
    let first = (max_deviation_mm / tolerance_mm).sqrt().ceil().clamp(2.0, f64::from(MAX_PARTS) + 1.0) as u32;
    let last = first.saturating_mul(SEARCH_FACTOR).saturating_add(SEARCH_EXTRA).min(MAX_PARTS);
    let mut reachable_mm = max_deviation_mm;
    let mut parts = first;
    while parts <= last {
        let nodes = nodes(block, correction, parts, resolution);
        match verify(block, &nodes, tolerance_mm, evaluations) {
            Ok(after) => return Ok(Subdivision { nodes, after }),
            Err(found_mm) => reachable_mm = reachable_mm.min(found_mm),
        }
        parts += 1 + parts / 64;
    }
    Err(reachable_mm)
}

/// Checks every part; the error is the largest deviation over all parts, so that it can be reported.
fn verify(
    block: &SourceBlock<'_>,
    nodes: &[Node],
    tolerance_mm: f64,
    evaluations: &mut u64,
) -> Result<Sampled, f64> {
    let mut from = 0.0;
    let mut parts = Vec::with_capacity(nodes.len());
    let mut worst_mm: Option<f64> = None;
    for segment in segments(block, nodes) {
        let found = within_tolerance(block, &segment, tolerance_mm);
        let (Ok(sampled) | Err(sampled)) = found;
        *evaluations += sampled.evaluations;
        if found.is_err() {
            worst_mm = Some(worst_mm.unwrap_or(0.0).max(sampled.max_mm));
        }
        parts.push((segment.fraction[1] - from, sampled));
        from = segment.fraction[1];
    }
    worst_mm.map_or_else(|| Ok(Sampled::join(parts)), Err)
}
