//! Wear entries that do not tell the worn cutter.

use thiserror::Error;

use crate::units::Length;

/// A wear entry and what it says.
#[derive(Debug, Clone, PartialEq)]
pub struct EnteredWear {
    /// The entry.
    pub entry: String,
    /// What the radius is smaller by \[µm\].
    pub wear_um: f64,
}

/// Why the wear entries of a tool do not tell its worn cutter.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnfitWear {
    /// More than entries are believed.
    #[error(
        "wear entry {} says that the radius is {} µm smaller, and more than {:.1} µm is not taken from entries: a fifth of the nominal radius of {} mm. If it is true, state the worn cutter in the request (`actual_tool`), else withdraw the entry",
        .largest.entry, .largest.wear_um, .most.um(), .radius.mm()
    )]
    TooMuch {
        /// The entry.
        largest: EnteredWear,
        /// The most that is taken from entries.
        most: Length,
        /// Nominal radius.
        radius: Length,
    },
    /// Wear that grew back.
    #[error(
        "wear entry {} says {} µm, after {} µm in entry {} of the same cutter. Wear does not grow back: withdraw the wrong entry, record a new cutter under its own `cutter_id`, or state the worn cutter in the request (`actual_tool`)",
        .newest.entry, .newest.wear_um, .earlier.wear_um, .earlier.entry
    )]
    Fallen {
        /// What was measured last.
        newest: EnteredWear,
        /// What was measured before.
        earlier: EnteredWear,
    },
    /// Entries of flank wear alone.
    #[error(
        "its wear entries under this `cutter_id` (the newest is {newest}) have `flank_wear_um` and no `radius_wear_um`, and a land of wear does not tell the radius. State the worn cutter in the request (`actual_tool`), or enter the `radius_wear_um` under a `cutter_id` of its own"
    )]
    FlankAlone {
        /// The newest of them.
        newest: String,
    },
}

impl UnfitWear {
    /// Whether the entries say what cannot be, so that nothing is done with the tool until somebody has looked.
    pub(in crate::process) const fn is_doubtful(&self) -> bool {
        matches!(self, Self::TooMuch { .. } | Self::Fallen { .. })
    }
}
