//! The `trunnion` binary.
fn main() {}
