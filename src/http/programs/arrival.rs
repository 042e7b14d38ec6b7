//! The steps of every operation on an uploaded program: take the upload, do the work, store the job, answer in the
//! requested form.

use std::sync::Arc;

use axum::extract::Request;
use axum::response::Response;

use super::answer;
use super::several::calls_no_files;
use super::upload::{Part, Upload, take};
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::current_machine::current_machine;
use crate::http::idempotency::{key, remembered, unless_keyed, used};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::request_facts::caller;
use crate::jobs::memory::will_take;
use crate::jobs::{
    ProgramJob, ProgramParameters, ProgramWork, Sizes, already_done, run_program_job, steps_done, with_wear,
};
use crate::store::{Draft, JobRow};

/// Performs an operation on the program of a request, and answers with the best of `offers` for the client.
///
/// # Errors
/// No such machine; an unreadable key or a key that was used for another request; an unreadable upload; wrong
/// parameters; work without a result.
pub(super) async fn operate<P: ProgramParameters>(
    app: &AppState,
    machine_id: String,
    request: Request,
    offers: &[&'static str],
) -> Result<Response, Problem> {
    let kind = choose(request.headers(), offers)?;
    let job = job::<P>(app, machine_id, request).await?;
    answer::job(app, &job, kind).await
}

/// The job of a request: the job that it created before with the same key, or a new one.
async fn job<P: ProgramParameters>(
    app: &AppState,
    machine_id: String,
    request: Request,
) -> Result<JobRow, Problem> {
    let (parts, body) = request.into_parts();
    let key = key(&parts)?;
    let on = unless_keyed(key.as_ref(), current_machine(app, &machine_id).await)?;
    let part = if P::LOOKS_AT_PART { Part::Seen } else { Part::Unseen };
    let upload: Upload<P> = take(app, &parts, body, part).await?;
    let Upload { program, file_name, has_files, surface, parameters } = upload;
    if has_files && !P::CALLS_FILES {
        return Err(calls_no_files());
    }
    let mut said = vec![program.sha256(), serde_json::to_string(&parameters).unwrap_or_default()];
    said.extend(surface.as_ref().map(Draft::sha256));
    let used = used(app, &parts, key, &said.iter().map(String::as_str).collect::<Vec<_>>());
    if let Some(job) = remembered(app, used.as_ref()).await? {
        return Ok(job);
    }
    let on = Arc::unwrap_or_clone(on?);
    let machines = caller(&parts.extensions)?.machines;
    let steps_done = steps_done(&app.store, &program.sha256(), machines.as_deref()).await?;
    if let Some(step) = parameters.steps().shared_with(steps_done) {
        return Err(already_done(step.name()).into());
    }
    let on = with_wear(&app.store, &app.sources, on, parameters.cutter_id()).await?;
    let machine_revision = on.revision;
    let sizes = Sizes::of_drafts(&program, surface.as_ref())?;
    will_take(parameters.working_bytes());
    let work = ProgramWork::new(parameters, on, sizes, &app.means())?;
    let job = ProgramJob {
        machine_id,
        machine_revision,
        work,
        repeats: None,
        steps_done,
        program,
        surface,
        file_name,
        used,
        by: actor(&parts)?,
    };
    Ok(run_program_job(&app.compute, &app.store, &app.spool, &app.sources, job).await?)
}
