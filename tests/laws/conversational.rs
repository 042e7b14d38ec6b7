//! Laws of Heidenhain conversational programs and of cutter location data: tool-centre-point programs in these dialects
//! keep the tolerance, seen by the witness, and what is not divided stays byte for byte.

#![expect(clippy::print_stdout, reason = "it tells what it measured")]

use std::fmt::Write;
use std::ops::ControlFlow;

use nalgebra::Vector3;
use trunnion::process::{
    CcParameters, CcReport, ContactSource, WearParameters, WornCutter, compensate, compensate_wear,
};
use trunnion::program::Dialect;
use trunnion::units::Length;

use crate::compensation::{parameters, run, witness};
use crate::models::finishing::{Finishing, ac_machine, blade, impeller_flank, tool};
use crate::models::set_ups::{at_zero, in_mm};
use crate::models::witness::{Verdict, scan};
use crate::tool_vectors::with_angles;

/// The witness' sums and ours differ by rounding only, and by the ninth decimal of its angles [mm].
const ARITHMETIC_MM: f64 = 1e-6;
/// F words have no decimals, or one: 1200 is off by less than this.
const TIME_SHARE: f64 = 0.005;

/// A point as the program writes it, and as the witness needs it.
struct Written {
    tip: [String; 3],
    angles: [String; 2],
    axis: [String; 3],
    normal: [String; 3],
    first_of_pass: bool,
}

fn written(part: &Finishing) -> Vec<Written> {
    let tables = witness(part, true);
    part.points
        .iter()
        .map(|point| {
            let angles = point.rotary_deg.map(|word| format!("{word:+.4}"));
            let numbers = angles.each_ref().map(|word| word.parse().expect("a number"));
            let axis = tables.forward(Vector3::zeros(), numbers).1;
            Written {
                tip: [0, 1, 2].map(|k| format!("{:+.4}", point.pose.tip_mm[k])),
                angles,
                axis: [0, 1, 2].map(|k| format!("{:.8}", axis[k])),
                normal: [0, 1, 2].map(|k| format!("{:+.7}", point.normal[k])),
                first_of_pass: point.first_of_pass,
            }
        })
        .collect()
}

fn vector(words: &[String; 3]) -> Vector3<f64> {
    Vector3::from_iterator(words.iter().map(|word| word.parse().expect("a number")))
}

/// U V W of the contact that normal and tool axis put at this tip, for the witness.
fn contact(part: &Finishing, point: &Written, axis: Vector3<f64>) -> String {
    let (corner, core) = (part.tool.corner_radius().mm(), part.tool.core_radius().mm());
    let (n, t) = (vector(&point.normal).normalize(), axis.normalize());
    let across = n - t * n.dot(&t);
    let m = if core > 0.0 { across.normalize() } else { Vector3::zeros() };
    let c = vector(&point.tip) + t * corner - n * corner - m * core;
    format!("U{:.10} V{:.10} W{:.10}", c.x, c.y, c.z)
}

/// With rotary words, or with the tool axis as a vector; and the same for the witness.
pub(crate) fn heidenhain(part: &Finishing, vectors: bool) -> (String, String) {
    let (mut text, mut source) = ("0 BEGIN PGM PART MM\n1 L M128\n".to_owned(), String::new());
    let tables = witness(part, true);
    for (k, point) in written(part).iter().enumerate() {
        let [x, y, z] = &point.tip;
        let [a, c] = &point.angles;
        let [nx, ny, nz] = &point.normal;
        let (number, place) = (10 * k + 10, format!("X{x} Y{y} Z{z}"));
        let [i, j, k_axis] = &point.axis;
        let normal = format!("NX{nx} NY{ny} NZ{nz}");
        let turn = if vectors { format!("TX{i} TY{j} TZ{k_axis}") } else { format!("A{a} C{c}") };
        let feed = if point.first_of_pass { "R0 FMAX" } else { "F1200" };
        writeln!(text, "{number} LN {place} {normal} {turn} {feed}").expect("text");
        let angles = point.angles.each_ref().map(|word| word.parse().expect("a number"));
        let forward = tables.forward(Vector3::zeros(), angles).1;
        let contact = contact(part, point, if vectors { vector(&point.axis) } else { forward });
        let code = if point.first_of_pass { "G0" } else { "G94 G1" };
        let turn = turn.replace("TX", "I").replace("TY", "J").replace("TZ", "K");
        writeln!(source, "{code} {place} {turn} {contact} F1200").expect("text");
    }
    text.push_str("99999 L M129\nEND PGM PART MM\n");
    (text, if vectors { with_angles(&source) } else { source })
}

/// A conversational program as the witness reads it.
fn from_heidenhain(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines().filter(|line| line.contains(" X")) {
        let code = if line.contains("FMAX") { "G0" } else { "G94 G1" };
        let words: Vec<String> = line
            .split(' ')
            .map(|word| word.replace("TX", "I").replace("TY", "J").replace("TZ", "K"))
            .filter(|word| word.starts_with(['X', 'Y', 'Z', 'A', 'C', 'F', 'I', 'J', 'K']) && word != "FMAX")
            .collect();
        writeln!(out, "{code} {}", words.join(" ")).expect("text");
    }
    if text.contains(" TX") { with_angles(&out) } else { out }
}

pub(crate) fn apt(part: &Finishing) -> (String, String) {
    let (mut text, mut source) =
        ("PARTNO/PART\nUNITS/MM\nMULTAX/ON\nFEDRAT/1200.,MMPM\n".to_owned(), String::new());
    for point in written(part) {
        let plain =
            |words: &[String; 3]| words.each_ref().map(|word| word.trim_start_matches('+').to_owned());
        let [x, y, z] = plain(&point.tip);
        let [i, j, k] = plain(&point.axis);
        let [nx, ny, nz] = plain(&point.normal);
        if point.first_of_pass {
            text.push_str("RAPID\n");
        }
        writeln!(text, "GOTO/{x},{y},{z},{i},{j},{k},{nx},{ny},{nz}").expect("text");
        let contact = contact(part, &point, vector(&point.axis));
        let code = if point.first_of_pass { "G0" } else { "G94 G1" };
        writeln!(source, "{code} X{x} Y{y} Z{z} I{i} J{j} K{k} {contact} F1200").expect("text");
    }
    text.push_str("FINI\n");
    (text, with_angles(&source))
}

/// Cutter location data as the witness reads it.
fn from_apt(text: &str) -> String {
    let (mut out, mut feed, mut rapid) = (String::new(), String::new(), false);
    for line in text.lines() {
        if let Some(words) = line.strip_prefix("FEDRAT/") {
            words.split(',').next().unwrap_or_default().clone_into(&mut feed);
        } else if line.starts_with("RAPID") {
            rapid = true;
        } else if let Some(values) = line.strip_prefix("GOTO/") {
            let code = if std::mem::take(&mut rapid) { "G0" } else { "G94 G1" };
            let words: Vec<String> = values
                .split(',')
                .zip("XYZIJK".chars())
                .map(|(value, letter)| format!("{letter}{value}"))
                .collect();
            writeln!(out, "{code} {} F{feed}", words.join(" ")).expect("text");
        }
    }
    with_angles(&out)
}

fn judge(
    part: &Finishing,
    tolerance_um: f64,
    text: &str,
    source: &str,
    back: fn(&str) -> String,
) -> (String, CcReport, Vec<Verdict>) {
    let parameters = CcParameters { tolerance: Length::from_um(tolerance_um), ..parameters(part) };
    let (output, report) = run(part, &parameters, text).expect("compensated");
    assert_eq!(report.contact, ContactSource::Normals);
    let verdicts = witness(part, true).judge(source, &back(&output), 200);
    let over = verdicts.iter().filter(|verdict| verdict.before > tolerance_um / 1000.0).count() as u64;
    println!(
        "{} {:?} {tolerance_um} µm: {} checked, {over} over, {} -> {} blocks",
        part.name, report.dialect, report.motions_checked, report.blocks_in, report.blocks_out
    );
    assert_eq!(report.motions_over_tolerance, over);
    assert!(over > 0 || tolerance_um > 1.0, "nothing to do");
    assert_eq!(report.motions_checked, verdicts.len() as u64);
    for verdict in &verdicts {
        assert!(verdict.after <= tolerance_um / 1000.0 + ARITHMETIC_MM, "line {}", verdict.line);
        assert!(verdict.parts == 1 || verdict.before > tolerance_um / 1000.0 - ARITHMETIC_MM);
        assert!(
            (verdict.time_ratio - 1.0).abs() < TIME_SHARE,
            "line {}: {}",
            verdict.line,
            verdict.time_ratio
        );
    }
    // Every line of the source that was not divided is there as it was.
    let mut lines = output.lines();
    let kept = text.lines().filter(|line| lines.clone().any(|written| written == *line)).count() as u64;
    let total = text.lines().count() as u64;
    assert!(lines.next().is_some() && total - kept <= over, "{kept} of {total}");
    (output, report, verdicts)
}

fn parts() -> [Finishing; 2] {
    [blade(ac_machine(), tool(5.0, 5.0), 25, 3), impeller_flank(ac_machine(), tool(6.0, 1.5), 30, 3)]
}

#[test]
fn conversational_programs_keep_the_tolerance_seen_by_the_witness() {
    for part in parts() {
        let (text, source) = heidenhain(&part, false);
        for tolerance_um in [2.0, 0.5] {
            let (output, report, _) = judge(&part, tolerance_um, &text, &source, from_heidenhain);
            assert_eq!(report.dialect, Dialect::Heidenhain);
            for line in output.lines().filter(|line| line.contains(" X")) {
                let (number, statement) = line.split_once(' ').expect("two words");
                assert!(number.parse::<u32>().is_ok() && statement.starts_with("LN X"), "{line}");
                let mut coordinates =
                    statement.split(' ').filter(|word| word.starts_with(['X', 'Y', 'Z', 'A', 'C']));
                assert!(coordinates.all(|word| word[1..].starts_with(['+', '-'])), "{line}");
            }
        }
    }
}

#[test]
fn conversational_programs_with_vectors_keep_the_tolerance_and_stay_vectors() {
    for part in parts() {
        let (text, source) = heidenhain(&part, true);
        for tolerance_um in [2.0, 0.5] {
            let (output, report, _) = judge(&part, tolerance_um, &text, &source, from_heidenhain);
            assert_eq!(report.dialect, Dialect::Heidenhain);
            for line in output.lines().filter(|line| line.contains(" X")) {
                assert!(!line.contains(" A") && !line.contains(" C"), "{line}");
                let k = line.split(' ').find_map(|word| word.strip_prefix("TZ"));
                let digits = k.and_then(|k| Some(k.split_once('.')?.1.len()));
                assert_eq!(digits, Some(8), "{line}");
            }
        }
        let parameters = CcParameters { tolerance: Length::from_mm(1.0), ..parameters(&part) };
        assert_eq!(run(&part, &parameters, &text).expect("compensated").0, text);
    }
}

#[test]
fn cutter_location_data_keeps_the_tolerance_seen_by_the_witness() {
    for part in parts() {
        let (text, source) = apt(&part);
        for tolerance_um in [2.0, 0.5] {
            let (output, report, _) = judge(&part, tolerance_um, &text, &source, from_apt);
            assert_eq!(report.dialect, Dialect::Apt);
            for line in output.lines() {
                let is_point =
                    line.strip_prefix("GOTO/").is_some_and(|values| values.split(',').count() == 9);
                let is_feed = line.starts_with("FEDRAT/") && line.ends_with(",MMPM");
                assert!(is_point || is_feed || text.lines().any(|own| own == line), "{line}");
            }
        }
    }
}

#[test]
fn within_tolerance_both_come_back_byte_for_byte() {
    for part in parts() {
        for text in [
            heidenhain(&part, false).0,
            apt(&part).0,
            heidenhain(&part, false).0.replace('\n', "\r\n").replace('.', ","),
        ] {
            let parameters = CcParameters { tolerance: Length::from_mm(1.0), ..parameters(&part) };
            let (output, report) = run(&part, &parameters, &text).expect("compensated");
            assert!(report.motions_checked > 60 && output == text, "{}", report.motions_checked);
        }
    }
}

#[test]
fn programs_with_decimal_commas_get_decimal_commas() {
    for part in parts() {
        let text = heidenhain(&part, false).0;
        let parameters = CcParameters { tolerance: Length::from_um(0.5), ..parameters(&part) };
        let (output, _) = run(&part, &parameters, &text).expect("compensated");
        let (with_commas, _) = run(&part, &parameters, &text.replace('.', ",")).expect("compensated");
        assert!(output != text && with_commas == output.replace('.', ","));
    }
}

/// Half the last of four decimals in each of three words [mm].
const ROUNDING_MM: f64 = 0.000_05 * 1.732_051 + 1e-6;

#[test]
fn tips_of_both_move_for_a_worn_cutter_as_its_shape_says() {
    let worn = tool(5.8, 1.4);
    for part in parts() {
        let (corner, core) = (part.tool.corner_radius().mm(), part.tool.core_radius().mm());
        for (text, back) in
            [(heidenhain(&part, false).0, from_heidenhain as fn(&str) -> String), (apt(&part).0, from_apt)]
        {
            let run = |cutter| {
                let parameters = WearParameters {
                    program: in_mm(&part.setup),
                    ..WearParameters::new(part.tool, WornCutter::Tool(cutter), at_zero())
                };
                let mut output = Vec::new();
                let source = text.as_bytes().to_vec();
                compensate_wear(&part.machine, &parameters, &source, &mut output, &|| {
                    ControlFlow::Continue(())
                })
                .map(|_| String::from_utf8(output).expect("text"))
            };
            assert_eq!(run(part.tool).expect("no wear"), text, "{}", part.name);
            if core <= 0.0 {
                continue;
            }
            let output = run(worn).expect("moved");
            let tables = witness(&part, true);
            let moved = scan(&back(&output), tables.letters);
            assert_eq!(moved.len(), part.points.len());
            for ((line, point), source) in
                moved.iter().zip(written(&part)).zip(scan(&back(&text), tables.letters))
            {
                let t = tables.forward(source.q, source.angle).1;
                let n = vector(&point.normal).normalize();
                let m = (n - t * n.dot(&t)).normalize();
                let shift =
                    (n - t) * (worn.corner_radius().mm() - corner) + m * (worn.core_radius().mm() - core);
                let off_mm = (line.q - source.q - shift).norm();
                assert!(off_mm <= ROUNDING_MM, "line {}: {off_mm}", line.number);
            }
        }
    }
}

#[test]
fn cuts_with_several_tools_are_not_moved_for_one_unless_it_is_named() {
    let cuts = |text: &str, tool_number: Option<u32>| {
        let part = &parts()[0];
        let mut program = in_mm(&part.setup);
        program.tools.number = tool_number;
        let parameters = WearParameters {
            program,
            contact: ContactSource::FeedPlane,
            ..WearParameters::new(part.tool, WornCutter::Tool(tool(4.8, 4.8)), at_zero())
        };
        let mut output = Vec::new();
        let source = text.as_bytes().to_vec();
        compensate_wear(&part.machine, &parameters, &source, &mut output, &|| ControlFlow::Continue(()))
            .map(|_| String::from_utf8(output).expect("text"))
    };
    // The table turns along, so that the feed lets assume a contact.
    let line = |x: i32| {
        let a = 20.0 + 0.1 * f64::from(x);
        format!("L X+0.0000 Y+{x}.0000 Z+0.0000 A+{a:.4} C+0.0000 R0 F100\n")
    };
    let other = format!(
        "BEGIN PGM T MM\nTOOL CALL 1 Z S1\nL M128\n{}{}TOOL CALL 2 Z S1\n{}{}",
        line(0),
        line(9),
        line(0),
        line(9)
    );
    assert!(cuts(&other, None).is_err());
    let moved = cuts(&other, Some(2)).expect("the second tool's cuts");
    assert!(moved.starts_with(&other[..other.find("TOOL CALL 2").expect("there")]) && moved != other);
    let same = other.replace("CALL 2", "CALL 1");
    assert!(cuts(&same, None).expect("one tool") != same);
    let points = "GOTO/0.0000,0.0000,0.0000\nGOTO/9.0000,0.0000,0.0000\n";
    for (first, second) in
        [("CUTTER/10.,5.", "CUTTER/8.,4."), ("LOADTL/1", "LOADTL/2"), ("LOAD/TOOL,1", "LOAD/TOOL,2")]
    {
        let text = |second: &str| format!("UNITS/MM\nFEDRAT/100.,MMPM\n{first}\n{points}{second}\n{points}");
        assert!(cuts(&text(second), None).is_err(), "{second}");
        assert!(cuts(&text(first), None).is_ok(), "{first}");
    }
}

/// `LF1000` would be read back as another statement than `L F1000`.
#[test]
fn a_feed_of_its_own_is_apart_from_its_l_in_the_style_of_a_block_without_blanks() {
    let text = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S8000\n2 L X+0.0000 Y+0.0000 Z+10.0000 A+10.0000 C+0.0000 R0 FMAX\n\
        3 L X+5.0000 Y+1.0000 Z+10.0000 A+20.0000 C+30.0000 F1000\n4LX+6.0000A+21.0000\n5 M30\n6 END PGM A MM\n";
    let parameters =
        CcParameters { contact: ContactSource::Tip, ..CcParameters::new(tool(5.0, 5.0), at_zero()) };
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    let report = compensate(&ac_machine(), &parameters, &source, &mut output, &|| ControlFlow::Continue(()));
    let report = report.unwrap_or_else(|fault| panic!("{fault}"));
    let output = String::from_utf8(output).unwrap_or_else(|fault| panic!("{fault}"));
    assert!(report.motions_over_tolerance > 0);
    assert!(output.contains("\nL F1000.\n4LX+6.0000A+21.0000\n"), "{output}");
}
