//! Side milling: the shift that puts the worn flank on the same contact line (P3 eq. (5)).

use super::tip_shift::{length_shift_mm, unit};
use super::{CutterWear, ShiftFault, TipShift};
use crate::geometry::{Vec3, across};

/// Largest |n·t| of a flank contact: the effect of three-decimal contact words on a 1 mm radius.
const FLANK_COSINE: f64 = 1e-3;

/// The shift that keeps a flank contact with normal `normal` (out of the part, any length) across the unit tool
/// axis `axis`, both in W: `Δ = (R′ − R)·n − ΔL·t` (§4; P3 eq. (5)). The part of n along t, which comes from
/// rounding, is removed, so that the flank moves only across the axis.
///
/// # Errors
/// A normal without length, or one that is not across the tool axis (|n·t| > 1e-3).
pub fn side_milling_shift(wear: &CutterWear, axis: Vec3, normal: Vec3) -> Result<TipShift, ShiftFault> {
    let n = unit(normal)?;
    let cosine = n.dot(&axis);
    if cosine.abs() > FLANK_COSINE {
        return Err(ShiftFault::NotFlank { cosine, max: FLANK_COSINE });
    }
    let m = across(n, axis).normalize();
    let shift_mm = m * wear.radius_change_mm() + length_shift_mm(wear.shorter_by, axis);
    Ok(TipShift { shift_mm, note: None })
}
