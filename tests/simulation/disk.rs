//! A disk as POSIX promises it and no better: what a log leaves after a power cut.
//!
//! Bytes of a file are there once the file was synchronised, and a name once its folder was; each without the other.
//! What was not synchronised is there or not, in any order, whole or torn. A synchronisation that failed makes
//! nothing durable later on, as Linux forgets that the pages were dirty; the names of a folder are in the journal,
//! and a later one does. One thing is taken for granted, as `SQLite` takes it: bytes beside those that are written
//! stay as they are.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::chance::Chance;
use crate::recorder::{Node, Op, ROOT};

/// Everything below the folder: bytes of files, nothing for folders.
pub(crate) type Tree = BTreeMap<String, Option<Vec<u8>>>;

/// How the process or its disk ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Crash {
    /// The process is killed: the system keeps what it was given.
    Killed,
    /// Power is cut: nothing is there that was not synchronised.
    Dropped,
    /// Power is cut: all is there, but the last write is torn at a sector of 512 bytes.
    TornSector,
    /// Power is cut: all is there, but the last write is torn anywhere.
    TornByte,
    /// Power is cut: of what was not synchronised each write and each name is there or not, one of them torn.
    Reordered,
    /// The same with other luck.
    ReorderedAgain,
    /// Power is cut: names are there, bytes that were not synchronised are not.
    BytesLost,
    /// Power is cut: bytes are there, names that were not synchronised are not.
    NamesLost,
    /// Power is cut: files have their lengths, and zeros where bytes were not synchronised.
    Zeroed,
}

impl Crash {
    pub(crate) const ALL: [Self; 9] = [
        Self::Killed,
        Self::Dropped,
        Self::TornSector,
        Self::TornByte,
        Self::Reordered,
        Self::ReorderedAgain,
        Self::BytesLost,
        Self::NamesLost,
        Self::Zeroed,
    ];
}

/// A change of a file that was not synchronised.
#[derive(Debug, Clone)]
enum Change {
    Write { at: usize, bytes: Arc<[u8]> },
    Length(usize),
}

impl Change {
    fn apply(&self, to: &mut Vec<u8>) {
        match self {
            Self::Write { at, bytes } => put(to, *at, bytes),
            Self::Length(length) => to.resize(*length, 0),
        }
    }
}

fn put(to: &mut Vec<u8>, at: usize, bytes: &[u8]) {
    if to.len() < at + bytes.len() {
        to.resize(at + bytes.len(), 0);
    }
    to[at..at + bytes.len()].copy_from_slice(bytes);
}

#[derive(Debug, Clone, Default)]
struct File {
    /// What is on the disk for certain.
    durable: Vec<u8>,
    /// What the system holds.
    held: Vec<u8>,
    pending: Vec<Change>,
}

#[derive(Debug, Clone, Default)]
struct Folder {
    durable: BTreeMap<String, Node>,
    held: BTreeMap<String, Node>,
    /// What each name has stood for since the folder was synchronised, the oldest first; the last is what it stands
    /// for.
    pending: BTreeMap<String, Vec<Option<Node>>>,
}

/// The disk after some of a log.
#[derive(Debug, Clone)]
pub(crate) struct Disk {
    files: BTreeMap<Node, File>,
    folders: BTreeMap<Node, Folder>,
    last_write: Option<Node>,
}

impl Disk {
    /// A disk on which all of this is durable. Nodes are given as the recorder gives them.
    pub(crate) fn holding(tree: &Tree) -> Self {
        let mut disk = Self {
            files: BTreeMap::new(),
            folders: BTreeMap::from([(ROOT, Folder::default())]),
            last_write: None,
        };
        for (node, (path, bytes)) in (1..).zip(tree) {
            if let Some(bytes) = bytes {
                let file = File { durable: bytes.clone(), held: bytes.clone(), pending: Vec::new() };
                disk.files.insert(node, file);
            } else {
                disk.folders.insert(node, Folder::default());
            }
            let (folder, name) = disk.place(path).unwrap();
            let folder = disk.folders.get_mut(&folder).unwrap();
            folder.durable.insert(name.clone(), node);
            folder.held.insert(name, node);
        }
        disk
    }

    /// The folder that a path lies in, and its name there.
    fn place(&self, path: &str) -> Option<(Node, String)> {
        let (parent, name) = path.rsplit_once('/').unwrap_or(("", path));
        let mut folder = ROOT;
        for part in parent.split('/').filter(|part| !part.is_empty()) {
            folder = *self.folders.get(&folder)?.held.get(part)?;
        }
        Some((folder, name.to_owned()))
    }

    fn name(&mut self, path: &str, node: Option<Node>) -> Option<Node> {
        let (folder, name) = self.place(path)?;
        let folder = self.folders.get_mut(&folder)?;
        let before = folder.held.get(&name).copied();
        match node {
            Some(node) => folder.held.insert(name.clone(), node),
            None => folder.held.remove(&name),
        };
        folder.pending.entry(name).or_default().push(node);
        before
    }

    /// Does what the log says next.
    pub(crate) fn step(&mut self, op: &Op) {
        match op {
            Op::Create { node, path } => {
                self.files.insert(*node, File::default());
                self.name(path, Some(*node));
            }
            Op::Folder { node, path } => {
                self.folders.insert(*node, Folder::default());
                self.name(path, Some(*node));
            }
            Op::Write { node, at, bytes } => {
                let change = Change::Write { at: usize::try_from(*at).unwrap(), bytes: Arc::clone(bytes) };
                self.change(*node, change);
            }
            Op::Length { node, length } => {
                self.change(*node, Change::Length(usize::try_from(*length).unwrap()));
            }
            Op::Rename { from, to } => {
                if let Some(node) = self.name(from, None) {
                    self.name(to, Some(node));
                }
            }
            Op::Remove { path } => {
                self.name(path, None);
            }
            Op::Sync { node } => self.sync(*node),
            Op::SyncFailed { node } => {
                if let Some(file) = self.files.get_mut(node) {
                    file.pending.clear();
                }
            }
            Op::Nothing => {}
        }
    }

    fn change(&mut self, node: Node, change: Change) {
        if let Some(file) = self.files.get_mut(&node) {
            change.apply(&mut file.held);
            file.pending.push(change);
            self.last_write = Some(node);
        }
    }

    fn sync(&mut self, node: Node) {
        if let Some(file) = self.files.get_mut(&node) {
            for change in std::mem::take(&mut file.pending) {
                change.apply(&mut file.durable);
            }
        }
        if let Some(folder) = self.folders.get_mut(&node) {
            for (name, history) in std::mem::take(&mut folder.pending) {
                match history.last() {
                    Some(Some(node)) => folder.durable.insert(name, *node),
                    _ => folder.durable.remove(&name),
                };
            }
        }
    }

    /// What the system holds: the disk without a crash.
    pub(crate) fn held(&self) -> Tree {
        self.tree(&|folder: &Folder| folder.held.clone(), &|_node, file: &File| file.held.clone())
    }

    /// What is there after a crash.
    pub(crate) fn after(&self, crash: Crash, chance: &mut Chance) -> Tree {
        let held = |folder: &Folder| folder.held.clone();
        let durable = |folder: &Folder| folder.durable.clone();
        match crash {
            Crash::Killed => self.held(),
            Crash::Dropped => self.tree(&durable, &|_node, file| file.durable.clone()),
            Crash::TornSector | Crash::TornByte => {
                let (sector, luck) = (if crash == Crash::TornSector { 512 } else { 1 }, chance.bits());
                self.tree(&held, &|node, file| {
                    if self.last_write == Some(node) { torn(file, sector, luck) } else { file.held.clone() }
                })
            }
            Crash::Reordered | Crash::ReorderedAgain => {
                let mut names = BTreeMap::new();
                for (node, folder) in &self.folders {
                    names.insert(*node, some_names(folder, chance));
                }
                let mut bytes = BTreeMap::new();
                for (node, file) in self.files.iter().filter(|(_, file)| !file.pending.is_empty()) {
                    bytes.insert(*node, some_bytes(file, chance));
                }
                self.walk(&|node| names[&node].clone(), &|node, file| {
                    bytes.get(&node).unwrap_or(&file.durable).clone()
                })
            }
            Crash::BytesLost => self.tree(&held, &|_node, file| file.durable.clone()),
            Crash::NamesLost => self.tree(&durable, &|_node, file| file.held.clone()),
            Crash::Zeroed => self.tree(&held, &|_node, file| {
                let mut bytes = file.durable.clone();
                bytes.resize(file.held.len(), 0);
                bytes
            }),
        }
    }

    fn tree(
        &self,
        names: &dyn Fn(&Folder) -> BTreeMap<String, Node>,
        bytes: &dyn Fn(Node, &File) -> Vec<u8>,
    ) -> Tree {
        self.walk(&|node| names(&self.folders[&node]), bytes)
    }

    fn walk(
        &self,
        names: &dyn Fn(Node) -> BTreeMap<String, Node>,
        bytes: &dyn Fn(Node, &File) -> Vec<u8>,
    ) -> Tree {
        let (mut found, mut open) = (Tree::new(), vec![(String::new(), ROOT)]);
        while let Some((below, folder)) = open.pop() {
            for (name, node) in names(folder) {
                let path = if below.is_empty() { name } else { format!("{below}/{name}") };
                if let Some(file) = self.files.get(&node) {
                    found.insert(path, Some(bytes(node, file)));
                } else if self.folders.contains_key(&node) {
                    open.push((path.clone(), node));
                    found.insert(path, None);
                }
            }
        }
        found
    }
}

/// The file with the last of its pending changes done in part.
fn torn(file: &File, sector: usize, luck: u64) -> Vec<u8> {
    let Some((last, before)) = file.pending.split_last() else { return file.held.clone() };
    let mut bytes = file.durable.clone();
    for change in before {
        change.apply(&mut bytes);
    }
    if let Change::Write { at, bytes: written } = last {
        let parts = written.len().div_ceil(sector);
        let kept = usize::try_from(luck).unwrap_or(usize::MAX) % parts.max(1) * sector;
        put(&mut bytes, *at, &written[..kept.min(written.len())]);
    }
    bytes
}

/// Each name as it was at any time since its folder was synchronised.
fn some_names(folder: &Folder, chance: &mut Chance) -> BTreeMap<String, Node> {
    let mut names = folder.durable.clone();
    for (name, history) in &folder.pending {
        match chance.below(history.len() + 1).checked_sub(1).map(|at| history[at]) {
            None => {}
            Some(Some(node)) => {
                names.insert(name.clone(), node);
            }
            Some(None) => {
                names.remove(name);
            }
        }
    }
    names
}

/// Each pending change done or not, and one write of those that are done torn.
fn some_bytes(file: &File, chance: &mut Chance) -> Vec<u8> {
    let mut bytes = file.durable.clone();
    let torn = chance.below(file.pending.len());
    for (at, change) in file.pending.iter().enumerate() {
        match change {
            _ if chance.one_in(2) => {}
            Change::Write { at: place, bytes: written } if at == torn => {
                put(&mut bytes, *place, &written[..chance.below(written.len() + 1)]);
            }
            done => done.apply(&mut bytes),
        }
    }
    bytes
}
