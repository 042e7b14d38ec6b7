//! Every dependency that ends up in the binary carries a licence that lets a shop use it.

use std::process::Command;

use serde_json::Value;

/// Licences that ask for no more than a notice. An expression passes if one of its OR branches is made of these.
const ACCEPTED: &[&str] = &[
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "Unicode-3.0",
    "CC0-1.0",
    "0BSD",
    "BSL-1.0",
    "Unlicense",
    "CDLA-Permissive-2.0",
    "blessing",
];

fn accepted(expression: &str) -> bool {
    let flat = expression.replace(['(', ')'], " ").replace('/', " OR ");
    flat.split(" OR ").any(|branch| branch.split(" AND ").all(|licence| ACCEPTED.contains(&licence.trim())))
}

#[test]
fn every_dependency_has_an_accepted_licence() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--all-features", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .output()
        .expect("cargo metadata");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    assert!(packages.len() > 100);
    let refused: Vec<String> = packages
        .iter()
        .filter(|package| !package["license"].as_str().is_some_and(accepted))
        .map(|package| format!("{} {}: {}", package["name"], package["version"], package["license"]))
        .collect();
    assert!(refused.is_empty(), "{refused:#?}");
}

#[test]
fn expressions_are_read_as_they_are_meant() {
    assert!(accepted("MIT OR GPL-3.0-only"));
    assert!(accepted("(MIT OR Apache-2.0) AND Unicode-3.0") || accepted("MIT/Apache-2.0"));
    assert!(!accepted("GPL-3.0-only"));
    assert!(!accepted("MIT AND GPL-3.0-only"));
}

#[test]
fn without_scale_out_no_crate_for_postgresql_or_s3_is_built() {
    let tree = |features: &[&str]| {
        let call = Command::new(env!("CARGO"))
            .args([
                "tree",
                "--locked",
                "--edges",
                "normal",
                "--prefix",
                "none",
                "--format",
                "{p}",
                "--manifest-path",
            ])
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
            .args(features)
            .output();
        String::from_utf8(call.expect("cargo tree").stdout).expect("UTF-8")
    };
    let (without, with) = (tree(&[]), tree(&["--features", "scale-out"]));
    for name in ["sqlx-postgres", "object_store", "reqwest"] {
        assert!(!without.contains(name) && with.contains(name), "{name}");
    }
}
