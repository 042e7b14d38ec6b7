//! What every operation on an uploaded program does first.

use axum::extract::Request;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::upload::{Part, Upload, take};
use crate::http::AppState;
use crate::http::current_machine::{CurrentMachine, current_machine};
use crate::http::idempotency::{key, remembered, used};
use crate::http::problem::Problem;
use crate::jobs::ProgramJob;
use crate::machine::Machine;
use crate::store::{Draft, JobRow, KeyUse};
use crate::wire::JobOperation;

/// A program that came in.
pub(super) enum Arrival<P> {
    /// The same request under the same key was answered before: its job.
    Answered(Box<JobRow>),
    /// One to be worked on.
    New(Box<NewProgram<P>>),
}

/// A program to be worked on, on its machine.
pub(super) struct NewProgram<P> {
    /// The machine as it is now.
    pub(super) current: CurrentMachine,
    /// Its parameters.
    pub(super) parameters: P,
    machine_id: String,
    upload: Upload<()>,
    used: Option<KeyUse>,
}

/// Takes a program for a machine, unless its key was answered before.
///
/// # Errors
/// No such machine, a key that cannot be taken or was used for another request, an upload that cannot be taken.
pub(super) async fn arrival<P: DeserializeOwned + Serialize>(
    app: &AppState,
    machine_id: String,
    request: Request,
    part: Part,
) -> Result<Arrival<P>, Problem> {
    let (parts, body) = request.into_parts();
    let key = key(&parts)?;
    let current = current_machine(app, &machine_id).await?;
    let Upload { program, file_name, media_type, surface, parameters }: Upload<P> =
        take(app, &parts, body, part).await?;
    let mut said = vec![program.sha256(), serde_json::to_string(&parameters).unwrap_or_default()];
    said.extend(surface.as_ref().map(Draft::sha256));
    let used = used(app, &parts, key, &said.iter().map(String::as_str).collect::<Vec<_>>());
    if let Some(job) = remembered(app, used.as_ref()).await? {
        return Ok(Arrival::Answered(Box::new(job)));
    }
    let upload = Upload { program, file_name, media_type, surface, parameters: () };
    Ok(Arrival::New(Box::new(NewProgram { current, parameters, machine_id, upload, used })))
}

impl<P: Serialize> NewProgram<P> {
    /// Whether the part's surface came with it.
    pub(super) fn has_surface(&self) -> bool {
        self.upload.surface.is_some()
    }

    /// The machine, the parameters, and the job to be done.
    pub(super) fn into_job(self, operation: JobOperation) -> Result<(Machine, P, ProgramJob), Problem> {
        let Self { current, parameters, machine_id, upload, used } = self;
        let job = ProgramJob {
            machine_id,
            machine_revision: current.revision,
            operation,
            parameters: serde_json::to_value(&parameters).map_err(|fault| Problem::internal(&fault))?,
            file_name: upload.name(),
            program: upload.program,
            surface: upload.surface,
            used,
        };
        Ok((current.machine, parameters, job))
    }
}
