//! How time and memory of an operation grow with the program.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::programs::{Form, write_program};
use super::{Call, Failure, ROUNDS, Row, median};

/// Time and memory of `cc-compensation` from 10⁵ to 10⁷ blocks, as a table and as a figure.
pub(super) fn growth(folder: &Path, profile: &Path) -> Result<(), Failure> {
    let parameters = json!({"tool_radius_mm": 5, "work_offset_mm": [12, -7, 35]});
    let mut points = Vec::new();
    println!("| blocks | time, s | M blocks/s | peak memory, MiB |");
    println!("|---|---|---|---|");
    for blocks in [100_000, 300_000, 1_000_000, 3_000_000, 10_000_000] {
        let program = folder.join("program.nc");
        write_program(&program, Form::Iso, blocks)?;
        let (operation, form, parameters) = ("cc-compensation", Form::Iso, parameters.clone());
        let row = Row { operation, form, parameters, blocks, has_part: false };
        let call = Call { row: &row, program: &program, profile, part: profile };
        let (mut times_s, mut peak_mib) = (Vec::new(), 0.0_f64);
        for _ in 0..ROUNDS {
            let (took_s, peak) = call.on_the_command_line(None)?.ok_or("the command did not start")?;
            times_s.push(took_s);
            peak_mib = peak_mib.max(peak);
        }
        let took_s = median(&times_s).unwrap_or(f64::NAN);
        println!("| {blocks} | {took_s:.2} | {:.2} | {peak_mib:.0} |", f64::from(blocks) / took_s / 1e6);
        points.push([f64::from(blocks), took_s, peak_mib]);
    }
    let place: PathBuf = [env!("CARGO_MANIFEST_DIR"), "docs", "figures", "growth.svg"].iter().collect();
    fs::create_dir_all(place.parent().ok_or("no folder")?)?;
    fs::write(&place, growth_figure(&points)?)?;
    println!("figure: {}", place.display());
    Ok(())
}

/// Time (left scale) and memory (right scale) over the number of blocks, all scales logarithmic.
fn growth_figure(points: &[[f64; 3]]) -> Result<String, Failure> {
    const WIDTH: f64 = 640.0;
    const HEIGHT: f64 = 360.0;
    const MARGIN: f64 = 80.0;
    let across = |blocks: f64| MARGIN + (blocks.log10() - 5.0) / 2.0 * (WIDTH - 2.0 * MARGIN);
    let up = |share: f64| HEIGHT - MARGIN - share * (HEIGHT - 2.0 * MARGIN);
    let of_time = |seconds: f64| up((seconds.log10() + 2.0) / 3.0);
    let of_memory = |mib: f64| up(mib.log10() / 3.0);
    let line = |column: usize, scale: &dyn Fn(f64) -> f64| {
        let places =
            points.iter().map(|point| format!("{:.1},{:.1}", across(point[0]), scale(point[column])));
        places.collect::<Vec<_>>().join(" ")
    };
    let mut svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" font-family="system-ui, sans-serif" font-size="13">
<title>Time and memory of cc-compensation over the number of blocks</title>
<style>
  :root {{ color-scheme: light dark }}
  text {{ fill: #333 }} .grid {{ stroke: #ccc }} .time {{ stroke: #1f6feb; fill: #1f6feb }} .memory {{ stroke: #b35900; fill: #b35900 }}
  polyline {{ fill: none !important; stroke-width: 2 }} text.time, text.memory {{ stroke: none }}
  @media (prefers-color-scheme: dark) {{ text {{ fill: #ddd }} .grid {{ stroke: #444 }} .time {{ stroke: #6cb6ff; fill: #6cb6ff }} .memory {{ stroke: #f0a35e; fill: #f0a35e }} }}
</style>
"#
    );
    for (step, (seconds, mib)) in
        [("0.01 s", "1 MiB"), ("0.1 s", "10 MiB"), ("1 s", "100 MiB"), ("10 s", "1000 MiB")]
            .into_iter()
            .enumerate()
    {
        let y = up(step as f64 / 3.0);
        writeln!(
            svg,
            r#"<line class="grid" x1="{MARGIN}" y1="{y:.1}" x2="{:.1}" y2="{y:.1}"/>"#,
            WIDTH - MARGIN
        )?;
        writeln!(
            svg,
            r#"<text class="time" x="{:.1}" y="{:.1}" text-anchor="end">{seconds}</text>"#,
            MARGIN - 8.0,
            y + 4.0
        )?;
        writeln!(
            svg,
            r#"<text class="memory" x="{:.1}" y="{:.1}">{mib}</text>"#,
            WIDTH - MARGIN + 8.0,
            y + 4.0
        )?;
    }
    for (blocks, label) in [(1e5, "10⁵"), (1e6, "10⁶"), (1e7, "10⁷")] {
        let x = across(blocks);
        writeln!(
            svg,
            r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">{label}</text>"#,
            HEIGHT - MARGIN + 20.0
        )?;
    }
    writeln!(
        svg,
        r#"<text x="{:.1}" y="{:.1}" text-anchor="middle">blocks</text>"#,
        0.5 * WIDTH,
        HEIGHT - MARGIN + 40.0
    )?;
    writeln!(svg, r#"<text class="time" x="{MARGIN}" y="30">time</text>"#)?;
    writeln!(
        svg,
        r#"<text class="memory" x="{:.1}" y="30" text-anchor="end">peak memory</text>"#,
        WIDTH - MARGIN
    )?;
    for (class, column, scale) in [("time", 1, &of_time as &dyn Fn(f64) -> f64), ("memory", 2, &of_memory)] {
        writeln!(svg, r#"<polyline class="{class}" points="{}"/>"#, line(column, scale))?;
        for point in points {
            writeln!(
                svg,
                r#"<circle class="{class}" cx="{:.1}" cy="{:.1}" r="3"/>"#,
                across(point[0]),
                scale(point[column])
            )?;
        }
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}
