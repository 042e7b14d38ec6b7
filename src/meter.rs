//! Counts of every layer: without locks, without names, in memory that does not grow. They belong to the
//! process; the reader gives them their names.

use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Memory of this process \[bytes\], if the system reports it.
#[must_use]
pub fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

/// A count that only grows.
#[derive(Debug, Default)]
pub struct Counter(AtomicU64);

impl Counter {
    /// A count of zero.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU64::new(0))
    }

    /// Adds to the count.
    pub fn add(&self, count: u64) {
        self.0.fetch_add(count, Ordering::Relaxed);
    }

    /// The count so far.
    #[must_use]
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// The present number of things.
#[derive(Debug, Default)]
pub struct Level(AtomicI64);

impl Level {
    /// A level of zero.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicI64::new(0))
    }

    /// One more, until the returned value is dropped.
    #[must_use]
    pub fn enter(&self) -> Entered<'_> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Entered(self)
    }

    /// The present number.
    #[must_use]
    pub fn get(&self) -> i64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// One of the things that a level counts.
#[derive(Debug)]
pub struct Entered<'a>(&'a Level);

impl Drop for Entered<'_> {
    fn drop(&mut self) {
        self.0.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Upper ends of the classes of a histogram of times \[s\]: from a read of a row to a program of gigabytes.
pub const CLASSES_S: [f64; 19] = [
    0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0,
    30.0, 60.0, 300.0,
];

/// Durations, counted by classes.
#[derive(Debug)]
pub struct Times {
    /// The last class is for everything longer than the others.
    classes: [AtomicU64; CLASSES_S.len() + 1],
    sum_ns: AtomicU64,
}

impl Default for Times {
    fn default() -> Self {
        Self::new()
    }
}

impl Times {
    /// No durations yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { classes: [const { AtomicU64::new(0) }; CLASSES_S.len() + 1], sum_ns: AtomicU64::new(0) }
    }

    /// Adds a duration.
    pub fn record(&self, elapsed: Duration) {
        let elapsed_s = elapsed.as_secs_f64();
        let class = CLASSES_S.iter().position(|end_s| elapsed_s <= *end_s).unwrap_or(CLASSES_S.len());
        if let Some(class) = self.classes.get(class) {
            class.fetch_add(1, Ordering::Relaxed);
        }
        self.sum_ns.fetch_add(u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    /// Adds the time that the returned value lives.
    #[must_use]
    pub fn begin(&self) -> Running<'_> {
        Running { times: self, began: Instant::now() }
    }

    /// The number in each class, the last for everything longer; and the sum \[s\].
    #[must_use]
    pub fn read(&self) -> ([u64; CLASSES_S.len() + 1], f64) {
        let counts =
            std::array::from_fn(|k| self.classes.get(k).map_or(0, |class| class.load(Ordering::Relaxed)));
        (counts, self.sum_ns.load(Ordering::Relaxed) as f64 * 1e-9)
    }
}

/// A duration that is being measured.
#[derive(Debug)]
pub struct Running<'a> {
    times: &'a Times,
    began: Instant,
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.times.record(self.began.elapsed());
    }
}

/// Poses turned into axis words and back.
pub static POSES: Counter = Counter::new();
/// Program blocks that were processed.
pub static PROGRAM_BLOCKS: Counter = Counter::new();
/// Bytes received over the network.
pub static BYTES_IN: Counter = Counter::new();
/// Bytes sent over the network.
pub static BYTES_OUT: Counter = Counter::new();
/// Open connections.
pub static CONNECTIONS: Level = Level::new();
/// Requests whose answer has not begun.
pub static IN_FLIGHT: Level = Level::new();
/// Computations that are running.
pub static COMPUTING: Level = Level::new();
/// Computations that are waiting for their turn.
pub static WAITING: Level = Level::new();
/// Attempts to deliver webhooks, by outcome.
pub static WEBHOOK_ATTEMPTS: [Counter; 7] = [const { Counter::new() }; 7];
/// Ends of posted jobs, in the order of `JobState::ENDS`.
pub static JOBS_ENDED: [Counter; 3] = [const { Counter::new() }; 3];
/// Reads of stored data that was found damaged.
pub static DAMAGED_FILES_MET: Counter = Counter::new();
/// Reads of the database.
pub static STORE_READS: Times = Times::new();
/// Write transactions, including the wait for the one writing connection.
pub static STORE_WRITES: Times = Times::new();

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_counts_in_the_first_class_that_holds_it() {
        let times = Times::new();
        for micros in [1, 100, 101, 1_000_000, 301_000_000] {
            times.record(Duration::from_micros(micros));
        }
        let (counts, sum_s) = times.read();
        assert_eq!(counts[0], 2);
        assert_eq!(counts[1], 1);
        assert_eq!(counts[12], 1);
        assert_eq!(counts[19], 1);
        assert_eq!(counts.iter().sum::<u64>(), 5);
        assert!((sum_s - 302.000_202).abs() < 1e-9);
    }

    #[test]
    fn a_level_falls_when_what_entered_goes() {
        let level = Level::new();
        let one = level.enter();
        let two = level.enter();
        assert_eq!(level.get(), 2);
        drop(one);
        assert_eq!(level.get(), 1);
        drop(two);
        assert_eq!(level.get(), 0);
    }
}
