//! Servo simulations, sweeps and matchings; drives to start from.

mod figures;
mod list_drive_presets;
mod match_servo;
mod simulate_servo;
mod sweep_servo;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::AppState;
use super::problem::{Problem, ProblemType};
use crate::jobs::ServoWork;
use crate::wire::{FaultList, ServoOptions, ServoTask};

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(simulate_servo::simulate_servo))
        .routes(routes!(sweep_servo::sweep_servo))
        .routes(routes!(match_servo::match_servo))
        .routes(routes!(list_drive_presets::list_drive_presets))
}

/// What a servo operation answers.
const OFFERS: &[&str] = &["application/json", figures::SVG];

/// The work of a request, and the machine's revision; `more` adds what only this operation has. Every fault is named.
async fn work<T>(
    app: &AppState,
    options: ServoOptions<'_>,
    more: impl FnOnce(&mut ServoTask, &mut FaultList) -> T,
) -> Result<(Option<i64>, ServoWork, T), Problem> {
    let found = match options.machine_id {
        None => None,
        Some(id) => {
            Some(app.store.machine(id).await?.ok_or_else(|| Problem::machine_not_found(id))?.document)
        }
    };
    let revision = found.as_ref().map(|document| document.revision);
    let drives = found.as_ref().and_then(|document| document.profile.drives.clone());
    let machine = match found.map(|document| document.profile.into_machine()) {
        None => None,
        Some(Ok((_, machine))) => Some(machine),
        Some(Err(_stored_is_sound)) => {
            return Err(Problem::internal(&"a stored profile is no longer accepted"));
        }
    };
    let mut faults = FaultList::default();
    let on = machine.as_ref().map(|machine| (machine, drives.as_ref()));
    let task = options.to_core(on, &mut faults);
    // Without a task there are faults; what the operation adds can only be looked at with one.
    let Some(mut task) = task else {
        let faults = faults.into_result().err().unwrap_or_default();
        return Err(Problem::invalid(ProblemType::InvalidRequest, faults));
    };
    let own = more(&mut task, &mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    Ok((revision, ServoWork { task, machine, max_cost_s: app.settings.max_cost_s }, own))
}
