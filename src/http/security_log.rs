//! Requests that were not admitted: from where, with which key, and why. They have a log of their own, because
//! refused callers could make the audit log grow without limit. It has at most two files, and repetitions within a
//! minute are one line with a count.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::net::IpAddr;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use rustix::fs::OFlags;
use serde::Serialize;

use crate::meter::Counter;

/// Name of the log in the data directory; the previous log has `.1` after its name.
const SECURITY_LOG_NAME: &str = "security.log";

/// A link in the place of the log is not followed.
const NO_LINK: i32 = OFlags::NOFOLLOW.bits().cast_signed();
/// Length at which the log is renamed and a new one is started \[bytes\].
const MOST_BYTES: u64 = 4 << 20;
/// Repetitions within this time become one line.
const GATHERED: Duration = Duration::from_mins(1);
/// How often the service checks which counts are due.
const LOOK: Duration = Duration::from_secs(5);
/// Kinds of refusal whose repetitions are counted at the same time; if there are more, all counts are written.
const MOST_GATHERED: usize = 4096;
/// Refusals that may wait to be written; further ones are only counted.
const MOST_WAITING: usize = 1024;

/// Why a request was not admitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Reason {
    /// No key.
    NoKey,
    /// An `Authorization` that is not `Bearer` followed by one key.
    UnreadableKey,
    /// A key that this service does not know.
    UnknownKey,
    /// A key that was revoked.
    RevokedKey,
    /// An expired key.
    EndedKey,
    /// A key without the scope.
    Scope,
    /// A key that does not reach the machine.
    Machine,
    /// A page of another site, or a name that anyone could register.
    ForeignPage,
    /// The request does not have exactly one clear host.
    Host,
    /// No key exists, and the service is not configured to be open.
    NoKeysMade,
    /// Too many requests.
    Rate,
}

impl Reason {
    /// Every reason.
    pub(super) const ALL: [Self; 11] = [
        Self::NoKey,
        Self::UnreadableKey,
        Self::UnknownKey,
        Self::RevokedKey,
        Self::EndedKey,
        Self::Scope,
        Self::Machine,
        Self::ForeignPage,
        Self::Host,
        Self::NoKeysMade,
        Self::Rate,
    ];

    /// The word in the log and in the metrics.
    pub(super) const fn as_str(self) -> &'static str {
        match self {
            Self::NoKey => "no-key",
            Self::UnreadableKey => "unreadable-key",
            Self::UnknownKey => "unknown-key",
            Self::RevokedKey => "revoked-key",
            Self::EndedKey => "ended-key",
            Self::Scope => "scope",
            Self::Machine => "machine",
            Self::ForeignPage => "foreign-page",
            Self::Host => "host",
            Self::NoKeysMade => "no-keys-made",
            Self::Rate => "rate",
        }
    }
}

/// One refusal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct SecurityEvent {
    /// Time of the refusal.
    pub(super) at: String,
    /// The reason.
    pub(super) reason: Reason,
    /// Address of the connection; if there is a proxy, the proxy's address.
    pub(super) source: Option<IpAddr>,
    /// Id of the key, if the request proved to have one.
    pub(super) key_id: Option<String>,
    /// HTTP method of the request.
    pub(super) method: String,
    /// Path template of the request; missing if no operation has its path.
    pub(super) route: Option<String>,
    /// Our id of the request; the log line has it too.
    pub(super) request_id: String,
}

/// A line of the log.
#[derive(Debug, Serialize)]
struct Line<'a> {
    #[serde(flatten)]
    event: &'a SecurityEvent,
    /// How many refusals the line represents.
    count: u64,
}

type Kind = (Reason, Option<IpAddr>, Option<String>, Option<String>);

/// Takes refusals without delaying any request.
#[derive(Debug)]
pub(super) struct SecurityLog {
    book: SyncSender<SecurityEvent>,
    counts: [Counter; Reason::ALL.len()],
    unwritten: Arc<Counter>,
}

impl SecurityLog {
    /// Opens the log in the data directory, and writes to it on a thread of its own.
    pub(super) fn open(data_dir: &Path) -> io::Result<Self> {
        let (sender, receiver) = sync_channel(MOST_WAITING);
        let unwritten = Arc::new(Counter::new());
        let book = Book::new(data_dir, Arc::clone(&unwritten));
        std::thread::Builder::new().name("security-log".to_owned()).spawn(move || book.keep(&receiver))?;
        Ok(Self { book: sender, counts: Default::default(), unwritten })
    }

    /// Takes one refusal. If too many are waiting, it is counted and not written.
    pub(super) fn note(&self, event: SecurityEvent) {
        let place = Reason::ALL.iter().position(|reason| *reason == event.reason);
        if let Some(count) = place.and_then(|place| self.counts.get(place)) {
            count.add(1);
        }
        if self.book.try_send(event).is_err() {
            self.unwritten.add(1);
        }
    }

    /// Counts of refusals by reason, and the number of refusals that were not written.
    pub(super) fn counts(&self) -> (impl Iterator<Item = (Reason, u64)>, u64) {
        (Reason::ALL.into_iter().zip(self.counts.iter().map(Counter::get)), self.unwritten.get())
    }
}

/// The file, and the repetitions.
struct Book {
    path: PathBuf,
    file: Option<(File, u64)>,
    gathered: HashMap<Kind, Gathered>,
    unwritten: Arc<Counter>,
}

struct Gathered {
    last: SecurityEvent,
    since: Instant,
    unwritten: u64,
}

impl Book {
    fn new(data_dir: &Path, unwritten: Arc<Counter>) -> Self {
        Self { path: data_dir.join(SECURITY_LOG_NAME), file: None, gathered: HashMap::new(), unwritten }
    }

    fn keep(mut self, events: &Receiver<SecurityEvent>) {
        let mut looked = Instant::now();
        loop {
            match events.recv_timeout(LOOK) {
                Ok(event) => self.take(event),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if looked.elapsed() >= LOOK {
                looked = Instant::now();
                self.write_counts(|gathered| gathered.since.elapsed() >= GATHERED);
            }
        }
        self.write_counts(|_| true);
    }

    fn take(&mut self, event: SecurityEvent) {
        let kind = (event.reason, event.source, event.key_id.clone(), event.route.clone());
        if let Some(known) = self.gathered.get_mut(&kind) {
            known.unwritten += 1;
            known.last = event;
            return;
        }
        if self.gathered.len() >= MOST_GATHERED {
            self.write_counts(|_| true);
        }
        self.write(&event, 1);
        self.gathered.insert(kind, Gathered { last: event, since: Instant::now(), unwritten: 0 });
    }

    /// Writes the counts that are due, and removes them.
    fn write_counts(&mut self, due: impl Fn(&Gathered) -> bool) {
        let mut gathered = std::mem::take(&mut self.gathered);
        let mut written: Vec<_> =
            gathered.extract_if(|_, gathered| due(gathered)).map(|(_, it)| it).collect();
        self.gathered = gathered;
        written.sort_by(|one, other| one.last.at.cmp(&other.last.at));
        for Gathered { last, unwritten, .. } in written {
            if unwritten > 0 {
                self.write(&last, unwritten);
            }
        }
    }

    fn write(&mut self, event: &SecurityEvent, count: u64) {
        if let Err(fault) = self.try_write(event, count) {
            self.file = None;
            self.unwritten.add(count);
            tracing::warn!(error = %fault, path = %self.path.display(), "the security log cannot be written");
        }
    }

    fn try_write(&mut self, event: &SecurityEvent, count: u64) -> io::Result<()> {
        let mut line = serde_json::to_vec(&Line { event, count })?;
        line.push(b'\n');
        if self.file.as_ref().is_some_and(|(_, length)| *length >= MOST_BYTES) {
            self.file = None;
            std::fs::rename(&self.path, self.path.with_added_extension("1"))?;
        }
        let (file, length) = match &mut self.file {
            Some(open) => open,
            none => {
                let file = OpenOptions::new()
                    .create(true)
                    .append(true)
                    .mode(0o600)
                    .custom_flags(NO_LINK)
                    .open(&self.path)?;
                let length = file.metadata()?.len();
                none.insert((file, length))
            }
        };
        file.write_all(&line)?;
        *length += line.len() as u64;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    fn event(key: u32) -> SecurityEvent {
        SecurityEvent {
            at: "2026-03-14T09:26:53.589Z".to_owned(),
            reason: Reason::Scope,
            source: Some(IpAddr::from([127, 0, 0, 1])),
            key_id: Some(format!("{key:012x}")),
            method: "POST".to_owned(),
            route: Some("/v1/jobs".to_owned()),
            request_id: "x".to_owned(),
        }
    }

    fn lines(path: &Path) -> Vec<serde_json::Value> {
        let text = fs::read_to_string(path).unwrap_or_default();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    #[test]
    fn the_first_is_written_at_once_and_what_repeats_is_one_line() {
        let folder = tempfile::TempDir::new().unwrap();
        let mut book = Book::new(folder.path(), Arc::default());
        for _ in 0..1000 {
            book.take(event(1));
        }
        book.take(event(2));
        let path = folder.path().join(SECURITY_LOG_NAME);
        let counts = |lines: &[serde_json::Value]| -> Vec<u64> {
            lines.iter().map(|line| line["count"].as_u64().unwrap()).collect()
        };
        assert_eq!(counts(&lines(&path)), [1, 1]);
        book.write_counts(|_| true);
        let written = lines(&path);
        assert_eq!(counts(&written), [1, 1, 999]);
        assert_eq!(written[2]["reason"], Reason::Scope.as_str());
        assert_eq!(written[2]["source"], "127.0.0.1");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    }

    #[test]
    fn it_is_two_files_of_bounded_length_whatever_comes() {
        let folder = tempfile::TempDir::new().unwrap();
        let mut book = Book::new(folder.path(), Arc::default());
        for key in 0..60_000 {
            book.take(event(key));
            assert!(book.gathered.len() <= MOST_GATHERED);
        }
        let mut lengths: Vec<u64> = fs::read_dir(folder.path())
            .unwrap()
            .map(|file| file.unwrap().metadata().unwrap().len())
            .collect();
        lengths.sort_unstable();
        assert_eq!(lengths.len(), 2);
        assert!(lengths.iter().all(|length| *length < MOST_BYTES + 4096), "{lengths:?}");
        assert!(lengths[1] >= MOST_BYTES);
    }

    #[test]
    fn a_link_is_not_followed_and_what_could_not_be_written_is_counted() {
        let folder = tempfile::TempDir::new().unwrap();
        let elsewhere = folder.path().join("elsewhere");
        fs::write(&elsewhere, "").unwrap();
        std::os::unix::fs::symlink(&elsewhere, folder.path().join(SECURITY_LOG_NAME)).unwrap();
        let unwritten = Arc::new(Counter::new());
        let mut book = Book::new(folder.path(), Arc::clone(&unwritten));
        book.take(event(1));
        assert_eq!((unwritten.get(), fs::read(&elsewhere).unwrap().len()), (1, 0));
    }

    #[test]
    fn every_reason_has_the_word_that_the_log_writes() {
        for reason in Reason::ALL {
            assert_eq!(serde_json::to_value(reason).unwrap(), reason.as_str());
        }
    }
}
