//! What the process does to the files below one folder, in order, and the faults that meet it there.
//!
//! A path is held as it stands below that folder. `SQLite`'s shared memory (`-shm`) is left out: it is written
//! through a mapping, it never outlives the processes that map it, and `SQLite` makes it anew from the write-ahead
//! log.

use std::collections::BTreeMap;
use std::ffi::c_int;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::chance::Chance;

/// A file or a folder, whatever it is called at the moment.
pub(crate) type Node = u32;

/// The folder itself.
pub(crate) const ROOT: Node = 0;

/// One thing that was done.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Op {
    /// A file was made.
    Create { node: Node, path: String },
    /// A folder was made.
    Folder { node: Node, path: String },
    /// Bytes were written.
    Write { node: Node, at: u64, bytes: Arc<[u8]> },
    /// The length was set.
    Length { node: Node, length: u64 },
    /// The name was changed.
    Rename { from: String, to: String },
    /// The name was removed.
    Remove { path: String },
    /// File or folder is on the disk.
    Sync { node: Node },
    /// The disk said that it could not: what was written until now is in memory alone, and stays there.
    SyncFailed { node: Node },
    /// Nothing: a planted fault left it out.
    Nothing,
}

/// What meets a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Illness {
    /// No space is left: nothing is made or written.
    Full,
    /// Every write breaks off half way with EIO.
    Writing,
    /// Nothing can be synchronised: EIO.
    Synchronising,
    /// Every second write is interrupted before its first byte.
    Interrupted,
    /// Every write writes a part.
    Short,
    /// Every call takes half a second by the clock that never goes back.
    Slow,
}

/// An illness that begins with one call and passes after some.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) illness: Illness,
    /// The first call that it meets, counted from 0 over all calls that change anything.
    pub(crate) at: usize,
    /// How many calls it lasts.
    pub(crate) calls: usize,
}

/// Half a second \[ns\].
const SLOW_NS: i64 = 500_000_000;

static ON: AtomicBool = AtomicBool::new(false);
static RECORDER: Mutex<Option<Recorder>> = Mutex::new(None);
/// What the clock that never goes back shows \[ns\]; negative where it goes as it does.
static STANDING_NS: AtomicI64 = AtomicI64::new(-1);
static RECEIVER_PORT: AtomicU64 = AtomicU64::new(0);

/// Where every callback goes by its address; the recorder leads it to the receiver of the run.
pub(crate) const CALLBACK_PORT: u16 = 9;

#[derive(Debug)]
struct Open {
    node: Node,
    path: String,
}

/// The log of one run.
#[derive(Debug)]
pub(crate) struct Recorder {
    root: String,
    log: Vec<Op>,
    names: BTreeMap<String, Node>,
    open: BTreeMap<c_int, Open>,
    next: Node,
    calls: usize,
    fault: Option<Fault>,
    random: BTreeMap<usize, Chance>,
    seed: u64,
}

/// Whether a call may be to a file of the run.
pub(crate) fn is_on() -> bool {
    ON.load(Ordering::Acquire)
}

/// The recorder, while one records.
pub(crate) fn recorder() -> MutexGuard<'static, Option<Recorder>> {
    RECORDER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Begins to record what is done below `root`; what is there already has its nodes in the order of their paths.
pub(crate) fn begin(root: &Path, seed: u64, fault: Option<Fault>) {
    let mut names = BTreeMap::from([(String::new(), ROOT)]);
    for (node, (path, _bytes)) in (1..).zip(tree(root)) {
        names.insert(path, node);
    }
    let next = Node::try_from(names.len()).unwrap();
    let root = root.to_str().unwrap().to_owned();
    let mut random = Chance::of(seed, 1);
    let bytes: Vec<u8> = (0..RANDOM_BYTES).map(|_| random.bits().to_le_bytes()[0]).collect();
    fs::write(format!("{root}{RANDOM_FILE}"), bytes).unwrap();
    let (log, open, random) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
    *recorder() = Some(Recorder { root, log, names, open, next, calls: 0, fault, random, seed });
    STANDING_NS.store(crate::interpose::real_monotonic_ns(), Ordering::SeqCst);
    ON.store(true, Ordering::Release);
}

/// Ends the recording, and gives what was recorded.
pub(crate) fn end() -> Vec<Op> {
    ON.store(false, Ordering::Release);
    STANDING_NS.store(-1, Ordering::SeqCst);
    RECEIVER_PORT.store(0, Ordering::SeqCst);
    let Recorder { log, root, .. } = recorder().take().unwrap();
    fs::remove_file(format!("{root}{RANDOM_FILE}")).unwrap();
    log
}

/// How long the log is now: what was answered by now rests on no more than that.
pub(crate) fn now() -> usize {
    recorder().as_ref().map_or(0, |recorder| recorder.log.len())
}

/// The illness ends, if one is there.
pub(crate) fn cure() {
    if let Some(recorder) = recorder().as_mut() {
        recorder.fault = None;
    }
}

/// Sets the clock that never goes back ahead.
pub(crate) fn pass_ns(by: i64) {
    STANDING_NS.fetch_add(by, Ordering::SeqCst);
}

/// What the clock that never goes back shows \[ns\], where it is ours.
pub(crate) fn standing_ns() -> Option<i64> {
    let shown = STANDING_NS.load(Ordering::SeqCst);
    (shown >= 0).then_some(shown)
}

/// Leads callbacks to this port of this computer.
pub(crate) fn receive_at(port: u16) {
    RECEIVER_PORT.store(port.into(), Ordering::SeqCst);
}

/// Where a callback really goes.
pub(crate) fn receiver_port() -> Option<u16> {
    u16::try_from(RECEIVER_PORT.load(Ordering::SeqCst)).ok().filter(|port| *port != 0)
}

/// Everything below a folder by its path: the bytes of a file, nothing for a folder.
pub(crate) fn tree(root: &Path) -> BTreeMap<String, Option<Vec<u8>>> {
    fn walk(root: &Path, below: &str, into: &mut BTreeMap<String, Option<Vec<u8>>>) {
        for entry in fs::read_dir(root.join(below)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let path = if below.is_empty() { name } else { format!("{below}/{name}") };
            if is_left_out(&path) {
                continue;
            }
            let place = root.join(&path);
            if place.is_dir() {
                into.insert(path.clone(), None);
                walk(root, &path, into);
            } else {
                into.insert(path, Some(fs::read(&place).unwrap()));
            }
        }
    }
    let mut found = BTreeMap::new();
    walk(root, "", &mut found);
    found
}

fn is_left_out(path: &str) -> bool {
    path.ends_with("-shm")
}

/// What is to become of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It is done.
    Well,
    /// It is done as far as this many bytes go.
    Part(usize),
    /// Nothing is done, and this is said.
    Fails(c_int),
    /// So many bytes are written, and this is said.
    BreaksOff(usize, c_int),
}

const EINTR: c_int = 4;
const EIO: c_int = 5;
const ENOSPC: c_int = 28;

/// Beside the folder: what `SQLite` reads in place of the system's random bytes.
const RANDOM_FILE: &str = ".random";
/// More than `SQLite` asks for at a time.
const RANDOM_BYTES: usize = 4096;

impl Recorder {
    /// Where `SQLite` finds random bytes that the seed decides.
    pub(crate) fn random_file(&self) -> String {
        format!("{}{RANDOM_FILE}", self.root)
    }

    /// The path below the folder, where it is one.
    pub(crate) fn below(&self, path: &str) -> Option<String> {
        let rest = path.strip_prefix(self.root.as_str())?;
        let below = if rest.is_empty() { rest } else { rest.strip_prefix('/')? };
        let below = below.trim_end_matches('/');
        (!is_left_out(below)).then(|| below.to_owned())
    }

    /// What the node of an open file is.
    pub(crate) fn node(&self, file: c_int) -> Option<Node> {
        self.open.get(&file).map(|open| open.node)
    }

    /// Whether there is something of this name.
    pub(crate) fn is_there(&self, path: &str) -> bool {
        self.names.contains_key(path)
    }

    fn new_node(&mut self, path: &str) -> Node {
        let node = self.next;
        self.next += 1;
        self.names.insert(path.to_owned(), node);
        node
    }

    fn ill(&mut self) -> Option<(Illness, usize)> {
        let call = self.calls;
        self.calls += 1;
        let fault = self.fault.filter(|fault| (fault.at..fault.at + fault.calls).contains(&call))?;
        if fault.illness == Illness::Slow {
            pass_ns(SLOW_NS);
        }
        Some((fault.illness, call - fault.at))
    }

    /// What becomes of writing so many bytes.
    pub(crate) fn writing(&mut self, bytes: usize) -> Verdict {
        match self.ill() {
            Some((Illness::Full, _)) => Verdict::Fails(ENOSPC),
            Some((Illness::Writing, _)) => Verdict::BreaksOff(bytes / 2, EIO),
            Some((Illness::Interrupted, count)) if count % 2 == 0 => Verdict::Fails(EINTR),
            Some((Illness::Short, _)) if bytes > 1 => Verdict::Part(bytes / 2),
            _ => Verdict::Well,
        }
    }

    /// What becomes of making a file or a folder, or of setting a length.
    pub(crate) fn making(&mut self) -> Verdict {
        match self.ill() {
            Some((Illness::Full, _)) => Verdict::Fails(ENOSPC),
            Some((Illness::Writing, _)) => Verdict::Fails(EIO),
            _ => Verdict::Well,
        }
    }

    /// What becomes of synchronising.
    pub(crate) fn synchronising(&mut self) -> Verdict {
        match self.ill() {
            Some((Illness::Synchronising, _)) => Verdict::Fails(EIO),
            _ => Verdict::Well,
        }
    }

    /// A file or a folder was opened under this name, and emptied where that was asked for.
    pub(crate) fn opened(&mut self, file: c_int, path: &str, emptied: bool) {
        let node = if let Some(node) = self.names.get(path) {
            *node
        } else {
            let node = self.new_node(path);
            self.log.push(Op::Create { node, path: path.to_owned() });
            node
        };
        if emptied {
            self.log.push(Op::Length { node, length: 0 });
        }
        self.open.insert(file, Open { node, path: path.to_owned() });
    }

    /// A file is closed.
    pub(crate) fn closing(&mut self, file: c_int) {
        if self.open.contains_key(&file) {
            self.look_for_renames();
            self.open.remove(&file);
        }
    }

    /// Bytes were written.
    pub(crate) fn wrote(&mut self, file: c_int, at: u64, bytes: &[u8]) {
        if let Some(node) = self.node(file) {
            self.log.push(Op::Write { node, at, bytes: bytes.into() });
        }
    }

    /// A length was set.
    pub(crate) fn cut(&mut self, file: c_int, length: u64) {
        if let Some(node) = self.node(file) {
            self.log.push(Op::Length { node, length });
        }
    }

    /// File or folder was synchronised, or could not be.
    pub(crate) fn synchronised(&mut self, file: c_int, done: bool) {
        self.look_for_renames();
        if let Some(node) = self.node(file) {
            self.log.push(if done { Op::Sync { node } } else { Op::SyncFailed { node } });
        }
    }

    /// A folder was made.
    pub(crate) fn made(&mut self, path: &str) {
        let node = self.new_node(path);
        self.log.push(Op::Folder { node, path: path.to_owned() });
    }

    /// A name was removed.
    pub(crate) fn removed(&mut self, path: &str) {
        self.look_for_renames();
        if self.names.remove(path).is_some() {
            self.log.push(Op::Remove { path: path.to_owned() });
        }
    }

    /// A name was changed.
    pub(crate) fn renamed(&mut self, from: &str, to: &str) {
        if let Some(node) = self.names.remove(from) {
            self.names.insert(to.to_owned(), node);
            self.log.push(Op::Rename { from: from.to_owned(), to: to.to_owned() });
        }
    }

    /// Drafts are renamed by a system call of their own, which no symbol of the C library stands for. The file that was
    /// renamed is still open then: the system says what it is called now. Asked before anything that must come after.
    fn look_for_renames(&mut self) {
        let drafts = self.open.iter().filter(|(_, open)| open.path.starts_with("spool/"));
        let mut found = Vec::new();
        for (file, open) in drafts {
            let Ok(now) = fs::read_link(format!("/proc/self/fd/{file}")) else { continue };
            let now = now.to_str().and_then(|now| self.below(now));
            if let Some(now) = now.filter(|now| *now != open.path && !now.ends_with(" (deleted)")) {
                found.push((*file, open.path.clone(), now));
            }
        }
        for (file, from, to) in found {
            self.renamed(&from, &to);
            if let Some(open) = self.open.get_mut(&file) {
                open.path = to;
            }
        }
    }

    /// Random bytes that the seed decides: for each length a stream of its own, as threads ask in any order.
    pub(crate) fn random(&mut self, into: &mut [u8]) {
        let seed = self.seed;
        let length = into.len();
        let stream = self.random.entry(length).or_insert_with(|| Chance::of(seed, 0x1000 + length as u64));
        for byte in into {
            *byte = stream.bits().to_le_bytes()[0];
        }
    }
}
