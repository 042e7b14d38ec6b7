//! Arcs of cutter location data: the circle that `CIRCLE/` states, and the points after it.
//!
//! Most systems write one point after `CIRCLE/`, the end of the arc. Some (Creo) write several points on the arc, of
//! which the last one is its end. So a further point on the same circle is the end of a straight line or of an arc, and
//! the text does not say which. Such a motion is not followed.

use super::interpreter::Interpreter;
use super::{MotionKind, Unfollowable};
use crate::geometry::{AxisCircle, Vec3};
use crate::program::Address;

/// Largest distance of points from their circle \[mm\], or share of its radius, as six digits of the radius leave. Few
/// decimals in the text add to it.
const OFF_CIRCLE_MM: f64 = 0.01;
const OFF_CIRCLE_SHARE: f64 = 1e-5;
/// Two copies of one point, rounded by half a unit on every axis, differ by less than this \[units\].
pub const ROUNDED_ENDS: f64 = 2.0;
/// Assumed precision of points written as whole numbers \[decimals\].
const WHOLE_NUMBERS_DECIMALS: i32 = 3;
/// Points this close are the same point \[mm\].
const SAME_POINT_MM: f64 = 1e-6;
/// A line that leaves a circle along its tangent is within the slack of the circle as long as the arc beside it is
/// within this share of the slack from its chord. There the two courses are the same.
const SAME_COURSE_SHARE: f64 = 0.25;

/// Largest distance of a point from its circle, for points whose last decimal is `unit_mm` \[mm\].
#[must_use]
pub fn off_circle_mm(radius_mm: f64, unit_mm: f64) -> f64 {
    OFF_CIRCLE_MM.max(OFF_CIRCLE_SHARE * radius_mm).max(ROUNDED_ENDS * unit_mm)
}

/// The value of one step of the last decimal of points with this number of decimals \[mm\]. Points without decimals
/// count as points with three.
#[must_use]
pub fn last_decimal_mm(mm_per_unit: f64, decimals: u8) -> f64 {
    let decimals = if decimals == 0 { WHOLE_NUMBERS_DECIMALS } else { i32::from(decimals) };
    mm_per_unit * 10.0_f64.powi(-decimals)
}

/// What holds of circles at a point of the program.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) enum PointArc {
    #[default]
    None,
    /// The circle of the next point; `None` if its statement is not understood.
    Stated(Option<AxisCircle>),
    /// The tool is on a circle since its arc.
    On(OnCircle),
}

/// The tool on a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OnCircle {
    circle: AxisCircle,
    at_mm: Vec3,
    radius_mm: f64,
    /// From the start of the arc to here, at most one turn.
    turned_rad: f64,
    /// How much the arc rose along the axis; zero if it is flat.
    rise_mm: f64,
}

impl Interpreter {
    /// `CIRCLE/`: the circle from the words of the block.
    pub(super) fn state_circle(&mut self) {
        let vector = |addresses: [Address; 3]| {
            let [x, y, z] = addresses.map(|address| self.block.value(address));
            Some(Vec3::new(x?, y?, z?))
        };
        let centre = vector([Address::I, Address::J, Address::K]);
        let axis = vector([Address::P, Address::Q, Address::S]);
        let circle = match (centre, axis, self.modal.mm_per_unit) {
            // H: several turns, and systems differ on what they count.
            (Some(centre), Some(axis), Some(mm)) if !self.block.has(Address::H) => {
                AxisCircle::new(centre * mm, axis)
            }
            _ => None,
        };
        self.point_arc = PointArc::Stated(circle);
    }

    /// Whether the next point depends on a circle.
    #[inline]
    pub(super) fn has_point_arc(&self) -> bool {
        self.point_arc != PointArc::None
    }

    /// Takes a motion from and to these places \[mm\] into account. Returns why its course is not known, if it is not.
    #[cold]
    pub(super) fn pass_point_arc(
        &mut self,
        kind: MotionKind,
        from_mm: Option<[f64; 3]>,
        to_mm: Option<[f64; 3]>,
    ) -> Option<Unfollowable> {
        let before = std::mem::take(&mut self.point_arc);
        let unit_mm = last_decimal_mm(self.modal.mm_per_unit?, self.program_decimals.linear);
        let to_mm = Vec3::from(to_mm?);
        let from_mm = from_mm.map(Vec3::from);
        match (before, kind) {
            (PointArc::Stated(None), MotionKind::Arc) => Some(Unfollowable::CircleUnread),
            (PointArc::Stated(Some(circle)), MotionKind::Arc) => {
                self.point_arc = PointArc::On(OnCircle::after_arc(circle, from_mm, to_mm, unit_mm));
                None
            }
            (PointArc::On(on), MotionKind::Linear) if from_mm.is_some_and(|from| on.is_at(from)) => {
                let next = on.on_to(to_mm, unit_mm)?;
                self.point_arc = PointArc::On(next);
                next.is_in_doubt_from(&on, unit_mm).then_some(Unfollowable::OnCircle)
            }
            _ => None,
        }
    }
}

impl OnCircle {
    /// At the end of the arc from `from_mm` to `at_mm`. Where the ends are equal, the first point may repeat the start.
    fn after_arc(circle: AxisCircle, from_mm: Option<Vec3>, at_mm: Vec3, unit_mm: f64) -> Self {
        let (arm, height_mm) = circle.arm_mm(at_mm);
        let radius_mm = arm.norm();
        let from_mm = from_mm.unwrap_or(at_mm);
        let turn_rad = circle.turn_rad(from_mm, at_mm);
        let is_open = (at_mm - from_mm).norm() <= (ROUNDED_ENDS * unit_mm).max(SAME_POINT_MM);
        let rise_mm = height_mm - circle.arm_mm(from_mm).1;
        let is_flat = rise_mm.abs() <= off_circle_mm(radius_mm, unit_mm);
        Self {
            circle,
            at_mm,
            radius_mm,
            turned_rad: if is_open { 0.0 } else { turn_rad },
            rise_mm: if is_flat { 0.0 } else { rise_mm },
        }
    }

    fn is_at(&self, place_mm: Vec3) -> bool {
        (place_mm - self.at_mm).norm() <= SAME_POINT_MM
    }

    /// Further round the circle to this point; `None` if the point is not on it, or more than one turn after the start.
    fn on_to(&self, to_mm: Vec3, unit_mm: f64) -> Option<Self> {
        if self.is_at(to_mm) {
            return Some(*self);
        }
        let slack_mm = off_circle_mm(self.radius_mm, unit_mm);
        let ((_, low_mm), (arm, high_mm)) = (self.circle.arm_mm(self.at_mm), self.circle.arm_mm(to_mm));
        let rise_mm = high_mm - low_mm;
        let is_beside =
            if self.rise_mm.abs() > 0.0 { rise_mm * self.rise_mm < 0.0 } else { rise_mm.abs() > slack_mm };
        let turned_rad = self.turned_rad + self.circle.turn_rad(self.at_mm, to_mm);
        let is_further = turned_rad <= std::f64::consts::TAU + slack_mm / self.radius_mm.max(slack_mm);
        let is_on = (arm.norm() - self.radius_mm).abs() <= slack_mm;
        (is_on && is_further && !is_beside).then_some(Self { at_mm: to_mm, turned_rad, ..*self })
    }

    /// Whether arc and line from the place before to this one are different courses.
    fn is_in_doubt_from(&self, before: &Self, unit_mm: f64) -> bool {
        let half_rad = 0.5 * (self.turned_rad - before.turned_rad).min(std::f64::consts::PI);
        let off_mm = self.radius_mm * (1.0 - crate::geometry::trig::sin_cos(half_rad).1);
        off_mm > SAME_COURSE_SHARE * off_circle_mm(self.radius_mm, unit_mm)
    }
}

#[cfg(test)]
mod tests {
    use crate::machine::{Machine, Preset};
    use crate::motion::{Interpreter, InterpreterOptions, Unfollowable};
    use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader};

    /// The reasons of the motions after the first point and the first arc.
    fn reasons(text: &str) -> Vec<Option<Unfollowable>> {
        let mut reader = Reader::new(Some(Dialect::Apt), ReadLimits::default());
        let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
        let mut interpreter = Interpreter::new(&machine, InterpreterOptions::in_mm());
        let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
        reader.feed(text.as_bytes());
        reader.finish();
        while reader.next_batch(&mut batch).unwrap() {
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
        }
        motions.iter().skip(1).map(|motion| motion.unfollowable).collect()
    }

    const LINE: Option<Unfollowable> = Some(Unfollowable::ToolVector);
    const DOUBT: Option<Unfollowable> = Some(Unfollowable::OnCircle);

    #[test]
    fn a_further_point_on_the_circle_is_in_doubt_and_others_are_lines() {
        let quarter = "FEDRAT/100,MMPM\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0\n";
        for (behind, expected) in [
            ("GOTO/-10,0,0\n", vec![LINE, DOUBT]),
            ("GOTO/-10,0,0\nGOTO/0,-10,0\nGOTO/0,0,0\n", vec![LINE, DOUBT, DOUBT, LINE]),
            ("FEDRAT/50,MMPM\nGOTO/-6.,8.,0\n", vec![LINE, DOUBT]),
            // Whole turns of the points.
            ("GOTO/10,0,0\n", vec![LINE, DOUBT]),
            // An arc has at most one turn.
            ("GOTO/6,8,0\n", vec![LINE, LINE]),
            ("GOTO/-10,1,0\n", vec![LINE, LINE]),
            ("GOTO/-10,0,1\n", vec![LINE, LINE]),
            ("GOTO/0,10,5\nGOTO/-10,0,5\n", vec![LINE, LINE, LINE]),
            ("RAPID\nGOTO/-10,0,0\n", vec![LINE, LINE]),
            ("CIRCLE/0,0,0,0,0,1,10\nGOTO/-10,0,0\n", vec![LINE, LINE]),
            ("GOTO/0,10,0\nGOTO/-10,0,0\n", vec![LINE, LINE, DOUBT]),
            ("FROM/0,10,1\nGOTO/-10,0,0\n", vec![LINE, LINE]),
            // Along the tangent, and so near that arc and line are the same.
            ("GOTO/-0.3,10,0\nGOTO/-8,10,0\n", vec![LINE, LINE, LINE]),
        ] {
            assert_eq!(reasons(&format!("{quarter}{behind}")), expected, "{behind}");
        }
        // Equal ends: a whole circle, or the start again.
        let whole = "FEDRAT/100,MMPM\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/10,0,0\n";
        assert_eq!(reasons(&format!("{whole}GOTO/0,10,0\n")), [LINE, DOUBT]);
        // A helix.
        let helix = "FEDRAT/100,MMPM\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,2\n";
        assert_eq!(reasons(&format!("{helix}GOTO/-10,0,4\n")), [LINE, DOUBT]);
        assert_eq!(reasons(&format!("{helix}GOTO/-10,0,0\n")), [LINE, LINE]);
        // The other sense.
        let clockwise = quarter.replace("0,0,1,10", "0,0,-1,10");
        assert_eq!(reasons(&format!("{clockwise}GOTO/-10,0,0\n")), [LINE, LINE]);
        assert_eq!(reasons(&format!("{clockwise}GOTO/6,8,0\n")), [LINE, DOUBT]);
    }

    #[test]
    fn a_circle_with_other_items_is_no_arc_that_is_followed() {
        let unread = Some(Unfollowable::CircleUnread);
        for (items, expected) in [
            ("0,0,0,0,0,1,10", LINE),
            ("0,0,0,0,0,1", LINE),
            (" 0 , 0,0,0,0,1., $\n10.,", LINE),
            ("0,0,0,0,0,1,10,0.06,0.5,12,0", LINE),
            ("0,0,0,0,0,1,10,0.06,0.5,12,0,TIMES,3", unread),
            ("0,0,0,0,0,1,10,TIMES,1", unread),
            ("0,0,0,0,0,1,10,CCLW", unread),
            ("0,0,0,0,0,1,10,1,2,3,4,5", unread),
            ("0,0,,0,0,1,10", unread),
            ("0,0,0,0,0,0,10", unread),
            ("0,0,0,10", unread),
            ("CENTER,0,0,0,RADIUS,10", unread),
        ] {
            let text = format!("FEDRAT/100,MMPM\nGOTO/10,0,0\nCIRCLE/{items}\nGOTO/0,10,0\nGOTO/0,11,0\n");
            assert_eq!(reasons(&text), [expected, LINE], "{items}");
        }
    }
}
