//! The file system of a directory. `SQLite`'s write-ahead log needs shared memory and locks that network file systems
//! do not provide: on such a file system a database is damaged sooner or later.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Creates a directory and the missing ones above it, and brings their names to the disk: without their names,
/// synchronised files below are not found again.
///
/// # Errors
/// A directory cannot be created, or its name cannot be synchronised.
pub fn make_directory(path: &Path) -> io::Result<()> {
    let above = |path: &Path| match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let missing = path.ancestors().take_while(|folder| *folder != Path::new("") && !folder.is_dir()).count();
    fs::create_dir_all(path)?;
    path.ancestors().take(missing).try_for_each(|folder| File::open(above(folder))?.sync_all())
}

/// The space of a file system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DiskSpace {
    /// All of it \[bytes\].
    pub size_bytes: u64,
    /// The part that this process may still use \[bytes\].
    pub free_bytes: u64,
}

/// The space of the file system of a directory.
///
/// # Errors
/// The directory does not exist, or the system does not answer.
pub fn disk_space(directory: &Path) -> io::Result<DiskSpace> {
    let found = rustix::fs::statvfs(directory)?;
    let bytes = |blocks: u64| blocks.saturating_mul(found.f_frsize);
    Ok(DiskSpace { size_bytes: bytes(found.f_blocks), free_bytes: bytes(found.f_bavail) })
}

/// A mounted file system of another computer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkMount {
    /// Where it is mounted.
    pub at: PathBuf,
    /// Its kind, as the system names it.
    pub kind: String,
}

/// File systems whose files are on another computer. Shares of a host with its virtual machines (9p, virtiofs) are
/// left out: containers have their own root on them.
const NETWORK: &[&str] = &[
    "afs", "beegfs", "ceph", "cifs", "coda", "davfs", "gpfs", "lustre", "ncpfs", "nfs", "nfs4", "orangefs",
    "pvfs2", "smb3", "smbfs",
];

/// The same if a user process mounts it: `fuse.<kind>`.
const NETWORK_FUSE: &[&str] = &[
    "ceph",
    "curlftpfs",
    "davfs",
    "davfs2",
    "gcsfuse",
    "glusterfs",
    "goofys",
    "juicefs",
    "moosefs",
    "rclone",
    "s3fs",
    "smbnetfs",
    "sshfs",
];

/// The mount of `directory` (absolute, links followed) and its kind; `mounts` is the text of `/proc/mounts`. Of
/// several mounts the innermost is used, of two in one place the later.
#[must_use]
pub fn mount_kind<'a>(mounts: &'a str, directory: &Path) -> Option<(PathBuf, &'a str)> {
    let mut innermost: Option<(PathBuf, &str)> = None;
    for line in mounts.lines() {
        let mut fields = line.split(' ');
        let (Some(_device), Some(at), Some(kind)) = (fields.next(), fields.next(), fields.next()) else {
            continue;
        };
        let at = PathBuf::from(unescaped(at));
        let depth = |path: &Path| path.components().count();
        if directory.starts_with(&at)
            && innermost.as_ref().is_none_or(|(inner, _)| depth(&at) >= depth(inner))
        {
            innermost = Some((at, kind));
        }
    }
    innermost
}

/// The network mount of `directory`, if it is on one.
#[must_use]
pub fn network_mount(mounts: &str, directory: &Path) -> Option<NetworkMount> {
    let (at, kind) = mount_kind(mounts, directory)?;
    let remote = match kind.strip_prefix("fuse.") {
        Some(program) => NETWORK_FUSE.contains(&program),
        None => NETWORK.contains(&kind),
    };
    remote.then(|| NetworkMount { at, kind: kind.to_owned() })
}

/// A path without escapes: the table writes blanks, tabs, line ends and backslashes as three octal digits.
fn unescaped(text: &str) -> String {
    let mut path = String::with_capacity(text.len());
    let mut parts = text.split('\\');
    path.push_str(parts.next().unwrap_or_default());
    for part in parts {
        let digits = part.get(..3).and_then(|digits| u8::from_str_radix(digits, 8).ok());
        match (digits, part.get(3..)) {
            (Some(byte), Some(rest)) if byte.is_ascii() => {
                path.push(char::from(byte));
                path.push_str(rest);
            }
            _ => {
                path.push('\\');
                path.push_str(part);
            }
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_made_with_those_above_it_and_once_more_without_harm() {
        let folder = tempfile::TempDir::new().expect("a directory");
        let path = folder.path().join("a").join("b");
        make_directory(&path).expect("made");
        make_directory(&path).expect("there already");
        assert!(path.is_dir());
        std::fs::write(path.join("file"), "").expect("written");
        make_directory(&path.join("file")).expect_err("a file");
    }

    #[test]
    fn a_directory_has_space_and_a_missing_one_has_none() {
        let DiskSpace { size_bytes, free_bytes } = disk_space(&std::env::temp_dir()).expect("space");
        assert!(free_bytes <= size_bytes && size_bytes > 1 << 20, "{free_bytes} of {size_bytes}");
        disk_space(Path::new("/no/such/directory")).expect_err("missing");
    }

    #[test]
    fn only_what_the_table_escapes_is_unescaped() {
        for (text, path) in
            [("/a\\040b\\134c", "/a b\\c"), ("/a\\377", "/a\\377"), ("/a\\9", "/a\\9"), ("/a\\", "/a\\")]
        {
            assert_eq!(unescaped(text), path);
        }
    }

    const MOUNTS: &str = "\
proc /proc proc rw,relatime 0 0
/dev/vda / ext4 rw,relatime 0 0
server:/export /srv nfs4 rw,vers=4.2 0 0
/dev/sdb1 /srv/local xfs rw 0 0
//nas/share /mnt/my\\040programs cifs rw 0 0
host /mnt/back\\134slash nfs rw 0 0
user@host:/ /home/user/remote fuse.sshfs rw 0 0
/dev/sdc1 /home/user/ntfs fuseblk rw 0 0
portal /home/user/portal fuse.portal rw 0 0
tmpfs /covered tmpfs rw 0 0
nas:/x /covered nfs rw 0 0
nas:/y /uncovered nfs rw 0 0
tmpfs /uncovered tmpfs rw 0 0
a line of something else
";

    fn kind(directory: &str) -> Option<String> {
        network_mount(MOUNTS, Path::new(directory)).map(|mount| mount.kind)
    }

    #[test]
    fn the_innermost_mount_counts_and_of_two_in_one_place_the_later() {
        for (directory, expected) in [
            ("/data", None),
            ("/srv", Some("nfs4")),
            ("/srv/trunnion/data", Some("nfs4")),
            ("/srvdata", None),
            ("/srv/local/data", None),
            ("/mnt/my programs/data", Some("cifs")),
            ("/mnt/back\\slash", Some("nfs")),
            ("/home/user/remote/data", Some("fuse.sshfs")),
            ("/home/user/ntfs", None),
            ("/home/user/portal", None),
            ("/covered/data", Some("nfs")),
            ("/uncovered/data", None),
        ] {
            assert_eq!(kind(directory).as_deref(), expected, "{directory}");
        }
        let mount = network_mount(MOUNTS, Path::new("/srv/a")).unwrap();
        assert_eq!(mount.at, Path::new("/srv"));
        assert_eq!(network_mount("", Path::new("/srv")), None);
    }
}
