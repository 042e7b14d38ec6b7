//! One budget for the memory that requests take: bodies, what is read from them, decoders, what a computation makes, and
//! answers that the client has not taken yet. It is paid before or as the memory is taken, and given back when it is free.
//!
//! Who pays is a key, or an address where there is none. One payer may hold four times what is free at that moment:
//! alone four fifths of all, and however many hold as much as they may, something is left for the next.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use thiserror::Error;

use crate::shares::Who;

/// How many times what is free one payer may hold.
const SHARE: u64 = 4;
/// What every request pays from its arrival until its answer is taken: its header, a small body, a small answer or the part of
/// a file that is on its way, and the tasks that belong to it \[bytes\].
pub const REQUEST_BYTES: u64 = 192 << 10;

/// What the process takes besides: its code, the database's pages, and what the allocator keeps of memory that was given back. With
/// 64 MiB the flood of `tests/faults/memory.py` reached 510 of 512 MiB in its second round \[bytes\].
const SERVICE_BYTES: u64 = 112 << 20;
/// What a connection takes besides its requests: buffers for reading and writing, TLS \[bytes\].
const CONNECTION_BYTES: u64 = 32 << 10;
/// What a running computation takes besides what it pays for \[bytes\].
const COMPUTATION_BYTES: u64 = 16 << 20;
/// The least budget, whatever the settings leave \[bytes\].
const LEAST_BYTES: u64 = 32 << 20;

/// Why memory is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum MemoryFault {
    /// It would be refused at an idle service too.
    #[error(
        "the request needs {needed_bytes} bytes of memory, and one may have {most_bytes}; split it, or raise max_memory_bytes"
    )]
    Never {
        /// All that the request would hold.
        needed_bytes: u64,
        /// Most that one may hold.
        most_bytes: u64,
    },
    /// Others hold too much, or the caller's other requests do.
    #[error(
        "the request needs {needed_bytes} bytes of memory now; the caller's requests hold {held_bytes}, and {free_bytes} of \
         {budget_bytes} are free"
    )]
    Now {
        /// All that the request would hold.
        needed_bytes: u64,
        /// What the caller's requests hold.
        held_bytes: u64,
        /// What nobody holds.
        free_bytes: u64,
        /// The budget.
        budget_bytes: u64,
    },
}

/// The budget. A clone is the same one.
#[derive(Debug, Clone)]
pub struct Memory {
    books: Arc<Mutex<Books>>,
    budget_bytes: u64,
}

#[derive(Debug, Default)]
struct Books {
    held_bytes: u64,
    payers: HashMap<Who, u64>,
}

impl Memory {
    /// A budget of so many bytes.
    #[must_use]
    pub fn new(budget_bytes: u64) -> Self {
        Self { books: Arc::default(), budget_bytes }
    }

    /// What is left for requests of `process_bytes`, with so many connections and computations side by side.
    #[must_use]
    pub fn within(process_bytes: u64, connections: usize, computations: usize) -> Self {
        let besides = SERVICE_BYTES
            .saturating_add(CONNECTION_BYTES.saturating_mul(connections as u64))
            .saturating_add(COMPUTATION_BYTES.saturating_mul(computations as u64));
        Self::new(process_bytes.saturating_sub(besides).max(LEAST_BYTES))
    }

    /// The budget \[bytes\].
    #[must_use]
    pub fn budget_bytes(&self) -> u64 {
        self.budget_bytes
    }

    /// What is held now \[bytes\].
    #[must_use]
    pub fn held_bytes(&self) -> u64 {
        self.books().held_bytes
    }

    /// Begins a request, which pays what every request does.
    ///
    /// # Errors
    /// There is no room for it.
    pub fn open(&self, payer: Who) -> Result<Account, MemoryFault> {
        let (kept, leased, working) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
        let account = Account(Arc::new(Held { memory: self.clone(), payer, kept, leased, working }));
        account.keep(REQUEST_BYTES)?;
        Ok(account)
    }

    fn books(&self) -> MutexGuard<'_, Books> {
        // What is held is whole at every moment, whoever panicked with it.
        self.books.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn pay(&self, payer: &Who, own_bytes: u64, bytes: u64) -> Result<(), MemoryFault> {
        let needed_bytes = own_bytes.saturating_add(bytes);
        let most_bytes = self.budget_bytes / (SHARE + 1) * SHARE;
        if needed_bytes > most_bytes {
            return Err(MemoryFault::Never { needed_bytes, most_bytes });
        }
        let mut books = self.books();
        let held_bytes = books.payers.get(payer).copied().unwrap_or(0);
        let free_bytes = self.budget_bytes.saturating_sub(books.held_bytes);
        let after = free_bytes.checked_sub(bytes);
        if after.is_none_or(|free| held_bytes + bytes > free.saturating_mul(SHARE)) {
            let budget_bytes = self.budget_bytes;
            return Err(MemoryFault::Now { needed_bytes, held_bytes, free_bytes, budget_bytes });
        }
        books.held_bytes += bytes;
        match books.payers.get_mut(payer) {
            Some(held) => *held += bytes,
            None => drop(books.payers.insert(payer.clone(), bytes)),
        }
        Ok(())
    }

    fn give_back(&self, payer: &Who, bytes: u64) {
        let mut books = self.books();
        books.held_bytes = books.held_bytes.saturating_sub(bytes);
        if let Some(held) = books.payers.get_mut(payer) {
            *held = held.saturating_sub(bytes);
            if *held == 0 {
                books.payers.remove(payer);
            }
        }
    }
}

/// What one request holds, given back with the last clone.
#[derive(Debug, Clone)]
pub struct Account(Arc<Held>);

#[derive(Debug)]
struct Held {
    memory: Memory,
    payer: Who,
    /// Until the request ends.
    kept: AtomicU64,
    /// By leases.
    leased: AtomicU64,
    /// To be paid by the next computation when it begins.
    working: AtomicU64,
}

impl Drop for Held {
    fn drop(&mut self) {
        self.memory.give_back(&self.payer, *self.kept.get_mut());
    }
}

impl Account {
    /// Pays for so many bytes more, until the request ends.
    ///
    /// # Errors
    /// There is no room for them.
    pub fn keep(&self, bytes: u64) -> Result<(), MemoryFault> {
        self.pay(bytes)?;
        self.0.kept.fetch_add(bytes, Ordering::Relaxed);
        Ok(())
    }

    /// Gives back what is kept but for so many bytes.
    pub fn keep_only(&self, bytes: u64) {
        let before = self.0.kept.fetch_min(bytes, Ordering::Relaxed);
        if before > bytes {
            self.0.memory.give_back(&self.0.payer, before - bytes);
        }
    }

    /// What is kept \[bytes\].
    #[must_use]
    pub fn kept_bytes(&self) -> u64 {
        self.0.kept.load(Ordering::Relaxed)
    }

    /// A part of what the request holds that ends before it; nothing yet.
    #[must_use]
    pub fn lease(&self) -> Lease {
        Lease { account: self.clone(), bytes: 0 }
    }

    /// Pays for what was announced, as the computation begins.
    ///
    /// # Errors
    /// There is no room for it.
    pub(super) fn begin_work(&self) -> Result<(), MemoryFault> {
        match self.0.working.swap(0, Ordering::Relaxed) {
            0 => Ok(()),
            bytes => self.keep(bytes),
        }
    }

    fn pay(&self, bytes: u64) -> Result<(), MemoryFault> {
        let own = self.kept_bytes() + self.0.leased.load(Ordering::Relaxed);
        self.0.memory.pay(&self.0.payer, own, bytes)
    }
}

/// Memory paid for until this is dropped.
#[derive(Debug)]
pub struct Lease {
    account: Account,
    bytes: u64,
}

impl Lease {
    /// Pays for so many bytes in all, if they are more than before.
    ///
    /// # Errors
    /// There is no room for them.
    pub fn grow_to(&mut self, bytes: u64) -> Result<(), MemoryFault> {
        let more = bytes.saturating_sub(self.bytes);
        if more > 0 {
            self.account.pay(more)?;
            self.account.0.leased.fetch_add(more, Ordering::Relaxed);
            self.bytes = bytes;
        }
        Ok(())
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let held = &self.account.0;
        held.leased.fetch_sub(self.bytes, Ordering::Relaxed);
        held.memory.give_back(&held.payer, self.bytes);
    }
}

tokio::task_local! {
    static ACCOUNT: Account;
}

/// What `request` does is paid by `account`.
pub fn paid_by<T>(account: Account, request: impl Future<Output = T>) -> impl Future<Output = T> {
    ACCOUNT.scope(account, request)
}

/// Who pays for what is done here; nobody outside of a request.
#[must_use]
pub fn account() -> Option<Account> {
    ACCOUNT.try_with(Clone::clone).ok()
}

/// Pays for so many bytes more, until the request ends.
///
/// # Errors
/// There is no room for them.
pub fn keep(bytes: u64) -> Result<(), MemoryFault> {
    ACCOUNT.try_with(|account| account.keep(bytes)).unwrap_or(Ok(()))
}

/// Announces what the next computation takes: it is paid once the computation begins, not while it waits.
pub fn will_take(bytes: u64) {
    // Outside of a request nobody pays.
    let _announced = ACCOUNT.try_with(|account| account.0.working.fetch_add(bytes, Ordering::Relaxed));
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIB: u64 = 1 << 20;

    fn site(number: u128) -> Who {
        Who::Peer(number)
    }

    #[test]
    fn one_payer_has_four_fifths_and_everything_comes_back() {
        let memory = Memory::new(100 * MIB);
        let one = memory.open(site(1)).unwrap();
        assert_eq!(one.keep(80 * MIB - REQUEST_BYTES), Ok(()));
        assert!(matches!(one.keep(1), Err(MemoryFault::Never { most_bytes, .. }) if most_bytes == 80 * MIB));
        // Another request of the same payer has to wait, another payer has not.
        assert!(matches!(memory.open(site(1)), Err(MemoryFault::Now { .. })));
        let other = memory.open(site(2)).unwrap();
        assert_eq!(other.keep(15 * MIB), Ok(()));
        assert!(matches!(other.keep(5 * MIB), Err(MemoryFault::Now { .. })));
        assert_eq!(memory.held_bytes(), 95 * MIB + REQUEST_BYTES);
        drop((one, other));
        assert_eq!(memory.held_bytes(), 0);
        assert!(memory.books().payers.is_empty());
    }

    #[test]
    fn however_many_hold_as_much_as_they_may_there_is_room_for_the_next() {
        let memory = Memory::new(1000 * MIB);
        let mut accounts = Vec::new();
        for number in 0..4 {
            let account = memory.open(site(number)).unwrap();
            while account.keep(MIB / 16).is_ok() {}
            accounts.push(account);
            assert!(memory.held_bytes() < memory.budget_bytes(), "{number}");
        }
        let next = memory.open(site(9)).unwrap();
        assert_eq!(next.keep(MIB / 8), Ok(()));
    }

    #[test]
    fn a_lease_ends_before_the_request_and_work_is_paid_when_it_begins() {
        let memory = Memory::new(100 * MIB);
        let account = memory.open(Who::Key("k".into())).unwrap();
        let mut lease = account.lease();
        assert_eq!(lease.grow_to(10 * MIB), Ok(()));
        assert_eq!(lease.grow_to(5 * MIB), Ok(()));
        assert_eq!(memory.held_bytes(), 10 * MIB + REQUEST_BYTES);
        assert!(lease.grow_to(90 * MIB).is_err());
        account.keep_only(0);
        assert_eq!(memory.held_bytes(), 10 * MIB);
        drop(lease);
        assert_eq!(memory.held_bytes(), 0);
        account.0.working.store(7 * MIB, Ordering::Relaxed);
        assert_eq!(account.begin_work(), Ok(()));
        assert_eq!(account.begin_work(), Ok(()));
        assert_eq!(memory.held_bytes(), 7 * MIB);
    }

    #[test]
    fn what_is_left_of_the_process_is_the_budget() {
        let budget = Memory::within(512 << 20, 1024, 2).budget_bytes();
        assert_eq!(budget, (512 - 112 - 32 - 32) << 20);
        assert_eq!(Memory::within(1, 1024, 64).budget_bytes(), LEAST_BYTES);
    }
}
