//! How long a search on a mesh may go on.

use std::ops::ControlFlow;

/// Counts the steps of searches on a mesh, and says whether to go on.
///
/// A step is one look at a box, at a facet or at a place on a facet, and takes some ten nanoseconds. A file can be made so that one
/// search looks at all its facets. Whoever searches for a client therefore counts.
pub trait Pace {
    /// Counts `steps` steps more. Once it breaks it always breaks. A search that was broken off finds nothing.
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
