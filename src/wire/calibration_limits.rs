//! Limits of location errors, for the verdict of a calibration report.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::reading::escape;
use super::{Fault, FaultList};
use crate::description::ToSchema;

/// The largest magnitude of each location error against the machine's frame, under its name in `iso_230` of a run
/// (µm or µrad).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(example = json!({"E_X0C_um": 10, "E_A0C_urad": 30}))]
pub struct CalibrationLimits(BTreeMap<String, f64>);

/// Largest limit that is accepted \[µm or µrad\].
const MAX_LIMIT: f64 = 1e5;
/// Number of limits that is never needed: six errors of each of three letters.
const MOST: usize = 18;
/// How many characters of a wrong name an error shows.
const SHOWN: usize = 16;

impl CalibrationLimits {
    /// The limit of this error.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    /// Checks names and numbers for a machine with these rotary axes; faults are added to `faults` under `pointer`.
    pub(super) fn check<'a>(
        &self,
        pointer: &str,
        letters: &(impl Iterator<Item = &'a str> + Clone),
        faults: &mut FaultList,
    ) {
        for (name, limit) in &self.0 {
            let at = || format!("{pointer}/{}", escape(name));
            if !letters.clone().any(|letter| is_error_of(name, letter)) {
                faults.push(|| {
                    let shown: String = name.chars().take(SHOWN).collect();
                    let there: Vec<String> = letters
                        .clone()
                        .take(2)
                        .map(|axis| format!("E_X0{axis}_um … E_C0{axis}_urad"))
                        .collect();
                    let there = there.join(" and ");
                    let detail =
                        format!("{shown:?} is not a location error of this machine; its errors are {there}");
                    Fault::new(at(), detail)
                });
            } else if !(*limit > 0.0 && *limit <= MAX_LIMIT) {
                let detail =
                    format!("the limit {limit} is wrong: it must be above 0 and at most {MAX_LIMIT}");
                faults.push(|| Fault::new(at(), detail));
            }
        }
    }
}

/// Whether this is the name of a location error of the axis with this letter.
fn is_error_of(name: &str, letter: &str) -> bool {
    let of_axis = |unit: &str| -> Option<&str> {
        name.strip_prefix("E_")?.strip_suffix(unit)?.strip_suffix(letter)?.strip_suffix('0')
    };
    matches!(of_axis("_um"), Some("X" | "Y" | "Z")) || matches!(of_axis("_urad"), Some("A" | "B" | "C"))
}

struct ByName;

impl<'de> Visitor<'de> for ByName {
    type Value = CalibrationLimits;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of limits by the names of errors")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<CalibrationLimits, A::Error> {
        let mut limits = BTreeMap::new();
        while let Some((name, limit)) = map.next_entry::<String, f64>()? {
            if limits.contains_key(&name) {
                // In serde's words, because the pointer is made from them.
                return Err(A::Error::custom(format_args!("duplicate field `{name}`")));
            }
            if limits.len() == MOST {
                return Err(A::Error::custom(format_args!(
                    "more than {MOST} limits; a machine has at most 12"
                )));
            }
            limits.insert(name, limit);
        }
        Ok(CalibrationLimits(limits))
    }
}

impl<'de> Deserialize<'de> for CalibrationLimits {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(ByName)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> Vec<String> {
        let limits: CalibrationLimits = serde_json::from_str(text).unwrap();
        let mut faults = FaultList::default();
        limits.check("/calibration_limits", &["A", "C"].into_iter(), &mut faults);
        let faults = faults.into_result().err().unwrap_or_default();
        faults.into_iter().map(|fault| fault.pointer).collect()
    }

    #[test]
    fn a_limit_has_the_name_of_an_error_with_its_unit() {
        assert!(faults(r#"{"E_X0C_um": 10, "E_C0A_urad": 30, "E_Z0A_um": 0.5}"#).is_empty());
        for name in ["E_X0C", "E_X0C_urad", "E_A0C_um", "E_X0B_um", "E_X0_um", "C.e_x_um", "E__um", ""] {
            assert_eq!(
                faults(&format!("{{{name:?}: 1}}")),
                [format!("/calibration_limits/{name}")],
                "{name}"
            );
        }
        for limit in ["0", "-1", "100001"] {
            assert_eq!(faults(&format!("{{\"E_X0C_um\": {limit}}}")), ["/calibration_limits/E_X0C_um"]);
        }
    }

    #[test]
    fn a_name_is_given_once() {
        let twice = serde_json::from_str::<CalibrationLimits>(r#"{"E_X0C_um": 1, "E_X0C_um": 2}"#);
        assert!(twice.unwrap_err().to_string().contains("duplicate field"));
    }
}
