//! The callers, and how much of a limited resource one of them may hold: a part of what the others leave. A
//! single caller gets most of it. However many callers take their full share, there is always a rest for the
//! next.

use std::collections::HashMap;
use std::fmt;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use foldhash::fast::RandomState;
use thiserror::Error;

/// Callers that are counted together.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Who {
    /// All requests with one key.
    Key(Arc<str>),
    /// All requests from one address; for IPv6 the first 64 bits, which belong to one site.
    Peer(u128),
    /// Callers without a place in the table, or with an unknown address.
    Others,
    /// The service itself.
    Service,
}

/// This bit is set in the number of every IPv6 network. An IPv4 address has no bit there, so no number
/// belongs to both kinds.
const IS_IPV6: u128 = 1 << 63;

impl Who {
    /// The caller at an address.
    #[must_use]
    pub fn at(ip: IpAddr) -> Self {
        match ip.to_canonical() {
            IpAddr::V4(ip) => Self::Peer(u128::from(u32::from(ip))),
            IpAddr::V6(ip) => Self::Peer((u128::from(ip) >> 64 << 64) | IS_IPV6),
        }
    }

    /// The caller with this name, as `Display` prints it.
    #[must_use]
    pub fn named(name: &str) -> Self {
        match name.split_once(' ') {
            Some(("key", id)) => Self::Key(id.into()),
            Some(("address", ip)) => {
                ip.trim_end_matches("/64").parse().map_or(Self::Others, |ip: IpAddr| Self::at(ip))
            }
            _ if name == "service" => Self::Service,
            _ => Self::Others,
        }
    }
}

impl fmt::Display for Who {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Key(id) => write!(f, "key {id}"),
            Self::Peer(number) if *number > u128::from(u32::MAX) => {
                write!(f, "address {}/64", Ipv6Addr::from(number & !IS_IPV6))
            }
            Self::Peer(number) => {
                let low = u32::try_from(number & u128::from(u32::MAX)).unwrap_or(0);
                write!(f, "address {}", Ipv4Addr::from(low))
            }
            Self::Others => f.write_str("others"),
            Self::Service => f.write_str("service"),
        }
    }
}

/// A shared resource.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quota {
    /// Jobs that are waiting.
    QueuedJobs,
    /// Computations that run or wait.
    Computations,
    /// Clients that follow jobs.
    EventStreams,
    /// Bytes of uploads and results that are not stored yet, and of long tables of poses.
    SpoolBytes,
    /// Open connections.
    Connections,
    /// Bytes of memory of requests.
    MemoryBytes,
}

impl Quota {
    /// The name of what it counts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::QueuedJobs => "queued jobs",
            Self::Computations => "computations that run or wait",
            Self::EventStreams => "event streams",
            Self::SpoolBytes => "bytes of uploads, results and long tables of poses under way",
            Self::Connections => "connections",
            Self::MemoryBytes => "bytes of memory",
        }
    }

    /// The names of the settings that limit it.
    const fn settings(self) -> &'static str {
        match self {
            Self::QueuedJobs => "max_queued_jobs",
            Self::Computations => "max_computations and max_waiting_computations",
            Self::EventStreams => "max_event_streams",
            Self::SpoolBytes => "max_spool_bytes",
            Self::Connections => "max_connections",
            Self::MemoryBytes => "max_memory_bytes",
        }
    }

    /// How a caller gets below its share.
    const fn cure(self) -> &'static str {
        match self {
            Self::QueuedJobs => "wait until some of them have started, or cancel some",
            Self::Computations => "send fewer requests at once",
            Self::EventStreams | Self::Connections => "close some of them",
            Self::SpoolBytes => "send fewer or smaller programs or tables at once",
            Self::MemoryBytes => "send fewer or smaller requests at once",
        }
    }
}

/// The caller wants more than it may have at present.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoShare {
    /// The caller holds its full share.
    #[error(
        "this caller holds {used} {}; its share is {allowed} now ({}, max_share_per_caller): {}",
        quota.name(), quota.settings(), quota.cure()
    )]
    OverShare {
        /// The resource.
        quota: Quota,
        /// Amount that the caller holds.
        used: u64,
        /// Amount that the caller may hold at present.
        allowed: u64,
    },
    /// Nothing is left for any caller.
    #[error("all {total} {} are taken ({}); retry later", quota.name(), quota.settings())]
    Full {
        /// The resource.
        quota: Quota,
        /// Total amount.
        total: u64,
    },
}

/// The part that one caller may hold of what the others leave; above 0, at most 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share(pub f64);

impl Share {
    /// Whether a caller that holds `own` may take `more` of `total` while others hold `others`. The rest of a
    /// share is rounded up, so that somebody can take the last place.
    ///
    /// # Errors
    /// The caller may not take it.
    pub fn check(self, quota: Quota, total: u64, others: u64, own: u64, more: u64) -> Result<(), NoShare> {
        let wanted = own.saturating_add(more);
        if others.saturating_add(wanted) > total {
            // A caller that holds its full share gets that answer, even if nothing is left.
            let allowed = self.of(total.saturating_sub(others));
            if own > 0 && wanted > allowed && allowed < total.saturating_sub(others) {
                return Err(NoShare::OverShare { quota, used: own, allowed });
            }
            return Err(NoShare::Full { quota, total });
        }
        let allowed = self.of(total - others);
        if wanted > allowed { Err(NoShare::OverShare { quota, used: own, allowed }) } else { Ok(()) }
    }

    /// What one caller may hold of what the others leave.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and no more than `left`"
    )]
    pub fn of(self, left: u64) -> u64 {
        ((left as f64 * self.0).ceil() as u64).min(left)
    }
}

/// One resource that callers share. Clones share the same resource.
#[derive(Debug, Clone)]
pub struct Shares(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    quota: Quota,
    total: u64,
    share: Share,
    held: Mutex<Counts>,
}

#[derive(Debug, Default)]
struct Counts {
    all: u64,
    by: HashMap<Who, u64, RandomState>,
}

impl Shares {
    /// A total amount, of which one caller gets a share.
    #[must_use]
    pub fn new(quota: Quota, total: u64, share: Share) -> Self {
        Self(Arc::new(Shared { quota, total, share, held: Mutex::default() }))
    }

    /// Takes an amount; it is given back when the returned value is dropped.
    ///
    /// # Errors
    /// The caller holds its full share, or nothing is left.
    pub fn take(&self, who: &Who, amount: u64) -> Result<Held, NoShare> {
        let mut held = self.none_of(who);
        held.take_more(amount)?;
        Ok(held)
    }

    /// An empty holding, for a caller that will take more later.
    #[must_use]
    pub fn none_of(&self, who: &Who) -> Held {
        Held { shares: self.clone(), who: who.clone(), amount: 0 }
    }

    /// The total amount.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.total
    }

    /// The amount that one caller may hold if the others hold nothing.
    #[must_use]
    pub fn most_of_one(&self) -> u64 {
        self.0.share.of(self.0.total)
    }

    /// The amount that all callers hold.
    #[must_use]
    pub fn held(&self) -> u64 {
        self.counts().all
    }

    /// The amount that one caller holds.
    #[must_use]
    pub fn held_by(&self, who: &Who) -> u64 {
        self.counts().by.get(who).copied().unwrap_or(0)
    }

    fn counts(&self) -> MutexGuard<'_, Counts> {
        // The held amounts are consistent at every moment, even after a panic.
        self.0.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The amount that one caller holds.
#[derive(Debug)]
pub struct Held {
    shares: Shares,
    who: Who,
    amount: u64,
}

impl Held {
    /// Takes more.
    ///
    /// # Errors
    /// The caller holds its full share, or nothing is left; the amount held so far stays held.
    pub fn take_more(&mut self, more: u64) -> Result<(), NoShare> {
        let Shared { quota, total, share, .. } = *self.shares.0;
        let mut counts = self.shares.counts();
        let Counts { all, by } = &mut *counts;
        let known = by.get_mut(&self.who);
        let own = known.as_deref().copied().unwrap_or(0);
        // The service's own work is limited where it starts.
        if self.who != Who::Service {
            share.check(quota, total, *all - own, own, more)?;
        }
        *all = all.saturating_add(more);
        match known {
            Some(known) => *known = own.saturating_add(more),
            None => drop(by.insert(self.who.clone(), more)),
        }
        drop(counts);
        self.amount = self.amount.saturating_add(more);
        Ok(())
    }

    /// Gives back everything except `amount`; nothing if less is held.
    pub fn keep_only(&mut self, amount: u64) {
        let over = self.amount.saturating_sub(amount);
        if over == 0 {
            return;
        }
        self.amount -= over;
        let mut counts = self.shares.counts();
        counts.all = counts.all.saturating_sub(over);
        let Some(own) = counts.by.get_mut(&self.who) else { return };
        *own = own.saturating_sub(over);
        // A caller that holds nothing is removed.
        if *own == 0 {
            counts.by.remove(&self.who);
        }
    }

    /// The amount that is held.
    #[must_use]
    pub fn amount(&self) -> u64 {
        self.amount
    }

    /// The shared resource.
    #[must_use]
    pub fn shares(&self) -> &Shares {
        &self.shares
    }

    /// The caller that holds it.
    #[must_use]
    pub fn who(&self) -> &Who {
        &self.who
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.keep_only(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUOTA: Quota = Quota::EventStreams;

    fn key(name: &str) -> Who {
        Who::Key(name.into())
    }

    /// As many places as a caller gets.
    fn all_it_gets(shares: &Shares, who: &Who) -> Vec<Held> {
        std::iter::from_fn(|| shares.take(who, 1).ok()).collect()
    }

    #[test]
    fn one_alone_gets_its_share_of_the_whole_and_the_next_of_what_is_left() {
        let shares = Shares::new(QUOTA, 1000, Share(0.75));
        let first = all_it_gets(&shares, &key("a"));
        assert_eq!(first.len(), 750);
        let refused = shares.take(&key("a"), 1).unwrap_err();
        assert_eq!(refused, NoShare::OverShare { quota: QUOTA, used: 750, allowed: 750 });
        assert_eq!(all_it_gets(&shares, &key("b")).len(), 188);
        drop(first);
        assert_eq!((shares.held(), shares.counts().by.len()), (0, 0));
    }

    #[test]
    fn ten_that_take_all_they_get_leave_room_for_the_next() {
        let shares = Shares::new(QUOTA, 1000, Share(0.75));
        let mut held: Vec<Vec<Held>> = Vec::new();
        // In turns, until no caller gets more.
        loop {
            let before = shares.held();
            for one in 0..10 {
                if let Ok(more) = shares.take(&key(&one.to_string()), 1) {
                    held.push(vec![more]);
                }
            }
            if shares.held() == before {
                break;
            }
        }
        assert!((950..1000).contains(&shares.held()), "{}", shares.held());
        assert!(shares.take(&key("next"), 1).is_ok());
    }

    #[test]
    fn a_few_places_are_given_out_to_the_last() {
        for total in 1..=3 {
            let shares = Shares::new(QUOTA, total, Share(0.75));
            let first = all_it_gets(&shares, &key("a"));
            let second = all_it_gets(&shares, &key("b"));
            assert_eq!((first.len() + second.len()) as u64, total);
        }
        let all = Shares::new(QUOTA, 7, Share(1.0));
        assert_eq!(all_it_gets(&all, &key("a")).len(), 7);
    }

    #[test]
    fn who_finds_nothing_left_is_told_so() {
        let shares = Shares::new(QUOTA, 2, Share(1.0));
        let _held = all_it_gets(&shares, &key("a"));
        assert_eq!(shares.take(&key("b"), 1).unwrap_err(), NoShare::Full { quota: QUOTA, total: 2 });
        assert_eq!(shares.take(&key("a"), 1).unwrap_err(), NoShare::Full { quota: QUOTA, total: 2 });
        assert!(shares.take(&Who::Service, 5).is_ok());
    }

    #[test]
    fn bytes_are_taken_as_they_come_and_given_back() {
        let shares = Shares::new(Quota::SpoolBytes, 100, Share(0.5));
        let mut upload = shares.take(&key("a"), 0).unwrap();
        upload.take_more(30).unwrap();
        upload.take_more(20).unwrap();
        assert!(upload.take_more(1).is_err());
        assert_eq!(shares.held(), 50);
        let mut other = shares.take(&key("b"), 25).unwrap();
        assert!(other.take_more(1).is_err());
        drop(upload);
        other.take_more(25).unwrap();
        assert_eq!(shares.held(), 50);
    }

    #[test]
    fn a_caller_is_known_again_by_its_name() {
        let site = Who::at("2001:db8:1:2::1".parse().unwrap());
        assert_eq!(site, Who::at("2001:db8:1:2:ffff::9".parse().unwrap()));
        assert_ne!(site, Who::at("2001:db8:1:3::1".parse().unwrap()));
        assert_eq!(site.to_string(), "address 2001:db8:1:2::/64");
        let old = Who::at(IpAddr::from([10, 0, 0, 7]));
        assert_eq!(Who::at("::ffff:10.0.0.7".parse().unwrap()), old);
        assert_eq!(old.to_string(), "address 10.0.0.7");
        for who in [key("0a1b2c"), site, old, Who::Others, Who::Service] {
            assert_eq!(Who::named(&who.to_string()), who);
        }
        assert_eq!(Who::named("?"), Who::Others);
    }
}
