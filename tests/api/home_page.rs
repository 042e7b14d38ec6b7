//! The first page.

use serde_json::Value;

use crate::support::{problem, spawn};

const BROWSER: &str = "text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,*/*;q=0.8";

#[tokio::test]
async fn a_browser_gets_a_page_whose_links_lead_somewhere_and_nowhere_else() {
    let mut app = spawn().await;
    let answer = app.client.get(app.url("/")).header("accept", BROWSER).send().await.unwrap();
    assert_eq!(answer.status(), 200);
    assert_eq!(answer.headers()["content-type"], "text/html; charset=utf-8");
    assert_eq!(answer.headers()["vary"], "accept");
    let policy = answer.headers()["content-security-policy"].to_str().unwrap().to_owned();
    assert!(policy.starts_with("default-src 'none'") && !policy.contains("script-src"), "{policy}");
    let page = answer.text().await.unwrap();
    assert!(page.contains(concat!("Version ", env!("CARGO_PKG_VERSION"))), "{page}");
    assert!(page.contains("prefers-color-scheme: dark") && !page.contains("<script"), "{page}");
    assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("//"), "an outside address: {page}");
    let links: Vec<&str> =
        page.split("<a href=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
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
