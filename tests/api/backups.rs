//! Backups and what is restored from them.

use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::command_line::{files, path, posted, said, trunnion};
use crate::database::has_no_file;
use crate::support::spawn_in;

#[tokio::test]
async fn a_backup_made_while_the_service_runs_is_restored_with_every_byte() {
    if has_no_file("a_backup_made_while_the_service_runs_is_restored_with_every_byte") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let app = spawn_in(&data, |_| {}).await;
    let (job, program) = posted(&app).await;
    let backup = folder.path().join("backups/first");
    let made = trunnion(&data, &["backup", path(&backup)]);
    assert_eq!(made.status.code(), Some(0), "{}", said(&made));
    // What comes afterwards is not in it.
    let (later, _) = posted(&app).await;
    app.stop().await;
    let manifest: Value =
        serde_json::from_slice(&std::fs::read(backup.join("manifest.json")).unwrap()).unwrap();
    assert_eq!(
        (&manifest["rows"]["jobs"], &manifest["rows"]["machines"]),
        (&json!(1), &json!(1)),
        "{manifest}"
    );
    // The database, the upload and the program.
    assert_eq!(manifest["files"].as_object().unwrap().len(), 3, "{manifest}");
    for inside in ["spool/one", "deeper/one"] {
        let refused = trunnion(&data, &["backup", path(&data.join(inside))]);
        assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
        assert!(said(&refused).contains("is inside the data directory"), "{}", said(&refused));
    }
    let again = trunnion(&data, &["backup", path(&backup)]);
    assert_eq!(again.status.code(), Some(2), "{}", said(&again));
    let occupied = trunnion(&data, &["restore", path(&backup)]);
    assert_eq!(occupied.status.code(), Some(2));
    assert!(said(&occupied).contains("nothing was changed"), "{}", said(&occupied));

    let restored = folder.path().join("restored");
    let done = trunnion(&restored, &["restore", path(&backup)]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let sound = trunnion(&restored, &["doctor"]);
    assert_eq!(sound.status.code(), Some(0), "{}", said(&sound));
    let app = spawn_in(&restored, |_| {}).await;
    assert_eq!(app.get(&format!("{job}/program")).await.text().await.unwrap(), program);
    assert_eq!(app.get(&later).await.status(), 404);
    app.stop().await;
    // A service that was stopped is backed up as well.
    let stopped = trunnion(&restored, &["backup", path(&folder.path().join("second"))]);
    assert_eq!(stopped.status.code(), Some(0), "{}", said(&stopped));
}

#[tokio::test]
async fn a_backup_that_is_not_as_it_was_made_is_not_restored() {
    if has_no_file("a_backup_that_is_not_as_it_was_made_is_not_restored") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let app = spawn_in(&data, |_| {}).await;
    posted(&app).await;
    app.stop().await;
    let backup = folder.path().join("backup");
    assert_eq!(trunnion(&data, &["backup", path(&backup)]).status.code(), Some(0));
    let manifest = std::fs::read_to_string(backup.join("manifest.json")).unwrap();
    let refused = |why: &str| {
        let target = folder.path().join("target");
        let output = trunnion(&target, &["restore", path(&backup)]);
        assert_eq!(output.status.code(), Some(2), "{why}: {}", said(&output));
        assert!(said(&output).contains(why), "{why}: {}", said(&output));
        assert!(!target.exists());
        let left = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, 2, "{why}: something was left beside data and backup");
    };
    // A byte of a file, a file, a pipe in its place, a row, another schema, a name that leads elsewhere, another form
    // of backup, no manifest.
    let blob = files(&backup.join("blobs")).pop().unwrap();
    let bytes = std::fs::read(&blob).unwrap();
    let mut other = bytes.clone();
    other[7] ^= 1;
    std::fs::write(&blob, &other).unwrap();
    refused("is damaged: its digest is");
    std::fs::remove_file(&blob).unwrap();
    refused("opening");
    assert!(Command::new("mkfifo").arg(&blob).status().unwrap().success());
    refused("this is not a regular file");
    std::fs::remove_file(&blob).unwrap();
    std::fs::write(&blob, &bytes).unwrap();
    let change = |from: &str, to: &str| {
        assert!(manifest.contains(from), "{from}");
        std::fs::write(backup.join("manifest.json"), manifest.replacen(from, to, 1)).unwrap();
    };
    change("\"jobs\": 1", "\"jobs\": 2");
    refused("the table jobs has 1 rows");
    let schema = serde_json::from_str::<Value>(&manifest).unwrap()["schema"].to_string();
    change(&format!("\"schema\": {schema}"), "\"schema\": 1");
    refused(&format!("schema {schema}, but its manifest states 1"));
    change("\"blobs/", "\"../blobs/");
    refused("is not a file of a backup");
    change("\"format\": 1", "\"format\": 2");
    refused("format 2");
    std::fs::remove_file(backup.join("manifest.json")).unwrap();
    refused("manifest.json");
}

#[tokio::test]
async fn a_backup_names_the_file_that_is_missing() {
    if has_no_file("a_backup_names_the_file_that_is_missing") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let app = spawn_in(&data, |_| {}).await;
    posted(&app).await;
    app.stop().await;
    let blob = files(&data.join("blobs")).pop().unwrap();
    std::fs::remove_file(&blob).unwrap();
    let refused = trunnion(&data, &["backup", path(&folder.path().join("backup"))]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    let name = blob.file_name().unwrap().to_str().unwrap();
    assert!(said(&refused).contains(&format!("{name} is missing, but a job needs it")), "{}", said(&refused));
    assert!(!folder.path().join("backup").exists());
}

#[tokio::test]
async fn an_empty_directory_is_filled_and_not_replaced() {
    if has_no_file("an_empty_directory_is_filled_and_not_replaced") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let app = spawn_in(&data, |_| {}).await;
    let (job, program) = posted(&app).await;
    app.stop().await;
    let backup = folder.path().join("backup");
    assert_eq!(trunnion(&data, &["backup", path(&backup)]).status.code(), Some(0));
    // A mount point cannot be replaced: the directory itself must stay. A new file system has a folder of its own.
    let volume = folder.path().join("volume");
    std::fs::create_dir_all(volume.join("lost+found")).unwrap();
    let which = |path: &Path| std::fs::metadata(path).unwrap().ino();
    let before = which(&volume);
    let done = trunnion(&volume, &["restore", path(&backup)]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert_eq!(which(&volume), before);
    let mut names: Vec<_> =
        std::fs::read_dir(&volume).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["blobs", "lost+found", "trunnion.sqlite"]);
    let app = spawn_in(&volume, |_| {}).await;
    assert_eq!(app.get(&format!("{job}/program")).await.text().await.unwrap(), program);
    app.stop().await;
    let sound = trunnion(&volume, &["doctor"]);
    assert_eq!(sound.status.code(), Some(0), "{}", said(&sound));
    let again = trunnion(&volume, &["restore", path(&backup)]);
    assert!(again.status.code() == Some(2) && said(&again).contains("is not empty"), "{}", said(&again));
    // A damaged backup leaves nothing in it.
    let blob = files(&backup.join("blobs")).pop().unwrap();
    std::fs::write(&blob, "other bytes").unwrap();
    let other = folder.path().join("other");
    std::fs::create_dir(&other).unwrap();
    let refused = trunnion(&other, &["restore", path(&backup)]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert_eq!(std::fs::read_dir(&other).unwrap().count(), 0);
}

#[tokio::test]
async fn nothing_starts_in_a_directory_while_it_is_restored_or_after_a_restore_that_did_not_end() {
    if has_no_file("nothing_starts_in_a_directory_while_it_is_restored_or_after_a_restore_that_did_not_end") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    spawn_in(&data, |_| {}).await.stop().await;
    let backup = folder.path().join("backup");
    assert_eq!(trunnion(&data, &["backup", path(&backup)]).status.code(), Some(0));
    let volume = folder.path().join("volume");
    std::fs::create_dir(&volume).unwrap();
    let entries = || std::fs::read_dir(&volume).unwrap().count();
    // As a restore holds it.
    let held = std::fs::File::open(&volume).unwrap();
    held.lock().unwrap();
    for command in [&["migrate"][..], &["restore", path(&backup)]] {
        let refused = trunnion(&volume, command);
        assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
        assert!(said(&refused).contains("another trunnion uses"), "{}", said(&refused));
        assert_eq!(entries(), 0);
    }
    drop(held);
    // As a restore leaves it that was killed.
    let copy = volume.join(".trunnion-a1b2c3");
    std::fs::create_dir(&copy).unwrap();
    let refused = trunnion(&volume, &["migrate"]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("of a restore that did not end"), "{}", said(&refused));
    std::fs::remove_dir(&copy).unwrap();
    let done = trunnion(&volume, &["restore", path(&backup)]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
}
