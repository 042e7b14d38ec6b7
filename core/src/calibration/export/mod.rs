//! Calibrated axes as text for a control, based on public sources.
//!
//! [`neutral`]: ISO 230-7 symbols, cascaded values and lines, complete and at full precision. [`linuxcnc`] and
//! [`siemens`]: the values that those controls accept, as far as a public source defines their meaning. Values
//! without such a source are left out, and the text says so. Reading a text back gives the axes from which it was
//! made (`tests/oracles/control_export.rs`).

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
