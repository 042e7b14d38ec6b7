//! One budget for the memory of requests: bodies, documents read from them, decoders, results of computations, and
//! answers that the client has not taken yet. Memory is reserved before or while it is used, and released when it is
//! free.
//!
//! A key reserves memory for its requests; without keys, an address does. `crate::shares` says how much of the budget
//! one of them may hold.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use thiserror::Error;

use crate::shares::{Held, Quota, Share, Shares, Who};

/// Memory that every request reserves from its arrival until its answer is taken: its header, a small body, a small
/// answer or the part of a file that is being sent, and its tasks \[bytes\].
pub const REQUEST_BYTES: u64 = 192 << 10;

/// Memory of the process in addition: its code, the database's pages, and memory that the allocator keeps. With 64
/// MiB, the flood of `tests/faults/memory.py` reached 510 of 512 MiB in its second round \[bytes\].
const SERVICE_BYTES: u64 = 112 << 20;
/// Memory of a connection in addition to its requests: buffers for reading and writing, TLS \[bytes\].
const CONNECTION_BYTES: u64 = 32 << 10;
/// Memory of a running computation in addition to what it reserves \[bytes\].
const COMPUTATION_BYTES: u64 = 16 << 20;
/// The smallest budget, whatever the settings leave \[bytes\].
const LEAST_BYTES: u64 = 32 << 20;

/// Why memory is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum MemoryFault {
    /// The service would refuse it even if it were idle.
    #[error(
        "the request needs {needed_bytes} bytes of memory, but one caller may hold {most_bytes}; split it, or raise max_memory_bytes"
    )]
    Never {
        /// Memory that the request would hold in total.
        needed_bytes: u64,
        /// The most that one caller may hold.
        most_bytes: u64,
    },
    /// Other callers, or the caller's other requests, hold too much.
    #[error(
        "the request needs {needed_bytes} bytes of memory now; the caller's requests hold {held_bytes}, and {free_bytes} of \
         {budget_bytes} are free"
    )]
    Now {
        /// Memory that the request would hold in total.
        needed_bytes: u64,
        /// Memory that the caller's requests hold.
        held_bytes: u64,
        /// Free memory.
        free_bytes: u64,
        /// The budget.
        budget_bytes: u64,
    },
}

/// The budget. Clones share it.
#[derive(Debug, Clone)]
pub struct Memory(Shares);

impl Memory {
    /// A budget of `budget_bytes`. One caller may hold the part of it that `share` allows.
    #[must_use]
    pub fn new(budget_bytes: u64, share: Share) -> Self {
        Self(Shares::new(Quota::MemoryBytes, budget_bytes, share))
    }

    /// The part of `process_bytes` that is left for requests, with this many connections and this many computations
    /// at the same time.
    #[must_use]
    pub fn within(process_bytes: u64, connections: usize, computations: usize, share: Share) -> Self {
        let besides = SERVICE_BYTES
            .saturating_add(CONNECTION_BYTES.saturating_mul(connections as u64))
            .saturating_add(COMPUTATION_BYTES.saturating_mul(computations as u64));
        Self::new(process_bytes.saturating_sub(besides).max(LEAST_BYTES), share)
    }

    /// The budget \[bytes\].
    #[must_use]
    pub fn budget_bytes(&self) -> u64 {
        self.0.total()
    }

    /// The memory that is held now \[bytes\].
    #[must_use]
    pub fn held_bytes(&self) -> u64 {
        self.0.held()
    }

    /// Begins a request and reserves the memory that every request needs.
    ///
    /// # Errors
    /// There is no memory for it.
    pub fn open(&self, payer: &Who) -> Result<Account, MemoryFault> {
        let kept = Mutex::new(self.0.none_of(payer));
        let account =
            Account(Arc::new(Books { kept, leased: AtomicU64::new(0), working: AtomicU64::new(0) }));
        account.keep(REQUEST_BYTES)?;
        Ok(account)
    }
}

/// Reserves `bytes` more, for a request that holds `own_bytes` in total.
fn pay(held: &mut Held, own_bytes: u64, bytes: u64) -> Result<(), MemoryFault> {
    let needed_bytes = own_bytes.saturating_add(bytes);
    let most_bytes = held.shares().most_of_one();
    if needed_bytes > most_bytes {
        return Err(MemoryFault::Never { needed_bytes, most_bytes });
    }
    if held.take_more(bytes).is_ok() {
        return Ok(());
    }
    let shares = held.shares();
    let budget_bytes = shares.total();
    Err(MemoryFault::Now {
        needed_bytes,
        held_bytes: shares.held_by(held.who()),
        free_bytes: budget_bytes.saturating_sub(shares.held()),
        budget_bytes,
    })
}

/// The memory that one request holds; it is released with the last clone.
#[derive(Debug, Clone)]
pub struct Account(Arc<Books>);

#[derive(Debug)]
struct Books {
    /// Held until the request ends.
    kept: Mutex<Held>,
    /// Held by leases.
    leased: AtomicU64,
    /// Reserved by the next computation when it begins.
    working: AtomicU64,
}

impl Books {
    fn kept(&self) -> MutexGuard<'_, Held> {
        // The held amounts are consistent at every moment, even after a panic.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Account {
    /// Reserves this many bytes more, until the request ends.
    ///
    /// # Errors
    /// There is no room for them.
    pub fn keep(&self, bytes: u64) -> Result<(), MemoryFault> {
        let mut kept = self.0.kept();
        let own_bytes = kept.amount() + self.0.leased.load(Ordering::Relaxed);
        pay(&mut kept, own_bytes, bytes)
    }

    /// Releases everything except this many bytes.
    pub fn keep_only(&self, bytes: u64) {
        self.0.kept().keep_only(bytes);
    }

    /// The bytes that are kept.
    #[must_use]
    pub fn kept_bytes(&self) -> u64 {
        self.0.kept().amount()
    }

    /// A part of the request's memory that is released earlier; empty at first.
    #[must_use]
    pub fn lease(&self) -> Lease {
        let kept = self.0.kept();
        Lease { held: kept.shares().none_of(kept.who()), account: self.clone() }
    }

    /// Reserves the announced memory when the computation begins.
    ///
    /// # Errors
    /// There is no memory for it.
    pub(super) fn begin_work(&self) -> Result<(), MemoryFault> {
        match self.0.working.swap(0, Ordering::Relaxed) {
            0 => Ok(()),
            bytes => self.keep(bytes),
        }
    }
}

/// Memory that is reserved until this is dropped.
#[derive(Debug)]
pub struct Lease {
    held: Held,
    account: Account,
}

impl Lease {
    /// Reserves this many bytes in total, if that is more than before.
    ///
    /// # Errors
    /// There is no room for them.
    pub fn grow_to(&mut self, bytes: u64) -> Result<(), MemoryFault> {
        let more = bytes.saturating_sub(self.held.amount());
        if more > 0 {
            let leased = &self.account.0.leased;
            let own_bytes = self.account.kept_bytes() + leased.load(Ordering::Relaxed);
            pay(&mut self.held, own_bytes, more)?;
            leased.fetch_add(more, Ordering::Relaxed);
        }
        Ok(())
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        self.account.0.leased.fetch_sub(self.held.amount(), Ordering::Relaxed);
    }
}

tokio::task_local! {
    static ACCOUNT: Account;
}

/// `account` reserves the memory for the work of `request`.
pub fn paid_by<T>(account: Account, request: impl Future<Output = T>) -> impl Future<Output = T> {
    ACCOUNT.scope(account, request)
}

/// The account of the present request; `None` outside of a request.
#[must_use]
pub fn account() -> Option<Account> {
    ACCOUNT.try_with(Clone::clone).ok()
}

/// Reserves this many bytes more, until the request ends.
///
/// # Errors
/// There is no room for them.
pub fn keep(bytes: u64) -> Result<(), MemoryFault> {
    ACCOUNT.try_with(|account| account.keep(bytes)).unwrap_or(Ok(()))
}

/// Announces the memory of the next computation: it is reserved when the computation begins, not while it waits.
pub fn will_take(bytes: u64) {
    // Outside of a request nothing is reserved.
    let _announced = ACCOUNT.try_with(|account| account.0.working.fetch_add(bytes, Ordering::Relaxed));
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIB: u64 = 1 << 20;
    const SHARE: Share = Share(0.75);

    fn site(number: u128) -> Who {
        Who::Peer(number)
    }

    #[test]
    fn one_payer_has_its_share_and_everything_comes_back() {
        let memory = Memory::new(100 * MIB, SHARE);
        let one = memory.open(&site(1)).unwrap();
        assert_eq!(one.keep(75 * MIB - REQUEST_BYTES), Ok(()));
        assert!(matches!(one.keep(1), Err(MemoryFault::Never { most_bytes, .. }) if most_bytes == 75 * MIB));
        // Another request of the same caller has to wait, another caller does not.
        assert!(
            matches!(memory.open(&site(1)), Err(MemoryFault::Now { held_bytes, .. }) if held_bytes == 75 * MIB)
        );
        let other = memory.open(&site(2)).unwrap();
        assert_eq!(other.keep(15 * MIB), Ok(()));
        assert!(matches!(other.keep(5 * MIB), Err(MemoryFault::Now { .. })));
        assert_eq!(memory.held_bytes(), 90 * MIB + REQUEST_BYTES);
        drop((one, other));
        assert_eq!(memory.held_bytes(), 0);
    }

    #[test]
    fn a_lease_ends_before_the_request_and_work_is_paid_when_it_begins() {
        let memory = Memory::new(100 * MIB, SHARE);
        let account = memory.open(&Who::Key("k".into())).unwrap();
        let mut lease = account.lease();
        assert_eq!(lease.grow_to(10 * MIB), Ok(()));
        assert_eq!(lease.grow_to(5 * MIB), Ok(()));
        assert_eq!(memory.held_bytes(), 10 * MIB + REQUEST_BYTES);
        assert!(lease.grow_to(90 * MIB).is_err());
        account.keep_only(0);
        assert_eq!(memory.held_bytes(), 10 * MIB);
        // The memory of a lease counts together with the kept memory.
        assert!(
            matches!(account.keep(66 * MIB), Err(MemoryFault::Never { needed_bytes, .. }) if needed_bytes == 76 * MIB)
        );
        drop(lease);
        assert_eq!(memory.held_bytes(), 0);
        account.0.working.store(7 * MIB, Ordering::Relaxed);
        assert_eq!(account.begin_work(), Ok(()));
        assert_eq!(account.begin_work(), Ok(()));
        assert_eq!(memory.held_bytes(), 7 * MIB);
    }

    #[test]
    fn what_is_left_of_the_process_is_the_budget() {
        let budget = Memory::within(512 << 20, 1024, 2, SHARE).budget_bytes();
        assert_eq!(budget, (512 - 112 - 32 - 32) << 20);
        assert_eq!(Memory::within(1, 1024, 64, SHARE).budget_bytes(), LEAST_BYTES);
    }
}
