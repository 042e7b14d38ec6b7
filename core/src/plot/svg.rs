//! The elements of a figure as SVG text. Lengths are in pixels and are written with two decimals.

use std::fmt::{self, Display, Write as _};

/// A colour on a light and on a dark background.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ink {
    light: &'static str,
    dark: &'static str,
}

/// The colour on a light background: a figure is written with these, and its style replaces them on a dark screen.
impl Display for Ink {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.light)
    }
}

const fn ink(light: &'static str, dark: &'static str) -> Ink {
    Ink { light, dark }
}

/// The background.
pub(super) const PAPER: Ink = ink("#ffffff", "#14181d");
/// Text, frames and marks.
pub(super) const BLACK: Ink = ink("#1a1a1a", "#e8eaed");
/// Text and lines that stand back.
pub(super) const MUTED: Ink = ink("#595959", "#a9b1ba");
/// Lines of the grid.
pub(super) const GRID: Ink = ink("#e0e0e0", "#343b43");
/// Text on light and on dark shades; the same on every background.
pub(super) const ON_SHADE: [Ink; 2] = [ink("#101010", "#101010"), ink("#fdfdfd", "#fdfdfd")];
/// Colours of curves, to be distinguished with any colour vision (after Okabe and Ito).
pub(super) const INKS: [Ink; 6] = [
    ink("#0072b2", "#5ab4f0"),
    ink("#d55e00", "#ff9447"),
    ink("#008f68", "#3ccfa0"),
    ink("#b0508a", "#e59ac6"),
    ink("#404048", "#cfcfd6"),
    ink("#7a5c00", "#d8b84a"),
];
/// Dashes of curves: prints without colours can be read too.
const DASHES: [&str; 6] = ["", "9 4", "2 3", "10 3 2 3", "5 2", "14 4"];

/// A fixed colour of a map, the same on every background.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Shade(pub(super) [u8; 3]);

impl Display for Shade {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.0;
        write!(out, "#{red:02x}{green:02x}{blue:02x}")
    }
}

impl Shade {
    /// The shade at a share of the way through `stops`, which are evenly spaced.
    pub(super) fn between(stops: &[[f64; 3]], share: f64) -> Self {
        let last = stops.len().saturating_sub(1);
        let place = share.clamp(0.0, 1.0) * last as f64;
        let below = whole(place).min(last.saturating_sub(1));
        let part = place - below as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 255")]
        Self(std::array::from_fn(|k| {
            let at = |stop: usize| stops.get(stop).map_or(0.0, |stop| stop[k]);
            (at(below) + (at(below + 1) - at(below)) * part).round() as u8
        }))
    }

    /// The colour of text on it.
    pub(super) fn ink(self) -> Ink {
        let [red, green, blue] = self.0.map(f64::from);
        let is_light = 0.299 * red + 0.587 * green + 0.114 * blue > 140.0;
        ON_SHADE[usize::from(!is_light)]
    }
}

/// The whole part of a number, 0 if it is negative.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, saturating")]
pub(super) fn whole(value: f64) -> usize {
    value.max(0.0) as usize
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub(super) ink: Ink,
    pub(super) width: f64,
    /// Lengths of dashes and gaps; empty for a continuous line.
    pub(super) dash: &'static str,
}

impl Stroke {
    pub(super) const fn new(ink: Ink, width: f64) -> Self {
        Self { ink, width, dash: "" }
    }

    pub(super) const fn dashed(self, dash: &'static str) -> Self {
        Self { dash, ..self }
    }

    /// The line of the curve with this index.
    pub(super) fn of_curve(index: usize) -> Self {
        Self { ink: INKS[index % INKS.len()], width: 1.8, dash: DASHES[index % DASHES.len()] }
    }
}

/// A point is drawn as a disk or as a ring of this colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Dot {
    Disk(Ink),
    Ring(Ink),
}

/// Where a text is relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is drawn. Its point is on the base line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lettering {
    pub(super) size: f64,
    pub(super) ink: Ink,
    pub(super) anchor: Anchor,
    /// Background around the letters, for text over lines.
    pub(super) has_halo: bool,
}

impl Lettering {
    pub(super) const fn new(size: f64, ink: Ink, anchor: Anchor) -> Self {
        Self { size, ink, anchor, has_halo: false }
    }

    pub(super) const fn with_halo(self) -> Self {
        Self { has_halo: true, ..self }
    }
}

/// A place in the figure, from its upper left corner.
pub(super) type At = (f64, f64);

/// The elements drawn so far.
#[derive(Debug, Default)]
pub(super) struct Drawing {
    elements: String,
}

impl Drawing {
    fn add(&mut self, element: fmt::Arguments<'_>) {
        // Writing to a text does not fail.
        let _ = self.elements.write_fmt(element);
    }

    pub(super) fn line(&mut self, points: &[At], stroke: Stroke) {
        if points.len() < 2 {
            return;
        }
        let (points, Stroke { ink, width, .. }, dash) = (Places(points), stroke, Dash(stroke.dash));
        self.add(format_args!(
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\"{dash}/>\n"
        ));
    }

    pub(super) fn area(&mut self, points: &[At], ink: Ink, opacity: f64) {
        let points = Places(points);
        self.add(format_args!("<polygon points=\"{points}\" fill=\"{ink}\" fill-opacity=\"{opacity}\"/>\n"));
    }

    /// Boxes of one colour: upper left corner, width and height of each. Neighbours leave no gap.
    pub(super) fn boxes(&mut self, boxes: &[[f64; 4]], colour: &dyn Display) {
        let mut path = String::new();
        for corner_and_size in boxes {
            let [x, y, width, height] = corner_and_size.map(Px);
            // Writing to a text does not fail.
            let _ = write!(path, "M{x},{y}h{width}v{height}h-{width}z");
        }
        self.add(format_args!("<path d=\"{path}\" fill=\"{colour}\" shape-rendering=\"crispEdges\"/>\n"));
    }

    pub(super) fn dot(&mut self, at: At, radius: f64, dot: Dot) {
        let (x, y) = (Px(at.0), Px(at.1));
        let (ink, fill, width) = match dot {
            Dot::Disk(ink) => (ink, ink, 0),
            Dot::Ring(ink) => (ink, PAPER, 2),
        };
        self.add(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{fill}\""));
        if width > 0 {
            self.add(format_args!(" stroke=\"{ink}\" stroke-width=\"{width}\""));
        }
        self.add(format_args!("/>\n"));
    }

    /// A circle without a fill.
    pub(super) fn ring(&mut self, at: At, radius: f64, stroke: Stroke) {
        let (x, y, radius, dash) = (Px(at.0), Px(at.1), Px(radius), Dash(stroke.dash));
        let Stroke { ink, width, .. } = stroke;
        self.add(format_args!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\"{dash}/>\n"
        ));
    }

    pub(super) fn text(&mut self, at: At, text: &str, lettering: Lettering) {
        self.lettered(at, text, lettering, "");
    }

    /// Text that reads upwards.
    pub(super) fn text_up(&mut self, at: At, text: &str, lettering: Lettering) {
        let turn = format!(" transform=\"rotate(-90 {} {})\"", Px(at.0), Px(at.1));
        self.lettered(at, text, lettering, &turn);
    }

    pub(super) fn title(&mut self, at: At, text: &str) {
        self.lettered(at, text, Lettering::new(TITLE_SIZE, BLACK, Anchor::Start), " font-weight=\"bold\"");
    }

    fn lettered(&mut self, at: At, text: &str, lettering: Lettering, more: &str) {
        let Lettering { size, ink, anchor, has_halo } = lettering;
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let halo = if has_halo {
            format!(" stroke=\"{PAPER}\" stroke-width=\"3\" paint-order=\"stroke\"")
        } else {
            String::new()
        };
        let (x, y, text) = (Px(at.0), Px(at.1), Escaped(text));
        self.add(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{ink}\"{anchor}{halo}{more}>{text}</text>\n"
        ));
    }

    /// The whole figure. Title and description are for readers who do not see it.
    pub(super) fn finish(self, (width, height): (f64, f64), title: &str, description: &str) -> String {
        let (width, height) = (Px(width), Px(height));
        let (title, description, elements) = (Escaped(title), Escaped(description), self.elements);
        let inks = [&[PAPER, BLACK, MUTED, GRID][..], &INKS].concat();
        let used = inks.iter().filter(|ink| **ink == PAPER || elements.contains(ink.light));
        let dark = used.fold(String::new(), |rules, Ink { light, dark }| {
            rules
                + &format!(
                    "{MINE} [fill=\"{light}\"]{{fill:{dark}}}{MINE} [stroke=\"{light}\"]{{stroke:{dark}}}"
                )
        });
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"trunnion\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"Arial, Helvetica, sans-serif\" stroke-linejoin=\"round\">\n\
             <title>{title}</title>\n<desc>{description}</desc>\n\
             <style>@media screen and (prefers-color-scheme:dark){{{dark}}}</style>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"{PAPER}\"/>\n{elements}</svg>\n"
        )
    }
}

/// The class of our figures, so that the style of one inside a page is of figures alone.
const MINE: &str = ".trunnion";
pub(super) const TITLE_SIZE: f64 = 17.0;

/// About the width of a text (Arial).
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    let of = |letter: char| match letter {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | 'I' => 0.26,
        ' ' | 'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' => 0.32,
        'm' | 'w' | 'M' | 'W' | '…' => 0.88,
        'A'..='Z' => 0.70,
        _ => 0.56,
    };
    size * text.chars().map(of).sum::<f64>()
}

/// The text, cut at its end so that it is not wider than `room`.
pub(super) fn cut(text: &str, size: f64, room: f64) -> String {
    if width_of(text, size) <= room {
        return text.to_owned();
    }
    let mut kept: String = text.to_owned();
    while kept.pop().is_some() && width_of(&kept, size) > room - size {}
    kept + "…"
}

struct Px(f64);

/// A number far outside the figure would only make a reader fail.
const FARTHEST_PX: f64 = 1e5;

impl Display for Px {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sound = if self.0.is_finite() { self.0.clamp(-FARTHEST_PX, FARTHEST_PX) } else { 0.0 };
        let text = format!("{sound:.2}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        out.write_str(if text == "-0" { "0" } else { text })
    }
}

struct Places<'a>(&'a [At]);

impl Display for Places<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (x, y)) in self.0.iter().enumerate() {
            let space = if index > 0 { " " } else { "" };
            write!(out, "{space}{},{}", Px(*x), Px(*y))?;
        }
        Ok(())
    }
}

struct Dash(&'static str);

impl Display for Dash {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() { Ok(()) } else { write!(out, " stroke-dasharray=\"{}\"", self.0) }
    }
}

struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for letter in self.0.chars() {
            match letter {
                '&' => out.write_str("&amp;")?,
                '<' => out.write_str("&lt;")?,
                '>' => out.write_str("&gt;")?,
                // XML has no control characters.
                letter if letter.is_control() => out.write_char(' ')?,
                // Nor these two.
                '\u{fffe}' | '\u{ffff}' => out.write_char('\u{fffd}')?,
                letter => out.write_char(letter)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_two_decimals_and_every_number_is_sound() {
        for (value, text) in [
            (1.0, "1"),
            (0.125, "0.12"),
            (-0.001, "0"),
            (12.345_678, "12.35"),
            (f64::NAN, "0"),
            (1e300, "100000"),
        ] {
            assert_eq!(Px(value).to_string(), text);
        }
    }

    #[test]
    fn text_of_others_stays_text() {
        let mut drawing = Drawing::default();
        drawing.text((1.0, 2.0), "<script>&\u{1}", Lettering::new(13.0, BLACK, Anchor::Start));
        let svg = drawing.finish((10.0, 10.0), "a & b", "\"<>");
        assert!(svg.contains(">&lt;script&gt;&amp; </text>") && svg.contains("<title>a &amp; b</title>"));
        assert!(!svg.contains("<script>"));
    }

    #[test]
    fn a_dark_screen_has_a_rule_for_every_colour_that_is_used() {
        let mut drawing = Drawing::default();
        drawing.line(&[(0.0, 0.0), (1.0, 1.0)], Stroke::of_curve(1));
        let svg = drawing.finish((10.0, 10.0), "", "");
        assert!(svg.contains("[stroke=\"#d55e00\"]{stroke:#ff9447}") && svg.contains("#14181d"));
        assert!(!svg.contains("#008f68"), "a colour that is not used");
    }

    #[test]
    fn a_long_text_is_cut_to_its_room() {
        assert_eq!(cut("short", 10.0, 100.0), "short");
        let long = "a name that does not end ".repeat(20);
        let shown = cut(&long, 10.0, 200.0);
        assert!(shown.ends_with('…') && width_of(&shown, 10.0) <= 200.0 && shown.len() > 20);
    }
}
