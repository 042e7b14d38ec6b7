//! The contact from the part: the point at which a cutter at a pose touches a mesh.
//!
//! The search has two steps. The first finds the point of the mesh nearest to the cutter, by the least signed
//! distance from its body over all facets. On facets, this point is wrong along the surface by up to a facet's tilt
//! times the cutter's radius. In the second step, the point p therefore moves over the mesh until the cutter's
//! point with normal n(p) is over p itself, with n the smoothed normal: `F = c(n) − p` along the surface is 0. With
//! the mesh's curvature K and the cutter's `C = r I + (R − r)/sin ψ · b bᵀ` (ψ between n and t, b across both) a
//! step of Newton's method is `(I + C K) δ = F`.

use std::sync::Arc;

use super::{CutterBody, CutterContact};
use crate::geometry::{Vec3, across};
use crate::kinematics::ToolPose;
use crate::machine::Tool;
use crate::surface::{Mesh, MeshPoint, Pace, nearest_weights};
use crate::units::Length;

/// A part's nominal surface in W, and the distance within which a cutter touches it.
#[derive(Debug, Clone)]
pub struct PartSurface {
    /// The surface.
    pub mesh: Arc<Mesh>,
    /// Largest distance above or inside the facets at which a cutter touches.
    pub contact_gap: Length,
}

impl PartSurface {
    /// The default gap: facets, rounding and a program's own tolerance.
    pub const DEFAULT_CONTACT_GAP: Length = Length::from_mm(0.1);
}

impl PartialEq for PartSurface {
    /// Whether both are the same mesh in memory.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.mesh, &other.mesh) && self.contact_gap == other.contact_gap
    }
}

/// The point at which a cutter touches a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceContact {
    /// The point on the mesh.
    pub place: MeshPoint,
    /// Unit normal of the part at the contact: the smoothed normal of the mesh, or on a real edge the normal of the
    /// cutter.
    pub normal: Vec3,
    /// Signed distance between cutter and mesh along the normal, negative if the cutter is inside \[mm\]. It
    /// includes the distance between the facets and the true surface.
    pub gap_mm: f64,
    /// Whether the contact is on an edge, a corner or a rim, where the part has more than one normal.
    pub on_edge: bool,
}

/// The search may start farther away than the nearest point by this share of the contact gap.
const SLACK: f64 = 0.25;
/// The contact on the mesh is iterated until it moves by less than this [mm].
const SETTLED_MM: f64 = 1e-7;
/// If it still moves by more than this, there is an edge [mm].
const EDGE_MM: f64 = 1e-5;
const MAX_STEPS: usize = 20;
/// A normal this close to the tool axis (sine) leaves the side undetermined: the flat end touches.
const FLAT_SINE: f64 = 1e-6;
/// A normal this nearly across the tool axis (cosine), above the corner, touches the flank.
const FLANK_COSINE: f64 = 0.01;
/// One search looks at this number of facets closely. It then skips every facet that lies wholly behind the tangent
/// plane at the best point found, because such a facet has no nearer point. On a sound part no search reaches this
/// number.
const CROWD: u32 = 256;
/// Evaluations of the cutter for each facet, without the halvings of its three sides.
const FACET_STEPS: u64 = 5;
/// A feed this close to the normal (sine) has no direction along the part except rounding.
const ALONG_NORMAL_SINE: f64 = 1e-9;

/// The contact of `tool` at `pose` with the part, if the distance is within the part's contact gap.
///
/// The body's flank reaches four radii above the tip. A cutter that is inside by more than the gap does not touch,
/// it gouges. The result means nothing if `pace` broke off.
#[must_use]
pub fn contact_on_surface(
    part: &PartSurface,
    tool: &Tool,
    pose: &ToolPose,
    pace: &mut impl Pace,
) -> Option<SurfaceContact> {
    let body = CutterBody::with_default_length(tool);
    let within_mm = part.contact_gap.mm();
    // A point that is not about as near as the nearest one belongs to another side of an edge.
    let doubt_mm = part.mesh.chordal_tolerance_mm().max(0.5 * within_mm);
    let mut find = |slack_mm: f64| {
        let nearest = nearest_to_cutter(&part.mesh, &body, pose, within_mm, slack_mm, pace)?;
        let (distance_mm, away) = body.distance_and_gradient(pose, nearest.point_mm);
        let settled = settle(&part.mesh, &body, pose, nearest, pace)
            .filter(|found| (found.gap_mm - distance_mm).abs() <= doubt_mm);
        Some((settled, SurfaceContact { place: nearest, normal: -away, gap_mm: distance_mm, on_edge: true }))
    };
    // A point near the nearest one is enough, unless there is an edge.
    let (near, _) = find(SLACK * within_mm)?;
    let found = if let Some(settled) = near {
        settled
    } else {
        let (settled, edge) = find(0.0)?;
        settled.unwrap_or(edge)
    };
    (found.gap_mm.abs() <= within_mm).then_some(found)
}

/// The point of a mesh with the least signed distance from a cutter's body, to within `slack_mm`, if it is below
/// `below_mm`.
///
/// The distance is convex. It is nowhere below its tangent at the middle of a box or of a facet, nor below the
/// tangent at the nearest point so far. The latter excludes facets that lie on top of each other. Nothing is found
/// if `pace` breaks off.
#[must_use]
pub fn nearest_to_cutter(
    mesh: &Mesh,
    body: &CutterBody,
    pose: &ToolPose,
    below_mm: f64,
    slack_mm: f64,
    pace: &mut impl Pace,
) -> Option<MeshPoint> {
    let mut looked_at = 0;
    let mut tangent: Option<(f64, Vec3, Vec3)> = None;
    let found = mesh.tree().least(
        below_mm + slack_mm,
        pace,
        |bounds| {
            let (centre_mm, halves_mm) = bounds.centre_and_halves_mm();
            let (distance_mm, away) = body.distance_and_gradient(pose, centre_mm);
            distance_mm - away.abs().dot(&halves_mm) + slack_mm
        },
        |triangle, best_mm, pace| {
            let corners_mm = mesh.corners_mm(triangle)?;
            let centre_mm = (corners_mm[0] + corners_mm[1] + corners_mm[2]) / 3.0;
            let (distance_mm, away) = body.distance_and_gradient(pose, centre_mm);
            let falls_mm =
                corners_mm.iter().map(|corner| (corner - centre_mm).dot(&away)).fold(0.0, f64::min);
            if distance_mm + falls_mm + slack_mm >= best_mm {
                return None;
            }
            if looked_at >= CROWD
                && let Some((distance_mm, at_mm, away)) = &tangent
                && corners_mm.iter().all(|corner| distance_mm + (corner - at_mm).dot(away) >= best_mm)
            {
                return None;
            }
            looked_at += 1;
            let (point_mm, steps) = least_on_triangle(body, pose, &corners_mm);
            // If it breaks off here, the tree does so at the next box.
            let _ = pace.step(steps);
            let distance_mm = body.distance_mm(pose, point_mm);
            if distance_mm < best_mm {
                let (_, away) = body.distance_and_gradient(pose, point_mm);
                tangent = Some((distance_mm, point_mm, away));
                return Some((distance_mm, (triangle, point_mm)));
            }
            None
        },
    );
    let (_, (triangle, point_mm)) = found?;
    mesh.at(triangle, nearest_weights(mesh.corners_mm(triangle)?, point_mm))
}

/// The point of a triangle nearest to the cutter, and the number of evaluations of the cutter. It is below the
/// cutter's outermost point against the facet if that falls inside, otherwise on one of the sides. The distance is
/// convex.
fn least_on_triangle(body: &CutterBody, pose: &ToolPose, corners_mm: &[Vec3; 3]) -> (Vec3, u64) {
    let [a, b, c] = *corners_mm;
    let normal = (b - a).cross(&(c - a)).normalize();
    let centre_mm = (a + b + c) / 3.0;
    if let Some(outermost_mm) = outermost_mm(body, pose, normal, centre_mm) {
        let foot_mm = outermost_mm - normal * (outermost_mm - a).dot(&normal);
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(from, to)| (to - from).cross(&(foot_mm - from)).dot(&normal) >= 0.0);
        if inside {
            return (foot_mm, FACET_STEPS);
        }
    }
    let mut best = (f64::INFINITY, centre_mm);
    let mut steps = FACET_STEPS;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let (point_mm, halvings) = least_on_side(body, pose, from, to);
        steps += halvings;
        let distance_mm = body.distance_mm(pose, point_mm);
        if distance_mm < best.0 {
            best = (distance_mm, point_mm);
        }
    }
    (best.1, steps)
}

/// The point of the cutter that is farthest against a normal. If there are many (flat end, flank), the one nearest
/// to `near_mm`.
fn outermost_mm(body: &CutterBody, pose: &ToolPose, normal: Vec3, near_mm: Vec3) -> Option<Vec3> {
    let (cosine, beside) = (normal.dot(&pose.axis), across(normal, pose.axis));
    let from_tip_mm = near_mm - pose.tip_mm;
    if beside.norm() < FLAT_SINE && cosine > 0.0 {
        let aside_mm = across(from_tip_mm, pose.axis);
        let reach_mm = aside_mm.norm().min(body.core_radius_mm());
        return Some(pose.tip_mm + aside_mm.try_normalize(0.0).unwrap_or_default() * reach_mm);
    }
    if cosine < -FLAT_SINE {
        return None;
    }
    let contact = CutterContact::Normal { direction: normal, magnitude: 1.0 };
    let mut found_mm = pose.tip_mm + contact.offset_mm(body.tool(), pose.axis);
    if cosine < FLAT_SINE {
        let (low_mm, high_mm) = (body.corner_radius_mm(), body.cutting_length_mm());
        let height_mm = from_tip_mm.dot(&pose.axis).clamp(low_mm, high_mm);
        found_mm += pose.axis * (height_mm - (found_mm - pose.tip_mm).dot(&pose.axis));
    }
    Some(found_mm)
}

/// The point of the least distance along a side, found by halving, and the number of halvings.
fn least_on_side(body: &CutterBody, pose: &ToolPose, from_mm: Vec3, to_mm: Vec3) -> (Vec3, u64) {
    let side_mm = to_mm - from_mm;
    let (mut low, mut high) = (0.0, 1.0);
    let mut halvings = 0;
    while (high - low) * side_mm.norm() > SETTLED_MM && high - low > f64::EPSILON {
        let middle = 0.5 * (low + high);
        let (_, away) = body.distance_and_gradient(pose, from_mm + side_mm * middle);
        if away.dot(&side_mm) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
        halvings += 1;
    }
    (from_mm + side_mm * (0.5 * (low + high)), halvings)
}

/// Moves over the mesh until the cutter's point of the smoothed normal is over it; `None` if there is no such point
/// nearby, because the part has an edge.
fn settle(
    mesh: &Mesh,
    body: &CutterBody,
    pose: &ToolPose,
    start: MeshPoint,
    pace: &mut impl Pace,
) -> Option<SurfaceContact> {
    let (corner_mm, core_mm) = (body.corner_radius_mm(), body.core_radius_mm());
    // On the flank the contact keeps its height.
    let is_above = (start.point_mm - pose.tip_mm).dot(&pose.axis) > corner_mm;
    let on_flank = is_above && start.normal.dot(&pose.axis).abs() < FLANK_COSINE;
    let mut place = start;
    let mut last_mm = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        let normal = place.normal;
        let beside = across(normal, pose.axis);
        let sine = beside.norm();
        if core_mm > 0.0 && sine < FLAT_SINE {
            // The whole flat end touches: the point found first is as good as any other.
            let gap_mm = (pose.tip_mm - place.point_mm).dot(&normal);
            return Some(SurfaceContact { place, normal, gap_mm, on_edge: false });
        }
        let contact = CutterContact::Normal { direction: normal, magnitude: 1.0 };
        let mut apart_mm = pose.tip_mm + contact.offset_mm(body.tool(), pose.axis) - place.point_mm;
        if on_flank {
            apart_mm = across(apart_mm, pose.axis);
        }
        let aside_mm = across(apart_mm, normal);
        let off_mm = aside_mm.norm();
        if off_mm < SETTLED_MM || (off_mm < EDGE_MM && off_mm >= last_mm) {
            let gap_mm = apart_mm.dot(&normal);
            return Some(SurfaceContact { place, normal, gap_mm, on_edge: false });
        }
        last_mm = off_mm;
        let first = aside_mm / off_mm;
        let second = normal.cross(&first);
        let round = if sine > 0.0 { pose.axis.cross(&(beside / sine)) } else { Vec3::zeros() };
        let wide_mm = if sine > 0.0 { core_mm / sine } else { 0.0 };
        let moved = |along: Vec3| {
            let turn_per_mm = mesh.normal_rate_per_mm(&place, across(along, place.facet_normal));
            along + turn_per_mm * corner_mm + round * (wide_mm * turn_per_mm.dot(&round))
        };
        let (p, q) = (moved(first), moved(second));
        let [[a, b], [c, d]] = [[p.dot(&first), q.dot(&first)], [p.dot(&second), q.dot(&second)]];
        let determinant = a * d - b * c;
        // A hollow narrower than the cutter, or an edge.
        if determinant <= 0.0 {
            return None;
        }
        let step_mm = first * (off_mm * d / determinant) - second * (off_mm * c / determinant);
        place = mesh.nearest_at_pace(place.point_mm + step_mm, 2.0 * step_mm.norm() + EDGE_MM, pace)?;
    }
    None
}

impl SurfaceContact {
    /// Normal curvature of the part across the feed \[1/mm\], positive if convex. `None` on an edge, or if the feed
    /// (of any length) has no direction along the part. The result means nothing if `pace` broke off.
    #[must_use]
    pub fn curvature_across_per_mm(&self, mesh: &Mesh, feed: Vec3, pace: &mut impl Pace) -> Option<f64> {
        let along = feed.try_normalize(f64::MIN_POSITIVE)?;
        let aside = self.normal.cross(&along).try_normalize(ALONG_NORMAL_SINE)?;
        (!self.on_edge).then(|| mesh.curvature_per_mm_at_pace(&self.place, aside, pace))
    }
}
