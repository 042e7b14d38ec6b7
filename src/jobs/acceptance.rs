//! Facts that are fixed when work is accepted: the wear of the tools, and whether a requested step was already
//! applied to this program.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use super::{
    CompensatorFault, JobFault, KeptShelf, KeptWear, MachineUsed, Refusal, RefusalClass, Sources, ToolShelf,
    UnfitEntries, WhyUnfit,
};
use crate::machine::Tool;
use crate::program::{StepName, Steps};
use crate::store::{JobRow, Store, StoreError};
use crate::wear::{has_fallen, most_wear};
use crate::wire::{ResolvedWear, WearEntry, tools_of_report};

/// The data that a job was accepted with beside its parameters, as it is stored.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// The machine's tools.
    #[serde(flatten)]
    pub shelf: KeptShelf,
    /// A requested step that was already applied to the program: the job fails with this step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<String>,
    /// Names of the steps of earlier jobs that wrote the program as their output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps_done: Option<String>,
}

impl Accepted {
    /// The data that a job was accepted with; empty for a job of an older version, and for one that did not wait.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn of(row: &JobRow) -> Result<Self, JobFault> {
        let read = row.accepted.as_deref().map(serde_json::from_str).transpose();
        Ok(read.map_err(|_stored_is_sound| JobFault::MachineLost)?.unwrap_or_default())
    }

    /// The steps of earlier jobs that wrote the program.
    pub(super) fn steps_done(&self) -> Steps {
        self.steps_done.as_deref().and_then(Steps::from_names).unwrap_or(Steps::NONE)
    }
}

/// The machine at the time when a job was accepted, with these tools.
///
/// # Errors
/// Its revision or one of the tools is missing, or the database failed.
pub(super) async fn machine_then(
    store: &Store,
    row: &JobRow,
    kept: &KeptShelf,
) -> Result<MachineUsed, JobFault> {
    let (id, revision) = (&row.document.machine_id, row.document.machine_revision);
    let found = store.machine_revision(id, revision).await?.ok_or(JobFault::MachineLost)?;
    let tools = store.tools_at(id, &kept.tools).await?;
    if tools.len() != kept.tools.len() {
        return Err(JobFault::MachineLost);
    }
    let shelf = ToolShelf::new(tools).worn(kept.wear.clone(), kept.unfit.clone());
    MachineUsed::new(id.clone(), revision, found.document.profile, shelf)
        .map_err(|_stored_is_sound| JobFault::MachineLost)
}

/// The machine of a job that ended, with the tools that it was accepted with or, if it did not wait, those of its
/// report.
///
/// # Errors
/// Its revision or one of the tools is missing, or the database failed.
pub(super) async fn machine_of_job(store: &Store, row: &JobRow) -> Result<MachineUsed, JobFault> {
    let kept = match &row.accepted {
        Some(_) => Accepted::of(row)?.shelf,
        None => KeptShelf {
            tools: tools_of_report(row.report.as_deref().unwrap_or_default()),
            ..KeptShelf::default()
        },
    };
    machine_then(store, row, &kept).await
}

/// The machine with the wear of this cutter on its shelf, if the wear of a cutter is requested.
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
    let entries = store.newest_and_most_wear(&on.machine_id, cutter_id).await?;
    let (worn, unfit) = worn(&on.shelf, cutter_id, entries, sources.clock.now());
    on.shelf = on.shelf.worn(worn, unfit);
    Ok(on)
}

/// The wear of each tool of the table from the newest entries of its edges, and the tools whose entries do not give
/// it. For each edge, `entries` has the newest entry first. If another entry has more wear, it comes after.
fn worn(
    shelf: &ToolShelf,
    cutter_id: &str,
    entries: Vec<WearEntry>,
    now: Timestamp,
) -> (Vec<ResolvedWear>, Vec<UnfitEntries>) {
    let mut by_tool: BTreeMap<String, Vec<WearEntry>> = BTreeMap::new();
    for entry in entries {
        by_tool.entry(entry.tool_id.clone()).or_default().push(entry);
    }
    let (mut all, mut unfit) = (Vec::new(), Vec::new());
    for (tool_id, entries) in by_tool {
        let Some(tool) = shelf.tools().iter().find(|tool| tool.tool_id == tool_id) else { continue };
        match worn_by(&entries, tool.document.cutter()) {
            Ok(newest) => all.extend(resolved(tool_id, cutter_id, &newest, now)),
            Err(why) => unfit.push(UnfitEntries { tool_id, why }),
        }
    }
    (all, unfit)
}

fn kept((entry, wear_um): (&WearEntry, f64)) -> KeptWear {
    (entry.id.clone(), wear_um)
}

/// The entries of a tool that are used: the newest of each edge. An entry of the whole cutter replaces older entries
/// of its edges.
fn worn_by(entries: &[WearEntry], nominal: Option<Tool>) -> Result<Vec<&WearEntry>, WhyUnfit> {
    let of_radius: Vec<(&WearEntry, f64)> =
        entries.iter().filter_map(|entry| Some((entry, entry.radius_wear_um?))).collect();
    if of_radius.is_empty() {
        let newest = entries.iter().max_by(|a, b| a.measured_at.cmp(&b.measured_at));
        return newest.map_or(Ok(Vec::new()), |entry| Err(WhyUnfit::FlankAlone { newest: entry.id.clone() }));
    }
    let mut edges = BTreeSet::new();
    let mut newest = of_radius.clone();
    newest.retain(|(entry, _)| edges.insert(&entry.edge));
    if let Some(whole) = newest.iter().find(|(entry, _)| entry.edge.is_none()).map(|(entry, _)| *entry) {
        let is_newer = |entry: &WearEntry| entry.edge.is_some() && entry.measured_at > whole.measured_at;
        let any_newer = newest.iter().any(|(entry, _)| is_newer(entry));
        newest
            .retain(|(entry, _)| entry.edge.is_some() == any_newer && entry.measured_at >= whole.measured_at);
    }
    for (entry, wear_um) in &newest {
        // Earlier measurements of the same edge or of the whole cutter; for the whole cutter, earlier measurements of
        // any edge.
        let is_before = |earlier: &WearEntry| {
            earlier.measured_at <= entry.measured_at
                && (entry.edge.is_none() || earlier.edge.is_none() || earlier.edge == entry.edge)
        };
        let before = of_radius.iter().filter(|(earlier, _)| is_before(earlier));
        let most = before.max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(earlier) = most.filter(|(_, most_um)| has_fallen(*most_um, *wear_um)) {
            return Err(WhyUnfit::Fallen { newest: kept((entry, *wear_um)), earlier: kept(*earlier) });
        }
    }
    let largest = newest.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let most_um = nominal.map_or(f64::INFINITY, |tool| most_wear(tool.radius()).um());
    match largest.filter(|(_, wear_um)| *wear_um > most_um) {
        Some(largest) => Err(WhyUnfit::TooMuch { largest: kept(*largest) }),
        None => Ok(newest.into_iter().map(|(entry, _)| entry).collect()),
    }
}

/// The wear from these entries, as the report states it.
fn resolved(
    tool_id: String,
    cutter_id: &str,
    entries: &[&WearEntry],
    now: Timestamp,
) -> Option<ResolvedWear> {
    let measured_at = entries.iter().map(|entry| entry.measured_at.clone()).max()?;
    let age_s = measured_at.parse::<Timestamp>().ok().map(|at| now.duration_since(at).as_secs_f64())?;
    Some(ResolvedWear {
        tool_id,
        cutter_id: cutter_id.to_owned(),
        radius_wear_um: entries.iter().filter_map(|entry| entry.radius_wear_um).fold(0.0, f64::max),
        measured_at,
        // Clocks differ: an entry may be dated after the request.
        age_days: age_s.max(0.0) / S_PER_DAY,
        entry_ids: entries.iter().map(|entry| entry.id.clone()).collect(),
    })
}

/// Seconds in a day.
const S_PER_DAY: f64 = 86_400.0;

/// The steps of earlier jobs that wrote a program with this digest, on machines that the caller reaches.
///
/// # Errors
/// The database failed.
pub async fn steps_done(
    store: &Store,
    sha256: &str,
    machines: Option<&BTreeSet<String>>,
) -> Result<Steps, StoreError> {
    let behind = store.steps_behind(sha256, machines).await?;
    Ok(behind.iter().filter_map(|names| Steps::from_names(names)).fold(Steps::NONE, Steps::and))
}

/// The refusal of such a step.
#[must_use]
pub fn already_done(step: &str) -> JobFault {
    let class = RefusalClass::AlreadyCompensated;
    let is_repeatable =
        Steps::from_names(step).and_then(|steps| steps.iter().next()).is_some_and(StepName::may_be_repeated);
    let cure = if is_repeatable {
        "To do it again, set allow_repeated=true"
    } else {
        "A second time would move every end twice. Send the program from before that step"
    };
    let detail = format!("the program is the result of an earlier step `{step}`. {cure}");
    let refusal = Refusal { class, detail, line: None, block: None, errors: Vec::new() };
    JobFault::Compensator(CompensatorFault::Refused(Box::new(refusal)))
}
