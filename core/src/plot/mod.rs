//! Figures as SVG text, one file each. `svg` writes the elements, `axis` places values, `chart` has the parts that
//! figures have in common.

mod axis;
mod calibration_trend;
mod chart;
mod contour_error;
mod deviation_along_path;
mod eccentricity_bars;
mod following_error;
mod polar_contour;
mod residual_map;
mod scallop;
mod svg;
mod sweep;
mod wear_trend;

pub use axis::plain;
pub use calibration_trend::{TrendFigure, TrendMark, calibration_trend};
pub use contour_error::{ContourFigure, ContourPoint, contour_error_along};
pub use deviation_along_path::{ALONG_CONTACT_PATH, DeviationFigure, DeviationPoint, deviation_along_path};
pub use eccentricity_bars::{EccentricityBars, EccentricityFigure, eccentricity_bars};
pub use following_error::{FollowingErrorCurve, FollowingErrorFigure, following_error_over_time};
pub use polar_contour::{PolarCurve, PolarFigure, polar_contour};
pub use residual_map::{ResidualFigure, ResidualSample, residual_map};
pub use scallop::{ScallopCurve, ScallopFigure, scallop_heights};
pub use sweep::{SweepFigure, sweep_curves, sweep_map};
pub use wear_trend::{WearBand, WearEdgeCurve, WearEnd, WearTrendFigure, wear_trend};
