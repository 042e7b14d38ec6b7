//! A needle against one straight piece of motion, in the frame of the tool.
//!
//! In this frame the needle moves and the cutter is at rest. At the fraction u of the piece and the height s, the
//! needle is at `(1 − u)(a0 + s·n0) + u(a1 + s·n1)`. The signed distance d(s, u) is convex in u for every s, and
//! convex in s for every u, because the cutter is convex.

use crate::contact::CutterBody;
use crate::geometry::Vec3;

/// Smallest depth by which a level must be entered \[mm\].
const FLOOR_MM: f64 = -1e-8;
/// Enlargement of the cutter, so that a needle or its top that is only touched counts in spite of rounding \[mm\].
const TOUCH_MM: f64 = 2e-8;
/// Accuracy of a least distance \[mm\], or as a share of itself: the next level checks again.
const GAP_MM: f64 = 1e-9;
const GAP_SHARE: f64 = 0.02;
/// Accuracy of entries \[mm\].
const ENTRY_MM: f64 = 1e-11;
/// Bounds on the number of steps. They are only reached by rounding.
const MAX_STEPS: usize = 60;
/// Levels after which the entry counts as on a fold, and tangent planes are used.
const SMOOTH_LEVELS: usize = 2;
/// Levels after which the entry counts as on a fold where entries decrease too slowly, and heights are bisected.
const LEVELS: usize = 24;
/// Accuracy of a bisected entry: that of a least distance \[mm\].
const BISECTED_MM: f64 = 1e-9;

/// A needle in the frame of the tool, at both ends of a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    /// Its sample \[mm\].
    pub(super) at_mm: [Vec3; 2],
    /// Its direction.
    pub(super) along: [Vec3; 2],
}

/// The distance at one fraction u of a line.
#[derive(Debug, Clone, Copy)]
struct Mark {
    u: f64,
    distance_mm: f64,
    /// Derivative by u.
    slope: f64,
}

/// The position of the least distance along a line.
#[derive(Debug, Clone, Copy)]
struct Least {
    mark: Mark,
    /// Marks on either side of it, with the distance decreasing and increasing; `None` at an end of the line.
    between: Option<[Mark; 2]>,
}

/// A position of the piece that enters below a height.
#[derive(Debug, Clone, Copy)]
struct Entering {
    u: f64,
    /// Marks on either side of the least distance, if nothing else decides u.
    between: Option<[Mark; 2]>,
}

/// A line from u = 0 to u = 1 in the frame of the tool.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    from_mm: Vec3,
    step_mm: Vec3,
}

impl Run {
    pub(super) fn new([from_mm, to_mm]: [Vec3; 2]) -> Self {
        Self { from_mm, step_mm: to_mm - from_mm }
    }

    #[inline]
    fn mark(&self, body: &CutterBody, u: f64) -> Mark {
        let p = self.from_mm + self.step_mm * u;
        let radial_mm = (p.x * p.x + p.y * p.y).sqrt();
        let profile = body.profile(radial_mm, p.z);
        // On the axis the distance has no radial slope except on folds, where any slope will do.
        let turn = if radial_mm > 0.0 { profile.radial / radial_mm } else { 0.0 };
        let slope = (p.x * self.step_mm.x + p.y * self.step_mm.y) * turn + profile.axial * self.step_mm.z;
        Mark { u, distance_mm: profile.distance_mm - TOUCH_MM, slope }
    }

    /// A lower bound of the distance along the run, by its tangents: those at the ends, and one between if these do
    /// not decide `enough_mm`.
    #[inline]
    pub(super) fn lower_bound_mm(&self, body: &CutterBody, enough_mm: f64) -> f64 {
        let left = self.mark(body, 0.0);
        if left.slope >= 0.0 {
            return left.distance_mm;
        }
        let right = self.mark(body, 1.0);
        if right.slope <= 0.0 {
            return right.distance_mm;
        }
        let (meet, bound_mm) = tangents(&left, &right);
        if bound_mm >= enough_mm {
            return bound_mm;
        }
        let middle = self.mark(body, meet.clamp(0.0, 1.0));
        let (_, finer_mm) =
            if middle.slope < 0.0 { tangents(&middle, &right) } else { tangents(&left, &middle) };
        finer_mm.max(bound_mm).min(middle.distance_mm)
    }

    /// The approximate position of the least distance, if it is below `floor_mm` anywhere.
    #[inline]
    fn least(&self, body: &CutterBody, floor_mm: f64) -> Option<Least> {
        let mut left = self.mark(body, 0.0);
        if left.slope >= 0.0 {
            return (left.distance_mm < floor_mm).then_some(Least { mark: left, between: None });
        }
        let mut right = self.mark(body, 1.0);
        if right.slope <= 0.0 {
            return (right.distance_mm < floor_mm).then_some(Least { mark: right, between: None });
        }
        let below = |mark: Mark, left, right| {
            (mark.distance_mm < floor_mm).then_some(Least { mark, between: Some([left, right]) })
        };
        let mut best = if left.distance_mm < right.distance_mm { left } else { right };
        for step in 0..MAX_STEPS {
            let (meet, bound_mm) = tangents(&left, &right);
            if bound_mm >= floor_mm {
                return None;
            }
            let gap_mm = best.distance_mm - bound_mm;
            if gap_mm <= GAP_MM || (gap_mm <= -GAP_SHARE * best.distance_mm && best.distance_mm < floor_mm) {
                return below(best, left, right);
            }
            let width = right.u - left.u;
            // The secant is for smooth parts, the intersection of tangents for folds, the middle for all others.
            let u = match step % 3 {
                0 => left.u - width * left.slope / (right.slope - left.slope),
                1 => meet,
                _ => left.u + 0.5 * width,
            };
            if !(u > left.u && u < right.u) {
                return below(best, left, right);
            }
            let mark = self.mark(body, u);
            if mark.distance_mm < best.distance_mm {
                best = mark;
            }
            if mark.slope < 0.0 {
                left = mark;
            } else {
                right = mark;
            }
        }
        below(best, left, right)
    }

    /// The root of the distance that Newton's method reaches from outside, starting at `u`. The distance is convex,
    /// so it never goes past the root.
    fn enter(&self, body: &CutterBody, mut u: f64) -> f64 {
        for _ in 0..MAX_STEPS {
            let mark = self.mark(body, u);
            if mark.distance_mm <= ENTRY_MM || mark.slope == 0.0 {
                break;
            }
            u -= mark.distance_mm / mark.slope;
        }
        u
    }
}

/// Intersection of the tangents of both marks, and its height; `left.slope < right.slope`.
#[inline]
fn tangents(left: &Mark, right: &Mark) -> (f64, f64) {
    let width = right.u - left.u;
    let run = (right.slope * width - (right.distance_mm - left.distance_mm)) / (right.slope - left.slope);
    (left.u + run, left.distance_mm + left.slope * run)
}

impl Section {
    /// The path of the needle's point at height `s_mm`.
    #[inline]
    fn level(&self, s_mm: f64) -> Run {
        let [from, to] = &self.at_mm;
        Run::new([from + self.along[0] * s_mm, to + self.along[1] * s_mm])
    }

    /// The needle at the fraction `u`, as a function of its height.
    fn needle(&self, u: f64) -> Run {
        let from_mm = self.at_mm[0] + (self.at_mm[1] - self.at_mm[0]) * u;
        Run { from_mm, step_mm: self.along[0] + (self.along[1] - self.along[0]) * u }
    }

    /// The smallest height below `best_mm` at which a position of the piece enters that also contains `stock_mm`,
    /// if there is one; `best_mm` ≤ `stock_mm`.
    ///
    /// At a height s, the least distance over all counting u is found. If it is negative, the entry at that u is
    /// the next, lower s. No u can enter below a height at which all have a distance of 0 or more: it would contain
    /// the stock's height and its entry, and so every height between.
    #[inline]
    pub(super) fn entry_below(&self, body: &CutterBody, stock_mm: f64, best_mm: f64) -> Option<f64> {
        let mut s_mm = best_mm;
        let mut lowest = None;
        let mut down_mm = 0.0;
        for step in 0..LEVELS {
            let Some(Entering { u, between }) = self.entering(body, stock_mm, s_mm) else { return lowest };
            let mut entered_mm = self.entry_at(body, u, s_mm);
            if let Some(between) = between.filter(|_| step >= SMOOTH_LEVELS)
                && let Some(u) = self.on_fold(body, s_mm, between)
                && self.level(s_mm).mark(body, u).distance_mm < FLOOR_MM
                && self
                    .counting(body, stock_mm, s_mm, u)
                    .is_some_and(|nearest| nearest.to_bits() == u.to_bits())
            {
                entered_mm = entered_mm.min(self.entry_at(body, u, s_mm));
            }
            if entered_mm >= s_mm {
                return lowest;
            }
            down_mm = s_mm - entered_mm;
            s_mm = entered_mm;
            lowest = Some(s_mm);
        }
        Some(self.bisected(body, stock_mm, s_mm, down_mm))
    }

    /// A position of the piece that enters below the height `s_mm` and also contains `stock_mm`.
    #[inline]
    fn entering(&self, body: &CutterBody, stock_mm: f64, s_mm: f64) -> Option<Entering> {
        let level = self.level(s_mm);
        let Least { mark, between } = level.least(body, FLOOR_MM)?;
        let u = self.counting(body, stock_mm, s_mm, mark.u)?;
        let is_free = u.to_bits() == mark.u.to_bits();
        let distance_mm = if is_free { mark.distance_mm } else { level.mark(body, u).distance_mm };
        (distance_mm < FLOOR_MM).then_some(Entering { u, between: between.filter(|_| is_free) })
    }

    /// The smallest entry below `high_mm`, an entry that was reached by a last step of `down_mm`. A position that
    /// enters below a height also contains every height between it and the stock, so heights can be bisected.
    #[cold]
    fn bisected(&self, body: &CutterBody, stock_mm: f64, mut high_mm: f64, mut down_mm: f64) -> f64 {
        let entry_mm = |at_mm: f64| {
            let found = self.entering(body, stock_mm, at_mm)?;
            Some(self.entry_at(body, found.u, at_mm).min(at_mm))
        };
        let mut low_mm = high_mm - down_mm;
        for _ in 0..MAX_STEPS {
            let Some(entered_mm) = entry_mm(low_mm) else { break };
            down_mm *= 2.0;
            (high_mm, low_mm) = (entered_mm, entered_mm - down_mm);
        }
        for _ in 0..MAX_STEPS {
            if high_mm - low_mm <= BISECTED_MM {
                break;
            }
            let middle_mm = 0.5 * (low_mm + high_mm);
            match entry_mm(middle_mm) {
                Some(entered_mm) => high_mm = entered_mm,
                None => low_mm = middle_mm,
            }
        }
        high_mm
    }

    /// The intersection of the tangent planes of d(s, u) at two marks of the level `s_mm` with the plane d = 0, if
    /// it is between them. On a fold of the distance, the entries at one u decrease slowly, and these do not.
    fn on_fold(&self, body: &CutterBody, s_mm: f64, [left, right]: [Mark; 2]) -> Option<f64> {
        let [by_left, by_right] = [left.u, right.u].map(|u| self.needle(u).mark(body, s_mm).slope);
        let [from_left, from_right] = [left, right].map(|mark| mark.u - mark.distance_mm / mark.slope);
        let down_mm = (from_left - from_right) / (by_left / left.slope - by_right / right.slope);
        let u = left.u - (left.distance_mm + by_left * down_mm) / left.slope;
        (down_mm < 0.0 && u > left.u && u < right.u).then_some(u)
    }

    /// The fraction nearest to `u` at which the cutter contains the needle's top.
    fn counting(&self, body: &CutterBody, stock_mm: f64, s_mm: f64, u: f64) -> Option<f64> {
        if s_mm >= stock_mm {
            return Some(u);
        }
        let top = self.level(stock_mm);
        if top.mark(body, u).distance_mm <= 0.0 {
            return Some(u);
        }
        top.least(body, FLOOR_MM)?;
        Some(top.enter(body, u).clamp(0.0, 1.0))
    }

    /// The point at which the cutter, which contains the needle at `inside_mm`, begins on it.
    fn entry_at(&self, body: &CutterBody, u: f64, inside_mm: f64) -> f64 {
        let needle = self.needle(u);
        let mark = needle.mark(body, inside_mm);
        // A tangent's root is outside. If the tangent does not fall, a point a whole diameter below is.
        let outside_mm = if mark.slope < -0.1 {
            inside_mm - mark.distance_mm / mark.slope
        } else {
            inside_mm - 2.0 * (2.0 * body.radius_mm() + body.cutting_length_mm())
        };
        needle.enter(body, outside_mm)
    }
}
