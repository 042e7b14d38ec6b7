//! Laws of singular regions, seen by an independent witness.
#![expect(clippy::float_cmp, reason = "words that were copied are the same to the bit")]

use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, SingularityKind};
use trunnion::machine::{Machine, Preset, Tool};
use trunnion::process::{
    CcParameters, Fault, LeftReason, MemoryStepStore, RegionTreatment, SingularityAction,
    SingularityParameters, SingularityReport, compensate, treat_and_compensate, treat_singular_regions,
};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::units::{Angle, Feedrate, Length};

use crate::models::axes_witness::{Axes, Move, angle_deg, off_line, on_circle};
use crate::models::finishing::{self, FeedForm, Form, ac_machine, dome_near_pole};
use crate::models::pole_passes::{PassShape, PolePass, pole_pass};
use crate::models::set_ups::{at_zero, in_mm};

/// Machines with a pole: tables, heads, both, and three nutating ones.
const LAYOUTS: [&str; 7] = [
    "ac-table",
    "bc-head",
    "ab-table",
    "b-head-c-table",
    "nutating-b-head-c-table",
    "nutating-bc-table",
    "nutating-ac-head",
];
/// Sums of rotations in two implementations [mm, deg].
const ARITHMETIC: f64 = 1e-7;
/// Four decimals on three axes \[mm\].
const ROUNDING_MM: f64 = 0.5e-4 * 1.8;
/// F words keep their decimals, and have four digits here.
const TIME_SHARE: f64 = 0.006;
/// The witness takes twenty samples of a block.
const SAMPLES: usize = 20;

fn treat(pass: &PolePass, singularity: &SingularityParameters) -> Result<(String, SingularityReport), Fault> {
    let parameters = CcParameters { program: in_mm(&pass.setup), ..CcParameters::new(pass.tool, at_zero()) };
    let mut output = Vec::new();
    let source = pass.text.clone().into_bytes();
    let go_on = || ControlFlow::Continue(());
    let report =
        treat_singular_regions(&pass.machine, &parameters, singularity, &source, &mut output, &go_on)?;
    Ok((String::from_utf8(output).expect("text"), report))
}

fn shapes() -> Vec<PassShape> {
    let plain = PassShape::PLAIN;
    vec![
        plain,
        PassShape { miss_deg: 0.05, ..plain },
        PassShape { miss_deg: 1.0, motions: 25, inverse_time: true, ..plain },
        PassShape { miss_deg: 0.5, incremental: true, ..plain },
    ]
}

fn every_pass(mut look: impl FnMut(&str, &PolePass)) {
    for id in LAYOUTS {
        for tcp in [true, false] {
            for shape in shapes() {
                look(&format!("{id} TCP {tcp} {shape:?}"), &pole_pass(id, tcp, shape));
            }
        }
    }
}

/// The lines whose motion turns an axis and comes within the zone of the pole, by samples; with the least angle.
fn singular_lines(pass: &PolePass, axes: &Axes, moves: &[Move], zone_deg: f64) -> Vec<(u64, f64)> {
    let kinematics = trunnion::kinematics::Kinematics::new(&pass.machine, &pass.setup);
    let u = pass.machine.rotary_axes()[kinematics.workpiece_to_tool()[0]].direction;
    moves
        .windows(2)
        .filter(|pair| !pair[1].rapid && Axes::step(&pair[0], &pair[1]) > 0.0)
        .filter_map(|pair| {
            let ends = [0.0, 1.0].map(|s| axes.between(&pair[0], &pair[1], s).1);
            let least = (0..=100)
                .map(|k| f64::from(k) / 100.0)
                .flat_map(|s| [axes.between(&pair[0], &pair[1], s).1, on_circle(ends[0], ends[1], s)])
                .map(|axis| angle_deg(u, axis))
                .fold(f64::INFINITY, f64::min);
            (least < zone_deg).then_some((pair[1].line as u64, least))
        })
        .collect()
}

#[test]
fn a_report_names_the_motions_near_the_pole_and_changes_nothing() {
    every_pass(|name, pass| {
        let singularity = SingularityParameters::new(SingularityAction::Report);
        let (output, report) = treat(pass, &singularity).expect("reported");
        assert_eq!(output, pass.text, "{name}");
        let axes = Axes::new(&pass.machine, &pass.setup, pass.tcp);
        let moves = axes.scan(&pass.text);
        let expected = singular_lines(pass, &axes, &moves, singularity.zone.deg());
        let [region] = report.regions.as_slice() else { panic!("{name}: {:?}", report.regions) };
        assert_eq!(region.kind, SingularityKind::Pole, "{name}");
        // The zone is one of gain: on these layouts the gain is the sine of the angle but for a few per cent.
        let lines = [expected[0].0, expected[expected.len() - 1].0];
        assert!(region.first_line.abs_diff(lines[0]) <= 1, "{name}: {region:?} {lines:?}");
        assert!(region.last_line.abs_diff(lines[1]) <= 1, "{name}: {region:?} {lines:?}");
        assert_eq!(region.motions, region.last_line - region.first_line + 1, "{name}");
        let least = expected.iter().map(|(_, least)| *least).fold(f64::INFINITY, f64::min);
        // A sample misses the least angle by a part of 1/100 of a block.
        assert!(
            (region.least_angle.deg() - least).abs() < 2e-3,
            "{name}: {} {least}",
            region.least_angle.deg()
        );
        let speeds = moves
            .windows(2)
            .filter(|pair| !pair[1].rapid)
            .filter(|pair| (region.first_line..=region.last_line).contains(&(pair[1].line as u64)));
        let fastest = speeds
            .map(|pair| Axes::step(&pair[0], &pair[1]) / Axes::time(&pair[0], &pair[1]))
            .fold(0.0, f64::max);
        let found = region.before.rotary_deg_per_s.expect("a feed");
        assert!((found - fastest).abs() < 1e-6 * fastest, "{name}: {found} {fastest}");
        assert_eq!(region.before.motions_over_speed > 0, fastest > 120.0, "{name}");
        assert_eq!((region.after, report.blocks_out), (None, report.blocks_in), "{name}");
    });
}

#[test]
fn smoothing_slows_the_rotary_axes_within_the_tolerance_of_the_tool_axis() {
    let (mut smoothed, mut best, mut worst) = (0, 1.0_f64, 0.0_f64);
    every_pass(|name, pass| {
        for tolerance_deg in [0.05, 0.3] {
            let singularity = SingularityParameters {
                axis_tolerance: Angle::from_deg(tolerance_deg),
                ..SingularityParameters::new(SingularityAction::Smooth)
            };
            let (output, report) = treat(pass, &singularity).expect("smoothed");
            let axes = Axes::new(&pass.machine, &pass.setup, pass.tcp);
            let (source, written) = (axes.scan(&pass.text), axes.scan(&output));
            assert_eq!(source.len(), written.len(), "{name}");
            let region = report.regions[0];
            let RegionTreatment::Smoothed { axis_spent, changed } = region.treatment else {
                assert_eq!(output, pass.text, "{name}");
                assert_eq!(region.treatment, RegionTreatment::Left(LeftReason::NothingToGain), "{name}");
                continue;
            };
            smoothed += 1;
            let inside = region.first_line..=region.last_line;
            let (mut spent, mut speeds) = (0.0_f64, [0.0_f64; 2]);
            let mut differ = 0;
            for k in 0..source.len() {
                let (a, b) = (&source[k], &written[k]);
                let is_in = inside.contains(&(a.line as u64));
                differ += u64::from(is_in && a.text != b.text);
                // The first block behind the region may get the program's F back.
                let same = a.text == b.text || b.text.starts_with(a.text.trim_end()) && b.feed == a.feed;
                assert!(is_in || same, "{name}: {} {}", a.text, b.text);
                if !is_in || a.line as u64 == region.last_line {
                    assert!((a.q - b.q).norm() < 1e-9 && (a.angle[0] - b.angle[0]).abs() < 1e-9, "{name}");
                }
                let [was, is] = [axes.pose(a.q, a.angle), axes.pose(b.q, b.angle)];
                assert!((was.0 - is.0).norm() < ROUNDING_MM, "{name}: {} {}", a.text, b.text);
                spent = spent.max(angle_deg(was.1, is.1));
                if k == 0 || a.rapid {
                    continue;
                }
                let times = [Axes::time(&source[k - 1], a), Axes::time(&written[k - 1], b)];
                assert!((times[1] / times[0] - 1.0).abs() < TIME_SHARE, "{name}: {} {}", a.text, b.text);
                if is_in {
                    speeds[0] = speeds[0].max(Axes::step(&source[k - 1], a) / times[0]);
                    speeds[1] = speeds[1].max(Axes::step(&written[k - 1], b) / times[1]);
                }
            }
            assert!(spent <= tolerance_deg + ARITHMETIC, "{name}: {spent}");
            assert!((spent - axis_spent.deg()).abs() < ARITHMETIC, "{name}: {spent} {}", axis_spent.deg());
            assert!(speeds[1] < 0.92 * speeds[0], "{name}: {speeds:?}");
            let after = region.after.expect("read back");
            let told = after.rotary_deg_per_s.expect("a feed");
            assert!((told / speeds[1] - 1.0).abs() < 1e-6, "{name}: {told} {speeds:?}");
            assert!(changed >= differ && report.blocks_changed == differ, "{name}: {changed} {differ}");
            best = best.min(speeds[1] / speeds[0]);
            worst = worst.max(speeds[1] / speeds[0]);
        }
    });
    println!("{smoothed} regions smoothed; largest rotary speed left: {best:.3} to {worst:.3} of before");
    assert!(smoothed > 60, "{smoothed}");
}

#[test]
fn what_is_densified_keeps_line_great_circle_and_step() {
    let mut divided_motions = 0;
    every_pass(|name, pass| {
        let singularity = SingularityParameters::new(SingularityAction::Densify);
        let (output, report) = treat(pass, &singularity).expect("densified");
        let axes = Axes::new(&pass.machine, &pass.setup, pass.tcp);
        let (source, written) = (axes.scan(&pass.text), axes.scan(&output));
        let region = report.regions[0];
        let (divided, inserted) = match region.treatment {
            RegionTreatment::Densified { divided, inserted, left, .. } => {
                assert_eq!(left, 0, "{name}: {region:?}");
                (divided, inserted)
            }
            RegionTreatment::Left(LeftReason::NothingToGain) => (0, 0),
            other => panic!("{name}: {other:?}"),
        };
        divided_motions += divided;
        assert_eq!((written.len() - source.len()) as u64, inserted, "{name}");
        assert_eq!(report.blocks_out - report.blocks_in, inserted, "{name}");
        let (mut at, mut longer) = (0, 0);
        for k in 0..source.len() {
            let first = at;
            let same = |b: &Move| {
                (b.q - source[k].q).norm() < 1e-9
                    && (0..2).all(|n| (b.angle[n] - source[k].angle[n]).abs() < 1e-9)
            };
            while !same(&written[at]) {
                at += 1;
            }
            at += 1;
            let parts = at - first;
            longer += u64::from(parts > 1);
            let is_in = (region.first_line..=region.last_line).contains(&(source[k].line as u64));
            if k == 0 || source[k].rapid || !is_in {
                assert_eq!(parts, 1, "{name}: {}", source[k].text);
                continue;
            }
            let ends = [0.0, 1.0].map(|s| axes.between(&source[k - 1], &source[k], s));
            let whole = Axes::time(&source[k - 1], &source[k]);
            for part in 0..parts {
                let (a, b) = (&written[first + part - 1], &written[first + part]);
                let step = Axes::step(a, b);
                assert!(step <= singularity.max_step.deg() + 1e-6, "{name}: {} {step}", b.text);
                let share = Axes::time(a, b) * parts as f64 / whole;
                assert!((share - 1.0).abs() < TIME_SHARE, "{name}: {} {share}", b.text);
                for sample in 0..=SAMPLES {
                    let s = sample as f64 / SAMPLES as f64;
                    let (tip, axis) = axes.between(a, b, s);
                    let u = (part as f64 + s) / parts as f64;
                    let off = angle_deg(axis, on_circle(ends[0].1, ends[1].1, u));
                    assert!(off <= singularity.axis_tolerance.deg() + ARITHMETIC, "{name}: {} {off}", b.text);
                    let off = off_line(tip, ends[0].0, ends[1].0);
                    assert!(off <= 0.01 + ARITHMETIC, "{name}: {} {off}", b.text);
                }
            }
        }
        assert_eq!((at, longer), (written.len(), divided), "{name}");
    });
    println!("{divided_motions} motions divided");
    assert!(divided_motions > 100);
}

#[test]
fn a_pass_through_the_pole_itself_is_divided_where_it_may_lean_aside_or_left_with_a_reason() {
    for id in LAYOUTS {
        let shape = PassShape { miss_deg: 0.0, motions: 7, ..PassShape::PLAIN };
        let pass = pole_pass(id, true, shape);
        for (tolerance_deg, step_deg) in [(0.05, 5.0), (0.5, 20.0)] {
            let singularity = SingularityParameters {
                axis_tolerance: Angle::from_deg(tolerance_deg),
                max_step: Angle::from_deg(step_deg),
                ..SingularityParameters::new(SingularityAction::Densify)
            };
            let (output, report) = treat(&pass, &singularity).expect("treated");
            let axes = Axes::new(&pass.machine, &pass.setup, true);
            let written = axes.scan(&output);
            match report.regions[0].treatment {
                RegionTreatment::Left(reason) => {
                    assert_eq!(output, pass.text);
                    let fits = matches!(reason, LeftReason::TooManyParts | LeftReason::NothingToGain);
                    assert!(fits, "{id}: {reason:?}");
                }
                RegionTreatment::Densified { left: 0, .. } => {
                    let region = report.regions[0];
                    assert!(region.after.expect("read back").step_deg <= step_deg + 1e-6);
                    assert!(written.len() > 8);
                }
                other => assert!(matches!(other, RegionTreatment::Densified { .. }), "{id}: {other:?}"),
            }
        }
    }
}

#[test]
fn contacts_stay_where_the_words_put_them_when_the_tool_leans_otherwise() {
    for (radius_mm, corner_mm) in [(5.0, 5.0), (6.0, 1.5)] {
        for form in [Form::ContactWords, Form::Tcp] {
            let tool = finishing::tool(radius_mm, corner_mm);
            let part = dome_near_pole(ac_machine(), tool, 41, 3);
            let text = part.program(form, FeedForm::PerMinute);
            let parameters =
                CcParameters { program: in_mm(&part.setup), ..CcParameters::new(part.tool, at_zero()) };
            let singularity = SingularityParameters {
                axis_tolerance: Angle::from_deg(0.3),
                ..SingularityParameters::new(SingularityAction::Smooth)
            };
            let mut output = Vec::new();
            let source = text.clone().into_bytes();
            let go_on = || ControlFlow::Continue(());
            let report = treat_singular_regions(
                &part.machine,
                &parameters,
                &singularity,
                &source,
                &mut output,
                &go_on,
            )
            .expect("smoothed");
            assert!(report.regions_treated > 0 && report.blocks_changed > 10, "{report:?}");
            assert!(report.after.rotary_deg_per_s < report.before.rotary_deg_per_s);
            let output = String::from_utf8(output).expect("text");
            let witness = super::compensation::witness(&part, form == Form::Tcp);
            let letters = ['A', 'C'];
            let (was, is) = (
                crate::models::witness::scan(&text, letters),
                crate::models::witness::scan(&output, letters),
            );
            assert_eq!(was.len(), is.len());
            for ((was, is), point) in was.iter().zip(&is).zip(&part.points) {
                let (tip, axis) = witness.forward(is.q, is.angle);
                let contact = witness.forward(is.uvw.expect("a contact"), is.angle).0;
                let before = witness.forward(was.uvw.expect("a contact"), was.angle).0;
                assert!((contact - before).norm() < ROUNDING_MM, "{}", is.text);
                // The same point of the surface by the tool's shape, with its normal there.
                let across = point.normal - axis * point.normal.dot(&axis);
                let core = if radius_mm > corner_mm {
                    across.normalize() * (radius_mm - corner_mm)
                } else {
                    across * 0.0
                };
                let touched = tip - point.normal * corner_mm - core + axis * corner_mm;
                let turned = angle_deg(axis, witness.forward(was.q, was.angle).1);
                assert!(turned <= 0.3 + ARITHMETIC, "{turned}");
                // Words near the tool's centre tell the side only to some digits, and it turns as the tool leans.
                let across = across.norm();
                let side = 2.0 * ROUNDING_MM / corner_mm / across * turned.to_radians() / across;
                let slack = 2.0 * ROUNDING_MM + (radius_mm - corner_mm) * side;
                assert!((touched - before).norm() < slack, "{} {}", is.text, (touched - before).norm());
            }
        }
    }
}

#[test]
fn coarse_decimals_and_turning_in_place_are_refused_or_kept_by_name() {
    let coarse = PassShape { decimals: 1, ..PassShape::PLAIN };
    let pass = pole_pass("ac-table", true, coarse);
    let singularity = SingularityParameters {
        axis_tolerance: Angle::from_deg(0.001),
        ..SingularityParameters::new(SingularityAction::Smooth)
    };
    let (output, report) = treat(&pass, &singularity).expect("treated");
    assert_eq!(output, pass.text);
    assert_eq!(report.left[0].reason, LeftReason::DecimalsTooCoarse);

    // C turns at A0: nothing leans, and the tip is held by parts.
    let text = "G21 G90\nG0 X50. Y0. Z0. A0. C0.\nG1 X0. Y-50. C90. F1000\nX10.\nC91.\nM30\n";
    let turning =
        PolePass { text: text.to_owned(), tcp: false, ..pole_pass("ac-table", false, PassShape::PLAIN) };
    let machine = trunnion::machine::Machine::new(
        trunnion::machine::Preset::by_id("ac-table").expect("a preset").parts(),
    )
    .expect("a machine");
    let turning = PolePass { machine, setup: trunnion::kinematics::Setup::default(), ..turning };
    let densify = SingularityParameters::new(SingularityAction::Densify);
    let (output, report) = treat(&turning, &densify).expect("treated");
    let region = report.regions[0];
    assert_eq!((region.first_line, region.last_line, region.motions), (3, 5, 3));
    assert!(region.least_angle.deg() < 1e-9);
    assert!(region.before.deviation.mm() > 10.0);
    let after = region.after.expect("read back");
    assert!(after.deviation.mm() <= 0.01 && after.step_deg <= 5.0 + 1e-6, "{after:?}");
    assert!(output.contains("C90."), "{output}");
}

#[test]
fn treated_and_compensated_in_one_is_one_after_the_other_with_the_lines_of_the_upload() {
    for action in [SingularityAction::Report, SingularityAction::Densify, SingularityAction::Smooth] {
        let pass = pole_pass(
            "bc-head",
            false,
            PassShape { lean_deg: 12.0, miss_deg: 0.5, motions: 12, ..PassShape::PLAIN },
        );
        let singularity = SingularityParameters::new(action);
        let (between, treated) = treat(&pass, &singularity).expect("treated");
        let parameters =
            CcParameters { program: in_mm(&pass.setup), ..CcParameters::new(pass.tool, at_zero()) };
        let go_on = || ControlFlow::Continue(());
        let mut apart = Vec::new();
        let source = between.clone().into_bytes();
        let after = compensate(&pass.machine, &parameters, &source, &mut apart, &go_on).expect("compensated");
        let mut at_once = Vec::new();
        let (region, found) = treat_and_compensate(
            &pass.machine,
            &parameters,
            &singularity,
            &pass.text.clone().into_bytes(),
            &MemoryStepStore::default(),
            &mut at_once,
            &OneAfterAnother,
            &go_on,
        )
        .expect("both");
        assert_eq!(apart, at_once);
        assert_eq!((found.blocks_in, found.blocks_out), (treated.blocks_in, after.blocks_out));
        assert_eq!((region, found.after.max_mm), (Some(treated), after.after.max_mm));
        assert!(after.motions_over_tolerance > 0);
        // The line of the written program, counted back over the blocks that came in before it.
        let axes = Axes::new(&pass.machine, &pass.setup, false);
        let (source, written) = (axes.scan(&pass.text), axes.scan(&between));
        let worst = after.before.worst_line.expect("a worst line");
        let at = written.iter().position(|a| a.line as u64 == worst).expect("a motion");
        let end = written[at..].iter().find_map(|b| {
            source.iter().find(|a| (a.q - b.q).norm() < 1e-9 && (a.angle[0] - b.angle[0]).abs() < 1e-9)
        });
        let line = found.before.worst_line.expect("a worst line");
        match action {
            SingularityAction::Densify => assert_eq!(line, end.expect("an end of the source").line as u64),
            _ => assert_eq!(line, worst),
        }
    }
}

/// The pass in tool vectors of ten decimals (G43.5) in place of A and C.
fn in_vectors(pass: &PolePass, kinematics: &Kinematics) -> String {
    let axes = pass.machine.rotary_axes();
    let mut angles_deg = [0.0; 2];
    let mut text = String::new();
    for line in pass.text.replace("G43.4", "G43.5").lines() {
        let mut words = Vec::new();
        for word in line.split_whitespace() {
            match axes.iter().position(|axis| word.starts_with(axis.letter.as_char())) {
                Some(k) => angles_deg[k] = word[1..].parse::<f64>().expect("a number"),
                None => words.push(word.to_owned()),
            }
        }
        // Every numbered block is a point of the pass.
        if line.starts_with('N') {
            let axis = kinematics.axis([0, 1].map(|k: usize| axes[k].angle_rad(angles_deg[k])));
            let before_feed = words.iter().position(|word| word.starts_with('F')).unwrap_or(words.len());
            words.insert(before_feed, format!("I{:.10} J{:.10} K{:.10}", axis.x, axis.y, axis.z));
        }
        text.push_str(&(words.join(" ") + "\n"));
    }
    text
}

#[test]
fn tool_vectors_are_turned_into_words_on_the_machine_as_the_request_has_it() {
    let shape = PassShape { lean_deg: 3.0, miss_deg: 1.0, motions: 240, decimals: 6, ..PassShape::PLAIN };
    let mut pass = pole_pass("ac-table", true, shape);
    // A machine whose measured errors do not count for this request.
    let mut parts = Preset::by_id("ac-table").expect("a preset").parts();
    for axis in &mut parts.rotary_axes {
        axis.travel_deg = None;
        axis.location_error.rotation_rad = Vec3::new(6e-4, -5e-4, 0.0);
    }
    pass.machine = Machine::new(parts).expect("a machine");
    pass.setup.apply_errors = false;
    let kinematics = Kinematics::new(&pass.machine, &pass.setup);
    let singularity = SingularityParameters::new(SingularityAction::Report);
    let (_, by_words) = treat(&pass, &singularity).expect("reported");
    pass.text = in_vectors(&pass, &kinematics);
    let (_, by_vectors) = treat(&pass, &singularity).expect("reported");
    let [[words], [vectors]] = [by_words.regions.as_slice(), by_vectors.regions.as_slice()] else {
        panic!("{:?} {:?}", by_words.regions, by_vectors.regions)
    };
    assert_eq!(words.motions, vectors.motions);
    // Six decimals of a degree, ten of a vector; the tilt would be 3e-2.
    let off_deg = (words.least_angle.deg() - vectors.least_angle.deg()).abs();
    assert!(off_deg < 1e-5, "{off_deg}");
}

#[test]
fn beside_a_point_without_a_normal_none_is_made_up() {
    // Found by fuzzing: what lay between was not a number.
    let machine = Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine");
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    let max_feed = Some(Feedrate::from_mm_per_min(1e6));
    let parameters = CcParameters { max_feed, ..CcParameters::new(tool, at_zero()) };
    let densify = SingularityParameters::new(SingularityAction::Densify);
    let go_on = || ControlFlow::Continue(());
    for [from, to] in [["0,0,0", "0,0.1,0.99"], ["0,0.1,0.99", "0,0,0"], ["0,0,0", "0,0,0"]] {
        let table = format!(
            "X,Y,Z,A,C,nx,ny,nz,F\n10.000,0.000,5.000,10.000,20.000,{from},900\n20.000,0.000,5.000,1.000,160.000,{to},900\n"
        );
        let mut output = Vec::new();
        let report = treat_singular_regions(
            &machine,
            &parameters,
            &densify,
            &table.as_bytes().to_vec(),
            &mut output,
            &go_on,
        );
        assert!(report.expect("densified").blocks_out > 3);
        let rows = String::from_utf8(output).expect("text");
        let made = rows.lines().skip(2).collect::<Vec<_>>();
        for row in &made[..made.len() - 1] {
            let normal: Vec<f64> =
                row.split(',').skip(5).take(3).map(|cell| cell.parse().expect("a number")).collect();
            assert_eq!(normal, [0.0; 3], "{row}");
        }
        // Where a contact is asked for, none is made up either.
        let asked = compensate(&machine, &parameters, &table.into_bytes(), &mut Vec::new(), &go_on);
        assert!(matches!(asked, Err(Fault::Lines(_))), "{asked:?}");
    }
}
