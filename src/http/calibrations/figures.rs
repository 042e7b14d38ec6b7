//! The figures of calibration runs.

use std::collections::BTreeSet;

use axum::response::{IntoResponse, Response};
use http::header::CONTENT_TYPE;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use super::measured_revision;
use crate::description::{IntoParams, ToSchema};
use crate::http::AppState;
use crate::http::problem::{Problem, ProblemType};
use crate::jobs::evaluate_ballbar;
use crate::plot::{
    EccentricityBars, EccentricityFigure, PolarCurve, PolarFigure, TrendFigure, TrendMark, calibration_trend,
    eccentricity_bars, polar_contour,
};
use crate::store::CalibrationRow;
use crate::units::UM_PER_MM;
use crate::wire::{CalibrationDocument, CalibrationKind, CalibrationRequest, Fault, Trend};

/// Media type of a figure.
pub(super) const SVG: &str = "image/svg+xml";

/// Figures of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum CalibrationPlot {
    /// Eccentricities before and after compensation, as bars.
    #[default]
    Eccentricities,
    /// Residuals of one test about the bar's circle, magnified.
    Residuals,
}

/// The figure to draw if the answer is a figure.
#[derive(Debug, Clone, Copy, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct CalibrationFigure {
    /// With `Accept: image/svg+xml`.
    #[param(inline)]
    plot: Option<CalibrationPlot>,
    /// Index of the test whose residuals are drawn, from 0.
    #[param(default = 0)]
    test: Option<usize>,
}

impl CalibrationFigure {
    /// The figure of a run.
    pub(super) async fn respond(self, app: &AppState, run: CalibrationRow) -> Result<Response, Problem> {
        let svg = match self.plot.unwrap_or_default() {
            CalibrationPlot::Eccentricities if run.document.ball_bar.is_none() => {
                let detail = "probed spheres have no eccentricities; the report has what they show";
                return Err(Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new("/plot", detail)]));
            }
            CalibrationPlot::Eccentricities => {
                app.compute.run(move |_stop| eccentricities(&run.document)).await?
            }
            CalibrationPlot::Residuals => {
                let test = self.test.unwrap_or(0);
                let figure = residuals(app, &run, Some(test)).await?.pop();
                figure.ok_or_else(|| {
                    let count = run.document.ball_bar.as_ref().map_or(0, |found| found.tests.len());
                    let detail = format!("test {test} has no readings; the run has {count} tests");
                    Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new("/test", detail)])
                })?
            }
        };
        Ok(([(CONTENT_TYPE, SVG)], svg).into_response())
    }
}

/// The bars of a run.
pub(super) fn eccentricities(document: &CalibrationDocument) -> String {
    let title =
        format!("{}: eccentricities, measured {}", document.machine_id, minute(&document.measured_at));
    let mut labelled: Vec<(String, [f64; 3])> = Vec::new();
    if let Some(ball_bar) = &document.ball_bar {
        let rows = &ball_bar.eccentricities_um;
        for (index, test) in ball_bar.tests.iter().enumerate() {
            let at = |row: &[Option<[f64; 2]>]| row.get(index).copied().flatten();
            let (Some(before), Some(linear), Some(all)) =
                (at(&rows.before), at(&rows.after_linear), at(&rows.after_all))
            else {
                continue;
            };
            let pair = match test.rotary_axis.as_str() {
                "A" => ["y", "z"],
                "B" => ["z", "x"],
                _ => ["x", "y"],
            };
            for (component, name) in pair.into_iter().enumerate() {
                let label = format!("{} {} {name}", test.rotary_axis, test.bar_direction.as_str());
                labelled.push((label, [before[component], linear[component], all[component]]));
            }
        }
    }
    let bars: Vec<EccentricityBars<'_>> =
        labelled.iter().map(|(label, values_um)| EccentricityBars { label, values_um: *values_um }).collect();
    eccentricity_bars(&EccentricityFigure { title: &title, bars: &bars })
}

/// The residuals of each test with readings, or of only one test, about the bar's circle. The run is evaluated again
/// on the revision that it measured.
pub(super) async fn residuals(
    app: &AppState,
    run: &CalibrationRow,
    only: Option<usize>,
) -> Result<Vec<String>, Problem> {
    if run.document.kind != CalibrationKind::RtcpBallbar {
        return Ok(Vec::new());
    }
    let revision = measured_revision(app, run).await?;
    let (_, machine) = revision
        .document
        .profile
        .into_machine()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    let request: CalibrationRequest =
        serde_json::from_str(&run.run).map_err(|fault| Problem::internal(&fault))?;
    app.compute
        .run(move |_stop| {
            let found = evaluate_ballbar(&request, &machine)
                .map_err(|_stored_is_sound| Problem::internal(&"a stored run is no longer accepted"))?;
            let tests = request.tests.iter().flatten().zip(&found.residuals_mm).enumerate();
            Ok(tests
                .filter(|(index, _)| only.is_none_or(|only| only == *index))
                .filter_map(|(_, (test, residuals_mm))| {
                    let readings = test.readings.as_ref()?;
                    let points: Vec<(f64, f64)> = readings
                        .iter()
                        .zip(residuals_mm)
                        .map(|(reading, mm)| (reading.angle_deg.to_radians(), mm * UM_PER_MM))
                        .collect();
                    let (there, back) = there_and_back(&points);
                    let curves = [
                        PolarCurve { label: "there: the axis turns forwards", points: there },
                        PolarCurve { label: "back: the axis turns backwards", points: back },
                    ];
                    let direction = test.bar_direction.as_str();
                    let title = format!("{} axis, bar {direction}: measured minus fitted", test.rotary_axis);
                    Some(polar_contour(&PolarFigure {
                        title: &title,
                        circle: "bar as fitted (outside: bar longer)",
                        radius_mm: request.bar_length_mm.unwrap_or(1.0),
                        curves: if back.is_empty() { &curves[..1] } else { &curves },
                        oval: None,
                    }))
                })
                .collect())
        })
        .await?
}

/// Angles \[rad\] and residuals \[µm\].
type Readings<'a> = &'a [(f64, f64)];

/// The readings until the axis turns back, and those from there on. A single reading at that angle belongs to both.
fn there_and_back(points: Readings<'_>) -> (Readings<'_>, Readings<'_>) {
    let turns = |pair: &[(f64, f64)]| pair.iter().map(|(angle, _)| *angle).reduce(|from, to| to - from);
    let first = points.windows(2).filter_map(turns).find(|turn| *turn != 0.0).unwrap_or(0.0);
    let back = points.windows(2).position(|pair| turns(pair).is_some_and(|turn| turn * first < 0.0));
    let Some(place) = back else { return (points, &[]) };
    let (there, back) = points.split_at(place);
    let is_read_twice = there.last().map(|(angle, _)| *angle) == back.first().map(|(angle, _)| *angle);
    (if is_read_twice { there } else { points.get(..=place).unwrap_or(there) }, back)
}

/// Date, hour and minute of a time as RFC 3339 writes it.
fn minute(time: &str) -> String {
    time.get(..16).map_or_else(|| time.to_owned(), |minute| minute.replace('T', " ") + " UTC")
}

/// The values beside the runs of a trend.
#[derive(Debug, Clone, Default)]
pub(super) struct TrendContext {
    /// Ids of the runs whose errors a revision of the profile has.
    pub(super) applied: BTreeSet<String>,
    /// The value in the profile, and its revision.
    pub(super) profile: Option<(f64, i64)>,
    /// The largest allowed size of the error.
    pub(super) tolerance: Option<f64>,
}

/// The figure of a trend.
pub(super) fn trend_figure(trend: &Trend, context: &TrendContext) -> String {
    let days =
        |text: &str| text.parse::<Timestamp>().map_or(0.0, |time| time.as_second() as f64) / SECONDS_PER_DAY;
    // Counted from the last run, which is always drawn.
    let every = trend.points.len().div_ceil(MOST_DRAWN).max(1);
    let last = trend.points.len().saturating_sub(1);
    let drawn = trend.points.iter().enumerate().filter(|(index, _)| (last - index).is_multiple_of(every));
    let runs: Vec<TrendMark> = drawn
        .map(|(_, point)| point)
        .map(|point| TrendMark {
            days: days(&point.measured_at),
            value: point.value,
            standard_uncertainty: point.standard_uncertainty,
            identifiable: point.identifiable,
            applied: context.applied.contains(&point.calibration_id),
        })
        .collect();
    let thinned = if every > 1 { format!(", every {every} runs one") } else { String::new() };
    let unit = if trend.unit == "urad" { "µrad" } else { "µm" };
    calibration_trend(&TrendFigure {
        title: &format!("{}: {} of the {} axis{thinned}", trend.machine_id, trend.error, trend.axis),
        error_name: &format!("{} [{unit}]", trend.error),
        unit,
        runs: &runs,
        profile: context.profile,
        limit: context.tolerance,
    })
}

/// A figure with more runs than this would not show more.
const MOST_DRAWN: usize = 2000;
const SECONDS_PER_DAY: f64 = 86_400.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_are_split_where_the_axis_turns_back() {
        let points = |angles: &[f64]| angles.iter().map(|angle| (*angle, 0.0)).collect::<Vec<_>>();
        for (angles, there, back) in [
            (&[0.0, 30.0, 60.0, 60.0, 30.0, 0.0][..], 3, 3),
            (&[90.0, 0.0, -90.0, 0.0, 90.0][..], 3, 3),
            (&[0.0, 30.0, 60.0][..], 3, 0),
            (&[5.0][..], 1, 0),
            (&[][..], 0, 0),
        ] {
            let points = points(angles);
            let split = there_and_back(&points);
            assert_eq!((split.0.len(), split.1.len()), (there, back), "{angles:?}");
        }
    }
}
