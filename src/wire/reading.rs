//! JSON text to documents, with the location of faults.

use serde::de::DeserializeOwned;
use serde_path_to_error::{Path, Segment};
use thiserror::Error;

use super::{Fault, Objects};

/// Why a JSON text cannot be read as a document.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Unreadable {
    /// The text is not JSON.
    #[error("the body is not JSON: {reason}")]
    Syntax {
        /// The reader's message, with line and column.
        reason: String,
    },
    /// The text is JSON, but not the document: unknown, missing or mistyped fields.
    #[error("{}: {}", .0.pointer, .0.detail)]
    Document(Fault),
}

/// Reads one JSON document. Unknown and repeated fields, arrays in place of objects, and text after the end
/// are refused.
///
/// # Errors
/// The first fault.
pub fn read_json<T: DeserializeOwned>(text: &[u8]) -> Result<T, Unreadable> {
    let Ok(text) = std::str::from_utf8(text) else {
        return Err(Unreadable::Syntax { reason: "it is not UTF-8".to_owned() });
    };
    let mut reader = serde_json::Deserializer::from_str(text);
    let read = T::deserialize(Objects(&mut reader)).and_then(|value| reader.end().map(|()| value));
    // Following the path costs time on every key, so it is only done after a fault.
    read.map_err(|error| locate::<T>(text, &error))
}

fn locate<T: DeserializeOwned>(text: &str, first: &serde_json::Error) -> Unreadable {
    let mut reader = serde_json::Deserializer::from_str(text);
    let Err(error) = serde_path_to_error::deserialize::<_, T>(Objects(&mut reader)) else {
        return Unreadable::Syntax { reason: first.to_string() };
    };
    let out_of_range = error.inner().to_string().starts_with("number out of range");
    // A wrong type at the beginning does not prove that the rest is JSON. Numbers out of range are JSON, but
    // they stop this check too.
    if let Err(syntax) = serde_json::from_str::<serde::de::IgnoredAny>(text)
        && !syntax.is_data()
        && !out_of_range
    {
        return Unreadable::Syntax { reason: syntax.to_string() };
    }
    // The text is JSON, so the fault is a wrong value. If a word is expected, the reader only says that it
    // expected a value.
    let detail = if error.inner().is_data() || out_of_range {
        without_place(error.inner())
    } else {
        "use one of the words that this member allows, as text in quotation marks".to_owned()
    };
    Unreadable::Document(fault_at(error.path(), &detail))
}

/// The fault for a message at a path. The name of a missing field is only in the message and is added to the
/// pointer.
pub(super) fn fault_at(path: &Path, message: &str) -> Fault {
    let mut at = pointer(path);
    let quoted = |prefix: &str| message.strip_prefix(prefix).and_then(|rest| rest.split('`').next());
    if let Some(name) = quoted("missing field `") {
        at.push('/');
        at.push_str(name);
    }
    if let Some(name) = quoted("unknown field `").or_else(|| quoted("duplicate field `")) {
        let token = escape(name);
        if !at.ends_with(&format!("/{token}")) {
            at.push('/');
            at.push_str(&token);
        }
    }
    Fault::new(at, message)
}

fn pointer(path: &Path) -> String {
    let mut pointer = String::new();
    for segment in path {
        match segment {
            Segment::Seq { index } => {
                pointer.push('/');
                pointer.push_str(&index.to_string());
            }
            Segment::Map { key } => {
                pointer.push('/');
                pointer.push_str(&escape(key));
            }
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    pointer
}

/// A name as a part of a JSON pointer (RFC 6901 §3).
pub(super) fn escape(token: &str) -> String {
    token.replace('~', "~0").replace('/', "~1")
}

fn without_place(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(end) => text.get(..end).unwrap_or(&text).to_owned(),
        None => text,
    }
}
