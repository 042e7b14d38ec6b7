//! An interface to run parts of a computation side by side.

/// Runs independent parts of one computation, on threads or one after the other.
///
/// The core has no threads; a caller with threads implements this. Results never depend on the number of
/// parts.
pub trait SideBySide {
    /// Number of parts into which the work is worth dividing, at least 1.
    fn parts(&self) -> usize;

    /// Runs every part to its end before it returns.
    fn run<'a>(&self, parts: Vec<Box<dyn FnOnce() + Send + 'a>>);
}

/// Runs one part after the other, in the caller's thread.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OneAfterAnother;

impl SideBySide for OneAfterAnother {
    fn parts(&self) -> usize {
        1
    }

    fn run<'a>(&self, parts: Vec<Box<dyn FnOnce() + Send + 'a>>) {
        for part in parts {
            part();
        }
    }
}
