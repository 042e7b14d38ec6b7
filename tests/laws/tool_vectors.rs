//! Laws of programs that state the tool axis as a vector (G43.5 I J K): the same motion as with rotary words.

use std::fmt::Write;

use trunnion::process::CcParameters;
use trunnion::program::Dialect;
use trunnion::units::Length;

use crate::compensation::{parameters, run, witness};
use crate::models::finishing::{FeedForm, Finishing, Form, ac_machine, blade, impeller_flank, tool};

/// The witness' sums and ours differ by rounding only, and by the ninth decimal of its angles [mm].
const ARITHMETIC_MM: f64 = 1e-6;

/// The value behind a letter of a line.
fn word(line: &str, letter: char) -> Option<f64> {
    line.split(' ').find_map(|word| word.strip_prefix(letter)).and_then(|number| number.parse().ok())
}

/// The part's program with `I J K` of seven decimals in place of A and C.
fn with_vectors(part: &Finishing) -> String {
    let mut points = part.points.iter();
    let mut text = String::new();
    for line in part.program(Form::Tcp, FeedForm::InverseTime).lines() {
        let moving = line.contains(" X");
        let words: Vec<String> = line
            .replace("G43.4", "G43.5")
            .split(' ')
            .filter_map(|word| match word.chars().next() {
                Some('A') if moving => {
                    let axis = points.next().expect("a point").pose.axis;
                    Some(format!("I{:.7} J{:.7} K{:.7}", axis.x, axis.y, axis.z))
                }
                Some('C') if moving => None,
                _ => Some(word.to_owned()),
            })
            .collect();
        writeln!(text, "{}", words.join(" ")).expect("text");
    }
    text
}

/// The same for a Sinumerik, with A3 B3 C3 in place of I J K.
fn to_siemens(text: &str) -> String {
    let words = |line: &str| {
        line.replace("G43.5 H1", "TRAORI")
            .replace("G21", "G71")
            .replace(" I", " A3=")
            .replace(" J", " B3=")
            .replace(" K", " C3=")
    };
    text.lines().filter(|line| line.starts_with('N')).map(|line| words(line) + "\n").collect()
}

fn from_siemens(text: &str) -> String {
    let words = |line: &str| {
        line.replace("TRAORI", "G43.5 H1")
            .replace("G71", "G21")
            .replace(" A3=", " I")
            .replace(" B3=", " J")
            .replace(" C3=", " K")
    };
    text.lines().map(|line| words(line) + "\n").collect()
}

/// The same with A and C for the witness, by the closed form of an AC table: `t = (sin A sin C, −sin A cos C, cos A)`.
pub(crate) fn with_angles(text: &str) -> String {
    let mut near = [0.0; 2];
    let mut out = String::new();
    for line in text.lines() {
        let Some([i, j, k]) =
            word(line, 'I').zip(word(line, 'J')).zip(word(line, 'K')).map(|((i, j), k)| [i, j, k])
        else {
            writeln!(out, "{line}").expect("text");
            continue;
        };
        let branches = [1.0_f64, -1.0].map(|sign| {
            let a = sign * f64::hypot(i, j).atan2(k).to_degrees();
            let c = (sign * i).atan2(-sign * j).to_degrees();
            [a, c + 360.0 * ((near[1] - c) / 360.0).round()]
        });
        let way = |angles: &[f64; 2]| (angles[0] - near[0]).abs() + (angles[1] - near[1]).abs();
        near = if way(&branches[0]) <= way(&branches[1]) { branches[0] } else { branches[1] };
        let words: Vec<String> = line
            .split(' ')
            .filter_map(|word| match word.chars().next() {
                Some('I') => Some(format!("A{:.9} C{:.9}", near[0], near[1])),
                Some('J' | 'K') => None,
                _ => Some(word.to_owned()),
            })
            .collect();
        writeln!(out, "{}", words.join(" ")).expect("text");
    }
    out
}

#[test]
fn programs_with_vectors_keep_the_tolerance_seen_by_the_witness() {
    let mut divided = 0;
    for part in
        [blade(ac_machine(), tool(5.0, 5.0), 25, 3), impeller_flank(ac_machine(), tool(6.0, 1.5), 30, 3)]
    {
        let text = with_vectors(&part);
        for (tolerance_um, dialect) in
            [(2.0, Dialect::Iso), (0.5, Dialect::Iso), (2.0, Dialect::Siemens), (0.5, Dialect::Siemens)]
        {
            let parameters = CcParameters { tolerance: Length::from_um(tolerance_um), ..parameters(&part) };
            let is_iso = dialect == Dialect::Iso;
            let source = if is_iso { text.clone() } else { to_siemens(&text) };
            let (output, report) = run(&part, &parameters, &source).expect("compensated");
            assert_eq!(report.dialect, dialect);
            let output = if is_iso { output } else { from_siemens(&output) };
            let verdicts = witness(&part, true).judge(&with_angles(&text), &with_angles(&output), 200);
            let over =
                verdicts.iter().filter(|verdict| verdict.before > tolerance_um / 1000.0).count() as u64;
            println!("{} {tolerance_um} µm: {} checked, {over} over", part.name, report.motions_checked);
            assert_eq!(report.motions_over_tolerance, over);
            divided += over;
            assert_eq!(report.motions_checked, verdicts.len() as u64);
            for verdict in &verdicts {
                assert!(verdict.after <= tolerance_um / 1000.0 + ARITHMETIC_MM, "line {}", verdict.line);
                assert!(verdict.parts == 1 || verdict.before > tolerance_um / 1000.0 - ARITHMETIC_MM);
            }
            // Vectors stay vectors, with the decimals of the source.
            for line in output.lines().filter(|line| line.contains(" X")) {
                assert!(!line.contains(" A") && !line.contains(" C"), "{line}");
                let k = line.split(' ').find_map(|word| word.strip_prefix('K'));
                assert!(
                    k.is_some_and(|k| k.split_once('.').is_some_and(|(_, digits)| digits.len() == 7)),
                    "{line}"
                );
            }
        }
    }
    assert!(divided > 50, "{divided}");
}

#[test]
fn a_program_with_vectors_within_tolerance_comes_back_byte_for_byte() {
    let part = blade(ac_machine(), tool(5.0, 5.0), 25, 3);
    let text = with_vectors(&part);
    let parameters = CcParameters { tolerance: Length::from_mm(1.0), ..parameters(&part) };
    let (output, report) = run(&part, &parameters, &text).expect("compensated");
    assert_eq!(output, text);
    assert!(report.motions_checked > 60, "{}", report.motions_checked);
}
