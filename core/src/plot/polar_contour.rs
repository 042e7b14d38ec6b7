//! Radius error of a circle, magnified about the ideal circle (P2 Fig. 7, 9).

use super::axis::{plain, round_down, round_up};
use super::chart::{Chart, Sample};
use super::svg::{Anchor, At, BLACK, Dot, GRID, Lettering, MUTED, Stroke, whole};
use crate::geometry::trig;

/// The radius error of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarCurve<'a> {
    /// Its name.
    pub label: &'a str,
    /// φ of the command \[rad\] and ΔR \[µm\], positive outside.
    pub points: &'a [(f64, f64)],
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct PolarFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// Name of the circle without an error: `ideal circle`.
    pub circle: &'a str,
    /// Its radius \[mm\].
    pub radius_mm: f64,
    /// The curves.
    pub curves: &'a [PolarCurve<'a>],
    /// Amplitude \[µm\] and direction of the major axis \[rad\] of the oval.
    pub oval: Option<(f64, f64)>,
}

/// Width of the figure and height of its circles.
const SIDE: f64 = 760.0;
/// Half of the figure in radii of the ideal circle.
const EDGE: f64 = 1.58;
/// The largest error is drawn as this share of the radius, or a little less.
const LARGEST_SHARE: f64 = 0.4;
/// Distance of two rings of the scale, in radii, at least.
const RING_SHARE: f64 = 0.13;
/// Direction of the numbers of the radial scale: between two spokes, and steep, so that they are below each other
/// \[rad\].
const SCALE_AT: f64 = 3.0 * std::f64::consts::FRAC_PI_8;
/// Between two points, the error is drawn as changing evenly with the angle: in steps of this \[rad\].
const STEP: f64 = 0.03;
/// Readings are drawn as dots if they are not more.
const MOST_DOTS: usize = 120;
const IDEAL: Stroke = Stroke::new(BLACK, 1.4).dashed("6 4");
const OVAL: Stroke = Stroke::new(MUTED, 1.4).dashed("12 3 2 3");

/// Draws each curve at `r + magnification ΔR` over a radial scale of the error, the ideal circle, and the oval's major
/// axis. The magnification is 1, 2 or 5 times a power of ten. Same numbers, same bytes.
#[must_use]
pub fn polar_contour(figure: &PolarFigure<'_>) -> String {
    let radius_um = figure.radius_mm * crate::units::UM_PER_MM;
    let errors = figure.curves.iter().flat_map(|curve| curve.points.iter().map(|(_, error)| error.abs()));
    let largest_um = errors.filter(|error| error.is_finite()).fold(0.0, f64::max);
    let magnification =
        if largest_um > 0.0 { round_down(LARGEST_SHARE * radius_um / largest_um) } else { 1.0 };
    let mut chart = Chart::of_width(figure.title, SIDE);
    let top = chart.take(SIDE - 40.0);
    let (middle, unit) = ((0.5 * SIDE, top + 0.5 * (SIDE - 40.0)), (0.5 * SIDE - 20.0) / EDGE);
    let at = |phi: f64, radius: f64| -> At {
        let (sin, cos) = trig::sin_cos(phi);
        (middle.0 + unit * radius * cos, middle.1 - unit * radius * sin)
    };
    let of_error = |error_um: f64| 1.0 + magnification * error_um / radius_um;
    let step_um = round_up(RING_SHARE * radius_um / magnification);
    // As many rings as fit.
    let rings = (LARGEST_SHARE * radius_um / (magnification * step_um) + 1e-9).floor().min(MOST_RINGS);
    let grid = Stroke::new(GRID, 1.0);
    for eighth in 0..8_u32 {
        let phi = f64::from(eighth) * std::f64::consts::FRAC_PI_4;
        chart.drawing.line(&[at(phi, of_error(-rings * step_um)), at(phi, of_error(rings * step_um))], grid);
        let (x, y) = at(phi, 1.5);
        let lettering = Lettering::new(13.0, MUTED, Anchor::Middle);
        chart.drawing.text((x, y + 4.5), &format!("{}°", eighth * 45), lettering);
    }
    let marks: Vec<f64> =
        (1..=whole(rings)).flat_map(|ring| [-1.0, 1.0].map(|sign| sign * ring as f64 * step_um)).collect();
    for error_um in marks.iter().copied() {
        chart.drawing.ring(middle, unit * of_error(error_um), grid);
    }
    chart.drawing.ring(middle, unit, IDEAL);
    let mut largest = Vec::new();
    for (index, curve) in figure.curves.iter().enumerate() {
        let points: Vec<(f64, f64)> = curve
            .points
            .iter()
            .copied()
            .filter(|(phi, error)| phi.is_finite() && error.is_finite())
            .collect();
        let line: Vec<At> =
            filled(&points).into_iter().map(|(phi, error)| at(phi, of_error(error))).collect();
        let stroke = Stroke::of_curve(index);
        chart.drawing.line(&line, stroke);
        if points.len() <= MOST_DOTS {
            for (phi, error) in points {
                chart.drawing.dot(at(phi, of_error(error)), 3.0, Dot::Disk(stroke.ink));
            }
            chart.explain(Sample::Dotted(stroke, Dot::Disk(stroke.ink)), curve.label);
        } else {
            chart.explain(Sample::Line(stroke), curve.label);
        }
        largest.push(curve.label);
    }
    for error_um in marks.into_iter().chain([0.0]) {
        let (x, y) = at(SCALE_AT, of_error(error_um));
        let sign = if error_um > 0.0 { "+" } else { "" };
        let unit = if error_um == 0.0 { " µm" } else { "" };
        let lettering = Lettering::new(12.0, BLACK, Anchor::Middle).with_halo();
        chart.drawing.text((x, y + 4.0), &format!("{sign}{}{unit}", plain(error_um)), lettering);
    }
    chart.explain(Sample::Line(IDEAL), format!("{}, r = {} mm", figure.circle, plain(figure.radius_mm)));
    if let Some((amplitude_um, direction)) = figure.oval.filter(|(amplitude, _)| *amplitude > 0.0) {
        let (amplitude, degrees) = (plain(amplitude_um), plain(direction.to_degrees()));
        chart.drawing.line(&[at(direction, -1.45), at(direction, 1.45)], OVAL);
        let text = format!("major axis at {degrees}°, second harmonic {amplitude} µm");
        chart.explain(Sample::Line(OVAL), text);
    }
    let scale = format!("rings every {} µm, error magnified {} times", plain(step_um), plain(magnification));
    chart.explain(Sample::Note, scale.clone());
    chart.finish(&format!(
        "Radius error about the {} of {} mm: {scale}. Largest error: {} µm. Curves: {}.",
        figure.circle,
        plain(figure.radius_mm),
        plain(largest_um),
        largest.join("; ")
    ))
}

/// Most rings of the scale on each side of the ideal circle.
const MOST_RINGS: f64 = 5.0;

/// The curve with points between its own, so that a chord does not look like an error.
fn filled(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
    for (from, to) in points.iter().zip(points.iter().skip(1)) {
        let turn = to.0 - from.0;
        // The shorter way: angles may begin again after a lap.
        let turn = turn - std::f64::consts::TAU * (turn / std::f64::consts::TAU).round();
        let steps = (turn.abs() / STEP).ceil().max(1.0);
        all.extend((1..=whole(steps)).map(|step| {
            let share = step as f64 / steps;
            (from.0 + share * turn, from.1 + share * (to.1 - from.1))
        }));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figure_states_magnification_scale_and_oval() {
        let points: Vec<(f64, f64)> = (0..720_u32)
            .map(|k| f64::from(k).to_radians() / 2.0)
            .map(|phi| (phi, -100.0 * (2.0 * phi).sin()))
            .collect();
        let figure = PolarFigure {
            title: "circle",
            circle: "ideal circle",
            radius_mm: 60.0,
            curves: &[PolarCurve { label: "X 30, C 25 1/s", points: &points }],
            oval: Some((100.0, 135_f64.to_radians())),
        };
        let svg = polar_contour(&figure);
        // Up to 24 mm for the largest error of 0.1 mm: 200 times.
        for part in [
            "magnified 200 times",
            "rings every 50 µm",
            "major axis at 135°",
            "ideal circle, r = 60 mm",
            "X 30, C 25",
            "315°",
        ] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, polar_contour(&figure));
    }

    #[test]
    fn readings_far_apart_lie_on_arcs() {
        let quarter = [(0.0, 1.0), (std::f64::consts::FRAC_PI_2, 3.0)];
        let all = filled(&quarter);
        assert!(all.len() > 50 && all.windows(2).all(|pair| pair[1].0 - pair[0].0 <= STEP + 1e-12));
        assert!(all.iter().all(|(phi, error)| (error - 1.0 - 2.0 * phi / quarter[1].0).abs() < 1e-12));
        // From 350° to 10° it is 20° further.
        let over_zero = filled(&[(350_f64.to_radians(), 0.0), (10_f64.to_radians(), 0.0)]);
        assert!(over_zero.len() < 20);
    }

    #[test]
    fn no_error_at_all_and_what_is_no_number_are_drawn() {
        for points in [vec![], vec![(0.0, 0.0), (1.0, 0.0)], vec![(0.0, f64::NAN), (1.0, 1e12)]] {
            let curves = [PolarCurve { label: "", points: &points }];
            let figure = PolarFigure { title: "", circle: "", radius_mm: 1.0, curves: &curves, oval: None };
            let svg = polar_contour(&figure);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
