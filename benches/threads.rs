//! Threads for the benchmarks that use several.

use std::sync::{Mutex, PoisonError};

use trunnion::side_by_side::SideBySide;

/// So many threads, the caller's own among them; each takes the next part when it is done with one.
pub(crate) struct Threads(pub(crate) usize);

impl SideBySide for Threads {
    fn parts(&self) -> usize {
        self.0
    }

    fn run<'a>(&self, parts: Vec<Box<dyn FnOnce() + Send + 'a>>) {
        let helpers = self.0.min(parts.len()).saturating_sub(1);
        let waiting = Mutex::new(parts.into_iter());
        let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || {
            while let Some(part) = next() {
                part();
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..helpers {
                scope.spawn(work);
            }
            work();
        });
    }
}
