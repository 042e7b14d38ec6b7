//! Measured wear as clients post it and as the service stores it.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::{Fault, FaultList};
use crate::description::ToSchema;

/// The quantity that was measured on a cutter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WearQuantity {
    /// Decrease of the cutter's radius.
    Radius,
    /// Width of the wear land on the flank.
    Flank,
}

impl WearQuantity {
    /// The word in documents.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Radius => "radius",
            Self::Flank => "flank",
        }
    }

    /// The member of an entry that holds the quantity.
    #[must_use]
    pub const fn member(self) -> &'static str {
        match self {
            Self::Radius => "radius_wear_um",
            Self::Flank => "flank_wear_um",
        }
    }

    /// The quantity of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Radius, Self::Flank].into_iter().find(|quantity| quantity.as_str() == name)
    }
}

/// A measured wear, either of the radius or of the flank.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearEntryRequest {
    /// Time of the measurement (RFC 3339); not in the future.
    #[schema(example = "2025-03-14T09:26:53Z", format = "date-time")]
    pub measured_at: String,
    /// Parts cut since this cutter was new.
    #[schema(example = 120, minimum = 0, maximum = 1_000_000_000)]
    pub parts_cut: i64,
    /// Decrease of the radius against the new cutter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 14.0, minimum = 0, maximum = 10_000)]
    pub radius_wear_um: Option<f64>,
    /// Width of the wear land on the flank.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 10_000)]
    pub flank_wear_um: Option<f64>,
    /// Standard uncertainty of the wear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.001, maximum = 1000)]
    pub standard_uncertainty_um: Option<f64>,
    /// Id of the cutter in the tool's holder; a new or reground cutter gets a new id.
    #[serde(default = "first_cutter")]
    #[schema(default = "1", max_length = 100)]
    pub cutter_id: String,
    /// Name of the edge, if several are measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 100)]
    pub edge: Option<String>,
    /// Any note.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 2000)]
    pub note: Option<String>,
}

fn first_cutter() -> String {
    "1".to_owned()
}

/// One entry, or an array of them.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum WearEntriesRequest {
    /// One entry.
    One(WearEntryRequest),
    /// Many entries; either all are stored or none.
    Many(Vec<WearEntryRequest>),
}

struct OneOrMany;

impl<'de> Visitor<'de> for OneOrMany {
    type Value = WearEntriesRequest;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an entry or an array of entries")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<WearEntriesRequest, A::Error> {
        WearEntryRequest::deserialize(MapAccessDeserializer::new(map)).map(WearEntriesRequest::One)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<WearEntriesRequest, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = seq.next_element()? {
            entries.push(entry);
        }
        Ok(WearEntriesRequest::Many(entries))
    }
}

impl<'de> Deserialize<'de> for WearEntriesRequest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrMany)
    }
}

/// The withdrawal of a wrong entry.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Withdrawal {
    /// Time of the withdrawal.
    pub withdrawn_at: String,
    /// The reason.
    #[schema(example = "read the wrong flute")]
    pub reason: String,
}

/// A measured wear as it is stored.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearEntry {
    /// Id of the entry.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// Id of the machine.
    pub machine_id: String,
    /// Id of the tool.
    #[schema(example = "T12")]
    pub tool_id: String,
    /// Id of the cutter in the tool.
    #[schema(example = "1")]
    pub cutter_id: String,
    /// Name of the edge; null for the whole cutter.
    pub edge: Option<String>,
    /// Time of the measurement.
    #[schema(example = "2025-03-14T09:26:53.000Z")]
    pub measured_at: String,
    /// Time at which the entry was stored.
    #[schema(example = "2025-03-14T09:30:00.000Z")]
    pub created_at: String,
    /// Parts cut since the cutter was new.
    #[schema(example = 120)]
    pub parts_cut: u32,
    /// Wear of the radius, if it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = 14.0)]
    pub radius_wear_um: Option<f64>,
    /// Wear of the flank, if it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flank_wear_um: Option<f64>,
    /// Standard uncertainty of the wear; null if none was stated.
    pub standard_uncertainty_um: Option<f64>,
    /// Any note.
    pub note: Option<String>,
    /// The withdrawal of a wrong entry; the entry is kept but trends leave it out.
    pub withdrawn: Option<Withdrawal>,
}

impl WearEntry {
    /// The measured quantity and its value \[µm\].
    #[must_use]
    pub fn wear(&self) -> (WearQuantity, f64) {
        match (self.radius_wear_um, self.flank_wear_um) {
            (None, Some(wear_um)) => (WearQuantity::Flank, wear_um),
            (radius, _) => (WearQuantity::Radius, radius.unwrap_or_default()),
        }
    }
}

/// One entry or an array of them, as they were posted.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum WearEntriesAnswer {
    /// One entry.
    One(Box<WearEntry>),
    /// Many entries.
    Many(Vec<WearEntry>),
}

/// The reason why an entry is wrong.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WithdrawalRequest {
    /// The reason in words.
    #[schema(example = "read the wrong flute", min_length = 1, max_length = 2000)]
    pub reason: String,
}

/// Most entries in one request, and most entries of one cutter.
pub const MAX_WEAR_ENTRIES: usize = 10_000;
/// Most edges of one cutter.
pub const MAX_WEAR_EDGES: usize = 32;
/// Most parts of one cutter.
const MAX_PARTS: i64 = 1_000_000_000;
/// Largest wear that is accepted \[µm\].
const MAX_WEAR_UM: f64 = 10_000.0;
/// Uncertainties that are accepted \[µm\].
const UNCERTAINTY_UM: [f64; 2] = [1e-3, 1000.0];
/// Longest name of a tool, a cutter, an edge, and longest note or reason \[characters\].
const MAX_NAME: usize = 100;
const MAX_TEXT: usize = 2000;

/// Checks a name of a tool, a cutter or an edge; a fault is added to `faults`.
pub fn check_name(pointer: impl FnOnce() -> String, name: &str, faults: &mut FaultList) {
    let length = name.chars().count();
    let sound =
        (1..=MAX_NAME).contains(&length) && name.trim() == name && !name.chars().any(char::is_control);
    if !sound {
        faults.push(|| {
            let what = format!(
                "a name has 1 to {MAX_NAME} characters, no control characters, and no space at its ends; this one has {length} characters"
            );
            Fault::new(pointer(), what)
        });
    }
}

/// Checks a note or a reason; a fault is added to `faults`.
fn check_text(pointer: impl FnOnce() -> String, text: &str, faults: &mut FaultList) {
    let length = text.chars().count();
    if !(1..=MAX_TEXT).contains(&length) || text.contains('\0') {
        faults.push(|| {
            let detail =
                format!("{length} characters; a text must have 1 to {MAX_TEXT} characters without NUL");
            Fault::new(pointer(), detail)
        });
    }
}

impl WithdrawalRequest {
    /// Faults are added to `faults`.
    pub fn check(&self, faults: &mut FaultList) {
        check_text(|| "/reason".to_owned(), &self.reason, faults);
    }
}

impl WearEntriesRequest {
    /// The entries.
    #[must_use]
    pub fn entries(&self) -> &[WearEntryRequest] {
        match self {
            Self::One(entry) => std::slice::from_ref(entry),
            Self::Many(entries) => entries,
        }
    }

    /// The location of the entry with this index.
    #[must_use]
    pub fn pointer(&self, index: usize) -> String {
        match self {
            Self::One(_) => String::new(),
            Self::Many(_) => format!("/{index}"),
        }
    }

    /// Checks everything but the times; faults are added to `faults`.
    pub fn check(&self, faults: &mut FaultList) {
        let entries = self.entries();
        if !(1..=MAX_WEAR_ENTRIES).contains(&entries.len()) {
            let count = entries.len();
            faults.push(|| {
                Fault::new(
                    "",
                    format!("{count} entries; a request must have 1 to {MAX_WEAR_ENTRIES} entries"),
                )
            });
        }
        let mut quantities: BTreeMap<&str, WearQuantity> = BTreeMap::new();
        for (index, entry) in entries.iter().enumerate() {
            let at = |member: &str| format!("{}/{member}", self.pointer(index));
            entry.check(at, faults);
            // One quantity for each cutter.
            if let (Some((quantity, _)), cutter) = (entry.wear(), entry.cutter_id.as_str())
                && *quantities.entry(cutter).or_insert(quantity) != quantity
            {
                faults.push(|| Fault::new(at(quantity.member()), other_quantity(cutter, quantity)));
            }
        }
    }
}

/// The fault that a cutter already has entries of the other quantity.
#[must_use]
pub fn other_quantity(cutter_id: &str, quantity: WearQuantity) -> String {
    let other = match quantity {
        WearQuantity::Radius => WearQuantity::Flank,
        WearQuantity::Flank => WearQuantity::Radius,
    };
    format!(
        "cutter {cutter_id:?} already has entries of {}, and one history can have only one quantity",
        other.member()
    )
}

impl WearEntryRequest {
    /// The measured quantity and its value \[µm\]; `None` if neither or both are given.
    #[must_use]
    pub fn wear(&self) -> Option<(WearQuantity, f64)> {
        match (self.radius_wear_um, self.flank_wear_um) {
            (Some(wear_um), None) => Some((WearQuantity::Radius, wear_um)),
            (None, Some(wear_um)) => Some((WearQuantity::Flank, wear_um)),
            _ => None,
        }
    }

    fn check(&self, at: impl Fn(&str) -> String, faults: &mut FaultList) {
        let parts = self.parts_cut;
        if !(0..=MAX_PARTS).contains(&parts) {
            faults.push(|| Fault::new(at("parts_cut"), format!("{parts} is not between 0 and {MAX_PARTS}")));
        }
        match self.wear() {
            Some((quantity, wear_um)) => {
                faults.check_range(|| at(quantity.member()), wear_um, 0.0, MAX_WEAR_UM);
            }
            None if self.radius_wear_um.is_none() => faults.push(|| {
                let detail = "missing: an entry needs radius_wear_um or flank_wear_um";
                Fault::new(at("radius_wear_um"), detail)
            }),
            None => faults.push(|| {
                let detail = "an entry has either radius_wear_um or flank_wear_um, but this one has both";
                Fault::new(at("flank_wear_um"), detail)
            }),
        }
        if let Some(uncertainty_um) = self.standard_uncertainty_um {
            let [least, most] = UNCERTAINTY_UM;
            faults.check_range(|| at("standard_uncertainty_um"), uncertainty_um, least, most);
        }
        check_name(|| at("cutter_id"), &self.cutter_id, faults);
        if let Some(edge) = &self.edge {
            check_name(|| at("edge"), edge, faults);
        }
        if let Some(note) = &self.note {
            check_text(|| at("note"), note, faults);
        }
    }
}
