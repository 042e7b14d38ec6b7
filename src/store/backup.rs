//! Backups of a data directory: a copy of the database at one moment, every file that it names, and a manifest with
//! lengths, digests and row counts. A backup is complete or does not exist, and so is a restored directory.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::blobs::hex;
use super::examination::STAGING;
use super::lock::LOCK_FILE;
use super::{AuditHead, DatabaseFile, DirectoryLock, LockFault, Pace, Sha256Hex, StoreError, own_schema};

/// Name of the database in a data directory and in a backup.
pub const DATABASE_NAME: &str = "trunnion.sqlite";
const MANIFEST_NAME: &str = "manifest.json";
/// Form of a backup.
const FORMAT: u32 = 1;
/// Folder that the system makes in the root of a new file system.
const FOR_REPAIRS: &str = "lost+found";
/// How often files that jobs release during the copy are searched again.
const ATTEMPTS: usize = 3;

/// Why there is no backup, or why nothing was restored.
#[derive(Debug, Error)]
pub enum BackupFault {
    /// A file or directory could not be read or written.
    #[error("while {doing} {}: {source}", path.display())]
    File {
        /// The action that failed.
        doing: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The database could not be read or copied.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A service has the directory to restore into.
    #[error(transparent)]
    Locked(#[from] LockFault),
    /// The target already exists.
    #[error("{} already exists; nothing was changed; name another directory", .0.display())]
    Occupied(PathBuf),
    /// A directory to restore into has entries.
    #[error(
        "{} is not empty, it holds {found:?}; nothing was changed; move its content away, or name another directory",
        path.display()
    )]
    NotEmpty {
        /// The directory.
        path: PathBuf,
        /// The name of an entry.
        found: String,
    },
    /// The backup would be inside the data directory.
    #[error("{} is inside the data directory, which cannot contain its own backup; name a directory outside it", .0.display())]
    Within(PathBuf),
    /// The directory has no database.
    #[error("there is no database in {}", .0.display())]
    NoDatabase(PathBuf),
    /// The bytes of a file do not match its digest.
    #[error("{} is damaged: its digest is {found}, expected {expected}", path.display())]
    Digest {
        /// The file.
        path: PathBuf,
        /// The digest of its bytes.
        found: Sha256Hex,
        /// The digest under which it was kept.
        expected: Sha256Hex,
    },
    /// The manifest cannot be read.
    #[error("{} is not a manifest of a backup: {source}", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: serde_json::Error,
    },
    /// A backup of another format.
    #[error("the backup has format {found}, but this version reads format {FORMAT}")]
    Format {
        /// The format found.
        found: u32,
    },
    /// The backup comes from a newer version.
    #[error("the backup's database has schema {found}; this version knows schemas up to {ours}")]
    Newer {
        /// Schema of the backup.
        found: i64,
        /// Newest schema of this version.
        ours: i64,
    },
    /// The database has another schema than the manifest states.
    #[error("the backup's database has schema {found}, but its manifest states {expected}")]
    Schema {
        /// Schema of the database.
        found: i64,
        /// Schema in the manifest.
        expected: i64,
    },
    /// A table has another number of rows than the manifest states.
    #[error("the table {table} has {found} rows, but the manifest states {expected}")]
    Rows {
        /// The table.
        table: String,
        /// Rows found.
        found: u64,
        /// Rows expected.
        expected: u64,
    },
    /// The audit log has another end than the manifest states.
    #[error("the backup's audit log ends at {}, but its manifest states {}", end_of(found.as_ref()), end_of(expected.as_ref()))]
    AuditHead {
        /// The last entry of the database.
        found: Option<AuditHead>,
        /// The entry in the manifest.
        expected: Option<AuditHead>,
    },
    /// The backup lacks a file that the database names.
    #[error("the file {0} is missing from the backup, but a job needs it")]
    Missing(Sha256Hex),
    /// The database is damaged.
    #[error("the database is damaged: {0}")]
    Damaged(String),
    /// A file that jobs name is missing, however often the database was copied again.
    #[error("{} is missing, but a job needs it; restore it from an earlier backup; trunnion doctor lists all missing files", .0.display())]
    Lost(PathBuf),
    /// Jobs released files during every copy.
    #[error("the service removed files during the copy {ATTEMPTS} times, the last one {}; try again", .0.display())]
    Unquiet(PathBuf),
}

fn at<'a>(doing: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> BackupFault + 'a {
    move |source| BackupFault::File { doing, path: path.to_owned(), source }
}

/// One file of a backup.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BackupFile {
    /// Length of the file.
    pub bytes: u64,
    /// Digest of the file.
    pub sha256: Sha256Hex,
}

/// The content of a backup.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Form of the backup.
    pub format: u32,
    /// Version that made the backup.
    pub software_version: String,
    /// Time of the backup.
    pub created_at: String,
    /// Schema of the database.
    pub schema: i64,
    /// The last entry of the audit log; it shows later whether the log was rewritten. Missing in schemas without a
    /// chain, and without entries.
    #[serde(default)]
    pub audit_head: Option<AuditHead>,
    /// Rows of every table.
    pub rows: BTreeMap<String, u64>,
    /// Every file, by its path within the backup.
    pub files: BTreeMap<String, BackupFile>,
}

/// Backs up a data directory into `target`, which must not exist. A service may run meanwhile.
///
/// # Errors
/// Why there is no backup; `target` does not exist then.
pub async fn back_up(data_dir: &Path, target: &Path, created_at: String) -> Result<Manifest, BackupFault> {
    if target.symlink_metadata().is_ok() {
        return Err(BackupFault::Occupied(target.to_owned()));
    }
    let database = data_dir.join(DATABASE_NAME);
    if !database.is_file() {
        return Err(BackupFault::NoDatabase(data_dir.to_owned()));
    }
    if lies_within(target, data_dir)? {
        return Err(BackupFault::Within(target.to_owned()));
    }
    let mut vanished: Vec<PathBuf> = Vec::new();
    for _ in 0..ATTEMPTS {
        let staging = staging_beside(target)?;
        let copy = staging.path().join(DATABASE_NAME);
        let mut file = DatabaseFile::open(&database).await?;
        let copied = file.copy_to(&copy).await;
        file.close().await;
        copied?;
        let Examined { rows, schema, named, audit_head } = examined(&copy).await?;
        let mut files = BTreeMap::new();
        files.insert(DATABASE_NAME.to_owned(), digested(&copy)?);
        File::open(&copy).and_then(|file| file.sync_all()).map_err(at("synchronising", &copy))?;
        if let Some(gone) = copy_blobs(&named, data_dir, staging.path(), &mut files)? {
            vanished.push(gone);
        } else {
            let software_version = env!("CARGO_PKG_VERSION").to_owned();
            let manifest =
                Manifest { format: FORMAT, software_version, created_at, schema, audit_head, rows, files };
            let text = serde_json::to_vec_pretty(&manifest).unwrap_or_default();
            write_whole(&staging.path().join(MANIFEST_NAME), &text)?;
            settle(staging, target)?;
            return Ok(manifest);
        }
    }
    let last = vanished.pop().unwrap_or_default();
    // Each copy of the database is newer than the file's removal before it: a file that it still names was not
    // released.
    Err(if vanished.contains(&last) { BackupFault::Lost(last) } else { BackupFault::Unquiet(last) })
}

/// Whether a place that does not exist yet is in this directory.
fn lies_within(target: &Path, data_dir: &Path) -> Result<bool, BackupFault> {
    let data_dir = data_dir.canonicalize().map_err(at("looking for", data_dir))?;
    let mut there = target.ancestors().skip(1).map(|folder| {
        // The last ancestor of a relative path is the working directory.
        if folder == Path::new("") { Path::new(".") } else { folder }
    });
    let nearest = there.find_map(|folder| folder.canonicalize().ok());
    Ok(nearest.is_some_and(|folder| folder.starts_with(&data_dir)))
}

/// Restores a backup into a data directory that is empty or missing. An empty one stays, and may be a mount point. Everything is verified before the first byte is
/// moved to its place.
///
/// # Errors
/// Why nothing was restored; the data directory is unchanged then.
pub async fn restore(backup: &Path, data_dir: &Path) -> Result<Manifest, BackupFault> {
    // Held to the end, so that no service starts in the directory meanwhile.
    let held = data_dir.is_dir().then(|| DirectoryLock::take_without_file(data_dir)).transpose()?;
    let exists = is_empty_directory(data_dir)?;
    let manifest_path = backup.join(MANIFEST_NAME);
    let mut text = Vec::new();
    opened(&manifest_path)?.read_to_end(&mut text).map_err(at("reading", &manifest_path))?;
    let manifest: Manifest = serde_json::from_slice(&text)
        .map_err(|source| BackupFault::Manifest { path: manifest_path.clone(), source })?;
    if manifest.format != FORMAT {
        return Err(BackupFault::Format { found: manifest.format });
    }
    // A directory that exists stays, because it may be a mount point, and its parent another file system.
    let staging = if exists { staging_in(data_dir)? } else { staging_beside(data_dir)? };
    for (name, expected) in &manifest.files {
        // Names come from a file: only names that a backup can have are followed.
        if name != DATABASE_NAME && blob_name(&expected.sha256) != *name {
            let source = serde::de::Error::custom(format!("{name:?} is not a file of a backup"));
            return Err(BackupFault::Manifest { path: manifest_path, source });
        }
        let from = backup.join(name);
        let found = copy_whole(&from, &staging.path().join(name))?;
        if found != *expected {
            let expected = expected.sha256.clone();
            return Err(BackupFault::Digest { path: from, found: found.sha256, expected });
        }
    }
    let Examined { rows, schema, named, audit_head } = examined(&staging.path().join(DATABASE_NAME)).await?;
    if schema > own_schema() {
        return Err(BackupFault::Newer { found: schema, ours: own_schema() });
    }
    if schema != manifest.schema {
        return Err(BackupFault::Schema { found: schema, expected: manifest.schema });
    }
    // Backups of earlier versions do not contain it.
    if manifest.audit_head.is_some() && manifest.audit_head != audit_head {
        return Err(BackupFault::AuditHead { found: audit_head, expected: manifest.audit_head });
    }
    for table in rows.keys().chain(manifest.rows.keys()) {
        let [found, expected] = [&rows, &manifest.rows].map(|rows| rows.get(table).copied().unwrap_or(0));
        if found != expected {
            return Err(BackupFault::Rows { table: table.clone(), found, expected });
        }
    }
    if let Some(missing) = named.into_iter().find(|sha256| !manifest.files.contains_key(&blob_name(sha256))) {
        return Err(BackupFault::Missing(missing));
    }
    if exists {
        settle_within(&staging, data_dir)?;
    } else {
        settle(staging, data_dir)?;
    }
    drop(held);
    Ok(manifest)
}

/// Whether a directory exists, which must then be empty. The folder that a new file system has for its own repairs does
/// not count.
fn is_empty_directory(path: &Path) -> Result<bool, BackupFault> {
    match content_of(path) {
        Ok(None) => Ok(true),
        Ok(Some(found)) => Err(BackupFault::NotEmpty { path: path.to_owned(), found }),
        Err(fault) if fault.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(fault) => Err(at("reading", path)(fault)),
    }
}

/// The name of something in a directory, if it is not empty. The folder for repairs of a file system does not count,
/// and a service that did not start leaves its lock file.
///
/// # Errors
/// The directory cannot be read.
pub fn content_of(directory: &Path) -> io::Result<Option<String>> {
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name();
        if name != FOR_REPAIRS && name != LOCK_FILE {
            return Ok(Some(name.to_string_lossy().into_owned()));
        }
    }
    Ok(None)
}

/// Rows, schema, named files and end of the audit log of a sound database.
pub(super) struct Examined {
    rows: BTreeMap<String, u64>,
    schema: i64,
    pub(super) named: BTreeSet<Sha256Hex>,
    audit_head: Option<AuditHead>,
}

fn end_of(head: Option<&AuditHead>) -> String {
    head.map_or_else(|| "no entry".to_owned(), ToString::to_string)
}

/// Reads every row. The first finding is an error: such a database is not sound.
pub(super) async fn examined(database: &Path) -> Result<Examined, BackupFault> {
    let mut file = DatabaseFile::open(database).await?;
    if let Some(fault) = file.structural_faults().await?.into_iter().next() {
        return Err(BackupFault::Damaged(fault));
    }
    let broken = file.broken_references().await?;
    if broken > 0 {
        return Err(BackupFault::Damaged(format!("{broken} rows refer to missing rows")));
    }
    let deep = file.deep(&Pace::unbounded(), None).await?;
    if let Some(first) = deep.faults().into_iter().next() {
        return Err(BackupFault::Damaged(format!("{first} (trunnion doctor --deep lists all damage)")));
    }
    let examined = Examined {
        rows: file.row_counts().await?,
        schema: file.schema().await?.unwrap_or_default(),
        named: file.named_blobs().await?,
        audit_head: deep.audit.and_then(|chain| chain.head),
    };
    file.close().await;
    Ok(examined)
}

/// Copies every named file; returns the missing one, if there is one.
fn copy_blobs(
    named: &BTreeSet<Sha256Hex>,
    data_dir: &Path,
    target: &Path,
    files: &mut BTreeMap<String, BackupFile>,
) -> Result<Option<PathBuf>, BackupFault> {
    for sha256 in named {
        let name = blob_name(sha256);
        let from = data_dir.join(&name);
        let copied = match copy_whole(&from, &target.join(&name)) {
            Err(BackupFault::File { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Ok(Some(from));
            }
            copied => copied?,
        };
        if copied.sha256 != *sha256 {
            return Err(BackupFault::Digest { path: from, found: copied.sha256, expected: sha256.clone() });
        }
        files.insert(name, copied);
    }
    Ok(None)
}

/// Path of a kept file within a data directory.
fn blob_name(sha256: &str) -> String {
    format!("blobs/{}/{sha256}", sha256.get(..2).unwrap_or("00"))
}

/// A directory beside `target`, on its file system; it is removed unless it is settled.
fn staging_beside(target: &Path) -> Result<tempfile::TempDir, BackupFault> {
    let parent = match target.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(at("making", parent))?;
    staging_in(parent)
}

fn staging_in(folder: &Path) -> Result<tempfile::TempDir, BackupFault> {
    let made = tempfile::Builder::new().prefix(STAGING).tempdir_in(folder);
    made.map_err(at("making a directory in", folder))
}

fn sync(path: &Path) -> Result<(), BackupFault> {
    File::open(path).and_then(|folder| folder.sync_all()).map_err(at("synchronising", path))
}

/// Brings everything to the disk, then renames it.
fn settle(staging: tempfile::TempDir, target: &Path) -> Result<(), BackupFault> {
    sync_all(staging.path())?;
    fs::rename(staging.path(), target).map_err(at("moving the copy to", target))?;
    // It has another name now, so there is nothing left to remove.
    let _moved = staging.keep();
    match target.parent() {
        Some(parent) if parent != Path::new("") => sync(parent),
        _ => sync(Path::new(".")),
    }
}

/// Brings everything to the disk, then moves it into the directory that it is in. The database comes last: a service
/// does not start on files without their database.
fn settle_within(staging: &tempfile::TempDir, directory: &Path) -> Result<(), BackupFault> {
    sync_all(staging.path())?;
    let listed = fs::read_dir(staging.path()).and_then(Iterator::collect::<io::Result<Vec<_>>>);
    let listed = listed.map_err(at("reading", staging.path()))?;
    let (database, files): (Vec<_>, Vec<_>) =
        listed.into_iter().map(|entry| entry.file_name()).partition(|name| name == DATABASE_NAME);
    let mut moved = Vec::new();
    let mut place = |name: &OsString| {
        let to = directory.join(name);
        fs::rename(staging.path().join(name), &to).map_err(at("moving the copy to", &to))?;
        moved.push(name.clone());
        sync(directory)
    };
    let placed = files.iter().chain(&database).try_for_each(&mut place);
    if placed.is_err() {
        for name in moved {
            // They are removed with the staging directory.
            let _back = fs::rename(directory.join(&name), staging.path().join(&name));
        }
    }
    placed
}

/// Brings the files of a copy to the disk.
fn sync_all(copy: &Path) -> Result<(), BackupFault> {
    let blobs = copy.join("blobs");
    let listed = match fs::read_dir(&blobs) {
        Ok(listed) => listed.collect::<Result<Vec<_>, _>>().map_err(at("reading", &blobs))?,
        Err(_no_blobs) => Vec::new(),
    };
    for folder in &listed {
        sync(&folder.path())?;
    }
    if !listed.is_empty() {
        sync(&blobs)?;
    }
    sync(copy)
}

fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), BackupFault> {
    let mut file = File::create(path).map_err(at("making", path))?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(at("writing", path))
}

fn copy_whole(from: &Path, to: &Path) -> Result<BackupFile, BackupFault> {
    let mut source = opened(from)?;
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(at("making", folder))?;
    }
    let mut target = File::create_new(to).map_err(at("making", to))?;
    let copied = through(&mut source, |bytes| target.write_all(bytes)).map_err(at("copying", from))?;
    target.sync_all().map_err(at("synchronising", to))?;
    Ok(copied)
}

/// Opens a file for reading. A link is not followed, and a pipe is not opened, because that would wait for a writer.
fn opened(path: &Path) -> Result<File, BackupFault> {
    let found = fs::symlink_metadata(path).map_err(at("opening", path))?;
    if !found.is_file() {
        return Err(at("opening", path)(io::Error::other("this is not a regular file")));
    }
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
    File::options().read(true).custom_flags(flags).open(path).map_err(at("opening", path))
}

/// Length and digest of a file.
pub(super) fn digested(path: &Path) -> Result<BackupFile, BackupFault> {
    through(&mut opened(path)?, |_| Ok(())).map_err(at("reading", path))
}

fn through(source: &mut File, mut each: impl FnMut(&[u8]) -> io::Result<()>) -> io::Result<BackupFile> {
    let (mut hasher, mut bytes, mut buffer) = (Sha256::new(), 0, vec![0; 1 << 18]);
    loop {
        let read = source.read(&mut buffer)?;
        let Some(part) = buffer.get(..read).filter(|part| !part.is_empty()) else { break };
        hasher.update(part);
        bytes += read as u64;
        each(part)?;
    }
    Ok(BackupFile { bytes, sha256: hex(&hasher.finalize()) })
}
