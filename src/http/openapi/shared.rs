//! What several operations have is written once, under `components`: every refusal, and parameters, headers and
//! examples that occur more than once. Refusals that no operation has of its own are in its `default` response.
//!
//! The most frequent of several values gets the plain name, such as the status of a refusal. The names of the others
//! end with the id of the first operation that has them.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::general_refusals;
use super::schemas::pascal;
use super::{each_operation, is_refusal};

/// An example that is shorter than this is not worth a reference \[bytes\].
const SHORT_EXAMPLE: usize = 160;

/// Moves shared parts to `components`.
pub(super) fn share(document: &mut Value) {
    type Visit = fn(&mut Map<String, Value>, &str, &mut Parts);
    let kinds: [(&str, usize, Visit); 4] = [
        ("examples", 2, examples),
        ("headers", 2, headers),
        ("parameters", 2, parameters),
        ("responses", 1, refusals),
    ];
    general_refusals::gather(document);
    for (kind, least, visit) in kinds {
        let mut parts = Parts::default();
        each_operation(document, |operation, id| visit(operation, id, &mut parts));
        let shared = parts.name(kind, least);
        each_operation(document, |operation, id| visit(operation, id, &mut parts));
        if let Some(components) = document.get_mut("components").and_then(Value::as_object_mut) {
            components.insert(kind.to_owned(), Value::Object(shared));
        }
    }
}

/// How often a value occurs, and where first.
#[derive(Debug)]
struct Use {
    base: String,
    first: String,
    count: usize,
}

/// Parts of one kind: counted at the first visit, replaced by references once they are named.
#[derive(Debug, Default)]
struct Parts {
    uses: BTreeMap<String, Use>,
    references: Option<BTreeMap<String, Value>>,
}

impl Parts {
    /// Visits a part that would get this name; without a name, that of the operation.
    fn visit(&mut self, part: &mut Value, base: &str, operation: &str) {
        let key = format!("{base} {part}");
        let Some(references) = &self.references else {
            let new = || Use { base: base.to_owned(), first: operation.to_owned(), count: 0 };
            self.uses.entry(key).or_insert_with(new).count += 1;
            return;
        };
        if let Some(reference) = references.get(&key) {
            *part = reference.clone();
        }
    }

    /// Names the parts that occur at least so often.
    fn name(&mut self, kind: &str, least: usize) -> Map<String, Value> {
        let mut order: Vec<_> = self.uses.iter().filter(|(_, one)| one.count >= least).collect();
        order.sort_by_key(|(key, one)| (&one.base, std::cmp::Reverse(one.count), *key));
        let (mut shared, mut references) = (Map::new(), BTreeMap::new());
        for (key, one) in order {
            let plain = if one.base.is_empty() { &one.first } else { &one.base };
            let others = [plain.clone(), format!("{plain}-{}", one.first), format!("{plain}-2")];
            let Some(name) = others.into_iter().find(|name| !shared.contains_key(name)) else { continue };
            let text = key.get(one.base.len() + 1..).unwrap_or_default();
            if let Ok(part) = serde_json::from_str(text) {
                references.insert(key.clone(), json!({ "$ref": format!("#/components/{kind}/{name}") }));
                shared.insert(name, part);
            }
        }
        self.references = Some(references);
        shared
    }
}

fn responses_of(operation: &mut Map<String, Value>) -> impl Iterator<Item = (&String, &mut Value)> {
    operation.get_mut("responses").and_then(Value::as_object_mut).into_iter().flatten()
}

fn refusals(operation: &mut Map<String, Value>, id: &str, parts: &mut Parts) {
    for (status, response) in responses_of(operation).filter(|(status, _)| is_refusal(status)) {
        parts.visit(response, status, id);
    }
}

fn headers(operation: &mut Map<String, Value>, id: &str, parts: &mut Parts) {
    for (_, response) in responses_of(operation) {
        let headers = response.get_mut("headers").and_then(Value::as_object_mut);
        for (name, header) in headers.into_iter().flatten() {
            parts.visit(header, name, id);
        }
    }
}

fn parameters(operation: &mut Map<String, Value>, id: &str, parts: &mut Parts) {
    let parameters = operation.get_mut("parameters").and_then(Value::as_array_mut);
    for parameter in parameters.into_iter().flatten() {
        let name = pascal(parameter.get("name").and_then(Value::as_str).unwrap_or_default());
        parts.visit(parameter, &name, id);
    }
}

fn examples(operation: &mut Map<String, Value>, id: &str, parts: &mut Parts) {
    if let Some(body) = operation.get_mut("requestBody") {
        examples_of(body, "request", id, parts);
    }
    for (_, response) in responses_of(operation) {
        examples_of(response, "answer", id, parts);
    }
}

fn examples_of(body: &mut Value, name: &str, id: &str, parts: &mut Parts) {
    let contents = body.get_mut("content").and_then(Value::as_object_mut);
    for content in contents.into_iter().flatten().filter_map(|(_, content)| content.as_object_mut()) {
        let Some(example) = content.remove("example") else { continue };
        let mut whole = json!({ "value": example });
        if whole.to_string().len() >= SHORT_EXAMPLE {
            parts.visit(&mut whole, "", id);
        }
        match whole.get_mut("value") {
            Some(value) => content.insert("example".to_owned(), value.take()),
            None => content.insert("examples".to_owned(), json!({ name: whole })),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_the_same_twice_is_written_once() {
        let tall = json!({ "name": "limit", "in": "query", "description": "Tall." });
        let wide = json!({ "name": "limit", "in": "query", "description": "Wide." });
        let gone = json!({ "description": "Gone." });
        let lost = json!({ "description": "Lost." });
        let answer =
            |text: &str| json!({ "description": "Good.", "content": {"text/plain": {"example": text}} });
        let long = "x".repeat(SHORT_EXAMPLE);
        let operation = |id: &str, parameter: &Value, refusal: &Value, text: &str| {
            json!({ "post": {
                "operationId": id, "parameters": [parameter], "responses": {"200": answer(text), "404": refusal}
            }})
        };
        let mut document = json!({ "components": {}, "paths": {
            "/a": operation("a", &wide, &gone, "short"), "/b": operation("b", &tall, &lost, "short"),
            "/c": operation("c", &tall, &lost, &long),
        }});
        share(&mut document);
        let components = &document["components"];
        assert_eq!(components["parameters"], json!({ "Limit": tall }));
        assert_eq!(components["responses"]["404"], lost);
        assert_eq!(components["responses"]["404-a"], gone);
        assert_eq!(components["examples"], json!({}));
        assert_eq!(document["paths"]["/a"]["post"]["parameters"], json!([wide]));
        assert_eq!(
            document["paths"]["/b"]["post"]["parameters"],
            json!([{ "$ref": "#/components/parameters/Limit" }])
        );
        let refusal = |path: &str| document["paths"][path]["post"]["responses"]["404"]["$ref"].clone();
        assert_eq!(refusal("/a"), "#/components/responses/404-a");
        assert_eq!(refusal("/c"), "#/components/responses/404");
        let answered = |path: &str| document["paths"][path]["post"]["responses"]["200"].clone();
        assert_eq!((answered("/a"), answered("/c")), (answer("short"), answer(&long)));
    }

    #[test]
    fn an_example_of_two_operations_is_one_example() {
        let long = "x".repeat(SHORT_EXAMPLE);
        let answer = json!({ "description": "Good.", "content": {"text/plain": {"example": long}} });
        let operation = |id: &str| json!({ "get": {"operationId": id, "responses": {"200": answer}} });
        let mut document = json!({ "components": {}, "paths": {"/a": operation("a"), "/b": operation("b")} });
        share(&mut document);
        assert_eq!(document["components"]["examples"], json!({ "a": {"value": long} }));
        let content = &document["paths"]["/b"]["get"]["responses"]["200"]["content"]["text/plain"];
        assert_eq!(content, &json!({ "examples": {"answer": {"$ref": "#/components/examples/a"}} }));
    }
}
