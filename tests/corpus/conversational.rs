//! Heidenhain programs and cutter location data that others wrote.

#![expect(clippy::unwrap_used, reason = "tests stop at the first surprise")]

use std::ops::ControlFlow;

use trunnion::machine::{Machine, PlaneRule, PlaneSolution, RotaryLetter, Tool};
use trunnion::motion::{Interpolation, Interpreter, InterpreterOptions, Motion, MotionKind, Unfollowable};
use trunnion::process::{
    CcParameters, ContactSource, WearParameters, WornCutter, compensate, compensate_wear,
};
use trunnion::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader};
use trunnion::units::Length;

use crate::set_ups::at_zero;
use crate::shared_file;
use crate::tables::tables;

/// Posted points are rounded to three decimals, cutter location data to six [mm].
const POSTED_MM: f64 = 0.0006;

const FILES: [(&str, Dialect); 8] = [
    ("5axis/nx_dmc100_heidenhain_m128.h", Dialect::Heidenhain),
    ("cl/aamorim_boss_posted_11.h", Dialect::Heidenhain),
    ("cl/aamorim_boss_posted_12.h", Dialect::Heidenhain),
    ("other/aamorim_machine_cirstud.h", Dialect::Heidenhain),
    ("other/aamorim_machine_printr1.h", Dialect::Heidenhain),
    ("cl/aamorim_boss.apt", Dialect::Apt),
    ("cl/aamorim_tilt_support.apt", Dialect::Apt),
    ("cl/aamorim_interface_glue.clt", Dialect::Apt),
];

fn program(name: &str) -> Option<Vec<u8>> {
    shared_file(&format!("programs/{name}")).map(|path| std::fs::read(path).unwrap())
}

fn batches(text: &[u8], dialect: Option<Dialect>, chunk: usize) -> Vec<Batch> {
    let mut reader = Reader::new(dialect, ReadLimits::default());
    let (mut batches, mut batch) = (Vec::new(), Batch::new());
    for piece in text.chunks(chunk) {
        reader.feed(piece);
        while reader.next_batch(&mut batch).unwrap() {
            batches.push(batch.clone());
        }
    }
    reader.finish();
    while reader.next_batch(&mut batch).unwrap() {
        batches.push(batch.clone());
    }
    batches
}

fn follow(text: &[u8], machine: &Machine) -> (Vec<Motion>, Diagnostics) {
    let mut interpreter = Interpreter::new(machine, InterpreterOptions::in_mm());
    let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
    for mut batch in batches(text, None, 64 * 1024) {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    (motions, diagnostics)
}

#[test]
fn every_file_is_detected_read_without_fault_and_covered_byte_for_byte() {
    for (name, dialect) in FILES {
        let Some(text) = program(name) else { return };
        let read = batches(&text, None, 4096);
        let mut printed = Vec::new();
        let mut line = 1;
        for batch in &read {
            assert_eq!((batch.dialect(), batch.faults()), (dialect, &[][..]), "{name}");
            for block in batch.blocks() {
                assert_eq!(block.line, line, "{name}");
                let body = batch.block_text(block);
                line += body.split(|byte| *byte == b'\n').count() as u64 - 1;
                printed.extend_from_slice(body);
            }
        }
        assert!(printed == text, "{name}");
        for chunk in [1, 17, 997] {
            assert!(batches(&text, Some(dialect), chunk) == read, "{name} in chunks of {chunk}");
        }
    }
}

#[test]
fn the_dmc_program_is_followed_through_its_calls() {
    let Some(text) = program("5axis/nx_dmc100_heidenhain_m128.h") else { return };
    let (motions, diagnostics) = follow(&text, &tables([RotaryLetter::B, RotaryLetter::C], false));
    assert_eq!(diagnostics.kept(), []);
    let followed = |motion: &&Motion| {
        motion.kind == MotionKind::Linear && motion.unfollowable.is_none() && motion.start.is_some()
    };
    let linear: Vec<_> = motions.iter().filter(followed).collect();
    println!("{} motions, {} lines followed", motions.len(), linear.len());
    // 3369 lines with L, without FMAX, that name an axis; 104 of them stand in tilted planes.
    assert_eq!(linear.len(), 3265);
    assert!(linear.iter().all(|motion| (motion.mm_per_unit - 25.4).abs() < 1e-12 && !motion.offset_changed));
    let tilted = motions.iter().filter(|motion| motion.unfollowable == Some(Unfollowable::PlaneSolution));
    assert!(tilted.clone().all(|motion| motion.line >= 206) && tilted.count() > 100);
    let calls = motions.iter().filter(|motion| motion.unfollowable == Some(Unfollowable::Call)).count();
    assert_eq!(calls, 23);
    let tcp = linear.iter().filter(|motion| motion.interpolation == Interpolation::Tcp).count();
    assert!(tcp > 2500, "{tcp}");
    // F78.7 inches a minute.
    assert_eq!(linear[0].feed.value, Some(78.7 * 25.4));
}

/// Tables whose control turns B to the negative side for a tilted plane.
fn tables_with_planes() -> Machine {
    let rule = PlaneSolution { rule: PlaneRule::NegativeFirst, axis: Some(RotaryLetter::B) };
    tables([RotaryLetter::B, RotaryLetter::C], false).with_plane_solution(Some(rule))
}

#[test]
fn the_planes_of_the_dmc_program_are_followed_and_need_no_correction() {
    let Some(text) = program("5axis/nx_dmc100_heidenhain_m128.h") else { return };
    let machine = tables_with_planes();
    let (motions, _) = follow(&text, &machine);
    let in_planes: Vec<_> =
        motions.iter().filter(|motion| motion.frame.is_some() && motion.kind == MotionKind::Linear).collect();
    // Two planes at right angles, and one that only names the workpiece.
    assert!(in_planes.len() > 100, "{}", in_planes.len());
    assert!(in_planes.iter().all(|motion| motion.unfollowable.is_none() && motion.end.is_some()));
    let axes: Vec<_> =
        in_planes.iter().filter_map(|motion| motion.end).map(|end| end.rotary_deg[0]).collect();
    assert!(axes.iter().all(|b| (b + 90.0).abs() < 1e-9 || b.abs() < 1e-9), "{axes:?}");
    let checked = [&machine, &tables([RotaryLetter::B, RotaryLetter::C], false)].map(|machine| {
        let radius = Length::from_mm(5.0);
        let parameters = CcParameters::new(Tool::new(radius, radius).unwrap(), at_zero());
        let mut output = Vec::new();
        let report =
            compensate(machine, &parameters, &text, &mut output, &|| ControlFlow::Continue(())).unwrap();
        let lines: Vec<Vec<u8>> = output.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
        for motion in &in_planes {
            let own =
                text.split(|byte| *byte == b'\n').nth(usize::try_from(motion.line).unwrap() - 1).unwrap();
            assert!(lines.iter().any(|line| line == own), "line {}", motion.line);
        }
        report.motions_checked
    });
    let with_start = in_planes.iter().filter(|motion| motion.start != motion.end && motion.start.is_some());
    assert_eq!(checked[0] - checked[1], with_start.count() as u64);
}

/// The first section of the program in a plane, for a tool that is shorter by a hundredth of an inch.
#[test]
fn a_plane_of_the_dmc_program_is_written_for_a_shorter_tool() {
    let Some(text) = program("5axis/nx_dmc100_heidenhain_m128.h") else { return };
    let text = String::from_utf8(text).unwrap();
    let section: Vec<&str> = text.lines().skip(203).take(44).collect();
    assert!(section[0].contains("TOOL CALL 0 Z") && section[1].contains("PLANE SPATIAL"), "{}", section[0]);
    let source = format!("0 BEGIN PGM P INCH\n{}\n9 END PGM P INCH\n", section.join("\n").replace('\r', ""));
    let ball = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).unwrap();
    let parameters = WearParameters {
        shorter_by: Length::from_mm(0.254),
        ..WearParameters::new(ball, WornCutter::Tool(ball), at_zero())
    };
    let mut output = Vec::new();
    let go_on = || ControlFlow::Continue(());
    let report =
        compensate_wear(&tables_with_planes(), &parameters, &source.as_bytes().to_vec(), &mut output, &go_on);
    let report = report.unwrap();
    let output = String::from_utf8(output).unwrap();
    let written: Vec<&str> = output.lines().filter(|line| !line.contains("trunnion")).collect();
    assert_eq!(written.len(), source.lines().count(), "{output}");
    let mut changed = 0;
    for (before, after) in source.lines().zip(written) {
        for (before, after) in before.split(' ').zip(after.split(' ')) {
            let number = |word: &str| word.strip_prefix("Z+").and_then(|number| number.parse::<f64>().ok());
            match number(before).zip(number(after)) {
                Some((before, after)) => assert!((before - 0.01 - after).abs() < 1e-9, "{before} {after}"),
                None => assert_eq!(before, after, "{output}"),
            }
            changed += u64::from(number(before).is_some());
        }
    }
    assert!(changed > 8 && report.blocks_changed == changed, "{changed}");
}

#[test]
fn the_dmc_program_keeps_its_tolerance() {
    let Some(text) = program("5axis/nx_dmc100_heidenhain_m128.h") else { return };
    let radius = Length::from_mm(5.0);
    for tolerance_um in [10.0, 5.0] {
        let parameters = CcParameters {
            contact: ContactSource::FeedPlane,
            tolerance: Length::from_um(tolerance_um),
            ..CcParameters::new(Tool::new(radius, radius).unwrap(), at_zero())
        };
        let mut output = Vec::new();
        let machine = tables([RotaryLetter::B, RotaryLetter::C], false);
        let result = compensate(&machine, &parameters, &text, &mut output, &|| ControlFlow::Continue(()));
        // Four decimals of an inch leave 2.5 µm open.
        let report = result.unwrap();
        println!(
            "{tolerance_um} µm: {} checked, {} over, {:.2} -> {:.2} µm, {} -> {} blocks",
            report.motions_checked,
            report.motions_over_tolerance,
            report.before.max_mm * 1e3,
            report.after.max_mm * 1e3,
            report.blocks_in,
            report.blocks_out
        );
        for warning in &report.warnings {
            println!("  {:?} × {} at {:?} {:?}", warning.kind, warning.count, warning.line, warning.reason);
        }
        assert_eq!(report.contact, ContactSource::FeedPlane);
        assert!(report.motions_checked > 3000);
        assert!(report.after.max_mm <= tolerance_um / 1e3);
        let is_own = |line: &&[u8]| !text.split(|byte| *byte == b'\n').any(|own| own == *line);
        let new = output.split(|byte| *byte == b'\n').filter(is_own).count() as u64;
        assert!(new >= report.motions_over_tolerance);
    }
}

/// The ends of all motions, one after the other, where they differ.
fn path(motions: impl Iterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
    let mut path: Vec<[f64; 3]> = Vec::new();
    for end in motions {
        if path.last().is_none_or(|last| (0..3).any(|k| (last[k] - end[k]).abs() > POSTED_MM)) {
            path.push(end);
        }
    }
    path
}

#[test]
fn cutter_location_data_and_the_program_posted_from_it_run_through_the_same_points() {
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    let (Some(apt), Some(first), Some(second)) = (
        program("cl/aamorim_boss.apt"),
        program("cl/aamorim_boss_posted_11.h"),
        program("cl/aamorim_boss_posted_12.h"),
    ) else {
        return;
    };
    let points = follow(&apt, &machine).0;
    // The first set-up stands upright; in the second one the tool's axis is X, and the post turns it to Z.
    for (posted, upright) in [(first, true), (second, false)] {
        let in_setup = points.iter().filter(|motion| (motion.tool_axis == Some([0.0, 0.0, 1.0])) == upright);
        let turned = |[x, y, z]: [f64; 3]| if upright { [x, y, z] } else { [-z, y, x] };
        let data = path(in_setup.filter_map(|motion| motion.linear_end_mm).map(turned));
        let program = path(follow(&posted, &machine).0.iter().filter_map(|motion| motion.linear_end_mm));
        let mut matched = 0;
        let mut at = 0;
        for end in &program {
            let same = |point: &[f64; 3]| (0..3).all(|k| (point[k] - end[k]).abs() <= POSTED_MM);
            // The post leaves out points it does not need.
            if let Some(found) = data[at..].iter().take(40).position(same) {
                at += found + 1;
                matched += 1;
            }
        }
        println!("{} points, {} posted, {matched} matched, reached {at}", data.len(), program.len());
        assert!(matched * 100 >= program.len() * 97, "{matched} of {}", program.len());
        assert!(at * 100 >= data.len() * 97, "{at} of {}", data.len());
    }
}

#[test]
fn tilted_cutter_location_data_is_followed_and_turned_coordinates_are_left_alone() {
    let machine = tables([RotaryLetter::B, RotaryLetter::C], false);
    let (Some(tilted), Some(turned)) =
        (program("cl/aamorim_tilt_support.apt"), program("cl/aamorim_interface_glue.clt"))
    else {
        return;
    };
    let (motions, _) = follow(&tilted, &machine);
    let axes = motions.iter().filter(|motion| motion.unfollowable == Some(Unfollowable::ToolVector));
    assert!(axes.clone().all(|motion| motion.tool_axis == Some([-0.173_648, 0.0, 0.984_808])));
    assert_eq!((motions.len(), axes.count()), (184, 180));
    let (motions, _) = follow(&turned, &machine);
    let reasons = motions.iter().map(|motion| motion.unfollowable);
    assert!(reasons.into_iter().all(|reason| {
        matches!(
            reason,
            Some(Unfollowable::Transformation | Unfollowable::CannedCycle | Unfollowable::CutterCompensation)
        )
    }));
    assert_eq!(motions.len(), 2036);
}
