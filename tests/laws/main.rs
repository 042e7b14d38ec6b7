//! Laws: what must hold for every machine and every input.
#![expect(clippy::unwrap_used, reason = "a law that cannot be set up has failed")]

mod inverse;
mod machines;
mod path;
