//! Figures as SVG text: one file per figure.

mod deviation_along_path;

pub use deviation_along_path::{DeviationFigure, DeviationPoint, deviation_along_path};

use thiserror::Error;

/// A figure could not be drawn: a defect of this software, never of the figure's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the figure could not be drawn")]
pub struct PlotFault;
