//! Compresses what the binary serves as it is: the description of the interface, and the files of its pages. Builds
//! again when a migration is added: the files are compiled into the binary.

use std::error::Error;
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use utoipa_swagger_ui_vendored::SWAGGER_UI_VENDORED;
use zip::ZipArchive;

/// The description, which `src/http/openapi/tests.rs` compares with the routes.
const DESCRIPTION: &str = "openapi/trunnion.json";
/// The files that the pages load. The archive has as many again, for other uses.
const PAGES: [&str; 6] = [
    "favicon-16x16.png",
    "favicon-32x32.png",
    "index.css",
    "swagger-ui-bundle.js",
    "swagger-ui-standalone-preset.js",
    "swagger-ui.css",
];

fn main() -> Result<(), Box<dyn Error>> {
    for changed in ["build.rs", "migrations", DESCRIPTION] {
        println!("cargo:rerun-if-changed={changed}");
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("cargo gives no OUT_DIR")?);
    compress(File::open(DESCRIPTION)?, &out.join("trunnion.json.gz"))?;
    let mut archive = ZipArchive::new(Cursor::new(SWAGGER_UI_VENDORED))?;
    let mut found = 0;
    for index in 0..archive.len() {
        let entry = archive.by_index(index)?;
        let path = PathBuf::from(entry.name()?.as_ref());
        // The folder above carries the version in its name.
        let is_of_pages =
            path.parent().is_some_and(|folder| folder.ends_with("dist") && folder.iter().count() == 2);
        let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|name| PAGES.contains(name))
        else {
            continue;
        };
        if is_of_pages {
            compress(entry, &out.join(format!("{name}.gz")))?;
            found += 1;
        }
    }
    if found == PAGES.len() { Ok(()) } else { Err("the archive of the pages lacks a file".into()) }
}

/// The same input gives the same bytes: no time stamp, no name.
fn compress(mut from: impl Read, to: &Path) -> io::Result<()> {
    let mut encoder = GzEncoder::new(File::create(to)?, Compression::best());
    io::copy(&mut from, &mut encoder)?;
    encoder.finish()?;
    Ok(())
}
