//! Stores a program, its parameters and the part's surface from a plain or a multipart body on the disk.

use std::time::Duration;

use axum::body::Body;
use axum::extract::multipart::Field;
use axum::extract::{DefaultBodyLimit, FromRequest, Multipart, Request};
use http::HeaderMap;
use http::request::Parts;
use serde::de::DeserializeOwned;

use super::several::{Beside, LONGEST_MAIN_BYTES, MAIN, NAMELESS, SUBPROGRAM, refuse_archive, with_files};
use crate::http::AppState;
use crate::http::body::{BetweenFields, Incoming, PaidAsItGrows, content_length, media_type, unreadable};
use crate::http::extract::parsed_bytes;
use crate::http::problem::{Problem, ProblemType};
use crate::jobs::Upload as Spooling;
use crate::jobs::memory;
use crate::store::Draft;
use crate::wire::{Fault, read_json, read_query};

/// A program on the disk, with the rest of the upload.
pub(super) struct Upload<P> {
    /// The program.
    pub(super) program: Draft,
    /// Its cleaned name; a default name if the client gave none.
    pub(super) file_name: String,
    /// Files that it calls came with it.
    pub(super) has_files: bool,
    /// The part's surface.
    pub(super) surface: Option<Draft>,
    /// The parameters.
    pub(super) parameters: P,
}

/// Whether an operation uses the part's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::http) enum Part {
    /// A field `surface` is not allowed.
    Unseen,
    /// A field `surface` is allowed.
    Seen,
}

/// The name given, or eight digits of the program's digest with an extension that fits its media type.
fn named(given: Option<String>, program: &Draft, media_type: Option<&str>) -> String {
    given.unwrap_or_else(|| {
        let extension = if media_type == Some("text/csv") { "csv" } else { "nc" };
        let digest = program.sha256();
        format!("{}.{extension}", digest.get(..8).unwrap_or(&digest))
    })
}

const MULTIPART: &str = "multipart/form-data";

/// Takes the upload, within the limits of bodies and surfaces.
pub(super) async fn take<P: DeserializeOwned>(
    app: &AppState,
    parts: &Parts,
    body: Body,
    part: Part,
) -> Result<Upload<P>, Problem> {
    let kind = media_type(&parts.headers);
    let mut incoming = Incoming::new(body, app.settings.body_pause_timeout_s);
    let with_surface = part == Part::Seen && kind.as_deref() == Some(MULTIPART);
    let surface = if with_surface { app.settings.max_surface_bytes } else { 0 };
    let limit = app.settings.max_body_bytes.saturating_add(surface);
    if content_length(&parts.headers)
        .is_some_and(|length| length > limit.saturating_add(app.settings.max_parameters_bytes))
    {
        return Err(incoming.refuse_length(limit).await);
    }
    match kind.as_deref() {
        Some(MULTIPART) => multipart(app, parts, incoming, part).await,
        Some(kind) if !kind.starts_with("text/") && kind != "application/octet-stream" => {
            let detail = format!(
                "send a program as text/*, application/octet-stream, multipart/form-data or without a type, not as {kind}"
            );
            incoming.swallow().await;
            Err(Problem::new(ProblemType::UnsupportedMediaType, detail))
        }
        _ => {
            // Wrong parameters are refused before the program is read.
            let parameters = match read_query(parts.uri.query().unwrap_or_default()) {
                Ok(parameters) => parameters,
                Err(fault) => {
                    incoming.swallow().await;
                    return Err(fault.into());
                }
            };
            let mut spooling = app.spool.begin()?;
            while let Some(chunk) = incoming.next().await? {
                if let Err(fault) = spooling.take(&chunk).await {
                    incoming.swallow().await;
                    return Err(fault.into());
                }
            }
            let program = spooling.finish().await?;
            refuse_archive(&program)?;
            let file_name = named(given_name(&parts.headers), &program, kind.as_deref());
            Ok(Upload { program, file_name, has_files: false, surface: None, parameters })
        }
    }
}

async fn multipart<P: DeserializeOwned>(
    app: &AppState,
    parts: &Parts,
    incoming: Incoming,
    part: Part,
) -> Result<Upload<P>, Problem> {
    // A field that states no parameter leaves them to the query.
    let read = |text: &[u8]| if is_empty_object(text) { Ok(None) } else { Ok(Some(read_json(text)?)) };
    let names = FormFields { document: "parameters", file: "program", part, several: true };
    let Form { document, program, file_name, has_files, surface } =
        form(app, parts, incoming, names, read).await?;
    let query = parts.uri.query().unwrap_or_default();
    let parameters = match document.flatten() {
        Some(_) if !query.is_empty() => {
            let detail =
                "the field parameters and the query both have parameters; move all of them to one place";
            let fault = Fault::new("/parameters", detail);
            return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
        }
        Some(parameters) => parameters,
        None => read_query(query)?,
    };
    Ok(Upload { program, file_name, has_files, surface, parameters })
}

/// Whether a text is `{}`, perhaps with blanks.
fn is_empty_object(text: &[u8]) -> bool {
    text.iter().filter(|byte| !byte.is_ascii_whitespace()).eq(b"{}")
}

/// The names of a form's fields.
#[derive(Debug, Clone, Copy)]
pub(in crate::http) struct FormFields {
    /// The field with the JSON document.
    pub(in crate::http) document: &'static str,
    /// The field with the file.
    pub(in crate::http) file: &'static str,
    /// Whether the form may have a surface.
    pub(in crate::http) part: Part,
    /// Whether the form may have files that the program calls.
    pub(in crate::http) several: bool,
}

/// A form with a JSON document, a program and optionally the part's surface.
pub(in crate::http) struct Form<D> {
    /// The document, if the form has one.
    pub(in crate::http) document: Option<D>,
    /// The program.
    pub(in crate::http) program: Draft,
    /// Its name.
    pub(in crate::http) file_name: String,
    /// Files that it calls came with it.
    pub(in crate::http) has_files: bool,
    /// The part's surface.
    pub(in crate::http) surface: Option<Draft>,
}

/// Takes a form with these fields, within the limits of bodies and surfaces.
pub(in crate::http) async fn take_form<D>(
    app: &AppState,
    parts: &Parts,
    body: Body,
    names: FormFields,
    read: impl Fn(&[u8]) -> Result<D, Problem>,
) -> Result<Form<D>, Problem> {
    let mut incoming = Incoming::new(body, app.settings.body_pause_timeout_s);
    if media_type(&parts.headers).as_deref() != Some(MULTIPART) {
        incoming.swallow().await;
        let detail = format!("send {MULTIPART} with the fields {} and {}", names.document, names.file);
        return Err(Problem::new(ProblemType::UnsupportedMediaType, detail));
    }
    let surface = if names.part == Part::Seen { app.settings.max_surface_bytes } else { 0 };
    let limit = app.settings.max_body_bytes.saturating_add(surface);
    if content_length(&parts.headers)
        .is_some_and(|length| length > limit.saturating_add(app.settings.max_parameters_bytes))
    {
        return Err(incoming.refuse_length(limit).await);
    }
    form(app, parts, incoming, names, read).await
}

async fn form<D>(
    app: &AppState,
    parts: &Parts,
    incoming: Incoming,
    names: FormFields,
    read: impl Fn(&[u8]) -> Result<D, Problem>,
) -> Result<Form<D>, Problem> {
    let (body, between) = incoming.into_form(app.settings.max_header_bytes);
    let form = fields(app, parts, (body, &between), names, read).await;
    if let Err(problem) = &form {
        // A form that does not arrive, or that is not a form, has no rest to wait for.
        if !matches!(problem.kind(), ProblemType::RequestTimeout | ProblemType::MalformedRequest) {
            between.swallow().await;
        }
    }
    form
}

async fn fields<D>(
    app: &AppState,
    parts: &Parts,
    (body, between): (Body, &BetweenFields),
    names: FormFields,
    read: impl Fn(&[u8]) -> Result<D, Problem>,
) -> Result<Form<D>, Problem> {
    let mut request = Request::from_parts(parts.clone(), body);
    *request.method_mut() = http::Method::POST;
    // The limits of fields are the service's own.
    DefaultBodyLimit::disable().apply(&mut request);
    let mut form = Multipart::from_request(request, app)
        .await
        .map_err(|fault| Problem::new(ProblemType::MalformedRequest, fault.body_text()))?;
    let mut document: Option<D> = None;
    let mut program: Option<(Draft, Option<String>, Option<String>)> = None;
    let mut surface: Option<Draft> = None;
    let mut beside = Beside::default();
    let mut empty_parts = 0;
    loop {
        between.enter();
        let Some(mut field) = paused(app, form.next_field()).await? else { break };
        between.leave();
        match field.name().unwrap_or_default() {
            name if name == names.document && document.is_none() => {
                let (mut text, mut paid) = (Vec::new(), PaidAsItGrows::default());
                while let Some(chunk) = paused(app, field.chunk()).await? {
                    paid.grow_to(text.len() + chunk.len())?;
                    text.extend_from_slice(&chunk);
                    let limit = app.settings.max_parameters_bytes;
                    if text.len() as u64 > limit {
                        let field = names.document;
                        let detail = format!("the field {field} is larger than the limit of {limit} bytes");
                        return Err(Problem::new(ProblemType::BodyTooLarge, detail));
                    }
                }
                if text.trim_ascii().is_empty() {
                    empty_parts += 1;
                } else {
                    memory::keep(parsed_bytes(&text))?;
                    document = Some(read(&text)?);
                }
            }
            name if name == names.file && program.is_none() => {
                let name = field.file_name().and_then(clean_name);
                let kind = field.content_type().map(str::to_owned);
                let draft = spooled(app, &mut field, app.spool.begin()?).await?;
                program = is_filled(&draft, name.as_deref()).then_some((draft, name, kind));
                empty_parts += u32::from(program.is_none());
            }
            "surface" if surface.is_none() && names.part == Part::Seen => {
                let name = field.file_name().and_then(clean_name);
                let spooling = app.spool.begin_within(app.settings.max_surface_bytes)?;
                let draft = spooled(app, &mut field, spooling).await?;
                surface = is_filled(&draft, name.as_deref()).then_some(draft);
                empty_parts += u32::from(surface.is_none());
            }
            SUBPROGRAM if names.several => {
                empty_parts += u32::from(!take_beside(app, &mut field, &mut beside).await?);
            }
            MAIN if names.several && beside.main.is_none() => {
                beside.main = main_name(app, &mut field).await?;
                empty_parts += u32::from(beside.main.is_none());
            }
            name => {
                let name = name.to_owned();
                let known = match name.as_str() {
                    "surface" => names.part == Part::Seen,
                    MAIN => names.several,
                    name => name == names.document || name == names.file,
                };
                let mut filled = !known;
                while !filled && let Some(chunk) = paused(app, field.chunk()).await? {
                    filled = !chunk.is_empty();
                }
                if filled {
                    let detail = if known { "the field occurs more than once" } else { "unknown field" };
                    let fault = Fault::new(format!("/{name}"), detail);
                    return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
                }
                empty_parts += 1;
            }
        }
        if empty_parts > MOST_EMPTY_PARTS {
            let detail = format!(
                "the form has more than {MOST_EMPTY_PARTS} parts without content; leave out fields without a value"
            );
            return Err(Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new("", detail)]));
        }
    }
    between.end(Duration::from_secs_f64(app.settings.body_pause_timeout_s)).await?;
    let Some((program, file_name, media_type)) = program else {
        let detail = format!("the file field {} is missing; choose a file", names.file);
        let fault = Fault::new(format!("/{}", names.file), detail);
        return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
    };
    let file_name = named(file_name, &program, media_type.as_deref());
    if !names.several {
        return Ok(Form { document, has_files: false, program, file_name, surface });
    }
    let sent = program.sha256();
    let (program, file_name) = with_files(app, program, file_name, beside).await?;
    Ok(Form { document, has_files: program.sha256() != sent, program, file_name, surface })
}

/// Most parts of a form that have no content: each takes a file while it is read.
const MOST_EMPTY_PARTS: u32 = 16;

/// Whether a file was chosen for a field. Browsers send an empty part without a file name if none was, and pages that
/// make the form themselves an empty part with the name `blob`.
fn is_filled(draft: &Draft, name: Option<&str>) -> bool {
    draft.length() > 0 || name.is_some_and(|name| name != NAMELESS)
}

/// Takes a file that the program calls. Returns whether there is one.
async fn take_beside(app: &AppState, field: &mut Field<'_>, beside: &mut Beside) -> Result<bool, Problem> {
    let name = field.file_name().map(str::to_owned);
    while let Some(chunk) = paused(app, field.chunk()).await? {
        beside.files(app)?.take(&chunk).await?;
    }
    beside.end(app, name.as_deref())
}

/// The name in a field, if there is one.
async fn main_name(app: &AppState, field: &mut Field<'_>) -> Result<Option<String>, Problem> {
    let mut text = Vec::new();
    while let Some(chunk) = paused(app, field.chunk()).await? {
        text.extend_from_slice(&chunk);
        if text.len() > LONGEST_MAIN_BYTES {
            let detail = format!("the name is longer than {LONGEST_MAIN_BYTES} bytes");
            let fault = Fault::new(format!("/{MAIN}"), detail);
            return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
        }
    }
    let name = String::from_utf8_lossy(&text).trim().to_owned();
    Ok(Some(name).filter(|name| !name.is_empty()))
}

/// A field on the disk.
async fn spooled(app: &AppState, field: &mut Field<'_>, mut spooling: Spooling) -> Result<Draft, Problem> {
    while let Some(chunk) = paused(app, field.chunk()).await? {
        spooling.take(&chunk).await?;
    }
    Ok(spooling.finish().await?)
}

async fn paused<T>(
    app: &AppState,
    next: impl Future<Output = Result<T, axum::extract::multipart::MultipartError>>,
) -> Result<T, Problem> {
    let pause_s = app.settings.body_pause_timeout_s;
    match tokio::time::timeout(Duration::from_secs_f64(pause_s), next).await {
        Ok(read) => read.map_err(|fault| {
            unreadable(&fault)
                .unwrap_or_else(|| Problem::new(ProblemType::MalformedRequest, fault.body_text()))
        }),
        Err(_elapsed) => {
            let detail = format!("no byte of the body arrived for {pause_s} s; send the request again");
            Err(Problem::new(ProblemType::RequestTimeout, detail))
        }
    }
}

/// The name in the Content-Disposition of a plain upload.
fn given_name(headers: &HeaderMap) -> Option<String> {
    let value = headers.get(http::header::CONTENT_DISPOSITION)?.to_str().ok()?;
    let (_, name) = value.split_once("filename=")?;
    clean_name(name.split(';').next()?.trim().trim_matches('"'))
}

/// The last part of a path, reduced to characters that are safe in a header and in a shell.
pub(in crate::http) fn clean_name(name: &str) -> Option<String> {
    let last = name.rsplit(['/', '\\']).next()?;
    let safe = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let clean: String = last.chars().take(120).map(safe).collect();
    let clean = clean.trim_start_matches('.').to_owned();
    if clean.is_empty() { None } else { Some(clean) }
}
