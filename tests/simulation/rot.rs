//! Bytes that rot at rest: a bit of a file flips while nothing runs, and whoever examines the folder is told.

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
const FLIPS: usize = 60;

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

/// Every value of every table; nothing where they cannot be read.
async fn values(data: &Path) -> Option<Vec<String>> {
    let options = SqliteConnectOptions::new().filename(data.join(DATABASE_NAME)).read_only(true);
    let mut database = options.connect().await.ok()?;
    let ask = async |database: &mut SqliteConnection, query: String| {
        sqlx::query_scalar::<_, String>(AssertSqlSafe(query)).fetch_all(database).await.ok()
    };
    let mut all = Vec::new();
    let tables = "SELECT name FROM sqlite_schema WHERE type = 'table' ORDER BY name".to_owned();
    for table in ask(&mut database, tables).await? {
        let columns = ask(&mut database, format!("SELECT name FROM pragma_table_info('{table}')")).await?;
        let quoted: Vec<String> = columns.iter().map(|column| format!("quote(\"{column}\")")).collect();
        let query = format!("SELECT {} FROM \"{table}\"", quoted.join(" || '|' || "));
        all.extend(ask(&mut database, query).await?);
    }
    database.close().await.ok()?;
    all.sort_unstable();
    Some(all)
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

/// `SQLite` keeps no sums of its pages: an examination sees what breaks their structure. What changes a value alone is counted
/// here, so that the figure is known; it is for digests of rows to bring it to nothing.
#[test]
fn a_bit_that_flips_in_the_database_is_said_or_counted() {
    let _alone = alone();
    let run = run(7);
    let mut chance = Chance::of(7, 7);
    let (mut said, mut harmless, mut silent) = (0, 0, 0);
    let runtime = runtime();
    let sound = folder();
    write_out(&run.end, sound.path());
    let expected = runtime.block_on(values(sound.path()));
    assert!(expected.as_ref().is_some_and(|values| values.len() > 50));
    for _ in 0..FLIPS {
        let place = folder();
        write_out(&flipped(&run.end, DATABASE_NAME, &mut chance), place.path());
        if runtime.block_on(is_said(place.path())) {
            said += 1;
        } else if runtime.block_on(values(place.path())) == expected {
            harmless += 1;
        } else {
            silent += 1;
        }
    }
    println!(
        "of {FLIPS} flips {said} are said, {harmless} change no value, {silent} change one and are not said"
    );
    assert!(said > 0, "no flip is said");
}
