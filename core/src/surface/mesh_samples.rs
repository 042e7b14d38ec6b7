//! Points spread evenly over a mesh.

use std::ops::ControlFlow;

use super::asking::Asking;
use super::samples::GOLDEN;
use super::{EvenSamples, Mesh, MeshFault};

/// Powers of the plastic number. They spread points of a square evenly, for any number of points.
const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

impl Mesh {
    /// `count` points spread evenly over the area, with smooth normals. They are always the same points.
    ///
    /// Triangles are visited in the order of the tree, neighbours after neighbours. Each stretch of `area / count`
    /// gets one point.
    #[must_use]
    pub fn samples(&self, count: usize) -> EvenSamples {
        self.samples_until(count, &|| ControlFlow::Continue(())).unwrap_or_else(|_never| EvenSamples::none())
    }

    /// The same, until the caller stops.
    ///
    /// # Errors
    /// `stop` broke.
    pub fn samples_until(
        &self,
        count: usize,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<EvenSamples, MeshFault> {
        let mut asking = Asking::new(stop);
        let area_mm2 = self.report().area_mm2;
        if count == 0 {
            return Ok(EvenSamples { points: Vec::new(), area_mm2, spacing_mm: f64::INFINITY });
        }
        let share_mm2 = area_mm2 / count as f64;
        let mut points = Vec::with_capacity(count);
        let mut walked_mm2 = 0.0;
        let mut last = 0;
        #[expect(clippy::cast_possible_truncation, reason = "fewer than 2²⁴ triangles")]
        for triangle in 0..self.triangles() as u32 {
            asking.after(1)?;
            let Some([a, b, c]) = self.corners_mm(triangle) else { break };
            walked_mm2 += 0.5 * (b - a).cross(&(c - a)).norm();
            last = triangle;
            while points.len() < count && (points.len() as f64 + 0.5) * share_mm2 <= walked_mm2 {
                asking.after(1)?;
                points.extend(self.at(triangle, spread(points.len())).map(|place| place.surface_point()));
            }
        }
        // Rounding may put the last point just beyond the last triangle.
        while points.len() < count {
            let Some(place) = self.at(last, spread(points.len())) else { break };
            points.push(place.surface_point());
        }
        Ok(EvenSamples { points, area_mm2, spacing_mm: share_mm2.sqrt() })
    }
}

/// Shares of a triangle's corners, evenly spread over it.
fn spread(index: usize) -> [f64; 3] {
    let [u, v] = PLASTIC.map(|step| (index as f64 * step + 0.5 * GOLDEN).fract());
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    [1.0 - u - v, u, v]
}
