//! Examples of answers: the service's real answers to the examples of requests. `tests/api/examples.rs` requests each
//! of them and writes it down (`BLESS=1`); no example is invented.

use serde_json::{Map, Value, json};

/// Answers by operation and media type.
const ANSWERS: &str = include_str!("answers.json");

/// Operations whose example is that of another, because they answer with the same document.
const SHOWN_AS: &[(&str, &str)] = &[("apply_calibration", "get_machine"), ("put_machine", "get_machine")];

/// Items of a list, and members of an object by axis letter, that the description has.
const ITEMS: usize = 2;
/// The second item of a list is left out if the first one is longer than this \[bytes\].
const LONG_ITEM: usize = 120;
/// Lists that have a fixed number of items.
const WHOLE: &[&str] = &["rotary_axes"];
/// Characters of a text that the description has, to the end of a line.
const CHARACTERS: usize = 200;
/// Characters of a figure that the description has: its first line says what it is.
const FIGURE_CHARACTERS: usize = 40;
/// Names of axes.
const AXES: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

/// All answers in brief; empty if they cannot be read, which the test of the description finds.
pub(super) fn all() -> Map<String, Value> {
    let mut answers: Map<String, Value> = serde_json::from_str(ANSWERS).unwrap_or_default();
    for (operation, other) in SHOWN_AS {
        if let Some(shown) = answers.get(*other).cloned() {
            answers.insert((*operation).to_owned(), shown);
        }
    }
    answers.into_iter().map(|(id, answers)| (id, brief("", answers))).collect()
}

/// The first items of lists (of numbers all, because they may be a vector), the first axes, members that have a value,
/// the beginning of texts, four digits of numbers.
fn brief(name: &str, answer: Value) -> Value {
    match answer {
        Value::Array(items) => {
            let is_long = items.first().is_some_and(|item| item.to_string().len() > LONG_ITEM);
            let kept = match items.as_slice() {
                all if all.iter().all(Value::is_number) || WHOLE.contains(&name) => all.len(),
                _ if is_long => 1,
                _ => ITEMS,
            };
            items.into_iter().take(kept).map(|item| brief("", item)).collect()
        }
        Value::Object(members) => {
            let by_axis =
                members.iter().all(|(name, value)| AXES.contains(&name.as_str()) && value.is_object());
            let kept = if by_axis { ITEMS } else { members.len() };
            let members = members.into_iter().filter(|(_, value)| !value.is_null()).take(kept);
            members.map(|(name, value)| (name.clone(), brief(&name, value))).collect()
        }
        Value::String(text) => {
            let most = if text.starts_with("<svg") { FIGURE_CHARACTERS } else { CHARACTERS };
            Value::String(match text.char_indices().nth(most) {
                Some((end, _)) => {
                    let beginning = text.get(..end).unwrap_or_default();
                    let end = beginning.rfind('\n').map_or(end, |last| last + 1);
                    format!("{}…", text.get(..end).unwrap_or_default())
                }
                None => text,
            })
        }
        Value::Number(number) if number.is_f64() => {
            let value = number.as_f64().unwrap_or_default();
            format!("{value:.3e}").parse::<f64>().map_or(Value::Number(number), Value::from)
        }
        other => other,
    }
}

/// Adds an operation's answers to its responses that have no example.
pub(super) fn insert(operation: &mut Map<String, Value>, answers: &Map<String, Value>) {
    let id = operation.get("operationId").and_then(Value::as_str).unwrap_or_default();
    let answers = answers.get(id).unwrap_or(&Value::Null);
    let responses = operation.get("responses").cloned().unwrap_or_default();
    let Value::Object(mut responses) = responses else { return };
    for (status, response) in responses.iter_mut().filter(|(status, _)| status.starts_with('2')) {
        let contents = response.get_mut("content").and_then(Value::as_object_mut);
        for (kind, content) in contents.into_iter().flatten() {
            let Some(content) = content.as_object_mut() else { continue };
            // A part of the bytes has the same media type but is not a document. A stream has no end; OpenAPI before
            // 3.2 cannot describe the form of its events.
            if (status == "206" && kind == "application/json") || kind == "text/event-stream" {
                content.remove("schema");
                continue;
            }
            if let Some(answer) = answers.get(kind)
                && !content.contains_key("example")
                && !content.contains_key("examples")
            {
                content.insert(
                    "example".to_owned(),
                    if status == "206" { beginning(answer) } else { answer.clone() },
                );
            }
        }
    }
    operation.insert("responses".to_owned(), Value::Object(responses));
}

/// The first bytes of a text.
fn beginning(text: &Value) -> Value {
    json!(text.as_str().unwrap_or_default().chars().take(32).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_in_brief_keeps_vectors_and_whole_lines() {
        let lines = "G1 X0.0 Y0.0\n".repeat(30);
        let answer = json!({ "axis": [0.0, 0.123_456_789, 1.0], "items": ["a", "b", "c"], "text": lines, "count": 12_345_678, "edge": null });
        let expected = format!("{}…", "G1 X0.0 Y0.0\n".repeat(CHARACTERS / 13));
        assert_eq!(
            brief("", answer),
            json!({ "axis": [0.0, 0.123_5, 1.0], "items": ["a", "b"], "text": expected, "count": 12_345_678 })
        );
    }

    #[test]
    fn an_answer_in_brief_has_one_long_item_two_axes_and_the_first_characters_of_a_figure() {
        let item = json!({ "words": "x".repeat(LONG_ITEM) });
        let drive = json!({ "gain_per_s": 30.0 });
        let answer = json!({
            "items": [item, item], "rotary_axes": [item, item], "plot": format!("<svg {}", "x".repeat(100)),
            "drives": {"A": drive, "C": drive, "X": drive}, "offsets": {"A": 1.0, "C": 2.0, "X": 3.0}
        });
        let expected = json!({
            "items": [item], "rotary_axes": [item, item], "plot": format!("<svg {}…", "x".repeat(FIGURE_CHARACTERS - 5)),
            "drives": {"A": drive, "C": drive}, "offsets": {"A": 1.0, "C": 2.0, "X": 3.0}
        });
        assert_eq!(brief("", answer), expected);
    }

    #[test]
    fn an_operation_that_is_shown_as_another_has_its_answer() {
        let answers = all();
        for (operation, other) in SHOWN_AS {
            assert!(answers.contains_key(*other), "{other}");
            assert_eq!(answers.get(*operation), answers.get(*other));
        }
    }
}
