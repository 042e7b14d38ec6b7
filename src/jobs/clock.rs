//! Time and ids come from outside, so that tests can set them.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};
use rustls::pki_types::UnixTime;
use rustls::time_provider::TimeProvider;
use uuid::{ContextV7, Uuid};

/// The source of the time.
pub trait Clock: Send + Sync + fmt::Debug {
    /// The present time.
    fn now(&self) -> Timestamp;

    /// The time for deciding what is too old: the present time, or an earlier time if the present time is doubtful.
    fn certain(&self) -> Timestamp {
        self.now()
    }

    /// The time that has passed with certainty; it may be later than the present time.
    fn passed(&self) -> Timestamp {
        Timestamp::MIN
    }

    /// For how long the clock that nobody sets has been watched.
    fn watched(&self) -> SignedDuration {
        SignedDuration::ZERO
    }

    /// At this moment the server of the database, whose clock counts for several services, said this time. A clock that
    /// is set by somebody else ignores it.
    fn hear(&self, _at: Instant, _time: Timestamp) {}
}

/// The source of new ids.
pub trait IdSource: Send + Sync + fmt::Debug {
    /// A new id that was never given before.
    fn next(&self) -> Uuid;
}

/// Clock and ids of one service.
#[derive(Debug, Clone)]
pub struct Sources {
    /// The source of the time.
    pub clock: Arc<dyn Clock>,
    /// The source of new ids.
    pub ids: Arc<dyn IdSource>,
}

/// The system's clock. Another clock, which nobody can set, measures the time since the start. So if the system's
/// clock is set ahead or back, for a moment or for good, nothing becomes older than it is. As soon as the server of the
/// database has said the time, that counts: several services have one clock, whatever their computers say.
#[derive(Debug)]
struct SystemClock(Mutex<Times>);

/// A time, and the moment at which it was the present one.
#[derive(Debug, Clone, Copy)]
struct Reading {
    at: Instant,
    time: Timestamp,
}

impl Reading {
    fn passed(&self) -> SignedDuration {
        SignedDuration::try_from(self.at.elapsed()).unwrap_or(SignedDuration::MAX)
    }

    fn now(&self) -> Timestamp {
        self.time.checked_add(self.passed()).unwrap_or(Timestamp::MAX)
    }
}

#[derive(Debug, Clone, Copy)]
struct Times {
    /// The first one of the clock that counts.
    began: Reading,
    /// The last one of the server.
    server: Option<Reading>,
}

/// Time-ordered ids (RFC 9562 §5.7). Their counter keeps the order within a millisecond.
#[derive(Debug, Default)]
struct Version7 {
    counter: Mutex<ContextV7>,
}

impl Version7 {
    /// The next id at this time. Version 7 counts from 1970: an earlier time counts as 1970.
    fn at(&self, now: Timestamp) -> Uuid {
        let now = now.max(Timestamp::UNIX_EPOCH);
        let (seconds, nanoseconds) = (now.as_second(), now.subsec_nanosecond());
        let seconds = u64::try_from(seconds).unwrap_or(0);
        let nanoseconds = u32::try_from(nanoseconds).unwrap_or(0);
        Uuid::new_v7(uuid::Timestamp::from_unix(&self.counter, seconds, nanoseconds))
    }
}

impl SystemClock {
    #[expect(clippy::disallowed_methods, reason = "this is the clock")]
    fn new() -> Self {
        let began = Reading { at: Instant::now(), time: Timestamp::now() };
        Self(Mutex::new(Times { began, server: None }))
    }

    fn times(&self) -> MutexGuard<'_, Times> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clock for SystemClock {
    #[expect(clippy::disallowed_methods, reason = "this is the clock")]
    fn now(&self) -> Timestamp {
        let server = self.times().server;
        server.map_or_else(Timestamp::now, |server| server.now())
    }

    fn certain(&self) -> Timestamp {
        self.passed().min(self.now())
    }

    fn passed(&self) -> Timestamp {
        let began = self.times().began;
        began.now()
    }

    fn watched(&self) -> SignedDuration {
        let began = self.times().began;
        began.passed()
    }

    fn hear(&self, at: Instant, time: Timestamp) {
        let (mut times, told) = (self.times(), Reading { at, time });
        if times.server.is_none() {
            times.began = told;
        }
        times.server = Some(told);
    }
}

/// The system's time, for output only: nothing may depend on it.
#[expect(clippy::disallowed_methods, reason = "this is the clock")]
#[must_use]
pub fn system_time() -> Timestamp {
    Timestamp::now()
}

/// The system's time for TLS, which counts from 1970. An earlier time counts as 1970, when no certificate is valid
/// yet.
#[derive(Debug, Clone, Copy)]
pub struct TlsTime;

impl TimeProvider for TlsTime {
    fn current_time(&self) -> Option<UnixTime> {
        Some(tls_time(system_time()))
    }
}

fn tls_time(now: Timestamp) -> UnixTime {
    UnixTime::since_unix_epoch(Duration::try_from(now.as_duration()).unwrap_or(Duration::ZERO))
}

impl IdSource for Version7 {
    #[expect(clippy::disallowed_methods, reason = "ids have the system's time in them")]
    fn next(&self) -> Uuid {
        self.at(Timestamp::now())
    }
}

impl Sources {
    /// The system's clock and time-ordered random ids.
    #[must_use]
    pub fn real() -> Self {
        Self { clock: Arc::new(SystemClock::new()), ids: Arc::new(Version7::default()) }
    }

    /// The present time in the stored form.
    #[must_use]
    pub fn timestamp(&self) -> String {
        timestamp(self.clock.now())
    }

    /// The time `seconds_s` ago in the stored form: older data may be removed.
    #[must_use]
    pub fn timestamp_before(&self, seconds_s: f64) -> String {
        let ago = SignedDuration::try_from_secs_f64(seconds_s).unwrap_or(SignedDuration::ZERO);
        timestamp(self.clock.certain().checked_sub(ago).unwrap_or(Timestamp::MIN))
    }

    /// The latest stored time that is possible for data with a lifetime of `seconds_s`: later data was stored while
    /// the clock was ahead. Until `seconds_s` have passed since the start this is the last time of all, because the
    /// clock may now be behind.
    #[must_use]
    pub fn farthest(&self, seconds_s: f64) -> String {
        if self.clock.watched().as_secs_f64() < seconds_s {
            return timestamp(LAST);
        }
        after(self.clock.now().max(self.clock.passed()), seconds_s)
    }

    /// The time `seconds_s` from now in the stored form.
    #[must_use]
    pub fn timestamp_after(&self, seconds_s: f64) -> String {
        after(self.clock.now(), seconds_s)
    }
}

/// The time `seconds_s` after `time` in the stored form.
#[must_use]
pub(super) fn after(time: Timestamp, seconds_s: f64) -> String {
    let ahead = SignedDuration::try_from_secs_f64(seconds_s).unwrap_or(SignedDuration::MAX);
    timestamp(time.checked_add(ahead).unwrap_or(LAST))
}

/// The last time whose text sorts after all others.
const LAST: Timestamp = Timestamp::constant(253_402_207_200, 0);

/// RFC 3339, UTC, always three decimals, so that stored times sort as text.
#[must_use]
pub fn timestamp(time: Timestamp) -> String {
    format!("{time:.3}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The present time, the time that has passed since the start, and for how long that is known.
    #[derive(Debug)]
    struct Told(Timestamp, Timestamp, SignedDuration);

    impl Clock for Told {
        fn now(&self) -> Timestamp {
            self.0
        }

        fn passed(&self) -> Timestamp {
            self.1
        }

        fn watched(&self) -> SignedDuration {
            self.2
        }
    }

    #[test]
    fn a_clock_before_1970_gives_ids_and_times() {
        let ids = Version7::default();
        let early = "1969-12-31T23:59:59.5Z".parse::<Timestamp>().expect("a time");
        let (first, second) = (ids.at(early), ids.at(Timestamp::MIN));
        assert_ne!(first, second);
        assert_eq!((first.get_version_num(), second.get_version_num()), (7, 7));
        assert_eq!(timestamp(early), "1969-12-31T23:59:59.500Z");
        assert_eq!(tls_time(early), UnixTime::since_unix_epoch(Duration::ZERO));
        let later = ids.at("2026-11-21T12:00:00Z".parse().expect("a time"));
        assert!(later > first && later > second);
    }

    #[test]
    fn the_clock_of_the_server_counts_as_soon_as_it_is_heard() {
        let (clock, year_s) = (SystemClock::new(), 365 * 86_400);
        let (wrong, at) = (clock.now(), Instant::now());
        let right = wrong.checked_sub(SignedDuration::from_secs(year_s)).expect("a time");
        clock.hear(at, right);
        for told in [clock.now(), clock.certain(), clock.passed()] {
            assert!(told >= right && told.duration_since(right) < SignedDuration::from_secs(60), "{told}");
        }
        // If the server's own clock jumps ahead, nothing becomes older than it is.
        clock.hear(Instant::now(), wrong);
        assert!(clock.now() >= wrong);
        assert!(clock.certain().duration_since(right) < SignedDuration::from_secs(60));
        // If it jumps back, what was stored meanwhile is no older either.
        clock.hear(Instant::now(), right);
        assert!(clock.certain().duration_since(right) < SignedDuration::from_secs(60));
    }

    #[test]
    fn ids_of_one_moment_are_in_order() {
        let (ids, now) = (Version7::default(), "2026-11-21T12:00:00Z".parse().expect("a time"));
        let made: Vec<_> = (0..1000).map(|_| ids.at(now)).collect();
        assert!(made.is_sorted_by(|one, other| one < other));
    }

    #[test]
    fn nothing_is_held_to_be_of_the_future_by_a_clock_that_may_be_behind() {
        let at = |text: &str| text.parse::<Timestamp>().expect("a time");
        let (early, late) = (at("1970-01-01T00:00:00Z"), at("2026-11-21T12:00:00Z"));
        let farthest = |now, passed, watched_s| {
            let clock = Arc::new(Told(now, passed, SignedDuration::from_secs(watched_s)));
            Sources { clock, ids: Arc::new(Version7::default()) }.farthest(60.0)
        };
        assert_eq!(farthest(early, early, 59), "9999-12-30T22:00:00.000Z");
        assert_eq!(farthest(late, late, 60), "2026-11-21T12:01:00.000Z");
        // The clock was set back, or the computer has just started without a battery.
        assert_eq!(farthest(early, late, 60), "2026-11-21T12:01:00.000Z");
        assert_eq!(farthest(late, early, 60), "2026-11-21T12:01:00.000Z");
    }
}
