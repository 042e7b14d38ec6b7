//! Arcs and helices as the control runs them.

use std::fmt;

use crate::geometry::{PlaneFrame, trig};
use crate::motion::{ArcCourse, AxisWords, Motion};
use crate::program::{Address, Batch, Word, WordForm};

/// Why the course of an arc is not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UnknownArc {
    /// The active plane is not known.
    Plane,
    /// Rotary axes turn along the arc.
    Turning {
        /// By how much, in the profile's order \[deg\].
        turn_deg: [f64; 2],
    },
    /// The block has a P word. It means several turns, or something else on another control.
    Turns {
        /// Its value.
        turns: f64,
    },
    /// The value of one of its words is an expression.
    Expression {
        /// The word.
        address: Address,
    },
    /// The block states no radius, and not every centre word that it needs.
    CentreNotStated,
    /// The block states both a radius and a centre.
    RadiusAndCentre {
        /// The radius \[mm\].
        radius_mm: f64,
    },
    /// Start and end are equal, and only the radius is given. Many circles pass through one point.
    FullCircleByRadius {
        /// The radius \[mm\].
        radius_mm: f64,
    },
    /// No circle of this radius reaches both ends.
    RadiusTooShort {
        /// The radius \[mm\].
        radius_mm: f64,
        /// How much shorter the radius is than half the chord \[mm\].
        short_mm: f64,
    },
    /// The circle about the centre misses the end.
    Missed {
        /// Distance from the centre to the start \[mm\].
        radius_mm: f64,
        /// Distance from the centre to the end, minus the distance from the centre to the start \[mm\].
        missed_mm: f64,
    },
    /// The centre is where the arc starts or ends.
    NoRadius,
}

impl fmt::Display for UnknownArc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Plane => f.write_str("its plane is not known"),
            Self::Turning { turn_deg: [first, second] } => {
                write!(f, "rotary axes turn along it, by {first:.3} and {second:.3} deg")
            }
            Self::Turns { turns } => write!(f, "it has the word P{turns}, for several turns"),
            Self::Expression { address } => write!(f, "the value of its word {address} is an expression"),
            Self::CentreNotStated => f.write_str("it states neither its radius nor its whole centre"),
            Self::RadiusAndCentre { radius_mm } => {
                write!(f, "it states both a centre and a radius of {radius_mm:.4} mm")
            }
            Self::FullCircleByRadius { radius_mm } => {
                write!(f, "it ends where it starts and states only its radius of {radius_mm:.4} mm")
            }
            Self::RadiusTooShort { radius_mm, short_mm } => {
                write!(f, "its radius of {radius_mm:.4} mm is {short_mm:.4} mm less than half its chord")
            }
            Self::Missed { radius_mm, missed_mm } => write!(
                f,
                "its end misses the circle of {radius_mm:.4} mm about its centre by {missed_mm:.4} mm"
            ),
            Self::NoRadius => f.write_str("its centre is its start or its end"),
        }
    }
}

/// An arc in one of the planes XY, ZX, YZ, with the third axis linear and rotary axes at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::process) struct ArcPath {
    start: AxisWords,
    end: AxisWords,
    /// The axes of the plane, in its right-handed order.
    axes: [usize; 2],
    /// Centre in the plane \[mm\].
    centre_mm: [f64; 2],
    /// Vector from the centre to the start \[mm\].
    arm_mm: [f64; 2],
    /// Angle that the arc runs through, counter-clockwise positive \[rad\].
    sweep_rad: f64,
    /// Radius at the end divided by the radius at the start. It differs from 1 because words are rounded.
    growth: f64,
    /// The tilted plane in which all of this counts.
    frame: Option<PlaneFrame>,
}

/// G2, G3, G90.1, G91.1 in tenths.
const CLOCKWISE: u32 = 20;
const COUNTER_CLOCKWISE: u32 = 30;
pub(in crate::process) const ABSOLUTE_CENTRES: u32 = 901;
pub(in crate::process) const INCREMENTAL_CENTRES: u32 = 911;
/// Start and end of an arc lie on one circle within this length, or within this share of the radius. Words have three
/// decimals, and controls have similar limits.
pub(in crate::process) const RADIUS_SLACK_MM: f64 = 0.01;
const RADIUS_SLACK_SHARE: f64 = 1e-3;
/// Ends that are closer together in the plane are one point \[mm\].
const SAME_MM: f64 = 1e-6;

/// The modes of arcs that a motion does not state: the direction, and the point from which centres are counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(in crate::process) struct ArcModes {
    is_clockwise: bool,
    absolute_centres: bool,
}

impl ArcModes {
    /// Arcs of this direction, with centres that are points or count from the start.
    pub(in crate::process) const fn new(is_clockwise: bool, absolute_centres: bool) -> Self {
        Self { is_clockwise, absolute_centres }
    }

    /// Updates the modes from the codes of one block.
    pub(in crate::process) fn see(&mut self, words: &[Word]) {
        for word in words.iter().filter(|word| word.address == Address::G) {
            match word.code_tenths() {
                Some(CLOCKWISE) => self.is_clockwise = true,
                Some(COUNTER_CLOCKWISE) => self.is_clockwise = false,
                Some(ABSOLUTE_CENTRES) => self.absolute_centres = true,
                Some(INCREMENTAL_CENTRES) => self.absolute_centres = false,
                _ => {}
            }
        }
    }
}

impl ArcPath {
    /// The arc of a motion from `start` to `end`.
    ///
    /// # Errors
    /// The reason why the course of the arc is not known.
    pub(in crate::process) fn of(
        modes: ArcModes,
        batch: &Batch,
        motion: &Motion,
        [start, end]: [AxisWords; 2],
    ) -> Result<Self, UnknownArc> {
        let [start, end] = [start, end].map(|words| motion.stated(words));
        let across = usize::from(motion.plane.ok_or(UnknownArc::Plane)?);
        let axes = [(across + 1) % 3, (across + 2) % 3];
        let is_at_rest = |k: usize| start.rotary_deg[k].to_bits() == end.rotary_deg[k].to_bits();
        if !(is_at_rest(0) && is_at_rest(1)) {
            let turn_deg = [0, 1].map(|k| end.rotary_deg[k] - start.rotary_deg[k]);
            return Err(UnknownArc::Turning { turn_deg });
        }
        if let ArcCourse::About { centre_mm, is_clockwise } = motion.arc {
            return Self::about(is_clockwise, [start, end], axes, centre_mm);
        }
        let block = batch.blocks().get(motion.block as usize).ok_or(UnknownArc::CentreNotStated)?;
        let mut centre_words = [None; 3];
        let (mut radius, mut turns) = (None, None);
        // Centre words whose form says from where they count, as bits by address.
        let (mut places, mut offsets) = (0_u32, 0_u32);
        for word in batch.words(block) {
            let slot = match word.address {
                Address::I => &mut centre_words[0],
                Address::J => &mut centre_words[1],
                Address::K => &mut centre_words[2],
                Address::R => &mut radius,
                // P may be the number of full circles, which the motion already knows.
                Address::P if motion.further_turns.is_none() => &mut turns,
                _ => continue,
            };
            match word.form {
                WordForm::Number | WordForm::Evaluated => {}
                WordForm::Absolute => places |= 1 << word.address.index(),
                WordForm::Incremental => offsets |= 1 << word.address.index(),
                _ => return Err(UnknownArc::Expression { address: word.address }),
            }
            let scale = if word.address == Address::P { 1.0 } else { motion.mm_per_unit };
            *slot = Some(word.value * scale);
        }
        if let Some(turns) = turns {
            return Err(UnknownArc::Turns { turns });
        }
        let from_mm = axes.map(|axis| start.linear_mm[axis]);
        let to_mm = axes.map(|axis| end.linear_mm[axis]);
        let centres = axes.map(|axis| centre_words[axis]);
        let centre_mm = match (radius, centres) {
            (Some(radius_mm), [None, None]) => centre_by_radius(modes, from_mm, to_mm, radius_mm)?,
            (None, [None, None]) => return Err(UnknownArc::CentreNotStated),
            (Some(radius_mm), _) => return Err(UnknownArc::RadiusAndCentre { radius_mm }),
            (None, [first, second]) => {
                let place = |word: Option<f64>, axis: usize, from: f64| {
                    let bit = 1 << [Address::I, Address::J, Address::K][axis].index();
                    let is_place = places & bit != 0 || (modes.absolute_centres && offsets & bit == 0);
                    match (word, is_place) {
                        (Some(at), true) => Ok(at),
                        (Some(offset), false) => Ok(from + offset),
                        (None, false) => Ok(from),
                        // Controls differ here: some keep the coordinate, others take zero.
                        (None, true) => Err(UnknownArc::CentreNotStated),
                    }
                };
                [place(first, axes[0], from_mm[0])?, place(second, axes[1], from_mm[1])?]
            }
        };
        let mut arc = Self::about(modes.is_clockwise, [start, end], axes, centre_mm)?;
        let further_rad = std::f64::consts::TAU * f64::from(motion.further_turns.unwrap_or_default());
        arc.frame = motion.frame;
        arc.sweep_rad += if modes.is_clockwise { -further_rad } else { further_rad };
        Ok(arc)
    }

    fn about(
        is_clockwise: bool,
        [start, end]: [AxisWords; 2],
        axes: [usize; 2],
        centre_mm: [f64; 2],
    ) -> Result<Self, UnknownArc> {
        let arm = |words: &AxisWords| [0, 1].map(|k| words.linear_mm[axes[k]] - centre_mm[k]);
        let (arm_mm, last_mm) = (arm(&start), arm(&end));
        let [first, last] = [arm_mm, last_mm].map(|[a, b]| (a * a + b * b).sqrt());
        let slack = RADIUS_SLACK_MM.max(RADIUS_SLACK_SHARE * first);
        if !(first > SAME_MM && last > SAME_MM) {
            return Err(UnknownArc::NoRadius);
        }
        let missed_mm = last - first;
        if missed_mm.is_nan() || missed_mm.abs() > slack {
            return Err(UnknownArc::Missed { radius_mm: first, missed_mm });
        }
        let cross = arm_mm[0] * last_mm[1] - arm_mm[1] * last_mm[0];
        let dot = arm_mm[0] * last_mm[0] + arm_mm[1] * last_mm[1];
        let ends_mm = ((arm_mm[0] - last_mm[0]).powi(2) + (arm_mm[1] - last_mm[1]).powi(2)).sqrt();
        let turn_rad = trig::atan2(cross, dot);
        let sweep_rad = match (ends_mm < SAME_MM, is_clockwise) {
            (true, true) => -std::f64::consts::TAU,
            (true, false) => std::f64::consts::TAU,
            (false, true) if turn_rad > 0.0 => turn_rad - std::f64::consts::TAU,
            (false, false) if turn_rad < 0.0 => turn_rad + std::f64::consts::TAU,
            _ => turn_rad,
        };
        Ok(Self { start, end, axes, centre_mm, arm_mm, sweep_rad, growth: last / first, frame: None })
    }

    /// Returns the words at the centre, and those at 1 mm from there along the normal of the arc's plane. The third
    /// axis is where the arc starts.
    pub(in crate::process) fn centre(&self) -> [AxisWords; 2] {
        let mut words = self.start;
        for (axis, at_mm) in self.axes.into_iter().zip(self.centre_mm) {
            words.linear_mm[axis] = at_mm;
        }
        let mut beside = words;
        beside.linear_mm[3 - self.axes[0] - self.axes[1]] += 1.0;
        [words, beside].map(|words| self.out(words))
    }

    /// Words that count in the arc's tilted plane, in the work offset.
    fn out(&self, words: AxisWords) -> AxisWords {
        match self.frame {
            Some(frame) => AxisWords { linear_mm: frame.to_workpiece(words.linear_mm), ..words },
            None => words,
        }
    }

    /// Angle that the arc runs through, counter-clockwise about the plane's normal positive \[rad\].
    pub(in crate::process) fn sweep_rad(&self) -> f64 {
        self.sweep_rad
    }

    /// The words at the fraction `u`: on the circle in the plane, linear in the third axis.
    pub(in crate::process) fn words_at(&self, u: f64) -> AxisWords {
        if u <= 0.0 {
            return self.out(self.start);
        }
        if u >= 1.0 {
            return self.out(self.end);
        }
        let mut words = self.start;
        for axis in 0..3 {
            let (from, to) = (self.start.linear_mm[axis], self.end.linear_mm[axis]);
            words.linear_mm[axis] = from + (to - from) * u;
        }
        let (sin, cos) = trig::sin_cos(self.sweep_rad * u);
        let scale = 1.0 + (self.growth - 1.0) * u;
        let [a, b] = self.arm_mm;
        words.linear_mm[self.axes[0]] = self.centre_mm[0] + scale * (a * cos - b * sin);
        words.linear_mm[self.axes[1]] = self.centre_mm[1] + scale * (a * sin + b * cos);
        self.out(words)
    }

    /// Bounds on the first and second derivative of the words with respect to u \[mm\].
    pub(in crate::process) fn derivative_bounds_mm(&self) -> [f64; 2] {
        let [a, b] = self.arm_mm;
        let radius_mm = (a * a + b * b).sqrt() * self.growth.max(1.0);
        let spiral_mm = radius_mm * (self.growth - 1.0).abs();
        let rise_mm = (0..3)
            .filter(|axis| !self.axes.contains(axis))
            .map(|axis| (self.end.linear_mm[axis] - self.start.linear_mm[axis]).abs())
            .sum::<f64>();
        let sweep = self.sweep_rad.abs();
        [radius_mm * sweep + spiral_mm + rise_mm, radius_mm * sweep * sweep + 2.0 * spiral_mm * sweep]
    }
}

/// The centre of an arc that is given by its radius. A negative radius takes the longer way round.
fn centre_by_radius(
    modes: ArcModes,
    from_mm: [f64; 2],
    to_mm: [f64; 2],
    radius_mm: f64,
) -> Result<[f64; 2], UnknownArc> {
    let chord = [to_mm[0] - from_mm[0], to_mm[1] - from_mm[1]];
    let length_mm = (chord[0] * chord[0] + chord[1] * chord[1]).sqrt();
    let half_mm = 0.5 * length_mm;
    let reach_mm = radius_mm.abs();
    let slack = RADIUS_SLACK_MM.max(RADIUS_SLACK_SHARE * reach_mm);
    if length_mm < SAME_MM {
        return Err(UnknownArc::FullCircleByRadius { radius_mm });
    }
    if half_mm > reach_mm + slack {
        return Err(UnknownArc::RadiusTooShort { radius_mm, short_mm: half_mm - reach_mm });
    }
    let height_mm = ((reach_mm - half_mm) * (reach_mm + half_mm)).max(0.0).sqrt();
    // The centre is left of the chord if a short arc runs counter-clockwise.
    let side = if modes.is_clockwise == (radius_mm > 0.0) { -height_mm } else { height_mm };
    let middle = [0.5 * (from_mm[0] + to_mm[0]), 0.5 * (from_mm[1] + to_mm[1])];
    Ok([middle[0] - chord[1] / length_mm * side, middle[1] + chord[0] / length_mm * side])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Machine, Preset};
    use crate::motion::{Interpreter, InterpreterOptions};
    use crate::program::{Diagnostics, Dialect, ReadLimits, Reader};

    /// Rounding of a few operations on lengths of ten to twenty millimetres \[mm\].
    const ROUNDING_MM: f64 = 1e-12;
    const XY: [usize; 2] = [0, 1];

    fn words(x: f64, y: f64, z: f64) -> AxisWords {
        AxisWords { linear_mm: [x, y, z], rotary_deg: [0.0; 2] }
    }

    #[track_caller]
    fn assert_at(arc: &ArcPath, u: f64, expected: [f64; 3]) {
        let at = arc.words_at(u).linear_mm;
        assert!(at.iter().zip(expected).all(|(a, b)| (a - b).abs() < ROUNDING_MM), "{at:?} {expected:?}");
    }

    #[test]
    fn quarter_circles_run_the_stated_way() {
        let ends = [words(10.0, 0.0, 0.0), words(0.0, 10.0, 4.0)];
        let half = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
        assert_at(&ArcPath::about(false, ends, XY, [0.0; 2]).unwrap(), 0.5, [half, half, 2.0]);
        assert_at(&ArcPath::about(true, ends, XY, [0.0; 2]).unwrap(), 0.5, [-half, -half, 2.0]);
    }

    #[test]
    fn equal_ends_are_a_full_circle_and_other_circles_none() {
        let ends = [words(10.0, 0.0, 0.0), words(10.0, 0.0, 0.0)];
        assert_at(&ArcPath::about(true, ends, XY, [0.0; 2]).unwrap(), 0.25, [0.0, -10.0, 0.0]);
        let missing = ArcPath::about(true, [words(10.0, 0.0, 0.0), words(0.0, 11.0, 0.0)], XY, [0.0; 2]);
        assert_eq!(missing, Err(UnknownArc::Missed { radius_mm: 10.0, missed_mm: 1.0 }));
        let none = ArcPath::about(true, ends, XY, [10.0, 0.0]);
        assert_eq!(none, Err(UnknownArc::NoRadius));
    }

    /// The arc of the last line of a Sinumerik program.
    fn sinumerik(text: &str) -> Result<ArcPath, UnknownArc> {
        let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
        let mut reader = Reader::new(Some(Dialect::Siemens), ReadLimits::default());
        reader.feed(text.as_bytes());
        reader.finish();
        let mut batch = Batch::new();
        assert!(reader.next_batch(&mut batch).unwrap());
        let mut interpreter = Interpreter::new(&machine, InterpreterOptions::default());
        let (mut motions, mut modes) = (Vec::new(), ArcModes::default());
        interpreter.interpret(&mut batch, &mut motions, &mut Diagnostics::new());
        batch.blocks().iter().for_each(|block| modes.see(batch.words(block)));
        let motion = motions.last().unwrap();
        ArcPath::of(modes, &batch, motion, [motion.start.unwrap(), motion.end.unwrap()])
    }

    #[test]
    fn further_turns_are_run_beside_the_way_to_the_end() {
        let arc = |code: &str| sinumerik(&format!("G17 G0 X10 Y0 Z0 A0 C0\n{code}\n"));
        let half = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
        // A quarter and two full circles are 2.25 turns, so one turn takes four ninths of the way.
        for centre in ["I-10 J0", "I=AC(0) J=AC(0)", "I=IC(-10)", "CR=10"] {
            let helix = arc(&format!("G3 X0 Y10 Z9 {centre} TURN=2")).unwrap();
            assert_at(&helix, 4.0 / 9.0, [10.0, 0.0, 4.0]);
            assert_at(&helix, 8.5 / 9.0, [half, half, 8.5]);
            let plain = arc(&format!("G3 X0 Y10 Z9 {centre} TURN=0")).unwrap();
            assert_at(&plain, 0.5, [half, half, 4.5]);
            let back = arc(&format!("G2 X0 Y10 Z9 {centre} TURN=1"));
            assert_at(&back.unwrap(), 0.0, [10.0, 0.0, 0.0]);
        }
        // Clockwise, the way to the end is three quarters: 1.75 turns in all.
        assert_at(&arc("G2 X0 Y10 Z7 I-10 J0 TURN=1").unwrap(), 1.0 / 7.0, [0.0, -10.0, 1.0]);
        // Equal ends make one full circle, and TURN=1 adds another.
        let circles = arc("G2 X10 Y0 Z8 I=AC(0) J=AC(0) TURN=1").unwrap();
        assert_at(&circles, 0.25, [-10.0, 0.0, 2.0]);
        let [first, _] = circles.derivative_bounds_mm();
        assert!(first >= 10.0 * 2.0 * std::f64::consts::TAU, "{first}");
    }

    #[test]
    fn a_radius_takes_the_short_way_and_a_negative_one_the_long() {
        let (from, to) = ([10.0, 0.0], [0.0, 10.0]);
        let centre = |is_clockwise, radius_mm| {
            let modes = ArcModes { is_clockwise, absolute_centres: false };
            centre_by_radius(modes, from, to, radius_mm).unwrap()
        };
        for (found, expected) in [
            (centre(false, 10.0), [0.0, 0.0]),
            (centre(true, 10.0), [10.0, 10.0]),
            (centre(false, -10.0), [10.0, 10.0]),
            (centre(true, -10.0), [0.0, 0.0]),
        ] {
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < ROUNDING_MM), "{found:?} {expected:?}");
        }
        let modes = ArcModes::default();
        let Err(UnknownArc::RadiusTooShort { radius_mm: -7.0, short_mm }) =
            centre_by_radius(modes, from, to, -7.0)
        else {
            panic!("7 mm reach both ends");
        };
        assert!((short_mm - (50.0_f64.sqrt() - 7.0)).abs() < ROUNDING_MM, "{short_mm}");
        let full = centre_by_radius(modes, from, from, 7.0);
        assert_eq!(full, Err(UnknownArc::FullCircleByRadius { radius_mm: 7.0 }));
    }
}
