//! Laws of cutter-contact compensation, seen by an independent witness.

use std::ops::ControlFlow;

use trunnion::contact::Correction;
use trunnion::machine::Tool;
use trunnion::process::{CcParameters, CcReport, ContactSource, Fault, OutputForm, compensate};
use trunnion::units::Length;

use crate::models::finishing::{
    FeedForm, Finishing, Form, ac_machine, blade, dome_near_pole, impeller_flank, tool,
};
use crate::models::set_ups::{at_zero, in_mm};
use crate::models::witness::{Tables, scan};

/// The witness' sums and ours differ by rounding only [mm].
const ARITHMETIC_MM: f64 = 1e-8;
/// The witness samples 200 steps a part: what lies between is below this share of a maximum.
const WITNESS_SHARE: f64 = 1e-3;
/// The contract's bound on blocks against the fewest possible.
const BLOCK_SHARE: f64 = 1.05;
/// F words keep their decimals; 600. and 1200. round by less than this.
const TIME_SHARE: f64 = 0.005;

pub(crate) fn parameters(part: &Finishing) -> CcParameters {
    CcParameters { program: in_mm(&part.setup), ..CcParameters::new(part.tool, at_zero()) }
}

pub(crate) fn run(
    part: &Finishing,
    parameters: &CcParameters,
    text: &str,
) -> Result<(String, CcReport), Fault> {
    let mut output = Vec::new();
    let report = compensate(&part.machine, parameters, &text.as_bytes().to_vec(), &mut output, &|| {
        ControlFlow::Continue(())
    })?;
    Ok((String::from_utf8(output).expect("text"), report))
}

pub(crate) fn witness(part: &Finishing, tcp: bool) -> Tables {
    let [first, second] = part.machine.rotary_axes();
    Tables {
        first: (first.direction, first.point_mm),
        second: (second.direction, second.point_mm),
        letters: [first.letter.as_char(), second.letter.as_char()],
        offset: part.setup.work_offset_mm,
        corner: part.tool.corner_radius().mm(),
        core: part.tool.core_radius().mm(),
        tcp,
    }
}

fn parts(tool: Tool) -> [Finishing; 3] {
    [
        blade(ac_machine(), tool, 25, 3),
        impeller_flank(ac_machine(), tool, 30, 3),
        dome_near_pole(ac_machine(), tool, 41, 3),
    ]
}

/// Places of a block at which the witness looks. `TRUNNION_THOROUGH_TESTS=1` looks at more.
fn samples() -> usize {
    if std::env::var_os("TRUNNION_THOROUGH_TESTS").is_some() { 200 } else { 60 }
}

#[test]
fn what_is_written_keeps_the_tolerance_with_no_more_blocks_than_needed_and_takes_the_same_time() {
    for tool in [tool(5.0, 5.0), tool(6.0, 1.5)] {
        for part in parts(tool) {
            for (form, feed) in [
                (Form::ContactWords, FeedForm::PerMinute),
                (Form::ContactWords, FeedForm::InverseTime),
                (Form::Tcp, FeedForm::InverseTime),
            ] {
                let text = part.program(form, feed);
                for tolerance_um in [10.0, 2.0] {
                    let parameters =
                        CcParameters { tolerance: Length::from_um(tolerance_um), ..parameters(&part) };
                    let (output, report) = run(&part, &parameters, &text).expect("compensated");
                    let verdicts = witness(&part, form == Form::Tcp).judge(&text, &output, samples());
                    println!(
                        "{} R{}/{} {form:?} {feed:?} {tolerance_um} µm: {} checked, {} over, {:.2} -> {:.2} µm, {} -> {} blocks",
                        part.name,
                        tool.radius().mm(),
                        tool.corner_radius().mm(),
                        report.motions_checked,
                        report.motions_over_tolerance,
                        report.before.max_mm * 1e3,
                        report.after.max_mm * 1e3,
                        report.blocks_in,
                        report.blocks_out,
                    );
                    let tolerance_mm = tolerance_um / 1000.0;
                    let mut over = 0;
                    let (mut blocks, mut fewest) = (0.0, 0.0);
                    for verdict in &verdicts {
                        assert!(
                            verdict.after <= tolerance_mm + ARITHMETIC_MM,
                            "{} {form:?} line {}: {} mm after, {} before, {} parts",
                            part.name,
                            verdict.line,
                            verdict.after,
                            verdict.before,
                            verdict.parts
                        );
                        if verdict.before > tolerance_mm {
                            over += 1;
                            blocks += verdict.parts as f64;
                            fewest += (verdict.before / tolerance_mm).sqrt().ceil();
                        } else {
                            assert_eq!(verdict.parts, 1, "line {} was within tolerance", verdict.line);
                        }
                        assert!(
                            (verdict.time_ratio - 1.0).abs() < TIME_SHARE,
                            "line {}: {}",
                            verdict.line,
                            verdict.time_ratio
                        );
                    }
                    assert!(
                        blocks <= BLOCK_SHARE * fewest,
                        "{}: {blocks} blocks, {fewest} needed",
                        part.name
                    );
                    assert_eq!(report.motions_over_tolerance, over);
                    assert_eq!(report.motions_checked, verdicts.len() as u64);
                    let largest = |value: fn(&crate::models::witness::Verdict) -> f64| {
                        verdicts.iter().map(value).fold(0.0, f64::max)
                    };
                    for (ours, theirs) in [
                        (report.before.max_mm, largest(|verdict| verdict.before)),
                        (report.after.max_mm, largest(|verdict| verdict.after)),
                    ] {
                        assert!(
                            (ours - theirs).abs() <= WITNESS_SHARE * theirs + ARITHMETIC_MM,
                            "{}: {ours} {theirs}",
                            part.name
                        );
                    }
                    let worst =
                        verdicts.iter().max_by(|a, b| a.before.total_cmp(&b.before)).expect("motions");
                    let at_worst = verdicts.iter().find(|v| Some(v.line as u64) == report.before.worst_line);
                    let at_worst = at_worst.expect("the worst line is a motion").before;
                    assert!(at_worst >= worst.before * (1.0 - WITNESS_SHARE));
                }
            }
        }
    }
}

#[test]
fn lines_within_tolerance_come_back_byte_for_byte() {
    let part = blade(ac_machine(), tool(5.0, 5.0), 25, 3);
    let text = part.program(Form::ContactWords, FeedForm::InverseTime);
    let parameters = CcParameters { tolerance: Length::from_um(20.0), ..parameters(&part) };
    let (output, report) = run(&part, &parameters, &text).expect("compensated");
    assert!(report.motions_over_tolerance > 0 && report.motions_over_tolerance < report.motions_checked);
    let verdicts = witness(&part, false).judge(&text, &output, 50);
    let changed: Vec<usize> =
        verdicts.iter().filter(|verdict| verdict.parts > 1).map(|verdict| verdict.line).collect();
    let written: std::collections::HashSet<&str> = output.lines().collect();
    for (index, line) in text.lines().enumerate() {
        assert!(changed.contains(&(index + 1)) || written.contains(line), "{line}");
    }
    assert_eq!(
        report.blocks_out - report.blocks_in,
        scan(&output, ['A', 'C']).len() as u64 - scan(&text, ['A', 'C']).len() as u64
    );
}

#[test]
fn a_program_within_tolerance_comes_back_as_it_was() {
    for part in parts(tool(5.0, 5.0)) {
        for form in [Form::Plain, Form::ContactWords, Form::Tcp, Form::NormalTable] {
            let text = part.program(form, FeedForm::PerMinute).replace('\n', "\r\n");
            let parameters = CcParameters { tolerance: Length::from_mm(5.0), ..parameters(&part) };
            let (output, report) = run(&part, &parameters, &text).expect("compensated");
            assert_eq!(output, text);
            assert!(report.motions_checked > 0);
            assert_eq!((report.motions_over_tolerance, report.blocks_out), (0, report.blocks_in));
            assert_eq!(report.before, report.after);
        }
    }
}

#[test]
fn contacts_from_words_and_from_normals_are_the_same_contacts() {
    for part in parts(tool(6.0, 1.5)) {
        let by_words = run(&part, &parameters(&part), &part.program(Form::ContactWords, FeedForm::PerMinute));
        let by_normals =
            run(&part, &parameters(&part), &part.program(Form::NormalTable, FeedForm::PerMinute));
        let (by_words, by_normals) = (by_words.expect("compensated").1, by_normals.expect("compensated").1);
        assert_eq!(by_words.contact, ContactSource::Program);
        assert_eq!(by_normals.contact, ContactSource::Normals);
        // The pull-up between passes is a G0 in the one and a row of the table in the other.
        assert!(
            (by_words.before.max_mm - by_normals.before.max_mm).abs() < 1e-3
                || by_normals.before.max_mm > by_words.before.max_mm
        );
        assert!(by_normals.after.max_mm <= 0.01);
    }
}

#[test]
fn foot_keeps_the_tolerance_too_and_seed_reports_what_it_leaves() {
    for part in parts(tool(5.0, 5.0)) {
        let text = part.program(Form::ContactWords, FeedForm::PerMinute);
        let with = |correction, output| CcParameters { correction, output, ..parameters(&part) };
        let foot = run(&part, &with(Correction::Foot, OutputForm::Minimal), &text).expect("compensated").1;
        assert!(foot.after.max_mm <= 0.01);
        let seed = run(&part, &with(Correction::Seed, OutputForm::Minimal), &text).expect("compensated").1;
        assert_eq!(seed.motions_over_tolerance, foot.motions_over_tolerance);
        assert!(seed.after.max_mm > foot.after.max_mm);
        // Interpolated: far more blocks than minimal.
        let steps =
            run(&part, &with(Correction::Even, OutputForm::Interpolated), &text).expect("compensated").1;
        assert!(steps.after.max_mm <= 0.01);
        assert!(steps.blocks_out > 2 * foot.blocks_out);
    }
}

#[test]
fn a_compensated_program_needs_no_second_compensation_of_its_parts() {
    let part = impeller_flank(ac_machine(), tool(5.0, 5.0), 30, 2);
    let text = part.program(Form::ContactWords, FeedForm::InverseTime);
    let parameters = CcParameters { tolerance: Length::from_um(5.0), ..parameters(&part) };
    let (once, first) = run(&part, &parameters, &text).expect("compensated");
    assert!(first.motions_over_tolerance > 10);
    // The inserted blocks' own lines are chords of the source's: twice the tolerance bounds what they deviate.
    let loose = CcParameters { tolerance: Length::from_um(10.5), ..parameters };
    let (twice, second) = run(&part, &loose, &once).expect("compensated");
    assert_eq!(once, twice, "{:?}", second.before);
}
