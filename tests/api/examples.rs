//! Every request example of the description, posted as it stands to a fresh service, is taken.

use std::sync::Arc;

use reqwest::Method;
use serde_json::Value;
use trunnion::jobs::CutterContactCompensator;

use crate::support::{App, spawn_real};

/// An operation with the example of one media type of its body.
struct Example {
    method: Method,
    path: String,
    kind: String,
    body: Vec<u8>,
}

/// The examples of all operations that take a body. A multipart form needs none: its fields have those of the others.
fn examples(document: &Value) -> Vec<Example> {
    let mut examples = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let content = operation["requestBody"]["content"].as_object();
            for (kind, media) in
                content.into_iter().flatten().filter(|(kind, _)| *kind != "multipart/form-data")
            {
                let example = &media["example"];
                assert!(!example.is_null(), "{method} {path} has no example of {kind}");
                let body = match example {
                    Value::String(text) if kind != "application/json" => text.clone().into_bytes(),
                    other => other.to_string().into_bytes(),
                };
                let method = Method::from_bytes(method.to_uppercase().as_bytes()).unwrap();
                let mut path = filled(path, operation);
                path += &required_query(operation);
                examples.push(Example { method, path, kind: kind.clone(), body });
            }
        }
    }
    examples
}

/// The path with the examples of its parameters.
fn filled(path: &str, operation: &Value) -> String {
    let mut path = path.to_owned();
    for parameter in operation["parameters"].as_array().into_iter().flatten() {
        if parameter["in"] == "path" {
            let name = parameter["name"].as_str().unwrap();
            assert!(parameter["example"].is_string(), "{path}: {name} has no example");
            let example = parameter["example"].as_str().unwrap();
            path = path.replace(&format!("{{{name}}}"), example);
        }
    }
    assert!(!path.contains('{'), "{path} has a parameter without an example");
    path
}

/// The query parameters that have an example and no default: those an operation cannot do without.
fn required_query(operation: &Value) -> String {
    let parameters = operation["parameters"].as_array().into_iter().flatten();
    let wanted: Vec<String> = parameters
        .filter(|parameter| parameter["in"] == "query" && parameter["example"].is_number())
        .map(|parameter| format!("{}={}", parameter["name"].as_str().unwrap(), parameter["example"]))
        .collect();
    if wanted.is_empty() { String::new() } else { format!("?{}", wanted.join("&")) }
}

async fn send(app: &App, example: &Example) -> (u16, String) {
    let mut request = app.client.request(example.method.clone(), app.url(&example.path));
    request = request.header("content-type", &example.kind).body(example.body.clone());
    let response = request.send().await.unwrap();
    (response.status().as_u16(), response.text().await.unwrap())
}

#[tokio::test]
async fn every_request_example_of_the_description_is_taken() {
    let app = spawn_real(Arc::new(CutterContactCompensator)).await;
    let document: Value = app.get("/openapi.json").await.json().await.unwrap();
    let examples = examples(&document);
    assert!(examples.len() >= 9, "only {} examples", examples.len());
    for example in &examples {
        let (status, body) = send(&app, example).await;
        let (method, path) = (&example.method, &example.path);
        assert!((200..300).contains(&status), "{method} {path} answers {status}: {body}");
    }
}
