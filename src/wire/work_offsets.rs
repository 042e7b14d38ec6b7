//! Work offsets by the names that programs call them by.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use super::printable::is_printable;
use super::reading::escape;
use super::{CcParameters, Fault, FaultList, Fixed};

/// Work offsets by name, as a program calls them: `G54`, `G54.1 P3`, `G505`, or whatever else a control calls them. Each is the
/// place of W's origin in M at zero pose.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct WorkOffsets(
    /// In the order of the names as they were given.
    BTreeMap<String, Fixed<3>>,
);

/// Most work offsets in one table. A control of today has at most 300 of `G54.1` and some hundred of its own.
const MAX_WORK_OFFSETS: usize = 400;
/// Longest name of a work offset \[characters\].
const MAX_NAME: usize = 32;

/// What a name of a work offset is compared by: without blanks, in capitals, and without zeros before a number, as a control
/// reads it. `G54.1 P3` and `g54.1p03` are the same.
#[must_use]
pub fn work_offset_key(name: &str) -> String {
    let mut key = String::with_capacity(name.len());
    let mut letters = name.chars().filter(|letter| !letter.is_whitespace()).peekable();
    while let Some(letter) = letters.next() {
        let begins_number = key.chars().next_back().is_some_and(|last| last.is_ascii_alphabetic());
        let goes_on = letters.peek().is_some_and(char::is_ascii_digit);
        if !(letter == '0' && begins_number && goes_on) {
            key.push(letter.to_ascii_uppercase());
        }
    }
    key
}

/// A name of a work offset: 1 to 32 printable characters, no space at the ends. A fault joins `faults`.
pub fn check_work_offset_name(pointer: impl FnOnce() -> String, name: &str, faults: &mut FaultList) {
    let length = name.chars().count();
    if !(1..=MAX_NAME).contains(&length) || !is_printable(name) {
        faults.push(|| {
            let detail = format!(
                "the name of a work offset has 1 to {MAX_NAME} printable characters and no space at its ends, as in G54 or G54.1 P3; this one has {length} characters"
            );
            Fault::new(pointer(), detail)
        });
    }
}

impl WorkOffsets {
    /// The offset with this name \[mm\], whatever its capitals, blanks and leading zeros.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<[f64; 3]> {
        let key = work_offset_key(name);
        self.iter().find(|(known, _)| work_offset_key(known) == key).map(|(_, offset_mm)| offset_mm)
    }

    /// Name and offset \[mm\] of each, in the order of the names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, [f64; 3])> {
        self.0.iter().map(|(name, offset_mm)| (name.as_str(), offset_mm.0))
    }

    /// Everything that is wrong with names and numbers joins `faults` under `pointer`.
    pub fn check(&self, pointer: &str, faults: &mut FaultList) {
        let max_mm = CcParameters::MAX_OFFSET_MM;
        let mut keys: BTreeMap<String, &str> = BTreeMap::new();
        for (name, offset_mm) in self.iter() {
            let at = || format!("{pointer}/{}", escape(name));
            check_work_offset_name(at, name, faults);
            for (index, value_mm) in offset_mm.into_iter().enumerate() {
                faults.check_range(|| format!("{}/{index}", at()), value_mm, -max_mm, max_mm);
            }
            if let Some(first) = keys.insert(work_offset_key(name), name) {
                faults.push(|| {
                    let detail = format!(
                        "{name:?} and {first:?} are the same work offset for a program. Leave one of them out"
                    );
                    Fault::new(at(), detail)
                });
            }
        }
    }

    /// The same offsets; one that is −0 is 0.
    pub(super) fn without_negative_zeros(mut self) -> Self {
        for offset_mm in self.0.values_mut() {
            offset_mm.0 = offset_mm.0.map(|value_mm| value_mm + 0.0);
        }
        self
    }
}

struct Named;

impl<'de> Visitor<'de> for Named {
    type Value = WorkOffsets;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of work offsets by name")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<WorkOffsets, A::Error> {
        let mut offsets = BTreeMap::new();
        while let Some((name, offset_mm)) = map.next_entry::<String, Fixed<3>>()? {
            if offsets.contains_key(&name) {
                // In the words of serde, from which the pointer is made.
                return Err(A::Error::custom(format_args!("duplicate field `{name}`")));
            }
            if offsets.len() == MAX_WORK_OFFSETS {
                return Err(A::Error::custom(format_args!(
                    "more than {MAX_WORK_OFFSETS} work offsets; a machine has at most {MAX_WORK_OFFSETS}"
                )));
            }
            offsets.insert(name, offset_mm);
        }
        Ok(WorkOffsets(offsets))
    }
}

impl<'de> Deserialize<'de> for WorkOffsets {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Named)
    }
}

impl PartialSchema for WorkOffsets {
    fn schema() -> RefOr<Schema> {
        let name =
            ObjectBuilder::new().schema_type(Type::String).min_length(Some(1)).max_length(Some(MAX_NAME));
        ObjectBuilder::new()
            .description(Some(
                "Work offsets by name: X Y Z of the programming zero in machine coordinates at zero pose",
            ))
            .property_names(Some(name))
            .additional_properties(Some(Ref::from_schema_name(Fixed::<3>::name())))
            .max_properties(Some(MAX_WORK_OFFSETS))
            .into()
    }
}

impl ToSchema for WorkOffsets {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("WorkOffsets")
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        schemas.push((Fixed::<3>::name().into_owned(), Fixed::<3>::schema()));
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_json;
    use super::*;

    fn read(text: &str) -> Result<WorkOffsets, String> {
        read_json(text.as_bytes()).map_err(|fault| fault.to_string())
    }

    #[test]
    fn names_that_a_control_reads_alike_are_one() {
        for (one, other) in [
            ("G54", "g54"),
            ("G54.1 P3", "G54.1P03"),
            ("G054", "G54"),
            ("G54.1 P3", "g54.1 p003"),
            ("Table 2", "TABLE2"),
        ] {
            assert_eq!(work_offset_key(one), work_offset_key(other));
        }
        for (one, other) in [
            ("G54", "G55"),
            ("G54.1 P3", "G54.1 P30"),
            ("G54.1 P1", "G54.1 P10"),
            ("G500", "G5"),
            ("7", "07"),
            ("G54.01", "G54.1"),
            ("P0", "P"),
        ] {
            assert_ne!(work_offset_key(one), work_offset_key(other));
        }
        let table = read("{\"G54.1 P3\": [1, 2, 3], \"G505\": [4, 5, 6]}").unwrap();
        assert_eq!(table.get("g54.1p03"), Some([1.0, 2.0, 3.0]));
        assert_eq!(table.get("G54"), None);
        // Names stay as they were given, in one order.
        assert_eq!(table.iter().map(|(name, _)| name).collect::<Vec<_>>(), ["G505", "G54.1 P3"]);
    }

    #[test]
    fn a_name_stands_once_and_there_are_not_too_many() {
        let twice = read("{\"G54\": [0, 0, 0], \"G54\": [1, 0, 0]}").unwrap_err();
        assert!(twice.starts_with("/G54: duplicate"), "{twice}");
        let many = |count: usize| {
            let entries: Vec<_> = (0..count).map(|index| format!("\"T{index}\": [0, 0, 0]")).collect();
            read(&format!("{{{}}}", entries.join(", ")))
        };
        assert_eq!(many(MAX_WORK_OFFSETS).unwrap().iter().count(), MAX_WORK_OFFSETS);
        assert!(many(MAX_WORK_OFFSETS + 1).unwrap_err().contains("at most 400"));
    }
}
