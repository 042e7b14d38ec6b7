//! The points of a compensated program's figure.

use crate::plot::DeviationPoint;
use crate::wire::DeviationSeries;

/// The points of a report's series.
pub(super) fn points_of(series: &DeviationSeries) -> Vec<DeviationPoint> {
    DeviationPoint::zipped(&series.path_mm, &series.line, &series.before_um, &series.after_um)
}
