//! API keys: every kind of key against every operation of the description, and against what belongs to the machines of
//! another; how keys are made, end and are revoked.

use reqwest::multipart::{Form, Part};
use reqwest::{Client, Method, Response, StatusCode};
use serde_json::{Value, json};

use crate::job_batches::archive;
use crate::support::{App, ac_table, description, pointers, problem, spawn, spawn_with};

/// What is open at every service.
const OPEN: &[&str] = &["/healthz", "/readyz", "/v1/version", "/problems", "/problems/{code}"];

/// Who may do what is no plain reading. An operation that is not here fails the test until somebody has said so.
const SCOPES: &[(&str, &str)] = &[
    ("get /v1/keys", "admin"),
    ("post /v1/keys", "admin"),
    ("get /v1/keys/{id}", "admin"),
    ("delete /v1/keys/{id}", "admin"),
    ("get /v1/audit", "admin"),
    ("get /v1/webhooks/secret", "admin"),
    ("post /v1/webhooks/secret/rotation", "admin"),
    ("put /v1/machines/{machine_id}", "machines"),
    ("delete /v1/machines/{machine_id}", "machines"),
    ("put /v1/machines/{machine_id}/tools/{tool_id}", "machines"),
    ("delete /v1/machines/{machine_id}/tools/{tool_id}", "machines"),
    ("post /v1/machines/{machine_id}/calibrations", "calibrations"),
    ("post /v1/machines/{machine_id}/calibrations/{id}/apply", "calibrations"),
    ("post /v1/machines/{machine_id}/tools/{tool_id}/wear-entries", "calibrations"),
    ("post /v1/machines/{machine_id}/tools/{tool_id}/wear-entries/{id}/withdraw", "calibrations"),
    ("post /v1/machines/{machine_id}/cc-compensation", "compute"),
    ("post /v1/machines/{machine_id}/compensation", "compute"),
    ("post /v1/machines/{machine_id}/forward-kinematics", "compute"),
    ("post /v1/machines/{machine_id}/inverse-kinematics", "compute"),
    ("post /v1/machines/{machine_id}/interpretation", "compute"),
    ("post /v1/machines/{machine_id}/posting", "compute"),
    ("post /v1/machines/{machine_id}/servo-simulation", "compute"),
    ("post /v1/machines/{machine_id}/verification", "compute"),
    ("post /v1/machines/{machine_id}/wear-compensation", "compute"),
    ("post /v1/jobs", "compute"),
    ("post /v1/job-batches", "compute"),
    ("delete /v1/jobs/{id}", "compute"),
    ("post /v1/jobs/{id}/deliveries", "compute"),
    ("post /v1/scallop-height", "compute"),
    ("post /v1/servo-matching", "compute"),
    ("post /v1/servo-simulations", "compute"),
    ("post /v1/servo-sweeps", "compute"),
    ("post /v1/wear-advice", "compute"),
];

const ALL: [&str; 5] = ["read", "compute", "machines", "calibrations", "admin"];
/// Those that a key may have for some machines only.
const OF_MACHINES: [&str; 4] = ["read", "compute", "machines", "calibrations"];

struct Operation {
    method: String,
    path: String,
    /// The scope it needs, by this test's own table; none where it is open.
    scope: Option<&'static str>,
    /// The same, by the description.
    described: Value,
}

fn operations() -> Vec<Operation> {
    let document = description();
    let mut all = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let name = format!("{method} {path}");
            let named = SCOPES.iter().find(|(known, _)| *known == name).map(|(_, scope)| *scope);
            let scope = match named {
                _ if OPEN.contains(&path.as_str()) => None,
                None if method == "get" => Some("read"),
                None => unreachable!("{name}: which scope does it need?"),
                named => named,
            };
            let described = operation["security"].clone();
            all.push(Operation { method: method.clone(), path: path.clone(), scope, described });
        }
    }
    assert!(all.len() >= 45 && SCOPES.len() >= 20, "only {} operations", all.len());
    all
}

impl Operation {
    /// Its address on this machine, about things that are not there.
    fn address(&self, machine: &str) -> String {
        self.path
            .replace("{machine_id}", machine)
            .replace("{id}", "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")
            .replace("{tool_id}", "T1")
            .replace("{revision}", "1")
            .replace("{code}", "busy")
    }

    fn verb(&self) -> Method {
        self.method.to_uppercase().parse().unwrap()
    }
}

/// A client that sends no key of its own.
fn stranger() -> Client {
    Client::builder().no_proxy().build().unwrap()
}

async fn ask(app: &App, verb: Method, address: &str, key: Option<&str>) -> Response {
    let request = stranger().request(verb, app.url(address));
    let request = match key {
        Some(key) => request.header("authorization", format!("Bearer {key}")),
        None => request,
    };
    request.send().await.unwrap()
}

async fn made(app: &App, body: &Value) -> Value {
    let made = app.post_json("/v1/keys", body).await;
    assert_eq!(made.status(), 201);
    made.json().await.unwrap()
}

/// The first refusal of a key that ends: the clock of the tests goes on by a second whenever it is looked at.
async fn refused_at_its_end(app: &App, key: &str) -> Response {
    let mut tries = 0;
    loop {
        let answer = ask(app, Method::GET, "/v1/machines", Some(key)).await;
        if answer.status() != 200 {
            return answer;
        }
        tries += 1;
        assert!(tries < 60, "it never ends");
    }
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap()
}

#[tokio::test]
async fn every_key_opens_what_its_scope_names_and_nothing_else() {
    let mut app = spawn().await;
    let first = app.close().await;
    let mut single = Vec::new();
    for scope in ALL {
        single.push((scope, app.new_key(&[scope], None).await));
    }
    let revoked = made(&app, &json!({"name": "was here", "scopes": ALL})).await;
    let gone = app.client.delete(app.url(&format!("/v1/keys/{}", text(&revoked["id"])))).send().await;
    assert_eq!(gone.unwrap().status(), 204);
    let unknown = format!("{}0", &first[..first.len() - 1]);
    let unknown = if unknown == first { format!("{}1", &first[..first.len() - 1]) } else { unknown };
    let now: jiff::Timestamp = text(&revoked["created_at"]).parse().unwrap();
    let end = now + jiff::SignedDuration::from_secs(30);
    let expired = made(&app, &json!({"name": "a shift", "scopes": ALL, "expires_at": end.to_string()})).await;
    let expired = text(&expired["key"]);
    refused_at_its_end(&app, expired).await;
    let revoked = text(&revoked["key"]);
    let nothing = [None, Some("nonsense"), Some(unknown.as_str()), Some(revoked), Some(expired)];
    for operation in operations() {
        let (verb, address) = (operation.verb(), operation.address("example-ac-table"));
        let name = format!("{} {}", operation.method, operation.path);
        let described = match operation.scope {
            Some(scope) => json!([{ "api_key": [scope] }]),
            None => json!([]),
        };
        assert_eq!(operation.described, described, "{name}");
        for key in nothing {
            let answer = ask(&app, verb.clone(), &address, key).await;
            if operation.scope.is_none() {
                assert_eq!(answer.status(), 200, "{name} {key:?}");
                continue;
            }
            let challenge = answer.headers()["www-authenticate"].to_str().unwrap().to_owned();
            assert!(challenge.starts_with("Bearer realm="), "{name} {challenge}");
            assert_eq!(challenge.contains("invalid_token"), key.is_some(), "{name} {challenge}");
            assert_eq!(answer.status(), 401, "{name} {key:?}");
            problem(answer, "unauthenticated").await;
        }
        for (scope, key) in &single {
            let answer = ask(&app, verb.clone(), &address, Some(key)).await;
            match operation.scope {
                Some(needed) if needed != *scope => {
                    let challenge = answer.headers()["www-authenticate"].to_str().unwrap().to_owned();
                    assert!(challenge.contains(&format!("scope=\"{needed}\"")), "{name} {challenge}");
                    assert_eq!(answer.status(), 403, "{name} {scope}");
                    let body = problem(answer, "scope-missing").await;
                    assert!(text(&body["detail"]).contains(needed), "{name} {body}");
                }
                _ => assert!(is_let_in(answer.status()), "{name} {scope}: {}", answer.status()),
            }
        }
        let answer = ask(&app, verb, &address, Some(&first)).await;
        assert!(is_let_in(answer.status()), "{name}: {}", answer.status());
    }
}

fn is_let_in(status: StatusCode) -> bool {
    status != StatusCode::UNAUTHORIZED && status != StatusCode::FORBIDDEN && !status.is_server_error()
}

#[tokio::test]
async fn what_the_description_does_not_name_is_closed_or_not_there() {
    let mut app = spawn().await;
    let first = app.close().await;
    let reader = app.new_key(&["read"], None).await;
    for path in ["/openapi.json", "/docs/", "/docs/index.html", "/docs/swagger-ui.css"] {
        assert_eq!(ask(&app, Method::GET, path, None).await.status(), 200, "{path}");
    }
    problem(ask(&app, Method::GET, "/v1/nothing", None).await, "not-found").await;
    let machine = "/v1/machines/example-ac-table";
    assert_eq!(ask(&app, Method::HEAD, machine, None).await.status(), 401);
    assert_eq!(ask(&app, Method::HEAD, machine, Some(&reader)).await.status(), 200);
    problem(ask(&app, Method::PATCH, machine, None).await, "unauthenticated").await;
    problem(ask(&app, Method::PATCH, machine, Some(&reader)).await, "scope-missing").await;
    problem(ask(&app, Method::PATCH, machine, Some(&first)).await, "method-not-allowed").await;
}

#[tokio::test]
async fn a_key_comes_in_one_header_as_bearer() {
    let mut app = spawn().await;
    let key = app.close().await;
    let ask = |values: Vec<String>| {
        let mut request = stranger().get(app.url("/v1/machines"));
        for value in values {
            request = request.header("authorization", value);
        }
        async move { request.send().await.unwrap() }
    };
    for good in [format!("Bearer {key}"), format!("bearer  {key}"), format!("BEARER {key}")] {
        assert_eq!(ask(vec![good]).await.status(), 200);
    }
    let bearer = format!("Bearer {key}");
    for bad in [
        vec![key.clone()],
        vec![format!("Basic {key}")],
        vec!["Bearer".to_owned()],
        vec!["Bearer ".to_owned()],
        vec![format!("Bearer{key}")],
        vec![format!("{bearer} {key}")],
        vec![bearer.clone(), bearer.clone()],
    ] {
        problem(ask(bad).await, "unauthenticated").await;
    }
    // Neither in the query.
    let query = stranger().get(app.url(&format!("/v1/machines?access_token={key}"))).send().await.unwrap();
    problem(query, "unauthenticated").await;
}

#[tokio::test]
async fn the_first_key_closes_the_service_and_can_make_others() {
    let app = spawn().await;
    let body = json!({"name": "a reader", "scopes": ["read"]});
    let refused = problem(app.post_json("/v1/keys", &body).await, "invalid-request").await;
    assert_eq!(pointers(&refused), ["/scopes"]);
    assert_eq!(app.get("/v1/machines").await.status(), 200);
    let made = app.post_json("/v1/keys", &json!({"name": "office", "scopes": ["admin"]})).await;
    assert_eq!(made.status(), 201);
    assert_eq!(made.headers()["cache-control"], "no-store");
    let place = made.headers()["location"].to_str().unwrap().to_owned();
    let document: Value = made.json().await.unwrap();
    let key = text(&document["key"]);
    assert_eq!(place, format!("/v1/keys/{}", text(&document["id"])));
    assert!(key.starts_with(&format!("trn_{}_", text(&document["id"]))));
    // At once, on loopback too.
    problem(app.get("/v1/machines").await, "unauthenticated").await;
    problem(app.get(&place).await, "unauthenticated").await;
    let read = ask(&app, Method::GET, &place, Some(key)).await;
    let listed: Value = read.json().await.unwrap();
    assert!(listed.get("key").is_none() && listed["machines"].is_null() && listed["revoked_at"].is_null());
    for member in ["id", "name", "scopes", "created_at", "expires_at"] {
        assert_eq!(listed[member], document[member], "{member}");
    }
    // Once the last key is revoked the service stays closed.
    assert_eq!(ask(&app, Method::DELETE, &place, Some(key)).await.status(), 204);
    problem(ask(&app, Method::GET, &place, Some(key)).await, "unauthenticated").await;
    problem(app.get("/v1/machines").await, "unauthenticated").await;
}

#[tokio::test]
async fn a_page_of_another_site_does_not_get_at_a_service_without_keys() {
    let mut app = spawn().await;
    let here = app.base.strip_prefix("http://").unwrap().to_owned();
    let send = async |app: &App, verb: Method, headers: &[(&'static str, &str)]| {
        let path = if verb == Method::GET { "/v1/machines" } else { "/v1/wear-advice" };
        let mut request = stranger().request(verb, app.url(path));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        request.send().await.unwrap()
    };
    let same = format!("http://{here}");
    let mine: [&[(&'static str, &str)]; 6] = [
        &[],
        &[("host", "localhost:8080")],
        &[("host", "[::1]")],
        &[("sec-fetch-site", "same-origin"), ("origin", "http://localhost:5173")],
        &[("sec-fetch-site", "none")],
        &[("origin", &same)],
    ];
    let foreign: [&[(&'static str, &str)]; 6] = [
        &[("host", "evil.example")],
        &[("host", "evil.example"), ("origin", "http://evil.example"), ("sec-fetch-site", "same-origin")],
        &[("sec-fetch-site", "cross-site")],
        &[("sec-fetch-site", "same-site")],
        &[("origin", "http://evil.example")],
        &[("origin", "null")],
    ];
    for headers in mine {
        assert_eq!(send(&app, Method::GET, headers).await.status(), 200, "{headers:?}");
        problem(send(&app, Method::POST, headers).await, "unsupported-media-type").await;
    }
    for headers in foreign {
        problem(send(&app, Method::POST, headers).await, "foreign-page").await;
        // What another site's page reads here it does not get to see; what is under another name it would.
        let renamed = headers[0].0 == "host";
        let read = send(&app, Method::GET, headers).await.status();
        assert_eq!(read, if renamed { 403 } else { 200 }, "{headers:?}");
    }
    // A key is sent by nobody else's page.
    let key = app.close().await;
    let post = stranger().post(app.url("/v1/wear-advice")).header("host", "mes.example").bearer_auth(&key);
    problem(post.send().await.unwrap(), "unsupported-media-type").await;
}

#[tokio::test]
async fn a_service_that_is_open_to_a_network_is_asked_by_its_name() {
    let everywhere = spawn_with(|settings| {
        (settings.listen, settings.insecure) = (([0, 0, 0, 0], 0).into(), true);
    })
    .await;
    let port = everywhere.base.rsplit_once(':').unwrap().1;
    let ask = async |host: &str| {
        let url = format!("http://127.0.0.1:{port}/v1/machines");
        stranger().get(url).header("host", host).send().await.unwrap().status()
    };
    assert_eq!(ask("machines.example").await, 200);
    assert_eq!(ask("127.0.0.1").await, 200);
}

#[tokio::test]
async fn keys_are_listed_newest_first_without_secrets_and_never_deleted() {
    let mut app = spawn().await;
    let first = app.close().await;
    let second =
        made(&app, &json!({"name": "MES", "scopes": ["compute", "read"], "machines": ["b", "a"]})).await;
    let place = format!("/v1/keys/{}", text(&second["id"]));
    let tag = app.get(&place).await.headers()["etag"].to_str().unwrap().to_owned();
    let again = || app.client.get(app.url(&place)).header("if-none-match", &tag).send();
    assert_eq!(again().await.unwrap().status(), 304);
    for _twice in 0..2 {
        let revoke = app.client.delete(app.url(&place)).send().await.unwrap();
        assert_eq!(revoke.status(), 204);
    }
    assert_eq!(again().await.unwrap().status(), 200);
    let listed = app.get("/v1/keys").await.text().await.unwrap();
    for key in [first.as_str(), text(&second["key"])] {
        assert!(!listed.contains(key.rsplit('_').next().unwrap()));
    }
    let listed: Value = serde_json::from_str(&listed).unwrap();
    assert_eq!(listed["items"].as_array().unwrap().len(), 2);
    assert_eq!(listed["items"][0]["id"], second["id"]);
    assert_eq!(listed["items"][0]["scopes"], json!(["read", "compute"]));
    assert_eq!(listed["items"][0]["machines"], json!(["a", "b"]));
    assert_eq!(text(&listed["items"][0]["revoked_at"]).len(), 24);
    assert!(listed["items"][1]["revoked_at"].is_null());
    let page: Value = app.get("/v1/keys?limit=1").await.json().await.unwrap();
    let next = format!("/v1/keys?limit=1&cursor={}", text(&page["next_cursor"]));
    let page: Value = app.get(&next).await.json().await.unwrap();
    assert_eq!(page["items"][0]["id"], listed["items"][1]["id"]);
    assert!(page["next_cursor"].is_null());
    problem(app.get("/v1/keys/nobody").await, "key-not-found").await;
    problem(app.client.delete(app.url("/v1/keys/nobody")).send().await.unwrap(), "key-not-found").await;
}

#[tokio::test]
async fn a_key_that_cannot_be_is_refused_with_everything_that_is_wrong() {
    let mut app = spawn().await;
    app.close().await;
    let wrong = json!({"name": "", "scopes": ["admin"], "machines": ["No Slug"], "expires_at": "yesterday"});
    let body = problem(app.post_json("/v1/keys", &wrong).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/name", "/machines", "/machines/0", "/expires_at"]);
    for (wrong, pointer) in [
        (json!({"name": "a", "scopes": []}), "/scopes"),
        (json!({"name": "a", "scopes": ["all"]}), "/scopes/0"),
        (json!({"name": "a", "scopes": ["read"], "machines": []}), "/machines"),
        (json!({"name": "a", "scopes": ["read"], "expires_at": "2020-01-01T00:00:00Z"}), "/expires_at"),
        (json!({"name": "a\nb", "scopes": ["read"]}), "/name"),
        (json!({"name": "a", "scopes": ["read"], "key": "mine"}), "/key"),
    ] {
        let body = problem(app.post_json("/v1/keys", &wrong).await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{wrong}");
    }
}

#[tokio::test]
async fn the_same_request_under_one_idempotency_key_makes_one_key_and_shows_its_secret_once() {
    let mut app = spawn().await;
    app.close().await;
    let post = |name: &str| {
        let body = json!({"name": name, "scopes": ["read"]});
        let request = app.client.post(app.url("/v1/keys")).header("idempotency-key", "k-1").json(&body);
        async move { request.send().await.unwrap() }
    };
    let first: Value = post("MES").await.json().await.unwrap();
    let again = post("MES").await;
    assert_eq!(again.status(), 201);
    let again: Value = again.json().await.unwrap();
    assert_eq!(again["id"], first["id"]);
    assert!(first["key"].is_string() && again["key"].is_null());
    problem(post("another").await, "idempotency-key-reused").await;
}

#[tokio::test]
async fn a_key_ends_at_its_time() {
    let mut app = spawn().await;
    app.close().await;
    let at = "2026-02-25T06:14:00.000Z";
    let key = made(&app, &json!({"name": "a shift", "scopes": ["read"], "expires_at": at})).await;
    assert_eq!(key["expires_at"], at);
    let key = text(&key["key"]);
    assert_eq!(ask(&app, Method::GET, "/v1/machines", Some(key)).await.status(), 200);
    let body = problem(refused_at_its_end(&app, key).await, "unauthenticated").await;
    assert!(text(&body["detail"]).contains(at), "{body}");
}

/// A service with the machines `mine` and `theirs`, a job on each, and a key that reaches `mine` alone.
async fn two_machines() -> (App, String, [String; 2]) {
    let mut app = spawn().await;
    app.close().await;
    let mut jobs = Vec::new();
    for machine in ["mine", "theirs"] {
        assert_eq!(app.put_machine(machine, &ac_table()).await.status(), 201);
        let path = format!("/v1/machines/{machine}/cc-compensation?tool_radius_mm=5");
        let run = app.post_text(&path, "text/plain", "g1\n").await;
        jobs.push(run.headers()["location"].to_str().unwrap().to_owned());
    }
    let key = app.new_key(&OF_MACHINES, Some(&["mine", "later"])).await;
    (app, key, jobs.try_into().unwrap())
}

/// A problem without what differs from request to request.
async fn said(answer: Response, name: &str) -> Value {
    let text = answer.text().await.unwrap();
    serde_json::from_str(&text.replace(name, "NAME")).unwrap()
}

#[tokio::test]
async fn a_key_with_a_list_of_machines_does_not_see_the_others() {
    let (app, all, [my_job, their_job]) = two_machines().await;
    does_not_see_the_others(&app, &all, &OF_MACHINES, [&my_job, &their_job]).await;
    for scope in OF_MACHINES {
        let key = app.new_key(&[scope], Some(&["mine", "later"])).await;
        does_not_see_the_others(&app, &key, &[scope], [&my_job, &their_job]).await;
    }
    // Nor is one that has the other machine let in to the first.
    let key = app.new_key(&OF_MACHINES, Some(&["theirs"])).await;
    problem(ask(&app, Method::GET, "/v1/machines/mine", Some(&key)).await, "machine-not-found").await;
    problem(ask(&app, Method::GET, &my_job, Some(&key)).await, "job-not-found").await;
    assert_eq!(ask(&app, Method::GET, &their_job, Some(&key)).await.status(), 200);
    // An address may be written in more than one way.
    problem(ask(&app, Method::GET, "/v1/machines/t%68eirs", Some(&all)).await, "machine-not-found").await;
}

/// Asks everything that names a machine or a job: what is another's and what is nowhere look the same, and what the
/// scopes do not allow is refused for that, wherever it is.
async fn does_not_see_the_others(app: &App, key: &str, scopes: &[&str], [my_job, their_job]: [&str; 2]) {
    let key = Some(key);
    let mut tried = 0;
    for operation in operations() {
        let name = format!("{} {} {scopes:?}", operation.method, operation.path);
        let missing = operation.scope.is_some_and(|needed| !scopes.contains(&needed));
        let or_missing = |code: &'static str| if missing { "scope-missing" } else { code };
        if operation.path.contains("{machine_id}") {
            let theirs = ask(app, operation.verb(), &operation.address("theirs"), key).await;
            let none = ask(app, operation.verb(), &operation.address("nowhere"), key).await;
            // Only a machine itself may be one that is still to be made.
            let makes_machines = operation.method == "put" && operation.path == "/v1/machines/{machine_id}";
            let code = if makes_machines { "machine-not-allowed" } else { "machine-not-found" };
            assert_eq!(theirs.status(), none.status(), "{name}");
            let theirs = said(theirs, "theirs").await;
            assert_eq!(theirs["type"], format!("/problems/{}", or_missing(code)), "{name}");
            assert_eq!(theirs, said(none, "nowhere").await, "{name}");
            let mine = ask(app, operation.verb(), &operation.address("mine"), key).await;
            let mine: Value = serde_json::from_str(&mine.text().await.unwrap()).unwrap_or_default();
            assert_ne!(mine["type"], format!("/problems/{code}"), "{name}: {mine}");
            assert_eq!(mine["type"] == "/problems/scope-missing", missing, "{name}: {mine}");
            tried += 1;
        }
        if operation.path.starts_with("/v1/jobs/{id}") {
            let unknown = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60";
            let id = their_job.rsplit('/').next().unwrap();
            let at = |id: &str| operation.path.replace("{id}", id);
            let theirs = said(ask(app, operation.verb(), &at(id), key).await, id).await;
            assert_eq!(theirs["type"], format!("/problems/{}", or_missing("job-not-found")), "{name}");
            assert_eq!(theirs, said(ask(app, operation.verb(), &at(unknown), key).await, unknown).await);
            if operation.method == "get" && operation.path.ends_with("{id}") && !missing {
                assert_eq!(ask(app, operation.verb(), my_job, key).await.status(), 200);
            }
            tried += 1;
        }
    }
    assert!(tried >= 30, "only {tried} operations");
}

#[tokio::test]
async fn lists_hold_what_the_key_reaches() {
    let (app, key, [my_job, _]) = two_machines().await;
    let list = |path: &'static str| {
        let (app, key) = (&app, key.as_str());
        async move {
            let list: Value = ask(app, Method::GET, path, Some(key)).await.json().await.unwrap();
            list["items"].as_array().unwrap().clone()
        }
    };
    let machines = list("/v1/machines?limit=1").await;
    assert_eq!(machines.iter().map(|one| text(&one["machine_id"])).collect::<Vec<_>>(), ["mine"]);
    let jobs = list("/v1/jobs").await;
    assert_eq!(jobs.len(), 1);
    assert_eq!(format!("/v1/jobs/{}", text(&jobs[0]["id"])), my_job);
    assert!(list("/v1/jobs?machine_id=theirs").await.is_empty());
    assert_eq!(list("/v1/jobs?machine_id=mine").await.len(), 1);
    let all: Value = app.get("/v1/machines").await.json().await.unwrap();
    assert_eq!(all["items"].as_array().unwrap().len(), 3);
    // A machine of the list that is not there yet may be made.
    let put = stranger().put(app.url("/v1/machines/later")).bearer_auth(&key).json(&ac_table());
    assert_eq!(put.send().await.unwrap().status(), 201);
    let put = stranger().put(app.url("/v1/machines/other")).bearer_auth(&key).json(&ac_table());
    problem(put.send().await.unwrap(), "machine-not-allowed").await;
    // Its tools are those of the machines that it reaches.
    let tool = json!({"number": 1, "kind": "ball", "radius_mm": 5});
    let put = async |path: &str, key: Option<&str>| {
        let request = stranger().put(app.url(path)).json(&tool);
        let request = if let Some(key) = key { request.bearer_auth(key) } else { request };
        request.send().await.unwrap()
    };
    assert_eq!(put("/v1/machines/mine/tools/T1", Some(&key)).await.status(), 201);
    problem(put("/v1/machines/theirs/tools/T1", Some(&key)).await, "machine-not-found").await;
    problem(put("/v1/machines/mine/tools/T1", None).await, "unauthenticated").await;
    assert_eq!(app.get("/v1/machines/theirs/tools").await.json::<Value>().await.unwrap()["items"], json!([]));
}

#[tokio::test]
async fn a_body_does_not_name_a_machine_out_of_reach() {
    let (app, key, _) = two_machines().await;
    let circle = json!({"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100});
    let program = json!({"kind": "program", "text": "g1\n"});
    let bodies = [
        ("/v1/servo-simulations", json!({"path": circle, "feed_mm_per_min": 1800})),
        ("/v1/servo-simulations", json!({"path": program})),
        (
            "/v1/servo-sweeps",
            json!({"path": circle, "feed_mm_per_min": [1800], "position_gain_scale": {"C": [1.0]}}),
        ),
        ("/v1/servo-matching", json!({"path": circle, "feed_mm_per_min": 1800, "target_um": [10]})),
    ];
    for operation in operations() {
        let path = operation.path.as_str();
        let by_path = path.contains("{machine_id}") || path.contains("{id}") || operation.method == "get";
        let takes_jobs = ["/v1/jobs", "/v1/job-batches"].contains(&path);
        let tried = bodies.iter().any(|(known, _)| *known == path) || takes_jobs;
        let nowhere = ["/v1/keys", "/v1/scallop-height", "/v1/wear-advice", "/v1/webhooks/secret/rotation"]
            .contains(&path);
        assert!(by_path || tried || nowhere, "{path}: can its body name a machine?");
        if takes_jobs && operation.method == "post" {
            let post = async |machine: &str| {
                let job = json!({"machine_id": machine, "operation": "cc-compensation",
                    "parameters": {"tool_radius_mm": 5, "contact": "tip"}});
                let form = Form::new().text("job", job.to_string());
                let form = if path == "/v1/jobs" {
                    form.part("program", Part::text("g1 x1\n").file_name("a.nc"))
                } else {
                    form.part("programs", Part::bytes(archive(&[("a.nc", b"g1 x1\n")])).file_name("a.zip"))
                };
                stranger().post(app.url(path)).bearer_auth(&key).multipart(form).send().await.unwrap()
            };
            let theirs = post("theirs").await;
            assert_eq!(theirs.status(), 404);
            assert_eq!(said(theirs, "theirs").await, said(post("nowhere").await, "nowhere").await);
            assert_eq!(post("mine").await.status(), 202);
        }
    }
    for (path, mut body) in bodies {
        let mut post = async |machine: &str| {
            body["machine_id"] = json!(machine);
            stranger().post(app.url(path)).bearer_auth(&key).json(&body).send().await.unwrap()
        };
        let theirs = post("theirs").await;
        assert_eq!(theirs.status(), 404, "{path}");
        assert_eq!(said(theirs, "theirs").await, said(post("nowhere").await, "nowhere").await, "{path}");
        let mine: Value = post("mine").await.json().await.unwrap();
        assert_ne!(mine["type"], "/problems/machine-not-found", "{path}");
    }
}

#[tokio::test]
async fn an_idempotency_key_is_its_callers_own() {
    let (app, mine, _) = two_machines().await;
    let other = app.new_key(&["compute"], None).await;
    let post = |key: &str| {
        let request = stranger()
            .post(app.url("/v1/machines/mine/cc-compensation?tool_radius_mm=5"))
            .header("idempotency-key", "run-1")
            .header("content-type", "text/plain")
            .bearer_auth(key)
            .body("g1 x7\n");
        async move {
            let answer = request.send().await.unwrap();
            assert_eq!(answer.status(), 200);
            answer.headers()["location"].to_str().unwrap().to_owned()
        }
    };
    let first = post(&mine).await;
    assert_eq!(post(&mine).await, first);
    let others = post(&other).await;
    assert_ne!(others, first);
    assert_eq!(post(&other).await, others);
}

#[tokio::test]
async fn the_use_of_a_key_is_noted() {
    let mut app = spawn().await;
    app.close().await;
    let used = made(&app, &json!({"name": "MES", "scopes": ["read"]})).await;
    let place = format!("/v1/keys/{}", text(&used["id"]));
    assert!(app.get(&place).await.json::<Value>().await.unwrap()["last_used_at"].is_null());
    assert_eq!(ask(&app, Method::GET, "/v1/machines", Some(text(&used["key"]))).await.status(), 200);
    // It is written down beside the request, so it may be there a little later.
    for _try in 0..1000 {
        let read: Value = app.get(&place).await.json().await.unwrap();
        if read["last_used_at"].is_string() {
            return;
        }
    }
    panic!("the use was not noted");
}
