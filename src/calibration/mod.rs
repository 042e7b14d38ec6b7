//! Where a machine's rotary axes really are: lines identified from measurements, and their values handed to the
//! control.
//!
//! Letters and signs: `math.md` §1 "Location errors"; cascaded values enter the profile, ISO 230-7 ones are absolute.

pub mod export;
mod lines;
pub mod rotary_sphere;

pub use lines::{CommonPerpendicular, rotation_vector_rad};
