//! Residuals of a virtual cutting over the part, seen from both sides.

use std::collections::BTreeMap;
use std::ops::Range;

use super::axis::{Axis, plain, range};
use super::chart::{Chart, Sample, WIDTH, colour_bar};
use super::svg::{Anchor, BLACK, Dot, Lettering, Shade, whole};
use crate::geometry::Vec3;

/// One sample of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualSample {
    /// Position in W \[mm\].
    pub point_mm: Vec3,
    /// Unit normal out of the part.
    pub normal: Vec3,
    /// + above the surface, − below; `None` if no tool reached the sample \[µm\].
    pub residual_um: Option<f64>,
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct ResidualFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// The samples.
    pub samples: &'a [ResidualSample],
    /// The limit of the residual \[µm\].
    pub limit_um: f64,
}

/// Most cells of a view along its longer side.
const MAX_CELLS: f64 = 100.0;
/// A view that shows less than this share of the samples is left out.
const WORTH_A_VIEW: f64 = 0.02;
/// Number of colours on each side of zero; few, so that neighbouring cells join.
const LEVELS: f64 = 20.0;
/// This share of the samples may be beyond each end of the scale: single points do not take the colours of the others.
const BEYOND: f64 = 0.005;
/// Zero is on the scale unless all residuals are farther from it than this share of the largest.
const NEAR_ZERO: f64 = 0.4;
/// From the surface outwards, and into the part. In print, larger residuals are darker.
const EXCESS: [[f64; 3]; 4] =
    [[238.0, 242.0, 236.0], [146.0, 197.0, 222.0], [33.0, 113.0, 181.0], [8.0, 48.0, 107.0]];
const GOUGE: [[f64; 3]; 4] =
    [[238.0, 242.0, 236.0], [253.0, 187.0, 120.0], [217.0, 95.0, 14.0], [127.0, 39.0, 4.0]];
const UNCUT: Shade = Shade([128, 128, 128]);
const AXES: [&str; 3] = ["X", "Y", "Z"];
/// Space for the colour scale and its numbers.
const SCALE_WIDTH: f64 = 120.0;
/// Height of the views, at most and at least.
const HIGHEST: f64 = 400.0;
const LOWEST: f64 = 200.0;
/// Space at the sides of a view.
const BESIDE: f64 = 106.0;

/// The colours of the residuals: from the least to the largest, apart from a few.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ColourScale {
    low_um: f64,
    high_um: f64,
    /// Whether samples are beyond the low and the high end.
    is_passed: [bool; 2],
}

impl ColourScale {
    fn of(samples: &[ResidualSample], limit_um: f64) -> Self {
        let mut residuals: Vec<f64> = samples.iter().filter_map(|sample| sample.residual_um).collect();
        residuals.retain(|residual| residual.is_finite());
        residuals.sort_by(f64::total_cmp);
        let (Some(least), Some(most)) = (residuals.first(), residuals.last()) else {
            return Self { low_um: 0.0, high_um: limit_um, is_passed: [false; 2] };
        };
        let beyond = whole(BEYOND * residuals.len() as f64);
        let low = residuals.get(beyond).unwrap_or(least);
        let high = residuals.get(residuals.len() - 1 - beyond).unwrap_or(most);
        let with_zero = |end: f64, other: f64| if end.abs() < NEAR_ZERO * other.abs() { 0.0 } else { end };
        let low_um = if *low > 0.0 { with_zero(*low, *high) } else { *low };
        let high_um = if *high < 0.0 { with_zero(*high, *low) } else { *high };
        // A surface without any residual.
        let high_um = if high_um - low_um > 1e-6 { high_um } else { low_um + limit_um.max(1e-3) };
        Self { low_um, high_um, is_passed: [*least < low_um - 1e-9, *most > high_um + 1e-9] }
    }

    fn shade(&self, residual_um: f64) -> Shade {
        let value = residual_um.clamp(self.low_um, self.high_um);
        let (stops, near, far) = if value < 0.0 {
            (&GOUGE, self.high_um.min(0.0), self.low_um)
        } else {
            (&EXCESS, self.low_um.max(0.0), self.high_um)
        };
        let share = if (far - near).abs() > 0.0 { (value - near) / (far - near) } else { 0.0 };
        Shade::between(stops, (share * LEVELS).round() / LEVELS)
    }

    /// Numbers of the scale with their places.
    fn marks(&self) -> Vec<(f64, String)> {
        let axis = Axis::linear(self.low_um..self.high_um, "");
        let marks = axis.marks(8.0).into_iter();
        let mut marks: Vec<_> = marks.map(|(value, text)| (axis.share(value), text)).collect();
        marks
            .retain(|(share, _)| !(self.is_passed[0] && *share < 0.05 || self.is_passed[1] && *share > 0.95));
        if self.is_passed[0] {
            marks.push((0.0, format!("≤ {}", plain(self.low_um))));
        }
        if self.is_passed[1] {
            marks.push((1.0, format!("≥ {}", plain(self.high_um))));
        }
        marks
    }
}

/// Draws the samples as seen from both ends of the axis that most of the surface faces. Each cell shows its worst
/// residual, and rings mark the largest excess and the deepest cut. Same numbers, same bytes.
#[must_use]
pub fn residual_map(figure: &ResidualFigure<'_>) -> String {
    let scale = ColourScale::of(figure.samples, figure.limit_um);
    let facing = |axis: usize| figure.samples.iter().map(|sample| sample.normal[axis].abs()).sum::<f64>();
    let axis = (0..3).fold(2, |best, axis| if facing(axis) > facing(best) { axis } else { best });
    let views: Vec<View> =
        [true, false].into_iter().filter_map(|side| View::of(figure.samples, axis, side)).collect();
    let mut chart = Chart::new(figure.title);
    let room = (WIDTH - SCALE_WIDTH) / views.len().max(1) as f64;
    let heights = views.iter().map(|view| view.height_in([room - BESIDE, HIGHEST]));
    let height = heights.fold(LOWEST, f64::max);
    let top = chart.take(height + 84.0) + 28.0;
    let residuals = || figure.samples.iter().filter(|sample| sample.residual_um.is_some_and(f64::is_finite));
    let of = |sample: &ResidualSample| sample.residual_um.unwrap_or(0.0);
    let most = residuals().max_by(|a, b| of(a).total_cmp(&of(b))).filter(|sample| of(sample) > 0.0);
    let least = residuals().min_by(|a, b| of(a).total_cmp(&of(b))).filter(|sample| of(sample) < 0.0);
    let extremes = [most, least];
    let mut right = 0.0;
    for (index, view) in views.iter().enumerate() {
        right = view.draw(&mut chart, [index as f64 * room, top, room, height], &scale, &extremes);
    }
    let bar = [right + 40.0, top, 20.0, height];
    let at = |share: f64| scale.shade(scale.low_um + share * (scale.high_um - scale.low_um));
    colour_bar(&mut chart, bar, at, &scale.marks());
    chart.drawing.text((bar[0], top - 10.0), "residual [µm]", Lettering::new(13.0, BLACK, Anchor::Start));
    let above = "above the surface (excess)";
    let extent =
        format!("blue: {above}; orange: below it (cut too deep); limit ±{} µm", plain(figure.limit_um));
    chart.explain(Sample::Note, extent);
    if figure.samples.iter().any(|sample| sample.residual_um.is_none()) {
        chart.explain(Sample::Shade(UNCUT), "uncut: no cutter came here");
    }
    let words = [(most, "largest excess"), (least, "deepest cut")].into_iter();
    let words = words.filter_map(|(sample, name)| Some(format!("{name} {} µm", plain(of(sample?)))));
    let words = words.collect::<Vec<_>>().join(", ");
    if !words.is_empty() {
        chart.explain(Sample::Dot(Dot::Ring(BLACK)), words.as_str());
    }
    chart.finish(&format!("Residuals over the part: {words}; limit ±{} µm.", plain(figure.limit_um)))
}

/// The content of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cell {
    Empty,
    Uncut,
    Residual(f64),
}

impl Cell {
    /// The worse of two: uncut is worse than any number, then the larger magnitude.
    fn worse(self, other: Self) -> Self {
        let rank = |cell: Self| match cell {
            Self::Empty => -1.0,
            Self::Residual(value) => value.abs(),
            Self::Uncut => f64::INFINITY,
        };
        if rank(other) > rank(self) { other } else { self }
    }

    fn shade(self, scale: &ColourScale) -> Option<Shade> {
        match self {
            Self::Empty => None,
            Self::Uncut => Some(UNCUT),
            Self::Residual(value) => Some(scale.shade(value)),
        }
    }
}

/// The surface as seen from one end of an axis.
struct View {
    name: String,
    /// The axis from which the surface is seen, and the axes across and up.
    axis: usize,
    from_above: bool,
    across: usize,
    up: usize,
    x_mm: Range<f64>,
    y_mm: Range<f64>,
    cell_mm: f64,
    columns: usize,
    cells: Vec<Cell>,
}

impl View {
    fn of(samples: &[ResidualSample], axis: usize, from_above: bool) -> Option<Self> {
        let (across, up) = [(1, 2), (0, 2), (0, 1)][axis];
        let faces = |sample: &&ResidualSample| (sample.normal[axis] >= 0.0) == from_above;
        let seen = || samples.iter().filter(faces);
        if (seen().count() as f64) < WORTH_A_VIEW * samples.len() as f64 || seen().next().is_none() {
            return None;
        }
        let [x_mm, y_mm] = [across, up].map(|k| range(seen().map(|sample| sample.point_mm[k])));
        let [width_mm, height_mm] = [&x_mm, &y_mm].map(|range| range.end - range.start);
        // If samples are few, a cell holds about four of them.
        let spacing_mm = (width_mm * height_mm / seen().count() as f64).sqrt();
        let cell_mm = (width_mm.max(height_mm) / MAX_CELLS).max(2.0 * spacing_mm);
        let [columns, rows] = [width_mm, height_mm].map(|length_mm| whole(length_mm / cell_mm) + 1);
        let mut cells = vec![Cell::Empty; columns * rows];
        for sample in seen() {
            let column = whole((sample.point_mm[across] - x_mm.start) / cell_mm);
            let row = whole((sample.point_mm[up] - y_mm.start) / cell_mm);
            let new = sample.residual_um.map_or(Cell::Uncut, Cell::Residual);
            if let Some(cell) = cells.get_mut(row * columns + column) {
                *cell = cell.worse(new);
            }
        }
        let name = format!("seen from {}{}", if from_above { "+" } else { "−" }, AXES[axis]);
        Some(Self { name, axis, from_above, across, up, x_mm, y_mm, cell_mm, columns, cells })
    }

    fn mm_per_pixel(&self, room: [f64; 2]) -> f64 {
        let [width_mm, height_mm] = [&self.x_mm, &self.y_mm].map(|range| range.end - range.start);
        (width_mm / room[0]).max(height_mm / room[1])
    }

    /// The height that the view takes in this room.
    fn height_in(&self, room: [f64; 2]) -> f64 {
        (self.y_mm.end - self.y_mm.start) / self.mm_per_pixel(room)
    }

    /// Draws the view, and gives its right edge.
    fn draw(
        &self,
        chart: &mut Chart,
        [left, top, width, height]: [f64; 4],
        scale: &ColourScale,
        extremes: &[Option<&ResidualSample>],
    ) -> f64 {
        // One millimetre is equally long across and up.
        let mm_per_pixel = self.mm_per_pixel([width - BESIDE, height]);
        let room = [(self.x_mm.end - self.x_mm.start) / mm_per_pixel, height];
        let (x_mm, middle) = (self.x_mm.clone(), 0.5 * (self.y_mm.start + self.y_mm.end));
        let y_mm = middle - 0.5 * height * mm_per_pixel..middle + 0.5 * height * mm_per_pixel;
        let [x, y] = [(x_mm, self.across), (y_mm, self.up)]
            .map(|(ends, axis)| Axis::linear(ends, format!("{} [mm]", AXES[axis])));
        let panel = chart.panel_in([left + 80.0, top, room[0], room[1]], x, y);
        let lettering = Lettering::new(14.0, BLACK, Anchor::Middle);
        chart.drawing.text((left + 80.0 + 0.5 * room[0], top - 10.0), &self.name, lettering);
        let size = self.cell_mm / mm_per_pixel;
        // One path for each colour.
        let mut boxes: BTreeMap<Shade, Vec<[f64; 4]>> = BTreeMap::new();
        for (row, cells) in self.cells.chunks(self.columns).enumerate() {
            let upper = self.y_mm.start + (row + 1) as f64 * self.cell_mm;
            let mut start = 0;
            for run in cells.chunk_by(|a, b| a.shade(scale) == b.shade(scale)) {
                let place = panel.at((self.x_mm.start + start as f64 * self.cell_mm, upper));
                start += run.len();
                let shade = run.first().and_then(|cell| cell.shade(scale));
                if let Some((shade, (x, y))) = shade.zip(place) {
                    boxes.entry(shade).or_default().push([x, y, run.len() as f64 * size, size]);
                }
            }
        }
        for (shade, boxes) in boxes {
            chart.drawing.boxes(&boxes, &shade);
        }
        for sample in extremes.iter().flatten() {
            if (sample.normal[self.axis] >= 0.0) == self.from_above {
                let at = (sample.point_mm[self.across], sample.point_mm[self.up]);
                let sign = if sample.residual_um.is_some_and(|um| um > 0.0) { "+" } else { "" };
                let text = format!("{sign}{} µm", plain(sample.residual_um.unwrap_or(0.0)));
                chart.mark(&panel, at, &text);
            }
        }
        left + 80.0 + room[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(x: f64, y: f64, up: f64, residual_um: Option<f64>) -> ResidualSample {
        ResidualSample { point_mm: Vec3::new(x, y, up), normal: Vec3::new(0.0, 0.0, up), residual_um }
    }

    #[test]
    fn both_sides_of_a_plate_are_shown() {
        let mut samples = Vec::new();
        for i in 0..40 {
            for j in 0..30 {
                let (x, y) = (f64::from(i), f64::from(j));
                samples.push(sample(x, y, 1.0, Some(x - 20.0)));
                samples.push(sample(x, y, -1.0, (i > 3).then_some(y)));
            }
        }
        let figure = ResidualFigure { title: "a plate", samples: &samples, limit_um: 30.0 };
        let svg = residual_map(&figure);
        for part in ["a plate", "seen from +Z", "seen from −Z", "X [mm]", "Y [mm]", "uncut", "residual [µm]"]
        {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, residual_map(&figure));
    }

    #[test]
    fn the_worst_of_a_cell_is_shown() {
        let cell = Cell::Empty.worse(Cell::Residual(3.0)).worse(Cell::Residual(-5.0));
        assert_eq!(cell.worse(Cell::Residual(4.0)), Cell::Residual(-5.0));
        assert_eq!(cell.worse(Cell::Uncut), Cell::Uncut);
    }

    #[test]
    fn the_colours_span_the_residuals() {
        let of = |values: &[f64]| {
            let samples: Vec<_> = values.iter().map(|um| sample(0.0, 0.0, 1.0, Some(*um))).collect();
            ColourScale::of(&samples, 30.0)
        };
        let ends = |scale: ColourScale| (scale.low_um, scale.high_um);
        assert_eq!(ends(of(&[60.0, 130.0])), (60.0, 130.0));
        assert_eq!(ends(of(&[6.0, 130.0])), (0.0, 130.0));
        assert_eq!(ends(of(&[-6.0, 130.0])), (-6.0, 130.0));
        assert_eq!(ends(of(&[-130.0, -6.0])), (-130.0, 0.0));
        assert_eq!(ends(of(&[0.0, 0.0])), (0.0, 30.0));
        let scale = of(&[-5.0, 100.0]);
        assert_eq!(scale.shade(-5.0), Shade::between(&GOUGE, 1.0));
        assert_eq!(scale.shade(1e9), Shade::between(&EXCESS, 1.0));
        // One wild point of a thousand is beyond the end of the scale.
        let mut many: Vec<f64> = (0..1000_u32).map(f64::from).collect();
        many.push(1e6);
        let scale = of(&many);
        assert!(scale.high_um < 1000.0 && scale.is_passed == [false, true]);
        assert!(scale.marks().iter().any(|(_, text)| text.starts_with("≥")));
    }

    #[test]
    fn nothing_to_see_is_a_figure_too() {
        let none = ResidualFigure { title: "", samples: &[], limit_um: 30.0 };
        assert!(residual_map(&none).ends_with("</svg>\n"));
    }
}
