//! The machine that a program is for: a profile in a file, or a preset by its name.

use std::path::Path;

use super::CompensateArguments;
use super::parameters::read_within;
use crate::cli::CommandFault;
use crate::jobs::{MachineUsed, ToolShelf};
use crate::wire::{MachineProfile, example_machine, presets, read_json};

/// The names of all presets, and of the example machine.
pub(super) fn preset_names() -> Vec<&'static str> {
    let example = example_machine().map(|(id, _)| id);
    presets().iter().map(|preset| preset.id).chain(example).collect()
}

/// The machine of the arguments.
///
/// # Errors
/// There is no such profile or preset, or the profile is refused.
pub(super) fn machine(
    arguments: &CompensateArguments,
    limit_bytes: u64,
) -> Result<MachineUsed, CommandFault> {
    if let Some(path) = &arguments.machine {
        return in_file(path, limit_bytes);
    }
    let name = arguments.preset.as_deref().unwrap_or_default();
    let preset = presets().into_iter().find(|preset| preset.id == name).map(|preset| preset.profile);
    let example = || example_machine().filter(|(id, _)| *id == name).map(|(_, profile)| profile);
    let profile = preset
        .or_else(example)
        .ok_or_else(|| CommandFault::NoPreset { given: name.to_owned(), known: preset_names().join(", ") })?;
    used(name.to_owned(), 0, profile)
}

fn used(machine_id: String, revision: i64, profile: MachineProfile) -> Result<MachineUsed, CommandFault> {
    MachineUsed::new(machine_id, revision, profile, ToolShelf::default()).map_err(CommandFault::Machine)
}

fn in_file(path: &Path, limit_bytes: u64) -> Result<MachineUsed, CommandFault> {
    let text = read_within(path, "max_json_bytes", limit_bytes)?;
    let (text, machine_id, revision) = profile_alone(text);
    let profile: MachineProfile = read_json(&text).map_err(CommandFault::UnreadableMachine)?;
    let machine_id = machine_id.unwrap_or_else(|| profile.name.clone());
    used(machine_id, revision, profile)
}

/// A profile in the form in which it is sent to a service, with the id and revision if it was read from one;
/// else the revision is 0.
fn profile_alone(text: Vec<u8>) -> (Vec<u8>, Option<String>, i64) {
    let Ok(serde_json::Value::Object(mut members)) = serde_json::from_slice(&text) else {
        return (text, None, 0);
    };
    let Some(machine_id) = members.remove("machine_id") else { return (text, None, 0) };
    let machine_id = machine_id.as_str().map(str::to_owned);
    members.remove("created_at");
    let revision = members.remove("revision").and_then(|revision| revision.as_i64());
    let text = serde_json::Value::Object(members).to_string().into_bytes();
    (text, machine_id, revision.unwrap_or_default())
}
