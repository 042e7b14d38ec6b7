//! The interpretation of a program, motion by motion.

mod run;

pub use run::{
    Interpretation, Interpreted, InterpretedArc, InterpretedKind, InterpretedMotion, interpret_program,
};
