//! The files of a form that belong to its program: fields `subprogram`, or an archive with the name of the main program
//! in the field `main`.

use std::io::{self, Read};

use super::answer::{is_zip_name, stem};
use crate::description::ToSchema;
use crate::http::AppState;
use crate::http::problem::{Problem, ProblemType};
use crate::jobs::{
    ArchiveFault, ArrivingFiles, CompensatorFault, ProgramFilesFault, SentFile, Spool, Unpacked, joined,
    looks_joined, unpack,
};
use crate::process::Stop;
use crate::store::Draft;
use crate::wire::Fault;

/// The field of a file that the program calls.
pub(super) const SUBPROGRAM: &str = "subprogram";
/// The field with the name of the main program in an archive.
pub(super) const MAIN: &str = "main";
/// The name that a page gives to a file without a name (`FormData` of the browsers).
pub(super) const NAMELESS: &str = "blob";

/// Longest name in this field \[bytes\].
pub(super) const LONGEST_MAIN_BYTES: usize = 2000;
/// The first bytes of a zip archive, and of an empty one.
const ARCHIVES: [[u8; 4]; 2] = [*b"PK\x03\x04", *b"PK\x05\x06"];
/// Most names in a message, and most characters of a name.
const NAMED: usize = 5;
const LONGEST_SHOWN: usize = 100;

/// A file of a form.
#[derive(Debug, ToSchema)]
#[schema(value_type = String, format = Binary)]
#[expect(dead_code, reason = "describes the multipart body")]
pub(in crate::http) struct ProgramFile(Vec<u8>);

/// What came beside the program.
#[derive(Default)]
pub(super) struct Beside {
    files: Option<ArrivingFiles>,
    /// The name of the main program in the archive.
    pub(super) main: Option<String>,
}

impl Beside {
    /// Where the bytes of the next file go.
    pub(super) fn files(&mut self, app: &AppState) -> Result<&mut ArrivingFiles, Problem> {
        match &mut self.files {
            Some(files) => Ok(files),
            none => Ok(none.insert(ArrivingFiles::begin(&app.spool, app.settings.max_body_bytes)?)),
        }
    }

    /// The file is complete. Returns whether there is one.
    pub(super) fn end(&mut self, app: &AppState, name: Option<&str>) -> Result<bool, Problem> {
        let last = name.and_then(|name| name.rsplit(['/', '\\']).next()).unwrap_or_default();
        let files = self.files(app)?;
        // Pages send an empty part for a file that was not chosen.
        let is_filled = files.length() > 0 || !matches!(last, "" | NAMELESS);
        if is_filled {
            files.end(last.to_owned()).map_err(refused)?;
        }
        Ok(is_filled)
    }
}

/// The program with the files that belong to it, and its name. The name of an archive ends with `.zip`.
pub(super) async fn with_files(
    app: &AppState,
    program: Draft,
    file_name: String,
    Beside { files, main }: Beside,
) -> Result<(Draft, String), Problem> {
    let files = match files {
        Some(files) => files.finish().await?,
        None => Vec::new(),
    };
    refuse_joined(&program)?;
    let is_archive = is_archive(&program)?;
    if is_archive && !files.is_empty() {
        let detail = "the program is a zip archive; put all files into it, or send all of them as fields";
        return Err(invalid(SUBPROGRAM, detail));
    }
    if !is_archive && main.is_some() {
        let detail = "the program is no zip archive, so it has no other main program; remove the field";
        return Err(invalid(MAIN, detail));
    }
    if !is_archive && files.is_empty() {
        return Ok((program, file_name));
    }
    let (spool, limit) = (app.spool.of_asker(), app.settings.max_body_bytes);
    if !is_archive {
        let main = SentFile::of(file_name.clone(), &program)?;
        let joined = app.compute.run(move |_stop| joined(&spool, main, files, false)).await?;
        return Ok((joined.map_err(refused)?, file_name));
    }
    // The files of an archive stay open until they are one file, so archives take turns.
    let _turn = app.archives.lock().await;
    let joined =
        app.compute.run(move |stop| of_archive(&spool, &program, main.as_deref(), limit, stop)).await?;
    let file_name = if is_zip_name(&file_name) { file_name } else { format!("{}.zip", stem(&file_name)) };
    Ok((joined?, file_name))
}

/// Refuses an archive where only a program is taken.
pub(super) fn refuse_archive(program: &Draft) -> Result<(), Problem> {
    if is_archive(program)? {
        let detail = "this is a zip archive: send it in the field program of a form (multipart/form-data), and the name of its main program in the field main";
        return Err(invalid("program", detail));
    }
    refuse_joined(program)
}

/// Refuses a text that begins as the service's own files of several programs.
pub(in crate::http) fn refuse_joined(program: &Draft) -> Result<(), Problem> {
    if looks_joined(program)? {
        let detail = "the text begins as a file of the service's own; send the files of a program in fields or in a zip archive";
        return Err(invalid("program", detail));
    }
    Ok(())
}

/// Whether a file is a zip archive.
fn is_archive(program: &Draft) -> io::Result<bool> {
    let mut head = Vec::new();
    std::fs::File::open(program.path())?.take(4).read_to_end(&mut head)?;
    Ok(ARCHIVES.iter().any(|archive| head == archive))
}

/// The files of an archive as one program. Blocks.
fn of_archive(
    spool: &Spool,
    archive: &Draft,
    main: Option<&str>,
    limit: u64,
    stop: &Stop<'_>,
) -> Result<Draft, Problem> {
    let unpacked = unpack(archive, spool, limit, stop).map_err(|fault| archive_refused(fault, "program"))?;
    let Unpacked { programs: mut files, .. } = unpacked;
    let place = main_of(&files, main)?;
    let (name, draft) = files.remove(place);
    let main = SentFile::of(name, &draft)?;
    let others = files.into_iter().map(|(name, draft)| SentFile::of(name, &draft));
    joined(spool, main, others.collect::<Result<_, _>>()?, true).map_err(refused)
}

/// Which file of an archive is the main program.
fn main_of(files: &[(String, Draft)], main: Option<&str>) -> Result<usize, Problem> {
    let names = || {
        let shown: Vec<_> = files.iter().take(NAMED).map(|(name, _)| name.as_str()).collect();
        let more = if files.len() > NAMED { " and others" } else { "" };
        format!("{}{more}", shown.join(", "))
    };
    let Some(main) = main else {
        if files.len() == 1 {
            return Ok(0);
        }
        let detail =
            format!("missing: the archive has {} files ({}); name the main program", files.len(), names());
        return Err(invalid(MAIN, &detail));
    };
    let last = |name: &str| name.rsplit(['/', '\\']).next().unwrap_or(name).to_uppercase();
    let whole = files.iter().position(|(name, _)| name == main);
    let mut by_last = files.iter().enumerate().filter(|(_, (name, _))| last(name) == last(main));
    let only = by_last.next().filter(|_| by_last.next().is_none()).map(|(index, _)| index);
    whole.or(only).ok_or_else(|| {
        let shown: String = main.chars().take(LONGEST_SHOWN).collect();
        invalid(MAIN, &format!("{shown}: the archive has no such file, or several; it has {}", names()))
    })
}

/// The refusal of files that an operation does not use.
pub(in crate::http) fn calls_no_files() -> Problem {
    invalid(SUBPROGRAM, "this operation follows no calls; send one program without other files")
}

fn invalid(field: &str, detail: &str) -> Problem {
    Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new(format!("/{field}"), detail)])
}

fn refused(fault: ProgramFilesFault) -> Problem {
    match fault {
        ProgramFilesFault::TooMany { .. } | ProgramFilesFault::Name | ProgramFilesFault::Twice { .. } => {
            invalid(SUBPROGRAM, &fault.to_string())
        }
        ProgramFilesFault::File(fault) => fault.into(),
        ProgramFilesFault::Write(fault) => fault.into(),
    }
}

/// The problem of an archive in a field of a form.
pub(in crate::http) fn archive_refused(fault: ArchiveFault, field: &str) -> Problem {
    match fault {
        ArchiveFault::TooLarge { .. } => Problem::new(ProblemType::BodyTooLarge, fault.to_string()),
        ArchiveFault::NoShare(fault) => fault.into(),
        ArchiveFault::File(fault) => fault.into(),
        ArchiveFault::Write(fault) => fault.into(),
        ArchiveFault::Cancelled => CompensatorFault::Cancelled.into(),
        fault => invalid(field, &fault.to_string()),
    }
}
