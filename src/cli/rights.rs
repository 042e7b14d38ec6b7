//! Who else may read or change the files that the settings name, and the data directory.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::config::Settings;
use crate::store::make_private;

/// What others may do with a file, from its mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rights {
    /// The mode's lower nine bits.
    pub(super) mode: u32,
}

impl Rights {
    /// Of the file that a path leads to; none where there is none to look at.
    pub(super) fn of(path: &Path) -> Option<Self> {
        path.metadata().ok().map(|found| Self { mode: found.permissions().mode() & 0o777 })
    }

    /// Whether anybody may read it. The group may be the one that keys are for.
    pub(super) fn all_read(self) -> bool {
        self.mode & 0o004 != 0
    }

    /// Whether somebody besides its owner may write to it.
    pub(super) fn others_write(self) -> bool {
        self.mode & 0o022 != 0
    }
}

/// The files that the service believes and that somebody besides their owner may change, in words. None of them holds a secret.
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

/// Takes the data directory from everybody but its user, and says what could not be taken.
pub(super) fn keep_private(data_dir: &Path) {
    let tightened = make_private(data_dir);
    if tightened.changed > 0 {
        tracing::warn!(
            changed = tightened.changed,
            data_dir = %data_dir.display(),
            "others could read files of the data directory, and cannot any more"
        );
    }
    // One line for the directory, however many files are another user's.
    if let Some((path, fault)) = tightened.left.first() {
        let files = tightened.left.len();
        tracing::warn!(
            files, path = %path.display(), error = %fault,
            "others can read files of the data directory, and their rights cannot be changed: chmod -R go= it"
        );
    }
}
