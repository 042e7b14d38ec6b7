//! Servo simulations, sweeps and matchings, and drive presets.

mod figures;
mod list_drive_presets;
mod match_servo;
mod simulate_servo;
mod sweep_servo;

use super::AppState;
use super::caller::Caller;
use super::current_machine::current_machine;
use super::described::resource;
use super::problem::{Problem, ProblemType};
use crate::jobs::ServoWork;
use crate::wire::{FaultList, ServoDraft, ServoOptions};

resource! {
    simulate_servo::simulate_servo,
    sweep_servo::sweep_servo,
    match_servo::match_servo,
    list_drive_presets::list_drive_presets,
}

/// Media types that a servo operation answers.
const OFFERS: &[&str] = &["application/json", figures::SVG];

/// The work of a request, and the machine's revision; `more` adds the part that only this operation has. Every fault
/// is reported.
async fn work<T>(
    app: &AppState,
    caller: &Caller,
    options: ServoOptions<'_>,
    more: impl FnOnce(&mut ServoDraft<'_>, &mut FaultList) -> T,
) -> Result<(Option<i64>, ServoWork, T), Problem> {
    let current = match options.machine_id {
        None => None,
        Some(id) => {
            caller.must_reach(id)?;
            Some(current_machine(app, id).await?)
        }
    };
    let mut faults = FaultList::default();
    let on = current.as_ref().map(|current| (&current.machine, current.drives.as_ref()));
    let mut draft = options.to_core(on, &mut faults);
    let own = more(&mut draft, &mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    let task = draft
        .into_task()
        .ok_or_else(|| Problem::internal(&"a request without faults has no path or no drives"))?;
    let revision = current.as_ref().map(|current| current.revision);
    let machine = current.map(|current| current.machine.clone());
    Ok((revision, ServoWork { task, machine, max_cost_s: app.settings.max_cost_s }, own))
}
