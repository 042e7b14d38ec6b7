//! Statements that load tools, and statements that select the register of a tool's length.

use super::parameters::PostParameters;
use crate::program::Excerpt;

/// Items after which the number of the length register stands.
const REGISTERS: [&str; 5] = ["ADJUST", "OSETNO", "OFSETL", "OFSTNO", "OFFSTL"];
/// Statements that select a length register and load no tool.
const REGISTER_STATEMENTS: [&str; 6] = ["ADJUST", "OSETNO", "OFSETL", "OFSTNO", "OFFSTL", "TLOFST"];

/// A tool as `LOADTL/` names it: by its number, or by the whole statement if it has no number.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ToolName {
    Number(f64),
    Text(String),
}

/// What `LOADTL/` and similar statements say.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Load {
    pub(super) name: ToolName,
    /// The number of the length register: `ADJUST,n`, `OSETNO,n`.
    pub(super) register: Option<u32>,
    /// The length of the tool: `LENGTH,l`.
    pub(super) states_length: bool,
    /// The first item whose meaning is not certain.
    pub(super) odd: Option<Excerpt>,
}

impl Load {
    /// Reads the statement. `number` is that of its T word.
    pub(super) fn of(statement: &[u8], number: Option<f64>) -> Self {
        let text = upper(statement);
        let mut load =
            Self { name: ToolName::Text(text.clone()), register: None, states_length: false, odd: None };
        if let Some(number) = number {
            load.name = ToolName::Number(number);
        }
        load.odd = load.take_items(&text).err().map(|item| Excerpt::new(item.as_bytes()));
        load
    }

    /// Whether it takes the tool out.
    pub(super) fn unloads(statement: &[u8]) -> bool {
        upper(statement).starts_with("UNLOAD")
    }

    /// Takes the items after the name, in pairs. The error is the first one that is not understood.
    fn take_items(&mut self, text: &str) -> Result<(), String> {
        let is_open = |c: char| c.is_whitespace() || c == '$';
        let list = text.split_once('/').map_or("", |(_, list)| list);
        let list = list.trim_end_matches(|c: char| is_open(c) || c == ',');
        let mut items = list.split([',', '/']).map(|item| item.trim_matches(is_open));
        let mut name = items.next().unwrap_or_default();
        if name == "TOOL" {
            name = items.next().unwrap_or_default();
        }
        if REGISTERS.contains(&name) {
            return Err(name.to_owned());
        }
        while let Some(item) = items.next() {
            let value = items.next().and_then(|value| value.parse::<f64>().ok());
            match (item, value) {
                (register, Some(value)) if REGISTERS.contains(&register) => {
                    let number = length_number(value).ok_or_else(|| item.to_owned())?;
                    if self.register.replace(number).is_some_and(|other| other != number) {
                        return Err(item.to_owned());
                    }
                }
                ("LENGTH", Some(value)) if value >= 0.0 => self.states_length = true,
                ("ZOFF", Some(value)) if value.abs() <= 0.0 => {}
                _ => return Err(item.to_owned()),
            }
        }
        Ok(())
    }

    /// The number of the tool, if it is valid as a T word and as a length number.
    pub(super) fn number(&self) -> Option<u32> {
        match self.name {
            ToolName::Number(number) => length_number(number),
            ToolName::Text(_) => None,
        }
    }
}

/// A whole number that is valid as the number of a length.
fn length_number(number: f64) -> Option<u32> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be whole")]
    let whole = number as u32;
    (number.fract() == 0.0 && PostParameters::LENGTH_NUMBERS.contains(&whole)).then_some(whole)
}

/// Whether a statement selects a length register without loading a tool: `SET/OFSETL,3`, `OFSTNO/4`,
/// `CUTCOM/ON,LENGTH,7`.
pub(super) fn selects_register(statement: &[u8]) -> bool {
    let text = upper(statement);
    let mut items = text
        .split(|c: char| matches!(c, '/' | ',' | '$') || c.is_whitespace())
        .filter(|item| !item.is_empty());
    let major = items.next().unwrap_or_default();
    REGISTER_STATEMENTS.contains(&major)
        || (matches!(major, "SET" | "CUTCOM")
            && items.any(|item| item == "LENGTH" || REGISTER_STATEMENTS.contains(&item)))
}

/// The statement without its comment, in upper case.
fn upper(statement: &[u8]) -> String {
    let text = String::from_utf8_lossy(statement).to_ascii_uppercase();
    text.split("$$").next().unwrap_or_default().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(statement: &str, number: Option<f64>) -> (Option<u32>, Option<u32>, Option<String>) {
        let load = Load::of(statement.as_bytes(), number);
        (load.number(), load.register, load.odd.map(|odd| odd.to_string()))
    }

    #[test]
    fn the_register_of_a_tool_is_taken_and_other_items_are_named() {
        for (statement, number, register) in [
            ("LOADTL/2", 2, None),
            ("LOADTL/2,ADJUST,22", 2, Some(22)),
            (" load / tool , 2 , zoff, 0.0000 ,adjust, 9 $$ note", 2, Some(9)),
            ("LOADTL/4,LENGTH,120.5,OSETNO,$\n44", 4, Some(44)),
            ("TURRET/4,ADJUST,5,OSETNO,5,", 4, Some(5)),
        ] {
            assert_eq!(
                load(statement, Some(f64::from(number))),
                (Some(number), register, None),
                "{statement}"
            );
        }
        for (statement, odd) in [
            ("LOAD/TOOL,2,ZOFF,3.5,ADJUST,9", "ZOFF"),
            ("LOADTL/2,5", "5"),
            ("LOADTL/2,ADJUST", "ADJUST"),
            ("LOADTL/2,ADJUST,0", "ADJUST"),
            ("LOADTL/2,ADJUST,2.5", "ADJUST"),
            ("LOADTL/2,ADJUST,2,OSETNO,3", "OSETNO"),
            ("LOADTL/2,MANUAL", "MANUAL"),
            ("LOADTL/2,LENGTH,X", "LENGTH"),
        ] {
            assert_eq!(load(statement, Some(2.0)).2.as_deref(), Some(odd), "{statement}");
        }
        assert_eq!(load("LOADTL/ADJUST,5,12", None).2.as_deref(), Some("ADJUST"));
        assert_eq!(load("LOADTL/BALL", None), (None, None, None));
        assert_eq!(load("LOADTL/0", Some(0.0)).0, None);
    }

    #[test]
    fn statements_of_registers_are_known() {
        for statement in ["SET/OFSETL,3", "OFSTNO/4", "OFFSTL/5", "CUTCOM/ON,LENGTH,7", "set / adjust, 4"] {
            assert!(selects_register(statement.as_bytes()), "{statement}");
        }
        for statement in ["SET/MODE,2", "CUTCOM/LEFT", "PPRINT OFSTNO/4", "COOLNT/ON", "LOADTL/5"] {
            assert!(!selects_register(statement.as_bytes()), "{statement}");
        }
    }
}
