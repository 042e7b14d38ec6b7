//! Tool poses to axis words.

use std::io::Write;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::response::Response;
use http::{HeaderName, HeaderValue};

use super::table::{self, CSV, feed, is_table, offers};
use crate::description::operation;
use crate::http::AppState;
use crate::http::current_machine::current_machine;
use crate::http::extract::{Path, read_document};
use crate::http::negotiate::choose;
use crate::http::printed::{Printed, Unprinted, print_computed, print_here};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::jobs::memory::will_take;
use crate::jobs::{
    InverseAnswer, InverseTask, KinematicsFault, Limits, POSES_IN_MEMORY, PoseTable, ReceivedPoses,
    WaitingPoses,
};
use crate::machine::Machine;
use crate::process::Stop;
use crate::side_by_side::SideBySide;
use crate::wire::{
    InverseRequest, JointColumns, KinematicsOptions, Solutions, SolvedPoses, read_query, write_path_rows,
};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, UnreachablePose, TooCostly, ResultTooLarge, Busy
);

/// Turn tool poses into axis words
///
/// Request and answer are JSON, or `text/csv` with a header row. With CSV the options are query parameters,
/// `selection=all` adds a `pose` column, and the header `Trunnion-Warnings` has the number of warnings.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/inverse-kinematics",
    tag = "kinematics",
    operation_id = "solve_inverse_kinematics",
    params(("machine_id" = String, Path, description = "The machine", example = "example-ac-table"), KinematicsOptions),
    request_body(
        content(
            (InverseRequest = "application/json", example = json!({"poses": [{"x": 10.0, "y": 0.0, "z": 5.0, "i": 0.0, "j": -0.5, "k": 0.866}]})),
            (String = "text/csv", example = "x,y,z,i,j,k\n10,0,5,0,-0.5,0.866\n"),
        ),
        description = "Tool poses in the workpiece; i j k need not be of unit length",
    ),
    responses(
        (status = 200, description = "Axis words", content((SolvedPoses = "application/json"), (String = "text/csv"))),
        Refusals,
    )
)]
pub(super) async fn solve_inverse_kinematics(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let table = is_table(request.headers())?;
    let kind = choose(request.headers(), offers(table))?;
    let on = current_machine(&app, &machine_id).await?;
    let revision = on.revision;
    let csv = kind == CSV;
    let task_of = |options: &KinematicsOptions| -> Result<InverseTask, KinematicsFault> {
        let (setup, start_words_deg) = options.to_setup(&on.machine).map_err(KinematicsFault::Values)?;
        let selection = options.selection.unwrap_or_default();
        Ok(InverseTask::new(Arc::clone(&on), &setup, selection, start_words_deg))
    };
    // Bad options are told after the body was read.
    let may_wait = |options: &KinematicsOptions| csv && task_of(options).is_ok_and(|task| task.may_wait());
    let (poses, options) = read(&app, table, request, may_wait).await?;
    let limits = app.limits();
    let task = task_of(&options)?;
    let trifling = task.is_trifling(poses.len());
    let is_path_table = csv && task.is_path();
    let working_bytes =
        if is_path_table { task.deciding_bytes(poses.len()) } else { task.working_bytes(poses.len()) };
    will_take(working_bytes);
    let most = app.settings.max_result_bytes;
    let print = move |threads: &dyn SideBySide, stop: &Stop<'_>, printed: &mut Printed<usize>| {
        if is_path_table {
            return path_table(&task, poses, limits, most, threads, stop, printed);
        }
        // Only the poses of such a table wait in a file.
        let columns = poses.in_memory().map_err(|_in_file| {
            Problem::internal(&"poses of an answer that is made in memory wait in a file")
        })?;
        let InverseAnswer { solutions, warnings } = task.solve(columns, limits, stop)?;
        if csv {
            return rows(task.machine(), &solutions, warnings.len(), most, threads, printed);
        }
        let document = SolvedPoses::new(revision, solutions, warnings);
        printed.may_leave(0, document.most_json_bytes());
        Ok(document.write_json(threads, printed)?)
    };
    let leaving = if trifling {
        print_here(&app, print)?
    } else {
        // Boxed: otherwise its memory would be part of every small request's.
        Box::pin(print_computed(&app, print)).await?
    };
    if !csv {
        return Ok(table::document(leaving));
    }
    let (mut response, warnings) = table::table(revision, leaving);
    let name = HeaderName::from_static("trunnion-warnings");
    response.headers_mut().insert(name, HeaderValue::from(warnings));
    Ok(response)
}

/// Prints the table, if it does not exceed the largest length of a result.
fn rows(
    machine: &Machine,
    solutions: &Solutions,
    warnings: usize,
    limit: u64,
    threads: &dyn SideBySide,
    printed: &mut Printed<usize>,
) -> Result<(), Unprinted> {
    let columns = JointColumns::new(machine, matches!(solutions, Solutions::All { .. }));
    begin(columns, solutions.count(), warnings, limit, printed)?;
    Ok(solutions.write_rows(columns, threads, printed)?)
}

/// Decides a path and prints its table while its joints are made.
fn path_table(
    task: &InverseTask,
    poses: ReceivedPoses,
    limits: Limits,
    most: u64,
    threads: &dyn SideBySide,
    stop: &Stop<'_>,
    printed: &mut Printed<usize>,
) -> Result<(), Unprinted> {
    let mut poses = task.waiting::<Unprinted>(poses, limits)?;
    let done = path_rows(task, &poses, most, threads, stop, printed);
    // Poses that could not be read are the cause of whatever came of it.
    poses.take_fault().map_or(done, |fault| Err(fault.into()))
}

fn path_rows(
    task: &InverseTask,
    poses: &WaitingPoses,
    most: u64,
    threads: &dyn SideBySide,
    stop: &Stop<'_>,
    printed: &mut Printed<usize>,
) -> Result<(), Unprinted> {
    let (options, stop) = (task.path_options(), poses.or_unread(stop));
    let mut decided = task.decide(poses, &options, &stop)?;
    begin(JointColumns::new(task.machine(), false), decided.len(), decided.warnings(), most, printed)?;
    write_path_rows(task.machine(), &mut decided, threads, printed, |error| task.fault(error).into())
}

/// Prints the header row of a table. From then on the table may leave.
fn begin(
    columns: JointColumns,
    rows: usize,
    warnings: usize,
    limit: u64,
    printed: &mut Printed<usize>,
) -> Result<(), Unprinted> {
    let mut header = Vec::new();
    columns.write_header(&mut header);
    let most = table::most_bytes(&header, rows);
    table::within(limit, most)?;
    printed.may_leave(warnings, most);
    Ok(printed.write_all(&header)?)
}

/// The poses and the options. `may_wait` says whether the poses of a table may wait in a file.
#[expect(clippy::manual_async_fn, reason = "an async function would store the request twice")]
fn read(
    app: &AppState,
    table: bool,
    request: Request,
    may_wait: impl FnOnce(&KinematicsOptions) -> bool,
) -> impl Future<Output = Result<(ReceivedPoses, KinematicsOptions), Problem>> {
    async move {
        let query = request.uri().query().unwrap_or_default();
        if !table {
            table::no_options(query)?;
            let document = read_document(request, app, InverseRequest::read).await?;
            let options = document.options();
            return Ok((document.poses.into(), options));
        }
        let options = read_query(query)?;
        let may_wait = may_wait(&options);
        // Boxed: otherwise its memory would be part of every small request's.
        Ok((Box::pin(read_table(app, request, may_wait)).await?, options))
    }
}

/// The poses of a table. `may_wait` says whether they may wait in a file.
async fn read_table(app: &AppState, request: Request, may_wait: bool) -> Result<ReceivedPoses, Problem> {
    let (parts, body) = request.into_parts();
    let mut rows = PoseTable::in_memory(app.settings.max_poses);
    if may_wait {
        rows = rows.waiting_in(&app.spool, POSES_IN_MEMORY);
    }
    feed(app, &parts, body, &mut rows).await?;
    Ok(rows.finish().await??)
}
