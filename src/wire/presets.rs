//! Starting points for a profile.

use serde::Serialize;
use utoipa::ToSchema;

use super::{Drive, Drives, MachineProfile, ProgramUnit};
use crate::machine::{EXAMPLE_ID, PRESETS, Preset as Layout};
use crate::servo::{AxisLetter, DRIVE_PRESETS, DrivePreset};

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

/// A drive with where its numbers come from.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = DrivePreset)]
pub struct DrivePresetDoc {
    /// Its name.
    #[schema(example = "reference-linear")]
    pub id: &'static str,
    /// In a few words.
    pub title: &'static str,
    /// Axes it is made for.
    pub axes: Vec<String>,
    /// Constants that no source gives; all others are published values.
    pub assumed: Vec<&'static str>,
    /// The constants.
    pub drive: Drive,
}

/// Every drive preset.
#[must_use]
pub fn drive_presets() -> Vec<DrivePresetDoc> {
    let document = |preset: &DrivePreset| {
        let axis = preset.axes.first().copied().unwrap_or(AxisLetter::X);
        DrivePresetDoc {
            id: preset.id,
            title: preset.title,
            axes: preset.axes.iter().map(ToString::to_string).collect(),
            assumed: preset.assumed.to_vec(),
            drive: Drive::from_core(axis, &preset.drive),
        }
    };
    DRIVE_PRESETS.iter().map(document).collect()
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
    let preset = Layout::by_id(EXAMPLE_ID)?;
    let mut profile = MachineProfile::from(&preset.parts());
    // The documentation's programs are in millimetres. A preset is somebody's machine, of whose programs nothing is known.
    profile.program_unit = Some(ProgramUnit::Mm);
    profile.drives = Some(reference_drives());
    Some((preset.id, profile))
}

/// The reference drives on every axis of the example machine.
fn reference_drives() -> Drives {
    let mut drives = Drives::default();
    for (id, axes) in [
        ("reference-linear", &[AxisLetter::X, AxisLetter::Y, AxisLetter::Z][..]),
        ("reference-rotary", &[AxisLetter::A, AxisLetter::C]),
    ] {
        for axis in axes {
            *drives.slot(*axis) = DrivePreset::by_id(id).map(|preset| Drive::from_core(*axis, &preset.drive));
        }
    }
    drives
}
