//! An independent witness: reads both programs with a scanner of its own, moves the machine with rotation matrices,
//! and measures the contact's distance from the source's lines by brute force. Shares no code with the crate but the
//! vector type.
#![expect(clippy::float_cmp, reason = "words that were copied are the same to the bit")]

use nalgebra::{Rotation3, Unit, Vector3};

type V = Vector3<f64>;

/// A machine with two table axes, from the bed outward.
#[derive(Debug, Clone, Copy)]
pub struct Tables {
    pub first: (V, V),
    pub second: (V, V),
    pub letters: [char; 2],
    pub offset: V,
    pub corner: f64,
    pub core: f64,
    pub tcp: bool,
}

/// One motion block as the scanner sees it.
#[derive(Debug, Clone, Default)]
pub struct Line {
    pub text: String,
    pub number: usize,
    pub rapid: bool,
    pub inverse_time: bool,
    pub q: V,
    pub angle: [f64; 2],
    pub uvw: Option<V>,
    pub feed: f64,
}

/// What the witness found on the source block with this line.
#[derive(Debug, Clone)]
pub struct Verdict {
    pub line: usize,
    pub before: f64,
    pub after: f64,
    pub parts: usize,
    /// Time of the parts over the time of the source block.
    pub time_ratio: f64,
}

/// Reads motion blocks: words are a letter and a number, everything modal.
pub fn scan(text: &str, letters: [char; 2]) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut now = Line::default();
    for (index, raw) in text.lines().enumerate() {
        let clean: String = raw.split('(').next().unwrap_or("").to_uppercase();
        let mut moved = false;
        let mut uvw = now.uvw;
        let mut stated = 0;
        for (at, letter) in clean.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()) {
            let rest = clean[at + 1..].trim_start();
            let end = rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(rest.len());
            let Ok(value) = rest[..end].parse::<f64>() else { continue };
            match letter {
                'X' | 'Y' | 'Z' => {
                    now.q[(letter as u8 - b'X') as usize] = value;
                    moved = true;
                }
                'U' | 'V' | 'W' => {
                    let mut words = uvw.unwrap_or_else(V::zeros);
                    words[(letter as u8 - b'U') as usize] = value;
                    uvw = Some(words);
                    stated += 1;
                }
                'F' => now.feed = value,
                'G' if value == 0.0 => now.rapid = true,
                'G' if value == 1.0 => now.rapid = false,
                'G' if value == 93.0 => now.inverse_time = true,
                'G' if value == 94.0 => now.inverse_time = false,
                _ => {
                    if let Some(k) = letters.iter().position(|l| *l == letter) {
                        now.angle[k] = value;
                        moved = true;
                    }
                }
            }
        }
        if moved {
            let uvw = if stated > 0 { uvw } else { None };
            now.uvw = uvw;
            lines.push(Line { text: raw.to_owned(), number: index + 1, ..now.clone() });
        }
    }
    lines
}

fn turned(axis: (V, V), angle_deg: f64, p: V) -> V {
    Rotation3::from_axis_angle(&Unit::new_normalize(axis.0), angle_deg.to_radians()) * (p - axis.1) + axis.1
}

impl Tables {
    /// Tip (or any point given by linear words) in W, and the tool axis.
    pub fn forward(&self, q: V, angle: [f64; 2]) -> (V, V) {
        let tip = if self.tcp {
            q
        } else {
            turned(self.second, angle[1], turned(self.first, angle[0], q + self.offset)) - self.offset
        };
        let zero = |axis: (V, V)| (axis.0, V::zeros());
        (tip, turned(zero(self.second), angle[1], turned(zero(self.first), angle[0], V::z())))
    }

    /// The normal, scaled so that the stated contact point is met exactly.
    fn normal(&self, line: &Line) -> V {
        let (w, t) = self.forward(line.q, line.angle);
        let c = self.contact(line);
        let mut scaled = w - c + t * self.corner;
        if self.core > 0.0 {
            let d = w - c;
            scaled -= (d - t * d.dot(&t)).normalize() * self.core;
        }
        scaled / self.corner
    }

    fn contact(&self, line: &Line) -> V {
        self.forward(line.uvw.expect("a contact"), line.angle).0
    }

    fn touch(&self, w: V, t: V, n: V) -> V {
        let across = n - t * n.dot(&t);
        let m = if self.core > 0.0 { across.normalize() } else { V::zeros() };
        w - n * self.corner - m * self.core + t * self.corner
    }

    /// Largest distance from the source's contact line while the machine runs from `a` to `b`, fractions `u`.
    fn bow(&self, source: (&Line, &Line), run: (&Line, &Line), u: (f64, f64), samples: usize) -> f64 {
        let (n0, n1) = (self.normal(source.0), self.normal(source.1));
        let (c0, c1) = (self.contact(source.0), self.contact(source.1));
        let angle = n0.cross(&n1).norm().atan2(n0.dot(&n1));
        (0..=samples)
            .map(|k| {
                let s = k as f64 / samples as f64;
                let f = u.0 + (u.1 - u.0) * s;
                let q = run.0.q + (run.1.q - run.0.q) * s;
                let turn = [0, 1].map(|k| run.0.angle[k] + (run.1.angle[k] - run.0.angle[k]) * s);
                let (w, t) = self.forward(q, turn);
                let (a, b) = (n0.normalize(), n1.normalize());
                let direction = if angle < 1e-12 {
                    a
                } else {
                    (a * ((1.0 - f) * angle).sin() + b * (f * angle).sin()) / angle.sin()
                };
                let n = direction * (n0.norm() * (1.0 - f) + n1.norm() * f);
                let c = self.touch(w, t, n);
                let l = c1 - c0;
                if l.norm() < 1e-12 { (c - c0).norm() } else { (c - c0).cross(&l).norm() / l.norm() }
            })
            .fold(0.0, f64::max)
    }

    fn time(a: &Line, b: &Line) -> f64 {
        if b.inverse_time {
            return 60.0 / b.feed;
        }
        let path = (b.q - a.q).norm();
        let turn = (b.angle[0] - a.angle[0]).abs().max((b.angle[1] - a.angle[1]).abs());
        60.0 * if path > 0.0 { path } else { turn } / b.feed
    }

    /// Judges the output against the source, block by block.
    pub fn judge(&self, source: &str, output: &str, samples: usize) -> Vec<Verdict> {
        let (source, output) = (scan(source, self.letters), scan(output, self.letters));
        let mut verdicts = Vec::new();
        let mut at = 0;
        for k in 0..source.len() {
            let end = &source[k];
            let same = |line: &Line| line.q == end.q && line.angle == end.angle;
            let first = at;
            while !same(&output[at]) {
                at += 1;
            }
            at += 1;
            let parts = at - first;
            if k == 0 || end.rapid || source[k - 1].uvw.is_none() || end.uvw.is_none() {
                assert_eq!(parts, 1, "line {} must be left alone", end.number);
                continue;
            }
            let start = &source[k - 1];
            let mut after: f64 = 0.0;
            let mut time = 0.0;
            for part in 0..parts {
                let from = if part == 0 { start } else { &output[first + part - 1] };
                let to = &output[first + part];
                let u = (part as f64 / parts as f64, (part + 1) as f64 / parts as f64);
                after = after.max(self.bow((start, end), (from, to), u, samples));
                time += Self::time(from, to);
            }
            verdicts.push(Verdict {
                line: end.number,
                before: self.bow((start, end), (start, end), (0.0, 1.0), samples),
                after,
                parts,
                time_ratio: time / Self::time(start, end),
            });
        }
        assert_eq!(at, output.len(), "the output moves on after the source's end");
        verdicts
    }
}
