//! Laws, held for inputs that nobody chose.

mod program;
