//! Residuals of a virtual cutting over the part, seen from both sides.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::PlotFault;
use super::style::{GRID, MUTED, SIZE, mesh, plain, range};
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
const MAX_CELLS: f64 = 150.0;
/// A view that shows less than this share of the samples is left out.
const WORTH_A_VIEW: f64 = 0.02;
/// Number of colours from zero to the end of the scale; few, so that neighbouring cells join.
const LEVELS: f64 = 12.0;
/// The scale ends at the worst residual, but not beyond this number of limits.
const LIMITS_SHOWN: f64 = 10.0;
const EXCESS: RGBColor = RGBColor(0, 90, 160);
const GOUGE: RGBColor = RGBColor(200, 60, 0);
const UNCUT: RGBColor = RGBColor(120, 120, 120);
const NOTHING: (f64, f64, f64) = (236.0, 242.0, 232.0);
const AXES: [&str; 3] = ["X", "Y", "Z"];
/// Width of the colour scale and its numbers (pixels).
const SCALE_WIDTH: i32 = 110;
const TITLE_HEIGHT: i32 = 44;

/// Draws the samples as seen from both ends of the axis that most of the surface faces. Each cell shows its worst
/// residual. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn residual_map(figure: &ResidualFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
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

    fn colour(self, scale_um: f64) -> Option<RGBColor> {
        match self {
            Self::Empty => None,
            Self::Uncut => Some(UNCUT),
            Self::Residual(value) => Some(tint(value, scale_um)),
        }
    }
}

/// The colour of a residual on a scale that ends at `scale_um`.
fn tint(residual_um: f64, scale_um: f64) -> RGBColor {
    let share = ((residual_um.abs() / scale_um).min(1.0) * LEVELS).round() / LEVELS;
    let end = if residual_um < 0.0 { GOUGE } else { EXCESS };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between two colours, so within 0 and 255"
    )]
    let mix = |from: f64, to: u8| (from + (f64::from(to) - from) * share).round() as u8;
    RGBColor(mix(NOTHING.0, end.0), mix(NOTHING.1, end.1), mix(NOTHING.2, end.2))
}

/// The surface as seen from one end of an axis.
struct View {
    name: String,
    /// Indices of the axes across and up.
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
        let [columns, rows] = [width_mm, height_mm].map(|length_mm| index(length_mm / cell_mm) + 1);
        let mut cells = vec![Cell::Empty; columns * rows];
        for sample in seen() {
            let column = index((sample.point_mm[across] - x_mm.start) / cell_mm);
            let row = index((sample.point_mm[up] - y_mm.start) / cell_mm);
            let new = sample.residual_um.map_or(Cell::Uncut, Cell::Residual);
            if let Some(cell) = cells.get_mut(row * columns + column) {
                *cell = cell.worse(new);
            }
        }
        let name = format!("seen from {}{}", if from_above { "+" } else { "−" }, AXES[axis]);
        Some(Self { name, across, up, x_mm, y_mm, cell_mm, columns, cells })
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, scale_um: f64) -> Option<()> {
        // One millimetre is equally long across and up.
        const MARGINS: (f64, f64) = (100.0, 96.0);
        let (width, height) = area.dim_in_pixel();
        let room = [f64::from(width) - MARGINS.0, f64::from(height) - MARGINS.1].map(|room| room.max(10.0));
        let lengths_mm = [&self.x_mm, &self.y_mm].map(|range| range.end - range.start);
        let mm_per_pixel = (lengths_mm[0] / room[0]).max(lengths_mm[1] / room[1]);
        let [x_mm, y_mm] = [(&self.x_mm, room[0]), (&self.y_mm, room[1])].map(|(range, room)| {
            let middle = 0.5 * (range.start + range.end);
            middle - 0.5 * room * mm_per_pixel..middle + 0.5 * room * mm_per_pixel
        });
        let mut chart = ChartBuilder::on(area)
            .caption(&self.name, ("sans-serif", 15))
            .margin(8)
            .x_label_area_size(44)
            .y_label_area_size(68)
            .build_cartesian_2d(x_mm, y_mm)
            .ok()?;
        let name = |axis: usize| format!("{} [mm]", AXES[axis]);
        mesh(&mut chart, &name(self.across), &name(self.up))?;
        for (row, cells) in self.cells.chunks(self.columns).enumerate() {
            let bottom = self.y_mm.start + row as f64 * self.cell_mm;
            let mut start = 0;
            for run in cells.chunk_by(|a, b| a.colour(scale_um) == b.colour(scale_um)) {
                let [left, right] =
                    [start, start + run.len()].map(|column| self.x_mm.start + column as f64 * self.cell_mm);
                start += run.len();
                if let Some(colour) = run.first().and_then(|cell| cell.colour(scale_um)) {
                    let corners = [(left, bottom), (right, bottom + self.cell_mm)];
                    let cells = std::iter::once(Rectangle::new(corners, colour.filled()));
                    chart.draw_series(cells).ok()?;
                }
            }
        }
        Some(())
    }
}

/// The whole part of a number that is not negative.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number, saturating")]
fn index(value: f64) -> usize {
    value.max(0.0) as usize
}

fn draw(figure: &ResidualFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let title = ("sans-serif", 18).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Top));
    let middle = i32::try_from(SIZE.0 / 2).ok()?;
    root.draw(&Text::new(figure.title.to_owned(), (middle, 14), title)).ok()?;
    let worst_um = figure.samples.iter().filter_map(|sample| sample.residual_um).map(f64::abs);
    let worst_um = worst_um.fold(0.0, f64::max);
    let scale_um = worst_um.clamp(figure.limit_um, LIMITS_SHOWN * figure.limit_um);
    let facing = |axis: usize| figure.samples.iter().map(|sample| sample.normal[axis].abs()).sum::<f64>();
    let axis = (0..3).fold(2, |best, axis| if facing(axis) > facing(best) { axis } else { best });
    let views: Vec<View> =
        [true, false].into_iter().filter_map(|side| View::of(figure.samples, axis, side)).collect();
    let (_, below) = root.split_vertically(TITLE_HEIGHT);
    let width = i32::try_from(SIZE.0).ok()?;
    let (maps, scale) = below.split_horizontally(width - SCALE_WIDTH);
    for (view, area) in views.iter().zip(maps.split_evenly((1, views.len().max(1)))) {
        view.draw(&area, scale_um)?;
    }
    let uncut = figure.samples.iter().any(|sample| sample.residual_um.is_none());
    draw_scale(&scale, scale_um, uncut)?;
    drop((maps, scale, below));
    root.present().ok()
}

/// The colours with their values.
fn draw_scale<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, scale_um: f64, uncut: bool) -> Option<()> {
    const TOP: i32 = 60;
    const STEP: i32 = 13;
    let style = ("sans-serif", 13).into_font().color(&MUTED).pos(Pos::new(HPos::Left, VPos::Center));
    area.draw(&Text::new("residual [µm]", (0, TOP - 34), style.clone())).ok()?;
    let steps = index(LEVELS);
    for place in 0..=2 * steps {
        let share = 1.0 - place as f64 / LEVELS;
        let y = TOP + STEP * i32::try_from(place).ok()?;
        let corners = [(0, y - STEP / 2), (22, y + STEP / 2 + 1)];
        area.draw(&Rectangle::new(corners, tint(share * scale_um, scale_um).filled())).ok()?;
        if place % (steps / 2) == 0 {
            area.draw(&Text::new(plain(share * scale_um), (28, y), style.clone())).ok()?;
        }
    }
    if uncut {
        let y = TOP + STEP * i32::try_from(2 * steps + 3).ok()?;
        area.draw(&Rectangle::new([(0, y - 7), (22, y + 7)], UNCUT.filled())).ok()?;
        area.draw(&Rectangle::new([(0, y - 7), (22, y + 7)], GRID)).ok()?;
        area.draw(&Text::new("uncut", (28, y), style)).ok()?;
    }
    Some(())
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
        let svg = residual_map(&figure).expect("a figure");
        for part in ["a plate", "seen from +Z", "seen from −Z", "X [mm]", "Y [mm]", "uncut", "residual [µm]"]
        {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, residual_map(&figure).expect("a figure"));
    }

    #[test]
    fn the_worst_of_a_cell_is_shown() {
        let cell = Cell::Empty.worse(Cell::Residual(3.0)).worse(Cell::Residual(-5.0));
        assert_eq!(cell.worse(Cell::Residual(4.0)), Cell::Residual(-5.0));
        assert_eq!(cell.worse(Cell::Uncut), Cell::Uncut);
        assert_eq!(tint(-1e9, 10.0), GOUGE);
        assert_eq!(tint(10.0, 10.0), EXCESS);
    }

    #[test]
    fn nothing_to_see_is_a_figure_too() {
        let none = ResidualFigure { title: "", samples: &[], limit_um: 30.0 };
        assert!(residual_map(&none).expect("a figure").ends_with("</svg>\n"));
    }
}
