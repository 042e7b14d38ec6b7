//! R parameters and variables of the Sinumerik.

mod declaration;
mod elements;
mod expression;
mod functions;
mod operators;
mod variables;

pub(in crate::program) use expression::{
    MAX_DEPTH, Mistake, NoNames, Number, Walk, exponent_end, operand_name_end, with_exponent,
};
pub(in crate::program) use variables::Variables;
