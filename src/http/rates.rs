//! The rate of one caller's requests: each caller has a bucket that fills at a steady rate. It needs one number of
//! memory for each caller, and the number of callers is limited.

use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

pub(super) use crate::shares::Who;

/// Parts of the table, so that callers rarely wait for each other.
const SHARDS: usize = 16;
/// Callers remembered in each part.
const PER_SHARD: usize = 4096;
/// Pause between two searches for callers that can be removed.
const SWEEP_PAUSE_NS: u64 = 100_000_000;

/// The table. For each caller it holds the time at which the bucket is full again.
#[derive(Debug)]
pub(super) struct Rates {
    shards: [Mutex<Shard>; SHARDS],
    hasher: RandomState,
    began: Instant,
    /// Time in which the bucket regains one request \[ns\].
    interval_ns: u64,
    /// How far ahead of now the time of the full bucket may be, so that one more request is admitted \[ns\].
    ahead_ns: u64,
}

#[derive(Debug, Default)]
struct Shard {
    full_at_ns: HashMap<Who, u64>,
    swept_ns: u64,
}

impl Rates {
    /// This many requests per second, and this many at once after a pause; `None` if the rate is zero.
    pub(super) fn new(rate_per_s: f64, burst: u32) -> Option<Self> {
        if rate_per_s <= 0.0 {
            return None;
        }
        let interval_ns =
            u64::try_from(Duration::from_secs_f64(1.0 / rate_per_s).as_nanos()).unwrap_or(u64::MAX);
        let interval_ns = interval_ns.max(1);
        Some(Self {
            shards: std::array::from_fn(|_| Mutex::default()),
            hasher: RandomState::new(),
            began: Instant::now(),
            interval_ns,
            ahead_ns: interval_ns.saturating_mul(u64::from(burst.max(1)) - 1),
        })
    }

    /// Admits one request.
    ///
    /// # Errors
    /// The bucket is empty; the time is the wait until there is room for one request.
    pub(super) fn admit(&self, who: Who) -> Result<(), Duration> {
        let now_ns = u64::try_from(self.began.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.admit_at(who, now_ns).map_err(Duration::from_nanos)
    }

    fn admit_at(&self, who: Who, now_ns: u64) -> Result<(), u64> {
        let place = usize::try_from(self.hasher.hash_one(&who) % SHARDS as u64).unwrap_or(0);
        let Some(shard) = self.shards.get(place) else { return Ok(()) };
        // The held data is consistent at every moment, even after a panic.
        let mut shard = shard.lock().unwrap_or_else(PoisonError::into_inner);
        let who = shard.place_for(who, now_ns);
        let full_at_ns = shard.full_at_ns.get(&who).copied().unwrap_or(0).max(now_ns);
        let early_ns = (full_at_ns - now_ns).saturating_sub(self.ahead_ns);
        if early_ns > 0 {
            return Err(early_ns);
        }
        shard.full_at_ns.insert(who, full_at_ns.saturating_add(self.interval_ns));
        Ok(())
    }
}

impl Shard {
    /// The caller's entry, or the common entry of the callers that come while the table is full of active callers.
    fn place_for(&mut self, who: Who, now_ns: u64) -> Who {
        if self.full_at_ns.len() < PER_SHARD || self.full_at_ns.contains_key(&who) {
            return who;
        }
        if now_ns.saturating_sub(self.swept_ns) >= SWEEP_PAUSE_NS {
            self.swept_ns = now_ns;
            self.full_at_ns.retain(|_, full_at_ns| *full_at_ns > now_ns);
        }
        if self.full_at_ns.len() < PER_SHARD { who } else { Who::Others }
    }
}

#[cfg(test)]
mod tests {
    use std::net::IpAddr;

    use super::*;

    const SECOND_NS: u64 = 1_000_000_000;

    fn peer(last: u8) -> Who {
        Who::at(IpAddr::from([10, 0, 0, last]))
    }

    #[test]
    fn a_burst_is_let_in_and_then_the_rate() {
        let rates = Rates::new(10.0, 3).unwrap();
        for _ in 0..3 {
            assert_eq!(rates.admit_at(peer(1), 0), Ok(()));
        }
        // The fourth waits for one place, and what is refused does not make the wait longer.
        assert_eq!(rates.admit_at(peer(1), 0), Err(SECOND_NS / 10));
        assert_eq!(rates.admit_at(peer(1), 0), Err(SECOND_NS / 10));
        assert_eq!(rates.admit_at(peer(1), SECOND_NS / 10 - 1), Err(1));
        assert_eq!(rates.admit_at(peer(1), SECOND_NS / 10), Ok(()));
        assert!(rates.admit_at(peer(1), SECOND_NS / 10).is_err());
        // Another one is not concerned, and after a rest there is the whole burst again.
        assert_eq!(rates.admit_at(peer(2), 0), Ok(()));
        for _ in 0..3 {
            assert_eq!(rates.admit_at(peer(1), 5 * SECOND_NS), Ok(()));
        }
        assert!(rates.admit_at(peer(1), 5 * SECOND_NS).is_err());
    }

    #[test]
    fn over_a_long_time_the_rate_is_kept_exactly() {
        let rates = Rates::new(1000.0, 1).unwrap();
        let let_in = (0..100_000_u64).filter(|k| rates.admit_at(peer(1), k * 100_000).is_ok()).count();
        assert_eq!(let_in, 10_000);
    }

    #[test]
    fn the_table_does_not_grow_past_its_size() {
        let rates = Rates::new(0.001, 1).unwrap();
        let mut refused = 0;
        for address in 0..200_000_u32 {
            refused += usize::from(rates.admit_at(Who::at(IpAddr::from(address.to_be_bytes())), 0).is_err());
        }
        let held: usize = rates.shards.iter().map(|shard| shard.lock().unwrap().full_at_ns.len()).sum();
        assert!(held <= SHARDS * (PER_SHARD + 1), "{held}");
        assert!(refused > 200_000 - held - SHARDS, "{refused}");
        // Once their buckets are full again all of them are forgotten.
        let later = 3000 * SECOND_NS;
        for address in 0..1000_u32 {
            assert_eq!(rates.admit_at(Who::at(IpAddr::from(address.to_be_bytes())), later), Ok(()));
        }
    }

    #[test]
    fn a_site_has_one_bucket_and_zero_is_no_limit() {
        let one = Who::at("2001:db8:1:2::1".parse().unwrap());
        assert_eq!(one, Who::at("2001:db8:1:2:ffff::9".parse().unwrap()));
        assert_ne!(one, Who::at("2001:db8:1:3::1".parse().unwrap()));
        assert_eq!(Who::at("::ffff:10.0.0.1".parse().unwrap()), peer(1));
        assert!(Rates::new(0.0, 5).is_none());
    }
}
