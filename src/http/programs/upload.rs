//! A program with its parameters, taken from a plain or a multipart body onto the disk.

use axum::body::Body;
use axum::extract::{FromRequest, Multipart, Request};
use http::HeaderMap;
use http::request::Parts;
use serde::de::DeserializeOwned;

use crate::http::AppState;
use crate::http::body::{Incoming, content_length, media_type};
use crate::http::problem::{Problem, ProblemType};
use crate::jobs::Upload as Spooling;
use crate::store::Draft;
use crate::wire::{Fault, read_json, read_query};

/// A program on the disk, and what came with it.
pub(super) struct Upload<P> {
    /// The program.
    pub(super) program: Draft,
    /// Its name, cleaned; none where the client gave none.
    pub(super) file_name: Option<String>,
    /// The media type it came with.
    pub(super) media_type: Option<String>,
    /// The parameters.
    pub(super) parameters: P,
}

impl<P> Upload<P> {
    /// The upload's name, or eight digits of its digest with an extension that fits.
    pub(super) fn name(&self) -> String {
        self.file_name.clone().unwrap_or_else(|| {
            let csv = self.media_type.as_deref() == Some("text/csv");
            let digest = self.program.sha256();
            format!("{}.{}", digest.get(..8).unwrap_or(&digest), if csv { "csv" } else { "nc" })
        })
    }
}

/// Largest `parameters` field (bytes).
const MAX_PARAMETERS_BYTES: usize = 1 << 20;

/// Takes the upload, up to the limit on bodies.
pub(super) async fn take<P: DeserializeOwned>(
    app: &AppState,
    parts: &Parts,
    body: Body,
) -> Result<Upload<P>, Problem> {
    let kind = media_type(&parts.headers);
    let mut incoming = Incoming::new(body, app.settings.body_pause_timeout_s);
    let limit = app.settings.max_body_bytes;
    if content_length(&parts.headers)
        .is_some_and(|length| length > limit.saturating_add(MAX_PARAMETERS_BYTES as u64))
    {
        return Err(incoming.refuse_length(limit).await);
    }
    match kind.as_deref() {
        Some("multipart/form-data") => multipart(app, parts, incoming).await,
        Some(kind) if !kind.starts_with("text/") && kind != "application/octet-stream" => {
            let detail = format!(
                "a program comes as text/*, application/octet-stream, multipart/form-data or without a type, not as {kind}"
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
            Ok(Upload { program, file_name: given_name(&parts.headers), media_type: kind, parameters })
        }
    }
}

async fn multipart<P: DeserializeOwned>(
    app: &AppState,
    parts: &Parts,
    incoming: Incoming,
) -> Result<Upload<P>, Problem> {
    let mut request = Request::from_parts(parts.clone(), incoming.into_body());
    *request.method_mut() = http::Method::POST;
    let mut form = Multipart::from_request(request, app)
        .await
        .map_err(|fault| Problem::new(ProblemType::MalformedRequest, fault.body_text()))?;
    let mut parameters: Option<P> = None;
    let mut program: Option<(Draft, Option<String>, Option<String>)> = None;
    while let Some(mut field) = paused(app, form.next_field()).await? {
        match field.name().unwrap_or_default() {
            "parameters" if parameters.is_none() => {
                let mut text = Vec::new();
                while let Some(chunk) = paused(app, field.chunk()).await? {
                    text.extend_from_slice(&chunk);
                    if text.len() > MAX_PARAMETERS_BYTES {
                        let detail =
                            format!("the field parameters is larger than {MAX_PARAMETERS_BYTES} bytes");
                        return Err(Problem::new(ProblemType::BodyTooLarge, detail));
                    }
                }
                parameters = Some(read_json(&text)?);
            }
            "program" if program.is_none() => {
                let name = field.file_name().and_then(clean_name);
                let kind = field.content_type().map(str::to_owned);
                let mut spooling: Spooling = app.spool.begin()?;
                while let Some(chunk) = paused(app, field.chunk()).await? {
                    spooling.take(&chunk).await?;
                }
                program = Some((spooling.finish().await?, name, kind));
            }
            name => {
                let known = matches!(name, "parameters" | "program");
                let detail =
                    if known { "the field is there more than once" } else { "there is no such field" };
                let fault = Fault::new(format!("/{name}"), detail);
                return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
            }
        }
    }
    let Some((program, file_name, media_type)) = program else {
        let fault = Fault::new("/program", "the file field program is missing");
        return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
    };
    let query = parts.uri.query().unwrap_or_default();
    let parameters = match parameters {
        Some(_) if !query.is_empty() => {
            let fault =
                Fault::new("/parameters", "parameters come in the field or in the query, not in both");
            return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
        }
        Some(parameters) => parameters,
        None => read_query(query)?,
    };
    Ok(Upload { program, file_name, media_type, parameters })
}

async fn paused<T>(
    app: &AppState,
    next: impl Future<Output = Result<T, axum::extract::multipart::MultipartError>>,
) -> Result<T, Problem> {
    let pause_s = app.settings.body_pause_timeout_s;
    match tokio::time::timeout(std::time::Duration::from_secs_f64(pause_s), next).await {
        Ok(read) => read.map_err(|fault| Problem::new(ProblemType::MalformedRequest, fault.body_text())),
        Err(_elapsed) => {
            let detail = format!("no byte of the body arrived for {pause_s} s");
            Err(Problem::new(ProblemType::RequestTimeout, detail))
        }
    }
}

/// The name that a plain upload carries in its Content-Disposition.
fn given_name(headers: &HeaderMap) -> Option<String> {
    let value = headers.get(http::header::CONTENT_DISPOSITION)?.to_str().ok()?;
    let (_, name) = value.split_once("filename=")?;
    clean_name(name.split(';').next()?.trim().trim_matches('"'))
}

/// The last part of a path with only characters that are safe in a header and in a shell.
pub(in crate::http) fn clean_name(name: &str) -> Option<String> {
    let last = name.rsplit(['/', '\\']).next()?;
    let safe = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let clean: String = last.chars().take(120).map(safe).collect();
    let clean = clean.trim_start_matches('.').to_owned();
    if clean.is_empty() { None } else { Some(clean) }
}
