//! A tool of a machine's tool table as clients and the disk have it.

use serde::{Deserialize, Serialize};

use super::printable::is_printable;
use super::{CcParameters, Fault, FaultList};
use crate::description::ToSchema;
use crate::machine::{Tool, ToolFault};
use crate::units::Length;

/// Form of the cutter's end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ToolKind {
    /// A full ball: the corner radius is the radius.
    Ball,
    /// A corner radius between 0 and the radius.
    BullNose,
    /// A sharp corner: the corner radius is 0.
    Flat,
    /// Not an end mill, or an end mill of another form: a drill, a tap, a probe. Both radii may be left out.
    Other,
}

/// A tool as the shop states it: its number and name in programs, and its nominal cutter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Tool)]
pub struct TableTool {
    /// Number in programs, as in `T12` or `TOOL CALL 12`. A tool has a number, a name or both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 12)]
    pub number: Option<u32>,
    /// Name in programs, as in `T="BALL_10"` or `TOOL CALL "BALL_10"`. Upper and lower case are the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "BALL_10", min_length = 1, max_length = 64)]
    pub name: Option<String>,
    /// Form of the cutter's end.
    pub kind: ToolKind,
    /// Cutter radius. Only a tool of the kind `other` may leave it out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 5.0, minimum = 0.001, maximum = 1000)]
    pub radius_mm: Option<f64>,
    /// Corner radius. The kind gives it for a ball (the radius) and for a flat cutter (0); for a bull-nose
    /// cutter it is required.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 1000)]
    pub corner_radius_mm: Option<f64>,
    /// Length, measured in the same way as `tool_length_mm` in a request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 92.4, minimum = -100_000, maximum = 100_000)]
    pub length_mm: Option<f64>,
}

/// A stored revision of a tool.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ToolDocument {
    /// The machine.
    #[schema(example = "example-ac-table")]
    pub machine_id: String,
    /// The tool's id, chosen by the client; its wear entries use the same id.
    #[schema(example = "T12")]
    pub tool_id: String,
    /// Counts up from 1; a revision never changes.
    #[schema(example = 3)]
    pub revision: i64,
    /// Time at which this revision was stored.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub created_at: String,
    /// The tool, with the corner radius that its kind gives.
    #[serde(flatten)]
    pub tool: TableTool,
}

/// Longest name \[characters\].
const MAX_NAME: usize = 64;
/// Characters that would end a name in a program.
const QUOTES: [char; 3] = ['"', '\'', '\\'];

/// The form in which tool names are compared: `ball_10` and `BALL_10` are the same tool, as controls read
/// them.
#[must_use]
pub fn tool_name_key(name: &str) -> String {
    name.to_ascii_uppercase()
}

impl TableTool {
    /// The same tool with the corner radius that its kind gives. Every bad value and every contradiction is
    /// added to `faults`; if there is any, the tool must not be stored.
    #[must_use]
    pub fn normalised(mut self, faults: &mut FaultList) -> Self {
        self.check_call(faults);
        if let Some(length_mm) = self.length_mm {
            let max_mm = CcParameters::MAX_OFFSET_MM;
            faults.check_range(|| "/length_mm".to_owned(), length_mm, -max_mm, max_mm);
        }
        let corner_mm = match self.radius_mm {
            Some(radius_mm) => self.corner_mm(radius_mm, faults),
            None => self.without_radius(faults),
        };
        // Adding 0 turns −0 into 0, so that both give the same document.
        self.corner_radius_mm = corner_mm.map(|corner_mm| corner_mm + 0.0);
        self.length_mm = self.length_mm.map(|length_mm| length_mm + 0.0);
        self
    }

    /// The nominal cutter; `None` if a tool of the kind `other` does not state both radii.
    #[must_use]
    pub fn cutter(&self) -> Option<Tool> {
        let (radius_mm, corner_mm) = self.radius_mm.zip(self.corner_radius_mm)?;
        Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)).ok()
    }

    fn check_call(&self, faults: &mut FaultList) {
        match &self.name {
            Some(name) => {
                let length = name.chars().count();
                if !(1..=MAX_NAME).contains(&length) || !is_printable(name) || name.contains(QUOTES) {
                    faults.push(|| {
                        let detail = format!(
                            "a tool's name has 1 to {MAX_NAME} printable characters, no quotes, no backslash and no space at its ends; this one has {length} characters"
                        );
                        Fault::new("/name", detail)
                    });
                }
            }
            None if self.number.is_none() => faults.push(|| {
                let detail = "a program calls a tool by its number or its name, and both are missing. State one of them, or both";
                Fault::new("/number", detail)
            }),
            None => {}
        }
    }

    /// The corner radius \[mm\] of a cutter with this radius, if the kind or the document gives it.
    fn corner_mm(&self, radius_mm: f64, faults: &mut FaultList) -> Option<f64> {
        let stated_mm = self.corner_radius_mm;
        let of_kind_mm = match self.kind {
            ToolKind::Ball => Some(radius_mm),
            ToolKind::Flat => Some(0.0),
            ToolKind::BullNose | ToolKind::Other => None,
        };
        let corner_mm = stated_mm.or(of_kind_mm);
        let cutter = Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm.unwrap_or(0.0)));
        let detail = match (cutter, corner_mm) {
            (Err(fault), _) => {
                let member = match fault {
                    ToolFault::Radius { .. } => "/radius_mm",
                    ToolFault::CornerRadius { .. } => "/corner_radius_mm",
                };
                faults.push(|| Fault::new(member, fault.to_string()));
                return None;
            }
            (Ok(_), None) if self.kind == ToolKind::BullNose => format!(
                "missing: a bull-nose cutter needs its corner radius, between 0 and its radius of {radius_mm} mm"
            ),
            (Ok(_), None) => return None,
            (Ok(_), Some(corner_mm)) => match of_kind_mm {
                Some(kind_mm) if (kind_mm - corner_mm).abs() > 0.0 => format!(
                    "{corner_mm} mm contradicts the kind, which gives {kind_mm} mm. Leave it out, or state the kind of this cutter ({})",
                    ToolKind::of(radius_mm, corner_mm)
                ),
                None if self.kind == ToolKind::BullNose && !(corner_mm > 0.0 && corner_mm < radius_mm) => {
                    format!(
                        "{corner_mm} mm is not between 0 and the radius of {radius_mm} mm, but the kind is bull-nose. Correct it, or state the kind {}",
                        ToolKind::of(radius_mm, corner_mm)
                    )
                }
                _ => return Some(corner_mm),
            },
        };
        faults.push(|| Fault::new("/corner_radius_mm", detail));
        None
    }

    fn without_radius(&self, faults: &mut FaultList) -> Option<f64> {
        if self.kind != ToolKind::Other {
            faults.push(|| {
                let detail = "missing: only a tool of the kind other may have no radius";
                Fault::new("/radius_mm", detail)
            });
        } else if self.corner_radius_mm.is_some() {
            faults.push(|| {
                let detail = "missing: a corner radius needs the tool radius too. State both, or neither";
                Fault::new("/radius_mm", detail)
            });
        }
        None
    }
}

impl ToolKind {
    /// The word of the kind that a cutter of these radii \[mm\] has.
    fn of(radius_mm: f64, corner_mm: f64) -> &'static str {
        if corner_mm >= radius_mm {
            "ball"
        } else if corner_mm > 0.0 {
            "bull-nose"
        } else {
            "flat"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_json;
    use super::*;

    fn normalised(tool: TableTool) -> Result<TableTool, Vec<Fault>> {
        let mut faults = FaultList::default();
        let tool = tool.normalised(&mut faults);
        faults.into_result().map(|()| tool)
    }

    fn tool(text: &str) -> Result<TableTool, Vec<(String, String)>> {
        let posted: TableTool = read_json(text.as_bytes()).unwrap();
        normalised(posted)
            .map_err(|faults| faults.into_iter().map(|fault| (fault.pointer, fault.detail)).collect())
    }

    fn pointers(text: &str) -> Vec<String> {
        tool(text).unwrap_err().into_iter().map(|(pointer, _)| pointer).collect()
    }

    #[test]
    fn the_kind_says_the_corner_radius() {
        for (text, corner_mm) in [
            (r#"{"number": 1, "kind": "ball", "radius_mm": 5}"#, Some(5.0)),
            (r#"{"number": 1, "kind": "ball", "radius_mm": 5, "corner_radius_mm": 5}"#, Some(5.0)),
            (r#"{"number": 1, "kind": "flat", "radius_mm": 5}"#, Some(0.0)),
            (r#"{"number": 1, "kind": "flat", "radius_mm": 5, "corner_radius_mm": -0.0}"#, Some(0.0)),
            (r#"{"number": 1, "kind": "bull-nose", "radius_mm": 5, "corner_radius_mm": 0.5}"#, Some(0.5)),
            (r#"{"number": 1, "kind": "other", "radius_mm": 5}"#, None),
            (r#"{"number": 1, "kind": "other", "radius_mm": 5, "corner_radius_mm": 5}"#, Some(5.0)),
            (r#"{"number": 1, "kind": "other"}"#, None),
        ] {
            let read = tool(text).unwrap();
            assert_eq!(read.corner_radius_mm, corner_mm, "{text}");
            assert_eq!(read.corner_radius_mm.map(f64::is_sign_negative), corner_mm.map(|_| false));
            assert_eq!(read.cutter().is_some(), corner_mm.is_some(), "{text}");
            // A normalised document stays as it is.
            assert_eq!(normalised(read.clone()).unwrap(), read, "{text}");
        }
    }

    #[test]
    fn contradictions_are_named_with_their_cure() {
        for (text, pointer, cure) in [
            (
                r#"{"number": 1, "kind": "ball", "radius_mm": 5, "corner_radius_mm": 0}"#,
                "/corner_radius_mm",
                "(flat)",
            ),
            (
                r#"{"number": 1, "kind": "flat", "radius_mm": 5, "corner_radius_mm": 5}"#,
                "/corner_radius_mm",
                "(ball)",
            ),
            (
                r#"{"number": 1, "kind": "flat", "radius_mm": 5, "corner_radius_mm": 1}"#,
                "/corner_radius_mm",
                "(bull-nose)",
            ),
            (
                r#"{"number": 1, "kind": "bull-nose", "radius_mm": 5, "corner_radius_mm": 5}"#,
                "/corner_radius_mm",
                "kind ball",
            ),
            (
                r#"{"number": 1, "kind": "bull-nose", "radius_mm": 5, "corner_radius_mm": 0}"#,
                "/corner_radius_mm",
                "kind flat",
            ),
            (r#"{"number": 1, "kind": "bull-nose", "radius_mm": 5}"#, "/corner_radius_mm", "missing"),
            (
                r#"{"number": 1, "kind": "bull-nose", "radius_mm": 5, "corner_radius_mm": 6}"#,
                "/corner_radius_mm",
                "between 0 and",
            ),
            (r#"{"number": 1, "kind": "other", "corner_radius_mm": 1}"#, "/radius_mm", "State both"),
            (r#"{"number": 1, "kind": "ball"}"#, "/radius_mm", "missing"),
            (
                r#"{"number": 1, "kind": "other", "radius_mm": 0}"#,
                "/radius_mm",
                "between 0.001 mm and 1000 mm",
            ),
            (r#"{"kind": "other"}"#, "/number", "State one of them"),
        ] {
            let faults = tool(text).unwrap_err();
            assert_eq!(faults.len(), 1, "{text}: {faults:?}");
            assert_eq!(faults[0].0, pointer, "{text}");
            assert!(faults[0].1.contains(cure), "{text}: {}", faults[0].1);
        }
        let all = r#"{"name": "", "kind": "ball", "radius_mm": -1, "length_mm": 1e9}"#;
        assert_eq!(pointers(all), ["/name", "/length_mm", "/radius_mm"]);
    }

    #[test]
    fn a_name_can_stand_in_quotes_in_a_program() {
        let named = |name: &str| TableTool { name: Some(name.to_owned()), ..tool(OTHER).unwrap() };
        for good in ["BALL_10", "Kugel Ø 10/2", &"a".repeat(64)] {
            assert!(normalised(named(good)).is_ok(), "{good:?}");
        }
        for bad in ["", "a\"b", "a'b", "a\\b", "a\nb", " a", "a ", "a\u{200b}", &"a".repeat(65)] {
            let faults = normalised(named(bad)).unwrap_err();
            assert_eq!(faults[0].pointer, "/name", "{bad:?}");
        }
        assert_eq!(tool_name_key("Ball_10ä"), "BALL_10ä");
    }

    const OTHER: &str = r#"{"number": 4294967295, "kind": "other"}"#;
}
