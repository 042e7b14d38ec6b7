//! Laws: sentences that hold for every machine and every program.

mod inverse;
mod machines;
mod program;
