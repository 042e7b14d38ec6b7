//! The contour error as a figure, along a path or along a program.

use crate::plot::{ContourFigure, ContourPoint, contour_error_along, plain};
use crate::wire::{ServoReport, ServoSamples};

/// The contour error over the time of these samples.
pub(super) fn contour_error(title: &str, samples: &ServoSamples, judged_from_s: f64) -> String {
    let columns = samples.t_s.iter().zip(&samples.contour_error_um).enumerate();
    let points: Vec<ContourPoint> = columns
        .map(|(k, (time_s, contour_um))| ContourPoint {
            time_s: *time_s,
            line: samples.line.get(k).copied().unwrap_or(0),
            contour_um: *contour_um,
            axis_urad: samples.axis_error_urad.get(k).copied(),
        })
        .collect();
    contour_error_along(&ContourFigure { title, points: &points, judged_from_s })
}

/// The contour error along a program.
pub(super) fn program_contour_error(name: &str, report: &ServoReport) -> String {
    let title = format!(
        "{name}: {} motions, largest contour error {} µm",
        report.motions_simulated,
        plain(report.contour_error.max_abs_um)
    );
    contour_error(&title, &report.samples, 0.0)
}
