//! The access of other users to the files that the settings name, and to the data directory.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::config::Settings;
use crate::store::make_private;

/// The access of others to a file, from its mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rights {
    /// The mode's lower nine bits.
    pub(super) mode: u32,
}

impl Rights {
    /// The access to the file that a path leads to; `None` if there is no file.
    pub(super) fn of(path: &Path) -> Option<Self> {
        path.metadata().ok().map(|found| Self { mode: found.permissions().mode() & 0o777 })
    }

    /// Whether every user may read it. The group may be the one that the keys are for.
    pub(super) fn all_read(self) -> bool {
        self.mode & 0o004 != 0
    }

    /// Whether another user than its owner may write to it.
    pub(super) fn others_write(self) -> bool {
        self.mode & 0o022 != 0
    }
}

/// Files that the service trusts although another user than their owner may change them, in words. None of
/// them holds a secret.
pub(super) fn believed(settings: &Settings, config: Option<&Path>) -> Vec<String> {
    let files = [
        ("settings file", config),
        ("webhook_ca_file", settings.webhook_ca_file.as_deref()),
        ("tls_certificate", settings.tls_certificate.as_deref()),
    ];
    let told = files.into_iter().filter_map(|(what, path)| {
        let path = path?;
        let rights = Rights::of(path).filter(|rights| rights.others_write())?;
        let (mode, path) = (rights.mode, path.display());
        Some(format!("the {what} {path} has the mode {mode:03o}, so others can change it: chmod go-w {path}"))
    });
    told.collect()
}

/// Removes the access of others to the data directory, and reports the files where that failed.
pub(super) fn keep_private(data_dir: &Path) {
    let tightened = make_private(data_dir);
    if tightened.changed > 0 {
        tracing::warn!(
            changed = tightened.changed,
            data_dir = %data_dir.display(),
            "others could read files of the data directory; their access was removed"
        );
    }
    // One line for the directory, however many files belong to another user.
    if let Some((path, fault)) = tightened.left.first() {
        let files = tightened.left.len();
        tracing::warn!(
            files, path = %path.display(), error = %fault,
            "others can read files of the data directory, and their access cannot be removed; run chmod -R go= on the directory"
        );
    }
}
