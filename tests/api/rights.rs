//! Who else may read what the service writes, and who gets in beside it.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Stdio;

use rcgen::{CertifiedKey, generate_simple_self_signed};
use tempfile::TempDir;

use crate::command_line::{path, said, trunnion};
use crate::process::{address, binary};

fn mode(path: &Path) -> u32 {
    std::fs::symlink_metadata(path).unwrap().permissions().mode() & 0o777
}

fn set(path: &Path, mode: u32) {
    std::fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
}

/// Everything below a folder, and itself.
fn all(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let below = entries.flat_map(|path| if path.is_dir() { all(&path) } else { vec![path] });
    below.chain([folder.to_owned()]).collect()
}

fn assert_private(folder: &Path) {
    for path in all(folder) {
        assert_eq!(mode(&path) & 0o077, 0, "{} has the mode {:o}", path.display(), mode(&path));
    }
}

#[tokio::test]
async fn what_the_process_writes_is_its_users_alone_and_an_open_directory_is_closed_at_the_start() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    for round in 0..2 {
        let mut child = binary(&folder).args(["serve", "--listen", "127.0.0.1:0"]).spawn().unwrap();
        let address = address(&mut child);
        let url = format!("http://{address}/v1/machines/example-ac-table/posting");
        let program = include_str!("../../docs/examples/flank.apt");
        let posted = reqwest::Client::new().post(url).header("content-type", "text/plain").body(program);
        assert_eq!(posted.send().await.unwrap().status(), 200);
        let made = trunnion(&data, &["keys", "list"]);
        assert!(made.status.success(), "{}", said(&made));
        assert!(all(&data).len() > 6, "{:?}", all(&data));
        assert_private(&data);
        child.kill().unwrap();
        child.wait().unwrap();
        if round == 0 {
            set(&data, 0o755);
            all(&data).iter().filter(|path| path.is_file()).for_each(|path| set(path, 0o644));
        }
    }
    let backup = folder.path().join("backup");
    let made = trunnion(&data, &["backup", path(&backup)]);
    assert!(made.status.success(), "{}", said(&made));
    assert_private(&backup);
    let restored = folder.path().join("restored");
    let made = trunnion(&restored, &["restore", path(&backup)]);
    assert!(made.status.success(), "{}", said(&made));
    assert_private(&restored);
}

#[test]
fn a_tls_key_that_others_can_read_or_change_is_refused_with_the_cure() {
    let folder = TempDir::new().unwrap();
    let CertifiedKey { cert, signing_key } = generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    let (certificate, key) = (folder.path().join("chain.pem"), folder.path().join("key.pem"));
    std::fs::write(&certificate, cert.pem()).unwrap();
    std::fs::write(&key, signing_key.serialize_pem()).unwrap();
    let asked = |command: &[&str]| {
        let settings = ["--tls-certificate", path(&certificate), "--tls-key", path(&key)];
        trunnion(&folder.path().join("data"), &[&settings[..], command].concat())
    };
    for open in [0o666, 0o644, 0o604, 0o620] {
        set(&key, open);
        let refused = asked(&["serve", "--listen", "127.0.0.1:0"]);
        assert_eq!(refused.status.code(), Some(2), "{open:o}: {}", said(&refused));
        assert!(said(&refused).contains(&format!("the mode {open:o}")), "{}", said(&refused));
        assert!(said(&refused).contains(&format!("chmod 600 {}", path(&key))), "{}", said(&refused));
        assert_eq!(asked(&["doctor"]).status.code(), Some(1), "{open:o}");
    }
    for closed in [0o600, 0o400, 0o640] {
        set(&key, closed);
        let sound = asked(&["doctor"]);
        assert!(sound.status.success(), "{closed:o}: {}", said(&sound));
    }
    // What is believed and can be changed by others is told.
    set(&certificate, 0o666);
    let told = asked(&["doctor"]);
    assert!(told.status.success() && said(&told).contains("chmod go-w"), "{}", said(&told));
}

#[test]
fn a_removed_lock_file_lets_no_second_process_in_and_the_commands_beside_the_service_go_on() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let mut child = binary(&folder).args(["serve", "--listen", "127.0.0.1:0"]).spawn().unwrap();
    address(&mut child);
    std::fs::remove_file(data.join("trunnion.lock")).unwrap();
    for command in [&["serve", "--listen", "127.0.0.1:0"][..], &["migrate"]] {
        let refused = binary(&folder).args(command).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(refused.status.code(), Some(2), "{command:?}: {}", said(&refused));
        assert!(said(&refused).contains("another trunnion uses"), "{}", said(&refused));
    }
    let create = ["keys", "create", "--name", "office", "--scopes", "admin"];
    assert!(trunnion(&data, &create).status.success());
    let looked = trunnion(&data, &["doctor"]);
    assert!(said(&looked).contains("a service has the directory"), "{}", said(&looked));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(trunnion(&data, &["migrate"]).status.success());
}
