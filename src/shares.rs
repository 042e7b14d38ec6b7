//! Who asks, and how much of what is limited one of them may hold: a part of what the others leave. One alone gets most of it, and
//! however many take all they get, there is always a rest for the next.

use std::collections::HashMap;
use std::fmt;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use thiserror::Error;

/// Who is counted together.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Who {
    /// Everything asked under one key.
    Key(Arc<str>),
    /// Everything from one address; of IPv6 the first 64 bits, which one site holds.
    Peer(u128),
    /// Callers for whom there was no place in a table, or whose address is not known.
    Others,
    /// The service itself.
    Service,
}

/// Set in the number of every IPv6 network: below 64 bits nothing else is, so that no address of the one kind is one of the other.
const IS_IPV6: u128 = 1 << 63;

impl Who {
    /// Of an address.
    #[must_use]
    pub fn at(ip: IpAddr) -> Self {
        match ip.to_canonical() {
            IpAddr::V4(ip) => Self::Peer(u128::from(u32::from(ip))),
            IpAddr::V6(ip) => Self::Peer((u128::from(ip) >> 64 << 64) | IS_IPV6),
        }
    }

    /// The caller of this name, as it prints.
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

/// What is shared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quota {
    /// Jobs that wait.
    QueuedJobs,
    /// Computations that run and wait.
    Computations,
    /// Clients that follow jobs.
    EventStreams,
    /// Bytes of uploads and results that are not stored yet.
    SpoolBytes,
    /// Open connections.
    Connections,
    /// Bytes of memory that requests take.
    MemoryBytes,
}

impl Quota {
    /// What it counts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::QueuedJobs => "queued jobs",
            Self::Computations => "computations that run or wait",
            Self::EventStreams => "event streams",
            Self::SpoolBytes => "bytes of uploads and results under way",
            Self::Connections => "connections",
            Self::MemoryBytes => "bytes of memory",
        }
    }

    /// The settings that make it, as they are named.
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

    /// How a caller gets below it.
    const fn cure(self) -> &'static str {
        match self {
            Self::QueuedJobs => "wait until some of them have begun, or cancel some",
            Self::Computations => "send fewer requests at once",
            Self::EventStreams | Self::Connections => "close some of them",
            Self::SpoolBytes => "send fewer or smaller programs at once",
            Self::MemoryBytes => "send fewer or smaller requests at once",
        }
    }
}

/// More than there is for this caller now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoShare {
    /// The caller has its share.
    #[error(
        "this caller holds {used} {} and may hold {allowed} beside what others hold ({}, max_share_per_caller): {}",
        quota.name(), quota.settings(), quota.cure()
    )]
    OverShare {
        /// Of what.
        quota: Quota,
        /// What it holds.
        used: u64,
        /// What it may hold now.
        allowed: u64,
    },
    /// There is no more for anybody.
    #[error("all {total} {} are taken ({})", quota.name(), quota.settings())]
    Full {
        /// Of what.
        quota: Quota,
        /// How much there is.
        total: u64,
    },
}

/// The part that one caller may hold of what the others leave; above 0, at most 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share(pub f64);

impl Share {
    /// Whether a caller that holds `own` may take `more` of `total` while others hold `others`. What is left of a share is rounded
    /// up, so that the last place is somebody's.
    ///
    /// # Errors
    /// It may not.
    pub fn check(self, quota: Quota, total: u64, others: u64, own: u64, more: u64) -> Result<(), NoShare> {
        let wanted = own.saturating_add(more);
        if others.saturating_add(wanted) > total {
            // Whoever has all that one may have is told so, also where nothing is left.
            let allowed = self.of(total.saturating_sub(others));
            if own > 0 && wanted > allowed && allowed < total.saturating_sub(others) {
                return Err(NoShare::OverShare { quota, used: own, allowed });
            }
            return Err(NoShare::Full { quota, total });
        }
        let allowed = self.of(total - others);
        if wanted > allowed { Err(NoShare::OverShare { quota, used: own, allowed }) } else { Ok(()) }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and no more than `left`"
    )]
    fn of(self, left: u64) -> u64 {
        ((left as f64 * self.0).ceil() as u64).min(left)
    }
}

/// One thing that callers share. A clone shares the same.
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
    by: HashMap<Who, u64>,
}

impl Shares {
    /// So much for all, of which one gets a share.
    #[must_use]
    pub fn new(quota: Quota, total: u64, share: Share) -> Self {
        Self(Arc::new(Shared { quota, total, share, held: Mutex::default() }))
    }

    /// Takes so much; it is given back when what is returned goes.
    ///
    /// # Errors
    /// The caller has its share, or nothing is left.
    pub fn take(&self, who: &Who, amount: u64) -> Result<Held, NoShare> {
        let mut held = self.none_of(who);
        held.take_more(amount)?;
        Ok(held)
    }

    /// Nothing yet, for a caller that is to take more as it comes.
    #[must_use]
    pub fn none_of(&self, who: &Who) -> Held {
        Held { shares: self.clone(), who: who.clone(), amount: 0 }
    }

    /// What there is for all.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.total
    }

    /// What one caller may hold where nobody else holds anything.
    #[must_use]
    pub fn most_of_one(&self) -> u64 {
        self.0.share.of(self.0.total)
    }

    /// What all hold.
    #[must_use]
    pub fn held(&self) -> u64 {
        self.counts().all
    }

    /// What one caller holds.
    #[must_use]
    pub fn held_by(&self, who: &Who) -> u64 {
        self.counts().by.get(who).copied().unwrap_or(0)
    }

    fn counts(&self) -> MutexGuard<'_, Counts> {
        // What is held is whole at every moment, whoever panicked with it.
        self.0.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What one caller holds.
#[derive(Debug)]
pub struct Held {
    shares: Shares,
    who: Who,
    amount: u64,
}

impl Held {
    /// Takes more to it.
    ///
    /// # Errors
    /// The caller has its share, or nothing is left; what was held stays held.
    pub fn take_more(&mut self, more: u64) -> Result<(), NoShare> {
        let Shared { quota, total, share, .. } = *self.shares.0;
        let mut counts = self.shares.counts();
        let own = counts.by.get(&self.who).copied().unwrap_or(0);
        // The service's own work is bounded where it is begun.
        if self.who != Who::Service {
            share.check(quota, total, counts.all - own, own, more)?;
        }
        counts.all = counts.all.saturating_add(more);
        counts.by.insert(self.who.clone(), own.saturating_add(more));
        drop(counts);
        self.amount = self.amount.saturating_add(more);
        Ok(())
    }

    /// Gives back all but `amount`; nothing, where less is held.
    pub fn keep_only(&mut self, amount: u64) {
        let over = self.amount.saturating_sub(amount);
        if over == 0 {
            return;
        }
        self.amount -= over;
        let mut counts = self.shares.counts();
        counts.all = counts.all.saturating_sub(over);
        let own = counts.by.get(&self.who).copied().unwrap_or(0).saturating_sub(over);
        // Nobody is remembered who holds nothing.
        if own == 0 {
            counts.by.remove(&self.who);
        } else {
            counts.by.insert(self.who.clone(), own);
        }
    }

    /// How much is held.
    #[must_use]
    pub fn amount(&self) -> u64 {
        self.amount
    }

    /// Of what, and what others hold of it.
    #[must_use]
    pub fn shares(&self) -> &Shares {
        &self.shares
    }

    /// Who holds it.
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

    /// As many as a caller gets.
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
        // In turns, until nobody gets more.
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
