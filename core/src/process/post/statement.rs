//! Statements for the post-processor that become words of the posted program.

use crate::process::fault::NotPosted;

/// Longest dwell written \[s\], and fastest spindle \[1/min\]. Larger values are mistakes in the text.
const MAX_DWELL_S: f64 = 9999.0;
const MAX_SPINDLE_PER_MIN: f64 = 1e6;
/// Statements that switch or move something on the machine. As comments they have no effect.
const FOR_THE_MACHINE: [&str; 10] =
    ["STOP", "OPSTOP", "DELAY", "SPINDL", "COOLNT", "AUXFUN", "PREFUN", "CLAMP", "INSERT", "SET"];

/// What a statement becomes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Posted {
    /// A block with these words.
    Words(String),
    /// A comment without loss: it is for people, or for the caller's frame.
    Comment,
    /// A comment, although the machine should act on it: its form is unknown.
    NotDone,
}

/// The coolant switched on last. Flood at the start; missing after an unknown form.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coolant(Option<&'static str>);

impl Default for Coolant {
    fn default() -> Self {
        Self(Some("M8"))
    }
}

impl Coolant {
    fn switch(&mut self, words: Option<&'static str>) -> Option<String> {
        self.0 = words;
        self.again()
    }

    fn again(self) -> Option<String> {
        self.0.map(str::to_owned)
    }
}

/// The spindle, as far as the words of the program say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Spindle {
    /// No word so far: the caller's frame starts it.
    #[default]
    Unsaid,
    Runs,
    /// M6 has stopped it.
    StoppedByChange,
    /// M5 has stopped it.
    Stopped,
}

impl Spindle {
    /// Takes the words of a statement.
    pub(super) fn see(&mut self, words: &str) {
        match words.split_ascii_whitespace().last() {
            Some("M3" | "M4") => *self = Self::Runs,
            Some("M5") => *self = Self::Stopped,
            _ => {}
        }
    }

    /// Why a cut is refused here, if it is.
    pub(super) fn against_cut(self) -> Option<NotPosted> {
        match self {
            Self::Unsaid | Self::Runs => None,
            Self::StoppedByChange => Some(NotPosted::SpindleStands),
            Self::Stopped => Some(NotPosted::SpindleStopped),
        }
    }
}

/// Reads a statement: `STOP` is M0, `OPSTOP` M1, `DELAY/s` a G4 in milliseconds, `SPINDL/n,CLW` S and M3 (CCLW:
/// M4), `SPINDL/OFF` M5, `COOLNT/` `FLOOD` M8, `MIST` M7, `OFF` M9, `ON` the one that was on last, which `coolant`
/// keeps. With anything else beside them it becomes a comment.
pub(super) fn posted(statement: &[u8], coolant: &mut Coolant) -> Posted {
    let text = String::from_utf8_lossy(statement).to_ascii_uppercase();
    let text = text.split("$$").next().unwrap_or_default();
    let mut items = text
        .split(|c: char| matches!(c, '/' | ',' | '$') || c.is_whitespace())
        .filter(|item| !item.is_empty());
    let major = items.next().unwrap_or_default();
    let minors: Vec<&str> = items.collect();
    let words = match (major, minors.as_slice()) {
        ("STOP", []) => Some("M0".to_owned()),
        ("OPSTOP", []) => Some("M1".to_owned()),
        ("DELAY", [time]) => dwell(time),
        ("SPINDL", ["OFF"]) => Some("M5".to_owned()),
        ("SPINDL", minors) => spindle(minors),
        ("COOLNT", ["ON"]) => coolant.again(),
        ("COOLNT", ["FLOOD"]) => coolant.switch(Some("M8")),
        ("COOLNT", ["MIST"]) => coolant.switch(Some("M7")),
        ("COOLNT", ["OFF"]) => Some("M9".to_owned()),
        ("COOLNT", _) => coolant.switch(None),
        _ => None,
    };
    match words {
        Some(words) => Posted::Words(words),
        None if FOR_THE_MACHINE.contains(&major) => Posted::NotDone,
        None => Posted::Comment,
    }
}

/// Seconds as whole milliseconds: only a whole P has the same meaning with and without a decimal point.
fn dwell(text: &str) -> Option<String> {
    let time_s = text.parse::<f64>().ok().filter(|time_s| (0.001..=MAX_DWELL_S).contains(time_s))?;
    Some(format!("G4 P{:.0}", (time_s * 1000.0).ceil()))
}

/// A speed in turns per minute and a direction, in either order, with or without the word RPM.
fn spindle(minors: &[&str]) -> Option<String> {
    let (mut speed, mut sense) = (None, None);
    for minor in minors {
        match *minor {
            "RPM" => {}
            "CLW" if sense.is_none() => sense = Some("M3"),
            "CCLW" if sense.is_none() => sense = Some("M4"),
            number if speed.is_none() => {
                let per_min = number.parse::<f64>().ok()?;
                let is_whole = per_min.fract().abs() <= 0.0;
                speed =
                    Some(per_min).filter(|per_min| is_whole && (1.0..=MAX_SPINDLE_PER_MIN).contains(per_min));
            }
            _ => return None,
        }
    }
    Some(format!("S{:.0} {}", speed?, sense?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn posted(statement: &[u8]) -> Posted {
        super::posted(statement, &mut Coolant::default())
    }

    #[test]
    fn plain_statements_are_words_and_others_are_named() {
        for (statement, words) in [
            ("STOP", "M0"),
            ("  opstop  $$ look", "M1"),
            ("DELAY/2", "G4 P2000"),
            ("DELAY/ 0.0015", "G4 P2"),
            ("SPINDL/RPM,8000,CLW", "S8000 M3"),
            ("SPINDL/ CCLW, $\n 500.", "S500 M4"),
            ("SPINDL/OFF", "M5"),
            ("COOLNT/ON", "M8"),
            ("COOLNT/MIST", "M7"),
            ("COOLNT/OFF", "M9"),
        ] {
            assert_eq!(posted(statement.as_bytes()), Posted::Words(words.to_owned()), "{statement}");
        }
        for statement in [
            "STOP/1",
            "DELAY/3,REV",
            "DELAY/-1",
            "DELAY/nan",
            "DELAY/1e9",
            "SPINDL/8000",
            "SPINDL/ON",
            "SPINDL/SFM,100,CLW",
            "SPINDL/8000,CLW,RANGE,2",
            "SPINDL/0,CLW",
            "SPINDL/800.5,CLW",
            "SPINDL/8000,9000,CLW",
            "COOLNT/THRU",
            "COOLNT/ON,MIST",
            "AUXFUN/8",
            "INSERT M8",
        ] {
            assert_eq!(posted(statement.as_bytes()), Posted::NotDone, "{statement}");
        }
        for statement in ["PARTNO/STOP", "PPRINT STOP HERE", "CUTTER/10", "", "\u{fffd}"] {
            assert_eq!(posted(statement.as_bytes()), Posted::Comment, "{statement}");
        }
    }

    #[test]
    fn coolant_comes_back_as_it_was_on_last() {
        let mut coolant = Coolant::default();
        let words = ["ON", "MIST", "OFF", "ON", "FLOOD", "OFF", "ON"]
            .map(|minor| super::posted(format!("COOLNT/{minor}").as_bytes(), &mut coolant));
        let expected = ["M8", "M7", "M9", "M7", "M8", "M9", "M8"].map(|word| Posted::Words(word.to_owned()));
        assert_eq!(words, expected);
        let words = ["THRU", "OFF", "ON", "MIST", "ON"]
            .map(|minor| super::posted(format!("COOLNT/{minor}").as_bytes(), &mut coolant));
        let [m9, m7] = ["M9", "M7"].map(|word| Posted::Words(word.to_owned()));
        assert_eq!(words, [Posted::NotDone, m9, Posted::NotDone, m7.clone(), m7]);
    }
}
