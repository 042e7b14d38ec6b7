//! A bar that shows how far a long computation has come. Only a terminal gets one: in a file or a pipe it would be in
//! the way.

use std::io::{IsTerminal, Write, stderr};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use crate::jobs::Progress;

/// A computation that ends sooner has no bar.
const SHOWN_AFTER: Duration = Duration::from_secs(1);
/// Time between two pictures of the bar.
const EVERY: Duration = Duration::from_millis(200);
/// Length of the bar in characters; with its numbers it fits into half of the narrowest terminal.
const LENGTH: usize = 24;
/// Removes the line of the bar.
const REMOVED: &str = "\r\x1b[K";

/// The bar of one computation; it goes when this is dropped.
#[derive(Debug)]
pub(super) struct Bar(Option<(Sender<()>, JoinHandle<()>)>);

impl Bar {
    /// Shows this progress, if standard error is a terminal.
    pub(super) fn of(progress: Progress) -> Self {
        if !stderr().is_terminal() {
            return Self(None);
        }
        let (end, ended) = channel();
        let draw = move || drawn(&mut stderr(), &ended, SHOWN_AFTER, EVERY, || progress.share());
        // Without this thread there is only no bar.
        Self(Builder::new().name("progress".to_owned()).spawn(draw).ok().map(|thread| (end, thread)))
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some((end, thread)) = self.0.take() {
            drop(end);
            let _drawn = thread.join();
        }
    }
}

/// Draws the bar until its other end is dropped.
fn drawn(
    out: &mut impl Write,
    ended: &Receiver<()>,
    first: Duration,
    every: Duration,
    share: impl Fn() -> f64,
) {
    let began = Instant::now();
    let (mut pause, mut is_shown) = (first, false);
    while ended.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
        // A terminal that has gone needs no bar.
        let _shown = write!(out, "\r{}", line(share(), began.elapsed())).and_then(|()| out.flush());
        (pause, is_shown) = (every, true);
    }
    if is_shown {
        let _removed = write!(out, "{REMOVED}").and_then(|()| out.flush());
    }
}

fn line(share: f64, elapsed: Duration) -> String {
    let share = share.clamp(0.0, 1.0);
    let filled = (0..LENGTH).filter(|place| (*place as f64 + 0.5) < share * LENGTH as f64).count();
    let bar = "#".repeat(filled) + &".".repeat(LENGTH - filled);
    format!("[{bar}] {:3.0} %  {} s", (share * 100.0).floor(), elapsed.as_secs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_one_length_and_fills_up() {
        let at = |share: f64| line(share, Duration::from_secs(7));
        assert_eq!(at(0.0), format!("[{}]   0 %  7 s", ".".repeat(LENGTH)));
        assert_eq!(at(0.5), format!("[{}{}]  50 %  7 s", "#".repeat(12), ".".repeat(12)));
        assert_eq!(at(2.0), format!("[{}] 100 %  7 s", "#".repeat(LENGTH)));
        assert!(at(0.999).contains(" 99 %"), "{}", at(0.999));
    }

    #[test]
    fn a_short_computation_has_no_bar_and_a_long_one_leaves_none() {
        let mut out = Vec::new();
        let (end, ended) = channel::<()>();
        drop(end);
        drawn(&mut out, &ended, SHOWN_AFTER, EVERY, || 0.5);
        assert_eq!(out, b"");
        let (end, ended) = channel::<()>();
        let mut end = Some(end);
        let shares = std::cell::Cell::new(0);
        let share = || {
            shares.set(shares.get() + 1);
            f64::from(shares.get()) / 4.0
        };
        std::thread::scope(|scope| {
            let end = end.take();
            scope.spawn(move || {
                std::thread::park_timeout(Duration::from_millis(40));
                drop(end);
            });
            drawn(&mut out, &ended, Duration::ZERO, Duration::from_millis(1), share);
        });
        let text = String::from_utf8(out).unwrap();
        assert!(text.starts_with("\r[######..") && text.ends_with(REMOVED), "{text:?}");
    }
}
