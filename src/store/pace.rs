//! The speed at which stored data is read for checks.

use std::time::Duration;

use tokio_util::sync::CancellationToken;

use crate::meter;

/// Time between two checks of whether computations wait.
const LOOK: Duration = Duration::from_millis(100);

/// The speed of reading, and its end.
#[derive(Debug, Clone)]
pub struct Pace {
    /// Bytes per second; `None` for no limit.
    bytes_per_s: Option<f64>,
    stop: CancellationToken,
}

impl Pace {
    /// As fast as the disk, to the end: for a command.
    #[must_use]
    pub fn unbounded() -> Self {
        Self { bytes_per_s: None, stop: CancellationToken::new() }
    }

    /// At most this fast, not while computations wait, and no longer than `stop` allows.
    #[must_use]
    pub fn within(bytes_per_s: f64, stop: CancellationToken) -> Self {
        Self { bytes_per_s: Some(bytes_per_s.max(1.0)), stop }
    }

    /// Whether to stop.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.stop.is_cancelled()
    }

    /// Counts bytes that were read, and returns when more may be read.
    pub(super) async fn spend(&self, bytes: u64) {
        let Some(pause) = self.pause(bytes) else { return };
        tokio::select! {
            () = self.stop.cancelled() => {}
            () = async {
                tokio::time::sleep(pause).await;
                while meter::WAITING.get() > 0 {
                    tokio::time::sleep(LOOK).await;
                }
            } => {}
        }
    }

    /// The same on a thread that may block.
    pub fn spend_blocking(&self, bytes: u64) {
        let Some(mut pause) = self.pause(bytes) else { return };
        while !self.is_over() && (!pause.is_zero() || meter::WAITING.get() > 0) {
            let now = if pause.is_zero() { LOOK } else { pause.min(LOOK) };
            std::thread::sleep(now);
            pause = pause.saturating_sub(now);
        }
    }

    fn pause(&self, bytes: u64) -> Option<Duration> {
        self.bytes_per_s.map(|rate| Duration::from_secs_f64((bytes as f64 / rate).min(3600.0)))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    #[tokio::test]
    async fn reading_waits_as_long_as_its_rate_asks() {
        let pace = Pace::within(1e6, CancellationToken::new());
        let begun = Instant::now();
        pace.spend(50_000).await;
        assert!(begun.elapsed() >= Duration::from_millis(50), "{:?}", begun.elapsed());
        Pace::unbounded().spend(u64::MAX).await;
    }
}
