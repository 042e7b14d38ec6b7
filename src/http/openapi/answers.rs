//! Examples of answers: the service's real answers to the examples of requests. `tests/api/examples.rs` requests each
//! of them and writes it down (`BLESS=1`); no example is invented.

use serde_json::{Map, Value, json};

/// Answers by operation and media type.
const ANSWERS: &str = include_str!("answers.json");

/// Items of a list that the description has.
const ITEMS: usize = 2;
/// Characters of a text that the description has, to the end of a line.
const CHARACTERS: usize = 200;

/// All answers in brief; empty if they cannot be read, which the test of the description finds.
pub(super) fn all() -> Map<String, Value> {
    let answers: Map<String, Value> = serde_json::from_str(ANSWERS).unwrap_or_default();
    answers.into_iter().map(|(id, answers)| (id, brief(answers))).collect()
}

/// The first items of lists (of numbers all, because they may be a vector), the beginning of texts, four digits of
/// numbers.
fn brief(answer: Value) -> Value {
    match answer {
        Value::Array(items) => {
            let kept = if items.iter().all(Value::is_number) { items.len() } else { ITEMS };
            items.into_iter().take(kept).map(brief).collect()
        }
        Value::Object(members) => members.into_iter().map(|(name, value)| (name, brief(value))).collect(),
        Value::String(text) => Value::String(match text.char_indices().nth(CHARACTERS) {
            Some((end, _)) => {
                let beginning = text.get(..end).unwrap_or_default();
                let end = beginning.rfind('\n').map_or(end, |last| last + 1);
                format!("{}…", text.get(..end).unwrap_or_default())
            }
            None => text,
        }),
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
        let answer = json!({ "axis": [0.0, 0.123_456_789, 1.0], "items": ["a", "b", "c"], "text": lines, "count": 12_345_678 });
        let expected = format!("{}…", "G1 X0.0 Y0.0\n".repeat(CHARACTERS / 13));
        assert_eq!(
            brief(answer),
            json!({ "axis": [0.0, 0.123_5, 1.0], "items": ["a", "b"], "text": expected, "count": 12_345_678 })
        );
    }
}
