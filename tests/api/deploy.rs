//! The files under `deploy/` and the image fit the service: metrics, settings, versions, and what the image is built from.
//! `deploy/check` checks each with the tool of its kind.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use trunnion::config::{DatabaseAddress, ENVIRONMENT};

use crate::support::spawn;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap()
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    found
}

/// The words of a text that begin like this, made of letters, digits and underscores.
fn words<'a>(text: &'a str, beginning: &str) -> BTreeSet<&'a str> {
    let words = text.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_');
    words.filter(|word| word.starts_with(beginning) && word.len() > beginning.len()).collect()
}

/// Name and kind of every metric in the table of `docs/observation.md`.
fn documented(page: &str) -> BTreeMap<&str, &str> {
    let mut metrics = BTreeMap::new();
    for row in page.lines().filter(|line| line.starts_with("| `trunnion_") || line.starts_with("| `process_"))
    {
        let mut cells = row.split('|').skip(1).map(str::trim);
        let (names, kind) = (cells.next().unwrap(), cells.next().unwrap());
        metrics.extend(names.split(", ").map(|name| (name.trim_matches('`'), kind)));
    }
    metrics
}

#[tokio::test]
async fn the_docs_name_every_metric_of_the_service_and_alerts_and_dashboard_no_other() {
    let page = read("docs/observation.md");
    let documented = documented(&page);
    assert!(documented.len() > 25, "{documented:?}");
    let text = spawn().await.get("/metrics").await.text().await.unwrap();
    let printed = text.lines().filter_map(|line| line.strip_prefix("# TYPE ")?.split_once(' '));
    for (name, kind) in printed {
        assert_eq!(documented.get(name), Some(&kind), "{name} in docs/observation.md");
    }
    let is_known = |name: &str| {
        let stem = ["_bucket", "_sum", "_count"].iter().find_map(|end| name.strip_suffix(end));
        documented.contains_key(name) || stem.is_some_and(|stem| documented.get(stem) == Some(&"histogram"))
    };
    for path in
        ["deploy/prometheus/alerts.yml", "deploy/prometheus/alerts.test.yml", "deploy/grafana/trunnion.json"]
    {
        let text = read(path);
        let named: Vec<_> = words(&text, "trunnion_").into_iter().chain(words(&text, "process_")).collect();
        assert!(named.len() > 10, "{path}: {named:?}");
        for name in named {
            assert!(is_known(name), "{path} names {name}, which is not a metric of docs/observation.md");
        }
    }
}

#[test]
fn every_setting_that_the_files_name_is_one() {
    let mut seen = 0;
    for path in files(&root().join("deploy")) {
        let text = std::fs::read_to_string(&path).unwrap();
        let is_script = text.starts_with("#!");
        for name in words(&text, "TRUNNION_").into_iter().filter(|_| !is_script) {
            // Named in a comment as what Kubernetes would inject.
            let injected = name == "TRUNNION_PORT" && path.ends_with("kubernetes/trunnion.yaml");
            let is_setting = ENVIRONMENT.iter().any(|(_, variable)| *variable == name);
            assert!(is_setting || injected, "{}: {name}", path.display());
            seen += usize::from(is_setting);
        }
    }
    assert!(seen > 5, "{seen}");
}

/// The values that a text gives to a setting.
fn values<'a>(text: &'a str, setting: &str) -> Vec<&'a str> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices(setting) {
        let rest = text[at + setting.len()..].trim_start_matches([',', '\n', ' ']);
        let Some(value) = rest.strip_prefix("value: ").or_else(|| rest.strip_prefix(": ")) else { continue };
        found.push(value.split(['\n', '}']).next().unwrap().trim());
    }
    found
}

#[test]
fn several_services_have_one_database_with_their_files_and_what_they_name_is_there() {
    let manifests =
        ["trunnion.yaml", "first-key.yaml"].map(|file| read(&format!("deploy/kubernetes-several/{file}")));
    let compose = read("deploy/compose-several.yaml");
    let mut addresses = BTreeSet::new();
    for text in manifests.iter().chain([&compose]) {
        let [address] = values(text, "TRUNNION_DATABASE")[..] else { panic!("{text}") };
        assert_eq!(address.parse::<DatabaseAddress>().unwrap().fault(), None, "{address}");
        assert!(!address.contains(":trunnion@") && address.contains("//trunnion@"), "{address}");
        addresses.insert(address);
        assert_eq!(values(text, "TRUNNION_FILES"), ["postgres"]);
    }
    assert_eq!(addresses.len(), 2, "the first key is for the database of the services: {addresses:?}");
    for text in &manifests {
        let file = values(text, "TRUNNION_DATABASE_PASSWORD_FILE")[0];
        let folder = file.strip_suffix("/password").unwrap();
        let pods = text.matches("      containers:\n").count();
        for needed in [
            format!("{{name: database, mountPath: {folder}, readOnly: true}}"),
            "secret: {secretName: trunnion-database, defaultMode: 0440}".to_owned(),
            "enableServiceLinks: false".to_owned(),
            "runAsUser: 10001".to_owned(),
        ] {
            assert_eq!(text.matches(&needed).count(), pods, "{needed}");
        }
    }
    let services = &manifests[0];
    for needed in [
        "replicas: 3",
        "{maxUnavailable: 0, maxSurge: 1}",
        "kind: PodDisruptionBudget",
        "httpGet: {path: /readyz, port: http}",
        "httpGet: {path: /healthz, port: http}",
        "args: [doctor, --deep]",
    ] {
        assert!(services.contains(needed), "{needed}");
    }
    assert_eq!(values(&compose, "TRUNNION_DATABASE_PASSWORD_FILE"), ["/run/secrets/database_password"]);
    // The balancer asks every service, and no other.
    let balancer = read("deploy/haproxy/haproxy.cfg");
    let lines = |text: &str, beginning: &str| -> BTreeSet<String> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(beginning));
        lines.map(|line| line.split([' ', ':']).next().unwrap().to_owned()).collect()
    };
    let asked = lines(&balancer, "    server trunnion-");
    assert_eq!(
        asked,
        lines(
            &compose[compose.find("services:").unwrap()..compose.find("\nvolumes:").unwrap()],
            "  trunnion-"
        )
    );
    assert_eq!(asked.len(), 3);
    assert!(balancer.contains("uri /readyz"));
}

#[test]
fn the_files_name_this_version() {
    let image = concat!("trunnion:", env!("CARGO_PKG_VERSION"));
    let mut seen = 0;
    for path in files(&root().join("deploy"))
        .into_iter()
        .filter(|path| path.extension().is_some_and(|end| end.to_str().unwrap().starts_with('y')))
    {
        for line in std::fs::read_to_string(&path).unwrap().lines() {
            if let Some(named) =
                line.trim_start().strip_prefix("image: ").filter(|named| named.starts_with("trunnion"))
            {
                assert_eq!(named, image, "{}", path.display());
                seen += 1;
            }
        }
    }
    assert_eq!(seen, 7);
    let page = read("docs/operations.md");
    let named = page.split("trunnion:").skip(1).chain(page.split("trunnion-").skip(1));
    let versions: Vec<_> = named
        .filter(|rest| rest.starts_with(|first: char| first.is_ascii_digit()) && rest[1..].starts_with('.'))
        .collect();
    assert!(versions.len() > 3, "{}", versions.len());
    for rest in versions {
        assert!(rest.starts_with(env!("CARGO_PKG_VERSION")), "docs/operations.md: {}", &rest[..10]);
    }
    let version = concat!("ARG VERSION=", env!("CARGO_PKG_VERSION"));
    assert!(read("Dockerfile").lines().any(|line| line == version), "{version}");
}

/// The paths that the stages `manifests` and `build` of the image copy from the tree.
fn copied() -> Vec<PathBuf> {
    let text = read("Dockerfile");
    let stages = text.split("\nFROM ").filter(|stage| {
        stage.starts_with("manifests AS build\n") || stage.lines().next().unwrap().ends_with(" AS manifests")
    });
    let lines = stages.flat_map(str::lines).filter_map(|line| line.strip_prefix("COPY "));
    let sources = lines.flat_map(|line| {
        let mut words: Vec<_> = line.split(' ').collect();
        words.pop();
        words
    });
    sources.map(|source| root().join(source)).collect()
}

/// The paths that a text names in quotation marks and that are in the tree.
fn named_paths(text: &str, from: &Path) -> Vec<PathBuf> {
    let quoted = text.split('"').skip(1).step_by(2).filter(|name| !name.is_empty() && !name.contains('\n'));
    quoted.map(|name| from.join(name)).filter(|path| path.exists()).collect()
}

/// Everything that is compiled into the binary: the sources of each package, the files that they include, and what
/// the build script reads.
fn compiled_in() -> Vec<PathBuf> {
    let manifest = read("Cargo.toml");
    let members = manifest.lines().find(|line| line.starts_with("members = ")).unwrap();
    let mut built: Vec<_> =
        named_paths(members, root()).iter().map(|member| member.join("Cargo.toml")).collect();
    assert!(!built.is_empty());
    let packages: Vec<_> = built.iter().map(|manifest| manifest.parent().unwrap().join("src")).collect();
    let sources: Vec<_> =
        packages.iter().chain([&root().join("src")]).flat_map(|folder| files(folder)).collect();
    assert!(sources.len() > 300, "{}", sources.len());
    for path in sources.iter().filter(|path| path.extension().is_some_and(|end| end == "rs")) {
        let text = std::fs::read_to_string(path).unwrap();
        for call in ["include_str!(", "include_bytes!(", "include!("] {
            for rest in text.split(call).skip(1).filter(|rest| rest.starts_with('"')) {
                built.extend(named_paths(&rest[..rest.find(')').unwrap()], path.parent().unwrap()));
            }
        }
    }
    built.extend(named_paths(&read("build.rs"), root()));
    built.extend(["build.rs", "Cargo.toml", "Cargo.lock"].map(|path| root().join(path)));
    built.into_iter().chain(sources).map(|path| path.canonicalize().unwrap()).collect()
}

#[test]
fn the_image_is_built_from_all_that_is_compiled_in_and_from_no_docs_or_tests() {
    let copied = copied();
    let built = compiled_in();
    for read_by_the_script in ["migrations", "openapi/trunnion.json", "src/http/docs/index.html"] {
        assert!(built.contains(&root().join(read_by_the_script)), "{read_by_the_script}");
    }
    for file in built {
        assert!(copied.iter().any(|path| file.starts_with(path)), "the image lacks {}", file.display());
    }
    let allowed = read(".dockerignore");
    for path in copied {
        assert!(path.exists(), "{}", path.display());
        let name = path.strip_prefix(root()).unwrap().to_str().unwrap();
        let folder = name.split('/').next().unwrap();
        let is_let_in = |line: &str| line == format!("!{name}") || line == format!("!{folder}");
        assert!(allowed.lines().any(is_let_in), ".dockerignore keeps {name} away");
        let other = ["docs", "tests", "benches", "README.md", "CHANGELOG.md", "deploy"];
        assert!(!other.contains(&name), "a change of {name} would build the binary again");
    }
    // The stand-ins of the image are made by name.
    assert!(
        !read("Cargo.toml").lines().any(|line| line.starts_with("path = ")),
        "the stand-ins lack a target with a path"
    );
}
