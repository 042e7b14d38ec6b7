//! What every step did to every block: streamed, summed up and down-sampled.

use crate::process::fault::Fault;
use crate::process::pipeline::{Bucket, Buckets, MotionChange};

/// Receives every motion that a step changed, in program order, after everything was verified.
pub trait ChangeSink {
    /// Takes the next change.
    ///
    /// # Errors
    /// The change cannot be stored. The compensation then stops.
    fn changed(&mut self, change: &MotionChange) -> std::io::Result<()>;
}

/// For callers that do not need the changes.
impl ChangeSink for () {
    fn changed(&mut self, _: &MotionChange) -> std::io::Result<()> {
        Ok(())
    }
}

impl ChangeSink for Vec<MotionChange> {
    fn changed(&mut self, change: &MotionChange) -> std::io::Result<()> {
        self.push(*change);
        Ok(())
    }
}

/// One bucket of the series, with the largest shares and errors of its motions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ChangePoint {
    /// Line of the upload with the largest sum in the bucket.
    pub line: u64,
    /// Largest move by location errors \[mm\].
    pub location_errors_mm: f64,
    /// Largest move by wear \[mm\].
    pub wear_mm: f64,
    /// Largest correction of a course \[mm\].
    pub cc_mm: f64,
    /// The largest sum \[mm\].
    pub sum_mm: f64,
    /// Largest sum of a motion's errors as programmed \[mm\].
    pub error_before_mm: f64,
    /// Largest sum of a motion's errors as written \[mm\].
    pub error_after_mm: f64,
}

/// Changes along the program.
pub type ChangeSeries = Buckets<ChangePoint>;

impl Bucket for ChangePoint {
    fn merged(self, later: &Self) -> Self {
        Self {
            line: if later.sum_mm > self.sum_mm { later.line } else { self.line },
            location_errors_mm: self.location_errors_mm.max(later.location_errors_mm),
            wear_mm: self.wear_mm.max(later.wear_mm),
            cc_mm: self.cc_mm.max(later.cc_mm),
            sum_mm: self.sum_mm.max(later.sum_mm),
            error_before_mm: self.error_before_mm.max(later.error_before_mm),
            error_after_mm: self.error_after_mm.max(later.error_after_mm),
        }
    }
}

/// The changes of a whole program.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChangeTotals {
    /// Number of motions that a step changed.
    pub motions_changed: u64,
    /// The motions with the largest sum of shares, largest first.
    pub worst: Vec<MotionChange>,
    /// The changes of all motions, down-sampled.
    pub series: ChangeSeries,
}

impl ChangeTotals {
    /// Number of worst motions kept.
    pub const WORST: usize = 10;

    pub(in crate::process) fn take(
        &mut self,
        change: &MotionChange,
        sink: &mut dyn ChangeSink,
    ) -> Result<(), Fault> {
        let &MotionChange { line, location_errors_mm, wear_mm, cc_mm, error, .. } = change;
        self.series.push(ChangePoint {
            line,
            location_errors_mm,
            wear_mm,
            cc_mm,
            sum_mm: change.sum_mm(),
            error_before_mm: error.before.sum_mm(),
            error_after_mm: error.after.sum_mm(),
        });
        if !change.is_change() {
            return Ok(());
        }
        self.motions_changed += 1;
        keep_worst(&mut self.worst, change, MotionChange::sum_mm);
        Ok(sink.changed(change)?)
    }
}

/// Inserts a block among the worst by `measure`. Of equal blocks the first stays first.
pub(in crate::process) fn keep_worst(
    worst: &mut Vec<MotionChange>,
    change: &MotionChange,
    measure: impl Fn(&MotionChange) -> f64,
) {
    let size = measure(change);
    let at = worst.partition_point(|kept| measure(kept) >= size);
    if at < ChangeTotals::WORST {
        worst.truncate(ChangeTotals::WORST - 1);
        worst.insert(at, *change);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::MotionKind;

    fn moved(line: u64, wear_mm: f64) -> MotionChange {
        MotionChange { wear_mm, ..MotionChange::none(line, MotionKind::Linear) }
    }

    #[test]
    fn the_worst_are_the_largest_in_order_and_the_first_of_equals() {
        let mut totals = ChangeTotals::default();
        let mut sink = Vec::new();
        for line in 1..=5000 {
            let size = f64::from(u32::try_from(line * 7919 % 1000).unwrap());
            totals.take(&moved(line, size), &mut sink).unwrap();
        }
        let expected: Vec<f64> =
            (0..ChangeTotals::WORST).map(|k| 999.0 - f64::from(u32::try_from(k / 5).unwrap())).collect();
        assert_eq!(totals.worst.iter().map(MotionChange::sum_mm).collect::<Vec<_>>(), expected);
        assert!(totals.worst[..5].is_sorted_by_key(|change| change.line));
        assert!(totals.worst[5..].is_sorted_by_key(|change| change.line));
        // Every thousandth motion does not move.
        assert_eq!((totals.motions_changed, sink.len()), (4995, 4995));
    }

    #[test]
    fn a_long_series_stays_short_and_keeps_its_peaks() {
        let mut series = ChangeTotals::default();
        for line in 1..=100_000 {
            series.take(&moved(line, if line == 77_777 { 1.0 } else { 0.001 }), &mut ()).unwrap();
        }
        let points = series.series.points();
        assert!(points.len() <= ChangeSeries::MAX_POINTS && points.is_sorted_by_key(|point| point.line));
        let peak = points.iter().find(|point| point.sum_mm > 0.5);
        assert_eq!(peak.map(|point| point.line), Some(77_777));
    }
}
