//! The API keys as the guard sees them: in memory, and never older than their last change.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant};

use crate::jobs::{KeyRing, Sources};
use crate::store::{KEY_MARK_TRUSTED, KeyMark, Store, StoreError};

/// How long the keys are trusted without asking the database. Changes by this process and by the command line are
/// seen at once. This time is for changes that come in any other way, such as a restored database.
const TRUSTED: Duration = Duration::from_secs(1);

/// How long keys stay in use that cannot be read again, if other services may have changed them. With a database that
/// one service has, only this service changes them, and they stay in use.
const TRUSTED_WHILE_AWAY: Duration = Duration::from_secs(30);

/// How often the use of one key is recorded.
const NOTED: Duration = Duration::from_mins(5);

/// The keys of one data directory.
#[derive(Debug)]
pub(super) struct HeldKeys {
    /// The file with which another process reports that it has changed the keys.
    mark: PathBuf,
    loaded: RwLock<Option<Loaded>>,
    loading: tokio::sync::Mutex<()>,
    noted: Mutex<HashMap<Arc<str>, Instant>>,
    /// Whether keys have ever been seen.
    closed: AtomicBool,
}

#[derive(Debug)]
struct Loaded {
    ring: Arc<KeyRing>,
    mark: Option<KeyMark>,
    /// Number of changes that other services had told.
    changes: u64,
    /// When they were last looked for.
    at: Instant,
    /// When the database last gave them.
    read: Instant,
    /// How long after `at` the last check of the mark began \[ns\].
    looked_ns: AtomicU64,
}

impl Loaded {
    /// Whether no change of the keys was reported within this age.
    fn is_unchanged(&self, age: Duration, place: &Path) -> bool {
        let looked = Duration::from_nanos(self.looked_ns.load(Ordering::Relaxed));
        if age < looked + KEY_MARK_TRUSTED {
            return true;
        }
        let unchanged = self.mark == KeyMark::at(place);
        if unchanged {
            // The time at which the check began: the next check must find a change that came after it.
            self.looked_ns.store(u64::try_from(age.as_nanos()).unwrap_or(0), Ordering::Relaxed);
        }
        unchanged
    }
}

impl HeldKeys {
    pub(super) fn new(directory: &Path) -> Self {
        Self {
            mark: KeyMark::place(directory),
            loaded: RwLock::new(None),
            loading: tokio::sync::Mutex::new(()),
            noted: Mutex::default(),
            closed: AtomicBool::new(false),
        }
    }

    /// Every key at present.
    ///
    /// # Errors
    /// The keys have changed, or were never read, and cannot be read.
    pub(super) async fn current(&self, store: &Store) -> Result<Arc<KeyRing>, StoreError> {
        if let Some((ring, age, _)) = self.unchanged(store)
            && age < TRUSTED
        {
            return Ok(ring);
        }
        // Boxed because it is rare: otherwise its memory would be part of every request's.
        Box::pin(self.read(store)).await
    }

    /// Every key from the database.
    async fn read(&self, store: &Store) -> Result<Arc<KeyRing>, StoreError> {
        // Only one request reads; the requests that come meanwhile use its result.
        let _reading = self.loading.lock().await;
        let known = self.unchanged(store);
        if let Some((ring, age, _)) = &known
            && *age < TRUSTED
        {
            return Ok(Arc::clone(ring));
        }
        // Checked before the database is read, so that the next check sees a change in between.
        let at = Instant::now();
        let (mark, changes) = (KeyMark::at(&self.mark), store.key_changes());
        let (ring, read) = match (store.every_api_key().await, known) {
            (Ok(rows), _) => (Arc::new(KeyRing::of(rows)), at),
            (Err(fault), Some((known, _age, read)))
                if !store.is_shared() || read.elapsed() < TRUSTED_WHILE_AWAY =>
            {
                tracing::warn!(error = %fault, "the API keys cannot be read again; the known keys stay in use");
                (known, read)
            }
            (Err(fault), _) => return Err(fault),
        };
        if !ring.is_empty() {
            self.closed.store(true, Ordering::Relaxed);
        }
        let looked_ns = AtomicU64::new(0);
        let loaded = Loaded { ring: Arc::clone(&ring), mark, changes, at, read, looked_ns };
        *self.loaded.write().unwrap_or_else(PoisonError::into_inner) = Some(loaded);
        Ok(ring)
    }

    /// The keys that were read, their age, and when the database last gave them, if no change was reported since.
    fn unchanged(&self, store: &Store) -> Option<(Arc<KeyRing>, Duration, Instant)> {
        let loaded = self.loaded.read().unwrap_or_else(PoisonError::into_inner);
        let loaded = loaded.as_ref()?;
        let age = loaded.at.elapsed();
        let unchanged = loaded.changes == store.key_changes() && loaded.is_unchanged(age, &self.mark);
        unchanged.then(|| (Arc::clone(&loaded.ring), age, loaded.read))
    }

    /// Whether this process has ever seen a key: it never opens again, whatever happens to the database.
    pub(super) fn were_seen(&self) -> bool {
        self.closed.load(Ordering::Relaxed)
    }

    /// The keys have changed: they are read again before the next request.
    pub(super) fn forget(&self) {
        *self.loaded.write().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Records from time to time that a key was used.
    pub(super) fn note_use(&self, store: &Store, sources: &Sources, id: &Arc<str>) {
        {
            let mut noted = self.noted.lock().unwrap_or_else(PoisonError::into_inner);
            if noted.get(id).is_some_and(|at| at.elapsed() < NOTED) {
                return;
            }
            noted.insert(Arc::clone(id), Instant::now());
        }
        let (store, id, at) = (store.clone(), Arc::clone(id), sources.timestamp());
        tokio::spawn(async move {
            if let Err(fault) = store.note_use_of_api_key(&id, &at).await {
                tracing::warn!(error = %fault, key_id = %id, "the use of an API key could not be recorded");
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::mark_key_change;

    #[test]
    fn a_change_is_seen_as_soon_as_it_was_told() {
        let folder = tempfile::TempDir::new().unwrap();
        let place = KeyMark::place(folder.path());
        let ring = Arc::new(KeyRing::of(Vec::new()));
        let (at, looked_ns) = (Instant::now(), AtomicU64::new(0));
        let loaded = Loaded { ring, mark: None, changes: 0, at, read: at, looked_ns };
        assert!(loaded.is_unchanged(KEY_MARK_TRUSTED * 2, &place));
        // The last check was as late as possible before the change.
        loaded.looked_ns.store(u64::try_from(loaded.at.elapsed().as_nanos()).unwrap(), Ordering::Relaxed);
        mark_key_change(folder.path(), "one").unwrap();
        assert!(!loaded.is_unchanged(loaded.at.elapsed(), &place));
    }
}
