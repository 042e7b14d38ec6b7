//! Names of schemas for readers of clients: without the names of Rust's own types and of the code.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::schemas::SCHEMAS;

/// Schemas of types that have no name of their own in the description.
const NAMED: &[(&str, &str)] = &[("BTreeMap", "FactorsByAxis"), ("Numbers2", "Pair"), ("Numbers3", "Vector")];

/// Renames schemas, and what refers to them.
pub(super) fn rename(document: &mut Value) {
    let Some(Value::Object(schemas)) = document.pointer_mut("/components/schemas") else { return };
    let mut names = BTreeMap::new();
    for name in schemas.keys() {
        let new = renamed(name);
        if new != *name && !schemas.contains_key(&new) {
            names.insert(format!("{SCHEMAS}{name}"), format!("{SCHEMAS}{new}"));
        }
    }
    let old = std::mem::take(schemas);
    let by_new_name = |(name, schema): (String, Value)| {
        let new = names.get(&format!("{SCHEMAS}{name}")).and_then(|path| path.strip_prefix(SCHEMAS));
        (new.map_or(name, str::to_owned), schema)
    };
    *schemas = old.into_iter().map(by_new_name).collect::<Map<_, _>>();
    refer(document, &names);
}

fn renamed(name: &str) -> String {
    if let Some((_, new)) = NAMED.iter().find(|(old, _)| *old == name) {
        return (*new).to_owned();
    }
    match name.strip_prefix("Listed_") {
        Some(item) => format!("{}List", item.trim_end_matches("Document")),
        None => name.strip_suffix("Doc").unwrap_or(name).to_owned(),
    }
}

fn refer(value: &mut Value, names: &BTreeMap<String, String>) {
    match value {
        Value::String(text) => {
            if let Some(new) = names.get(text) {
                text.clone_from(new);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| refer(item, names)),
        Value::Object(members) => members.values_mut().for_each(|item| refer(item, names)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_refers_to_a_schema_has_its_new_name() {
        let reference = |name: &str| json!({ "$ref": format!("{SCHEMAS}{name}") });
        let schemas = json!({
            "Listed_MachineDocument": {"items": reference("Numbers3")}, "Numbers3": {}, "ReadingDoc": {},
            "SetupDoc": {}, "Setup": {}
        });
        let mut document = json!({
            "paths": [reference("Listed_MachineDocument"), reference("SetupDoc"), reference("ReadingDoc")],
            "components": {"schemas": schemas}
        });
        rename(&mut document);
        // A name that another schema has is not taken.
        let schemas = json!({
            "MachineList": {"items": reference("Vector")}, "Vector": {}, "Reading": {}, "SetupDoc": {}, "Setup": {}
        });
        let paths = json!([reference("MachineList"), reference("SetupDoc"), reference("Reading")]);
        assert_eq!(document, json!({ "paths": paths, "components": {"schemas": schemas} }));
    }
}
