//! The parameters of the treatment of singular regions.

use crate::units::Angle;

/// The treatment of singular regions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SingularityAction {
    /// Regions are listed; nothing changes.
    #[default]
    Report,
    /// The motions of a region are divided until they keep three limits. The tool axis keeps to the great circle, and
    /// the contact to its line. No rotary axis turns by more than a limit within a block.
    Densify,
    /// The rotary words of the points inside a region are replaced by words that need less rotary travel. The tool
    /// axis stays within a tolerance of the programmed one.
    Smooth,
}

impl SingularityAction {
    /// The name in the contract.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Densify => "densify",
            Self::Smooth => "smooth",
        }
    }
}

/// The parameters of the treatment of singular regions. Tool, contact and tolerance are those of the compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularityParameters {
    /// The treatment.
    pub action: SingularityAction,
    /// A motion is singular if the tool axis may turn by less than the sine of this angle while the rotary axes turn
    /// by 1. With orthogonal axes, the motion is then within this angle of the pole.
    pub zone: Angle,
    /// The largest angle of the tool axis from the programmed one at a point (`smooth`), and from the great circle
    /// between the block's ends (`densify`).
    pub axis_tolerance: Angle,
    /// The largest turn of a rotary axis in a block that `densify` writes.
    pub max_step: Angle,
    /// The largest speed of a rotary axis \[deg/s\]. Motions that need more are counted.
    pub max_rotary_deg_per_s: f64,
}

impl SingularityParameters {
    /// Three degrees: rotary axes turn up to 19 times as fast as the tool there. Finishing passes with less lead than
    /// this are the ones with problems.
    pub const ZONE_DEG: f64 = 3.0;
    /// 0.05°: a ball of 5 mm radius then touches at a point 4 µm away. That is within half of the usual tolerance of
    /// 10 µm. The three decimals of a postprocessor use up less than 0.001° of it.
    pub const AXIS_TOLERANCE_DEG: f64 = 0.05;
    /// Five degrees: at 100 mm from the axis a block bows by 95 µm before its ends are corrected. A few parts correct
    /// this.
    pub const MAX_STEP_DEG: f64 = 5.0;
    /// 20 turns a minute: the speed of a small machine's table with a worm gear.
    pub const MAX_ROTARY_DEG_PER_S: f64 = 120.0;
    /// Accepted ranges: zone, axis tolerance and step \[deg\], speed \[deg/s\].
    pub const ZONE_RANGE_DEG: [f64; 2] = [0.01, 30.0];
    /// See [`Self::ZONE_RANGE_DEG`].
    pub const AXIS_TOLERANCE_RANGE_DEG: [f64; 2] = [1e-4, 5.0];
    /// See [`Self::ZONE_RANGE_DEG`].
    pub const MAX_STEP_RANGE_DEG: [f64; 2] = [0.1, 180.0];
    /// See [`Self::ZONE_RANGE_DEG`].
    pub const MAX_ROTARY_RANGE_DEG_PER_S: [f64; 2] = [0.01, 1e5];

    /// The defaults of the contract.
    #[must_use]
    pub fn new(action: SingularityAction) -> Self {
        Self {
            action,
            zone: Angle::from_deg(Self::ZONE_DEG),
            axis_tolerance: Angle::from_deg(Self::AXIS_TOLERANCE_DEG),
            max_step: Angle::from_deg(Self::MAX_STEP_DEG),
            max_rotary_deg_per_s: Self::MAX_ROTARY_DEG_PER_S,
        }
    }
}
