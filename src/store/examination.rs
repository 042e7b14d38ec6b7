//! A data directory examined: is the database sound, is every file there that a row names, is anything left over.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::backup::digested;
use super::stored_file::{is_folder, is_plain_file};
use super::{AuditHead, DATABASE_NAME, DatabaseFile, Deep, Pace, Sha256Hex, StoreError};

/// What was found in a database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Examination {
    /// Version of the `SQLite` that read it.
    pub sqlite_version: String,
    /// Its schema; none where no migration ever ran.
    pub schema: Option<i64>,
    /// Faults of its structure.
    pub structural_faults: Vec<String>,
    /// Rows that refer to rows that are not there.
    pub broken_references: u64,
    /// Jobs, machines and so on: rows of all tables.
    pub rows: u64,
    /// Whether a machine was ever stored, as at every first start.
    pub was_served: bool,
    /// The files beside it.
    pub files: Files,
    /// Ends of jobs that are still to be told, and those that were given up; none in schemas without them.
    pub deliveries: Option<(u64, u64)>,
    /// What reading every row has found; none where that was not asked.
    pub deep: Option<Deep>,
}

/// How much is looked at.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Depth {
    /// Every file is read through.
    pub files: bool,
    /// Every row is.
    pub rows: bool,
    /// An entry of the audit log that is known from elsewhere.
    pub known_head: Option<AuditHead>,
}

/// What was found of the files beside a database.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    /// How many the database names.
    pub named: usize,
    /// Those of them that are not there.
    pub missing: Vec<Sha256Hex>,
    /// Those whose bytes are others.
    pub changed: Vec<PathBuf>,
    /// Files that no row names.
    pub orphans: usize,
    /// Files that are not complete: of requests under way, or left over.
    pub incomplete: usize,
}

/// Examines a data directory; with `digests` every file is read through.
///
/// # Errors
/// The database cannot be opened or read.
pub async fn examine(data_dir: &Path, digests: bool) -> Result<Examination, StoreError> {
    examine_to(data_dir, &Depth { files: digests, ..Depth::default() }).await
}

/// Examines a data directory, so deep.
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
    // Files first: what is named afterwards may have come meanwhile, and is not missed.
    let there = files_below(&data_dir.join("blobs"));
    let named = file.named_blobs().await?;
    let deliveries = file.deliveries().await?;
    file.close().await;
    let files = compared(data_dir, &named, &there, depth.files);
    Ok(Examination {
        sqlite_version,
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

/// How many files are stored in a data directory, whether a database names them or not.
#[must_use]
pub fn stored_files(data_dir: &Path) -> usize {
    files_below(&data_dir.join("blobs")).len()
}

fn compared(data_dir: &Path, named: &BTreeSet<Sha256Hex>, there: &[PathBuf], digests: bool) -> Files {
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
