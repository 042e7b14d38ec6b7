//! Radius error of a circle, magnified about the ideal circle (P2 Fig. 7, 9).

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::PlotFault;
use super::style::{GRID, MUTED, colour, legend, plain, round_down, swatch};
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
    /// Radius of the circle \[mm\].
    pub radius_mm: f64,
    /// The curves.
    pub curves: &'a [PolarCurve<'a>],
    /// Amplitude \[µm\] and direction of the major axis \[rad\] of the oval.
    pub oval: Option<(f64, f64)>,
}

const SIDE: u32 = 760;
/// Half the width of the figure in radii.
const EDGE: f64 = 1.45;
/// The largest error is drawn as this share of the radius, or a little less.
const LARGEST_SHARE: f64 = 0.25;

/// Draws the ideal circle, each curve at `r + magnification ΔR`, the magnification and a mark of its scale, and the
/// oval's major axis. The magnification is 1, 2 or 5 times a power of ten. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn polar_contour(figure: &PolarFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw(figure: &PolarFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, (SIDE, SIDE)).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let radius_um = figure.radius_mm * crate::units::UM_PER_MM;
    let errors = figure.curves.iter().flat_map(|curve| curve.points.iter().map(|(_, error)| error.abs()));
    let largest_um = errors.filter(|error| error.is_finite()).fold(0.0, f64::max);
    let magnification =
        if largest_um > 0.0 { round_down(LARGEST_SHARE * radius_um / largest_um) } else { 1.0 };
    let area = root.titled(figure.title, ("sans-serif", 18)).ok()?;
    // A circle must look like a circle, whatever space the title takes.
    let (width, height) = area.dim_in_pixel();
    let wide = EDGE * f64::from(width.max(1)) / f64::from(height.max(1));
    let mut chart = ChartBuilder::on(&area).build_cartesian_2d(-wide..wide, -EDGE..EDGE).ok()?;
    let at = |phi: f64, radius: f64| {
        let (sin, cos) = trig::sin_cos(phi);
        (radius * cos, radius * sin)
    };
    let label_style = ("sans-serif", 14).into_font().color(&MUTED).pos(Pos::new(HPos::Center, VPos::Center));
    for eighth in 0..8_u32 {
        let phi = f64::from(eighth) * std::f64::consts::FRAC_PI_4;
        chart.draw_series([PathElement::new([(0.0, 0.0), at(phi, 1.3)], GRID)]).ok()?;
        chart
            .draw_series([Text::new(format!("{}°", eighth * 45), at(phi, 1.37), label_style.clone())])
            .ok()?;
    }
    let circle = (0..=360_u32).map(|degree| at(f64::from(degree).to_radians(), 1.0));
    chart
        .draw_series(DashedLineSeries::new(circle, 6, 4, MUTED.stroke_width(2)))
        .ok()?
        .label(format!("ideal circle, r = {} mm", plain(figure.radius_mm)))
        .legend(swatch(MUTED.stroke_width(2)));
    for (index, curve) in figure.curves.iter().enumerate() {
        let points = curve.points.iter().filter(|(phi, error)| phi.is_finite() && error.is_finite());
        let line = points.map(|(phi, error)| at(*phi, 1.0 + magnification * error / radius_um));
        chart
            .draw_series(LineSeries::new(line, colour(index).stroke_width(2)))
            .ok()?
            .label(curve.label)
            .legend(swatch(colour(index).stroke_width(3)));
    }
    if let Some((amplitude_um, direction)) = figure.oval.filter(|(amplitude, _)| *amplitude > 0.0) {
        let ends = [at(direction, -1.2), at(direction, 1.2)];
        let (amplitude, degrees) = (plain(amplitude_um), plain(direction.to_degrees()));
        chart
            .draw_series(DashedLineSeries::new(ends, 3, 5, BLACK.mix(0.6).stroke_width(1)))
            .ok()?
            .label(format!("major axis at {degrees}°, second harmonic {amplitude} µm"))
            .legend(swatch(BLACK.mix(0.6).stroke_width(1)));
    }
    let mark_um = round_down(0.2 * radius_um / magnification);
    let length = magnification * mark_um / radius_um;
    let (x, y) = (-EDGE + 0.08, -EDGE + 0.08);
    let mark = [(x, y + 0.03), (x, y), (x + length, y), (x + length, y + 0.03)];
    chart.draw_series([PathElement::new(mark, BLACK.stroke_width(2))]).ok()?;
    let style = ("sans-serif", 14).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Bottom));
    let text = format!("{} µm, error magnified {} times", plain(mark_um), plain(magnification));
    chart.draw_series([Text::new(text, (x, y + 0.04), style)]).ok()?;
    legend(&mut chart, SeriesLabelPosition::MiddleMiddle, 0.9)?;
    drop(chart);
    root.present().ok()
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
            radius_mm: 60.0,
            curves: &[PolarCurve { label: "X 30, C 25 1/s", points: &points }],
            oval: Some((100.0, 135_f64.to_radians())),
        };
        let svg = polar_contour(&figure).expect("a figure");
        // 15 mm for the largest error of 0.1 mm: 100 times.
        for part in [
            "magnified 100 times",
            "100 µm",
            "major axis at 135°",
            "ideal circle, r = 60 mm",
            "X 30, C 25",
            "315°",
        ] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, polar_contour(&figure).expect("a figure"));
    }

    #[test]
    fn no_error_at_all_and_what_is_no_number_are_drawn() {
        for points in [vec![], vec![(0.0, 0.0), (1.0, 0.0)], vec![(0.0, f64::NAN), (1.0, 1e12)]] {
            let curves = [PolarCurve { label: "", points: &points }];
            let figure = PolarFigure { title: "", radius_mm: 1.0, curves: &curves, oval: None };
            let svg = polar_contour(&figure).expect("a figure");
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
