//! Holds the arrows of the house: every path under `src/` is checked against the layers, the core names nothing
//! that is not pure, files stay short, nothing unwraps.
//!
//! `rooms` holds the arrows one level deeper, `circles` finds files that name each other in a circle.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

mod circles;
mod names;
mod rooms;
mod source;
mod tree;

use std::collections::BTreeMap;

use source::sources;

/// A module and the modules it may name, besides what those name in turn.
const ARROWS: &[(&str, &[&str])] = &[
    ("units", &[]),
    ("geometry", &["units"]),
    ("machine", &["geometry"]),
    ("kinematics", &["machine"]),
    ("listed", &[]),
    ("program", &["geometry", "listed"]),
    ("surface", &["geometry"]),
    ("motion", &["program", "kinematics"]),
    ("contact", &["motion", "surface"]),
    ("side_by_side", &[]),
    ("wear", &["contact", "side_by_side"]),
    ("servo", &["motion"]),
    ("calibration", &["kinematics"]),
    ("process", &["wear", "servo", "contact"]),
    ("plot", &["process"]),
    ("description", &[]),
    ("wire", &["plot", "kinematics", "calibration", "description"]),
    ("config", &[]),
    ("meter", &[]),
    ("shares", &[]),
    ("store", &["wire", "config", "meter", "shares"]),
    ("jobs", &["store"]),
    ("http", &["jobs"]),
    ("cli", &["http"]),
    ("main", &["cli"]),
];

/// The modules that are the core.
const CORE: &[&str] = &[
    "units",
    "geometry",
    "machine",
    "kinematics",
    "listed",
    "program",
    "surface",
    "motion",
    "contact",
    "side_by_side",
    "wear",
    "servo",
    "calibration",
    "process",
    "plot",
];

/// What the core does not name: outside crates, and the standard library's clock, environment, files and threads.
const NOT_IN_CORE: &[&str] = &[
    "axum",
    "utoipa",
    "serde",
    "serde_json",
    "sqlx",
    "tokio",
    "tracing",
    "http",
    "hyper_util",
    "toml",
    "clap",
    "metrics",
    "jiff",
    "uuid",
    "rand",
    "std::time::SystemTime",
    "std::time::Instant",
    "std::env",
    "std::fs",
    "std::thread",
    "std::net",
    "std::process",
];

/// Longest file [lines].
const MAX_LINES: usize = 600;

fn allowed() -> BTreeMap<&'static str, Vec<&'static str>> {
    let mut allowed: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (module, named) in ARROWS {
        let mut all = vec![*module];
        for name in *named {
            all.push(name);
            all.extend(allowed.get(name).into_iter().flatten());
        }
        allowed.insert(module, all);
    }
    allowed
}

/// The first parts of the paths that begin with `crate::` (or the crate's name) on a line.
fn named_modules(line: &str) -> Vec<String> {
    let mut found = Vec::new();
    for prefix in ["crate::", "trunnion::", "trunnion_core::"] {
        for (at, _) in line.match_indices(prefix) {
            let before = line[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '$') {
                continue;
            }
            let rest = &line[at + prefix.len()..];
            if let Some(group) = rest.strip_prefix('{') {
                let mut depth = 0;
                for part in group.split(',') {
                    if depth == 0 {
                        found.push(word(part.trim()));
                    }
                    depth += part.matches('{').count();
                    depth -= part.matches('}').count().min(depth);
                }
            } else {
                found.push(word(rest));
            }
        }
    }
    found
}

fn word(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[test]
fn every_module_names_only_what_its_arrows_allow() {
    let allowed = allowed();
    let mut faults = Vec::new();
    let mut seen = 0;
    for source in sources() {
        if source.module == "lib" {
            continue;
        }
        let Some(may) = allowed.get(source.module.as_str()) else {
            faults.push(format!("{}: module {} has no arrow", source.path.display(), source.module));
            continue;
        };
        for (index, line) in source.code.iter().enumerate() {
            for named in named_modules(line) {
                seen += 1;
                // Only names of top-level modules count: a macro or a re-export is no module.
                if allowed.contains_key(named.as_str()) && !may.contains(&named.as_str()) {
                    let (path, at) = (source.path.display(), index + 1);
                    faults.push(format!("{path}:{at}: {} names {named}", source.module));
                }
            }
        }
    }
    assert!(seen > 100, "only {seen} paths were seen");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_core_is_pure() {
    let mut faults = Vec::new();
    for source in sources().iter().filter(|source| CORE.contains(&source.module.as_str())) {
        for (index, line) in source.code.iter().enumerate() {
            for name in NOT_IN_CORE {
                for (at, _) in line.match_indices(name) {
                    let before = line[..at].chars().next_back();
                    let after = &line[at + name.len()..];
                    let whole = !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':');
                    let path = after.starts_with("::")
                        || name.contains("::")
                        || line.trim() == format!("use {name};");
                    if whole && path {
                        faults.push(format!(
                            "{}:{}: the core names {name}",
                            source.path.display(),
                            index + 1
                        ));
                    }
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Functions whose last bit is the platform's; `geometry::trig` and `constants::arithmetic` have the same ones of our
/// own.
const OF_THE_PLATFORM: [&str; 12] = [
    ".ln()",
    ".exp()",
    ".powf(",
    ".sin()",
    ".cos()",
    ".tan()",
    ".sin_cos()",
    ".atan2(",
    ".asin()",
    ".acos()",
    ".atan()",
    ".hypot(",
];

#[test]
fn programs_and_poses_have_the_same_bits_everywhere() {
    let modules = ["program", "motion", "process", "contact", "kinematics", "machine"];
    for source in sources().iter().filter(|source| modules.contains(&source.module.as_str())) {
        for (number, line) in source.code.iter().enumerate() {
            let found = OF_THE_PLATFORM.iter().find(|call| line.contains(**call));
            assert_eq!(found, None, "{}:{}", source.path.display(), number + 1);
        }
    }
}

#[test]
fn only_the_store_names_the_database_and_only_http_the_web() {
    let mut faults = Vec::new();
    for source in sources() {
        for (index, line) in source.code.iter().enumerate() {
            let at = || format!("{}:{}", source.path.display(), index + 1);
            if line.contains("sqlx::") && source.module != "store" {
                faults.push(format!("{}: sqlx outside store", at()));
            }
            if line.contains("axum::") && source.module != "http" {
                faults.push(format!("{}: axum outside http", at()));
            }
            if line.contains("axum::Json") {
                faults.push(format!(
                    "{}: axum::Json answers text on a bad body; use http::extract::Json",
                    at()
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn no_file_is_longer_than_its_stop() {
    let long: Vec<_> = sources()
        .iter()
        .filter(|source| source.lines > MAX_LINES)
        .map(|source| format!("{}: {} lines", source.path.display(), source.lines))
        .collect();
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn nothing_unwraps() {
    let mut faults = Vec::new();
    for source in sources() {
        for (index, line) in source.code.iter().enumerate() {
            for banned in [".unwrap()", ".expect(", "panic!(", "unreachable!(", "todo!(", "unimplemented!("] {
                if line.contains(banned) {
                    faults.push(format!("{}:{}: {banned}", source.path.display(), index + 1));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_checker_sees_what_it_must() {
    assert_eq!(
        named_modules("use crate::{http::Problem, wire::{Pose, Fault}, store};"),
        ["http", "wire", "store"]
    );
    assert_eq!(named_modules("let x = crate::store::sha256_hex(b);"), ["store"]);
}
