//! Threads for the benchmarks that use several.

use trunnion::wear::SideBySide;

/// Every part but the first in a thread of its own.
pub struct Threads(pub usize);

impl SideBySide for Threads {
    fn parts(&self) -> usize {
        self.0
    }

    fn run<'a>(&self, parts: Vec<Box<dyn FnOnce() + Send + 'a>>) {
        std::thread::scope(|scope| {
            let mut parts = parts.into_iter();
            let own = parts.next();
            for part in parts {
                scope.spawn(part);
            }
            if let Some(part) = own {
                part();
            }
        });
    }
}
