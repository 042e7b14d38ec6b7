//! A location error over the runs, with expanded uncertainties.

use super::axis::{Axis, civil, plain, range};
use super::chart::{APPLIED, Chart, Sample, TALL};
use super::svg::{BLACK, Dot, INKS, MUTED, Stroke};

/// One run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrendMark {
    /// Time of the measurement: days since 1970-01-01, UTC.
    pub days: f64,
    /// The value of the error.
    pub value: f64,
    /// Its standard uncertainty, if there is one.
    pub standard_uncertainty: Option<f64>,
    /// Whether the run determines it.
    pub identifiable: bool,
    /// Whether a revision of the profile has its errors.
    pub applied: bool,
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct TrendFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// Name and unit of the error.
    pub error_name: &'a str,
    /// Unit of the error.
    pub unit: &'a str,
    /// The runs, oldest first.
    pub runs: &'a [TrendMark],
    /// The value in the machine's profile, with its revision.
    pub profile: Option<(f64, i64)>,
    /// The largest allowed size of the error.
    pub limit: Option<f64>,
}

/// Bars reach two standard uncertainties in each direction: about 95 %.
const COVERAGE: f64 = 2.0;
const PROFILE: Stroke = Stroke::new(INKS[2], 1.8).dashed("10 3 2 3");
const LIMIT: Stroke = Stroke::new(INKS[1], 1.6).dashed("9 5");
const BAR: Stroke = Stroke::new(INKS[0], 1.8);
/// Half of the width of a bar's ends (pixels).
const END: f64 = 4.0;

/// Draws each run as a dot with its bar of expanded uncertainty (k = 2), and joins the dots. Runs that do not determine
/// the error are hollow, applied runs have a ring. Lines show the value in the profile and the limits; a limit far from
/// every value is named only. Same numbers, same bytes.
#[must_use]
pub fn calibration_trend(figure: &TrendFigure<'_>) -> String {
    let half = |run: &TrendMark| COVERAGE * run.standard_uncertainty.unwrap_or(0.0);
    let ends = figure.runs.iter().flat_map(|run| [run.value - half(run), run.value + half(run)]);
    let profile = figure.profile.filter(|(value, _)| value.is_finite());
    let values: Vec<f64> = ends.chain(profile.map(|(value, _)| value)).filter(|v| v.is_finite()).collect();
    let farthest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let limit = figure.limit.filter(|limit| limit.is_finite());
    let limits = limit.map_or([f64::NAN; 2], |limit| [-limit, limit]);
    // A limit that is never near would make the course look flat.
    let near = limits.map(|level| if level.abs() <= FAR * farthest { level } else { f64::NAN });
    let shown = near.map(|level| {
        let same_side = values.iter().any(|value| value * level > 0.0) || farthest == 0.0;
        if same_side { level } else { f64::NAN }
    });
    let days = match (figure.runs.first(), figure.runs.last()) {
        (Some(first), Some(last)) if last.days - first.days < 0.5 => first.days - 1.0..first.days + 1.0,
        _ => range(figure.runs.iter().map(|run| run.days)),
    };
    let y = Axis::linear(range(values.iter().copied().chain(shown)), figure.error_name);
    let mut chart = Chart::new(figure.title);
    let panel = chart.panel(TALL, Axis::dates(days, "date of the run (UTC)"), y);
    for level in shown.into_iter().filter(|level| level.is_finite()) {
        chart.level(&panel, level, LIMIT);
    }
    if let Some((value, _)) = profile {
        chart.level(&panel, value, PROFILE);
    }
    chart.line(&panel, figure.runs.iter().map(|run| (run.days, run.value)), Stroke::new(MUTED, 1.0));
    for run in figure.runs {
        let ends = [run.value - half(run), run.value + half(run)];
        if run.standard_uncertainty.is_some() {
            chart.line(&panel, ends.map(|end| (run.days, end)), BAR);
            for (x, y) in ends.into_iter().filter_map(|end| panel.at((run.days, end))) {
                chart.drawing.line(&[(x - END, y), (x + END, y)], BAR);
            }
        }
        if run.applied
            && let Some(at) = panel.at((run.days, run.value))
        {
            chart.drawing.ring(at, APPLIED, Stroke::new(BLACK, 1.8));
        }
        let dot = if run.identifiable { Dot::Disk(INKS[0]) } else { Dot::Ring(INKS[0]) };
        chart.dots(&panel, [(run.days, run.value)], 4.0, dot);
    }
    chart.explain(Sample::Dotted(BAR, Dot::Disk(INKS[0])), "run, with expanded uncertainty U (k = 2)");
    if figure.runs.iter().any(|run| !run.identifiable) {
        let text = "hollow: includes errors that the run could not separate from it";
        chart.explain(Sample::Dot(Dot::Ring(INKS[0])), text);
    }
    if figure.runs.iter().any(|run| run.applied) {
        chart.explain(Sample::Applied, "applied to the profile");
    }
    if let Some((value, revision)) = profile {
        let text = format!("in the profile, revision {revision}: {} {}", plain(value), figure.unit);
        chart.explain(Sample::Line(PROFILE), text);
    }
    if let Some(limit) = limit {
        let outside = if shown.iter().any(|level| level.is_finite()) { "" } else { " (outside the figure)" };
        chart.explain(Sample::Line(LIMIT), format!("limits ±{} {}{outside}", plain(limit), figure.unit));
    }
    chart.finish(&described(figure))
}

/// A limit farther than this multiple of the largest value is not drawn.
const FAR: f64 = 4.0;

fn described(figure: &TrendFigure<'_>) -> String {
    let Some(last) = figure.runs.last() else {
        return format!("{}: no run.", figure.error_name);
    };
    let (year, month, day) = civil(last.days.floor());
    let uncertainty =
        last.standard_uncertainty.map_or_else(String::new, |sigma| format!(" ± {}", plain(COVERAGE * sigma)));
    format!(
        "{} of {} runs. The last, of {year}-{month:02}-{day:02}: {}{uncertainty} {}.",
        figure.error_name,
        figure.runs.len(),
        plain(last.value),
        figure.unit
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(days: f64, value: f64, standard_uncertainty: Option<f64>, identifiable: bool) -> TrendMark {
        TrendMark { days, value, standard_uncertainty, identifiable, applied: identifiable }
    }

    fn figure(runs: &[TrendMark], profile: Option<(f64, i64)>, limit: Option<f64>) -> String {
        let error_name = "e_y [µm]";
        calibration_trend(&TrendFigure { title: "A e_y", error_name, unit: "µm", runs, profile, limit })
    }

    #[test]
    fn runs_profile_and_limits_are_drawn_over_dates() {
        let runs = [run(20_161.4, 10.0, Some(0.5), true), run(20_191.4, 14.0, None, false)];
        let svg = figure(&runs, Some((12.34, 3)), Some(15.0));
        for part in [
            "2025-03-17",
            "expanded uncertainty U (k = 2)",
            "hollow",
            "applied to the profile",
            "in the profile, revision 3: 12.3 µm",
            "limits ±15 µm",
            "The last, of 2025-04-13: 14 µm.",
        ] {
            assert!(svg.contains(part), "{part}: {svg}");
        }
        // Two runs, the ring of the applied one, and three samples in the legend with one more ring.
        assert_eq!(svg.matches("<circle").count(), 2 + 1 + 2 + 2);
        assert_eq!(svg, figure(&runs, Some((12.34, 3)), Some(15.0)));
    }

    #[test]
    fn a_limit_far_away_leaves_the_course_readable() {
        let runs = [run(20_000.0, 10.0, None, true), run(20_100.0, 11.0, None, true)];
        let svg = figure(&runs, None, Some(500.0));
        assert!(svg.contains("limits ±500 µm (outside the figure)"));
    }

    #[test]
    fn no_run_and_what_is_no_number_are_drawn() {
        assert!(figure(&[], None, None).ends_with("</svg>\n"));
        assert!(figure(&[run(20_000.0, 0.0, None, true)], None, Some(0.0)).contains("limits ±0"));
        assert!(!figure(&[run(f64::NAN, f64::NAN, None, true)], None, Some(f64::NAN)).contains("NaN"));
    }
}
