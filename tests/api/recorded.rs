//! Answers as examples: without what is new each time, long lists and texts cut, and kept in
//! `src/http/openapi/answers.json`, from where the description takes them. `BLESS=1` writes them anew.

use std::path::PathBuf;

use serde_json::{Map, Value};

/// Items of a list that are kept.
const ITEMS: usize = 3;
/// Characters of a text that are kept.
const CHARACTERS: usize = 600;
/// What numbers may differ by: the fits of calibrations use a linear algebra that knows several processors.
const RELATIVE: f64 = 1e-6;
/// The same next to zero.
const ABSOLUTE: f64 = 1e-9;

/// Stands for every id.
const ID: &str = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60";
/// Stands for every time of today.
const TIME: &str = "2026-03-14T09:26:53.589Z";
/// Stands for every API key and its id.
const KEY: (&str, &str) = ("trn_5f1c2d4e9a07_…", "5f1c2d4e9a07");

/// What the secret that signs webhooks begins with.
const SECRET: &str = "whsec_";
/// Stands for every one of them.
const SECRET_INSTEAD: &str = "whsec_…";
/// Characters of a key: `trn_`, its id of 12, `_`, its secret of 64.
const KEY_LENGTH: usize = 81;

/// The file.
fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/http/openapi/answers.json")
}

/// The committed answers, by operation and media type.
pub(crate) fn committed() -> Map<String, Value> {
    serde_json::from_str(&std::fs::read_to_string(path()).unwrap()).unwrap()
}

/// Whether they are to be written anew.
pub(crate) fn is_blessed() -> bool {
    std::env::var_os("BLESS").is_some()
}

/// Writes them.
pub(crate) fn write(answers: &Map<String, Value>) {
    std::fs::write(path(), serde_json::to_string_pretty(answers).unwrap() + "\n").unwrap();
}

/// A JSON answer as an example.
pub(crate) fn example(answer: &Value) -> Value {
    match answer {
        Value::Array(items) => items.iter().take(ITEMS).map(example).collect(),
        Value::Object(members) => {
            let kept = members.iter().map(|(name, value)| match value.as_str() {
                // The id of a key is no UUID.
                Some(id) if name.ends_with("id") && id.len() == 12 && id.bytes().all(is_hex) => {
                    (name.clone(), KEY.1.into())
                }
                _ => (name.clone(), example(value)),
            });
            Value::Object(kept.collect())
        }
        Value::String(text) => Value::String(lasting(text)),
        other => other.clone(),
    }
}

/// A text answer as an example.
pub(crate) fn text_example(answer: &str) -> Value {
    let text = lasting(answer);
    let Some((end, _)) = text.char_indices().nth(CHARACTERS) else { return Value::String(text) };
    let beginning = &text[..end];
    let whole_lines = beginning.rfind('\n').map_or(beginning, |last| &beginning[..=last]);
    Value::String(format!("{whole_lines}…"))
}

fn is_hex(byte: u8) -> bool {
    byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte)
}

/// A text without what is new each time.
fn lasting(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let (instead, length) = if is_key(rest) {
            (KEY.0, KEY_LENGTH)
        } else if let Some(secret) = rest.strip_prefix(SECRET) {
            let end = secret.find(|letter: char| !letter.is_ascii_alphanumeric() && !"+/=".contains(letter));
            (SECRET_INSTEAD, SECRET.len() + end.unwrap_or(secret.len()))
        } else if is_uuid(rest) {
            (ID, 36)
        } else if let Some(length) = time_of_today(rest) {
            (TIME, length)
        } else {
            kept.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        };
        kept.push_str(instead);
        rest = rest.get(length..).unwrap_or_default();
    }
    kept
}

fn is_key(text: &str) -> bool {
    text.strip_prefix("trn_").and_then(|rest| rest.get(..KEY_LENGTH - 4)).is_some_and(|rest| {
        rest.bytes().enumerate().all(|(index, byte)| if index == 12 { byte == b'_' } else { is_hex(byte) })
    })
}

fn is_uuid(text: &str) -> bool {
    let Some(head) = text.as_bytes().get(..36) else { return false };
    head.iter().enumerate().all(|(index, byte)| match index {
        8 | 13 | 18 | 23 => *byte == b'-',
        _ => is_hex(*byte),
    })
}

#[expect(clippy::disallowed_methods, reason = "some services under test have the clock of this computer")]
fn now() -> jiff::Timestamp {
    jiff::Timestamp::now()
}

/// The length of a time that stands at the beginning and is new each time: within a day of now, or of the clock that
/// tests have, which goes on by a second whenever anything asks it.
fn time_of_today(text: &str) -> Option<usize> {
    let (time, length) = [24, 20].into_iter().find_map(|length| {
        let time = text.get(..length)?;
        Some((time.strip_suffix('Z').and(time.parse::<jiff::Timestamp>().ok())?, length))
    })?;
    let clocks = [now(), jiff::Timestamp::from_second(1_772_000_000).unwrap()];
    let day = jiff::SignedDuration::from_hours(24);
    clocks.iter().any(|clock| time.duration_since(*clock).abs() < day).then_some(length)
}

/// Where two answers differ.
pub(crate) fn difference(left: &Value, right: &Value, at: &str) -> Option<String> {
    match (left, right) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            let near = (a - b).abs() <= ABSOLUTE + RELATIVE * a.abs().max(b.abs());
            (!near).then(|| format!("{at}: {a} and {b}"))
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().find_map(|(index, (a, b))| difference(a, b, &format!("{at}/{index}")))
        }
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            a.iter().find_map(|(name, value)| difference(value, &b[name], &format!("{at}/{name}")))
        }
        _ => (left != right).then(|| format!("{at}: {left} and {right}")),
    }
}

#[test]
fn what_is_new_each_time_is_not_in_an_example() {
    let now = now();
    let text =
        format!("job 0195a3f0-ffff-7b1a-8b57-3f1c2d4e5f60 at {now:.3}, measured 2025-03-14T09:26:53.000Z");
    assert_eq!(lasting(&text), format!("job {ID} at {TIME}, measured 2025-03-14T09:26:53.000Z"));
    assert_eq!(lasting("{whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oD=}"), "{whsec_…}");
    assert_eq!(difference(&1.0.into(), &(1.0 + 1e-8).into(), ""), None);
    assert!(difference(&1.0.into(), &1.001.into(), "").is_some());
    assert!(difference(&serde_json::json!({"a": 1}), &serde_json::json!({"b": 1}), "").is_some());
}
