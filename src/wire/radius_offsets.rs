//! Radii in the registers of a control, by the words that name them.

#[cfg(test)]
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
#[cfg(test)]
use utoipa::openapi::schema::{AdditionalProperties, ObjectBuilder, Type};
#[cfg(test)]
use utoipa::openapi::{RefOr, Schema};
#[cfg(test)]
use utoipa::{PartialSchema, ToSchema};

use super::reading::escape;
use super::{Fault, FaultList};
use crate::machine::Machine;
use crate::motion::{self, RadiusRegister};

/// Radii by register: `D4`, `H19`.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RadiusOffsets(
    /// Radii by the names as given \[mm\].
    BTreeMap<String, f64>,
);

/// Most registers in one table. A present-day control has at most 999.
const MAX_REGISTERS: usize = 999;
/// Longest name of a register \[characters\].
const MAX_NAME: usize = 6;

impl RadiusOffsets {
    /// Checks names and radii; faults are added to `faults`.
    pub(super) fn check(&self, faults: &mut FaultList) {
        let mut known: BTreeMap<RadiusRegister, &str> = BTreeMap::new();
        for (name, radius_mm) in &self.0 {
            let at = || format!("/radius_offsets_mm/{}", escape(name));
            faults.check_range(at, *radius_mm, 0.0, Machine::MAX_LENGTH_MM);
            let shown: String = name.chars().take(MAX_NAME).collect();
            let detail = match RadiusRegister::from_name(name) {
                None => format!(
                    "no control calls a register {shown:?}; write it as D4, or as H19 if H is a radius"
                ),
                Some(register) => match known.insert(register, name) {
                    Some(first) => {
                        format!("{shown:?} and {first:?} are the same register. Leave one of them out")
                    }
                    None => continue,
                },
            };
            faults.push(|| Fault::new(at(), detail));
        }
    }

    /// The same in the core's terms.
    pub(super) fn to_core(&self) -> motion::RadiusOffsets {
        let named = |(name, radius_mm): (&String, &f64)| Some((RadiusRegister::from_name(name)?, *radius_mm));
        motion::RadiusOffsets { by_register_mm: self.0.iter().filter_map(named).collect() }
    }
}

struct Named;

impl<'de> Visitor<'de> for Named {
    type Value = RadiusOffsets;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of radii by register")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RadiusOffsets, A::Error> {
        let mut radii = BTreeMap::new();
        while let Some((name, radius_mm)) = map.next_entry::<String, f64>()? {
            if radii.contains_key(&name) {
                // In serde's words, because the pointer is made from them.
                return Err(A::Error::custom(format_args!("duplicate field `{name}`")));
            }
            if radii.len() == MAX_REGISTERS {
                return Err(A::Error::custom(format_args!("more than {MAX_REGISTERS} registers")));
            }
            radii.insert(name, radius_mm);
        }
        Ok(RadiusOffsets(radii))
    }
}

impl<'de> Deserialize<'de> for RadiusOffsets {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Named)
    }
}

#[cfg(test)]
impl PartialSchema for RadiusOffsets {
    fn schema() -> RefOr<Schema> {
        let name = ObjectBuilder::new()
            .schema_type(Type::String)
            .min_length(Some(2))
            .max_length(Some(MAX_NAME))
            .examples(["D4", "H19"]);
        let radius = ObjectBuilder::new()
            .schema_type(Type::Number)
            .minimum(Some(0.0))
            .maximum(Some(Machine::MAX_LENGTH_MM))
            .build();
        ObjectBuilder::new()
            .description(Some("Radii by register: geometry and wear together"))
            .property_names(Some(name))
            .additional_properties(Some(AdditionalProperties::RefOr(RefOr::T(Schema::Object(radius)))))
            .max_properties(Some(MAX_REGISTERS))
            .into()
    }
}

#[cfg(test)]
impl ToSchema for RadiusOffsets {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("RadiusOffsets")
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_json;
    use super::*;

    fn faults(text: &str) -> Vec<String> {
        let radii: RadiusOffsets = read_json(text.as_bytes()).unwrap();
        let mut faults = FaultList::default();
        radii.check(&mut faults);
        let faults = faults.into_result().err().unwrap_or_default();
        faults.into_iter().map(|fault| format!("{} {}", fault.pointer, fault.detail)).collect()
    }

    #[test]
    fn registers_are_named_once_and_their_radii_are_lengths() {
        assert_eq!(faults("{\"D4\": 5, \"d05\": 0, \"H19\": 2.5}"), [""; 0]);
        let alike = faults("{\"D4\": 5, \"d04\": 5}");
        assert!(matches!(&alike[..], [one] if one.contains("same register")), "{alike:?}");
        let foreign = faults("{\"T4\": 5, \"D\": 1, \"D5\": -1}");
        assert_eq!(foreign.len(), 3, "{foreign:?}");
        assert!(foreign.iter().any(|fault| fault.starts_with("/radius_offsets_mm/T4 no control")));
        let twice = read_json::<RadiusOffsets>(b"{\"D4\": 5, \"D4\": 6}").unwrap_err();
        assert!(twice.to_string().contains("duplicate"), "{twice}");
    }
}
