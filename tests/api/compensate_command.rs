//! `trunnion compensate` without a file for the machine, and what it says at its end.

use std::process::Output;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::command_line::{BLADE, Bench, path, said, trunnion};
use crate::support::ac_table;

const FLANK: &str = include_str!("../../docs/examples/flank.apt");
const DOME: &str = include_str!("../../docs/examples/dome.nc");

/// The command on a program, with these arguments after its name; the text of `out.nc` after it.
fn run(program: &str, more: &[&str]) -> (Output, Option<String>) {
    let folder = TempDir::new().unwrap();
    let (input, output) = (folder.path().join("in.nc"), folder.path().join("out.nc"));
    std::fs::write(&input, program).unwrap();
    let arguments = [&["compensate", path(&input), path(&output)][..], more].concat();
    let done = trunnion(&folder.path().join("data"), &arguments);
    (done, std::fs::read_to_string(&output).ok())
}

fn lines(done: &Output) -> Vec<String> {
    assert_eq!(done.status.code(), Some(0), "{}", said(done));
    let lines: Vec<String> = said(done).lines().map(ToOwned::to_owned).collect();
    assert_eq!(lines.len(), 3, "{lines:?}");
    lines
}

const OFFSET: [&str; 2] = ["--work-offset-mm", "12,-7,35"];

#[test]
fn a_preset_and_flags_need_no_file_and_give_the_program_of_the_parameters() {
    let flags = ["--preset", "ac-table", "--tool-radius-mm", "5", "--tolerance-um", "5"];
    let (done, program) = run(BLADE, &[&flags[..], &OFFSET].concat());
    let said = lines(&done);
    let (change, rest) = said[0].split_once(" µm, ").unwrap();
    let (before, after) = change.split_once(" → ").unwrap();
    let (before, after): (f64, f64) = (before.parse().unwrap(), after.parse().unwrap());
    assert!(before > 5.0 && after <= 5.0, "{said:?}");
    assert!(rest.contains(" blocks inserted, ") && rest.ends_with(" s"), "{said:?}");
    assert!(said[2].contains("out.nc") && said[2].contains("no warnings"), "{said:?}");
    let program = program.unwrap();
    assert!(program.contains("machine ac-table revision 0"), "{program}");
    // The same as JSON. What the parameters state already may be typed once more.
    let parameters =
        "{\"cc\": {\"tool_radius_mm\": 5, \"tolerance_um\": 5}, \"work_offset_mm\": [12, -7, 35]}";
    let (done, same) = run(BLADE, &["--preset", "ac-table", "--parameters", parameters]);
    lines(&done);
    assert_eq!(same.as_deref(), Some(program.as_str()));
    let part = ["--preset", "ac-table", "--parameters", "{\"cc\": {\"tool_radius_mm\": 5}}"];
    let (done, same) = run(BLADE, &[&part[..], &OFFSET, &flags[2..]].concat());
    lines(&done);
    assert_eq!(same.unwrap(), program);
    // Warnings of a step are said too.
    let left_alone = BLADE.replace("\nN1050 M5", "\nG92 X0\nG1 X1 Y2 Z3 A4 C5\nN1050 M5");
    let (done, _) = run(&left_alone, &[&flags[..], &OFFSET].concat());
    let last = lines(&done).remove(2);
    assert!(last.contains("; warnings: ") && last.contains("work_offset_changed"), "{last}");
    // One step without the pass.
    let alone = [&flags[..], &OFFSET, &["--operation", "cc-compensation"]].concat();
    let (done, alone) = run(BLADE, &alone);
    lines(&done);
    assert!(alone.unwrap().contains("cc-compensation steps cc"));
}

#[test]
fn every_operation_says_in_three_lines_what_came_of_it() {
    let example = ["--preset", "example-ac-table"];
    let worn = "{\"nominal_tool\": {\"radius_mm\": 5}, \"actual_tool\": {\"radius_mm\": 4.75}}";
    let one_pass =
        "{\"wear\": {\"nominal_tool\": {\"radius_mm\": 5}, \"actual_tool\": {\"radius_mm\": 4.95}},
                     \"location_errors\": true, \"cc\": {\"tolerance_um\": 5}}";
    let part = "{\"surface\": {\"kind\": \"sphere\", \"radius_mm\": 20, \"half_angle_deg\": 20},
                 \"tool\": {\"radius_mm\": 4.5}}";
    for (operation, program, parameters, parts) in [
        (
            "wear-compensation",
            BLADE,
            worn,
            ["125.0 → 0.0 µm, 100 blocks changed, ", "moved by up to 250.0 µm", "written: "],
        ),
        ("compensation", BLADE, one_pass, ["wear ", "errors before → after: interpolation ", "written: "]),
        (
            "posting",
            FLANK,
            "{}",
            [" points posted, ", "read back within ", "warnings: post_words_as_comments"],
        ),
        ("verification", DOME, part, [" samples over 30.0 µm", "most material left: ", "written: "]),
    ] {
        let more = ["--operation", operation, "--parameters", parameters];
        let (done, _) = run(program, &[&example[..], &more, &OFFSET].concat());
        let said = lines(&done);
        for (line, part) in said.iter().zip(parts) {
            assert!(line.contains(part), "{operation}: {part}: {said:?}");
        }
    }
    let folder = TempDir::new().unwrap();
    let input = folder.path().join("blade.nc");
    std::fs::write(&input, BLADE).unwrap();
    let simulated = ["compensate", path(&input), "--operation", "servo-simulation"];
    let done = trunnion(folder.path(), &[&simulated[..], &example, &OFFSET].concat());
    let said = lines(&done);
    assert!(said[0].starts_with("contour error up to "), "{said:?}");
    assert_eq!(said[2], "the program is unchanged; no warnings");
}

#[test]
fn a_program_within_tolerance_has_nothing_inserted() {
    let flags = ["--preset", "ac-table", "--tool-radius-mm", "5", "--work-offset-mm", "0,0,0"];
    let program = "G21 G1 X1.000 Y1.000 Z1.000 A0.000 C0.000 F100.\nX2.000\n";
    let (done, same) = run(program, &flags);
    assert!(lines(&done)[0].starts_with("0.0 → 0.0 µm, no block inserted, "), "{}", said(&done));
    assert_eq!(same.as_deref(), Some(program));
}

#[test]
fn the_report_on_standard_output_is_alone_there() {
    let bench = Bench::new(BLADE, &ac_table());
    let flags = ["--tool-radius-mm", "5", "--report", "-"];
    let done = bench.compensate(&[&flags[..], &OFFSET].concat());
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let report: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(report["steps"], json!(["cc"]));
    // A pipe gets no bar, only the lines.
    let lines = String::from_utf8(done.stderr).unwrap();
    assert!(lines.lines().count() == 3 && !lines.contains('\r') && !lines.contains('\u{1b}'), "{lines:?}");
    assert!(lines.contains("µm, ") && bench.at("out.nc").exists(), "{lines}");
}

#[test]
fn flags_that_do_not_fit_are_refused_with_their_names() {
    let preset = ["--preset", "ac-table"];
    for (more, code, parts) in [
        (&["--preset", "xy-table"][..], 2, ["xy-table", "ac-table"]),
        (&[], 2, ["--machine", "--preset"]),
        (&["--preset", "ac-table", "--machine", "m.json"], 2, ["--preset", "--machine"]),
        (&[&preset[..], &["--work-offset-mm", "1,2"]].concat(), 2, ["2 numbers", "12,-7,35"]),
        (&[&preset[..], &["--tool-radius-mm", "NaN"]].concat(), 2, ["NaN", "not a number"]),
        (
            &[&preset[..], &["--tolerance-um", "5", "--parameters", "{\"cc\": {\"tolerance_um\": 4}}"]]
                .concat(),
            2,
            ["--tolerance-um is 5", "tolerance_um 4"],
        ),
        (
            &[&preset[..], &["--tool-radius-mm", "5", "--operation", "posting"]].concat(),
            2,
            ["--tool-radius-mm", "posting"],
        ),
        (
            &[&preset[..], &["--location-errors", "--operation", "cc-compensation"]].concat(),
            2,
            ["--location-errors", "cc-compensation"],
        ),
        (&[&preset[..], &["--tool-radius-mm", "-5"]].concat(), 1, ["/cc/tool_radius_mm", "-5"]),
        (&preset, 1, ["tool_radius_mm", "missing"]),
    ] {
        let (done, written) = run(BLADE, more);
        assert_eq!(done.status.code(), Some(code), "{more:?}: {}", said(&done));
        for part in parts {
            assert!(said(&done).contains(part), "{more:?}: {part}: {}", said(&done));
        }
        assert_eq!(written, None, "{more:?}");
    }
}
