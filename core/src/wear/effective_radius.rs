//! The effective radius of an inclined cutter across the feed.

use thiserror::Error;

use crate::geometry::trig;
use crate::machine::Tool;
use crate::units::{Angle, Length, legible};

/// Why there is no effective radius.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LeadFault {
    /// The cutter lies on its flat, or is inclined beyond its flank.
    #[error("the lead angle of {}° is not between {min_deg}° and {max_deg}°", legible(.lead_deg))]
    OutOfRange {
        /// The angle asked for \[deg\].
        lead_deg: f64,
        /// Smallest angle accepted \[deg\].
        min_deg: f64,
        /// Largest accepted \[deg\].
        max_deg: f64,
    },
}

/// Smallest and largest lead angle \[deg\]. At smaller angles the effective radius of a cutter of a metre is larger
/// than any surface.
pub const LEAD_RANGE_DEG: [f64; 2] = [1e-3, 90.0];

/// Effective radius across the feed of a cutter (R, r) inclined by `lead` in the feed direction:
/// `r + (R − r)/sin(lead)` (§4). For a ball it is its own radius at any angle.
///
/// # Errors
/// A lead angle not in [0.001, 90]°, for any cutter that is not a ball.
pub fn effective_radius(tool: &Tool, lead: Angle) -> Result<Length, LeadFault> {
    if tool.is_ball() {
        return Ok(tool.radius());
    }
    check_lead(lead)?;
    let (sine, _) = trig::sin_cos(lead.rad());
    Ok(Length::from_mm(tool.corner_radius().mm() + tool.core_radius().mm() / sine))
}

/// The cutter radius R with this effective radius, for the corner radius `corner_radius` at `lead`: the inverse of
/// [`effective_radius`]. It is never below the corner radius, at which the cutter is a ball.
///
/// # Errors
/// A lead angle not in [0.001, 90]°.
pub fn cutter_radius(effective: Length, corner_radius: Length, lead: Angle) -> Result<Length, LeadFault> {
    check_lead(lead)?;
    let (sine, _) = trig::sin_cos(lead.rad());
    let core_mm = (effective - corner_radius).mm() * sine;
    Ok(Length::from_mm(corner_radius.mm() + core_mm.max(0.0)))
}

fn check_lead(lead: Angle) -> Result<(), LeadFault> {
    let [min_deg, max_deg] = LEAD_RANGE_DEG;
    let lead_deg = lead.deg();
    // NaN is in no range.
    if (min_deg..=max_deg).contains(&lead_deg) {
        return Ok(());
    }
    Err(LeadFault::OutOfRange { lead_deg, min_deg, max_deg })
}
