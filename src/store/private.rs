//! Permissions of a data directory: only for its user. The database contains the secret that signs webhooks in clear
//! text. And files with secrets, which others must not be able to read or change.

use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// Permissions of the group and of others.
const OF_OTHERS: u32 = 0o077;

/// Permissions that nobody else may have to a file with a secret: its group may read it.
#[cfg(feature = "scale-out")]
const TO_A_SECRET: u32 = 0o026;

/// The text of a file with a secret.
///
/// # Errors
/// It cannot be read, or others can read or change it.
#[cfg(feature = "scale-out")]
pub(super) fn secret_in(path: &Path) -> Result<String, super::StoreError> {
    use super::StoreError;

    let unusable = |source| StoreError::Note { path: path.to_owned(), source };
    let mode = path.metadata().map_err(unusable)?.permissions().mode() & 0o777;
    if mode & TO_A_SECRET != 0 {
        return Err(StoreError::Exposed { path: path.to_owned(), mode });
    }
    fs::read_to_string(path).map_err(unusable)
}

/// The result of removing permissions.
#[derive(Debug, Default)]
pub struct Tightened {
    /// Number of files and folders that others could read or change before.
    pub changed: usize,
    /// Files that are unchanged, with the reason.
    pub left: Vec<(PathBuf, io::Error)>,
}

/// Removes the permissions of the group and of others from a data directory and from its direct content; also from
/// everything below, if the directory or a folder in it was open to them. Links are not followed.
#[must_use]
pub fn make_private(data_dir: &Path) -> Tightened {
    let mut tightened = Tightened::default();
    // The path of the directory itself may be a link.
    let Ok(whole) = data_dir.canonicalize() else { return tightened };
    let was_open = tightened.take_from(&whole);
    for path in entries(&whole) {
        tightened.descend(&path, was_open);
    }
    tightened
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

impl Tightened {
    /// Whether others had permissions.
    fn take_from(&mut self, path: &Path) -> bool {
        let Ok(found) = path.symlink_metadata() else { return false };
        let mode = found.permissions().mode() & 0o7777;
        if found.is_symlink() || mode & OF_OTHERS == 0 {
            return false;
        }
        match fs::set_permissions(path, Permissions::from_mode(mode & !OF_OTHERS)) {
            Ok(()) => self.changed += 1,
            // It was removed after it was listed.
            Err(fault) if fault.kind() == io::ErrorKind::NotFound => {}
            Err(fault) => self.left.push((path.to_owned(), fault)),
        }
        true
    }

    fn descend(&mut self, path: &Path, was_open: bool) {
        let is_open = self.take_from(path) || was_open;
        if is_open && path.symlink_metadata().is_ok_and(|found| found.is_dir()) {
            for below in entries(path) {
                self.descend(&below, true);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn everything_of_an_open_directory_becomes_its_users_and_what_links_lead_to_stays() {
        let folder = tempfile::TempDir::new().expect("a directory");
        let data = folder.path().join("data");
        let at = |path: &str| data.join(path);
        fs::create_dir_all(at("blobs/ab")).expect("folders");
        let outside = folder.path().join("outside");
        for (path, mode) in
            [(at("trunnion.sqlite"), 0o644), (at("blobs/ab/file"), 0o666), (outside.clone(), 0o644)]
        {
            fs::write(&path, "x").expect("written");
            fs::set_permissions(&path, Permissions::from_mode(mode)).expect("a mode");
        }
        symlink(&outside, at("link")).expect("a link");
        for path in [at("blobs/ab"), at("blobs"), data.clone()] {
            fs::set_permissions(&path, Permissions::from_mode(0o755)).expect("a mode");
        }
        let tightened = make_private(&data);
        assert!(tightened.left.is_empty(), "{tightened:?}");
        assert_eq!(tightened.changed, 5);
        let mode = |path: &Path| fs::metadata(path).expect("there").permissions().mode() & 0o777;
        for (path, expected) in [
            (data.clone(), 0o700),
            (at("blobs"), 0o700),
            (at("blobs/ab"), 0o700),
            (at("blobs/ab/file"), 0o600),
            (at("trunnion.sqlite"), 0o600),
            (outside, 0o644),
        ] {
            assert_eq!(mode(&path), expected, "{}", path.display());
        }
        assert_eq!(make_private(&data).changed, 0);
    }
}
