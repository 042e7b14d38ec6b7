//! The figure of a compensated program.

use crate::plot::{DeviationFigure, DeviationPoint, deviation_along_path};
use crate::wire::DeviationSeries;

/// The points of a report's series.
pub(super) fn points_of(series: &DeviationSeries) -> Vec<DeviationPoint> {
    DeviationPoint::zipped(&series.path_mm, &series.line, &series.before_um, &series.after_um)
}

/// The figure as SVG text. It is empty if it cannot be drawn; the log says why.
pub(super) fn drawn(figure: &DeviationFigure<'_>) -> String {
    deviation_along_path(figure).unwrap_or_else(|fault| {
        tracing::error!(error = %fault, "a figure could not be drawn");
        String::new()
    })
}
