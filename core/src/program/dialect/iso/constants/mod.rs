//! `#` parameters of RS274/NGC and Fanuc controls: `#1`, `##1`, `#[#1+1]`, `#<name>`, `#<_global>`.
//!
//! A parameter is known from where the program sets it to a known value. Parameters from 1000 on, `#<_x>` and their
//! kin belong to the control and are never known. A block that the operator may skip, and a condition that is not
//! known, make what they assign unknown; a call makes everything unknown that what is called can reach.

mod assignment;
#[expect(clippy::float_cmp, reason = "truths and whole numbers are compared exactly, as controls do")]
mod expression;
mod parameters;

pub(in crate::program) use parameters::Parameters;
use parameters::{Name, Target};

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values as they are written, exact")]
mod tests;
