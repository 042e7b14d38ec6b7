//! Starting points for a profile.

use serde::Serialize;
use utoipa::ToSchema;

use super::MachineProfile;
use crate::machine::{EXAMPLE_ID, PRESETS, Preset as Layout};

/// A common layout, ready to be put after its numbers are filled in.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Preset {
    /// Its name.
    #[schema(example = "ac-table")]
    pub id: &'static str,
    /// In a few words.
    pub title: &'static str,
    /// Which axis carries what.
    pub description: &'static str,
    /// The profile.
    pub profile: MachineProfile,
}

/// Every preset but the example, which is a machine already.
#[must_use]
pub fn presets() -> Vec<Preset> {
    PRESETS
        .iter()
        .filter(|preset| preset.id != EXAMPLE_ID)
        .map(|preset| Preset {
            id: preset.id,
            title: preset.title,
            description: preset.description,
            profile: MachineProfile::from(&preset.parts()),
        })
        .collect()
}

/// Id and profile of the machine an empty store begins with.
#[must_use]
pub fn example_machine() -> Option<(&'static str, MachineProfile)> {
    Layout::by_id(EXAMPLE_ID).map(|preset| (preset.id, MachineProfile::from(&preset.parts())))
}
