//! Points on a mesh: the nearest one, its normals and its curvature.

use super::{Mesh, Pace, SurfacePoint, Uncounted};
use crate::geometry::{Vec3, across};

/// A point on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshPoint {
    /// The point on the facet \[mm\].
    pub point_mm: Vec3,
    /// The facet.
    pub triangle: u32,
    /// Shares of its three corners.
    pub weights: [f64; 3],
    /// Unit normal of the facet out of the part.
    pub facet_normal: Vec3,
    /// Unit normal of the true smooth surface, out of the part.
    pub normal: Vec3,
}

impl MeshPoint {
    /// The point with its smooth normal.
    #[must_use]
    pub fn surface_point(&self) -> SurfacePoint {
        SurfacePoint { point_mm: self.point_mm, normal: self.normal }
    }
}

/// Normals are compared at this number of facet widths to either side …
const WIDTHS: f64 = 2.0;
/// … if the surface continues for at least this share of the distance …
const LEAST_WAY: f64 = 0.25;
/// … and has not turned by more than 60°.
const LEAST_COSINE: f64 = 0.5;

impl Mesh {
    /// The nearest point on the mesh, if it is closer than `within_mm`.
    #[must_use]
    pub fn nearest(&self, point_mm: Vec3, within_mm: f64) -> Option<MeshPoint> {
        self.nearest_at_pace(point_mm, within_mm, &mut Uncounted)
    }

    /// The same, counted; `None` if `pace` breaks off.
    pub(crate) fn nearest_at_pace(
        &self,
        point_mm: Vec3,
        within_mm: f64,
        pace: &mut impl Pace,
    ) -> Option<MeshPoint> {
        let found = self.tree.least(
            within_mm,
            pace,
            |bounds| bounds.distance_mm(point_mm),
            |triangle, below, _| {
                let weights = nearest_weights(self.corners_mm(triangle)?, point_mm);
                let distance_mm = (self.place(triangle, weights)? - point_mm).norm();
                (distance_mm < below).then_some((distance_mm, (triangle, weights)))
            },
        );
        found.and_then(|(_, (triangle, weights))| self.at(triangle, weights))
    }

    fn place(&self, triangle: u32, weights: [f64; 3]) -> Option<Vec3> {
        let [a, b, c] = self.corners_mm(triangle)?;
        Some(a * weights[0] + b * weights[1] + c * weights[2])
    }

    /// The point of a triangle with the given shares of its corners, which sum up to 1; `None` beyond the last
    /// triangle.
    #[must_use]
    pub fn at(&self, triangle: u32, weights: [f64; 3]) -> Option<MeshPoint> {
        let [a, b, c] = self.corners_mm(triangle)?;
        let facet_normal = (b - a).cross(&(c - a)).normalize();
        let [l, m, n] = self.corner_normals(triangle);
        let smooth = l * weights[0] + m * weights[1] + n * weights[2];
        let normal = smooth.try_normalize(0.0).unwrap_or(facet_normal);
        let point_mm = self.place(triangle, weights)?;
        Some(MeshPoint { point_mm, triangle, weights, facet_normal, normal })
    }

    /// Normal curvature of the smooth surface at a point in a direction of W \[1/mm\], positive if the part is
    /// convex. Only the direction's component along the surface counts; without one the result is 0.
    ///
    /// It is the turn of the smoothed normal between two points, each two facets away. Beside a real edge it is
    /// taken between the point itself and the one on the other side, and if there is neither, over the facet. It is
    /// accurate to a few per cent on even facets, and to a quarter on facets of all shapes. Beside a real edge or
    /// the rim of an open surface, where normals come from one side, it is too small.
    #[must_use]
    pub fn curvature_per_mm(&self, place: &MeshPoint, direction: Vec3) -> f64 {
        self.curvature_per_mm_at_pace(place, direction, &mut Uncounted)
    }

    /// The same, counted. The result means nothing if `pace` breaks off.
    pub(crate) fn curvature_per_mm_at_pace(
        &self,
        place: &MeshPoint,
        direction: Vec3,
        pace: &mut impl Pace,
    ) -> f64 {
        let Some(along) = across(direction, place.normal).try_normalize(0.0) else { return 0.0 };
        let Some(corners_mm) = self.corners_mm(place.triangle) else { return 0.0 };
        let reaches_mm = corners_mm.map(|corner| corner.dot(&along));
        let facet_mm = reaches_mm.into_iter().fold(f64::NEG_INFINITY, f64::max)
            - reaches_mm.into_iter().fold(f64::INFINITY, f64::min);
        let reach_mm = WIDTHS * facet_mm;
        let mut beside = |sense: f64| {
            let aside_mm = place.point_mm + along * (sense * reach_mm);
            let found = self.nearest_at_pace(aside_mm, reach_mm, pace)?;
            let way_mm = (found.point_mm - place.point_mm).dot(&along) * sense;
            (way_mm > LEAST_WAY * reach_mm && found.normal.dot(&place.normal) > LEAST_COSINE).then_some(found)
        };
        let turn = |from: &MeshPoint, to: &MeshPoint| {
            let chord_mm = to.point_mm - from.point_mm;
            (to.normal - from.normal).dot(&chord_mm) / chord_mm.norm_squared()
        };
        match (beside(-1.0), beside(1.0)) {
            (Some(before), Some(behind)) => turn(&before, &behind),
            (Some(before), None) => turn(&before, place),
            (None, Some(behind)) => turn(place, &behind),
            (None, None) => {
                let along = across(along, place.facet_normal);
                self.normal_rate_per_mm(place, along).dot(&along) / along.norm_squared()
            }
        }
    }

    /// Change of the smoothed normal in a direction along the facet \[1/mm, times the direction's length\].
    pub(crate) fn normal_rate_per_mm(&self, place: &MeshPoint, along: Vec3) -> Vec3 {
        let Some([a, b, c]) = self.corners_mm(place.triangle) else { return Vec3::zeros() };
        let [l, m, n] = self.corner_normals(place.triangle);
        let (u, v) = (b - a, c - a);
        let determinant = u.norm_squared() * v.norm_squared() - u.dot(&v) * u.dot(&v);
        let size = (l * place.weights[0] + m * place.weights[1] + n * place.weights[2]).norm();
        if determinant <= 0.0 || size <= 0.0 {
            return Vec3::zeros();
        }
        let (p, q) = (along.dot(&u), along.dot(&v));
        let s = (p * v.norm_squared() - q * u.dot(&v)) / determinant;
        let t = (q * u.norm_squared() - p * u.dot(&v)) / determinant;
        across((m - l) * s + (n - l) * t, place.normal) / size
    }

    fn corner_normals(&self, triangle: u32) -> [Vec3; 3] {
        let corners = self.corners.get(triangle as usize).copied().unwrap_or_default();
        corners.map(|corner| {
            self.normals
                .get(corner as usize)
                .map_or(Vec3::zeros(), |normal| Vec3::from(normal.map(f64::from)))
        })
    }
}

/// Shares of the corners at the point of a triangle nearest to a point (Voronoi regions of its corners and sides;
/// C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
pub(crate) fn nearest_weights([a, b, c]: [Vec3; 3], point_mm: Vec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, point_mm - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = point_mm - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = point_mm - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    let (v, w) = (vb / sum, vc / sum);
    [1.0 - v - w, v, w]
}
