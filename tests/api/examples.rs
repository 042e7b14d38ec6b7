//! The description is true: every example of a request is sent as it stands to a new service with the real
//! compensator, every representation of the answer is asked for, and every JSON answer fits its schema. An operation
//! that cannot be tried this way fails the test.

use std::sync::Arc;

use reqwest::multipart::{Form, Part};
use reqwest::{Method, RequestBuilder, Response};
use serde_json::{Map, Value};
use trunnion::jobs::CutterContactCompensator;

use crate::job_batches::archive;
use crate::queue::{Held, accepted, cc, ended, running, spawn_held};
use crate::receiver::Receiver;
use crate::recorded;
use crate::support::{App, description, spawn_real};
use crate::webhooks::{at_once, calling};

/// One way to send an operation's request.
#[derive(Debug)]
struct Sample<'a> {
    /// Media type of the body; none without a body.
    kind: Option<&'a str>,
    body: &'a Value,
    schema: &'a Value,
}

struct Described {
    document: Value,
}

impl Described {
    fn operation(&self, method: &str, path: &str) -> Option<&Value> {
        self.document["paths"].get(path)?.get(method)
    }

    /// Every example of the operation's request; one without a body where it takes none.
    fn samples<'a>(&'a self, name: &str, operation: &'a Value) -> Vec<Sample<'a>> {
        let Some(contents) = operation["requestBody"]["content"].as_object() else {
            return vec![Sample { kind: None, body: &Value::Null, schema: &Value::Null }];
        };
        let mut samples = Vec::new();
        for (kind, content) in contents {
            let named = content["examples"].as_object().into_iter().flat_map(|all| all.values());
            let bodies: Vec<_> =
                content.get("example").into_iter().chain(named.map(|one| &one["value"])).collect();
            assert!(!bodies.is_empty(), "{name} has no example of a request as {kind}");
            let schema = self.resolved(&content["schema"]);
            samples.extend(bodies.into_iter().map(|body| Sample { kind: Some(kind), body, schema }));
        }
        samples
    }

    fn resolved<'a>(&'a self, schema: &'a Value) -> &'a Value {
        match schema["$ref"].as_str() {
            Some(reference) => {
                self.resolved(self.document.pointer(reference.trim_start_matches('#')).unwrap())
            }
            None => schema,
        }
    }

    /// The address of the operation with everything there that it names.
    async fn address(&self, app: &App, method: &str, path: &str, operation: &Value) -> String {
        let mut address = String::new();
        for segment in path.split('/').skip(1) {
            let parameter = segment.strip_prefix('{').and_then(|rest| rest.strip_suffix('}'));
            let value = match parameter {
                None => segment.to_owned(),
                Some("id") => self.made(app, &address, path, method == "delete").await,
                Some(name) => {
                    let found = parameters(operation, "path").find(|one| one["name"] == name);
                    let example = found.map_or(&Value::Null, |one| &one["example"]);
                    assert!(!example.is_null(), "{method} {path}: no example of {name}");
                    let value = plain(example);
                    let new = method == "put" && path.ends_with("{machine_id}");
                    if name == "machine_id" && !new {
                        self.provide_machine(app, &value).await;
                    }
                    // Wear entries need no tool in the table, and to put one makes it.
                    if name == "tool_id" && operation["tags"][0] == "tools" && method != "put" {
                        self.provide_tool(app, &format!("{address}/{value}")).await;
                    }
                    value
                }
            };
            address = format!("{address}/{value}");
        }
        if let Some(tool) = address.strip_suffix("/wear-trend") {
            wear(app, tool).await;
        }
        address
    }

    /// A machine with this id: the example of the operation that makes machines, where it is not there.
    async fn provide_machine(&self, app: &App, id: &str) {
        let path = "/v1/machines/{machine_id}";
        if app.get(&format!("/v1/machines/{id}")).await.status() == 404 {
            let put = self.operation("put", path).unwrap();
            let body = self.samples("put", put).pop().unwrap().body;
            assert_eq!(app.put_machine(id, body).await.status(), 201);
        }
    }

    /// A tool at this address: the example of the operation that makes tools.
    async fn provide_tool(&self, app: &App, address: &str) {
        let put = self.operation("put", "/v1/machines/{machine_id}/tools/{tool_id}").unwrap();
        let body = self.samples("put", put).pop().unwrap().body;
        let made = app.client.put(app.url(address)).json(body).send().await.unwrap();
        assert_eq!(made.status(), 201);
    }

    /// The id of a new thing in the collection at `address`.
    async fn made(&self, app: &App, address: &str, path: &str, held: bool) -> String {
        let collection = path.split("/{id}").next().unwrap();
        let (maker, at) = match self.operation("post", collection) {
            // A job that waits for the held one, so that it can still be cancelled.
            Some(maker) if collection == "/v1/jobs" && held => (maker, address.to_owned()),
            // A job with a result.
            Some(_) if collection == "/v1/jobs" => {
                let makes = match path.rsplit('/').next() {
                    Some("residuals") => "verification",
                    Some("changes") => "compensation",
                    Some("deliveries") => return told(app).await,
                    _ => "cc-compensation",
                };
                let path = format!("/v1/machines/{{machine_id}}/{makes}");
                (self.operation("post", &path).unwrap(), path.replace("{machine_id}", "example-ac-table"))
            }
            Some(maker) => (maker, address.to_owned()),
            None => unreachable!("{path}: nothing in the description makes one"),
        };
        let sample = self.samples(collection, maker).pop().unwrap();
        let made = sent(request(app, Method::POST, &at, maker, &sample)).await;
        let status = made.status();
        let location = made.headers().get("location").map(|value| value.to_str().unwrap().to_owned());
        let text = made.text().await.unwrap();
        assert!(status.is_success(), "{at}: {status} {text}");
        location.map_or_else(
            || serde_json::from_str::<Value>(&text).unwrap()["id"].as_str().unwrap().to_owned(),
            |location| location.rsplit('/').next().unwrap().to_owned(),
        )
    }

    /// Whether a document fits a schema: types, names, and what is needed.
    fn misfit(&self, schema: &Value, value: &Value, at: &str) -> Option<String> {
        let schema = self.resolved(schema);
        for part in schema["allOf"].as_array().into_iter().flatten() {
            if let Some(misfit) = self.misfit(part, value, at) {
                return Some(misfit);
            }
        }
        for choice in ["oneOf", "anyOf"] {
            if let Some(parts) = schema[choice].as_array() {
                let misfits: Vec<_> = parts.iter().map(|part| self.misfit(part, value, at)).collect();
                if misfits.iter().all(Option::is_some) {
                    return Some(format!("{at} fits none: {misfits:?}"));
                }
            }
        }
        let kinds = match &schema["type"] {
            Value::String(one) => vec![one.as_str()],
            Value::Array(all) => all.iter().filter_map(Value::as_str).collect(),
            _ => Vec::new(),
        };
        let fits = |kind: &&str| match *kind {
            "null" => value.is_null(),
            "number" => value.is_number(),
            "integer" => value.is_i64() || value.is_u64(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "array" => value.is_array(),
            _ => value.is_object(),
        };
        if !kinds.is_empty() && !kinds.iter().any(fits) {
            return Some(format!("{at}: {value} is not {kinds:?}"));
        }
        if let Some(words) = schema["enum"].as_array()
            && !words.contains(value)
        {
            return Some(format!("{at}: {value} is not one of {words:?}"));
        }
        if let Some(members) = value.as_object() {
            for name in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
                if !members.contains_key(name) {
                    return Some(format!("{at} has no {name}"));
                }
            }
            for (name, member) in members {
                if let Some(part) = schema["properties"].get(name)
                    && let Some(misfit) = self.misfit(part, member, &format!("{at}/{name}"))
                {
                    return Some(misfit);
                }
            }
        }
        let items = value.as_array().into_iter().flatten().enumerate();
        let inner = schema.get("items")?;
        items.into_iter().find_map(|(index, item)| self.misfit(inner, item, &format!("{at}/{index}")))
    }
}

/// The answers that were recorded, and those that are.
#[derive(Debug)]
struct Recording {
    committed: Map<String, Value>,
    made: Map<String, Value>,
}

impl Recording {
    /// Takes the answer of an operation in a representation: of several requests the first.
    fn take(&mut self, operation: &Value, status: &str, kind: &str, text: &str) {
        let id = operation["operationId"].as_str().unwrap();
        let content = &operation["responses"][status]["content"][kind];
        let known = self.committed.get(id).and_then(|answers| answers.get(kind));
        // What is not recorded has an example that was written by hand: how many places there are, what time it is.
        if content.is_null() || (known.is_none() && !recorded::is_blessed()) || is_by_hand(content, known) {
            let described =
                content.is_null() || !content["example"].is_null() || content["examples"].is_object();
            assert!(described, "{id} has no example of an answer as {kind}: record it with BLESS=1");
            return;
        }
        let made = self.made.entry(id).or_insert_with(|| Value::Object(Map::new())).as_object_mut().unwrap();
        if made.contains_key(kind) {
            return;
        }
        let example = match kind {
            "application/json" => recorded::example(&serde_json::from_str(text).unwrap()),
            _ => recorded::text_example(text),
        };
        if let Some(known) = known.filter(|_| !recorded::is_blessed()) {
            let difference = recorded::difference(known, &example, "");
            assert_eq!(difference, None, "{id} as {kind} is answered otherwise: record it with BLESS=1");
        }
        made.insert(kind.to_owned(), example);
    }

    /// Writes what is new, and finds what nobody asks for.
    fn finish(&self) {
        if recorded::is_blessed() {
            recorded::write(&self.made);
            return;
        }
        let kinds = |answers: &Map<String, Value>| -> Vec<String> {
            let named = answers.iter().map(|(id, kinds)| {
                format!("{id} {:?}", kinds.as_object().unwrap().keys().collect::<Vec<_>>())
            });
            named.collect()
        };
        assert_eq!(kinds(&self.committed), kinds(&self.made));
    }
}

/// Whether the example of an answer is not a recorded one.
fn is_by_hand(content: &Value, known: Option<&Value>) -> bool {
    known.is_none() && (!content["example"].is_null() || content["examples"].is_object())
}

/// A cutter of the tool that was measured eight times.
async fn wear(app: &App, tool: &str) {
    let wear_um = [61.0, 71.0, 79.0, 89.0, 96.0, 107.0, 115.0, 124.0];
    let entries: Vec<Value> = wear_um
        .iter()
        .enumerate()
        .map(|(index, wear_um)| {
            serde_json::json!({
                "measured_at": format!("2025-03-{:02}T09:26:53Z", 3 + index), "parts_cut": 30 * (index + 1),
                "flank_wear_um": wear_um,
            })
        })
        .collect();
    let posted = app.post_json(&format!("{tool}/wear-entries"), &entries.into()).await;
    assert_eq!(posted.status(), 201);
}

/// The id of a job whose end is told to nobody who can be found.
async fn told(app: &App) -> String {
    let mut order = cc("example-ac-table");
    order["callback_url"] = "http://mes.invalid/".into();
    let place = accepted(app, &order, "g1\n").await;
    ended(app, &place).await;
    place.rsplit('/').next().unwrap().to_owned()
}

/// Media types of the answers that are no refusals; one empty one where there is no body.
fn representations(operation: &Value) -> Vec<(&str, &Value)> {
    let good = operation["responses"].as_object().unwrap().iter().find(|(status, _)| status.starts_with('2'));
    let contents = good.and_then(|(_, response)| response["content"].as_object());
    match contents {
        Some(all) => all.iter().map(|(kind, content)| (kind.as_str(), &content["schema"])).collect(),
        None => vec![("*/*", &Value::Null)],
    }
}

fn parameters<'a>(operation: &'a Value, place: &'a str) -> impl Iterator<Item = &'a Value> {
    operation["parameters"].as_array().into_iter().flatten().filter(move |parameter| parameter["in"] == place)
}

/// A value as it stands in an address.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(plain).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}

/// The request of a sample. Query parameters go with bodies that have no place for them.
fn request(app: &App, method: Method, address: &str, operation: &Value, sample: &Sample) -> RequestBuilder {
    let mut request = app.client.request(method, app.url(address));
    let elsewhere = matches!(sample.kind, Some("application/json" | "multipart/form-data"));
    for parameter in parameters(operation, "query") {
        let (name, needed) = (parameter["name"].as_str().unwrap(), parameter["required"] == true);
        assert!(!needed || !parameter["example"].is_null(), "{address}: no example of {name}");
        if !parameter["example"].is_null() && (needed || !elsewhere) {
            let value = plain(&parameter["example"]);
            // A thing that has to exist: the one in the path does.
            let made =
                address.split('/').find(|segment| segment.len() == value.len() && segment.contains('-'));
            let value = if name == "from" { made.map_or(value, str::to_owned) } else { value };
            request = request.query(&[(name, value)]);
        }
    }
    match sample.kind {
        None => request,
        Some("multipart/form-data") => {
            let mut form = Form::new();
            for (name, value) in sample.body.as_object().unwrap() {
                // The text of an example is no archive.
                if name == "programs" {
                    let programs = archive(&[("op20/blade.nc", b"G21\nM30\n")]);
                    form = form.part("programs", Part::bytes(programs).file_name("programs.zip"));
                    continue;
                }
                let is_file = sample.schema["properties"][name]["format"] == "binary";
                let part = Part::text(plain(value));
                form = form.part(name.clone(), if is_file { part.file_name("blade.nc") } else { part });
            }
            request.multipart(form)
        }
        Some("application/json") => request.json(sample.body),
        Some(kind) => request.header("content-type", kind).body(sample.body.as_str().unwrap().to_owned()),
    }
}

/// A service whose only place is taken.
async fn with_a_held_job() -> App {
    let app = spawn_held(&Arc::<Held>::default(), |_| {}).await;
    let holding = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &holding).await;
    app
}

async fn sent(request: RequestBuilder) -> Response {
    request.send().await.unwrap()
}

#[tokio::test]
async fn every_example_of_the_description_is_answered_as_described() {
    let described = Described { document: description() };
    let mut recording = Recording { committed: recorded::committed(), made: Map::new() };
    let mut tried = 0;
    for (path, item) in described.document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let name = format!("{method} {path}");
            for sample in described.samples(&name, operation) {
                for (kind, schema) in representations(operation) {
                    let mut app = if name == "delete /v1/jobs/{id}" {
                        with_a_held_job().await
                    } else {
                        spawn_real(Arc::new(CutterContactCompensator::default())).await
                    };
                    // What is about keys is tried with one.
                    if path.starts_with("/v1/keys") {
                        app.close().await;
                    }
                    let address = described.address(&app, method, path, operation).await;
                    let verb = method.to_uppercase().parse().unwrap();
                    let mut request =
                        request(&app, verb, &address, operation, &sample).header("accept", kind);
                    for header in parameters(operation, "header").filter(|one| one["required"] == true) {
                        assert_eq!(header["name"], "If-Match", "{name}: how is this header made?");
                        // Only machines and their tools are changed under a condition, machines also by what stands
                        // below them.
                        let parts = if operation["tags"][0] == "tools" { 6 } else { 4 };
                        let resource = address.split('/').take(parts).collect::<Vec<_>>().join("/");
                        let tag = app.get(&resource).await.headers()["etag"].clone();
                        request = request.header("if-match", tag);
                    }
                    let response = sent(request).await;
                    let status = response.status();
                    let headers = response.headers().clone();
                    let text = response.text().await.unwrap();
                    let said = format!("{name} with {:?} as {kind}: {status} {text}", sample.kind);
                    assert!(status.is_success(), "{said}");
                    assert!(operation["responses"].get(status.as_str()).is_some(), "{said}");
                    if kind != "*/*" {
                        let found = headers["content-type"].to_str().unwrap();
                        assert_eq!(found.split(';').next().unwrap().trim(), kind, "{said}");
                    }
                    if kind == "application/json" {
                        let answer: Value = serde_json::from_str(&text).unwrap();
                        assert_eq!(described.misfit(schema, &answer, ""), None, "{said}");
                    }
                    recording.take(operation, status.as_str(), kind, &text);
                    tried += 1;
                    app.stop().await;
                }
            }
        }
    }
    assert!(tried >= 35, "only {tried} requests");
    recording.finish();
}

#[test]
fn every_example_fits_its_schema() {
    let described = Described { document: description() };
    let mut seen = 0;
    for (path, item) in described.document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let bodies = [("request", &operation["requestBody"])];
            let answers = operation["responses"]
                .as_object()
                .unwrap()
                .iter()
                .map(|(status, one)| (status.as_str(), one));
            for (place, body) in bodies.into_iter().chain(answers) {
                for (kind, content) in body["content"].as_object().into_iter().flatten() {
                    let at = format!("{method} {path} {place} {kind}");
                    let named = content["examples"].as_object().into_iter().flat_map(|all| all.values());
                    let all: Vec<_> =
                        content.get("example").into_iter().chain(named.map(|one| &one["value"])).collect();
                    // A part of a JSON text is no document, and refusals have the example of their schema.
                    let is_apart = content["schema"].is_null() || kind == "application/problem+json";
                    assert!(!all.is_empty() || is_apart, "{at} has no example");
                    for example in all {
                        assert_eq!(described.misfit(&content["schema"], example, ""), None, "{at}");
                        seen += 1;
                    }
                }
            }
        }
    }
    assert!(seen > 100, "only {seen} examples");
}

#[tokio::test]
async fn what_is_sent_to_receivers_fits_its_description() {
    let described = Described { document: description() };
    let sent = &described.document["webhooks"]["job-ended"]["post"];
    let content = &sent["requestBody"]["content"]["application/json"];
    let schema = described.resolved(&content["schema"]);
    assert_eq!(described.misfit(schema, &content["example"], ""), None);
    let app = spawn_held(&Arc::<Held>::default(), at_once).await;
    let mut receiver = Receiver::saying(&[]).await;
    for program in ["g1\n", "REFUSE\n"] {
        accepted(&app, &calling(&receiver.url()), program).await;
        let told = receiver.next().await;
        assert_eq!(described.misfit(schema, &told.json(), ""), None, "{}", told.json());
        for header in parameters(sent, "header") {
            assert!(told.headers.contains_key(header["name"].as_str().unwrap()), "{header}");
        }
    }
}

#[test]
fn the_check_of_answers_finds_what_does_not_fit() {
    let described = Described { document: description() };
    let schema = serde_json::json!({
        "type": "object", "required": ["a"],
        "properties": {"a": {"oneOf": [{"type": "null"}, {"type": "array", "items": {"type": "integer"}}]}}
    });
    for good in ["{\"a\": null}", "{\"a\": [1, 2]}"] {
        assert_eq!(described.misfit(&schema, &serde_json::from_str(good).unwrap(), ""), None, "{good}");
    }
    for bad in ["{}", "[]", "{\"a\": 1}", "{\"a\": [1, 0.5]}"] {
        assert!(described.misfit(&schema, &serde_json::from_str(bad).unwrap(), "").is_some(), "{bad}");
    }
}
