//! What nobody states is not assumed: the unit, the work offset, the places of the axes before the first block. Table
//! by table, what is refused, what is left alone, and what the caller reads of it.
#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, PRESETS, Side};
use trunnion::motion::{Interpolation, WorkOffset, WorkOffsets};
use trunnion::process::{
    CcParameters, CcReport, CompensationParameters, ContactSource, Fault, LineFaultKind, LineFaults,
    OffsetUse, ProgramSetup, SingularityAction, SingularityParameters, StartPosition, Unstated,
    VerificationParameters, Warning, WarningKind, WearParameters, WearReport, WornCutter, compensate,
    compensate_wear, treat_singular_regions, verify_part,
};
use trunnion::program::DiagnosticCode;
use trunnion::side_by_side::OneAfterAnother;
use trunnion::surface::SurfacePoint;
use trunnion::units::{Length, LengthUnit};

use crate::compensation::witness;
use crate::models::displaced::{errors, with_errors};
use crate::models::finishing::{FeedForm, Form, ac_machine, impeller_flank, tool};
use crate::models::set_ups::{at_zero, in_mm};
use crate::one_pass;

/// Millimetres, and nothing else.
pub(crate) fn in_mm_alone() -> ProgramSetup {
    ProgramSetup { unit: Some(LengthUnit::Millimetre), ..ProgramSetup::default() }
}

pub(crate) fn cc(
    machine: &Machine,
    parameters: &CcParameters,
    text: &str,
) -> Result<(String, CcReport), Fault> {
    let (mut output, source) = (Vec::new(), text.as_bytes().to_vec());
    let report = compensate(machine, parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

pub(crate) fn wear(
    machine: &Machine,
    parameters: &WearParameters,
    text: &str,
) -> Result<(String, WearReport), Fault> {
    let (mut output, source) = (Vec::new(), text.as_bytes().to_vec());
    let report = compensate_wear(machine, parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

pub(crate) fn warning(warnings: &[Warning], kind: WarningKind) -> Option<&Warning> {
    warnings.iter().find(|warning| warning.kind == kind)
}

fn by_tip(program: ProgramSetup) -> CcParameters {
    CcParameters { contact: ContactSource::Tip, ..CcParameters::new(tool(5.0, 5.0), program) }
}

// ---- The unit ------------------------------------------------------------------------------------------------------------

/// What refuses the program as a whole: line, column, code and text.
fn refusal(outcome: Result<(String, CcReport), Fault>) -> (u64, u32, DiagnosticCode, String) {
    match outcome {
        Err(Fault::Program(diagnostics)) => {
            let first = *diagnostics.refusals().next().expect("a refusal");
            (first.line, first.column, first.code, first.to_string())
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_unit_that_nobody_states_is_refused_at_the_first_dimensioned_word_with_the_cure() {
    let cases = [
        ("%\nO1\nG90 G94 G17\nT1 M6\nS9000 M3\nG0 X1.7224 Y0.\nM30\n", 6, 4, 'X'),
        ("G90 G94\nG0 A0. C0.\nG1 A5. Z1. F10.\nM30\n", 3, 8, 'Z'),
        ("G4 X2.\nG91 G28 Z0.\nG90 G1 Y3. F10.\nM30\n", 3, 8, 'Y'),
        ("%_N_P_MPF\nN10 G90 G94\nN20 G0 X1 Y2\nM30\n", 3, 8, 'X'),
        ("PARTNO/ P\nGOTO/1.,2.,3.,0.,0.,1.\nFINI\n", 2, 6, 'X'),
    ];
    for (text, line, column, address) in cases {
        let nothing = by_tip(ProgramSetup::default());
        let (at, from, code, said) = refusal(cc(&ac_machine(), &nothing, text));
        let DiagnosticCode::UnitUnknown { address: found } = code else { panic!("{text}{code:?}") };
        assert_eq!((at, from, format!("{found}")), (line, column, address.to_string()), "{text}{said}");
        assert!(said.contains("`unit`"), "{said}");
        // Whoever states it has it read.
        for unit in [LengthUnit::Millimetre, LengthUnit::Inch] {
            let stated = by_tip(ProgramSetup { unit: Some(unit), ..ProgramSetup::default() });
            let (output, report) = cc(&ac_machine(), &stated, text).unwrap_or_else(|fault| panic!("{fault}"));
            assert_eq!((output.as_str(), report.reading.unit), (text, Some(unit)));
            assert!(!report.reading.unit_is_stated, "{text}");
        }
    }
    // Angles have no such unit, and a program without a length needs none.
    let turning = "G90 G94\nG0 A0. C0.\nG1 A5. C9. F100.\nM30\n";
    let (output, report) = cc(&ac_machine(), &by_tip(ProgramSetup::default()), turning).expect("read");
    assert_eq!((output.as_str(), report.reading.unit), (turning, None));
}

/// Ways in which a text states its unit, with a cut after it.
const UNITS: [(&str, &str, LengthUnit); 8] = [
    ("G21 G90\n", "M30\n", LengthUnit::Millimetre),
    ("G20 G90\n", "M30\n", LengthUnit::Inch),
    ("%_N_P_MPF\nG71 G90\n", "M30\n", LengthUnit::Millimetre),
    ("%_N_P_MPF\nG70 G90\n", "M30\n", LengthUnit::Inch),
    ("%_N_P_MPF\nG710 G90\n", "M30\n", LengthUnit::Millimetre),
    ("%_N_P_MPF\nG700 G90\n", "M30\n", LengthUnit::Inch),
    ("BEGIN PGM P MM\n", "END PGM P MM\n", LengthUnit::Millimetre),
    ("BEGIN PGM P INCH\n", "END PGM P INCH\n", LengthUnit::Inch),
];

#[test]
fn what_the_text_says_of_its_unit_wins_over_what_the_caller_says_and_a_disagreement_is_a_warning() {
    for (head, end, unit) in UNITS {
        let cut = if head.starts_with("BEGIN") {
            "L X+1.0000 Y+0.0000 Z+1.7224 A+0.0000 C+0.0000 F100\nL X+2.0000\n"
        } else {
            "G1 X1.0000 Y0.0000 Z1.7224 A0.0000 C0.0000 F100.\nX2.0000\n"
        };
        let text = format!("{head}{cut}{end}");
        for stated in [None, Some(LengthUnit::Millimetre), Some(LengthUnit::Inch)] {
            let parameters = by_tip(ProgramSetup { unit: stated, ..ProgramSetup::default() });
            let (output, report) =
                cc(&ac_machine(), &parameters, &text).unwrap_or_else(|fault| panic!("{text}{fault}"));
            assert_eq!(output, text);
            assert_eq!((report.reading.unit, report.reading.unit_is_stated), (Some(unit), true), "{text}");
            assert!(
                (report.cc_path_length_mm - unit.mm()).abs() < 1e-9,
                "{text} {}",
                report.cc_path_length_mm
            );
            let disagrees = warning(&report.warnings, WarningKind::UnitDisagrees);
            let line = head.lines().count() as u64;
            assert_eq!(
                disagrees.map(|warning| (warning.count, warning.line)),
                stated.is_some_and(|stated| stated != unit).then_some((1, Some(line))),
                "{text} {stated:?}"
            );
        }
    }
}

#[test]
fn a_tool_two_tenths_shorter_moves_an_inch_program_by_79_ten_thousandths_of_an_inch() {
    let body = "G90 G94 G17\nG0 X0.0000 Y0.0000 Z3.0000 A0.0000 C0.0000\nG1 Z1.7224 F20.\nX2.0000\nM30\n";
    let shorter = |unit| WearParameters {
        shorter_by: Length::from_mm(0.2),
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(
            tool(5.0, 5.0),
            WornCutter::Tool(tool(5.0, 5.0)),
            ProgramSetup { unit, ..ProgramSetup::default() },
        )
    };
    let refused = wear(&ac_machine(), &shorter(None), body);
    assert!(matches!(&refused, Err(Fault::Program(_))), "{refused:?}");
    for (unit, head) in
        [(Some(LengthUnit::Inch), ""), (None, "G20\n"), (Some(LengthUnit::Millimetre), "G20\n")]
    {
        let text = format!("{head}{body}");
        let (output, _) =
            wear(&ac_machine(), &shorter(unit), &text).unwrap_or_else(|fault| panic!("{fault}"));
        // 0.2 mm are 0.0079 inch.
        let expected = text.replace("Z1.7224", "Z1.7145").replace("Z3.0000", "Z2.9921");
        assert_eq!(output, expected);
    }
}

// ---- Work offset and tool length -----------------------------------------------------------------------------------------

const GO_ON: &(dyn Fn() -> ControlFlow<()> + Sync) = &|| ControlFlow::Continue(());

/// The machines with a table axis, a head axis, both.
fn machines() -> Vec<(Machine, [bool; 2])> {
    let machine = |preset: &trunnion::machine::Preset| {
        let machine = Machine::new(preset.parts()).expect("a machine");
        let has = |side| machine.rotary_axes().iter().any(|axis| axis.side == side);
        let sides = [has(Side::Table), has(Side::Head)];
        (machine, sides)
    };
    PRESETS.iter().map(machine).collect()
}

/// A cut that turns no axis, then one that does, on a machine with these letters.
fn turning_at_line_4(machine: &Machine) -> String {
    let [a, c] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    format!(
        "G21 G90 G94 G17\nG0 X10.000 Y5.000 Z20.000 {a}0.000 {c}0.000\nG1 X11.000 F1000\nX12.000 {a}5.000 {c}8.000\nM30\n"
    )
}

type Operation<'a> = (&'a str, Box<dyn Fn(&Machine, ProgramSetup, &str) -> Result<(), Fault>>);

/// Everything whose result depends on where the part is once a rotary axis turns.
fn operations() -> Vec<Operation<'static>> {
    let source = |text: &str| text.as_bytes().to_vec();
    vec![
        ("cc", Box::new(|machine, program, text| cc(machine, &by_tip(program), text).map(drop))),
        (
            "singularity",
            Box::new(move |machine, program, text| {
                let action = SingularityParameters::new(SingularityAction::Report);
                let parameters = by_tip(program);
                treat_singular_regions(machine, &parameters, &action, &source(text), &mut Vec::new(), GO_ON)
                    .map(drop)
            }),
        ),
        (
            "verification",
            Box::new(move |machine, program, text| {
                let sample = SurfacePoint { point_mm: Vec3::new(11.0, 5.0, 20.0), normal: Vec3::z() };
                let parameters = VerificationParameters::new(tool(5.0, 5.0), program);
                verify_part(machine, &parameters, &[sample], &source(text), &OneAfterAnother, GO_ON).map(drop)
            }),
        ),
    ]
}

fn lines(outcome: Result<(), Fault>, told: &str) -> LineFaults {
    match outcome {
        Err(Fault::Lines(faults)) => faults,
        other => panic!("{told}: {other:?}"),
    }
}

#[test]
fn silence_on_offset_and_length_is_refused_where_an_axis_turns_and_zero_is_an_answer() {
    for (machine, [has_table, has_head]) in machines() {
        let text = turning_at_line_4(&machine);
        let upright: String = text.split_inclusive('\n').filter(|line| !line.starts_with("X12")).collect();
        let only_offset = ProgramSetup { work_offsets: at_zero().work_offsets, ..in_mm_alone() };
        let only_length = ProgramSetup { tools: at_zero().tools, ..in_mm_alone() };
        for (operation, run) in operations() {
            for (program, missing) in [
                (in_mm_alone(), if has_table { Some("work_offset_mm") } else { Some("tool_length_mm") }),
                (only_offset.clone(), has_head.then_some("tool_length_mm")),
                (only_length.clone(), has_table.then_some("work_offset_mm")),
                (at_zero(), None),
            ] {
                let told = format!("{operation} on {} {missing:?}", machine.name());
                let outcome = run(&machine, program.clone(), &text);
                if let Some(member) = missing {
                    let faults = lines(outcome, &told);
                    let LineFaultKind::Unstated(unstated) = &faults.kept[0].kind else {
                        panic!("{told}: {faults:?}")
                    };
                    assert_eq!(
                        (faults.total, faults.kept[0].line, unstated.member()),
                        (1, 4, member),
                        "{told}"
                    );
                    assert!(unstated.to_string().contains(&format!("give `{member}`")), "{told}: {unstated}");
                } else {
                    outcome.unwrap_or_else(|fault| panic!("{told}: {fault}"));
                }
                // Who interpolates on the tip has the control know where it is, and where nothing turns nothing
                // depends on it.
                let tcp = ProgramSetup { interpolation: Some(Interpolation::Tcp), ..program.clone() };
                run(&machine, tcp, &text).unwrap_or_else(|fault| panic!("{told} by TCP: {fault}"));
                run(&machine, program, &upright).unwrap_or_else(|fault| panic!("{told} upright: {fault}"));
            }
        }
    }
}

#[test]
fn a_program_posted_for_a_machine_as_it_is_needs_its_offset_for_every_motion() {
    let machine = with_errors(&ac_machine(), errors());
    let still = "G21 G90 G94 G17\nG0 X10.000 Y5.000 Z20.000 A20.000 C30.000\nG1 X11.000 F1000\nM30\n";
    let location =
        |program| CompensationParameters { location_errors: true, ..CompensationParameters::new(program) };
    let Err(Fault::Lines(faults)) = one_pass::run(&machine, &location(in_mm_alone()), still) else {
        panic!("refused")
    };
    assert_eq!((faults.total, faults.kept[0].line), (2, 2), "{faults:?}");
    assert!(
        matches!(faults.kept[0].kind, LineFaultKind::Unstated(Unstated::WorkOffset { .. })),
        "{faults:?}"
    );
    let (output, _, _) = one_pass::done(&machine, &location(at_zero()), still);
    assert_ne!(output, still);
}

#[test]
fn what_is_reported_with_the_true_offset_is_what_the_witness_measures_there() {
    let mut part = impeller_flank(ac_machine(), tool(5.0, 5.0), 12, 3);
    let text = part.program(Form::ContactWords, FeedForm::InverseTime);
    let with = |work_offset_mm: Vec3| {
        let setup = Setup { work_offset_mm, ..Setup::default() };
        CcParameters { program: in_mm(&setup), ..CcParameters::new(part.tool, at_zero()) }
    };
    let (true_offset, zero) = (Vec3::new(5.0, -8.0, 40.0), Vec3::zeros());
    let outcomes =
        [true_offset, zero].map(|offset| cc(&part.machine, &with(offset), &text).expect("compensated"));
    let silent = CcParameters { program: in_mm_alone(), ..with(zero) };
    let Err(Fault::Lines(faults)) = cc(&part.machine, &silent, &text) else { panic!("refused") };
    assert!(
        faults
            .kept
            .iter()
            .all(|fault| matches!(fault.kind, LineFaultKind::Unstated(Unstated::WorkOffset { .. }))),
        "{faults:?}"
    );
    let mut largest = |offset: Vec3, output: &str| {
        part.setup.work_offset_mm = offset;
        let verdicts = witness(&part, false).judge(&text, output, 200);
        let of = |value: fn(&crate::models::witness::Verdict) -> f64| {
            verdicts.iter().map(value).fold(0.0, f64::max)
        };
        [of(|verdict| verdict.before), of(|verdict| verdict.after)]
    };
    for ((output, report), offset) in outcomes.iter().zip([true_offset, zero]) {
        let [before, after] = largest(offset, output);
        for (ours, theirs) in [(report.before.max_mm, before), (report.after.max_mm, after)] {
            assert!(
                (ours - theirs).abs() <= WITNESS_SHARE * theirs + ARITHMETIC_MM,
                "{offset:?}: {ours} {theirs}"
            );
        }
        assert!(report.after.max_mm <= 0.01);
    }
    // What was computed for zero runs elsewhere on the machine, and there it keeps nothing.
    let [(_, by_truth), (for_zero, by_zero)] = &outcomes;
    let [_, truth] = largest(true_offset, for_zero);
    println!("after {} um by zero, in truth {} um", by_zero.after.max_mm * 1e3, truth * 1e3);
    assert!(truth > 10.0 * by_zero.after.max_mm, "{truth} {:?}", by_zero.after);
    assert!(
        (by_truth.before.max_mm - by_zero.before.max_mm).abs() > 1e-3,
        "{:?} {:?}",
        by_truth.before,
        by_zero.before
    );
}

/// The witness' sums and ours differ by rounding only [mm].
const ARITHMETIC_MM: f64 = 1e-8;
/// The witness samples 200 steps a part: what lies between is below this share of a maximum.
const WITNESS_SHARE: f64 = 1e-3;

/// A cut to be divided, from a point of its own.
const SECTION: &str =
    "G0 X50.000 Y0.000 Z0.000 A0.000 C0.000\nG1 X50.000 Y20.000 A20.000 C20.000 F1000\nG0 Z80.000\n";

fn named(offsets: &[(&str, [f64; 3])]) -> BTreeMap<WorkOffset, [f64; 3]> {
    offsets.iter().map(|(name, offset)| (WorkOffset::from_name(name).expect("a name"), *offset)).collect()
}

#[test]
fn several_offsets_that_are_stated_by_name_are_followed_each_at_its_place() {
    let pairs = [("G54", "G55"), ("G54.1 P3", "G54.1 P4"), ("G59.1", "G59.3"), ("G15 H1", "G15 H2")];
    let (first_mm, second_mm) = ([5.0, -8.0, 40.0], [-60.0, 12.0, 95.0]);
    let compensated = |offsets: WorkOffsets, text: &str| {
        let parameters = by_tip(ProgramSetup { work_offsets: Arc::new(offsets), ..in_mm_alone() });
        cc(&ac_machine(), &parameters, text).unwrap_or_else(|fault| panic!("{text}{fault}"))
    };
    for (first, second) in pairs {
        let both = named(&[(first, first_mm), (second, second_mm)]);
        let text = format!("G21 G90 G94\n{first}\n{SECTION}{second}\n{SECTION}M30\n");
        let alone = |offset_mm: [f64; 3]| {
            let text = format!("G21 G90 G94\n{SECTION}");
            compensated(WorkOffsets::only(offset_mm), &text).0.replace("G21 G90 G94\n", "")
        };
        let expected =
            format!("G21 G90 G94\n{first}\n{}{second}\n{}M30\n", alone(first_mm), alone(second_mm));
        assert_ne!(alone(first_mm), alone(second_mm));
        // By the request, by the machine, and the machine's overruled.
        let wrong = named(&[(first, [0.0; 3]), (second, [1.0; 3])]);
        for offsets in [
            WorkOffsets { named_mm: both.clone(), ..WorkOffsets::default() },
            WorkOffsets { of_machine_mm: both.clone(), ..WorkOffsets::default() },
            WorkOffsets { named_mm: both.clone(), of_machine_mm: wrong, only_mm: Some([9.0; 3]) },
        ] {
            let (output, report) = compensated(offsets, &text);
            assert_eq!(output, expected, "{first} {second}");
            let used: Vec<_> = report
                .reading
                .work_offsets
                .iter()
                .map(|used| (used.offset, used.is_left_alone, used.lines))
                .collect();
            let name = |name: &str| WorkOffset::from_name(name);
            assert_eq!(
                used,
                [(name(first), false, [3, 5]), (name(second), false, [7, 9])],
                "{first} {second}"
            );
        }
    }
}

#[test]
fn an_offset_that_is_not_given_leaves_the_motions_alone_from_there_and_the_reading_has_the_lines() {
    let text = format!("G21 G90 G94\nG54\n{SECTION}G55\n{SECTION}{SECTION}M30\n");
    for offsets in [
        WorkOffsets::only([5.0, -8.0, 40.0]),
        WorkOffsets { named_mm: named(&[("G54", [5.0, -8.0, 40.0])]), ..WorkOffsets::default() },
    ] {
        let parameters = by_tip(ProgramSetup { work_offsets: Arc::new(offsets), ..in_mm_alone() });
        let (output, report) = cc(&ac_machine(), &parameters, &text).expect("compensated");
        let (_, left_alone) = output.split_once("G55\n").expect("the second offset");
        assert_eq!(left_alone, format!("{SECTION}{SECTION}M30\n"));
        assert!(report.blocks_out > report.blocks_in, "the first section is compensated");
        let second = OffsetUse {
            offset: WorkOffset::from_name("G55"),
            is_only: false,
            is_left_alone: true,
            lines: [7, 12],
            motions: 6,
        };
        assert_eq!(report.reading.work_offsets.get(1), Some(&second), "{:?}", report.reading);
        assert_eq!(report.reading.work_offsets.len(), 2);
        let told = warning(&report.warnings, WarningKind::WorkOffsetChanged).expect("a warning");
        assert_eq!((told.count, told.line), (2, Some(8)));
    }
    // And with none stated at all the first is missing.
    let Err(Fault::Lines(faults)) = cc(&ac_machine(), &by_tip(in_mm_alone()), &text) else {
        panic!("refused")
    };
    assert_eq!(faults.kept[0].line, 4);
    let name = WorkOffset::from_name("G54");
    assert_eq!(faults.kept[0].kind, LineFaultKind::Unstated(Unstated::WorkOffset { name }));
}

// ---- Where the axes stand at the start -----------------------------------------------------------------------------------

fn standing_at(linear_mm: [Option<f64>; 3], rotary_deg: [Option<f64>; 2]) -> ProgramSetup {
    ProgramSetup { start: StartPosition { linear_mm, rotary_deg }, ..at_zero() }
}

#[test]
fn a_start_lets_programs_of_three_and_four_axes_be_followed_from_their_first_block() {
    // Three axes: nothing ever says where the rotary axes stand.
    let three = "G21 G90 G94\nG1 X10.000 Y0.000 Z5.000 F500\nX20.000\nM30\n";
    // Four: C is never said, and A turns enough to be divided.
    let four = "G21 G90 G94\nG1 X50.000 Y20.000 Z0.000 A25.000 F1000\nX40.000 A0.000\nM30\n";
    for (text, unknown) in [(three, 2), (four, 2)] {
        let (output, report) = cc(&ac_machine(), &by_tip(at_zero()), text).expect("read");
        assert_eq!((output.as_str(), report.motions_checked), (text, 0));
        assert!(warning(&report.warnings, WarningKind::NothingChecked).is_some(), "{report:?}");
        // Part of it is not enough, all of it is.
        for (linear, rotary, checked) in [
            ([None; 3], [Some(0.0), None], 0),
            ([None; 3], [Some(0.0), Some(0.0)], unknown - 1),
            ([Some(50.0), Some(0.0), Some(0.0)], [Some(0.0), Some(0.0)], unknown),
        ] {
            let (_, report) = cc(&ac_machine(), &by_tip(standing_at(linear, rotary)), text).expect("read");
            assert_eq!(report.motions_checked, checked, "{text}{linear:?} {rotary:?}");
        }
    }
    // What is stated is as if the program had said it itself.
    let start = standing_at([Some(50.0), Some(0.0), Some(0.0)], [Some(0.0), Some(30.0)]);
    for text in [three, four] {
        let said = text.replacen("G94\n", "G94\nG0 X50.000 Y0.000 Z0.000 A0.000 C30.000\n", 1);
        let (stated, report) = cc(&ac_machine(), &by_tip(start.clone()), text).expect("compensated");
        let (written, same) = cc(&ac_machine(), &by_tip(at_zero()), &said).expect("compensated");
        assert_eq!(stated.replacen("G94\n", "G94\nG0 X50.000 Y0.000 Z0.000 A0.000 C30.000\n", 1), written);
        assert_eq!((report.before.max_mm, report.after.max_mm), (same.before.max_mm, same.after.max_mm));
        assert_eq!(stated == text, text == three, "{stated}");
    }
}
