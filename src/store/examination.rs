//! Examines a data directory: whether the database is sound, whether every named file exists, and what is left over.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::backup::digested;
use super::stored_file::{is_folder, is_plain_file};
use super::{AuditHead, DATABASE_NAME, DatabaseFile, Deep, Pace, Sha256Hex, StoreError, own_schema};

/// The findings about a database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Examination {
    /// What keeps the rows: its name and version.
    pub engine: (&'static str, String),
    /// The newest schema that this version makes of it.
    pub newest_schema: i64,
    /// The oldest schema that a service must know to use it, if the database says so.
    pub usable_from: Option<i64>,
    /// The settings of the server; `None` for a file.
    pub server: Option<ServerState>,
    /// Schema of the database; `None` if no migration has run.
    pub schema: Option<i64>,
    /// Faults of the database's structure.
    pub structural_faults: Vec<String>,
    /// Rows that refer to missing rows.
    pub broken_references: u64,
    /// Jobs, machines and so on: rows of all tables.
    pub rows: u64,
    /// Whether a machine was ever stored, as at every first start.
    pub was_served: bool,
    /// The files beside it.
    pub files: Files,
    /// Webhooks that are waiting, and those that were given up; `None` in schemas without them.
    pub deliveries: Option<(u64, u64)>,
    /// The findings of reading every row; `None` if that was not requested.
    pub deep: Option<Deep>,
}

/// What is to be said of a server besides its rows, in words.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ServerState {
    /// What loses data, or keeps the service from its start.
    pub faults: Vec<String>,
    /// What is worth knowing.
    pub notes: Vec<String>,
}

/// The depth of an examination.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Depth {
    /// Whether every file is read.
    pub files: bool,
    /// Whether every row is read.
    pub rows: bool,
    /// An entry of the audit log that was recorded elsewhere.
    pub known_head: Option<AuditHead>,
}

/// The findings about the files beside a database.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    /// Number of files that the database names.
    pub named: usize,
    /// Named files that are missing.
    pub missing: Vec<Sha256Hex>,
    /// Files with other bytes.
    pub changed: Vec<PathBuf>,
    /// Files that no row names.
    pub orphans: usize,
    /// Incomplete files: of running requests, or left over.
    pub incomplete: usize,
    /// Whether several services have them together, in the database or in a bucket.
    pub shared: bool,
}

/// Examines a data directory; with `digests` every file is read.
///
/// # Errors
/// The database cannot be opened or read.
pub async fn examine(data_dir: &Path, digests: bool) -> Result<Examination, StoreError> {
    examine_to(data_dir, &Depth { files: digests, ..Depth::default() }).await
}

/// Examines a data directory to this depth.
///
/// # Errors
/// The database cannot be opened or read.
pub async fn examine_to(data_dir: &Path, depth: &Depth) -> Result<Examination, StoreError> {
    let mut file = DatabaseFile::open(&data_dir.join(DATABASE_NAME)).await?;
    let sqlite_version = file.sqlite_version().await?;
    let schema = file.schema().await?;
    let structural_faults = file.structural_faults().await?;
    let broken_references = file.broken_references().await?;
    let counts = file.row_counts().await?;
    let (rows, was_served) = (counts.values().sum(), counts.get("machines").is_some_and(|rows| *rows > 0));
    let deep = if depth.rows || depth.known_head.is_some() {
        file.hold().await?;
        let deep = file.deep(&Pace::unbounded(), depth.known_head.as_ref()).await?;
        file.let_go().await?;
        Some(deep)
    } else {
        None
    };
    // Files are listed first: a file that is named afterwards may have come meanwhile, and is not missing.
    let there = there(data_dir);
    let named = file.named_blobs().await?;
    let deliveries = file.deliveries().await?;
    file.close().await;
    let files = compared(data_dir, &named, &there, depth.files);
    Ok(Examination {
        engine: ("SQLite", sqlite_version),
        newest_schema: own_schema(),
        usable_from: None,
        server: None,
        schema,
        structural_faults,
        broken_references,
        rows,
        was_served,
        files,
        deliveries,
        deep,
    })
}

/// How the names of copies begin that are not complete.
pub(super) const STAGING: &str = ".trunnion-";

/// How many files are stored in a data directory, whether a database names them or not.
#[must_use]
pub fn stored_files(data_dir: &Path) -> usize {
    there(data_dir).len()
}

/// What is stored in a data directory.
pub(super) fn there(data_dir: &Path) -> Vec<PathBuf> {
    files_below(&data_dir.join("blobs"))
}

/// Compares what is stored in a data directory with what a database names.
pub(super) fn compared(
    data_dir: &Path,
    named: &BTreeSet<Sha256Hex>,
    there: &[PathBuf],
    digests: bool,
) -> Files {
    let mut files = Files {
        named: named.len(),
        incomplete: files_below(&data_dir.join("spool")).len(),
        ..Files::default()
    };
    let name = |path: &Path| path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
    files.orphans = there.iter().filter(|path| !named.contains(&name(path))).count();
    for sha256 in named {
        let path = data_dir.join("blobs").join(sha256.get(..2).unwrap_or("00")).join(sha256);
        if !is_plain_file(&path) {
            files.missing.push(sha256.clone());
        } else if digests && !digested(&path).is_ok_and(|found| found.sha256 == *sha256) {
            files.changed.push(path);
        }
    }
    files
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .flat_map(|entry| {
            let path = entry.path();
            if is_folder(&path) { files_below(&path) } else { vec![path] }
        })
        .collect()
}
