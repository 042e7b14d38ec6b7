//! Paths in a plane, made of lines and arcs, and the paths that run beside them at a distance.

use super::trig;

/// A point or a direction in a plane \[mm\].
type Plane = [f64; 2];

/// A straight or circular piece of a path in a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanePiece {
    /// Where it begins \[mm\].
    pub start_mm: [f64; 2],
    /// Where it ends \[mm\].
    pub end_mm: [f64; 2],
    /// `None` for a line.
    pub circle: Option<PlaneCircle>,
    /// The direction of a line, of length 1; not used for arcs.
    direction: [f64; 2],
}

/// The circle on which an arc runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneCircle {
    /// Its centre \[mm\].
    pub centre_mm: [f64; 2],
    /// Whether the arc runs clockwise.
    pub is_clockwise: bool,
}

/// How two pieces of a path beside another path are joined at a corner of that path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Corner {
    /// One goes on in the direction of the other.
    Smooth,
    /// An arc about the corner joins them.
    Around,
    /// They meet in this point, and what lies beyond is cut off \[mm\].
    Meet([f64; 2]),
    /// They do not meet: a cutter of this radius cannot go there.
    OutOfReach,
}

/// Corners that turn by less than this are no corners \[rad\].
const SMOOTH_RAD: f64 = 0.05;
/// Pieces and radii shorter than this have no direction \[mm\].
const NO_LENGTH_MM: f64 = 1e-9;
/// Directions that differ from opposite ones by less than this do not meet.
const OPPOSITE: f64 = 1e-9;

impl PlanePiece {
    /// A line between these points \[mm\]; `None` if it has no length.
    #[must_use]
    pub fn line(start_mm: [f64; 2], end_mm: [f64; 2]) -> Option<Self> {
        let direction = unit(from_to(start_mm, end_mm))?;
        Some(Self { start_mm, end_mm, circle: None, direction })
    }

    /// An arc between these points \[mm\]; `None` if the centre is one of them.
    #[must_use]
    pub fn arc(start_mm: [f64; 2], end_mm: [f64; 2], circle: PlaneCircle) -> Option<Self> {
        let is_apart = |at: Plane| unit(from_to(circle.centre_mm, at)).is_some();
        let direction = [0.0; 2];
        (is_apart(start_mm) && is_apart(end_mm)).then_some(Self {
            start_mm,
            end_mm,
            circle: Some(circle),
            direction,
        })
    }

    /// The same piece at a distance to the left of its direction \[mm\], to the right if the distance is negative.
    /// `None` if an arc would turn inside out.
    #[must_use]
    pub fn beside(&self, distance_mm: f64) -> Option<Self> {
        if let Some(circle) = self.circle {
            let inwards_mm = if circle.is_clockwise { -distance_mm } else { distance_mm };
            let shortest_mm = length(from_to(circle.centre_mm, self.start_mm))
                .min(length(from_to(circle.centre_mm, self.end_mm)));
            if shortest_mm - inwards_mm <= NO_LENGTH_MM {
                return None;
            }
        }
        let moved = |at: Plane| Some(add(at, left_of(self.direction_at(at)?), distance_mm));
        Some(Self { start_mm: moved(self.start_mm)?, end_mm: moved(self.end_mm)?, ..*self })
    }

    /// The direction in which it runs through a point on it, of length 1.
    #[must_use]
    pub fn direction_at(&self, at_mm: [f64; 2]) -> Option<[f64; 2]> {
        let Some(circle) = self.circle else { return Some(self.direction) };
        let ahead = left_of(unit(from_to(circle.centre_mm, at_mm))?);
        Some(if circle.is_clockwise { ahead.map(|part| -part) } else { ahead })
    }

    /// By how much the next piece turns towards the path beside, at this distance to the left or right \[rad\].
    #[must_use]
    pub fn inward_turn_rad(&self, next: &Self, distance_mm: f64) -> Option<f64> {
        let (before, after) = (self.direction_at(self.end_mm)?, next.direction_at(next.start_mm)?);
        Some(towards(distance_mm) * trig::atan2(cross(before, after), dot(before, after)))
    }

    /// Where the paths beside this piece and the next one meet, if the path turns towards them \[mm\]; `None` if a cutter
    /// of this radius cannot go there.
    #[must_use]
    pub fn meeting_mm(&self, next: &Self, distance_mm: f64) -> Option<[f64; 2]> {
        let (first, second) = (self.beside(distance_mm)?, next.beside(distance_mm)?);
        first.meets(&second, towards(distance_mm))
    }

    /// How this piece and the next one are joined `distance_mm` to the left of the path, or to the right if the
    /// distance is negative. A path that goes back on itself runs around its turning point, except beside an arc whose
    /// outer side it follows.
    #[must_use]
    pub fn corner(&self, next: &Self, distance_mm: f64) -> Corner {
        // Positive turns are inner corners.
        let Some(turn_rad) = self.inward_turn_rad(next, distance_mm) else { return Corner::OutOfReach };
        let is_back = turn_rad.abs() > std::f64::consts::PI - SMOOTH_RAD;
        let is_outside = |circle: PlaneCircle| circle.is_clockwise == (distance_mm > 0.0);
        let is_inner =
            if is_back { next.circle.or(self.circle).is_some_and(is_outside) } else { turn_rad > SMOOTH_RAD };
        if !is_inner {
            return if turn_rad < -SMOOTH_RAD || is_back { Corner::Around } else { Corner::Smooth };
        }
        self.meeting_mm(next, distance_mm).map_or(Corner::OutOfReach, Corner::Meet)
    }

    /// Where this piece or its continuation meets the next one or its continuation, and turns `towards` the left (1)
    /// or the right (−1) \[mm\].
    fn meets(&self, next: &Self, towards: f64) -> Option<Plane> {
        let places = match (self.circle, next.circle) {
            (None, None) => {
                let crossing = cross(self.direction, next.direction);
                if crossing.abs() < OPPOSITE {
                    return None;
                }
                let way_mm = cross(from_to(self.end_mm, next.start_mm), next.direction) / crossing;
                return Some(add(self.end_mm, self.direction, way_mm));
            }
            (None, Some(circle)) => line_and_circle(self, circle.centre_mm, next.start_mm)?,
            (Some(circle), None) => line_and_circle(next, circle.centre_mm, self.end_mm)?,
            (Some(first), Some(second)) => {
                two_circles([first.centre_mm, second.centre_mm], [self.end_mm, next.end_mm])?
            }
        };
        places.into_iter().find(|&at_mm| {
            let directions = self.direction_at(at_mm).zip(next.direction_at(at_mm));
            directions.is_some_and(|(before, after)| towards * cross(before, after) > 0.0)
        })
    }

    /// The angle through which an arc runs from one point to another, in its own direction \[rad\]: more than 0, and a
    /// full turn if both are the same. 0 for a line.
    #[must_use]
    pub fn sweep_rad(&self, from_mm: [f64; 2], to_mm: [f64; 2]) -> f64 {
        let Some(circle) = self.circle else { return 0.0 };
        let [first, last] = [from_mm, to_mm].map(|at| from_to(circle.centre_mm, at));
        let angle_rad = trig::atan2(cross(first, last), dot(first, last));
        let ahead_rad = if circle.is_clockwise { -angle_rad } else { angle_rad };
        if ahead_rad > SAME_ANGLE_RAD { ahead_rad } else { ahead_rad + std::f64::consts::TAU }
    }
}

/// Angles closer to 0 than this are 0 \[rad\].
const SAME_ANGLE_RAD: f64 = 1e-9;

/// 1 for a path beside on the left, −1 on the right.
fn towards(distance_mm: f64) -> f64 {
    if distance_mm < 0.0 { -1.0 } else { 1.0 }
}

/// The points in which the line of a piece meets the circle about a centre through a point \[mm\].
fn line_and_circle(line: &PlanePiece, centre_mm: Plane, on_circle_mm: Plane) -> Option<[Plane; 2]> {
    let radius_mm = length(from_to(centre_mm, on_circle_mm));
    let to_centre = from_to(line.start_mm, centre_mm);
    let (along_mm, across_mm) = (dot(line.direction, to_centre), cross(line.direction, to_centre));
    let half_mm = ((radius_mm - across_mm) * (radius_mm + across_mm)).sqrt();
    (half_mm > 0.0)
        .then(|| [along_mm - half_mm, along_mm + half_mm].map(|way| add(line.start_mm, line.direction, way)))
}

/// The points in which the circles about two centres, each through a point, meet \[mm\].
fn two_circles(centres_mm: [Plane; 2], on_circles_mm: [Plane; 2]) -> Option<[Plane; 2]> {
    let [first_mm, second_mm] = [0, 1].map(|k: usize| length(from_to(centres_mm[k], on_circles_mm[k])));
    let between = from_to(centres_mm[0], centres_mm[1]);
    let apart_mm = length(between);
    let direction = unit(between)?;
    let along_mm = 0.5 * (apart_mm + (first_mm - second_mm) * (first_mm + second_mm) / apart_mm);
    let across_mm = ((first_mm - along_mm) * (first_mm + along_mm)).sqrt();
    let foot = add(centres_mm[0], direction, along_mm);
    (across_mm > 0.0).then(|| [across_mm, -across_mm].map(|way_mm| add(foot, left_of(direction), way_mm)))
}

fn from_to(from: Plane, to: Plane) -> Plane {
    [to[0] - from[0], to[1] - from[1]]
}

fn add(at: Plane, direction: Plane, way_mm: f64) -> Plane {
    [at[0] + way_mm * direction[0], at[1] + way_mm * direction[1]]
}

fn left_of(direction: Plane) -> Plane {
    [-direction[1], direction[0]]
}

fn cross(a: Plane, b: Plane) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Plane, b: Plane) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn length(a: Plane) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: Plane) -> Option<Plane> {
    let size = length(a);
    (size > NO_LENGTH_MM && size.is_finite()).then(|| a.map(|part| part / size))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROUNDING_MM: f64 = 1e-12;

    fn line(start: Plane, end: Plane) -> PlanePiece {
        PlanePiece::line(start, end).unwrap()
    }

    fn arc(start: Plane, end: Plane, centre_mm: Plane, is_clockwise: bool) -> PlanePiece {
        PlanePiece::arc(start, end, PlaneCircle { centre_mm, is_clockwise }).unwrap()
    }

    #[track_caller]
    fn assert_meet(corner: Corner, expected: Plane) {
        let Corner::Meet(at) = corner else { panic!("{corner:?}") };
        assert!(length(from_to(at, expected)) < ROUNDING_MM, "{at:?} {expected:?}");
    }

    #[test]
    fn left_and_right_of_a_square_corner() {
        let (along, up) = (line([0.0, 0.0], [10.0, 0.0]), line([10.0, 0.0], [10.0, 10.0]));
        assert_meet(along.corner(&up, 1.0), [9.0, 1.0]);
        assert_eq!(along.corner(&up, -1.0), Corner::Around);
        let beside = along.beside(-1.0).unwrap();
        assert_eq!((beside.start_mm, beside.end_mm), ([0.0, -1.0], [10.0, -1.0]));
    }

    #[test]
    fn a_path_that_goes_on_or_back() {
        let along = line([0.0, 0.0], [10.0, 0.0]);
        assert_eq!(along.corner(&line([10.0, 0.0], [20.0, 0.2]), 1.0), Corner::Smooth);
        assert_eq!(along.corner(&line([10.0, 0.0], [0.0, 0.0]), 1.0), Corner::Around);
        // Up at an end of a half circle, which has the path on its outer side.
        let bow = arc([0.0, 0.0], [4.0, 0.0], [2.0, 0.0], true);
        assert_meet(bow.corner(&line([4.0, 0.0], [4.0, 9.0]), 1.0), [3.0, 8.0_f64.sqrt()]);
    }

    #[test]
    fn lines_and_arcs_meet_where_the_path_turns_inwards() {
        // From the left into a circle of 5 and along it, counter-clockwise, within it.
        let along = line([-9.0, 0.0], [5.0, 0.0]);
        let round = arc([5.0, 0.0], [0.0, 5.0], [0.0, 0.0], false);
        assert_meet(along.corner(&round, 1.0), [15.0_f64.sqrt(), 1.0]);
        // The same path backwards, on its other side.
        let back = arc([0.0, 5.0], [5.0, 0.0], [0.0, 0.0], true);
        assert_meet(back.corner(&line([5.0, 0.0], [-9.0, 0.0]), -1.0), [15.0_f64.sqrt(), 1.0]);
        // Two circles of 5 that meet in a valley between their centres.
        let (first, second) =
            (arc([0.0, 5.0], [4.0, 3.0], [0.0, 0.0], true), arc([4.0, 3.0], [8.0, 5.0], [8.0, 0.0], true));
        assert_meet(first.corner(&second, 1.0), [4.0, 20.0_f64.sqrt()]);
        assert_eq!(first.corner(&second, -1.0), Corner::Around);
        // A circle too small for a path within it.
        let narrow = arc([5.0, 0.0], [6.0, 1.0], [5.0, 1.0], false);
        assert_eq!(narrow.beside(1.0), None);
    }

    #[test]
    fn angles_count_in_the_direction_of_the_arc() {
        let quarter = arc([5.0, 0.0], [0.0, 5.0], [0.0, 0.0], false);
        let right_angle = std::f64::consts::FRAC_PI_2;
        let sweep = |clockwise: bool| {
            arc([5.0, 0.0], [0.0, 5.0], [0.0, 0.0], clockwise).sweep_rad([5.0, 0.0], [0.0, 5.0])
        };
        assert!(
            (sweep(false) - right_angle).abs() < 1e-15 && (sweep(true) - 3.0 * right_angle).abs() < 1e-15
        );
        assert!((quarter.sweep_rad([5.0, 0.0], [5.0, 0.0]) - 4.0 * right_angle).abs() < 1e-15);
    }
}
