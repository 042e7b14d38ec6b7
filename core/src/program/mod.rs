//! NC program text as written, and nothing more. Chunks of bytes go in, and batches of blocks come out. Every byte of
//! the upload is in exactly one block, so that untouched blocks are printed as they were.
//!
//! This module knows no machine, and it reads and writes no files. `motion` gives the text its meaning.

mod address;
mod batch;
mod code;
mod comment;
mod constants;
mod course;
mod decimal;
mod diagnostic;
mod dialect;
mod eight_digits;
mod fault;
mod flow;
mod keyword;
mod line;
mod number;
mod own_names;
mod plane;
mod reader;
mod short_decimal;
mod stamp;
mod word;
mod writer;

pub use address::Address;
pub use batch::{Batch, Block, BlockFlags, BlockKind, PlaceInFile};
pub use code::Code;
pub use constants::Constants;
pub use decimal::{MAX_DECIMALS, print_decimal, round_to_decimals};
pub use diagnostic::{ByteSpan, CalledLine, Diagnostic, DiagnosticCode, Diagnostics, Excerpt, Severity};
pub use dialect::{CycleUnread, Dialect, DialectRules, ForeignDialect, Grammar, WritingOut};
pub use eight_digits::eight_digits;
pub use fault::{ReadFault, WriteFault};
pub(crate) use flow::without_folders;
pub use flow::{ProgramRun, SubprogramFile};
pub use keyword::Keyword;
pub use number::{MAX_MAGNITUDE, POWERS_OF_TEN};
pub use own_names::OwnNames;
pub use plane::{FreeAxisWord, PlaneDirections, PlaneStatement, PlaneTurning, StatedSide};
pub use reader::{ReadLimits, Reader};
pub use stamp::{Borne, Stamp, StampFinder, StampPlace, StepName, Steps, borne_by, place_stamp};
pub use word::{Word, WordForm};
pub use writer::{
    NewWord, print_changed, print_changed_without, print_feed_only, print_inserted, print_inserted_without,
};
