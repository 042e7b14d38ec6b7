//! The figures of the servo operations.

use axum::response::{IntoResponse, Response};
use http::header::CONTENT_TYPE;
use serde::{Deserialize, Serialize};

use crate::description::{IntoParams, ToSchema};
use crate::http::contour_figure::contour_error;
use crate::plot::{
    FollowingErrorCurve, FollowingErrorFigure, PolarCurve, PolarFigure, SweepFigure,
    following_error_over_time, plain, polar_contour, sweep_curves, sweep_map,
};
use crate::servo::AxisLetter;
use crate::wire::{GainScales, ServoPathDoc, SimulationAnswer, SweepAnswer};

/// Media type of a figure.
pub(super) const SVG: &str = "image/svg+xml";

/// Figures of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum SimulationPlot {
    /// Radius error about the ideal circle; only for circles.
    Polar,
    /// Following errors over time.
    FollowingError,
    /// Contour error over time.
    ContourError,
}

/// The figure to draw if the answer is a figure.
#[derive(Debug, Clone, Copy, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct SimulationFigure {
    /// With `Accept: image/svg+xml`; default polar for a circle, the contour error for other paths.
    #[param(inline)]
    plot: Option<SimulationPlot>,
}

/// Figures of a sweep.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum SweepPlot {
    /// One curve over the feed for each row of gains.
    #[default]
    Curves,
    /// Gains and feeds as a grid of coloured cells.
    Map,
}

/// The figure to draw if the answer is a figure.
#[derive(Debug, Clone, Copy, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct SweepFigureChoice {
    /// With `Accept: image/svg+xml`.
    #[param(inline)]
    plot: Option<SweepPlot>,
}

/// A figure as a response.
pub(super) fn respond(svg: String) -> Response {
    ([(CONTENT_TYPE, SVG)], svg).into_response()
}

impl SimulationFigure {
    /// The figure of a simulation with these factors of the position gains.
    pub(super) fn draw(
        self,
        path: &ServoPathDoc,
        feed: f64,
        gains: &GainScales,
        answer: &SimulationAnswer,
    ) -> String {
        let radius_mm = path.circle_radius_mm();
        let gains: Vec<String> =
            gains.iter().map(|(letter, scale)| format!("{letter} × {}", plain(*scale))).collect();
        let gains = if gains.is_empty() { "as set".to_owned() } else { gains.join(", ") };
        let title = format!("{} at {feed} {}, position gains {gains}", path.title(), path.feed_unit());
        let samples = &answer.samples;
        let wanted = self.plot.unwrap_or(if radius_mm.is_some() {
            SimulationPlot::Polar
        } else {
            SimulationPlot::ContourError
        });
        match (wanted, radius_mm) {
            (SimulationPlot::Polar, Some(radius_mm)) => {
                let points: Vec<(f64, f64)> = samples
                    .t_s
                    .iter()
                    .zip(samples.phi_deg.iter().zip(&samples.contour_error_um))
                    .filter(|(t_s, _)| **t_s >= answer.judged_from_s)
                    .map(|(_, (phi_deg, error_um))| (phi_deg.to_radians(), *error_um))
                    .collect();
                let label = format!("radius error, largest {} µm", plain(answer.contour_error.max_abs_um));
                let oval = answer.contour_error.oval;
                polar_contour(&PolarFigure {
                    title: &title,
                    circle: "ideal circle",
                    radius_mm,
                    curves: &[PolarCurve { label: &label, points: &points }],
                    oval: oval.map(|oval| (oval.amplitude_um, oval.major_axis_deg.to_radians())),
                })
            }
            (SimulationPlot::FollowingError, _) => {
                let maps = [&samples.following_error_um, &samples.following_error_urad];
                let curves: Vec<FollowingErrorCurve<'_>> = maps
                    .into_iter()
                    .flatten()
                    .filter_map(|(letter, errors)| {
                        let axis = letter.parse().ok().and_then(AxisLetter::from_char)?;
                        Some(FollowingErrorCurve {
                            axis: axis.as_char(),
                            is_linear: axis.is_linear(),
                            errors,
                        })
                    })
                    .collect();
                following_error_over_time(&FollowingErrorFigure {
                    title: &title,
                    time_s: &samples.t_s,
                    curves: &curves,
                    judged_from_s: answer.judged_from_s,
                })
            }
            (SimulationPlot::Polar | SimulationPlot::ContourError, _) => {
                contour_error(&title, samples, answer.judged_from_s)
            }
        }
    }
}

impl SweepFigureChoice {
    /// The figure of a sweep.
    pub(super) fn draw(self, path: &ServoPathDoc, answer: &SweepAnswer) -> String {
        let title = path.title();
        let max_abs_um: Vec<Vec<Option<f64>>> = answer
            .contour_error
            .iter()
            .map(|row| row.iter().map(|cell| cell.map(|error| error.max_abs_um)).collect())
            .collect();
        let figure = SweepFigure {
            title: &title,
            gains: &answer.gains,
            feeds: &answer.feed_mm_per_min,
            feed_unit: path.feed_unit(),
            max_abs_um: &max_abs_um,
        };
        match self.plot.unwrap_or_default() {
            SweepPlot::Curves => sweep_curves(&figure),
            SweepPlot::Map => sweep_map(&figure),
        }
    }
}
