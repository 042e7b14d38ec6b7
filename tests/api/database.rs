//! The database of a test: a file in its data directory, or a schema of its own on the server that
//! `TRUNNION_TEST_DATABASE` names (`tests/postgres/run`).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection};
use trunnion::config::{FilesIn, Settings};

/// Directories of services on the server.
static ON_THE_SERVER: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The server, if the services of this run use one.
pub(crate) fn server() -> Option<String> {
    std::env::var("TRUNNION_TEST_DATABASE").ok().filter(|_| cfg!(feature = "scale-out"))
}

/// Whether a test has to be left out because it opens or copies the file of the database. It says so.
pub(crate) fn has_no_file(test: &str) -> bool {
    let left_out = server().is_some();
    if left_out {
        eprintln!("left out, because the database is no file: {test}");
    }
    left_out
}

/// Names the database of a data directory in the settings. A directory that is opened again has the same one.
pub(crate) fn choose(settings: &mut Settings) {
    put_on_the_server(&settings.data_dir);
    settings.database = address_of(&settings.data_dir).map(|address| address.parse().unwrap());
    settings.files_endpoint = bucket_server();
    if settings.database.is_some()
        && let Ok(files) = std::env::var("TRUNNION_TEST_FILES")
    {
        settings.files = files.parse().unwrap();
    }
}

/// The address of the server of the bucket, if this run has one (`tests/s3/with-server`).
pub(crate) fn bucket_server() -> Option<String> {
    std::env::var("TRUNNION_TEST_S3").ok().filter(|_| server().is_some())
}

/// Where services that share a database keep their files: in the bucket, if this run has one.
pub(crate) fn shared_place() -> FilesIn {
    match std::env::var("TRUNNION_TEST_FILES") {
        Ok(files) if bucket_server().is_some() => files.parse().unwrap(),
        _ => FilesIn::Postgres,
    }
}

/// Every place where a service on the server of this run can keep its files.
pub(crate) fn places() -> Vec<FilesIn> {
    let mut places = vec![FilesIn::Directory, FilesIn::Postgres];
    places.extend(Some(shared_place()).filter(|_| bucket_server().is_some()));
    places
}

/// From now on commands use the database of this data directory on the server, if this run has one.
pub(crate) fn put_on_the_server(data: &Path) {
    if server().is_some() {
        ask(&format!("CREATE SCHEMA IF NOT EXISTS {}", schema_of(data)));
        ON_THE_SERVER.lock().unwrap().insert(data.to_owned());
    }
}

/// The address of the database of a data directory, if a service of this run has it on the server.
pub(crate) fn address_of(data: &Path) -> Option<String> {
    ON_THE_SERVER.lock().unwrap().contains(data).then_some(())?;
    Some(format!("{}?options[search_path]={}", server()?, schema_of(data)))
}

/// The schema of a data directory.
pub(crate) fn schema_of(data: &Path) -> String {
    let digest = trunnion::store::sha256_hex(data.to_string_lossy().as_bytes());
    format!("t_{}", &digest[..24])
}

/// The answer of the server to a statement.
pub(crate) fn ask(text: &str) -> String {
    psql(text, "public").unwrap()
}

fn psql(text: &str, schema: &str) -> Result<String, String> {
    let mut call = Command::new("psql");
    call.args(["-XAt", "-v", "ON_ERROR_STOP=1", "-c", text]).arg(server().unwrap());
    let done = call.env("PGOPTIONS", format!("-c search_path={schema}")).output().unwrap();
    if done.status.success() {
        Ok(String::from_utf8(done.stdout).unwrap().trim().to_owned())
    } else {
        Err(String::from_utf8_lossy(&done.stderr).into_owned())
    }
}

async fn file_of(data: &Path) -> SqliteConnection {
    SqliteConnectOptions::new().filename(data.join("trunnion.sqlite")).connect().await.unwrap()
}

/// Changes rows behind the back of the service of a data directory. The number of rows, or the refusal.
pub(crate) async fn change(data: &Path, statement: &str) -> Result<u64, String> {
    if address_of(data).is_some() {
        let done = psql(statement, &schema_of(data))?;
        return Ok(done.rsplit(' ').next().and_then(|count| count.parse().ok()).unwrap_or(0));
    }
    let mut file = file_of(data).await;
    let done = sqlx::query(AssertSqlSafe(statement.to_owned())).execute(&mut file).await;
    file.close().await.unwrap();
    done.map(|done| done.rows_affected()).map_err(|fault| fault.to_string())
}

/// The one text that a query gives.
pub(crate) async fn value(data: &Path, query: &str) -> String {
    if address_of(data).is_some() {
        return psql(query, &schema_of(data)).unwrap();
    }
    let mut file = file_of(data).await;
    let found = sqlx::query_scalar(AssertSqlSafe(query.to_owned())).fetch_one(&mut file).await.unwrap();
    file.close().await.unwrap();
    found
}
