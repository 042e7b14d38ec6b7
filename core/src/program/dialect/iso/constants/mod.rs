//! `#` parameters of RS274/NGC and Fanuc controls: `#1`, `##1`, `#[#1+1]`, `#<name>`, `#<_global>`.
//!
//! A parameter is known after the program sets it to a known value. Parameters from 1000 on, `#<_x>` and similar
//! parameters belong to the control and are never known. If the operator may skip a block, or a condition is not
//! known, the parameters that it assigns become unknown. A call makes every parameter unknown that the called program
//! can reach.

mod assignment;
#[expect(clippy::float_cmp, reason = "truths and whole numbers are compared exactly, as controls do")]
mod expression;
mod parameters;

pub(in crate::program) use parameters::Parameters;
use parameters::{Name, Target};

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values as they are written, exact")]
mod tests;
