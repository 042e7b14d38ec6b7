//! The scrub checks all stored data while the service runs: it reads everything from time to time. It also writes the
//! head of the audit log to the log, so that a copy of the log shows later whether the audit log was rewritten.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use thiserror::Error;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::Sources;
use crate::store::{BlobFault, Blobs, DamagedFile, Pace, Store, StoreError};

/// Pause before a server that did not answer is asked again for a file, and how long that goes on.
const ASKED_AGAIN: Duration = Duration::from_secs(1);
const SERVER_AWAY: Duration = Duration::from_mins(5);

/// Time between two heads in the log.
const BETWEEN_HEADS: Duration = Duration::from_hours(24);
/// Time from a start to the first scrub, if the time of the last one is not known: not while clients wait for the
/// start.
const AFTER_A_START: Duration = Duration::from_mins(10);
/// How long the end of the service waits for the present read.
const GRACE: Duration = Duration::from_secs(1);
/// The file with the time of the last scrub.
const LAST: &str = "scrub.last";

/// How often the scrub runs, and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScrubLimits {
    /// Time between two scrubs \[s\]; 0 for none.
    pub interval_s: f64,
    /// Bytes read in a second.
    pub bytes_per_s: f64,
}

/// Why the scrub could not read everything.
#[derive(Debug, Error)]
enum ScrubFault {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Checks all stored data until it is stopped.
#[derive(Debug, Clone)]
pub struct Keeper {
    keeping: Keeping,
    tasks: TaskTracker,
}

#[derive(Debug, Clone)]
struct Keeping {
    store: Store,
    blobs: Blobs,
    sources: Sources,
    data_dir: PathBuf,
    limits: ScrubLimits,
    stop: CancellationToken,
}

impl Keeper {
    /// Starts the scrub.
    #[must_use]
    pub fn open(store: Store, blobs: Blobs, sources: Sources, data_dir: &Path, limits: ScrubLimits) -> Self {
        let (stop, tasks) = (CancellationToken::new(), TaskTracker::new());
        let keeping = Keeping { store, blobs, sources, data_dir: data_dir.to_owned(), limits, stop };
        tasks.spawn(keeping.clone().tell_heads());
        if limits.interval_s > 0.0 {
            tasks.spawn(keeping.clone().scrub_again_and_again());
        }
        Self { keeping, tasks }
    }

    /// Stops the scrub, and logs the head of the audit log once more.
    pub async fn stop(&self) {
        self.keeping.stop.cancel();
        self.tasks.close();
        if tokio::time::timeout(GRACE, self.tasks.wait()).await.is_err() {
            tracing::warn!("a scrub does not stop in time");
        }
        self.keeping.tell_head("stop").await;
    }
}

impl Keeping {
    async fn tell_heads(self) {
        let mut when = "start";
        loop {
            self.tell_head(when).await;
            when = "day";
            tokio::select! {
                () = self.stop.cancelled() => return,
                () = tokio::time::sleep(BETWEEN_HEADS) => {}
            }
        }
    }

    async fn tell_head(&self, when: &str) {
        match self.store.audit_head().await {
            Ok(Some(head)) => tracing::info!(%head, when, "head of the audit log"),
            Ok(None) => tracing::info!(when, "the audit log is empty"),
            Err(fault) => tracing::error!(error = %fault, "the head of the audit log cannot be read"),
        }
    }

    async fn scrub_again_and_again(self) {
        loop {
            tokio::select! {
                () = self.stop.cancelled() => return,
                () = tokio::time::sleep(self.due_in()) => {}
            }
            let began = std::time::Instant::now();
            match self.scrub().await {
                Ok(Some(findings)) => {
                    let elapsed_s = began.elapsed().as_secs_f64();
                    tracing::info!(findings, elapsed_s, "the scrub has read all stored data");
                }
                Ok(None) => return,
                Err(fault) => tracing::error!(error = %fault, "the scrub could not read all stored data"),
            }
            // Also after a fault: the next attempt is due as if this scrub had ended well.
            if let Err(fault) = self.note_time() {
                tracing::warn!(error = %fault, "the time of the scrub cannot be stored");
                tokio::select! {
                    () = self.stop.cancelled() => return,
                    () = tokio::time::sleep(AFTER_A_START) => {}
                }
            }
        }
    }

    /// Time until the next scrub: its interval after the last one, in whichever process that was.
    fn due_in(&self) -> Duration {
        let interval = Duration::from_secs_f64(self.limits.interval_s);
        let last = std::fs::read_to_string(self.data_dir.join(LAST)).ok();
        let Some(last) = last.and_then(|last| last.trim().parse::<Timestamp>().ok()) else {
            return interval.min(AFTER_A_START);
        };
        let passed = self.sources.clock.now().duration_since(last);
        // A time in the future comes from a clock that was ahead.
        let passed = passed.max(SignedDuration::ZERO).unsigned_abs();
        interval.saturating_sub(passed).max(interval.min(Duration::from_millis(10)))
    }

    fn note_time(&self) -> io::Result<()> {
        let mut file = tempfile::NamedTempFile::new_in(&self.data_dir)?;
        writeln!(file, "{}", self.sources.timestamp())?;
        file.persist(self.data_dir.join(LAST)).map_err(|fault| fault.error).map(drop)
    }

    /// Reads every row and every file that a row names, and reports the findings; `None` if it was stopped.
    async fn scrub(&self) -> Result<Option<usize>, ScrubFault> {
        let pace = Pace::within(self.limits.bytes_per_s, self.stop.clone());
        let mut findings = self.store.damage_in_rows(&self.data_dir, &pace).await?;
        let named = self.store.named_blobs().await?;
        let (blobs, at_pace) = (self.blobs.clone(), pace.clone());
        let looked = tokio::task::spawn_blocking(move || {
            let mut found = (Vec::<DamagedFile>::new(), Vec::new());
            for sha256 in named {
                match look(&blobs, &sha256, &at_pace) {
                    Err(BlobFault::Damaged(damaged)) => found.0.push(damaged),
                    // A server that does not answer says nothing about a file.
                    Err(BlobFault::Rows(fault)) if !at_pace.is_over() => return Err(fault),
                    Err(fault) if !at_pace.is_over() => found.1.push(fault.to_string()),
                    _ => {}
                }
                if at_pace.is_over() {
                    break;
                }
            }
            Ok(found)
        });
        let (mut damaged, unreadable) = looked.await.map_err(io::Error::other)??;
        if pace.is_over() {
            return Ok(None);
        }
        // Jobs may have released files meanwhile.
        let named = self.store.named_blobs().await?;
        damaged.retain(|damaged| named.contains(&damaged.sha256));
        findings.extend(unreadable);
        for finding in &findings {
            tracing::error!("found by the scrub: {finding}");
        }
        let count = findings.len() + damaged.len();
        let at_s = self.sources.clock.now().as_second();
        self.blobs.soundness().scrubbed(&damaged, findings, at_s);
        Ok(Some(count))
    }
}

/// Reads a file. As long as its server does not answer, the question is asked again, but not for ever. Blocks.
fn look(blobs: &Blobs, sha256: &str, pace: &Pace) -> Result<(), BlobFault> {
    let mut waited = Duration::ZERO;
    loop {
        let looked = blobs.look(sha256, pace);
        if !matches!(looked, Err(BlobFault::Rows(_))) || waited >= SERVER_AWAY || pace.is_over() {
            return looked;
        }
        std::thread::sleep(ASKED_AGAIN);
        waited += ASKED_AGAIN;
    }
}
