//! Documents as earlier versions stored them load for ever, and are the same documents, to the byte. Each stands in
//! `tests/fixtures/documents` under its digest.

use std::fs;
use std::path::Path;

use trunnion::jobs::profile_sha256;
use trunnion::wire::MachineProfile;

use crate::support::spawn;

/// Digits of a digest in a tag.
const TAG_DIGITS: usize = 16;

#[tokio::test]
async fn a_profile_stored_by_an_earlier_version_has_the_digest_that_it_had() {
    let app = spawn().await;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/documents");
    let mut seen = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        let Some((_, digest)) = name.strip_prefix("machine-").and_then(|rest| rest.rsplit_once('-')) else {
            continue;
        };
        let text = fs::read_to_string(&path).unwrap();
        let profile: MachineProfile = serde_json::from_str(&text).unwrap();
        assert_eq!(profile_sha256(&profile), digest, "{name}");
        assert_eq!(serde_json::to_string(&profile).unwrap(), text, "{name}");
        let (normalised, _machine) = profile.into_machine().unwrap();
        assert_eq!(profile_sha256(&normalised), digest, "{name}");
        // As a client would put it back.
        let request = app.client.put(app.url(&format!("/v1/machines/m{seen}")));
        let put = request.header("content-type", "application/json").body(text).send().await.unwrap();
        assert_eq!(put.status(), 201, "{name}");
        assert_eq!(put.headers()["etag"], format!("\"r1-{}\"", &digest[..TAG_DIGITS]), "{name}");
        seen += 1;
    }
    assert!(seen >= 2, "only {seen} profiles");
}
