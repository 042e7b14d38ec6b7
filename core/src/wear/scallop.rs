//! Scallop height of a ball between neighbouring passes, in forms that keep every digit, and its inverses.
//!
//! Letters: D step-over (chord between neighbouring contact points), r tool radius, Rs surface radius, k = +1 convex,
//! −1 concave, a = Rs + k·r, s = D/(2Rs), w = s·a, c = √(1 − s²), q = √(r² − w²), h height.

use super::{ScallopFault, ScallopQuantity, Surface};
use crate::units::Length;

/// Accepted lengths \[mm\]: from a picometre to a thousand kilometres, so that no intermediate value leaves the
/// range of a double, and effective radii of nearly flat cutters fit.
const MIN_MM: f64 = 1e-9;
const MAX_MM: f64 = 1e9;
/// A bound counts as kept if only rounding breaks it, so that the result of an inverse can be passed in again
/// (relative).
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Scallop height h at step-over `stepover` (D) of a ball of radius `tool_radius` (r), above the surface along its
/// normal half way between the passes (P3 eq. (4)).
///
/// Relative error at most 1e-14, up to the point where passes just meet: r − w and 1 − s are computed from the
/// lengths themselves. D = 0, and a concave surface with the tool's own radius, give 0.
///
/// # Errors
/// A length not in [1e-9, 1e9] mm (D may be 0), a concave surface narrower than the tool, passes that do not meet
/// (w > r), D > 2 Rs; each with its bound.
pub fn scallop_height(
    stepover: Length,
    tool_radius: Length,
    surface: Surface,
) -> Result<Length, ScallopFault> {
    let (d, r) = (stepover.mm(), tool_radius.mm());
    check(ScallopQuantity::Stepover, d, 0.0)?;
    check(ScallopQuantity::ToolRadius, r, MIN_MM)?;
    check_surface(surface)?;
    let height_mm = match surface.curvature() {
        None => {
            let half = kept(0.5 * d, r)
                .ok_or(ScallopFault::PassesDoNotMeet { stepover_mm: d, max_stepover_mm: 2.0 * r })?;
            half * (half / (r + ((r - half) * (r + half)).sqrt()))
        }
        Some((k, rs)) => {
            check_fits(k, r, rs)?;
            let a = rs + k * r;
            let too_wide = ScallopFault::NoChord { stepover_mm: d, max_stepover_mm: 2.0 * rs };
            let apart =
                ScallopFault::PassesDoNotMeet { stepover_mm: d, max_stepover_mm: widest_mm(k, r, rs) };
            let half = kept(0.5 * d, rs).ok_or(if a >= r { apart } else { too_wide })?;
            let s = half / rs;
            let w = kept(s * a, r).ok_or(apart)?;
            let c = ((rs - half) * (rs + half)).sqrt() / rs;
            let q = (left_mm(k, r, rs, half) * (r + w)).sqrt();
            if a * c + q <= 0.0 {
                // A convex surface far narrower than the tool, at its whole width.
                return Ok(Length::from_mm(highest_mm(k, r, rs)));
            }
            let factor = if k > 0.0 { rs * (1.0 + (rs + 2.0 * r) / (a * c + q)) } else { rs + a * c + q };
            w * (s * (factor / ((r + q) * (1.0 + c))))
        }
    };
    Ok(Length::from_mm(height_mm))
}

/// The largest step-over D that leaves at most `height`: closed form.
///
/// If `height` is as high as a scallop can get, D is the value at which neighbouring passes just meet, or 2 Rs.
///
/// # Errors
/// A length not in [1e-9, 1e9] mm (the height may be 0), a concave surface narrower than the tool.
pub fn largest_stepover(
    height: Length,
    tool_radius: Length,
    surface: Surface,
) -> Result<Length, ScallopFault> {
    let (h, r) = (height.mm(), tool_radius.mm());
    check(ScallopQuantity::AllowedHeight, h, 0.0)?;
    check(ScallopQuantity::ToolRadius, r, MIN_MM)?;
    check_surface(surface)?;
    let stepover_mm = match surface.curvature() {
        None if h >= r => 2.0 * r,
        None => 2.0 * (h * (2.0 * r - h)).sqrt(),
        Some((k, rs)) => {
            check_fits(k, r, rs)?;
            if h >= highest_mm(k, r, rs) {
                widest_mm(k, r, rs)
            } else {
                let a = rs + k * r;
                // 1 − cos of half the angle between the passes, as seen from the surface's centre.
                let v = h * (2.0 * r - h) / (2.0 * a * (rs + k * h));
                if v >= 1.0 { 2.0 * rs } else { 2.0 * rs * (v * (2.0 - v)).sqrt() }
            }
        }
    };
    Ok(Length::from_mm(stepover_mm))
}

/// The smallest tool radius r that leaves at most `height` at step-over D: closed form. A ball worn below it has
/// reached its limit. `None` if no tool up to 1e9 mm does: `height` is 0, or a convex surface bulges higher over
/// the chord.
///
/// Never below the radius at which neighbouring passes just meet; 0 if D = 0.
///
/// # Errors
/// A length not in [1e-9, 1e9] mm (height and D may be 0), D > 2 Rs.
pub fn smallest_tool_radius(
    height: Length,
    stepover: Length,
    surface: Surface,
) -> Result<Option<Length>, ScallopFault> {
    let (h, d) = (height.mm(), stepover.mm());
    check(ScallopQuantity::AllowedHeight, h, 0.0)?;
    check(ScallopQuantity::Stepover, d, 0.0)?;
    check_surface(surface)?;
    if d == 0.0 {
        return Ok(Some(Length::ZERO));
    }
    let radius_mm = match surface.curvature() {
        None => {
            let half = 0.5 * d;
            if h >= half {
                Some(half)
            } else {
                // In this order no value overflows: h/D is below 1/2.
                (h > 0.0).then(|| 0.5 * h + half * (half / (2.0 * h)))
            }
        }
        Some((k, rs)) => {
            let half = kept(0.5 * d, rs)
                .ok_or(ScallopFault::NoChord { stepover_mm: d, max_stepover_mm: 2.0 * rs })?;
            let s = half / rs;
            let c = ((rs - half) * (rs + half)).sqrt() / rs;
            let v = s * s / (1.0 + c);
            // Where passes just meet: w = r; a convex surface has no such radius at D = 2 Rs.
            let least = half / (1.0 - k * s);
            if least.is_finite() && h >= highest_mm(k, least, rs) {
                Some(least)
            } else {
                let rho = rs + k * h;
                let open = h - k * rho * v;
                let radius = (h * h + 2.0 * rs * rho * v) / (2.0 * open);
                // A tool larger than a concave surface gouges it: rounding must not give such a radius.
                let radius = if k < 0.0 { radius.min(rs) } else { radius };
                (open > 0.0).then_some(radius.max(least))
            }
        }
    };
    // Beyond the range there is no tool, and no result that could be passed in again.
    Ok(radius_mm.filter(|radius_mm| *radius_mm <= MAX_MM).map(Length::from_mm))
}

/// r − w = (r·Rs − (Rs + k·r)·D/2)/Rs \[mm\] without cancellation: the products and the sum keep their rounding
/// errors. Not below 0.
fn left_mm(k: f64, r: f64, rs: f64, half: f64) -> f64 {
    let (a, a_rest) = two_sum(rs, k * r);
    let (reach, reach_rest) = two_product(r, rs);
    let (taken, taken_rest) = two_product(a, half);
    (((reach - taken) + (reach_rest - taken_rest - a_rest * half)) / rs).max(0.0)
}

/// The sum of two numbers and its rounding error (Knuth).
fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let part = sum - x;
    (sum, (x - (sum - part)) + (y - part))
}

/// The product of two numbers below 1e290 and its rounding error (Dekker), without a fused multiply-add.
fn two_product(x: f64, y: f64) -> (f64, f64) {
    let product = x * y;
    let ((x0, x1), (y0, y1)) = (halves(x), halves(y));
    (product, ((x0 * y0 - product) + x0 * y1 + x1 * y0) + x1 * y1)
}

/// A number as a sum of two of 26 bits (Veltkamp).
fn halves(x: f64) -> (f64, f64) {
    let scaled = x * 134_217_729.0;
    let high = scaled - (scaled - x);
    (high, x - high)
}

/// The scallop where neighbouring passes just meet, or are as far apart as the surface allows \[mm\].
fn highest_mm(k: f64, r: f64, rs: f64) -> f64 {
    let a = rs + k * r;
    if a >= r {
        // k·(√(a² − r²) − Rs)
        2.0 * r * (rs / (rs + (rs * (rs + 2.0 * k * r)).max(0.0).sqrt()))
    } else {
        // Rs − √(r² − a²)
        2.0 * (rs * ((rs - r) / (rs + (rs * (2.0 * r - rs)).sqrt())))
    }
}

/// The largest step-over \[mm\] at which passes meet on a curved surface.
fn widest_mm(k: f64, r: f64, rs: f64) -> f64 {
    let a = rs + k * r;
    if a >= r { 2.0 * rs * (r / a) } else { 2.0 * rs }
}

/// The value, or the bound if the value exceeds it by rounding only; `None` beyond that.
fn kept(value: f64, bound: f64) -> Option<f64> {
    (value <= bound * (1.0 + ROUNDING)).then_some(value.min(bound))
}

fn check(quantity: ScallopQuantity, value_mm: f64, min_mm: f64) -> Result<(), ScallopFault> {
    // NaN is in no range.
    if (min_mm..=MAX_MM).contains(&value_mm) {
        return Ok(());
    }
    Err(ScallopFault::OutOfRange { quantity, value_mm, min_mm, max_mm: MAX_MM })
}

fn check_surface(surface: Surface) -> Result<(), ScallopFault> {
    surface.curvature().map_or(Ok(()), |(_, rs)| check(ScallopQuantity::SurfaceRadius, rs, MIN_MM))
}

fn check_fits(k: f64, r: f64, rs: f64) -> Result<(), ScallopFault> {
    if k < 0.0 && r > rs {
        return Err(ScallopFault::Gouge { tool_radius_mm: r, surface_radius_mm: rs });
    }
    Ok(())
}
