//! End milling: the shift that puts the worn cutter's corner on the same contact point (P3 eq. (6)).

use super::tip_shift::{checked_normal, length_shift_mm};
use super::{CutterWear, FlatContact, ShiftFault, TipShift};
use crate::geometry::{Vec3, across, angle_between};

/// A normal this close to the tool axis leaves the direction across it undetermined \[rad\]: there the rounding of
/// six decimals turns that direction by a tenth of a radian.
const OPEN_ANGLE_RAD: f64 = 1e-5;
/// Nearer than 0.1° to the tool axis, the side of the contact needs a warning \[rad\].
const NEARLY_FLAT_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// The shift that keeps the contact point of end milling with normal `normal` (out of the part, any length) and unit
/// tool axis `axis`, both in W: `Δ = (r′ − r)(n − t) + ((R′ − r′) − (R − r))·m − ΔL·t` (§4; P3 eq. (6)), m = n across
/// t.
///
/// If n ∥ t, the whole flat of a bull-nose or flat cutter touches. There is no m, Δ = −ΔL·t, and the note says so.
///
/// # Errors
/// A normal without length, or one that points away from the tool (n·t < 0 beyond rounding).
pub fn end_milling_shift(wear: &CutterWear, axis: Vec3, normal: Vec3) -> Result<TipShift, ShiftFault> {
    let n = checked_normal(axis, normal)?;
    let length_mm = length_shift_mm(wear.shorter_by, axis);
    let corner_mm = (n - axis) * wear.corner_change_mm();
    if wear.has_no_flat() {
        return Ok(TipShift { shift_mm: corner_mm + length_mm, note: None });
    }
    let angle_rad = angle_between(n, axis);
    if angle_rad < OPEN_ANGLE_RAD {
        return Ok(TipShift { shift_mm: length_mm, note: Some(FlatContact::Whole) });
    }
    let m = across(n, axis).normalize();
    let shift_mm = corner_mm + m * wear.core_change_mm() + length_mm;
    let note = (angle_rad < NEARLY_FLAT_RAD).then_some(FlatContact::Nearly { angle_rad });
    Ok(TipShift { shift_mm, note })
}

/// Residual of the worn cutter along the normal with the unchanged program \[mm\], + excess, − gouge, without the
/// cusp: `(r − r′)(1 − n·t) + ((R − r) − (R′ − r′))·(m·n) + ΔL·(n·t)`.
///
/// # Errors
/// As for [`end_milling_shift`].
pub fn uncompensated_excess_mm(wear: &CutterWear, axis: Vec3, normal: Vec3) -> Result<f64, ShiftFault> {
    let n = checked_normal(axis, normal)?;
    Ok(-end_milling_shift(wear, axis, n)?.shift_mm.dot(&n))
}
