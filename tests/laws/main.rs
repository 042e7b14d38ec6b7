//! Laws: what must hold for every machine and every input.

mod inverse;
mod machines;
mod path;
