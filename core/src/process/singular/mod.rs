//! Singular regions of a whole program: stretches in which a rotary axis turns far for a small turn of the tool. They
//! are reported, divided, or passed with less rotary travel. The written text is read back.

mod check;
mod collector;
mod contact;
mod densify;
mod figures;
mod find;
mod measured;
mod parameters;
mod pending;
mod planner;
mod regions;
mod report;
mod smooth;
mod step;
mod taut_string;
mod words;
mod work;

pub use parameters::{SingularityAction, SingularityParameters};
pub use report::{
    LeftReason, RegionFigures, RegionTreatment, RegionsLeft, SingularRegion, SingularityReport,
};
pub use step::treat_singular_regions;

pub(in crate::process) use find::RegionSearch;
pub(in crate::process) use step::SingularStep;
