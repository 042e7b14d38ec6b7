//! How long a search on a mesh may go on.

use std::ops::ControlFlow;

/// Counts the steps of searches on a mesh, and says whether to go on.
///
/// A step is one look at a box, at a facet or at a place on a facet: some ten nanoseconds. Facets made for it can make one search
/// look at all of them, so whoever searches for somebody else counts.
pub trait Pace {
    /// Counts so many steps more. What breaks once does not go on again; a search that was broken off finds nothing.
    fn step(&mut self, steps: u64) -> ControlFlow<()>;
}

/// Goes on without counting.
#[derive(Debug, Clone, Copy, Default)]
pub struct Uncounted;

impl Pace for Uncounted {
    fn step(&mut self, _steps: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
