//! The blocks of a program in the order in which a control runs them: loops and jumps are followed, and calls enter
//! the subprograms that are in the same text or in a file beside it.
//!
//! A condition whose value is not known ends the run with its statement, which refuses the program. A call of a
//! program that is in no file is an ordinary block, after which nothing is known.

mod calls;
mod files;
mod places;
mod refused;
mod run;

pub use files::SubprogramFile;
pub(crate) use files::without_folders;
pub use run::ProgramRun;
