//! Time and identity come from outside, so that tests can set them.

use std::fmt;
use std::sync::Arc;
use std::time::Instant;

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

/// Where the time comes from.
pub trait Clock: Send + Sync + fmt::Debug {
    /// Now.
    fn now(&self) -> Timestamp;

    /// The time by which things are forgotten: now, or an earlier time where now is doubtful.
    fn certain(&self) -> Timestamp {
        self.now()
    }

    /// The time that is doubtlessly over, where that may be later than now.
    fn passed(&self) -> Timestamp {
        Timestamp::MIN
    }
}

/// Where new ids come from.
pub trait IdSource: Send + Sync + fmt::Debug {
    /// An id never given before.
    fn next(&self) -> Uuid;
}

/// Clock and ids of one service.
#[derive(Debug, Clone)]
pub struct Sources {
    /// Where the time comes from.
    pub clock: Arc<dyn Clock>,
    /// Where new ids come from.
    pub ids: Arc<dyn IdSource>,
}

/// The system's clock. What has really passed since the start is known of another one that nobody sets, so that a clock
/// that is set ahead or back, for a moment or for good, makes nothing older than it is.
#[derive(Debug)]
struct SystemClock {
    began: (Instant, Timestamp),
}

#[derive(Debug)]
struct Version7;

impl SystemClock {
    #[expect(clippy::disallowed_methods, reason = "this is the clock")]
    fn new() -> Self {
        Self { began: (Instant::now(), Timestamp::now()) }
    }
}

impl Clock for SystemClock {
    #[expect(clippy::disallowed_methods, reason = "this is the clock")]
    fn now(&self) -> Timestamp {
        Timestamp::now()
    }

    fn certain(&self) -> Timestamp {
        self.passed().min(self.now())
    }

    fn passed(&self) -> Timestamp {
        let (instant, at) = self.began;
        let passed = SignedDuration::try_from(instant.elapsed()).unwrap_or(SignedDuration::MAX);
        at.checked_add(passed).unwrap_or(Timestamp::MAX)
    }
}

impl IdSource for Version7 {
    #[expect(clippy::disallowed_methods, reason = "this is the id source")]
    fn next(&self) -> Uuid {
        Uuid::now_v7()
    }
}

impl Sources {
    /// The system's clock and time-ordered random ids.
    #[must_use]
    pub fn real() -> Self {
        Self { clock: Arc::new(SystemClock::new()), ids: Arc::new(Version7) }
    }

    /// The time now, as it is stored and answered.
    #[must_use]
    pub fn timestamp(&self) -> String {
        timestamp(self.clock.now())
    }

    /// The time `seconds_s` ago, as it is stored: what is older may be forgotten.
    #[must_use]
    pub fn timestamp_before(&self, seconds_s: f64) -> String {
        let ago = SignedDuration::try_from_secs_f64(seconds_s).unwrap_or(SignedDuration::ZERO);
        timestamp(self.clock.certain().checked_sub(ago).unwrap_or(Timestamp::MIN))
    }

    /// The time `seconds_s` from now, as it is stored.
    #[must_use]
    pub fn timestamp_after(&self, seconds_s: f64) -> String {
        after(self.clock.now(), seconds_s)
    }
}

/// The time `seconds_s` after `time`, as it is stored.
#[must_use]
pub(super) fn after(time: Timestamp, seconds_s: f64) -> String {
    let ahead = SignedDuration::try_from_secs_f64(seconds_s).unwrap_or(SignedDuration::MAX);
    timestamp(time.checked_add(ahead).unwrap_or(LAST))
}

/// The last time whose text sorts behind all others.
const LAST: Timestamp = Timestamp::constant(253_402_207_200, 0);

/// RFC 3339, UTC, always three decimals, so that stored times sort as text.
#[must_use]
pub fn timestamp(time: Timestamp) -> String {
    format!("{time:.3}")
}
