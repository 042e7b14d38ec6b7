//! The deviation along the path, down-sampled while it streams by.

/// One bucket of the series, with the largest deviation of its motions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesPoint {
    /// Contact path length at the bucket's end \[mm\].
    pub path_mm: f64,
    /// Line of the upload where the bucket's largest deviation before compensation is.
    pub line: u64,
    /// Largest deviation before \[mm\].
    pub before_mm: f64,
    /// Largest deviation after \[mm\].
    pub after_mm: f64,
}

/// A series of at most [`Series::MAX_POINTS`] points for any length of program. When it is full, neighbours are
/// merged, and every later point covers twice as many motions.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    points: Vec<SeriesPoint>,
    motions_per_point: u64,
    motions_in_last: u64,
}

impl Default for Series {
    fn default() -> Self {
        Self { points: Vec::new(), motions_per_point: 1, motions_in_last: 0 }
    }
}

impl Series {
    /// Most points kept.
    pub const MAX_POINTS: usize = 2000;

    /// Adds one motion.
    pub fn push(&mut self, point: SeriesPoint) {
        if self.motions_in_last == self.motions_per_point || self.points.is_empty() {
            if self.points.len() == Self::MAX_POINTS {
                self.halve();
            }
            self.points.push(point);
            self.motions_in_last = 1;
        } else if let Some(last) = self.points.last_mut() {
            *last = merged(last, &point);
            self.motions_in_last += 1;
        }
    }

    /// The points so far.
    #[must_use]
    pub fn points(&self) -> &[SeriesPoint] {
        &self.points
    }

    fn halve(&mut self) {
        self.points = self
            .points
            .chunks(2)
            .map(|pair| pair.iter().skip(1).fold(pair[0], |whole, part| merged(&whole, part)))
            .collect();
        self.motions_per_point *= 2;
    }
}

fn merged(a: &SeriesPoint, b: &SeriesPoint) -> SeriesPoint {
    SeriesPoint {
        path_mm: b.path_mm,
        line: if b.before_mm > a.before_mm { b.line } else { a.line },
        before_mm: a.before_mm.max(b.before_mm),
        after_mm: a.after_mm.max(b.after_mm),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_series_stays_short_and_keeps_its_peaks() {
        let mut series = Series::default();
        for index in 0..100_000_u32 {
            let before_mm = if index == 77_777 { 1.0 } else { 0.001 };
            let line = u64::from(index) + 1;
            series.push(SeriesPoint { path_mm: f64::from(index), line, before_mm, after_mm: 0.0005 });
        }
        assert!(series.points().len() <= Series::MAX_POINTS);
        let peak = series.points().iter().find(|point| point.before_mm > 0.5);
        assert_eq!(peak.map(|point| point.line), Some(77_778));
        assert!(series.points().windows(2).all(|pair| pair[0].path_mm < pair[1].path_mm));
    }
}
