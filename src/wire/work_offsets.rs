//! Work offsets by their names in programs.

#[cfg(test)]
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
#[cfg(test)]
use utoipa::openapi::schema::{ObjectBuilder, Type};
#[cfg(test)]
use utoipa::openapi::{Ref, RefOr, Schema};
#[cfg(test)]
use utoipa::{PartialSchema, ToSchema};

use super::reading::escape;
use super::{CcParameters, Fault, FaultList, Fixed};
use crate::motion::WorkOffset;

/// Work offsets by their names in programs: `G54`, `G54.1 P3`, `G505`. Each value is the position of W's
/// origin in M at zero pose.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct WorkOffsets(
    /// Offsets by name as given.
    BTreeMap<String, Fixed<3>>,
);

/// Most work offsets in one table. A present-day control has at most 300 of `G54.1` and some hundred of its
/// own.
const MAX_WORK_OFFSETS: usize = 400;
/// Longest name of a work offset \[characters\].
const MAX_NAME: usize = 32;

impl WorkOffsets {
    /// Name and offset \[mm\] of each, in the order of the names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, [f64; 3])> {
        self.0.iter().map(|(name, offset_mm)| (name.as_str(), offset_mm.0))
    }

    /// Checks names and numbers; faults are added to `faults` under `pointer`.
    pub fn check(&self, pointer: &str, faults: &mut FaultList) {
        let max_mm = CcParameters::MAX_OFFSET_MM;
        let mut known: BTreeMap<WorkOffset, &str> = BTreeMap::new();
        for (name, offset_mm) in self.iter() {
            let at = || format!("{pointer}/{}", escape(name));
            for (index, value_mm) in offset_mm.into_iter().enumerate() {
                faults.check_range(|| format!("{}/{index}", at()), value_mm, -max_mm, max_mm);
            }
            let shown: String = name.chars().take(MAX_NAME).collect();
            match WorkOffset::from_name(name) {
                None => faults.push(|| {
                    let detail = format!(
                        "no control calls a work offset {shown:?}; write it as G54, G59.1, G54.1 P3, G154 P12, G505, G15 H2 or PRESET 4"
                    );
                    Fault::new(at(), detail)
                }),
                Some(offset) => {
                    if let Some(first) = known.insert(offset, name) {
                        faults.push(|| {
                            let detail = format!(
                                "{shown:?} and {first:?} are the same work offset in a program. Leave one of them out"
                            );
                            Fault::new(at(), detail)
                        });
                    }
                }
            }
        }
    }

    /// The same offsets, with −0 replaced by 0.
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
                // In serde's words, because the pointer is made from them.
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

#[cfg(test)]
impl PartialSchema for WorkOffsets {
    fn schema() -> RefOr<Schema> {
        let name = ObjectBuilder::new()
            .schema_type(Type::String)
            .min_length(Some(1))
            .max_length(Some(MAX_NAME))
            .examples(["G54", "G55", "G56", "G57", "G58", "G59"]);
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

#[cfg(test)]
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

    fn faults(text: &str) -> Vec<String> {
        let mut faults = FaultList::default();
        read(text).unwrap().check("/work_offsets_mm", &mut faults);
        let faults = faults.into_result().err().unwrap_or_default();
        faults.into_iter().map(|fault| format!("{} {}", fault.pointer, fault.detail)).collect()
    }

    #[test]
    fn names_are_those_that_controls_have_and_stand_for_one_offset_each() {
        assert_eq!(faults("{\"G54\": [1, 2, 3], \"G54.1 P3\": [4, 5, 6], \"g505\": [0, 0, 0]}"), [""; 0]);
        let alike = faults("{\"G54.1 P3\": [1, 2, 3], \"g54p03\": [1, 2, 3]}");
        assert!(matches!(&alike[..], [one] if one.contains("same work offset")), "{alike:?}");
        let foreign = faults("{\"Table 2\": [1, 2, 3], \"G53\": [0, 0, 0], \"\": [0, 0, 1e9]}");
        assert_eq!(foreign.len(), 4, "{foreign:?}");
        assert!(foreign.iter().any(|fault| fault.starts_with("/work_offsets_mm/Table 2 no control")));
    }

    #[test]
    fn a_name_stands_once_and_there_are_not_too_many() {
        let twice = read("{\"G54\": [0, 0, 0], \"G54\": [1, 0, 0]}").unwrap_err();
        assert!(twice.starts_with("/G54: duplicate"), "{twice}");
        let many = |count: usize| {
            let entries: Vec<_> = (0..count).map(|index| format!("\"G54.1 P{index}\": [0, 0, 0]")).collect();
            read(&format!("{{{}}}", entries.join(", ")))
        };
        assert_eq!(many(MAX_WORK_OFFSETS).unwrap().iter().count(), MAX_WORK_OFFSETS);
        assert!(many(MAX_WORK_OFFSETS + 1).unwrap_err().contains("at most 400"));
    }
}
