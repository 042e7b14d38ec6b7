//! Arcs of cutter location data as chords.

use crate::geometry::{Vec3, angle_about, trig};
use crate::process::fault::NotPosted;

/// Largest distance of the ends from their circle \[mm\], or share of its radius, as six digits of the radius
/// leave. Few decimals in the text add to it.
const OFF_CIRCLE_MM: f64 = 0.01;
const OFF_CIRCLE_SHARE: f64 = 1e-5;
/// Ends this near are the same point, so the arc is a full circle \[mm\].
const SAME_POINT_MM: f64 = 1e-6;
/// Two copies of one point, rounded by half a unit on every axis, differ by less than this \[units\].
const ROUNDED_ENDS: f64 = 2.0;
/// Most chords of an arc.
const MAX_CHORDS: f64 = 100_000.0;

/// `CIRCLE/x,y,z,i,j,k[,r…]`: centre, axis and radius. The arc turns counterclockwise as seen from the tip of the
/// axis vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    centre_mm: Vec3,
    axis: Vec3,
    radius_mm: Option<f64>,
}

impl Circle {
    /// Reads the statement, with lengths in program units of `mm_per_unit`.
    pub(super) fn read(statement: &[u8], mm_per_unit: f64) -> Option<Self> {
        let text = std::str::from_utf8(statement).ok()?;
        let mut numbers = text.split_once('/')?.1.split(',').map(|item| {
            item.trim_matches(|c: char| c.is_whitespace() || c == '$')
                .parse::<f64>()
                .ok()
                .filter(|x| x.is_finite())
        });
        let mut vector = || Some(Vec3::new(numbers.next()??, numbers.next()??, numbers.next()??));
        let centre_mm = vector()? * mm_per_unit;
        let axis = vector()?.try_normalize(1e-3)?;
        let radius_mm = numbers.next().flatten().map(|radius| radius * mm_per_unit);
        Some(Self { centre_mm, axis, radius_mm })
    }

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
        let across = |point: Vec3| {
            let from = point - self.centre_mm;
            let along = from.dot(&self.axis);
            (from - self.axis * along, along)
        };
        let ((from, low), (to, high)) = (across(start), across(end));
        let (radius_mm, other_mm) = (from.norm(), to.norm());
        let off_mm = OFF_CIRCLE_MM.max(OFF_CIRCLE_SHARE * radius_mm).max(ROUNDED_ENDS * unit_mm);
        if (radius_mm - other_mm).abs() > off_mm || radius_mm < SAME_POINT_MM {
            return Err(NotPosted::Arc { why: "its ends are not on one circle about its centre" });
        }
        if let Some(stated_mm) = self.radius_mm
            && [radius_mm, other_mm].iter().any(|radius| (radius - stated_mm).abs() > off_mm)
        {
            return Err(NotPosted::ArcRadius { stated_mm, start_mm: radius_mm, end_mm: other_mm });
        }
        let turn = angle_about(self.axis, from, to);
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
        let side = self.axis.cross(&from);
        let mut points: Vec<Vec3> = (1..count)
            .map(|k| {
                let u = f64::from(k) / chords;
                let (sin, cos) = trig::sin_cos(turn_rad * u);
                let scale = 1.0 + (other_mm / radius_mm - 1.0) * u;
                self.centre_mm + (from * cos + side * sin) * scale + self.axis * (low + (high - low) * u)
            })
            .collect();
        points.push(end);
        Ok(points)
    }
}
