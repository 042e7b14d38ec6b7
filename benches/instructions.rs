//! Instructions of every operation, counted by `valgrind --tool=callgrind`. Other work on the computer does not change
//! them. `cargo bench --bench operations -- instructions` compares them with the counts of the last release, which are in
//! `benches/instructions.txt`. `BLESS=1` writes this file again.
//!
//! Valgrind cannot count the instructions with which processors compute digests, so digests are left out.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use super::programs::write_program;
use super::{Call, Failure, Row, extension};

/// Blocks of the counted programs. The first four thousand or so are sampled in full.
const BLOCKS: u32 = 40_000;
/// Verification and the drives take much longer for each block.
const FEW_BLOCKS: u32 = 4_000;
/// A larger ratio to the instructions of the last release is a fault.
const ALLOWED: f64 = 1.05;
/// The counts of the last release, a row each.
const LAST_RELEASE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/instructions.txt");

/// Counts all rows and compares them.
pub(super) fn compare(folder: &Path, profile: &Path, rows: &[Row]) -> Result<(), Failure> {
    let last = last_release()?;
    let (mut text, mut more) = (String::new(), Vec::new());
    println!("| operation | blocks | instructions a block | last release | ratio |");
    println!("|---|---|---|---|---|");
    for row in rows.iter().filter(|row| !row.is_only_over_http()) {
        let blocks = match row.operation {
            "verification" | "servo-simulation" => FEW_BLOCKS,
            _ => BLOCKS,
        };
        let program = folder.join("program").with_extension(extension(row.form));
        write_program(&program, row.form, blocks)?;
        let part = folder.join("part.stl");
        fs::write(&part, super::wavy_plate())?;
        let counted = counted(&Call { row, program: &program, profile, part: &part }, folder)?;
        let each = counted as f64 / f64::from(blocks);
        let before = last.get(&row.name()).copied();
        let ratio = before.map(|before| each / before);
        let told = |number: Option<f64>, digits: usize| {
            number.map_or_else(|| "–".to_owned(), |number| format!("{number:.digits$}"))
        };
        println!("| {} | {blocks} | {each:.0} | {} | {} |", row.name(), told(before, 0), told(ratio, 3));
        writeln!(text, "{each:.0} {}", row.name())?;
        if ratio.is_some_and(|ratio| ratio > ALLOWED) {
            more.push(row.name());
        }
    }
    if std::env::var_os("BLESS").is_some() {
        fs::write(LAST_RELEASE, text)?;
        return Ok(());
    }
    if more.is_empty() { Ok(()) } else { Err(format!("more instructions: {}", more.join("; ")).into()) }
}

/// Instructions a block, by the name of the row.
fn last_release() -> Result<BTreeMap<String, f64>, Failure> {
    if std::env::var_os("BLESS").is_some() {
        return Ok(BTreeMap::new());
    }
    let text = fs::read_to_string(LAST_RELEASE).map_err(|fault| format!("{LAST_RELEASE}: {fault}"))?;
    let row = |line: &str| -> Result<(String, f64), Failure> {
        let (count, name) = line.split_once(' ').ok_or("a line without a name")?;
        Ok((name.to_owned(), count.parse()?))
    };
    text.lines().map(row).collect()
}

/// The instructions of one call, without those of digests.
fn counted(call: &Call<'_>, folder: &Path) -> Result<u64, Failure> {
    let file = folder.join("callgrind.out");
    let out = format!("--callgrind-out-file={}", file.display());
    let mut command = call.command(&["valgrind", "--tool=callgrind", &out]);
    // Settings of whoever counts are not those of the counts, and a name that is nearly one costs millions.
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("TRUNNION_")) {
        command.env_remove(name);
    }
    let ran = command.env("TRUNNION_MAX_COMPUTATIONS", "1").stdout(Stdio::null()).output()?;
    if !ran.status.success() {
        return Err(format!("{}: {}", call.row.name(), String::from_utf8_lossy(&ran.stderr)).into());
    }
    let annotated = Command::new("callgrind_annotate").arg("--threshold=100").arg(&file).output()?;
    let text = String::from_utf8(annotated.stdout)?;
    let count = |line: &str| line.split_whitespace().next().map(|count| count.replace(',', ""));
    let of = |wanted: &str| {
        let lines = text.lines().filter(|line| line.contains(wanted));
        lines.filter_map(count).map(|count| count.parse::<u64>()).sum::<Result<u64, _>>()
    };
    let digests = of("sha2::")?;
    if digests == 0 {
        return Err("no instructions of digests were found: the binary has no names of functions".into());
    }
    Ok(of("PROGRAM TOTALS")?.saturating_sub(digests))
}
