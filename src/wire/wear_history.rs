//! Measured wear as it is posted and as it is kept.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use super::{Fault, FaultList};

/// What was measured of a cutter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WearQuantity {
    /// How much smaller the cutter's radius is.
    Radius,
    /// How wide the land of wear on the flank is.
    Flank,
}

impl WearQuantity {
    /// As it stands in documents.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Radius => "radius",
            Self::Flank => "flank",
        }
    }

    /// The member of an entry that carries it.
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

/// A measured wear: of the radius or of the flank, one of the two.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearEntryRequest {
    /// When (RFC 3339); not in the future.
    #[schema(example = "2025-03-14T09:26:53Z", format = "date-time")]
    pub measured_at: String,
    /// Parts cut since this cutter was new.
    #[schema(example = 120, minimum = 0, maximum = 1_000_000_000)]
    pub parts_cut: i64,
    /// How much smaller the radius is than that of the new cutter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 14.0, minimum = 0, maximum = 10_000)]
    pub radius_wear_um: Option<f64>,
    /// Width of the land of wear on the flank.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 10_000)]
    pub flank_wear_um: Option<f64>,
    /// Standard uncertainty of the wear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.001, maximum = 1000)]
    pub standard_uncertainty_um: Option<f64>,
    /// Which cutter in the tool's holder: a new or reground one gets a new name.
    #[serde(default = "first_cutter")]
    #[schema(default = "1", max_length = 100)]
    pub cutter_id: String,
    /// Which edge, where several are measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 100)]
    pub edge: Option<String>,
    /// What else is to be remembered.
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
    /// One.
    One(WearEntryRequest),
    /// Many, all of which are kept or none.
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

/// That an entry was wrong.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Withdrawal {
    /// When that was said.
    pub withdrawn_at: String,
    /// Why.
    #[schema(example = "read the wrong flute")]
    pub reason: String,
}

/// A measured wear as it is kept.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearEntry {
    /// The entry.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// The machine.
    pub machine_id: String,
    /// The tool.
    #[schema(example = "T12")]
    pub tool_id: String,
    /// The cutter in it.
    #[schema(example = "1")]
    pub cutter_id: String,
    /// The edge; null where the cutter was measured as a whole.
    pub edge: Option<String>,
    /// When it was measured.
    #[schema(example = "2025-03-14T09:26:53.000Z")]
    pub measured_at: String,
    /// When it was stored.
    #[schema(example = "2025-03-14T09:30:00.000Z")]
    pub created_at: String,
    /// Parts cut since the cutter was new.
    #[schema(example = 120)]
    pub parts_cut: u32,
    /// Wear of the radius, where that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = 14.0)]
    pub radius_wear_um: Option<f64>,
    /// Wear of the flank, where that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flank_wear_um: Option<f64>,
    /// Its standard uncertainty; null where none was stated.
    pub standard_uncertainty_um: Option<f64>,
    /// What else was to be remembered.
    pub note: Option<String>,
    /// Where it turned out wrong: it is kept, and left out of trends.
    pub withdrawn: Option<Withdrawal>,
}

impl WearEntry {
    /// What was measured, and how much \[µm\].
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
    /// One.
    One(Box<WearEntry>),
    /// Many.
    Many(Vec<WearEntry>),
}

/// Why an entry is wrong.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WithdrawalRequest {
    /// In words.
    #[schema(example = "read the wrong flute", min_length = 1, max_length = 2000)]
    pub reason: String,
}

/// Most entries in one request, and of one cutter.
pub const MAX_WEAR_ENTRIES: usize = 10_000;
/// Most edges of one cutter.
pub const MAX_WEAR_EDGES: usize = 32;
/// Most parts of one cutter.
const MAX_PARTS: i64 = 1_000_000_000;
/// Most wear taken for real \[µm\].
const MAX_WEAR_UM: f64 = 10_000.0;
/// Uncertainties taken for real \[µm\].
const UNCERTAINTY_UM: [f64; 2] = [1e-3, 1000.0];
/// Longest name of a tool, a cutter, an edge, and longest note or reason \[characters\].
const MAX_NAME: usize = 100;
const MAX_TEXT: usize = 2000;

/// A name of a tool, a cutter or an edge; a fault joins `faults`.
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

/// A note or a reason; a fault joins `faults`.
fn check_text(pointer: impl FnOnce() -> String, text: &str, faults: &mut FaultList) {
    let length = text.chars().count();
    if !(1..=MAX_TEXT).contains(&length) || text.contains('\0') {
        faults.push(|| {
            let detail = format!("{length} characters; a text has 1 to {MAX_TEXT}, and none of them is NUL");
            Fault::new(pointer(), detail)
        });
    }
}

impl WithdrawalRequest {
    /// Faults join `faults`.
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

    /// Where the entry of this index stands.
    #[must_use]
    pub fn pointer(&self, index: usize) -> String {
        match self {
            Self::One(_) => String::new(),
            Self::Many(_) => format!("/{index}"),
        }
    }

    /// Everything that is wrong with the entries joins `faults`, but for their times.
    pub fn check(&self, faults: &mut FaultList) {
        let entries = self.entries();
        if !(1..=MAX_WEAR_ENTRIES).contains(&entries.len()) {
            let count = entries.len();
            faults.push(|| {
                Fault::new("", format!("{count} entries; a request has 1 to {MAX_WEAR_ENTRIES} of them"))
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

/// That a cutter's entries are of the other quantity.
#[must_use]
pub fn other_quantity(cutter_id: &str, quantity: WearQuantity) -> String {
    let other = match quantity {
        WearQuantity::Radius => WearQuantity::Flank,
        WearQuantity::Flank => WearQuantity::Radius,
    };
    format!("cutter {cutter_id:?} has entries of {}, and one history has one quantity", other.member())
}

impl WearEntryRequest {
    /// What was measured, and how much \[µm\]; `None` where neither or both are given.
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
                let detail = "an entry has radius_wear_um or flank_wear_um, and this one has neither";
                Fault::new(at("radius_wear_um"), detail)
            }),
            None => faults.push(|| {
                let detail = "an entry has radius_wear_um or flank_wear_um, and this one has both";
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
