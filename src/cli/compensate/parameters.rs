//! The parameters of the operation: JSON as the service takes it, and flags for the usual members.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::{CompensateArguments, at};
use crate::cli::CommandFault;
use crate::wire::JobOperation;

/// Parameters as they are given.
#[derive(Debug, Clone, Copy)]
pub(super) enum Parameters<'a> {
    /// As text.
    Inline(&'a str),
    /// In a file.
    File(&'a Path),
}

impl<'a> Parameters<'a> {
    /// A text that begins as JSON is JSON; every other text is the path of a file.
    pub(super) fn of(typed: &'a str) -> Self {
        let text = typed.trim_start();
        if text.starts_with('{') { Self::Inline(text) } else { Self::File(Path::new(typed)) }
    }

    /// The text, up to a limit.
    pub(super) fn read(self, limit_bytes: u64) -> Result<Vec<u8>, CommandFault> {
        let setting = "max_parameters_bytes";
        match self {
            Self::Inline(text) if text.len() as u64 > limit_bytes => {
                Err(CommandFault::TooLarge { path: PathBuf::from("--parameters"), limit_bytes, setting })
            }
            Self::Inline(text) => Ok(text.as_bytes().to_vec()),
            Self::File(path) => read_within(path, setting, limit_bytes),
        }
    }
}

/// A whole file, up to the limit of a setting; an endless file, such as a device, is not read further.
pub(super) fn read_within(
    path: &Path,
    setting: &'static str,
    limit_bytes: u64,
) -> Result<Vec<u8>, CommandFault> {
    let mut text = Vec::new();
    let file = File::open(path).map_err(at("opening", path))?;
    file.take(limit_bytes.saturating_add(1)).read_to_end(&mut text).map_err(at("reading", path))?;
    if text.len() as u64 > limit_bytes {
        return Err(CommandFault::TooLarge { path: path.to_owned(), limit_bytes, setting });
    }
    Ok(text)
}

/// A flag with the member that it sets: the object that the member is in, if it is in one, its name and its value.
struct Typed {
    flag: &'static str,
    within: Option<&'static str>,
    name: &'static str,
    value: Value,
}

/// The parameters with the values of the flags. Without any parameters, a compensation is that of the contact path. A
/// text that is not a JSON object is left for the operation to refuse.
pub(super) fn with_flags(
    parameters: Vec<u8>,
    arguments: &CompensateArguments,
) -> Result<Vec<u8>, CommandFault> {
    let typed = typed(arguments)?;
    let is_bare = arguments.parameters.is_none() && arguments.operation == JobOperation::Compensation;
    if typed.is_empty() && !is_bare {
        return Ok(parameters);
    }
    let read = serde_json::from_slice::<Map<String, Value>>(&parameters);
    let (Ok(stated), Some(open)) = (read, memchr::memchr(b'{', &parameters)) else { return Ok(parameters) };
    let mut added = Map::new();
    if is_bare {
        added.insert("cc".to_owned(), json!({}));
    }
    for Typed { flag, within, name, value } in typed {
        let known = match within {
            Some(object) => stated.get(object).and_then(|object| object.get(name)),
            None => stated.get(name),
        };
        match known {
            Some(known) if is_same(known, &value) => continue,
            Some(known) => {
                let (typed, stated) = (value.to_string(), known.to_string());
                return Err(CommandFault::TwoValues { flag, name, typed, stated });
            }
            None => {}
        }
        let Some(object) = within else {
            added.insert(name.to_owned(), value);
            continue;
        };
        let members = added.entry(object).or_insert_with(|| stated.get(object).cloned().unwrap_or(json!({})));
        // A member that is no object is refused by the operation.
        if let Some(members) = members.as_object_mut() {
            members.insert(name.to_owned(), value);
        }
    }
    if added.keys().any(|name| stated.contains_key(name)) {
        let whole: Map<String, Value> = stated.into_iter().chain(added).collect();
        return Ok(Value::Object(whole).to_string().into_bytes());
    }
    // The text stays as it is, so that its faults are reported.
    let comma = if stated.is_empty() || added.is_empty() { "" } else { "," };
    let members = Value::Object(added).to_string();
    let members = members.trim_start_matches('{').strip_suffix('}').unwrap_or_default();
    let (head, rest) = parameters.split_at(open + 1);
    Ok([head, members.as_bytes(), comma.as_bytes(), rest].concat())
}

/// Whether two values are the same: 5 and 5.0 are.
fn is_same(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Number(one), Value::Number(other)) => one.as_f64() == other.as_f64(),
        (Value::Array(one), Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| is_same(one, other))
        }
        _ => one == other,
    }
}

/// The values of the flags, at the places that the operation has for them.
fn typed(arguments: &CompensateArguments) -> Result<Vec<Typed>, CommandFault> {
    let operation = arguments.operation;
    let of_path = |flag, name, value: f64| {
        let within = match operation {
            JobOperation::CcCompensation => None,
            JobOperation::Compensation => Some("cc"),
            _ => return Err(CommandFault::NoSuchMember { flag, operation: operation.as_str() }),
        };
        Ok(Typed { flag, within, name, value: json!(value) })
    };
    let mut all = Vec::new();
    if let Some(unit) = arguments.unit {
        all.push(Typed { flag: "--unit", within: None, name: "unit", value: json!(unit) });
    }
    if let Some(offset) = &arguments.work_offset_mm {
        let flag = "--work-offset-mm";
        all.push(Typed { flag, within: None, name: "work_offset_mm", value: json!(offset.0) });
    }
    if let Some(radius) = arguments.tool_radius_mm {
        all.push(of_path("--tool-radius-mm", "tool_radius_mm", radius)?);
    }
    if let Some(tolerance) = arguments.tolerance_um {
        all.push(of_path("--tolerance-um", "tolerance_um", tolerance)?);
    }
    if arguments.flatten {
        let flag = "--flatten";
        if !matches!(
            operation,
            JobOperation::CcCompensation | JobOperation::WearCompensation | JobOperation::Compensation
        ) {
            return Err(CommandFault::NoSuchMember { flag, operation: operation.as_str() });
        }
        all.push(Typed { flag, within: None, name: "flatten", value: json!(true) });
    }
    if arguments.location_errors {
        let flag = "--location-errors";
        if operation != JobOperation::Compensation {
            return Err(CommandFault::NoSuchMember { flag, operation: operation.as_str() });
        }
        all.push(Typed { flag, within: None, name: "location_errors", value: json!(true) });
    }
    Ok(all)
}
