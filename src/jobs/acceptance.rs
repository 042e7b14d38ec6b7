//! What is settled when work is accepted: the wear of the tools, and whether the steps asked for were done to this program before.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use super::{CompensatorFault, JobFault, KeptShelf, MachineUsed, Refusal, RefusalClass, Sources, ToolShelf};
use crate::program::{Step, Steps};
use crate::store::{Store, StoreError};
use crate::wire::{ResolvedWear, WearEntry};

/// What a job was accepted with beside its parameters, as it is stored.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// The machine's tools.
    #[serde(flatten)]
    pub shelf: KeptShelf,
    /// A step that is asked for and was done to the program before: the job fails with that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<String>,
}

/// The machine with the wear of this cutter on its shelf, where a cutter's is asked for.
///
/// # Errors
/// The database failed.
pub async fn with_wear(
    store: &Store,
    sources: &Sources,
    mut on: MachineUsed,
    cutter_id: Option<&str>,
) -> Result<MachineUsed, StoreError> {
    let Some(cutter_id) = cutter_id else { return Ok(on) };
    let entries = store.newest_radius_wear(&on.machine_id, cutter_id).await?;
    on.shelf = on.shelf.worn(worn(&on.shelf, cutter_id, entries, sources.clock.now()));
    Ok(on)
}

/// The wear of each tool of the table by the newest entries of its edges. One of the cutter as a whole takes the place of those of
/// its edges that are older.
fn worn(shelf: &ToolShelf, cutter_id: &str, entries: Vec<WearEntry>, now: Timestamp) -> Vec<ResolvedWear> {
    let mut by_tool: BTreeMap<String, Vec<WearEntry>> = BTreeMap::new();
    for entry in entries {
        by_tool.entry(entry.tool_id.clone()).or_default().push(entry);
    }
    let of_tool = |(tool_id, mut entries): (String, Vec<WearEntry>)| {
        let is_listed = shelf.tools().iter().any(|tool| tool.tool_id == tool_id);
        let whole = entries.iter().find(|entry| entry.edge.is_none()).map(|entry| entry.measured_at.clone());
        if let Some(whole) = whole {
            let any_newer = entries.iter().any(|entry| entry.edge.is_some() && entry.measured_at > whole);
            entries.retain(|entry| entry.edge.is_some() == any_newer && entry.measured_at >= whole);
        }
        let newest = entries.iter().map(|entry| entry.measured_at.clone()).max()?;
        let age_s = newest.parse::<Timestamp>().ok().map(|at| now.duration_since(at).as_secs_f64())?;
        let radius_wear_um = entries.iter().filter_map(|entry| entry.radius_wear_um).fold(0.0, f64::max);
        is_listed.then(|| ResolvedWear {
            tool_id,
            cutter_id: cutter_id.to_owned(),
            radius_wear_um,
            measured_at: newest,
            age_days: age_s / S_PER_DAY,
            entry_ids: entries.into_iter().map(|entry| entry.id).collect(),
        })
    };
    by_tool.into_iter().filter_map(of_tool).collect()
}

/// Seconds in a day.
const S_PER_DAY: f64 = 86_400.0;

/// The first of these steps that made a program of this digest, on a machine that the caller reaches.
///
/// # Errors
/// The database failed.
pub async fn repeated_step(
    store: &Store,
    sha256: &str,
    steps: Steps,
    machines: Option<&BTreeSet<String>>,
) -> Result<Option<Step>, StoreError> {
    if steps.is_empty() {
        return Ok(None);
    }
    let behind = store.steps_behind(sha256, machines).await?;
    let done = behind.iter().filter_map(|names| Steps::from_names(names)).fold(Steps::NONE, Steps::and);
    Ok(steps.shared_with(done))
}

/// The refusal of such a step.
#[must_use]
pub fn already_done(step: &str) -> JobFault {
    let class = RefusalClass::AlreadyCompensated;
    let is_repeatable =
        Steps::from_names(step).and_then(|steps| steps.iter().next()).is_some_and(Step::may_be_repeated);
    let cure = if is_repeatable {
        "allow_repeated=true does it again"
    } else {
        "a second time would move every end twice; take the program as it was before"
    };
    let detail = format!("the program is what the step `{step}` answered before: {cure}");
    let refusal = Refusal { class, detail, line: None, block: None, errors: Vec::new() };
    JobFault::Compensator(CompensatorFault::Refused(Box::new(refusal)))
}
