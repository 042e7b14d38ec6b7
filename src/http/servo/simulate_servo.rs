//! One path at one feed.

use std::sync::Arc;

use axum::extract::{FromRequest, Request, State};
use axum::response::{IntoResponse, Response};
use http::request::Parts;
use serde::Serialize;

use super::figures::{SVG, SimulationFigure, respond};
use super::{OFFERS, work};
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::caller::Caller;
use crate::http::current_machine::current_machine;
use crate::http::extract::{Json, Query};
use crate::http::idempotency::{key, remembered, used};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::programs::answer;
use crate::http::programs::upload::clean_name;
use crate::http::refusals::refusals;
use crate::http::request_facts::caller;
use crate::jobs::memory;
use crate::jobs::{CompensatorFault, JobFault, ProgramJob, ProgramWork, Sizes, run_program_job};
use crate::program::Steps;
use crate::wire::{
    Fault, FaultList, ServoPathDoc, ServoProgramParameters, ServoReport, SimulationAnswer, SimulationRequest,
};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, KeyReused, ProgramFault, UnitUnknown, UnreachablePose, UnstableLoop, TooCostly, Busy
);

/// The answer for a path or for a program.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the answer")]
enum PathOrProgram {
    /// The answer for a path.
    Path(SimulationAnswer),
    /// The answer for a program.
    Program(ServoReport),
}

/// Simulate the servo drives along a path
///
/// Following error of each axis and contour error of the tool, from the loop gains and the feed; the commanded path
/// is the reference. With `Accept: image/svg+xml` the answer is a figure. If the path is a program, the run is stored
/// as a job that `Location` names, and its report is the answer.
#[operation(
    post,
    path = "/v1/servo-simulations",
    tag = "servo",
    operation_id = "simulate_servo",
    params(
        SimulationFigure,
        ("Idempotency-Key" = Option<String>, Header, description = "For a program: the same key with the same request returns the same answer"),
    ),
    request_body(
        content((SimulationRequest = "application/json", examples(
            ("program" = (summary = "A program, kept as a job", value = json!({
                "machine_id": "example-ac-table",
                "work_offset_mm": [0.0, 0.0, 0.0],
                "path": {
                    "kind": "program", "file_name": "turn.nc",
                    "text": "G90 G21 G94\nG1 X10 Y0 Z5 A10 C20 F1000\nG1 X20 Y0 Z5 A25 C60\nM30\n"
                }
            }))),
            ("path" = (summary = "A circle of X and C", value = json!({
                "machine_id": "example-ac-table",
                "path": {"kind": "xc-circle", "radius_mm": 60.0, "center_x_mm": 100.0},
                "feed_mm_per_min": 1800.0,
                "position_gain_scale": {"C": 0.8333}
            }))),
        ))),
    ),
    responses(
        (status = 200, description = "The result of the simulation",
            content((PathOrProgram = "application/json"), (String = "image/svg+xml")),
            headers(("Location" = String, description = "The job, if the path is a program"))),
        Refusals,
    )
)]
pub(super) async fn simulate_servo(
    State(app): State<AppState>,
    Query(figure): Query<SimulationFigure>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let (kind, caller) = (choose(&parts.headers, OFFERS)?, caller(&parts.extensions)?);
    // A bad choice of figure is refused for every kind of path.
    let key = key(&parts)?;
    let Json(request) =
        Json::<SimulationRequest>::from_request(Request::from_parts(parts.clone(), body), &app).await?;
    if let ServoPathDoc::Program { .. } = &request.path {
        return Box::pin(program(&app, &caller, (&parts, key), &request, kind)).await;
    }
    let (revision, work, ()) =
        work(&app, &caller, request.options(), |task, faults| request.apply(task, faults)).await?;
    let (drives, axes, feed) = (work.task.drives, work.axes(), work.task.run.feed);
    let account = memory::account();
    let simulation = app.compute.run(move |stop| work.simulate(account.as_ref(), stop)).await??;
    let answer = SimulationAnswer::of(revision, &simulation, &drives, &axes);
    if kind == SVG {
        let gains = &request.position_gain_scale;
        return Ok(respond(figure.draw(&request.path, feed.mm_per_min(), gains, &answer)));
    }
    Ok(Json(answer).into_response())
}

/// A program: it is simulated and stored as a job.
async fn program(
    app: &AppState,
    caller: &Caller,
    (parts, key): (&Parts, Option<String>),
    request: &SimulationRequest,
    kind: &str,
) -> Result<Response, Problem> {
    let (ServoPathDoc::Program { text, file_name, .. }, Some(parameters)) =
        (&request.path, ServoProgramParameters::of(request))
    else {
        return Err(Problem::internal(&"only a program is a program"));
    };
    if let Some(machine_id) = &request.machine_id {
        caller.must_reach(machine_id)?;
    }
    let said = serde_json::to_string(request).map_err(|fault| Problem::internal(&fault))?;
    let used = used(app, parts, key, &[&said]);
    if let Some(job) = remembered(app, used.as_ref()).await? {
        return answer::job(app, &job, kind).await;
    }
    // This check comes after the remembered answer, which outlives the machine.
    let current = match &request.machine_id {
        None => None,
        Some(machine_id) => Some((machine_id.clone(), current_machine(app, machine_id).await?)),
    };
    let mut faults = FaultList::default();
    if request.drives.is_some() {
        let detail = "a program is simulated with the drives in its machine's profile; give machine_id and leave this out";
        faults.push(|| Fault::new("/drives", detail));
    }
    if request.laps.is_some() {
        faults.push(|| Fault::new("/laps", "an open path has no laps; remove this member"));
    }
    let drives = current.as_ref().and_then(|(_, machine)| machine.drives.as_ref());
    parameters.to_core(drives, &mut faults);
    faults.into_result().map_err(|faults| at_the_path(JobFault::Parameters(faults)))?;
    let Some((machine_id, on)) = current else {
        return Err(Problem::internal(&"a program without a machine has no fault"));
    };
    let mut spooling = app.spool.begin()?;
    spooling.take(&bytes::Bytes::from(text.clone())).await?;
    let file_name = file_name.as_deref().and_then(clean_name).unwrap_or_else(|| "program.nc".to_owned());
    let (program, machine_revision) = (spooling.finish().await?, on.revision);
    let sizes = Sizes { program_length: program.length(), surface_facets: None };
    let work =
        ProgramWork::new(parameters, Arc::unwrap_or_clone(on), sizes, &app.means()).map_err(at_the_path)?;
    let by = actor(parts)?;
    let job = ProgramJob {
        machine_id,
        machine_revision,
        work,
        repeats: None,
        steps_done: Steps::NONE,
        program,
        surface: None,
        file_name,
        used,
        by,
    };
    let job = run_program_job(&app.compute, &app.store, &app.spool, &app.sources, job).await;
    answer::job(app, &job.map_err(at_the_path)?, kind).await
}

/// Members that are inside the path here, and outside it in the operation for programs.
const OF_THE_PATH: [&str; 7] =
    ["interpolation", "unit", "work_offsets_mm", "tool_number", "start", "dialect", "plane"];

/// A fault of the work on a program, with the location of the bad value in this request.
fn at_the_path(fault: JobFault) -> JobFault {
    let moved = |fault: Fault| {
        let member = fault.pointer.split('/').nth(1).unwrap_or_default();
        if OF_THE_PATH.contains(&member) {
            Fault { pointer: format!("/path{}", fault.pointer), ..fault }
        } else {
            fault
        }
    };
    match fault {
        JobFault::Parameters(faults) => JobFault::Parameters(faults.into_iter().map(moved).collect()),
        JobFault::Compensator(CompensatorFault::Refused(mut refusal)) => {
            refusal.errors = refusal.errors.into_iter().map(moved).collect();
            JobFault::Compensator(CompensatorFault::Refused(refusal))
        }
        other => other,
    }
}
