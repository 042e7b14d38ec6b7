//! Wear that differs along the corner: a table over the contact angle, as in some controls.

use thiserror::Error;

use super::tip_shift::{checked_normal, length_shift_mm};
use super::{ShiftFault, TipShift};
use crate::geometry::{Vec3, angle_between};
use crate::units::{Angle, Length};

/// Deviation δ of a cutter's corner over the contact angle ψ between surface normal and tool axis: how much farther
/// out (negative if worn) the tangent plane is than that of the nominal corner. Linear between the entries.
#[derive(Debug, Clone, PartialEq)]
pub struct WearTable {
    /// Angle \[rad\] and deviation \[mm\], with angles rising from 0.
    entries: Vec<(f64, f64)>,
}

/// A fault of a table.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum WearTableFault {
    /// The tip's own deviation is missing. Lengths are measured at the tip.
    #[error("a wear table must begin at 0°; add an entry for the tip")]
    NoTip,
    /// Angles that do not rise, or that are beyond the flank.
    #[error("entry {index}: a contact angle of {angle_deg}° is not above {above_deg}° and at most 90°")]
    Angle {
        /// Index of the entry, from 0.
        index: usize,
        /// Its angle \[deg\].
        angle_deg: f64,
        /// The angle before it \[deg\].
        above_deg: f64,
    },
    /// A deviation that is not plausible.
    #[error("entry {index}: a deviation of {deviation_mm:e} mm is not between −{max_mm} mm and {max_mm} mm")]
    Deviation {
        /// Index of the entry, from 0.
        index: usize,
        /// Its deviation \[mm\].
        deviation_mm: f64,
        /// Largest magnitude accepted \[mm\].
        max_mm: f64,
    },
}

impl WearTable {
    /// Largest deviation accepted for wear or regrinding \[mm\].
    pub const MAX_DEVIATION_MM: f64 = 10.0;
    /// Accepted rounding of a last entry of 90° \[rad\].
    const ANGLE_SLACK_RAD: f64 = 1e-9;

    /// A table of contact angles, rising from 0 to at most 90°, with their deviations.
    ///
    /// # Errors
    /// The first invalid entry.
    pub fn new(entries: &[(Angle, Length)]) -> Result<Self, WearTableFault> {
        let first = entries.first().map(|(angle, _)| angle.rad());
        if first != Some(0.0) {
            return Err(WearTableFault::NoTip);
        }
        let mut before_rad = -1.0;
        for (index, (angle, deviation)) in entries.iter().enumerate() {
            let (angle_rad, deviation_mm) = (angle.rad(), deviation.mm());
            let last_rad = std::f64::consts::FRAC_PI_2 + Self::ANGLE_SLACK_RAD;
            if !(angle_rad > before_rad && angle_rad <= last_rad) {
                let (angle_deg, above_deg) = (angle.deg(), Angle::from_rad(before_rad).deg());
                return Err(WearTableFault::Angle { index, angle_deg, above_deg });
            }
            let max_mm = Self::MAX_DEVIATION_MM;
            if !(-max_mm..=max_mm).contains(&deviation_mm) {
                return Err(WearTableFault::Deviation { index, deviation_mm, max_mm });
            }
            before_rad = angle_rad;
        }
        Ok(Self { entries: entries.iter().map(|(angle, deviation)| (angle.rad(), deviation.mm())).collect() })
    }

    /// Whether the table has no wear at any angle.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.entries.iter().all(|(_, deviation_mm)| deviation_mm.abs() <= 0.0)
    }

    /// Whether the cutter is farther out than the nominal corner anywhere.
    #[must_use]
    pub fn is_above_zero(&self) -> bool {
        self.entries.iter().any(|(_, deviation_mm)| *deviation_mm > 0.0)
    }

    /// δ at this contact angle; `None` beyond the last entry.
    #[must_use]
    pub fn deviation(&self, contact_angle: Angle) -> Option<Length> {
        let angle_rad = contact_angle.rad();
        let after = self.entries.partition_point(|(entry_rad, _)| *entry_rad <= angle_rad);
        let (from_rad, from_mm) = *self.entries.get(after.checked_sub(1)?)?;
        let deviation_mm = match self.entries.get(after) {
            Some((to_rad, to_mm)) => {
                from_mm + (to_mm - from_mm) * ((angle_rad - from_rad) / (to_rad - from_rad))
            }
            None if angle_rad - from_rad <= Self::ANGLE_SLACK_RAD => from_mm,
            None => return None,
        };
        Some(Length::from_mm(deviation_mm))
    }

    /// The shift that keeps an end-milling contact with this normal (out of the part, any length) and unit tool
    /// axis, both in W: `Δ = δ(ψ)·n − δ(0)·t − ΔL·t`. A constant δ is a ball of another radius. The tip is that of
    /// the worn cutter, with its own measured length in the control, except for ΔL.
    ///
    /// # Errors
    /// A normal without length, an undercut, a contact angle beyond the table.
    pub fn shift(&self, axis: Vec3, normal: Vec3, shorter_by: Length) -> Result<TipShift, ShiftFault> {
        let n = checked_normal(axis, normal)?;
        // A normal slightly beyond the flank counts as on it.
        let angle = Angle::from_rad(angle_between(n, axis).min(std::f64::consts::FRAC_PI_2));
        let (first_mm, last_rad) = (
            self.entries.first().map_or(0.0, |(_, deviation_mm)| *deviation_mm),
            self.entries.last().map_or(0.0, |(angle_rad, _)| *angle_rad),
        );
        let deviation = self.deviation(angle).ok_or(ShiftFault::BeyondTable {
            angle_deg: angle.deg(),
            max_deg: Angle::from_rad(last_rad).deg(),
        })?;
        let shift_mm = n * deviation.mm() - axis * first_mm + length_shift_mm(shorter_by, axis);
        Ok(TipShift { shift_mm, note: None })
    }
}
