//! What is understood of a program, motion by motion.

mod interpret;

pub use interpret::{
    Interpretation, Interpreted, InterpretedArc, InterpretedKind, InterpretedMotion, interpret_program,
};
