//! The API keys as the guard sees them: in memory, and never older than the last change of theirs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant};

use super::AppState;
use crate::jobs::KeyRing;
use crate::store::{KeyMark, Store, StoreError};

/// How long the ring is trusted without asking the database. Changes by this process and by the command line are seen
/// at once; this is for what comes in any other way, such as a restored database.
const TRUSTED: Duration = Duration::from_secs(1);

/// How often the use of one key is written down.
const NOTED: Duration = Duration::from_secs(300);

/// The keys of one data directory.
#[derive(Debug)]
pub(super) struct HeldKeys {
    directory: PathBuf,
    loaded: RwLock<Option<Loaded>>,
    loading: tokio::sync::Mutex<()>,
    noted: Mutex<HashMap<Arc<str>, Instant>>,
}

#[derive(Debug, Clone)]
struct Loaded {
    ring: Arc<KeyRing>,
    mark: Option<KeyMark>,
    at: Instant,
}

impl HeldKeys {
    pub(super) fn new(directory: &Path) -> Self {
        Self {
            directory: directory.to_owned(),
            loaded: RwLock::new(None),
            loading: tokio::sync::Mutex::new(()),
            noted: Mutex::default(),
        }
    }

    /// Every key as it is now.
    ///
    /// # Errors
    /// The keys have changed, or were never read, and cannot be read.
    pub(super) async fn current(&self, store: &Store) -> Result<Arc<KeyRing>, StoreError> {
        if let Some(loaded) = self.unchanged()
            && loaded.at.elapsed() < TRUSTED
        {
            return Ok(loaded.ring);
        }
        // Only one request reads; the others that come meanwhile find what it has read.
        let _reading = self.loading.lock().await;
        let known = self.unchanged();
        if let Some(loaded) = &known
            && loaded.at.elapsed() < TRUSTED
        {
            return Ok(Arc::clone(&loaded.ring));
        }
        // Looked at before the database, so that a change in between is seen the next time.
        let (mark, at) = (KeyMark::of(&self.directory), Instant::now());
        let ring = match (store.every_api_key().await, known) {
            (Ok(rows), _) => Arc::new(KeyRing::of(rows)),
            (Err(fault), Some(known)) => {
                tracing::warn!(error = %fault, "the API keys cannot be read again; those that are known go on");
                known.ring
            }
            (Err(fault), None) => return Err(fault),
        };
        let loaded = Loaded { ring: Arc::clone(&ring), mark, at };
        *self.loaded.write().unwrap_or_else(PoisonError::into_inner) = Some(loaded);
        Ok(ring)
    }

    /// What was read, where nobody has said since that it has changed.
    fn unchanged(&self) -> Option<Loaded> {
        let loaded = self.loaded.read().unwrap_or_else(PoisonError::into_inner).clone();
        loaded.filter(|loaded| loaded.mark == KeyMark::of(&self.directory))
    }

    /// The keys have changed: they are read again before the next request.
    pub(super) fn forget(&self) {
        *self.loaded.write().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Writes down that a key was used, now and then.
    pub(super) fn note_use(&self, app: &AppState, id: &Arc<str>) {
        {
            let mut noted = self.noted.lock().unwrap_or_else(PoisonError::into_inner);
            if noted.get(id).is_some_and(|at| at.elapsed() < NOTED) {
                return;
            }
            noted.insert(Arc::clone(id), Instant::now());
        }
        let (store, id, at) = (app.store.clone(), Arc::clone(id), app.sources.timestamp());
        tokio::spawn(async move {
            if let Err(fault) = store.note_use_of_api_key(&id, &at).await {
                tracing::warn!(error = %fault, key_id = %id, "the use of an API key could not be noted");
            }
        });
    }
}
