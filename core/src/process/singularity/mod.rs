//! Singular regions of a whole program: stretches where a rotary axis turns far for a small turn of the tool. They are
//! reported, divided, or passed with less rotary travel; what is written is read back.

mod and_compensate;
mod contact;
mod densify;
mod figures;
mod find;
mod measured;
mod parameters;
mod pending;
mod plan;
mod regions;
mod report;
mod run;
mod smooth;
mod taut_string;
mod verify;
mod words;

pub use and_compensate::treat_and_compensate;
pub use parameters::{SingularityAction, SingularityParameters};
pub use report::{
    LeftReason, RegionFigures, RegionTreatment, RegionsLeft, SingularRegion, SingularityReport,
};
pub use run::treat_singular_regions;

pub(super) use find::{RegionFinder, RegionSearch};
pub(super) use run::treat_from;
