//! Points spread evenly over a parametric surface.

use super::asking::Asking;
use super::{MeshFault, ParametricSurface, SurfacePoint};

/// Points spread evenly over a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct EvenSamples {
    /// The points, in their order.
    pub points: Vec<SurfacePoint>,
    /// Area of the surface \[mm²\].
    pub area_mm2: f64,
    /// Side of the square that one point represents, √(area / points) \[mm\].
    pub spacing_mm: f64,
}

impl EvenSamples {
    /// No point.
    #[must_use]
    pub fn none() -> Self {
        Self { points: Vec::new(), area_mm2: 0.0, spacing_mm: 0.0 }
    }
}

/// Number of cells in each direction in which the domain is measured.
const CELLS: usize = 128;
/// Number of rows of a surface up to which rows may have fewer than [`POINTS_OF_A_ROW`] points.
const FEW_ROWS: usize = 4096;
/// Smallest mean number of points in a row if there are more than [`FEW_ROWS`] rows. Every row is measured twice,
/// cell by cell. On a strip so narrow that a row has one point, the measuring would take 256 evaluations for each
/// point; with four points it takes 64.
const POINTS_OF_A_ROW: usize = 4;
/// The fraction of the golden ratio. Its multiples spread evenly over [0, 1) and never repeat a pattern.
pub(super) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// See [`ParametricSurface::samples`].
///
/// # Errors
/// The caller no longer waits.
pub(super) fn even_samples(
    surface: &(impl ParametricSurface + ?Sized),
    count: usize,
    asking: &mut Asking<'_>,
) -> Result<EvenSamples, MeshFault> {
    let [[u0, u1], [v0, v1]] = surface.domain();
    let step = [(u1 - u0) / CELLS as f64, (v1 - v0) / CELLS as f64];
    let at = |i: usize, v: f64| {
        let found = surface.derivatives([u0 + (i as f64 + 0.5) * step[0], v]);
        (found.by_u.cross(&found.by_v).norm(), found.by_v.norm())
    };
    // Length of the surface along v as a function of v, and its area.
    let mut area_mm2 = 0.0;
    let lengths: Vec<f64> = (0..CELLS)
        .map(|j| {
            let v = v0 + (j as f64 + 0.5) * step[1];
            let mut length = 0.0;
            for i in 0..CELLS {
                let (area, by_v) = at(i, v);
                area_mm2 += area * step[0] * step[1];
                length += by_v * step[1] / CELLS as f64;
            }
            length
        })
        .collect();
    if count == 0 {
        return Ok(EvenSamples { points: Vec::new(), area_mm2, spacing_mm: f64::INFINITY });
    }
    let spacing_mm = (area_mm2 / count as f64).sqrt();
    let along_v = Cumulative::new(&lengths);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and a count")]
    let rows = (along_v.total / spacing_mm).round().clamp(1.0, count as f64) as usize;
    let rows = rows.min((count / POINTS_OF_A_ROW).max(FEW_ROWS));
    let mut edges = Vec::with_capacity(rows + 1);
    for j in 0..=rows {
        asking.after(1)?;
        edges.push(v0 + step[1] * along_v.find(j as f64 / rows as f64 * along_v.total));
    }
    let row = |band: [f64; 2]| {
        let v = 0.5 * (band[0] + band[1]);
        let areas: Vec<f64> = (0..CELLS).map(|i| at(i, v).0 * step[0] * (band[1] - band[0])).collect();
        Cumulative::new(&areas)
    };
    let bands = || edges.iter().zip(edges.iter().skip(1)).map(|(&from, &to)| [from, to]);
    let mut total = 0.0;
    for band in bands() {
        asking.after(CELLS)?;
        total += row(band).total;
    }
    let share = total / count as f64;
    let mut points = Vec::with_capacity(count);
    let mut before = 0.0;
    for band in bands() {
        asking.after(CELLS)?;
        let across = row(band);
        while points.len() < count {
            let place = (points.len() as f64 + 0.5) * share - before;
            if place > across.total {
                break;
            }
            asking.after(1)?;
            let aside = (points.len() as f64 * GOLDEN + 0.5).fract();
            let v = band[0] + (band[1] - band[0]) * aside;
            points.push(surface.at([u0 + step[0] * across.find(place), v]));
        }
        before += across.total;
    }
    // Rounding may put the last point just beyond the last row.
    if let (true, Some(&v)) = (points.len() < count, edges.last()) {
        points.push(surface.at([u1, v]));
    }
    Ok(EvenSamples { points, area_mm2, spacing_mm })
}

/// Cumulative sums of positive weights of cells, to find the cell at which a sum is reached.
struct Cumulative {
    /// The sum up to the end of each cell.
    sums: Vec<f64>,
    total: f64,
}

impl Cumulative {
    fn new(weights: &[f64]) -> Self {
        let mut total = 0.0;
        let sums = weights
            .iter()
            .map(|weight| {
                total += weight;
                total
            })
            .collect();
        Self { sums, total }
    }

    /// Number of cells, and share of the next cell, that add up to `sum`.
    fn find(&self, sum: f64) -> f64 {
        let cell = self.sums.partition_point(|&end| end < sum).min(self.sums.len().saturating_sub(1));
        let from = cell.checked_sub(1).and_then(|before| self.sums.get(before)).copied().unwrap_or(0.0);
        let to = self.sums.get(cell).copied().unwrap_or(from);
        let part = if to > from { ((sum - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        cell as f64 + part
    }
}
