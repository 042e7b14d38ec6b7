//! A cutter that machines a surface pass by pass: scallop height with any tool (R, r), by its effective radius.

use thiserror::Error;

use super::{
    LeadFault, ScallopFault, Surface, cutter_radius, effective_radius, largest_stepover, scallop_height,
    smallest_tool_radius,
};
use crate::machine::Tool;
use crate::units::{Angle, Length, legible};

/// A cutter on a surface, inclined in the feed direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterPass {
    /// The cutter (R, r).
    pub tool: Tool,
    /// Lead angle between the tool axis and the surface normal, in the feed direction; ignored for a ball.
    pub lead: Angle,
    /// The surface across the feed.
    pub surface: Surface,
}

/// Why the scallop of a cutter's passes cannot be computed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PassFault {
    /// The lead angle.
    #[error(transparent)]
    Lead(#[from] LeadFault),
    /// The numbers of the scallop.
    #[error(transparent)]
    Scallop(#[from] ScallopFault),
    /// The step-over is wider than the cutter, although its effective radius would allow it.
    #[error("a step-over of {} mm is wider than the cutter; the limit is {} mm", legible(.stepover_mm), legible(.diameter_mm))]
    WiderThanCutter {
        /// D \[mm\].
        stepover_mm: f64,
        /// 2 R \[mm\].
        diameter_mm: f64,
    },
}

impl CutterPass {
    /// Effective radius of the cutter across the feed.
    ///
    /// # Errors
    /// A lead angle not in [0.001, 90]° for a cutter that is not a ball.
    pub fn effective_radius(&self) -> Result<Length, LeadFault> {
        effective_radius(&self.tool, self.lead)
    }

    /// Scallop height at this step-over; see [`scallop_height`].
    ///
    /// # Errors
    /// The faults of [`scallop_height`] and [`effective_radius`], and a step-over above 2 R.
    pub fn height(&self, stepover: Length) -> Result<Length, PassFault> {
        let diameter_mm = self.diameter_mm();
        let height = scallop_height(stepover, self.effective_radius()?, self.surface)?;
        if stepover.mm() > diameter_mm && !self.tool.is_ball() {
            return Err(PassFault::WiderThanCutter { stepover_mm: stepover.mm(), diameter_mm });
        }
        Ok(height)
    }

    /// The largest step-over that leaves at most `height`, never above 2 R for a cutter with a flat end.
    ///
    /// # Errors
    /// The faults of [`largest_stepover`] and [`effective_radius`].
    pub fn largest_stepover(&self, height: Length) -> Result<Length, PassFault> {
        let largest = largest_stepover(height, self.effective_radius()?, self.surface)?;
        if self.tool.is_ball() {
            return Ok(largest);
        }
        Ok(Length::from_mm(largest.mm().min(self.diameter_mm())))
    }

    /// The smallest cutter radius R that leaves at most `height` at this step-over, with the same corner radius and
    /// lead angle (a ball stays a ball). `None` if no cutter does.
    ///
    /// # Errors
    /// The faults of [`smallest_tool_radius`] and [`cutter_radius`].
    pub fn smallest_cutter(&self, height: Length, stepover: Length) -> Result<Option<Length>, PassFault> {
        let Some(effective) = smallest_tool_radius(height, stepover, self.surface)? else { return Ok(None) };
        if self.tool.is_ball() {
            return Ok(Some(effective));
        }
        let radius = cutter_radius(effective, self.tool.corner_radius(), self.lead)?;
        Ok(Some(Length::from_mm(radius.mm().max(0.5 * stepover.mm()))))
    }

    fn diameter_mm(&self) -> f64 {
        2.0 * self.tool.radius().mm()
    }
}
