//! A figure of one or more panels above each other, with its legend below them.

use super::axis::Axis;
use super::svg::{
    Anchor, At, BLACK, Dot, Drawing, GRID, INKS, Ink, Lettering, MUTED, Shade, Stroke, TITLE_SIZE, cut,
    whole, width_of,
};

/// Width of a figure.
pub(super) const WIDTH: f64 = 1000.0;
/// Space at the right of the panels.
const RIGHT: f64 = 28.0;
/// Left edge of the title and the legend.
const EDGE: f64 = 18.0;
/// Height of a panel that is alone.
pub(super) const TALL: f64 = 380.0;
/// Height of each of two panels.
pub(super) const HALF: f64 = 220.0;
const NUMBERS: Lettering = Lettering::new(13.0, MUTED, Anchor::Middle);
const NAMES: Lettering = Lettering::new(14.0, BLACK, Anchor::Middle);
/// From one mark to the next, at least.
const PX_PER_MARK: (f64, f64) = (110.0, 48.0);
const SAMPLE: f64 = 34.0;
const ROW: f64 = 22.0;
/// Columns into which a long series is collected; each shows the range of its values.
const COLUMN_PX: f64 = 2.0;

/// Radius of the ring of an applied run.
pub(super) const APPLIED: f64 = 8.0;

/// What the legend shows beside a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sample {
    Line(Stroke),
    /// A line with its points.
    Dotted(Stroke, Dot),
    Dot(Dot),
    /// A dot with the ring of an applied run.
    Applied,
    Area(Ink, f64),
    /// A colour of a map.
    Shade(Shade),
    /// Text alone.
    Note,
}

/// A figure under way.
#[derive(Debug)]
pub(super) struct Chart {
    pub(super) drawing: Drawing,
    width: f64,
    bottom: f64,
    title: String,
    legend: Vec<(Sample, String)>,
}

/// A plot area with its axes.
#[derive(Debug, Clone)]
pub(super) struct Panel {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: Axis,
    y: Axis,
}

impl Panel {
    /// The place of a point; `None` if it is no number.
    pub(super) fn at(&self, (x, y): (f64, f64)) -> Option<At> {
        let at = |x: f64, y: f64| {
            (self.left + self.x.share(x) * self.width, self.top + (1.0 - self.y.share(y)) * self.height)
        };
        (x.is_finite() && y.is_finite()).then(|| at(x, y))
    }

    /// The points as places, in pieces: a point that is no number interrupts a line.
    fn pieces(&self, points: impl Iterator<Item = (f64, f64)>) -> Vec<Vec<At>> {
        let mut pieces = vec![Vec::new()];
        for point in points {
            match (self.at(point), pieces.last_mut()) {
                (Some(at), Some(piece)) => piece.push(at),
                (None, Some(piece)) if !piece.is_empty() => pieces.push(Vec::new()),
                _ => {}
            }
        }
        pieces
    }
}

impl Chart {
    pub(super) fn new(title: &str) -> Self {
        Self::of_width(title, WIDTH)
    }

    pub(super) fn of_width(title: &str, width: f64) -> Self {
        let mut drawing = Drawing::default();
        // Bold letters are wider.
        let room = (width - 2.0 * EDGE) / 1.06;
        drawing.title((EDGE, 30.0), &cut(title, TITLE_SIZE, room));
        Self { drawing, width, bottom: 44.0, title: title.to_owned(), legend: Vec::new() }
    }

    /// Takes space below what is drawn, and gives its upper edge.
    pub(super) fn take(&mut self, height: f64) -> f64 {
        self.bottom += height;
        self.bottom - height
    }

    /// A panel below the others, with its grid, its numbers and the names of its axes.
    pub(super) fn panel(&mut self, height: f64, x: Axis, y: Axis) -> Panel {
        let marks = y.marks(height / PX_PER_MARK.1);
        let widest = marks.iter().map(|(_, text)| width_of(text, NUMBERS.size)).fold(44.0, f64::max);
        let left = EDGE + 24.0 + widest.min(0.3 * self.width) + 8.0;
        let width = self.width - left - RIGHT;
        let below = if x.name.is_empty() { 30.0 } else { 54.0 };
        let top = self.take(height + below + 10.0) + 10.0;
        let panel = Panel { left, top, width, height, x, y };
        self.axes(&panel, &marks);
        panel
    }

    /// A panel in this place, in which a unit is equally long in both directions if the caller's ranges are so.
    pub(super) fn panel_in(&mut self, [left, top, width, height]: [f64; 4], x: Axis, y: Axis) -> Panel {
        let marks = y.marks(height / PX_PER_MARK.1);
        let panel = Panel { left, top, width, height, x, y };
        self.axes(&panel, &marks);
        panel
    }

    fn axes(&mut self, panel: &Panel, y_marks: &[(f64, String)]) {
        let Panel { left, top, width, height, x, y } = panel;
        let (right, bottom) = (left + width, top + height);
        let grid = Stroke::new(GRID, 1.0);
        for (value, text) in x.marks(width / PX_PER_MARK.0) {
            let Some((at, _)) = panel.at((value, y.start())) else { continue };
            if x.has_grid() {
                self.drawing.line(&[(at, *top), (at, bottom)], grid);
            }
            self.drawing.text((at, bottom + 18.0), &text, NUMBERS);
        }
        for (value, text) in y_marks {
            let Some((_, at)) = panel.at((x.start(), *value)) else { continue };
            if y.has_grid() {
                self.drawing.line(&[(*left, at), (right, at)], grid);
            }
            let style = Lettering { anchor: Anchor::End, ..NUMBERS };
            self.drawing.text((left - 8.0, at + 4.5), &cut(text, NUMBERS.size, left - EDGE - 30.0), style);
        }
        let frame = [(*left, *top), (*left, bottom), (right, bottom)];
        self.drawing.line(&frame, Stroke::new(MUTED, 1.0));
        if !x.name.is_empty() {
            self.drawing.text((left + 0.5 * width, bottom + 41.0), &cut(&x.name, NAMES.size, *width), NAMES);
        }
        let middle = (EDGE + 10.0, top + 0.5 * height);
        self.drawing.text_up(middle, &cut(&y.name, NAMES.size, height + 40.0), NAMES);
    }

    /// Adds a row to the legend.
    pub(super) fn explain(&mut self, sample: Sample, text: impl Into<String>) {
        self.legend.push((sample, text.into()));
    }

    pub(super) fn line(
        &mut self,
        panel: &Panel,
        points: impl IntoIterator<Item = (f64, f64)>,
        stroke: Stroke,
    ) {
        for piece in panel.pieces(points.into_iter()) {
            self.drawing.line(&piece, stroke);
        }
    }

    /// A line across the panel.
    pub(super) fn level(&mut self, panel: &Panel, y: f64, stroke: Stroke) {
        self.line(panel, [(panel.x.start(), y), (panel.x.end(), y)], stroke);
    }

    /// A line from the bottom to the top of the panel.
    pub(super) fn upright(&mut self, panel: &Panel, x: f64, stroke: Stroke) {
        self.line(panel, [(x, panel.y.start()), (x, panel.y.end())], stroke);
    }

    /// The surface between two lines with the same places on the x axis: (x, low, high).
    pub(super) fn band(
        &mut self,
        panel: &Panel,
        band: impl IntoIterator<Item = (f64, f64, f64)>,
        ink: Ink,
        opacity: f64,
    ) {
        let sound = band.into_iter().filter_map(|(x, low, high)| panel.at((x, low)).zip(panel.at((x, high))));
        let (mut outline, high): (Vec<At>, Vec<At>) = sound.unzip();
        if outline.len() > 1 {
            outline.extend(high.into_iter().rev());
            self.drawing.area(&outline, ink, opacity);
        }
    }

    pub(super) fn dots(
        &mut self,
        panel: &Panel,
        points: impl IntoIterator<Item = (f64, f64)>,
        radius: f64,
        dot: Dot,
    ) {
        for at in points.into_iter().filter_map(|point| panel.at(point)) {
            self.drawing.dot(at, radius, dot);
        }
    }

    /// A ring with a text above it, or below it if the value is negative.
    pub(super) fn mark(&mut self, panel: &Panel, point: (f64, f64), text: &str) {
        let Some((x, y)) = panel.at(point) else { return };
        self.drawing.dot((x, y), 4.0, Dot::Ring(BLACK));
        let room = 0.5 * width_of(text, 14.0);
        let anchor = match x - panel.left {
            from_left if from_left < room => Anchor::Start,
            from_left if from_left > panel.width - room => Anchor::End,
            _ => Anchor::Middle,
        };
        let lower = if point.1 < 0.0 && y + 24.0 < panel.top + panel.height { 20.0 } else { -10.0 };
        self.drawing.text((x, y + lower), text, Lettering::new(14.0, BLACK, anchor).with_halo());
    }

    /// The number of columns of a panel.
    pub(super) fn columns(panel: &Panel) -> usize {
        whole(panel.width / COLUMN_PX)
    }

    /// The figure as SVG text. The description says in a sentence what it shows.
    pub(super) fn finish(mut self, description: &str) -> String {
        self.draw_legend();
        self.drawing.finish((self.width, self.bottom + 12.0), &self.title, description)
    }

    fn draw_legend(&mut self) {
        const SIZE: f64 = 14.0;
        let room = self.width - 2.0 * EDGE;
        let mut row = self.bottom + ROW - 6.0;
        let mut left = EDGE;
        let legend = std::mem::take(&mut self.legend);
        for (index, (sample, text)) in legend.iter().enumerate() {
            let lead = if *sample == Sample::Note { 0.0 } else { SAMPLE + 8.0 };
            let text = cut(text, SIZE, room - lead);
            let width = lead + width_of(&text, SIZE);
            if index > 0 && left + width > EDGE + room {
                (left, row) = (EDGE, row + ROW);
            }
            self.sample((left, row - 5.0), *sample);
            self.drawing.text((left + lead, row), &text, Lettering::new(SIZE, BLACK, Anchor::Start));
            left += width + 28.0;
        }
        if !legend.is_empty() {
            self.bottom = row;
        }
    }

    fn sample(&mut self, (x, y): At, sample: Sample) {
        let ends = [(x, y), (x + SAMPLE, y)];
        let middle = (x + 0.5 * SAMPLE, y);
        match sample {
            Sample::Line(stroke) => self.drawing.line(&ends, stroke),
            Sample::Dotted(stroke, dot) => {
                self.drawing.line(&ends, stroke);
                self.drawing.dot(middle, 3.5, dot);
            }
            Sample::Dot(dot) => self.drawing.dot(middle, 4.0, dot),
            Sample::Applied => {
                self.drawing.ring(middle, APPLIED, Stroke::new(BLACK, 1.8));
                self.drawing.dot(middle, 4.0, Dot::Disk(INKS[0]));
            }
            Sample::Area(ink, opacity) => {
                let (low, high) = (y + 6.0, y - 6.0);
                self.drawing.area(
                    &[(x, low), (x + SAMPLE, low), (x + SAMPLE, high), (x, high)],
                    ink,
                    opacity,
                );
            }
            Sample::Shade(shade) => self.drawing.boxes(&[[x, y - 7.0, SAMPLE, 13.0]], &shade),
            Sample::Note => {}
        }
    }
}

/// The range of the values in each of at most `columns` columns: (x, least, most). `None` if the points are so few
/// that a line shows them.
pub(super) fn envelope(points: &[(f64, f64)], columns: usize) -> Option<Vec<(f64, f64, f64)>> {
    let (first, last) = (points.first()?.0, points.last()?.0);
    if points.len() <= columns || last <= first {
        return None;
    }
    let width = (last - first) / columns as f64;
    let column = |x: f64| whole((x - first) / width).min(columns - 1);
    let ranges = points.chunk_by(|a, b| column(a.0) == column(b.0)).map(|part| {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (_, value) in part.iter().filter(|(_, value)| value.is_finite()) {
            least = least.min(*value);
            most = most.max(*value);
        }
        let x = part.first().map_or(first, |(x, _)| *x);
        (first + (column(x) as f64 + 0.5) * width, least, most)
    });
    Some(ranges.filter(|(_, least, _)| least.is_finite()).collect())
}

/// A colour scale from the bottom to the top, with marks on its right.
pub(super) fn colour_bar(
    chart: &mut Chart,
    [left, top, width, height]: [f64; 4],
    colours: impl Fn(f64) -> Shade,
    marks: &[(f64, String)],
) {
    const STEPS: u32 = 64;
    let step = height / f64::from(STEPS);
    for k in 0..STEPS {
        let share = (f64::from(k) + 0.5) / f64::from(STEPS);
        let y = top + height - f64::from(k + 1) * step;
        // A little higher: neighbours must not leave a gap when the figure is scaled.
        chart.drawing.boxes(&[[left, y, width, step + if k > 0 { 0.5 } else { 0.0 }]], &colours(share));
    }
    for (share, text) in marks {
        let y = top + (1.0 - share) * height;
        chart.drawing.line(&[(left + width, y), (left + width + 5.0, y)], Stroke::new(MUTED, 1.0));
        let lettering = Lettering::new(13.0, BLACK, Anchor::Start);
        chart.drawing.text((left + width + 9.0, y + 4.5), text, lettering);
    }
    let corners = [(left, top), (left + width, top), (left + width, top + height), (left, top + height)];
    let outline: Vec<At> = corners.iter().copied().chain(corners.first().copied()).collect();
    chart.drawing.line(&outline, Stroke::new(MUTED, 1.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_keeps_every_peak() {
        let mut points: Vec<(f64, f64)> =
            (0..5000_u32).map(|k| (f64::from(k), f64::from(k % 7) - 3.0)).collect();
        points[3333].1 = 99.0;
        points[10].1 = f64::NAN;
        let envelope = envelope(&points, 200).expect("more points than columns");
        assert_eq!(envelope.len(), 200);
        assert!(envelope.iter().all(|(_, least, _)| (*least + 3.0).abs() < 1e-12));
        assert_eq!(envelope.iter().filter(|(_, _, most)| *most > 90.0).count(), 1);
        assert_eq!(super::envelope(&points[..100], 200), None);
    }

    #[test]
    fn a_legend_of_many_rows_makes_the_figure_higher() {
        let height = |entries: usize| {
            let mut chart = Chart::new("title");
            for _ in 0..entries {
                chart.explain(Sample::Line(Stroke::of_curve(1)), "a curve with quite a long name");
            }
            let svg = chart.finish("");
            let (_, rest) = svg.split_once("height=\"").expect("a height");
            rest.split_once('"').expect("its end").0.parse::<f64>().expect("a number")
        };
        assert!(height(20) > height(1) + 3.0 * ROW);
    }
}
