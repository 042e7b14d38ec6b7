//! Wear entries that do not give the worn cutter.

use thiserror::Error;

use crate::units::Length;

/// A wear entry and its value.
#[derive(Debug, Clone, PartialEq)]
pub struct EnteredWear {
    /// The entry.
    pub entry: String,
    /// The wear, as the radius lost \[µm\].
    pub wear_um: f64,
}

/// Why the wear entries of a tool do not give its worn cutter.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnfitWear {
    /// More wear than the service accepts from entries.
    #[error(
        "wear entry {} says that the radius is {} µm smaller. The limit for entries is {:.1} µm, a fifth of the nominal radius of {} mm. If the value is right, state the worn cutter in the request (`actual_tool`). If it is wrong, withdraw the entry",
        .largest.entry, .largest.wear_um, .most.um(), .radius.mm()
    )]
    TooMuch {
        /// The entry.
        largest: EnteredWear,
        /// Limit for entries.
        most: Length,
        /// Nominal radius.
        radius: Length,
    },
    /// The wear became less.
    #[error(
        "wear entry {} says {} µm, after {} µm in entry {} of the same cutter. Wear does not grow back: withdraw the wrong entry, record a new cutter under its own `cutter_id`, or state the worn cutter in the request (`actual_tool`)",
        .newest.entry, .newest.wear_um, .earlier.wear_um, .earlier.entry
    )]
    Fallen {
        /// The latest measurement.
        newest: EnteredWear,
        /// The measurement before it.
        earlier: EnteredWear,
    },
    /// The entries have flank wear only.
    #[error(
        "its wear entries under this `cutter_id` (the newest is {newest}) have `flank_wear_um` but no `radius_wear_um`. The radius does not follow from the flank wear. State the worn cutter in the request (`actual_tool`), or enter `radius_wear_um` under a new `cutter_id`"
    )]
    FlankAlone {
        /// The newest of these entries.
        newest: String,
    },
}

impl UnfitWear {
    /// Whether the entries are impossible. The tool is then not used until somebody has checked them.
    pub(in crate::process) const fn is_doubtful(&self) -> bool {
        matches!(self, Self::TooMuch { .. } | Self::Fallen { .. })
    }
}
