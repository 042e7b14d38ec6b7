//! The page of the service, its files, and the index for every other client.

use std::collections::BTreeSet;
use std::io::Read;

use flate2::read::GzDecoder;
use serde_json::Value;

use crate::support::{App, problem, spawn};

const BROWSER: &str = "text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,*/*;q=0.8";
/// What the page may load: nothing that is not from this service, and nothing within its text.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// The addresses in a page.
fn addresses(page: &str) -> Vec<&str> {
    let quoted = ["href=\"", "src=\""];
    quoted
        .iter()
        .flat_map(|name| page.split(name).skip(1))
        .map(|rest| rest.split('"').next().unwrap())
        .collect()
}

/// What a name ends with.
fn ending(name: &str) -> &str {
    name.rsplit('.').next().unwrap()
}

async fn page(app: &App) -> String {
    app.client.get(app.url("/")).header("accept", BROWSER).send().await.unwrap().text().await.unwrap()
}

#[tokio::test]
async fn a_browser_gets_a_page_whose_links_lead_somewhere_and_nowhere_else() {
    let mut app = spawn().await;
    let answer = app.client.get(app.url("/")).header("accept", BROWSER).send().await.unwrap();
    assert_eq!(answer.status(), 200);
    assert_eq!(answer.headers()["content-type"], "text/html; charset=utf-8");
    assert_eq!(answer.headers()["vary"], "accept, accept-encoding");
    assert_eq!(answer.headers()["cache-control"], "no-store");
    assert_eq!(answer.headers()["content-security-policy"], POLICY);
    let page = answer.text().await.unwrap();
    // The policy lets neither run.
    assert!(!page.contains("<style") && !page.contains("style=") && !page.contains("<script>"), "{page}");
    assert!(!page.contains("//"), "an outside address: {page}");
    // Without scripts there are links.
    let links = addresses(&page);
    for wanted in ["/docs/", "/problems", "/metrics"] {
        assert!(links.contains(&wanted), "{wanted}: {links:?}");
    }
    for link in &links {
        assert_eq!(app.get(link).await.status(), 200, "{link}");
    }
    // It says nothing that needs a key.
    app.close().await;
    let open = reqwest::Client::builder().no_proxy().build().unwrap();
    assert_eq!(open.get(app.url("/")).header("accept", BROWSER).send().await.unwrap().status(), 200);
    let script = links.iter().find(|link| ending(link) == "js").unwrap();
    assert_eq!(open.get(app.url(script)).send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn the_files_of_the_page_are_served_by_their_kind_and_kept_by_their_digest() {
    let app = spawn().await;
    let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/page/dist")).unwrap();
    let names: BTreeSet<String> =
        folder.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.len() > 5 && names.contains("index.html") && names.contains("LICENSES.txt"), "{names:?}");
    let mut compressed = 0;
    for name in &names {
        let kept = std::fs::read(format!("{}/page/dist/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let path = format!("/page/{name}");
        let answer = app.get(&path).await;
        assert_eq!(answer.status(), 200, "{name}");
        let headers = answer.headers();
        let kind = match ending(name) {
            "html" => "text/html; charset=utf-8",
            "js" => "text/javascript; charset=utf-8",
            "css" => "text/css; charset=utf-8",
            "svg" => "image/svg+xml",
            _ => "text/plain; charset=utf-8",
        };
        assert_eq!(headers["content-type"], kind, "{name}");
        assert_eq!(headers["content-security-policy"], POLICY, "{name}");
        let cached = if name.contains('-') { "public, max-age=31536000, immutable" } else { "no-store" };
        assert_eq!(headers["cache-control"], cached, "{name}");
        assert_eq!(answer.bytes().await.unwrap(), kept, "{name}");
        let packed = app.client.get(app.url(&path)).header("accept-encoding", "gzip").send().await.unwrap();
        assert_eq!(packed.headers()["content-encoding"], "gzip", "{name}");
        let packed = packed.bytes().await.unwrap();
        compressed += packed.len();
        let mut plain = Vec::new();
        GzDecoder::new(&*packed).read_to_end(&mut plain).unwrap();
        assert_eq!(plain, kept, "{name}");
    }
    assert!(compressed < 300_000, "the page is {compressed} bytes");
    problem(app.get("/page/nothing.js").await, "not-found").await;
    problem(app.get("/page/..%2fCargo.toml").await, "not-found").await;
}

#[tokio::test]
async fn the_page_names_no_address_of_others_and_the_licences_of_all_that_is_in_it() {
    let app = spawn().await;
    let page = page(&app).await;
    let licences = app.get("/page/LICENSES.txt").await.text().await.unwrap();
    for library in ["preact", "@preact/signals", "three", "uplot"] {
        assert!(licences.contains(&format!("\n{library} ")), "{library}");
    }
    assert!(licences.matches("Permission is hereby granted").count() >= 5, "{licences}");
    for file in addresses(&page).iter().filter(|link| ["js", "css"].contains(&ending(link))) {
        let text = app.get(file).await.text().await.unwrap();
        assert!(!text.contains("sourceMappingURL"), "{file}");
    }
}

#[tokio::test]
async fn every_other_client_gets_an_index() {
    let app = spawn().await;
    for accept in [None, Some("*/*"), Some("application/json")] {
        let request = app.client.get(app.url("/"));
        let request = match accept {
            Some(accept) => request.header("accept", accept),
            None => request,
        };
        let answer = request.send().await.unwrap();
        assert_eq!(answer.headers()["content-type"], "application/json", "{accept:?}");
        let policy = answer.headers()["content-security-policy"].to_str().unwrap();
        assert!(!policy.contains("script-src"), "{policy}");
        let index: Value = answer.json().await.unwrap();
        assert_eq!(
            (&index["name"], &index["version"]),
            (&"trunnion".into(), &env!("CARGO_PKG_VERSION").into())
        );
        for name in ["documentation", "description", "problems", "metrics", "health", "readiness"] {
            assert_eq!(app.get(index[name].as_str().unwrap()).await.status(), 200, "{name}");
        }
    }
    let answer = app.client.get(app.url("/")).header("accept", "image/png").send().await.unwrap();
    problem(answer, "not-acceptable").await;
    problem(app.client.post(app.url("/")).send().await.unwrap(), "method-not-allowed").await;
}
