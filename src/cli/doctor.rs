//! Checks settings, data directory, database and files, and reports faults.

use std::path::Path;

use super::CommandFault;
use super::migrate::block_on;
use super::rights::{Rights, believed};
use super::settings::say;
use super::tls;
use crate::config::{DatabaseAddress, Settings};
use crate::jobs::trusted_certificates;
use crate::store::{
    DATABASE_NAME, Deep, Depth, DirectoryLock, DiskSpace, Examination, Store, StoreError, disk_space,
    examine_to, mount_kind, network_mount, own_schema, stored_files,
};

/// Below this free space a disk counts as nearly full \[bytes\].
const LITTLE_SPACE: u64 = 1 << 30;

/// The result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Sound,
    /// Worth knowing, but not a fault.
    Note,
    Fault,
}

#[derive(Debug, Default)]
struct Findings {
    lines: Vec<(Verdict, &'static str, String)>,
}

impl Findings {
    fn add(&mut self, verdict: Verdict, subject: &'static str, detail: impl Into<String>) {
        self.lines.push((verdict, subject, detail.into()));
    }

    /// Prints every line, and counts the faults.
    fn told(&self) -> Result<usize, CommandFault> {
        for (verdict, subject, detail) in &self.lines {
            let word = match verdict {
                Verdict::Sound => "ok",
                Verdict::Note => "note",
                Verdict::Fault => "FAULT",
            };
            say(&format!("{word:<6} {subject:<16} {detail}"))?;
        }
        Ok(self.lines.iter().filter(|(verdict, ..)| *verdict == Verdict::Fault).count())
    }

    /// Sound, or a fault if the list of faults is not empty.
    fn none_of(&mut self, subject: &'static str, sound: String, faults: &[String]) {
        match faults {
            [] => self.add(Verdict::Sound, subject, sound),
            faults => self.add(Verdict::Fault, subject, faults.join("; ")),
        }
    }
}

/// Checks to this depth, and prints the results.
pub(super) fn run(settings: &Settings, config: Option<&Path>, depth: &Depth) -> Result<(), CommandFault> {
    let mut findings = Findings::default();
    let from = config.map_or_else(|| "no settings file".to_owned(), |path| path.display().to_string());
    findings.add(Verdict::Sound, "settings", from);
    let version = env!("CARGO_PKG_VERSION");
    // A server has schemas of its own, which the examination of it names.
    let known = if settings.database.is_some() {
        version.to_owned()
    } else {
        format!("{version}, schema {}", own_schema())
    };
    findings.add(Verdict::Sound, "version", known);
    certificates(settings, &mut findings);
    for warning in believed(settings, config) {
        findings.add(Verdict::Note, "rights", warning);
    }
    let data_dir = &settings.data_dir;
    let is_there = directory(data_dir, &mut findings);
    let files = stored_files(data_dir);
    if let Some(address) = &settings.database {
        of_the_server(settings, address, depth, &mut findings);
    } else if is_there {
        if data_dir.join(DATABASE_NAME).is_file() {
            match block_on(async { Ok(examine_to(data_dir, depth).await?) }) {
                Ok(examination) => database(&examination, depth, &mut findings),
                Err(fault) => findings.add(Verdict::Fault, "database", fault.to_string()),
            }
        } else if files > 0 {
            findings.add(Verdict::Fault, "database", lost(files));
        } else {
            findings.add(Verdict::Note, "database", "missing; the service creates one when it starts");
        }
    }
    match findings.told()? {
        0 => Ok(()),
        faults => Err(CommandFault::Unsound { faults }),
    }
}

/// Checks the database on the server and its files to this depth.
fn of_the_server(settings: &Settings, address: &DatabaseAddress, depth: &Depth, findings: &mut Findings) {
    let data_dir = &settings.data_dir;
    if data_dir.join(DATABASE_NAME).is_file() {
        let fault = StoreError::FileHere { directory: data_dir.clone() };
        findings.add(Verdict::Fault, "database", fault.to_string());
    }
    match block_on(async { Ok(Store::examine_server(settings, depth).await?) }) {
        Ok(Some(examination)) => {
            findings.add(Verdict::Sound, "database", address.to_string());
            database(&examination, depth, findings);
        }
        Ok(None) => match stored_files(data_dir) {
            0 => {
                let detail = format!("{address} is empty; the service fills it when it starts");
                findings.add(Verdict::Note, "database", detail);
            }
            files => findings.add(Verdict::Fault, "database", lost(files)),
        },
        Err(fault) => findings.add(Verdict::Fault, "database", fault.to_string()),
    }
}

/// Reads every row and every file of the database on the server, prints the results, and counts the faults.
pub(super) fn server_is_read(settings: &Settings, address: &DatabaseAddress) -> Result<usize, CommandFault> {
    let mut findings = Findings::default();
    let depth = Depth { files: true, rows: true, known_head: None };
    of_the_server(settings, address, &depth, &mut findings);
    findings.told()
}

/// The files that the next start reads.
fn certificates(settings: &Settings, findings: &mut Findings) {
    if let (Some(certificate), Some(key)) = (&settings.tls_certificate, &settings.tls_key) {
        match tls::server(certificate, key) {
            Ok(_usable) => {
                let detail = format!("{} with {}", certificate.display(), key.display());
                findings.add(Verdict::Sound, "certificate", detail);
            }
            Err(fault) => findings.add(Verdict::Fault, "certificate", fault.to_string()),
        }
    }
    if let Some(file) = &settings.webhook_ca_file {
        match trusted_certificates(file) {
            Ok(trusted) => {
                let detail = format!("{} certificates in {}", trusted.len(), file.display());
                findings.add(Verdict::Sound, "webhook trust", detail);
            }
            Err(fault) => findings.add(Verdict::Fault, "webhook trust", fault.to_string()),
        }
    }
}

/// Checks the directory; returns whether it exists.
fn directory(data_dir: &Path, findings: &mut Findings) -> bool {
    let whole = match data_dir.canonicalize() {
        Ok(whole) if whole.is_dir() => whole,
        Ok(_) => {
            findings.add(
                Verdict::Fault,
                "data directory",
                format!("{} is not a directory", data_dir.display()),
            );
            return false;
        }
        Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => {
            findings.add(
                Verdict::Note,
                "data directory",
                format!("{} does not exist yet", data_dir.display()),
            );
            return false;
        }
        Err(fault) => {
            findings.add(Verdict::Fault, "data directory", format!("{}: {fault}", data_dir.display()));
            return false;
        }
    };
    match tempfile::NamedTempFile::new_in(&whole) {
        Ok(_written) => {
            findings.add(Verdict::Sound, "data directory", format!("{}, writable", whole.display()));
        }
        Err(fault) => {
            let detail = format!("{} cannot be written to: {fault}", whole.display());
            findings.add(Verdict::Fault, "data directory", detail);
        }
    }
    for path in [whole.clone(), whole.join(DATABASE_NAME)] {
        if let Some(Rights { mode }) = Rights::of(&path).filter(|rights| rights.mode & 0o077 != 0) {
            let path = path.display();
            let detail = format!(
                "{path} has the mode {mode:03o}, which lets others in; the next start of the service removes their access"
            );
            findings.add(Verdict::Note, "rights", detail);
        }
    }
    let mounts = std::fs::read_to_string("/proc/self/mounts").unwrap_or_default();
    let kind = mount_kind(&mounts, &whole).map_or("unknown", |(_, kind)| kind);
    if network_mount(&mounts, &whole).is_some() {
        let detail = format!("{kind} is on another computer, where the database would be damaged");
        findings.add(Verdict::Fault, "file system", detail);
    } else {
        findings.add(Verdict::Sound, "file system", kind);
    }
    match disk_space(&whole) {
        Ok(DiskSpace { free_bytes, .. }) => {
            let verdict = if free_bytes < LITTLE_SPACE { Verdict::Note } else { Verdict::Sound };
            findings.add(verdict, "free space", format!("{} MiB", free_bytes >> 20));
        }
        Err(fault) => findings.add(Verdict::Note, "free space", format!("cannot be determined: {fault}")),
    }
    let user = if DirectoryLock::is_taken(&whole) { "a service has the directory" } else { "nobody" };
    findings.add(Verdict::Sound, "in use by", user);
    true
}

/// Files that only another database than the present one can name.
fn lost(files: usize) -> String {
    format!(
        "{files} stored files belong to no database, so no service starts: restore the database, or move the files away"
    )
}

/// The findings of reading every row.
fn deep(found: &Deep, depth: &Depth, findings: &mut Findings) {
    let sound = format!("{} read, digests and schema unchanged", found.rows);
    findings.none_of("rows", sound, &found.findings);
    let Some(chain) = &found.audit else { return };
    let head = chain.head.as_ref().map_or_else(|| "no entry yet".to_owned(), |head| format!("head {head}"));
    let compared = match &depth.known_head {
        Some(known) => format!(", entry {} as recorded", known.seq),
        None => String::new(),
    };
    let faults: Vec<String> = chain.faults.iter().map(ToString::to_string).collect();
    findings.none_of("audit log", format!("a chain of {} entries, {head}{compared}", chain.length), &faults);
}

fn database(found: &Examination, depth: &Depth, findings: &mut Findings) {
    findings.add(Verdict::Sound, found.engine.0, found.engine.1.clone());
    if let Some(server) = &found.server {
        let sound = "what is acknowledged is on its disk, and a service with these settings may use it";
        findings.none_of("server", sound.to_owned(), &server.faults);
        server.notes.iter().for_each(|note| findings.add(Verdict::Note, "server", note.clone()));
    }
    let ours = found.newest_schema;
    match found.schema {
        Some(schema) if schema == ours => findings.add(Verdict::Sound, "schema", schema.to_string()),
        Some(schema) if schema > ours && found.usable_from.is_some_and(|from| from <= ours) => {
            let detail = format!(
                "{schema}, made by a newer trunnion; this version may use it, but does not compare it with its migrations"
            );
            findings.add(Verdict::Note, "schema", detail);
        }
        Some(schema) if schema > ours => {
            let detail =
                format!("{schema}, made by a newer trunnion; this version knows schemas up to {ours}");
            findings.add(Verdict::Fault, "schema", detail);
        }
        Some(schema) => {
            let detail = format!("{schema}; the next start, or `migrate`, updates it to {ours}");
            findings.add(Verdict::Note, "schema", detail);
        }
        None => findings.add(Verdict::Fault, "schema", "no migration has run on this database"),
    }
    findings.none_of("structure", format!("{} rows", found.rows), &found.structural_faults);
    let broken = match found.broken_references {
        0 => Vec::new(),
        rows => vec![format!("{rows} rows refer to missing rows")],
    };
    findings.none_of("references", "all rows that are referred to exist".to_owned(), &broken);
    if let Some(found) = &found.deep {
        deep(found, depth, findings);
    }
    let files = &found.files;
    let mut wrong: Vec<String> = files.missing.iter().map(|sha256| format!("{sha256} is missing")).collect();
    wrong.extend(files.changed.iter().map(|path| format!("{} has other bytes", path.display())));
    let how = if depth.files { "present, with the bytes of their digests" } else { "present, not read" };
    findings.none_of("files", format!("{} named in the database, all {how}", files.named), &wrong);
    if let Some((waiting, given_up)) = found.deliveries {
        let verdict = if given_up > 0 { Verdict::Note } else { Verdict::Sound };
        findings.add(
            verdict,
            "webhooks",
            format!("{waiting} are waiting for delivery, {given_up} were given up"),
        );
    }
    if files.shared && !found.was_served && files.orphans + files.incomplete > 0 {
        let detail = "a migration into this database did not end: run trunnion migrate --to once more";
        findings.add(Verdict::Fault, "left over", detail);
    } else if files.orphans > 0 && !found.was_served {
        findings.add(Verdict::Fault, "left over", lost(files.orphans));
    } else if files.orphans + files.incomplete > 0 {
        let goes =
            if files.shared { "a service removes them after a day" } else { "the next start removes them" };
        let detail = format!(
            "{} files that no row names, {} incomplete files: they belong to running requests, or {goes}",
            files.orphans, files.incomplete
        );
        findings.add(Verdict::Note, "left over", detail);
    }
}
