//! Bytes that rot at rest: a bit of a file flips while nothing runs, and whoever examines the folder is told.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection};
use trunnion::store::{DATABASE_NAME, Deep};

use crate::chance::Chance;
use crate::disk::Tree;
use crate::run::{alone, run, runtime, write_out};
use crate::verify::examined;
use crate::world::folder;

/// Bits that flip of files, and of the database.
const FLIPS: usize = 30;

/// The tree with one bit of a file other than it was.
fn flipped(tree: &Tree, path: &str, chance: &mut Chance) -> Tree {
    let mut tree = tree.clone();
    if let Some(Some(bytes)) = tree.get_mut(path) {
        let at = chance.below(bytes.len());
        bytes[at] ^= 1 << chance.below(8);
    }
    tree
}

/// Whether an examination says that something is wrong.
async fn is_said(data: &Path) -> bool {
    match examined(data).await {
        Err(_) => true,
        Ok(found) => {
            let files = &found.files;
            let rows = found.deep.iter().flat_map(Deep::faults).count();
            let wrong = [files.missing.len(), files.changed.len(), found.structural_faults.len(), rows];
            found.broken_references > 0 || wrong.iter().any(|count| *count > 0)
        }
    }
}

/// What has a digest that stands beside it. Where the column is `None`, every column is compared with what has one:
/// the chain of the audit log, the documents of calibrations.
const DIGESTED: [(&str, Option<&str>); 12] = [
    ("machine_revisions", Some("profile")),
    ("machine_revisions", Some("sha256")),
    ("tool_revisions", Some("document")),
    ("tool_revisions", Some("sha256")),
    ("calibrations", Some("run")),
    ("calibrations", Some("run_sha256")),
    ("calibrations", Some("document")),
    ("calibrations", Some("document_sha256")),
    ("jobs", Some("report")),
    ("jobs", Some("report_sha256")),
    ("audit", None),
    ("calibration_errors", None),
];

/// The values of a table's column, in the order in which they sort.
type Columns = BTreeMap<(String, String), Vec<String>>;

/// Every value of every table; nothing where they cannot be read.
async fn values(data: &Path) -> Option<Columns> {
    let options = SqliteConnectOptions::new().filename(data.join(DATABASE_NAME)).read_only(true);
    let mut database = options.connect().await.ok()?;
    let ask = async |database: &mut SqliteConnection, query: String| {
        sqlx::query_scalar::<_, String>(AssertSqlSafe(query)).fetch_all(database).await.ok()
    };
    let mut all = Columns::new();
    let tables = "SELECT name FROM sqlite_schema WHERE type = 'table' ORDER BY name".to_owned();
    for table in ask(&mut database, tables).await? {
        for column in ask(&mut database, format!("SELECT name FROM pragma_table_info('{table}')")).await? {
            let query = format!("SELECT quote(\"{column}\") FROM \"{table}\" ORDER BY 1");
            let found = ask(&mut database, query).await?;
            all.insert((table.clone(), column), found);
        }
    }
    database.close().await.ok()?;
    Some(all)
}

/// The columns whose values differ.
fn differing(expected: &Columns, found: &Columns) -> Vec<(String, String)> {
    let names: BTreeSet<_> = expected.keys().chain(found.keys()).cloned().collect();
    names.into_iter().filter(|name| expected.get(name) != found.get(name)).collect()
}

#[test]
fn a_bit_that_flips_in_a_file_is_said() {
    let _alone = alone();
    let run = run(7);
    let mut chance = Chance::of(7, 6);
    let files: Vec<&String> = run
        .end
        .iter()
        .filter(|(path, bytes)| {
            path.starts_with("blobs/") && bytes.as_ref().is_some_and(|bytes| !bytes.is_empty())
        })
        .map(|(path, _)| path)
        .collect();
    assert!(files.len() > 3, "{files:?}");
    for _ in 0..FLIPS {
        let path = (*chance.pick(&files)).clone();
        let place = folder();
        write_out(&flipped(&run.end, &path, &mut chance), place.path());
        assert!(runtime().block_on(is_said(place.path())), "{path} has other bytes and nobody says so");
    }
}

/// `SQLite` keeps no sums of its pages: an examination sees what breaks their structure, and by the digests what
/// changes a value that has one. What changes another value is counted here, so that the figure is known.
#[test]
fn a_bit_that_flips_in_the_database_is_said_where_a_digest_stands_for_it() {
    let _alone = alone();
    let run = run(7);
    let mut chance = Chance::of(7, 7);
    let (mut said, mut harmless, mut silent) = (0, 0, Vec::new());
    let runtime = runtime();
    let sound = folder();
    write_out(&run.end, sound.path());
    let expected = runtime.block_on(values(sound.path())).unwrap();
    assert!(expected.values().map(Vec::len).sum::<usize>() > 500);
    for _ in 0..FLIPS {
        let place = folder();
        write_out(&flipped(&run.end, DATABASE_NAME, &mut chance), place.path());
        if runtime.block_on(is_said(place.path())) {
            said += 1;
            continue;
        }
        match runtime.block_on(values(place.path())) {
            Some(found) if found == expected => harmless += 1,
            Some(found) => silent.push(differing(&expected, &found)),
            None => silent.push(vec![("the database".to_owned(), "cannot be read".to_owned())]),
        }
    }
    println!(
        "of {FLIPS} flips {said} are said, {harmless} change no value, {} change one and are not said: {silent:?}",
        silent.len()
    );
    assert!(said > 0, "no flip is said");
    for (table, column) in silent.iter().flatten() {
        let is_digested =
            DIGESTED.iter().any(|(other, only)| other == table && only.is_none_or(|only| only == column));
        assert!(!is_digested && table != "the database", "{table}.{column} has changed and nobody says so");
    }
}
