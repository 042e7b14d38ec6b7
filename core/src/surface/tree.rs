//! Boxes within boxes over the facets of a mesh.
//!
//! The tree is built from above: the facets of a box are halved at the median of their centres, along the axis with
//! the largest spread of centres. Boxes are single precision, rounded outward: 32 bytes for every two or three
//! facets.

use super::asking::{ASK_EVERY, Asking, DIVIDED_AT_ONCE, divide_at};
use super::{MeshFault, Pace};
use crate::geometry::Vec3;

/// An axis-parallel box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    least_mm: [f32; 3],
    largest_mm: [f32; 3],
}

impl Bounds {
    const NOTHING: Self = Self { least_mm: [f32::INFINITY; 3], largest_mm: [f32::NEG_INFINITY; 3] };

    #[expect(clippy::cast_possible_truncation, reason = "rounded outward afterwards")]
    fn add(&mut self, point_mm: Vec3) {
        for ((least, largest), x) in self.least_mm.iter_mut().zip(&mut self.largest_mm).zip(point_mm.iter()) {
            let near = *x as f32;
            *least = least.min(if f64::from(near) > *x { near.next_down() } else { near });
            *largest = largest.max(if f64::from(near) < *x { near.next_up() } else { near });
        }
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            least_mm: std::array::from_fn(|k| self.least_mm[k].min(other.least_mm[k])),
            largest_mm: std::array::from_fn(|k| self.largest_mm[k].max(other.largest_mm[k])),
        }
    }

    /// The distance of a point; 0 inside \[mm\].
    pub(crate) fn distance_mm(&self, point_mm: Vec3) -> f64 {
        let outside = |k: usize| {
            let (least, largest) = (f64::from(self.least_mm[k]), f64::from(self.largest_mm[k]));
            (least - point_mm[k]).max(point_mm[k] - largest).max(0.0)
        };
        Vec3::new(outside(0), outside(1), outside(2)).norm()
    }

    /// Its centre and its half widths \[mm\].
    pub(crate) fn centre_and_halves_mm(&self) -> (Vec3, Vec3) {
        let least = Vec3::from(self.least_mm.map(f64::from));
        let largest = Vec3::from(self.largest_mm.map(f64::from));
        ((least + largest) * 0.5, (largest - least) * 0.5)
    }
}

/// The middle of a facet [mm], and its index.
type Centre = ([f32; 3], u32);

/// A key that orders positions on an axis, with the facet's index in its low bits, so that all keys differ.
fn in_order(place_mm: f32, facet: u32) -> u64 {
    let bits = place_mm.to_bits();
    // For negative numbers the larger bits are the smaller number.
    let place = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    u64::from(place) << 32 | u64::from(facet)
}

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Bounds,
    /// The first facet of a leaf, or the child that does not come directly after.
    first: u32,
    /// Number of facets of a leaf; 0 for a box of boxes.
    count: u32,
}

/// Most facets of a leaf.
const LEAF: usize = 8;

/// The boxes. Facets are numbered in the order that [`Tree::build`] returns.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    /// The tree, and the order into which its facets have to be brought.
    ///
    /// # Errors
    /// `stop` broke.
    pub(super) fn build(
        facets: usize,
        corners_mm: impl Fn(u32) -> [Vec3; 3],
        asking: &mut Asking<'_>,
    ) -> Result<(Self, Vec<u32>), MeshFault> {
        let mut centres: Vec<Centre> = Vec::with_capacity(facets);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "fewer than 2²⁴ facets; only an order comes from centres"
        )]
        for facet in 0..facets as u32 {
            asking.after(1)?;
            let [a, b, c] = corners_mm(facet);
            let centre = (a + b + c) / 3.0;
            centres.push(([centre.x as f32, centre.y as f32, centre.z as f32], facet));
        }
        let mut tree = Self { nodes: Vec::with_capacity(facets / 2 + 1) };
        if !centres.is_empty() {
            tree.split(&mut centres, 0, &corners_mm, asking)?;
        }
        let mut order = Vec::with_capacity(facets);
        for (_, facet) in centres {
            asking.after(1)?;
            order.push(facet);
        }
        Ok((tree, order))
    }

    /// Adds the boxes of these facets. The depth is a logarithm, because facets are halved.
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2²⁴ facets")]
    fn split(
        &mut self,
        facets: &mut [Centre],
        first: usize,
        corners_mm: &impl Fn(u32) -> [Vec3; 3],
        asking: &mut Asking<'_>,
    ) -> Result<Bounds, MeshFault> {
        asking.after(facets.len())?;
        let at = self.nodes.len();
        self.nodes.push(Node { bounds: Bounds::NOTHING, first: first as u32, count: facets.len() as u32 });
        let mut bounds = Bounds::NOTHING;
        if facets.len() <= LEAF {
            // Ties of the order above leave nothing undefined.
            for (_, facet) in facets.iter() {
                for corner in corners_mm(*facet) {
                    bounds.add(corner);
                }
            }
        } else {
            let axis = widest(facets, asking)?;
            let half = facets.len() / 2;
            if facets.len() <= DIVIDED_AT_ONCE {
                facets.select_nth_unstable_by(half, |(a, m), (b, n)| {
                    a[axis].total_cmp(&b[axis]).then(m.cmp(n))
                });
            } else {
                divide_at(facets, half, |(centre, facet)| in_order(centre[axis], *facet), asking)?;
            }
            let (left, right) = facets.split_at_mut(half);
            let left_bounds = self.split(left, first, corners_mm, asking)?;
            let child = self.nodes.len() as u32;
            bounds = left_bounds.union(&self.split(right, first + half, corners_mm, asking)?);
            if let Some(node) = self.nodes.get_mut(at) {
                (node.first, node.count) = (child, 0);
            }
        }
        if let Some(node) = self.nodes.get_mut(at) {
            node.bounds = bounds;
        }
        Ok(bounds)
    }

    /// The smallest value over all facets that is below `below`, with the result that belongs to it.
    ///
    /// `bound` of a box must not exceed the value of any facet inside. `facet` gives a facet's value if it is below
    /// the number passed in, and counts its cost beyond one step. Boxes are opened nearest first. If `pace` breaks
    /// off, nothing is found.
    pub(crate) fn least<T, P: Pace>(
        &self,
        below: f64,
        pace: &mut P,
        bound: impl Fn(&Bounds) -> f64,
        mut facet: impl FnMut(u32, f64, &mut P) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let mut best = None;
        let mut below = below;
        let mut open: Vec<(f64, u32)> = Vec::with_capacity(2 * MAX_DEPTH);
        if let Some(root) = self.nodes.first() {
            open.push((bound(&root.bounds), 0));
        }
        while let Some((least, at)) = open.pop() {
            // Also skips a box whose bound is not a number.
            if least.partial_cmp(&below) != Some(std::cmp::Ordering::Less) {
                continue;
            }
            let Some(node) = self.nodes.get(at as usize) else { continue };
            if pace.step(NODE_STEPS.max(u64::from(node.count))).is_break() {
                return None;
            }
            if node.count > 0 {
                for number in node.first..node.first + node.count {
                    if let Some((value, found)) = facet(number, below, pace) {
                        below = value;
                        best = Some((value, found));
                    }
                }
                continue;
            }
            let mut pair = [at + 1, node.first].map(|child| {
                let least = self.nodes.get(child as usize).map_or(f64::INFINITY, |node| bound(&node.bounds));
                (least, child)
            });
            if pair[0].0 < pair[1].0 {
                pair.swap(0, 1);
            }
            open.extend(pair.into_iter().filter(|(least, _)| *least < below));
        }
        best
    }
}

/// Opening a box looks at the two boxes inside.
const NODE_STEPS: u64 = 2;
/// Halvings of fewer than 2²⁴ facets down to a leaf.
const MAX_DEPTH: usize = 24;

/// The axis with the largest spread of the centres.
fn widest(facets: &[Centre], asking: &mut Asking<'_>) -> Result<usize, MeshFault> {
    let mut least = [f32::INFINITY; 3];
    let mut largest = [f32::NEG_INFINITY; 3];
    for some in facets.chunks(ASK_EVERY) {
        for (centre, _) in some {
            for k in 0..3 {
                least[k] = least[k].min(centre[k]);
                largest[k] = largest[k].max(centre[k]);
            }
        }
        if facets.len() > some.len() {
            asking.after(some.len())?;
        }
    }
    let spread: [f32; 3] = std::array::from_fn(|k| largest[k] - least[k]);
    let y_or_z = if spread[2] > spread[1] { 2 } else { 1 };
    Ok(if spread[y_or_z] > spread[0] { y_or_z } else { 0 })
}
