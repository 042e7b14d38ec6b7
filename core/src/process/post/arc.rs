//! Arcs of cutter location data as chords.

use crate::geometry::{AxisCircle, Vec3, angle_about, trig};
use crate::motion::{ROUNDED_ENDS, off_circle_mm};
use crate::process::fault::NotPosted;
use crate::program::{Address, Word};

/// Ends this near are the same point, so the arc is a full circle \[mm\].
const SAME_POINT_MM: f64 = 1e-6;
/// Most chords of an arc.
const MAX_CHORDS: f64 = 100_000.0;

/// `CIRCLE/x,y,z,i,j,k[,r…]` as its numbers are written. The arc turns counterclockwise as seen from the tip of the
/// axis vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WrittenCircle {
    centre: Vec3,
    axis: Vec3,
    radius: Option<f64>,
    /// `TIMES` is stated.
    has_turns: bool,
}

impl WrittenCircle {
    /// The words of the statement; `None` if it was not read.
    pub(super) fn of(words: &[Word]) -> Option<Self> {
        let number = |address| words.iter().find(|word| word.address == address).map(|word| word.value);
        let vector = |addresses: [Address; 3]| {
            let [x, y, z] = addresses.map(number);
            Some(Vec3::new(x?, y?, z?))
        };
        Some(Self {
            centre: vector([Address::I, Address::J, Address::K])?,
            axis: vector([Address::P, Address::Q, Address::S])?,
            radius: number(Address::R),
            has_turns: number(Address::H).is_some(),
        })
    }

    /// The arc between these ends, if one unit of the circle's numbers is `mm_per_unit`.
    pub(super) fn seen(&self, ends: [Vec3; 2], mm_per_unit: f64) -> ArcSeen {
        let centre_mm = self.centre * mm_per_unit;
        let [start, end] = ends.map(|end| (end - centre_mm).cross(&self.axis).norm() / self.axis.norm());
        ArcSeen { centre_mm, axis: self.axis, radii_mm: [start.min(end), start.max(end)] }
    }

    /// The circle with lengths in program units of `mm_per_unit`.
    ///
    /// # Errors
    /// `TIMES` is stated, or the axis has no direction.
    pub(super) fn circle(&self, mm_per_unit: f64) -> Result<Circle, NotPosted> {
        if self.has_turns {
            let why = "its CIRCLE states TIMES, and systems differ on the turns that it counts: write the helix as \
                       points, or each turn as a CIRCLE with its end";
            return Err(NotPosted::Arc { why });
        }
        let about = AxisCircle::new(self.centre * mm_per_unit, self.axis)
            .ok_or(NotPosted::Arc { why: "the axis of its circle has no direction" })?;
        Ok(Circle { about, radius_mm: self.radius.map(|radius| radius * mm_per_unit) })
    }
}

/// An arc of the source, for the reading back: computed without the chords, and with the scale that the numbers of its
/// end have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ArcSeen {
    centre_mm: Vec3,
    /// Of any length.
    axis: Vec3,
    /// Distances of the ends from the axis, the smaller one first \[mm\].
    radii_mm: [f64; 2],
}

impl ArcSeen {
    /// Whether the line between two tips is a chord of the arc in its sense: both tips are on it within `slack_mm`, and
    /// the middle is not farther inside than the tolerance.
    pub(super) fn has_chord(&self, [from_mm, to_mm]: [Vec3; 2], tolerance_mm: f64, slack_mm: f64) -> bool {
        let arm = |tip_mm: Vec3| {
            let from = tip_mm - self.centre_mm;
            from - self.axis * (from.dot(&self.axis) / self.axis.norm_squared())
        };
        let [least_mm, most_mm] = self.radii_mm;
        let is_on = |tip_mm: Vec3| {
            let off_mm = arm(tip_mm).norm();
            off_mm >= least_mm - slack_mm && off_mm <= most_mm + slack_mm
        };
        let middle = (from_mm + to_mm) * 0.5;
        let turns_on =
            self.axis.dot(&arm(from_mm).cross(&(to_mm - from_mm))) >= -slack_mm * most_mm * self.axis.norm();
        is_on(from_mm) && is_on(to_mm) && arm(middle).norm() >= least_mm - tolerance_mm - slack_mm && turns_on
    }
}

/// A circle in the frame of the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    about: AxisCircle,
    radius_mm: Option<f64>,
}

impl Circle {
    /// The points after `start` at which chords end; `end` is the last. Both have units of `unit_mm`, their last
    /// decimal. Ends that differ by rounding only are a full circle or almost no arc, and the text does not tell
    /// which.
    ///
    /// # Errors
    /// Why it is not an arc.
    pub(super) fn chords(
        &self,
        [start, end]: [Vec3; 2],
        unit_mm: f64,
        tolerance_mm: f64,
    ) -> Result<Vec<Vec3>, NotPosted> {
        let ((from, low), (to, high)) = (self.about.arm_mm(start), self.about.arm_mm(end));
        let (centre_mm, axis) = (self.about.centre_mm(), self.about.axis());
        let (radius_mm, other_mm) = (from.norm(), to.norm());
        let off_mm = off_circle_mm(radius_mm, unit_mm);
        if (radius_mm - other_mm).abs() > off_mm || radius_mm < SAME_POINT_MM {
            return Err(NotPosted::Arc { why: "its ends are not on one circle about its centre" });
        }
        if let Some(stated_mm) = self.radius_mm
            && [radius_mm, other_mm].iter().any(|radius| (radius - stated_mm).abs() > off_mm)
        {
            return Err(NotPosted::ArcRadius { stated_mm, start_mm: radius_mm, end_mm: other_mm });
        }
        let turn = angle_about(axis, from, to);
        let is_open = turn.abs() * radius_mm <= (ROUNDED_ENDS * unit_mm).max(SAME_POINT_MM);
        let turn_rad = if (start - end).norm() < SAME_POINT_MM {
            std::f64::consts::TAU
        } else if is_open && (high - low).abs() > ROUNDED_ENDS * unit_mm {
            // One turn of a helix.
            std::f64::consts::TAU + turn
        } else if is_open {
            let why = "its ends differ in the last decimal only: it can be a full circle or almost no arc";
            return Err(NotPosted::Arc { why });
        } else if turn < 0.0 {
            turn + std::f64::consts::TAU
        } else {
            turn
        };
        // Sagitta r(1 − cos(step/2)) ≤ tolerance, with sin²(step/4) = sagitta / 2r.
        let sagitta = (tolerance_mm / (2.0 * radius_mm)).clamp(0.0, 0.5);
        let step_rad = 4.0 * trig::atan2(sagitta.sqrt(), (1.0 - sagitta).sqrt());
        let chords = (turn_rad / step_rad).ceil().max(1.0);
        if chords.is_nan() || chords > MAX_CHORDS {
            return Err(NotPosted::Arc { why: "it would need too many lines" });
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to MAX_CHORDS")]
        let count = chords as u32;
        let side = axis.cross(&from);
        let mut points: Vec<Vec3> = (1..count)
            .map(|k| {
                let u = f64::from(k) / chords;
                let (sin, cos) = trig::sin_cos(turn_rad * u);
                let scale = 1.0 + (other_mm / radius_mm - 1.0) * u;
                centre_mm + (from * cos + side * sin) * scale + axis * (low + (high - low) * u)
            })
            .collect();
        points.push(end);
        Ok(points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reading_back_finds_an_arc_in_another_unit_or_sense() {
        let written = WrittenCircle {
            centre: Vec3::new(1.0, 0.0, 0.0),
            axis: Vec3::z() * 2.0,
            radius: None,
            has_turns: false,
        };
        let inch_mm = 25.4;
        // As far from the centre in inches as from the one in millimetres.
        let ends = [Vec3::new(inch_mm, inch_mm, 0.0), Vec3::new(inch_mm, -inch_mm, 3.0)];
        let all_on = |seen: ArcSeen, points: &[Vec3]| {
            points.windows(2).all(|pair| seen.has_chord([pair[0], pair[1]], 0.005, 1e-4))
        };
        let chords = |mm_per_unit: f64| {
            let mut points = vec![ends[0]];
            points.extend(written.circle(mm_per_unit).unwrap().chords(ends, 1e-3, 0.005).unwrap());
            points
        };
        let seen = written.seen(ends, inch_mm);
        assert!(chords(inch_mm).len() > 40 && all_on(seen, &chords(inch_mm)));
        assert!(!all_on(seen, &chords(1.0)));
        let other_way = |tip: &Vec3| Vec3::new(2.0 * inch_mm - tip.x, tip.y, tip.z);
        let mirrored: Vec<Vec3> = chords(inch_mm).iter().map(other_way).collect();
        assert!(!all_on(seen, &mirrored));
        assert!(!all_on(seen, &ends), "a straight line");
    }
}
