//! Puts files into the binary. What it serves as it is (the description of the interface, the files of its pages, the
//! page) is compressed. The migrations of the database are lists of names and texts.

use std::error::Error;
use std::fmt::Write;
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use utoipa_swagger_ui_vendored::SWAGGER_UI_VENDORED;
use zip::ZipArchive;

/// The description, which `src/http/openapi/tests.rs` compares with the routes.
const DESCRIPTION: &str = "openapi/trunnion.json";
/// The files that `/docs` loads. The archive has as many again, for other uses.
const DOCS: [&str; 6] = [
    "favicon-16x16.png",
    "favicon-32x32.png",
    "index.css",
    "swagger-ui-bundle.js",
    "swagger-ui-standalone-preset.js",
    "swagger-ui.css",
];

/// The page as `page/build.mjs` made it. It is committed, so that a build needs no Node.
const PAGE: &str = "page/dist";

/// The folders of migrations, one for each database.
const MIGRATIONS: [&str; 2] = ["migrations", "migrations-postgres"];

fn main() -> Result<(), Box<dyn Error>> {
    for changed in ["build.rs", DESCRIPTION, PAGE].into_iter().chain(MIGRATIONS) {
        println!("cargo:rerun-if-changed={changed}");
    }
    // Set by `.ci/statements` alone.
    println!("cargo:rustc-check-cfg=cfg(check_sqlite, check_postgres)");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("cargo gives no OUT_DIR")?);
    compress(File::open(DESCRIPTION)?, &out.join("trunnion.json.gz"))?;
    embed_page(&out)?;
    for folder in MIGRATIONS {
        embed_migrations(folder, &out)?;
    }
    let mut archive = ZipArchive::new(Cursor::new(SWAGGER_UI_VENDORED))?;
    let mut found = 0;
    for index in 0..archive.len() {
        let entry = archive.by_index(index)?;
        let path = PathBuf::from(entry.name()?.as_ref());
        // The folder above carries the version in its name.
        let is_of_pages =
            path.parent().is_some_and(|folder| folder.ends_with("dist") && folder.iter().count() == 2);
        let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|name| DOCS.contains(name))
        else {
            continue;
        };
        if is_of_pages {
            compress(entry, &out.join(format!("{name}.gz")))?;
            found += 1;
        }
    }
    if found == DOCS.len() { Ok(()) } else { Err("the archive of the pages lacks a file".into()) }
}

/// Writes the list of the migrations in a folder, in their order, for `src/store/migrations.rs`.
fn embed_migrations(folder: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    let mut files = std::fs::read_dir(folder)?
        .map(|entry| Ok(std::path::absolute(entry?.path())?))
        .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    files.sort();
    let mut list = "&[\n".to_owned();
    for file in files {
        let name = file.file_stem().and_then(|name| name.to_str()).ok_or("a migration has no name")?;
        let path = file.to_str().ok_or("the path of a migration is no text")?;
        writeln!(list, "    ({name:?}, include_str!({path:?})),")?;
    }
    list.push_str("]\n");
    std::fs::write(out.join(format!("{folder}.rs")), list)?;
    Ok(())
}

/// Compresses the files of the page, and writes the table that names them for `src/http/page.rs`.
fn embed_page(out: &Path) -> Result<(), Box<dyn Error>> {
    let mut names = std::fs::read_dir(PAGE)?
        .map(|entry| entry?.file_name().into_string().map_err(|name| format!("{}", name.display()).into()))
        .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    names.sort();
    let mut table = format!("static FILES: [(&str, Embedded); {}] = [\n", names.len());
    for name in names {
        let kind = match name.rsplit('.').next() {
            Some("html") => "text/html; charset=utf-8",
            Some("js") => "text/javascript; charset=utf-8",
            Some("css") => "text/css; charset=utf-8",
            Some("svg") => "image/svg+xml",
            Some("txt") => "text/plain; charset=utf-8",
            _ => return Err(format!("{PAGE}/{name} has no known media type").into()),
        };
        let compressed = format!("page-{name}.gz");
        compress(File::open(Path::new(PAGE).join(&name))?, &out.join(&compressed))?;
        writeln!(
            table,
            "    ({name:?}, Embedded::new({kind:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{compressed}\")))),"
        )?;
    }
    table.push_str("];\n");
    std::fs::write(out.join("page_files.rs"), table)?;
    Ok(())
}

/// The same input gives the same bytes: no time stamp, no name.
fn compress(mut from: impl Read, to: &Path) -> io::Result<()> {
    let mut encoder = GzEncoder::new(File::create(to)?, Compression::best());
    io::copy(&mut from, &mut encoder)?;
    encoder.finish()?;
    Ok(())
}
