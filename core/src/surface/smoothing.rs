//! The smooth surfaces of a mesh: which facets belong together, and the normals at their corners.

use super::MeshFault;
use super::asking::{Asking, sort_by_unique_key};
use super::mesh::corners_of;
use crate::geometry::{Vec3, angle_between};

/// The edges of the facets, counted by kind.
#[derive(Debug, Default)]
pub(super) struct Edges {
    /// Edges of one facet.
    pub(super) open: u64,
    /// Edges of more than two facets.
    pub(super) non_manifold: u64,
    /// Edges of two facets that are not joined.
    pub(super) sharp: u64,
    /// Edges of two facets that run along them in the same direction.
    pub(super) contrary: u64,
    /// The ends of the first of these [mm].
    pub(super) first_contrary: Option<[Vec3; 2]>,
}

/// Normals at the corners of all triangles.
#[derive(Debug)]
pub(super) struct Smoothed {
    /// For each corner the index of its normal.
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) edges: Edges,
}

/// Largest angle between two facets of one smooth surface [rad] (45°).
const MAX_LEAN_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// One facet at a vertex.
struct Spoke {
    triangle: u32,
    corner: u8,
    /// Vectors to the next corner and to the one before [mm].
    next_mm: Vec3,
    before_mm: Vec3,
    /// Unit normal of the facet.
    normal: Vec3,
    /// The first spoke of the same smooth surface.
    root: u32,
}

/// Half an edge at a vertex.
#[derive(Clone, Copy)]
struct Half {
    other: u32,
    spoke: u32,
    /// Whether the facet runs from the vertex to the other end.
    outward: bool,
}

/// Looks at all facets around each vertex. It counts edges, joins facets into smooth surfaces, and gives each
/// corner the normal of its own smooth surface.
///
/// Two facets are joined across an edge if the circle through the edge and through their far ends (across the edge)
/// stays within `tolerance_mm` of them: heights h₁ ≤ h₂, angle δ between the normals, radius (h₁ + h₂)/2δ, sagitta
/// h₂² δ/4(h₁ + h₂). A vertex normal is the sum of the facets' products e₁ × e₂/(|e₁|²|e₂|²), which is exact on a
/// sphere (N. Max, Weights for computing vertex normals from facet normals, 1999).
///
/// # Errors
/// `stop` broke.
pub(super) fn smooth(
    vertices_mm: &[Vec3],
    triangles: &[[u32; 3]],
    tolerance_mm: f64,
    asking: &mut Asking<'_>,
) -> Result<Smoothed, MeshFault> {
    let around = Around::new(vertices_mm.len(), triangles, asking)?;
    let mut found = Smoothed {
        corners: vec![[0; 3]; triangles.len()],
        normals: Vec::with_capacity(vertices_mm.len()),
        edges: Edges::default(),
    };
    let (mut spokes, mut halves) = (Vec::new(), Vec::new());
    for (vertex, &here_mm) in vertices_mm.iter().enumerate() {
        spokes.clear();
        halves.clear();
        for &corner in around.of(vertex) {
            asking.after(1)?;
            add_spoke(&mut spokes, &mut halves, corner, vertices_mm, triangles);
        }
        let key = |half: &Half| (half.other, half.spoke, half.outward);
        sort_by_unique_key(&mut halves, key, asking)?;
        for edge in halves.chunk_by(|a, b| a.other == b.other) {
            asking.after(edge.len())?;
            // Each edge is seen from both ends and counted at one.
            let Some(first) = edge.first() else { continue };
            let counts = (vertex as u64) < u64::from(first.other);
            let edges = &mut found.edges;
            match edge {
                [_] => edges.open += u64::from(counts),
                [a, b] if a.outward == b.outward => {
                    edges.contrary += u64::from(counts);
                    if counts && edges.first_contrary.is_none() {
                        let there_mm = vertices_mm.get(first.other as usize).copied().unwrap_or_default();
                        edges.first_contrary = Some([here_mm, there_mm]);
                    }
                }
                [a, b] => {
                    let joined = are_joined(&spokes, a, b, tolerance_mm);
                    edges.sharp += u64::from(counts && !joined);
                    if joined {
                        join(&mut spokes, a.spoke, b.spoke);
                    }
                }
                _ => edges.non_manifold += u64::from(counts),
            }
        }
        found.give_normals(&mut spokes, asking)?;
    }
    Ok(found)
}

fn add_spoke(
    spokes: &mut Vec<Spoke>,
    halves: &mut Vec<Half>,
    corner: u32,
    vertices_mm: &[Vec3],
    triangles: &[[u32; 3]],
) {
    let (triangle, corner) = (corner / 3, corner % 3);
    let Some(&vertices) = triangles.get(triangle as usize) else { return };
    let mut numbers = vertices;
    let mut places_mm = corners_of(vertices_mm, vertices);
    numbers.rotate_left(corner as usize);
    places_mm.rotate_left(corner as usize);
    let (next_mm, before_mm) = (places_mm[1] - places_mm[0], places_mm[2] - places_mm[0]);
    // Starts from the same corner at either vertex, so that both ends of an edge give the same decision.
    let [a, b, c] = corners_of(vertices_mm, vertices);
    let normal = (b - a).cross(&(c - a)).normalize();
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2²⁶ corners; corners are 0, 1, 2")]
    let (spoke, corner) = (spokes.len() as u32, corner as u8);
    halves.push(Half { other: numbers[1], spoke, outward: true });
    halves.push(Half { other: numbers[2], spoke, outward: false });
    spokes.push(Spoke { triangle, corner, next_mm, before_mm, normal, root: spoke });
}

/// Whether the facets on both sides of an edge belong to one smooth surface.
fn are_joined(spokes: &[Spoke], a: &Half, b: &Half, tolerance_mm: f64) -> bool {
    let of = |half: &Half| {
        let spoke = spokes.get(half.spoke as usize)?;
        let (edge, beside) =
            if half.outward { (spoke.next_mm, spoke.before_mm) } else { (spoke.before_mm, spoke.next_mm) };
        Some((spoke.normal, edge.cross(&beside).norm() / edge.norm()))
    };
    let (Some((m, h)), Some((n, g))) = (of(a), of(b)) else { return false };
    let lean_rad = angle_between(m, n);
    let larger_mm = h.max(g);
    lean_rad <= MAX_LEAN_RAD && larger_mm * larger_mm * lean_rad <= 4.0 * (h + g) * tolerance_mm
}

/// The first spoke of the smooth surface. It also halves the path there for the next time.
fn root(spokes: &mut [Spoke], mut at: u32) -> u32 {
    let up = |spokes: &[Spoke], at: u32| spokes.get(at as usize).map_or(at, |spoke| spoke.root);
    loop {
        let above = up(spokes, at);
        let highest = up(spokes, above);
        if above == highest {
            return above;
        }
        if let Some(spoke) = spokes.get_mut(at as usize) {
            spoke.root = highest;
        }
        at = highest;
    }
}

fn join(spokes: &mut [Spoke], a: u32, b: u32) {
    let (a, b) = (root(spokes, a), root(spokes, b));
    if let Some(spoke) = spokes.get_mut(a.max(b) as usize) {
        spoke.root = a.min(b);
    }
}

impl Smoothed {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "fewer than 2²⁶ corners; normals are single precision"
    )]
    fn give_normals(&mut self, spokes: &mut [Spoke], asking: &mut Asking<'_>) -> Result<(), MeshFault> {
        let first = self.normals.len() as u32;
        // Roots come before their members: add up over each surface, and number the surfaces on the way.
        let mut sums: Vec<(u32, Vec3)> = Vec::new();
        for at in 0..spokes.len() as u32 {
            asking.after(1)?;
            let root = root(spokes, at);
            let Some(spoke) = spokes.get_mut(at as usize) else { continue };
            spoke.root = root;
            let weight = spoke.next_mm.norm_squared() * spoke.before_mm.norm_squared();
            let share = spoke.next_mm.cross(&spoke.before_mm) / weight;
            let place = sums.partition_point(|(number, _)| *number < root);
            match sums.get_mut(place) {
                Some((number, sum)) if *number == root => *sum += share,
                _ => sums.insert(place, (root, share)),
            }
            if let Some(corner) = self
                .corners
                .get_mut(spoke.triangle as usize)
                .and_then(|corners| corners.get_mut(usize::from(spoke.corner)))
            {
                *corner = first + place as u32;
            }
        }
        for (_, sum) in sums {
            asking.after(1)?;
            let normal = sum.try_normalize(0.0).unwrap_or_default();
            self.normals.push([normal.x as f32, normal.y as f32, normal.z as f32]);
        }
        Ok(())
    }
}

/// The corners at each vertex, by triangle.
struct Around {
    ends: Vec<u32>,
    corners: Vec<u32>,
}

impl Around {
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2²⁶ corners")]
    fn new(vertices: usize, triangles: &[[u32; 3]], asking: &mut Asking<'_>) -> Result<Self, MeshFault> {
        // Counts, then their sums; then each vertex's start moves to its end.
        let mut ends = vec![0_u32; vertices];
        for triangle in triangles {
            asking.after(1)?;
            for count in triangle {
                if let Some(end) = ends.get_mut(*count as usize) {
                    *end += 1;
                }
            }
        }
        let mut sum = 0;
        for end in &mut ends {
            asking.after(1)?;
            sum += std::mem::replace(end, sum);
        }
        let mut corners = vec![0; triangles.len() * 3];
        for (corner, vertex) in triangles.iter().flatten().enumerate() {
            asking.after(1)?;
            let Some(end) = ends.get_mut(*vertex as usize) else { continue };
            if let Some(place) = corners.get_mut(*end as usize) {
                *place = corner as u32;
            }
            *end += 1;
        }
        Ok(Self { ends, corners })
    }

    fn of(&self, vertex: usize) -> &[u32] {
        let end = self.ends.get(vertex).copied().unwrap_or(0);
        let from = vertex.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.corners.get(from as usize..end as usize).unwrap_or(&[])
    }
}
