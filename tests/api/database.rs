//! The database of a test: a file in its data directory, or a schema of its own on the server that
//! `TRUNNION_TEST_DATABASE` names (`tests/postgres/run`).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use trunnion::config::Settings;

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
        println!("left out, because the database is no file: {test}");
    }
    left_out
}

/// Names the database of a data directory in the settings. A directory that is opened again has the same one.
pub(crate) fn choose(settings: &mut Settings) {
    if server().is_none() {
        return;
    }
    let data = settings.data_dir.clone();
    let text = format!("CREATE SCHEMA IF NOT EXISTS {}", schema_of(&data));
    ask(&text);
    ON_THE_SERVER.lock().unwrap().insert(data.clone());
    settings.database = address_of(&data).map(|address| address.parse().unwrap());
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
    let call = Command::new("psql")
        .args(["-XAtq", "-v", "ON_ERROR_STOP=1", "-c", text])
        .arg(server().unwrap())
        .output();
    let done = call.unwrap();
    assert!(done.status.success(), "{text}: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap().trim().to_owned()
}
