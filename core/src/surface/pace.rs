//! The limit on a search on a mesh.

use std::ops::ControlFlow;

/// Counts the steps of searches on a mesh, and decides whether to continue.
///
/// A step is one look at a box, at a facet or at a point of a facet, and takes some ten nanoseconds. A malicious
/// file can make one search look at all its facets. Therefore every search for a client is counted.
pub trait Pace {
    /// Counts `steps` further steps. After it has broken once, it always breaks. A search that was broken off finds
    /// nothing.
    fn step(&mut self, steps: u64) -> ControlFlow<()>;
}

/// Continues without counting.
#[derive(Debug, Clone, Copy, Default)]
pub struct Uncounted;

impl Pace for Uncounted {
    fn step(&mut self, _steps: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
