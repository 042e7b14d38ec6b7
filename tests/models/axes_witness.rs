//! An independent witness for any two rotary axes: rotation matrices, a scanner of its own. Shares no code with the
//! crate but the description of the machine.

use nalgebra::{Rotation3, Unit, Vector3};
use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Side};

type V = Vector3<f64>;

/// One motion as the witness reads it, all values absolute.
#[derive(Debug, Clone)]
pub struct Move {
    pub line: usize,
    pub text: String,
    pub rapid: bool,
    pub q: V,
    pub angle: [f64; 2],
    pub feed: f64,
    pub inverse_time: bool,
}

/// Machine and set-up as numbers.
#[derive(Debug, Clone)]
pub struct Axes {
    lines: Vec<(bool, V, V)>,
    offset: V,
    letters: [char; 2],
    tcp: bool,
}

fn turned(point: V, direction: V, angle_deg: f64, p: V) -> V {
    Rotation3::from_axis_angle(&Unit::new_normalize(direction), angle_deg.to_radians()) * (p - point) + point
}

impl Axes {
    pub fn new(machine: &Machine, setup: &Setup, tcp: bool) -> Self {
        let lines = machine.rotary_axes().iter().map(|axis| {
            let head = axis.side == Side::Head;
            let up = if head { V::z() * setup.tool_length_mm } else { V::zeros() };
            assert!(!axis.reversed, "senses of the standard");
            (head, axis.direction, axis.point_mm + up)
        });
        let letters = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
        Self { lines: lines.collect(), offset: setup.work_offset_mm, letters, tcp }
    }

    /// Tip and tool axis in W.
    pub fn pose(&self, q: V, angle: [f64; 2]) -> (V, V) {
        let (mut p, mut t) = (V::zeros(), V::z());
        for (k, (_, direction, point)) in self.lines.iter().enumerate().rev().filter(|(_, line)| line.0) {
            p = turned(*point, *direction, angle[k], p);
            t = turned(V::zeros(), *direction, angle[k], t);
        }
        p += q + self.offset;
        for (k, (_, direction, point)) in self.lines.iter().enumerate().filter(|(_, line)| !line.0) {
            p = turned(*point, *direction, angle[k], p);
            t = turned(V::zeros(), *direction, angle[k], t);
        }
        (if self.tcp { q } else { p - self.offset }, t)
    }

    /// The pose at a share of the way between two moves.
    pub fn between(&self, a: &Move, b: &Move, s: f64) -> (V, V) {
        let angle = [0, 1].map(|k| a.angle[k] + (b.angle[k] - a.angle[k]) * s);
        self.pose(a.q + (b.q - a.q) * s, angle)
    }

    /// The largest turn of an axis between two moves \[deg\].
    pub fn step(a: &Move, b: &Move) -> f64 {
        (b.angle[0] - a.angle[0]).abs().max((b.angle[1] - a.angle[1]).abs())
    }

    /// The time of a move \[s\].
    pub fn time(a: &Move, b: &Move) -> f64 {
        let path = (b.q - a.q).norm();
        if b.inverse_time {
            60.0 / b.feed
        } else {
            60.0 * if path > 1e-9 { path } else { Self::step(a, b) } / b.feed
        }
    }

    pub fn scan(&self, text: &str) -> Vec<Move> {
        let (mut moves, mut rapid, mut incremental, mut inverse_time) = (Vec::new(), true, false, false);
        let (mut q, mut angle, mut feed) = (V::zeros(), [0.0; 2], 0.0);
        for (index, line) in text.lines().enumerate() {
            let mut moved = false;
            for word in line.split_whitespace().filter(|word| !word.starts_with(['%', 'N'])) {
                let (letter, value) =
                    (word.as_bytes()[0] as char, word[1..].parse::<f64>().expect("a number"));
                match (letter, value) {
                    ('G', 0.0) => rapid = true,
                    ('G', 1.0) => rapid = false,
                    ('G', 90.0) => incremental = false,
                    ('G', 91.0) => incremental = true,
                    ('G', 93.0) => inverse_time = true,
                    ('G', 94.0) => inverse_time = false,
                    ('F', value) => feed = value,
                    ('X'..='Z', value) => {
                        let slot = &mut q[letter as usize - 'X' as usize];
                        *slot = if incremental { *slot + value } else { value };
                        moved = true;
                    }
                    (letter, value) => {
                        if let Some(k) = self.letters.iter().position(|name| *name == letter) {
                            angle[k] = if incremental { angle[k] + value } else { value };
                            moved = true;
                        }
                    }
                }
            }
            if moved {
                moves.push(Move {
                    line: index + 1,
                    text: line.to_owned(),
                    rapid,
                    q,
                    angle,
                    feed,
                    inverse_time,
                });
            }
        }
        moves
    }
}

/// The angle between two directions \[deg\].
pub fn angle_deg(a: V, b: V) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
}

/// The direction at a share of the great circle between two.
pub fn on_circle(a: V, b: V, s: f64) -> V {
    let angle = a.cross(&b).norm().atan2(a.dot(&b));
    if angle < 1e-12 { a } else { (a * ((1.0 - s) * angle).sin() + b * (s * angle).sin()) / angle.sin() }
}

/// Distance of a point from the line between two.
pub fn off_line(p: V, a: V, b: V) -> f64 {
    let along = b - a;
    if along.norm() < 1e-12 { (p - a).norm() } else { (p - a).cross(&along).norm() / along.norm() }
}
