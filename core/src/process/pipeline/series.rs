//! Values along a program, down-sampled while they stream by, and the deviation along the path as one of them.

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

/// One point of a series, which may stand for several motions.
pub trait Bucket: Copy {
    /// The point for the motions of both; `later` follows.
    #[must_use]
    fn merged(self, later: &Self) -> Self;
}

/// A series of at most [`Buckets::MAX_POINTS`] points for any length of program. When it is full, neighbours are
/// merged, and every later point covers twice as many motions.
#[derive(Debug, Clone, PartialEq)]
pub struct Buckets<P> {
    points: Vec<P>,
    motions_per_point: u64,
    motions_in_last: u64,
}

/// The deviation along the path.
pub type Series = Buckets<SeriesPoint>;

impl<P> Default for Buckets<P> {
    fn default() -> Self {
        Self { points: Vec::new(), motions_per_point: 1, motions_in_last: 0 }
    }
}

impl<P: Bucket> Buckets<P> {
    /// Most points kept.
    pub const MAX_POINTS: usize = 2000;

    /// Adds one motion.
    pub fn push(&mut self, point: P) {
        if self.motions_in_last == self.motions_per_point || self.points.is_empty() {
            if self.points.len() == Self::MAX_POINTS {
                self.halve();
            }
            self.points.push(point);
            self.motions_in_last = 1;
        } else if let Some(last) = self.points.last_mut() {
            *last = last.merged(&point);
            self.motions_in_last += 1;
        }
    }

    /// The points so far.
    #[must_use]
    pub fn points(&self) -> &[P] {
        &self.points
    }

    fn halve(&mut self) {
        let halved = self.points.chunks(2).map(|pair| pair.iter().skip(1).fold(pair[0], P::merged));
        self.points = halved.collect();
        self.motions_per_point *= 2;
    }
}

impl Bucket for SeriesPoint {
    fn merged(self, later: &Self) -> Self {
        Self {
            path_mm: later.path_mm,
            line: if later.before_mm > self.before_mm { later.line } else { self.line },
            before_mm: self.before_mm.max(later.before_mm),
            after_mm: self.after_mm.max(later.after_mm),
        }
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
