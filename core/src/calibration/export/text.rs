//! The form of numbers and names in the texts.

use std::fmt::Write;

use crate::geometry::Vec3;
use crate::machine::Squareness;
use crate::units::URAD_PER_RAD;

/// The shortest digits that read back as the same number; −0 is never written.
pub(super) fn exact(value: f64) -> String {
    format!("{:?}", value + 0.0)
}

/// Three numbers in brackets, exact.
pub(super) fn exact_vector(v: Vec3) -> String {
    format!("[{}, {}, {}]", exact(v.x), exact(v.y), exact(v.z))
}

/// A name in quotation marks, as TOML reads it.
pub(super) fn quoted(name: &str) -> String {
    let mut out = String::from("\"");
    for c in name.chars() {
        match c {
            '"' | '\\' => {
                out.push('\\');
                out.push(c);
            }
            c if c.is_control() => {
                // Writing to a String cannot fail.
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A name in a comment, always on one line.
pub(super) fn in_comment(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Decimals of a length for a control: a nanometre.
pub(super) const MM_DECIMALS: i32 = 6;
/// Decimals of a direction for a control: a picometre at one metre.
pub(super) const DIRECTION_DECIMALS: i32 = 12;

/// The number as printed with this number of decimals; −0 becomes 0.
pub(super) fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10.0_f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}

/// [`rounded`] for every component.
pub(super) fn rounded_vector(v: Vec3, decimals: i32) -> Vec3 {
    v.map(|value| rounded(value, decimals))
}

/// An angle in µrad, for people to read.
pub(super) fn microradians(value_rad: f64) -> String {
    format!("{:.1}", rounded(value_rad * URAD_PER_RAD, 1))
}

/// Squareness, for people to read.
pub(super) fn squareness(square: &Squareness) -> String {
    format!(
        "Y turned by {} urad about Z, Z by {} about Y and {} about X",
        microradians(square.e_c0y_rad),
        microradians(square.e_b0z_rad),
        microradians(square.e_a0z_rad)
    )
}

/// A length as a control reads it.
pub(super) fn millimetres(value_mm: f64) -> String {
    format!("{:.6}", rounded(value_mm, MM_DECIMALS))
}
