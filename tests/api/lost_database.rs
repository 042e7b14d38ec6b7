//! A data directory whose database is gone: what is stored beside it stays, whatever is started.

use std::path::Path;

use tempfile::TempDir;

use crate::command_line::{said, trunnion};
use crate::database::has_no_file;
use crate::support::spawn_in;

const SERVE: [&str; 3] = ["serve", "--listen", "127.0.0.1:0"];
const CREATE: [&str; 6] = ["keys", "create", "--name", "office", "--scopes", "admin"];

/// A directory with a job in it and what its two files are.
async fn used(data: &Path) -> String {
    let app = spawn_in(data, |_| {}).await;
    let made = app
        .post_text("/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5", "text/plain", "g1 x1\n")
        .await;
    let job = made.headers()["location"].to_str().unwrap().to_owned();
    assert_eq!(app.files(), (2, 0));
    app.stop().await;
    job
}

#[tokio::test]
async fn files_without_their_database_are_kept_and_nothing_starts() {
    if has_no_file("files_without_their_database_are_kept_and_nothing_starts") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let job = used(&data).await;
    let (database, aside) = (data.join("trunnion.sqlite"), folder.path().join("aside.sqlite"));
    std::fs::rename(&database, &aside).unwrap();
    for empty in [false, true] {
        if empty {
            std::fs::write(&database, "").unwrap();
        }
        for command in [&SERVE[..], &["migrate"], &CREATE, &["keys", "list"], &["webhooks", "secret"]] {
            let output = trunnion(&data, command);
            let text = said(&output);
            assert_eq!(output.status.code(), Some(2), "{command:?}: {text}");
            assert!(text.contains("2 stored files") && text.contains("restore the database"), "{text}");
            let left = std::fs::metadata(&database).map_or(0, |found| found.len());
            assert!(left == 0 && database.exists() == empty, "{command:?} left a database of {left} bytes");
        }
        let looked = trunnion(&data, &["doctor"]);
        assert_eq!(looked.status.code(), Some(1), "{}", said(&looked));
        assert!(said(&looked).contains("2 stored files belong to no database"), "{}", said(&looked));
    }
    // Put back, everything is there.
    std::fs::rename(&aside, &database).unwrap();
    let sound = trunnion(&data, &["doctor"]);
    assert!(sound.status.success(), "{}", said(&sound));
    let app = spawn_in(&data, |_| {}).await;
    assert_eq!(app.get(&format!("{job}/program")).await.text().await.unwrap(), "G1 X1\n");
    app.stop().await;
}

#[tokio::test]
async fn a_database_that_never_served_does_not_count_for_that_of_the_files() {
    if has_no_file("a_database_that_never_served_does_not_count_for_that_of_the_files") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let (data, fresh) = (folder.path().join("data"), folder.path().join("fresh"));
    used(&data).await;
    assert!(trunnion(&fresh, &CREATE).status.success());
    std::fs::rename(fresh.join("trunnion.sqlite"), data.join("trunnion.sqlite")).unwrap();
    for command in [&SERVE[..], &["migrate"]] {
        let output = trunnion(&data, command);
        assert_eq!(output.status.code(), Some(2), "{command:?}: {}", said(&output));
        assert!(said(&output).contains("2 stored files"), "{command:?}: {}", said(&output));
    }
    let looked = trunnion(&data, &["doctor"]);
    assert_eq!(looked.status.code(), Some(1), "{}", said(&looked));
    assert!(said(&looked).contains("belong to no database"), "{}", said(&looked));
    // Whoever begins with nothing moves them away.
    std::fs::rename(data.join("blobs"), folder.path().join("blobs")).unwrap();
    let app = spawn_in(&data, |settings| settings.insecure = true).await;
    assert_eq!(app.get("/healthz").await.status(), 200);
    app.stop().await;
}
