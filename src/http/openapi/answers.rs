//! Examples of answers: the service's real answers to the examples of requests. `tests/api/examples.rs` requests each
//! of them and writes it down (`BLESS=1`); no example is invented.

use serde_json::{Map, Value, json};

/// Answers by operation and media type.
const ANSWERS: &str = include_str!("answers.json");

/// All answers; empty if they cannot be read, which the test of the description finds.
pub(super) fn all() -> Map<String, Value> {
    serde_json::from_str(ANSWERS).unwrap_or_default()
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
