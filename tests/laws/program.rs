//! Laws of reading and writing programs.
