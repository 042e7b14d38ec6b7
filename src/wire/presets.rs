//! Starting points for a profile.

use serde::Serialize;

use super::{Drive, Drives, MachineProfile, ProgramUnit};
use crate::description::ToSchema;
use crate::machine::{EXAMPLE_ID, PRESETS, Preset as Layout};
use crate::servo::{AxisLetter, DRIVE_PRESETS, DrivePreset};

/// A common layout of a machine; fill in its numbers, then store it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Preset {
    /// Id of the preset.
    #[schema(example = "ac-table")]
    pub id: &'static str,
    /// Short title.
    pub title: &'static str,
    /// Which axis carries the workpiece and which carries the tool.
    pub description: &'static str,
    /// The profile.
    pub profile: MachineProfile,
}

/// A drive, with the source of its numbers.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = DrivePreset)]
pub struct DrivePresetDoc {
    /// Id of the drive.
    #[schema(example = "reference-linear")]
    pub id: &'static str,
    /// Short title.
    pub title: &'static str,
    /// Axes that the drive is made for.
    pub axes: Vec<String>,
    /// Constants that were assumed because no source gives them; all others are published values.
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

/// Every preset except the example, which already exists as a machine.
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

/// Id and profile of the machine that an empty store starts with.
#[must_use]
pub fn example_machine() -> Option<(&'static str, MachineProfile)> {
    let preset = Layout::by_id(EXAMPLE_ID)?;
    let mut profile = MachineProfile::from(&preset.parts());
    // The programs of the documentation are in millimetres. A preset is a shop's machine, and its programs
    // are not known.
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
