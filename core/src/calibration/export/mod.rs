//! Calibrated axes as text for a control, from sources that anyone can read.
//!
//! [`neutral`]: ISO 230-7 symbols, cascaded values and lines, complete and at full precision. [`linuxcnc`] and
//! [`siemens`]: what those controls take, as far as a public source fixes what a value means; what none fixes is left
//! out, and the text says so. Read back, each text gives the axes it was made from (`tests/oracles/control_export.rs`).

mod linuxcnc;
mod linuxcnc_modules;
mod neutral;
mod remaining;
mod siemens;
mod text;

pub use linuxcnc::{LinuxCncExport, LinuxCncFault, linuxcnc};
pub use linuxcnc_modules::LinuxCncModule;
pub use neutral::neutral;
pub use remaining::RemainingError;
pub use siemens::{SiemensForm, siemens};
