//! Laws of programs for worn cutters, seen by an independent witness: rotation matrices, and the cutters written out.
#![expect(
    clippy::panic,
    clippy::float_cmp,
    reason = "a test may stop at what it did not expect; words that were copied are the same to the bit"
)]

use std::fmt::Write;
use std::ops::ControlFlow;

use proptest::prelude::*;
use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup};
use trunnion::machine::{RotaryAxis, Tool};
use trunnion::motion::Interpolation;
use trunnion::process::{
    ContactSource, Fault, LengthInControl, LineFaultKind, Milling, ToolUnknown, WearParameters, WearReport,
    WornCutter, compensate_wear,
};
use trunnion::program::Dialect;
use trunnion::units::{Angle, Length};
use trunnion::wear::WearTable;

use super::compensation::witness;
use super::machines::{any_machine, preset_machine, setup};
use crate::models::finishing::{
    FeedForm, Finishing, Form, ac_machine, blade, dome_near_pole, impeller_flank, tool, wall,
};
use crate::models::set_ups::{at_zero, in_mm, with_tool};
use crate::models::witness::{Line, Tables, scan};
use trunnion::process::ProgramSetup;

/// Half a unit of four decimals on three axes, once for the words written, and half as much again for the normal that
/// words of four decimals give [mm].
const ROUNDED_MM: f64 = 1.5 * 0.866_025_404e-4;
/// What rounding leaves between the words of a tip and those of its contact [mm].
const WORDS_MM: f64 = 1.3e-4;
/// A unit of four decimals there, and one back [mm].
const THERE_AND_BACK_MM: f64 = 2.0e-4 + 1e-9;
/// F words keep three digits (share).
const TIME_SHARE: f64 = 0.006;

fn worn(part: &Finishing, actual: Tool) -> WearParameters {
    WearParameters {
        program: in_mm(&part.setup),
        ..WearParameters::new(part.tool, WornCutter::Tool(actual), at_zero())
    }
}

fn run(part: &Finishing, parameters: &WearParameters, text: &str) -> Result<(String, WearReport), Fault> {
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    let go_on = || ControlFlow::Continue(());
    let report = compensate_wear(&part.machine, parameters, &source, &mut output, &go_on)?;
    Ok((String::from_utf8(output).expect("text"), report))
}

fn done(part: &Finishing, parameters: &WearParameters, text: &str) -> (String, WearReport) {
    run(part, parameters, text).unwrap_or_else(|fault| panic!("{}: {fault:?}", part.name))
}

/// A plain program of our own on the machine of tests.
fn plain(parameters: &WearParameters, text: &str) -> Result<(String, WearReport), Fault> {
    let part = blade(ac_machine(), parameters.nominal.expect("a cutter"), 3, 1);
    run(&part, parameters, text)
}

fn parts(tool: Tool) -> [Finishing; 3] {
    [
        blade(ac_machine(), tool, 25, 3),
        impeller_flank(ac_machine(), tool, 30, 3),
        dome_near_pole(ac_machine(), tool, 41, 3),
    ]
}

/// Where a cutter with its tip here touches the surface with this normal, written out.
fn touched(tool: Tool, tip: Vec3, t: Vec3, n: Vec3) -> Vec3 {
    let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
    let across = n - t * n.dot(&t);
    let m = if core > 0.0 { across.normalize() } else { Vec3::zeros() };
    tip - n * corner - m * core + t * corner
}

/// Every point's contact of both cutters, from the texts alone.
fn contacts_agree(
    part: &Finishing,
    tables: &Tables,
    actual: Tool,
    texts: [&str; 2],
    shorter_mm: f64,
    flank: bool,
) {
    let [source, output] = texts.map(|text| scan(text, tables.letters));
    assert_eq!((source.len(), output.len()), (part.points.len(), part.points.len()));
    let mut moved = 0;
    for ((point, before), after) in part.points.iter().zip(&source).zip(&output) {
        assert!(before.angle == after.angle, "{}", after.number);
        let place = |tool: Tool, line: &Line, shorter_mm: f64| {
            let (tip, t) = tables.forward(line.q, line.angle);
            let tip = tip + t * shorter_mm;
            if flank {
                let m = (point.normal - t * point.normal.dot(&t)).normalize();
                return tip - m * tool.radius().mm() + t * part.tool.corner_radius().mm();
            }
            touched(tool, tip, t, point.normal)
        };
        let (nominal, worn) = (place(part.tool, before, 0.0), place(actual, after, shorter_mm));
        let off_mm = (nominal - worn).norm();
        // The side of a contact near the axis is known as well as its words give it.
        let (tip, t) = tables.forward(before.q, before.angle);
        let from_axis_mm = { (nominal - tip) - t * (nominal - tip).dot(&t) }.norm();
        let core_mm = |tool: Tool| tool.core_radius().mm();
        let side_mm = (core_mm(actual) - core_mm(part.tool)).abs() * WORDS_MM / from_axis_mm;
        assert!(off_mm <= ROUNDED_MM + side_mm, "{} {}: {off_mm} mm", part.name, after.number);
        moved += usize::from(before.q != after.q);
    }
    assert!(moved * 10 > part.points.len() * 9, "{moved} moved");
}

#[test]
fn a_worn_cutter_touches_every_point_that_the_nominal_one_touched() {
    for (nominal, actual) in [
        (tool(5.0, 5.0), tool(4.0, 4.0)),
        (tool(5.0, 5.0), tool(4.5, 4.5)),
        (tool(5.0, 5.0), tool(4.75, 4.75)),
        (tool(5.0, 3.0), tool(4.75, 2.75)),
        (tool(5.0, 1.0), tool(4.6, 0.8)),
        (tool(5.0, 5.0), tool(5.1, 4.9)),
        (tool(5.0, 0.0), tool(4.9, 0.0)),
    ] {
        for part in parts(nominal) {
            for form in [Form::ContactWords, Form::Tcp, Form::NormalTable] {
                let text = part.program(form, FeedForm::PerMinute);
                // A point on a sharp edge says nothing of the normal, and none is needed.
                let (output, report) = done(&part, &worn(&part, actual), &text);
                assert_eq!(report.blocks_in, report.blocks_out);
                assert_eq!(report.contacts_kept, part.points.len() as u64);
                assert!(report.after.max_mm <= ROUNDED_MM && report.before.max_mm > 0.0, "{report:?}");
                if form != Form::NormalTable {
                    let tables = witness(&part, form == Form::Tcp);
                    contacts_agree(&part, &tables, actual, [&text, &output], 0.0, false);
                }
            }
        }
    }
}

#[test]
fn a_worn_flank_touches_every_point_too_and_moves_across_the_axis() {
    for (nominal, actual) in [(tool(5.0, 0.0), tool(4.9, 0.0)), (tool(5.0, 1.0), tool(4.75, 0.8))] {
        let part = wall(ac_machine(), nominal, 25, 2);
        for form in [Form::ContactWords, Form::Tcp, Form::NormalTable] {
            let text = part.program(form, FeedForm::PerMinute);
            let parameters = WearParameters { milling: Milling::Side, ..worn(&part, actual) };
            let (output, report) = done(&part, &parameters, &text);
            assert_eq!(report.contacts_kept, part.points.len() as u64);
            if form != Form::NormalTable {
                let tables = witness(&part, form == Form::Tcp);
                contacts_agree(&part, &tables, actual, [&text, &output], 0.0, true);
            }
        }
        let end =
            run(&part, &worn(&part, tool(4.0, 0.5)), &part.program(Form::NormalTable, FeedForm::PerMinute));
        assert!(end.is_ok(), "a flank's normal is a corner's too");
    }
    let part = blade(ac_machine(), tool(5.0, 1.0), 10, 1);
    let parameters = WearParameters { milling: Milling::Side, ..worn(&part, tool(4.9, 1.0)) };
    let Err(Fault::Lines(faults)) =
        run(&part, &parameters, &part.program(Form::NormalTable, FeedForm::PerMinute))
    else {
        panic!("the blade's normals are not across the axis")
    };
    assert_eq!((faults.total, faults.kept[0].line), (10, 2));
    let plain = part.program(Form::Plain, FeedForm::PerMinute);
    assert!(matches!(run(&part, &parameters, &plain), Err(Fault::ContactUnknown { milling: "side" })));
    let by_feed = WearParameters { contact: ContactSource::FeedPlane, ..parameters };
    assert!(matches!(run(&part, &by_feed, &plain), Err(Fault::UnfitContact { .. })));
}

#[test]
fn a_shorter_cutter_is_fed_farther_where_the_control_does_not_know() {
    let actual = tool(4.75, 4.75);
    for part in parts(tool(5.0, 5.0)) {
        for form in [Form::ContactWords, Form::Tcp] {
            let text = part.program(form, FeedForm::PerMinute);
            for shorter_mm in [0.3, -0.2] {
                let shorter_by = Length::from_mm(shorter_mm);
                let parameters = WearParameters { shorter_by, ..worn(&part, actual) };
                let (output, _) = done(&part, &parameters, &text);
                let tables = witness(&part, form == Form::Tcp);
                contacts_agree(&part, &tables, actual, [&text, &output], shorter_mm, false);
                // With the measured length in the control of a table machine nothing is missing.
                let known =
                    WearParameters { length_in_control: LengthInControl::Measured, ..parameters.clone() };
                let without = WearParameters { shorter_by: Length::ZERO, ..parameters };
                assert_eq!(done(&part, &known, &text).0, done(&part, &without, &text).0);
            }
        }
    }
}

#[test]
fn no_wear_is_no_change_of_any_byte() {
    for nominal in [tool(5.0, 5.0), tool(5.0, 1.0), tool(5.0, 0.0)] {
        for part in parts(nominal) {
            for form in [Form::Plain, Form::ContactWords, Form::Tcp, Form::NormalTable] {
                for feed in [FeedForm::PerMinute, FeedForm::InverseTime] {
                    let text = part.program(form, feed).replace('\n', "\r\n");
                    let (output, report) = done(&part, &worn(&part, nominal), &text);
                    assert!(output == text, "{} {form:?}", part.name);
                    assert_eq!((report.blocks_changed, report.motions_shifted), (0, 0));
                }
            }
        }
    }
}

#[test]
fn worn_and_reground_back_is_the_source_but_for_rounding() {
    let (nominal, actual) = (tool(5.0, 3.0), tool(4.75, 2.75));
    for part in parts(nominal) {
        for form in [Form::ContactWords, Form::Tcp] {
            let text = part.program(form, FeedForm::PerMinute);
            let (there, _) = done(&part, &worn(&part, actual), &text);
            let back = Finishing { tool: actual, ..part.clone() };
            let (back, _) = done(&back, &worn(&back, nominal), &there);
            let letters = ['A', 'C'];
            for (source, back) in scan(&text, letters).iter().zip(&scan(&back, letters)) {
                assert!((source.q - back.q).amax() <= THERE_AND_BACK_MM, "{} {}", source.number, back.number);
                assert!(source.uvw == back.uvw && source.angle == back.angle);
            }
        }
    }
}

#[test]
fn a_table_of_one_deviation_is_a_ball_of_another_radius() {
    let part = blade(ac_machine(), tool(5.0, 5.0), 25, 2);
    let table = |entries: &[(f64, f64)]| {
        let entries: Vec<_> =
            entries.iter().map(|(deg, mm)| (Angle::from_deg(*deg), Length::from_mm(*mm))).collect();
        WornCutter::Table(WearTable::new(&entries).expect("a table"))
    };
    let with = |worn_cutter| WearParameters { worn: Some(worn_cutter), ..worn(&part, part.tool) };
    for form in [Form::ContactWords, Form::NormalTable] {
        let text = part.program(form, FeedForm::PerMinute);
        let (by_table, _) = done(&part, &with(table(&[(0.0, -0.25), (90.0, -0.25)])), &text);
        let (by_tool, _) = done(&part, &worn(&part, tool(4.75, 4.75)), &text);
        assert_eq!(by_table, by_tool);
        assert_eq!(done(&part, &with(table(&[(0.0, 0.0), (90.0, 0.0)])), &text).0, text);
        // The blade's contacts stand at 60°.
        let Err(Fault::Lines(faults)) = run(&part, &with(table(&[(0.0, 0.0), (50.0, -0.1)])), &text) else {
            panic!("beyond the table")
        };
        assert_eq!(faults.total, part.points.len() as u64);
        assert!(matches!(faults.kept[0].kind, LineFaultKind::Shift(_)));
    }
}

#[test]
fn the_report_tells_what_was_left_and_what_is() {
    let part = blade(ac_machine(), tool(5.0, 5.0), 25, 3);
    let text = part.program(Form::ContactWords, FeedForm::PerMinute);
    let (_, report) = done(&part, &worn(&part, tool(4.75, 4.75)), &text);
    // 60° between normal and axis: 0.25·(1 − cos 60°), and a shift of 2·0.25·sin 30°.
    assert!((report.before.max_excess_mm - 0.125).abs() < 1e-4, "{:?}", report.before);
    assert!((report.max_shift.mm() - 0.25).abs() < 1e-4 && report.before.max_gouge_mm <= 0.0);
    let [least, most] = report.contact_angles.expect("contacts").map(Angle::deg);
    assert!((least - 60.0).abs() < 0.01 && (most - 60.0).abs() < 0.01);
    assert_eq!(report.motions_shifted, part.points.len() as u64);
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    assert_eq!(report.series.points().len(), part.points.len());
    // A tool that is not the one the program was made for.
    let other = WearParameters { nominal: Some(tool(6.0, 6.0)), ..worn(&part, tool(4.75, 4.75)) };
    let (_, report) = done(&part, &other, &text);
    let off = report.warnings.iter().find(|warning| warning.kind.name() == "contact_off_tool").expect("told");
    assert!(off.max_distance_mm.is_some_and(|off_mm| off_mm > 0.3) && off.count == 75, "{off:?}");
}

fn word(line: &str, letter: char) -> Option<f64> {
    line.split(' ').find_map(|word| word.strip_prefix(letter)).and_then(|number| number.parse().ok())
}

fn ball_by_feed(shape: (f64, f64)) -> WearParameters {
    let (nominal, actual) = shape;
    let worn = WornCutter::Tool(tool(actual, actual));
    WearParameters {
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(tool(nominal, nominal), worn, at_zero())
    }
}

#[test]
fn a_block_that_only_turned_keeps_its_time_when_it_gains_a_path() {
    // U V W of the points turn with C: the second block has no linear word, and gains a little X and Y.
    let text = "G90 G21 G94\nG1 X10.000 Y0.000 Z20.000 A-30.000 C0.000 U10.000 V-4.330 W22.500 F720.\n\
                C15.000 U9.000 V-4.330 W22.500\nX12.000 C16.000 U11.000 V-4.330 W22.500\n\
                G65 P9010\nM30\n";
    let nominal = tool(5.0, 5.0);
    let parameters = WearParameters::new(nominal, WornCutter::Tool(tool(4.5, 4.5)), at_zero());
    let (output, report) = plain(&parameters, &text.replace("G65 P9010\n", "")).expect("a program");
    let lines: Vec<&str> = output.lines().collect();
    assert_eq!(report.feeds_lowered, 1, "{output}");
    let (first, second, third) =
        (scan(&output, ['A', 'C'])[0].clone(), scan(&output, ['A', 'C'])[1].clone(), lines[3]);
    let path_mm = (second.q - first.q).norm();
    assert!(path_mm > 0.01, "{output}");
    // 15° at 720 °/min are 1.25 s.
    let feed = word(lines[2], 'F').expect("F");
    assert!((path_mm / feed * 60.0 / 1.25 - 1.0).abs() < TIME_SHARE, "{output}");
    // and what follows runs at the source's number again
    assert_eq!(word(third, 'F'), Some(720.0), "{output}");
    // In G93 the time stands in the block.
    let inverse = text.replace("G65 P9010\n", "").replace("G94", "G93").replace(" F720.", "");
    let inverse: String = inverse
        .lines()
        .map(|line| if line.contains('U') { format!("{line} F48.\n") } else { format!("{line}\n") })
        .collect();
    let (output, report) = plain(&parameters, &inverse).expect("a program");
    assert_eq!((report.feeds_lowered, output.matches("F48.\n").count()), (0, 3), "{output}");
    // An unknown F cannot be given another meaning.
    let unknown = text.replace("G65 P9010\n", "").replace("F720.", "F#1");
    assert!(
        matches!(plain(&parameters, &unknown), Err(Fault::Lines(_))),
        "{:?}",
        plain(&parameters, &unknown)
    );
    // F0 and a negative F are no speed, so no lower one can be written.
    for feed in ["F0.", "F-720."] {
        let no_speed = text.replace("G65 P9010\n", "").replace("F720.", feed);
        let Err(Fault::Lines(faults)) = plain(&parameters, &no_speed) else { panic!("{feed}") };
        assert_eq!((faults.total, faults.kept[0].line), (1, 3), "{faults:?}");
        assert!(matches!(faults.kept[0].kind, LineFaultKind::FeedTooSmall { .. }), "{faults:?}");
    }
    // A call behind a moved point starts from where the source never was.
    let Err(Fault::Lines(faults)) = plain(&parameters, text) else { panic!("a call behind a moved point") };
    assert_eq!((faults.total, faults.kept[0].line), (1, 5));
}

#[test]
fn a_feed_lowered_at_the_end_is_given_back_to_a_call() {
    let text = "G90 G21 G94\nG1 X10.000 Y0.000 Z20.000 A-30.000 C0.000 U10.000 V-4.330 W22.500 F720.\n\
                C15.000 U9.000 V-4.330 W22.500\nG0 Z100.000\nX10.000 Y0.000\nG65 P9010\nM30\n";
    let parameters = WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)), at_zero());
    let (output, report) = plain(&parameters, text).expect("a program");
    assert!(output.contains("\nF720.\nG65 P9010\n"), "{output}");
    assert_eq!((report.blocks_out, report.feeds_restored), (report.blocks_in + 1, 1));
}

#[test]
fn an_f_between_two_lowered_blocks_changes_neither() {
    let text = "G90 G21 G94\nG1 X10.000 Y0.000 Z20.000 A-30.000 C0.000 U10.000 V-4.330 W22.500 F720.\n\
                C15.000 U9.000 V-4.330 W22.500\nF720.\nC0.000 U10.000 V-4.330 W22.500\nF720.\nX11.000 U11.000 V-4.330 W22.500\nM30\n";
    let parameters = WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)), at_zero());
    let (output, report) = plain(&parameters, text).expect("a program");
    let feeds: Vec<f64> =
        output.lines().filter(|line| line.contains('U')).map(|line| word(line, 'F').expect("F")).collect();
    assert_eq!(report.feeds_lowered, 2);
    assert!(feeds[1] < 100.0 && (feeds[1] / feeds[2] - 1.0).abs() < TIME_SHARE, "{output}");
    assert!((feeds[0] - 720.0).abs() < 1e-9 && (feeds[3] - 720.0).abs() < 1e-9, "{output}");
}

/// A pass on which the table turns, from `x`.
fn pass_from(x: &str) -> String {
    format!("G0 X{x}.000 Y0.000 Z20.000 A-30.000 C0.000\nG1 Y10.000 Z24.000 A-31.000 F800\nG0 Z90.000\n")
}

#[test]
fn a_program_of_several_tools_is_refused_until_the_worn_one_is_named() {
    let refused = |text: &str| match plain(&ball_by_feed((5.0, 4.5)), text) {
        Ok(_) => None,
        Err(Fault::Tool(ToolUnknown::Several { count: 2, tools, is_for_one: true })) => Some(tools),
        Err(fault) => panic!("{fault}"),
    };
    let two_tools = |tools: &str| Some(tools.to_owned());
    let [one, two] = [pass_from("0"), pass_from("5")];
    assert_eq!(refused(&format!("T1 M6\n{one}T2\n{two}M30\n")), None, "T2 is only made ready");
    assert_eq!(refused(&format!("T1 M6\n{one}T1 M6\n{two}M30\n")), None, "the same tool again");
    assert_eq!(refused(&format!("T1 M6\n{one}T2\nM6\n{two}M30\n")), two_tools("T1, T2"));
    let first = refused(&format!("{one}T1 M6\n{two}M30\n"));
    assert_eq!(first, two_tools("the tool in the spindle at the start, T1"));
    // Values are not known.
    let unknown = refused(&format!("T[#1] M6\n{one}T[#1] M6\n{two}M30\n"));
    assert_eq!(unknown, two_tools("a tool that the text does not name, a tool that the text does not name"));
}

#[test]
fn a_program_of_which_nothing_can_be_followed_is_refused_where_it_should_move() {
    // Read as conversational text, blocks of G words have no motion that could be followed.
    let forced = |step: WearParameters| WearParameters {
        program: ProgramSetup { dialect: Some(Dialect::Heidenhain), ..at_zero() },
        ..step
    };
    let text = pass_from("0");
    match plain(&forced(ball_by_feed((5.0, 4.5))), &text) {
        Err(Fault::NothingFollowed { .. } | Fault::NoMotion | Fault::Lines(_)) => {}
        other => panic!("{other:?}"),
    }
    // Three axes alone: nobody knows how the table stands.
    let three = "G1 X10. Y0. Z20. F500\nX12.\nM30\n";
    match plain(&ball_by_feed((5.0, 4.5)), three) {
        Err(Fault::NothingFollowed { first: Some((_, 1)) } | Fault::Lines(_)) => {}
        other => panic!("{other:?}"),
    }
    let (output, _) = plain(&ball_by_feed((5.0, 5.0)), three).expect("nothing to move");
    assert_eq!(output, three);
}

#[test]
fn only_the_named_tool_is_moved_and_the_others_meet_the_sources_points() {
    let one = "G0 X0.000 Y0.000 Z20.000 A-30.000 C0.000\nG1 Y10.000 Z24.000 A-31.000 F800\n";
    let two = "G0 Z90.000\nX3.000 Y12.000 A-30.000 C0.000\nG1 Y20.000 Z20.000 A-31.000\nG0 Z90.000\n";
    let three = pass_from("7");
    let text = format!("T1 M6\n{one}T2 M6\n{two}M6 T1\n{three}M30\n");
    let parameters = |number| WearParameters { program: with_tool(number), ..ball_by_feed((5.0, 4.5)) };
    let (output, report) = plain(&parameters(1), &text).expect("a program");
    let (source, written): (Vec<_>, Vec<_>) = (text.lines().collect(), output.lines().collect());
    assert_eq!(source.len(), written.len());
    for moved in [1, 2, 9, 10] {
        assert_ne!(source[moved], written[moved]);
    }
    assert_eq!(source[3..9], written[3..9]);
    assert_eq!((report.contacts_kept, report.contacts_assumed), (0, 4));
    let (second, _) = plain(&parameters(2), &text).expect("a program");
    let second: Vec<_> = second.lines().collect();
    assert_eq!([&second[..5], &second[8..]], [&source[..5], &source[8..]]);
    assert_ne!(second[6], source[6]);
    assert!(matches!(
        plain(&parameters(3), &text),
        Err(Fault::Tool(ToolUnknown::NoSuchTool { number: 3, .. }))
    ));
    // A Y that the first tool left elsewhere would stand under the second one.
    let careless = text.replace(" Y12.000", "");
    match plain(&parameters(1), &careless) {
        Err(Fault::Lines(faults)) => {
            assert_eq!(faults.kept[0].line, 7);
            assert!(matches!(faults.kept[0].kind, LineFaultKind::AxesUnknown { .. }));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn increments_inches_and_absent_words_end_where_absolute_millimetres_do() {
    let parameters = ball_by_feed((5.0, 4.5));
    let machine = WearParameters {
        program: ProgramSetup { interpolation: Some(Interpolation::Machine), ..at_zero() },
        ..parameters
    };
    let absolute = "G90 G21 G94\nG0 X0.0000 Y0.0000 Z20.0000 A-30.0000 C0.0000\nG1 X10.0000 Y2.0000 Z21.0000 A-31.0000 C0.0000 F800\nX20.0000 A-35.0000 C5.0000\nX30.0000 Y5.0000 Z19.0000 C6.0000\nM30\n";
    let increments = "G90 G21 G94\nG0 X0.0000 Y0.0000 Z20.0000 A-30.0000 C0.0000\nG91 G1 X10.0000 Y2.0000 Z1.0000 A-1.0000 F800\nX10.0000 A-4.0000 C5.0000\nX10.0000 Y3.0000 Z-2.0000 C1.0000\nM30\n";
    let (by_words, report) = plain(&machine, absolute).expect("a program");
    assert_eq!(report.contacts_assumed, 4);
    assert!(by_words.lines().nth(3).expect("a block").contains('Y'), "{by_words}");
    let (by_steps, _) = plain(&machine, increments).expect("a program");
    let places = scan(&by_words, ['A', 'C']);
    let mut place = places[0].q;
    for (line, wanted) in by_steps.lines().skip(2).zip(&places[1..]) {
        for (k, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            place[k] += word(line, letter).unwrap_or(0.0);
        }
        assert!((place - wanted.q).amax() < 1.01e-4, "{by_steps} {by_words}");
    }
    let inches = |text: &str| {
        text.split_inclusive([' ', '\n'])
            .map(|word| match word.strip_prefix(['X', 'Y', 'Z']) {
                Some(number) => {
                    let end = &number[number.trim_end().len()..];
                    let mm: f64 = number.trim_end().parse().expect("a number");
                    format!("{}{:.6}{end}", &word[..1], mm / 25.4)
                }
                None => word.replace("G21", "G20"),
            })
            .collect::<String>()
    };
    let (by_inches, _) = plain(&machine, &inches(absolute)).expect("a program");
    for (inch, wanted) in scan(&by_inches, ['A', 'C']).iter().zip(&places) {
        assert!((inch.q * 25.4 - wanted.q).amax() < 1.5e-4, "{by_inches}");
    }
}

#[test]
fn coarse_words_get_the_decimals_that_a_shift_needs() {
    let text = "G90 G21 G94\nG0 X0 Y0 Z20. A-30. C0\nG1 X10. Y2. Z21. F800\nX20. A-35. C5.\nM30\n";
    let (output, report) = plain(&ball_by_feed((5.0, 4.5)), text).expect("a program");
    assert!(report.after_if_assumed.expect("assumed").max_mm < 0.001, "{output}");
    let second = output.lines().nth(2).expect("a block");
    let decimals = |word: &str| word.split_once('.').map_or(0, |(_, digits)| digits.len());
    assert!(
        second.split(' ').any(|word| word.starts_with(['X', 'Y', 'Z']) && decimals(word) == 3),
        "{output}"
    );
}

#[test]
fn a_tilted_axis_stated_in_cutter_location_data_is_left_as_it_is_stated() {
    for turn in 0..48 {
        let (tilt, about) = (0.15 + 0.013 * f64::from(turn), 0.7 * f64::from(turn));
        let axis =
            [tilt.sin() * about.cos(), tilt.sin() * about.sin(), tilt.cos()].map(|x| format!("{x:.6}"));
        let axis = axis.join(",");
        let mut text =
            format!("UNITS/MM\nMULTAX/ON\nRAPID\nGOTO/0.0000,0.0000,10.0000,{axis}\nFEDRAT/500,MMPM\n");
        for point in 1..6 {
            let x = 2.0 * f64::from(point);
            writeln!(text, "GOTO/{x:.4},{:.4},10.0000,{axis}", 1.0 + 0.3 * x * x).expect("a string");
        }
        text.push_str("FINI\n");
        // Along the axis, where it points: another cutter than this one would not move, because no rotary axis turns.
        let shorter = WearParameters { shorter_by: Length::from_mm(0.05), ..ball_by_feed((5.0, 5.0)) };
        let (written, report) = plain(&shorter, &text).unwrap_or_else(|fault| panic!("{axis}: {fault:?}"));
        assert!(report.motions_shifted >= 5, "{axis}: {report:?}");
        assert_eq!(written.matches(&axis).count(), 6, "{written}");
    }
}

#[test]
fn an_arc_stays_an_arc_where_both_ends_move_alike() {
    let text = |arc: &str| {
        format!(
            "G90 G21 G94 G17\nG0 X0.000 Y0.000 Z20.000 A0.000 C0.000\nG1 X10.000 F800\n{arc}\nG1 X30.000\nG0 Z50.000\nM30\n"
        )
    };
    let arc = "G2 X20.000 Y10.000 I10.000 J0.000";
    // No rotary axis turns, so nothing is assumed: nothing moves, whatever the arc.
    let helix = "G2 X20.000 Y10.000 Z18.000 I10.000 J0.000";
    for arc in [arc, helix, "G18 G2 X20.000 Z30.000 I10.000 K0.000"] {
        let (output, report) = plain(&ball_by_feed((5.0, 4.5)), &text(arc)).expect("a program");
        assert_eq!(output, text(arc));
        assert_eq!((report.contacts_kept, report.contacts_assumed), (0, 0));
    }
    // A shorter cutter goes down everywhere, arcs and rapids too.
    let shorter = WearParameters { shorter_by: Length::from_mm(0.25), ..ball_by_feed((5.0, 4.5)) };
    let (output, _) = plain(&shorter, &text(arc)).expect("a program");
    assert_eq!(output, text(arc).replace("Z20.000", "Z19.750").replace("Z50.000", "Z49.750"));
    let absolute = text(arc).replace("G17", "G17 G90.1");
    let refused = |parameters: &WearParameters, text: &str, line: u64| {
        let Err(Fault::Lines(faults)) = plain(parameters, text) else { panic!("{text}") };
        assert_eq!((faults.total, faults.kept[0].line), (1, line), "{faults:?}");
        assert!(matches!(faults.kept[0].kind, LineFaultKind::ArcShift { .. }), "{faults:?}");
        assert!(faults.kept[0].block.contains("G2"), "{faults:?}");
    };
    refused(&shorter, &absolute, 4);
    // A contact stated at its end moves that end alone: 60° from the tool axis.
    let stated = WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)), at_zero());
    refused(&stated, &text(&format!("{arc} U15.670 V10.000 W22.500")), 4);
    refused(&shorter, &text("G2 X20.000 Y10.000 I10.000 J0.000 C10.000"), 4);
}

#[test]
fn what_cannot_be_moved_and_would_have_to_is_refused_by_line() {
    let start = "G90 G21 G94 G54\nG0 X0.000 Y0.000 Z20.000 A-30.000 C0.000\nG1 X10.000 Y2.000 Z21.000 A-31.000 F800\n";
    let ball = ball_by_feed((5.0, 4.5));
    for (block, line) in [
        ("/X20.000 A-35.000", 4),
        ("G41 D1\nX20.000 A-35.000", 5),
        ("G81 X20.000 R30.000", 4),
        ("M98 P100", 4),
        ("X#1", 4),
        ("G55\nX0.000 Y0.000 Z20.000 A-30.000 C0.000", 5),
    ] {
        let text = format!("{start}{block}\nM30\n");
        let Err(Fault::Lines(faults)) = plain(&ball, &text) else {
            panic!("{text}{:?}", plain(&ball, &text))
        };
        assert_eq!(faults.kept[0].line, line, "{faults:?}");
    }
    for block in ["G53 G0 Z0", "G91 G28 Z0\nG90", "G28 U0 V0 W0", "M5\nM9"] {
        let text = format!("{start}{block}\nM30\n");
        let (output, report) = plain(&ball, &text).unwrap_or_else(|fault| panic!("{text}{fault:?}"));
        assert!(output.ends_with(&format!("{block}\nM30\n")), "{output}");
        assert!(report.motions_shifted > 0);
    }
    // Everything that is wrong is named.
    let part = dome_near_pole(ac_machine(), tool(5.0, 5.0), 9, 1);
    let table = part.program(Form::NormalTable, FeedForm::PerMinute);
    let broken: String = table
        .lines()
        .enumerate()
        .map(|(k, line)| if k % 3 == 2 { line.replace(",0.99", ",-0.99") } else { line.into() } + "\n")
        .collect();
    let Err(Fault::Lines(faults)) = run(&part, &worn(&part, tool(4.0, 4.0)), &broken) else {
        panic!("undercuts")
    };
    assert_eq!(faults.kept.iter().map(|fault| fault.line).collect::<Vec<_>>(), [3, 6, 9]);
}

#[test]
fn a_block_in_machine_coordinates_brings_back_only_the_axes_that_it_places() {
    let worn = WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)), at_zero());
    // The first contact moves X, the second one wants it where the source has it, and does not state it.
    let iso = "G90 G21 G94\nG0 X0.000 Y0.000 Z20.000 A-30.000 C0.000\n\
               G1 X10.000 Y6.000 Z24.000 U13.000 V6.000 W25.000 F800\n\
               @G1 Y12.000 Z28.000 U10.000 V15.000 W29.000\nM30\n";
    let heidenhain = "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+20 A-30 C+0 R0 FMAX\n\
                      2 LN X+10.000 Y+6.000 Z+24.000 NX+0.6 NY+0 NZ+0.8 F800\n\
                      @4 LN Y+12.000 Z+28.000 NX+0 NY+0.6 NZ+0.8\n5 END PGM A MM\n";
    let last = |text: &str| {
        let (output, _) = plain(&worn, text).unwrap_or_else(|fault| panic!("{text}{fault:?}"));
        let line = output.lines().rev().nth(1).expect("the last motion");
        // Where it starts is not known in machine coordinates, and F need not be lowered.
        line.split(" F").next().unwrap_or_default().to_owned()
    };
    for (text, blocks) in [
        (iso, &["G53 G0 Z0.\n", "G53 G0 Z#5\n", "G53 G0 Z[#5+1]\n", "G91 G53 G0 Z5.\nG90\n"][..]),
        (heidenhain, &["3 L Z+100 R0 FMAX M91\n", "3 L IZ+50 R0 FMAX M92\n", "3 L Z+Q5 R0 FMAX M91\n"][..]),
    ] {
        let stayed = last(&text.replace('@', ""));
        assert!(stayed.contains("X10.000") || stayed.contains("X+10.000"), "{stayed}");
        for block in blocks {
            assert_eq!(last(&text.replace('@', block)), stayed, "{block}");
        }
    }
}

/// Under control of the tip, an axis of the machine moves the tip in all three of X Y Z. A place of the machine then
/// leaves none of them known, and no word that the source does not have is written.
#[test]
fn under_control_of_the_tip_a_place_of_the_machine_leaves_no_word_known() {
    let worn = WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.9, 4.9)), at_zero());
    for there in ["G53 Z0", "G91 G28 Z0\nG90", "G30 P2 Z0"] {
        let text = format!(
            "G21 G90 G94 G54 G17\nG0 X0 Y0 Z100 A30 C0\nG43.4 H1\nG0 X1 Y2 Z50\nG1 X5 Y2 Z10 U5 V7 W10 F500\n\
             X6 Y3 Z10 U6 V8 W10\n{there}\nG1 Z12 U6 V8 W12 F500\nX8\nG49\nM30\n"
        );
        let fault = plain(&worn, &text).expect_err("X and Y are not known");
        assert!(fault.to_string().contains("position"), "{there}: {fault}");
    }
}

#[test]
fn a_rapid_that_hands_over_to_a_cut_ends_where_the_cut_begins() {
    // The table turns by so little that the shifts at both ends are alike.
    let text = "G90 G21 G94\nG0 X0.0000 Y0.0000 Z20.0000 A-30.0000 C0.0000\nG1 X10.0000 Y6.0000 Z24.0000 A-30.0010 F800\nG0 Z90.0000\nM30\n";
    let larger = ball_by_feed((5.0, 5.5));
    let (output, report) = plain(&larger, text).expect("a program");
    assert_eq!(report.contacts_assumed, 2);
    let lines = scan(&output, ['A', 'C']);
    let source = scan(text, ['A', 'C']);
    let shifts: Vec<_> = lines.iter().zip(&source).map(|(line, source)| line.q - source.q).collect();
    assert!((shifts[0] - shifts[1]).amax() < 1.01e-4 && shifts[0].norm() > 0.05, "{output}");
    // A larger cutter leaves as it stood.
    assert!((shifts[2] - shifts[1]).amax() < 1.01e-4, "{output}");
}

/// A point of a random program: linear words, rotary words, lean and turn of the normal from the tool axis.
type RandomPoint = ([f64; 3], [f64; 2], f64, f64);

fn random_points() -> impl Strategy<Value = Vec<RandomPoint>> {
    let point = ([-50.0..50.0, -50.0..50.0, -50.0..50.0], [-40.0..40.0, -40.0..40.0], 0.1..1.5, 0.0..6.3);
    proptest::collection::vec(point, 2..12)
}

fn random_tools() -> impl Strategy<Value = (Tool, Tool)> {
    let pair = (2.0..10.0, prop_oneof![Just(1.0), 0.1..0.9], 0.9..1.02, 0.9..1.0);
    pair.prop_map(|(radius, share, left, corner): (f64, f64, f64, f64)| {
        let actual = radius * left;
        (tool(radius, radius * share), tool(actual, (radius * share * corner).min(actual)))
    })
}

/// Half a unit of four decimals on three axes, stretched by squareness errors, and what stated words of six decimals
/// and rotary words printed to the bit leave [mm].
const WRITTEN_MM: f64 = 0.866_025_404e-4 * 1.01 + 2e-5;

proptest! {
    #[test]
    fn on_every_machine_the_worn_cutter_of_any_length_touches_the_same_points(
        machine in prop_oneof![preset_machine(true), any_machine()],
        setup in setup(),
        (nominal, actual) in random_tools(),
        points in random_points(),
        shorter_mm in prop_oneof![Just(0.0), -0.5..0.5],
        (measured, tcp) in (any::<bool>(), any::<bool>()),
    ) {
        let setup = Setup { apply_errors: true, ..setup };
        let length_in_control = if measured { LengthInControl::Measured } else { LengthInControl::Nominal };
        let real = Setup { tool_length_mm: setup.tool_length_mm - shorter_mm, ..setup };
        let source = Kinematics::new(&machine, &setup);
        // What the control believes in; the tip of the worn cutter stands behind it by what it does not know.
        let (control, unknown_mm) = if measured { (Kinematics::new(&machine, &real), 0.0) } else { (source.clone(), shorter_mm) };
        let [first, second] = machine.rotary_axes();
        let letters = [first, second].map(|axis| axis.letter.as_char());
        let inside = |axis: &RotaryAxis, word: f64| {
            axis.travel_deg.is_none_or(|travel| travel.contains(word, 0.0))
        };
        let interpolation = if tcp { "G43.4 H1\n" } else { "" };
        let mut text = format!("G90 G21 G94\n{interpolation}");
        let mut wanted = Vec::new();
        for (k, (linear, rotary, lean, turn)) in points.iter().enumerate() {
            let linear = linear.map(|mm| (mm * 1e4_f64).round() / 1e4);
            let rotary = rotary.map(|deg| (deg * 1e3_f64).round() / 1e3);
            prop_assume!(inside(first, rotary[0]) && inside(second, rotary[1]));
            let rotary_rad = [first.angle_rad(rotary[0]), second.angle_rad(rotary[1])];
            let axis = source.axis(rotary_rad);
            let tip = if tcp { Vec3::from(linear) } else { source.tip_mm(Vec3::from(linear), rotary_rad) };
            let side = axis.cross(&Vec3::new(0.3, 0.5, -0.7)).normalize();
            let across = side * turn.cos() + axis.cross(&side) * turn.sin();
            let normal = axis * lean.cos() + across * lean.sin();
            let contact = touched(nominal, tip, axis, normal);
            let stated = if tcp { contact } else { source.linear_mm(contact, rotary_rad) };
            let code = if k == 0 { "G1 F1000 " } else { "" };
            let ([x, y, z], [p, q]) = (linear, rotary);
            writeln!(
                text,
                "{code}X{x:.4} Y{y:.4} Z{z:.4} {}{p:.3} {}{q:.3} U{:.6} V{:.6} W{:.6}",
                letters[0], letters[1], stated.x, stated.y, stated.z
            )
            .expect("text");
            wanted.push((contact, normal, rotary_rad));
        }
        let parameters = WearParameters {
            program: in_mm(&setup),
            shorter_by: Length::from_mm(shorter_mm),
            length_in_control,
            ..WearParameters::new(nominal, WornCutter::Tool(actual), at_zero())
        };
        let mut output = Vec::new();
        let bytes = text.clone().into_bytes();
        let report = compensate_wear(&machine, &parameters, &bytes, &mut output, &|| ControlFlow::Continue(()));
        // Presets have no travel of X Y Z.
        let report = report.map_err(|fault| TestCaseError::fail(format!("{fault:?}\n{text}")))?;
        prop_assert_eq!(report.contacts_kept, points.len() as u64);
        let output = String::from_utf8(output).expect("text");
        let lines = scan(&output, letters);
        prop_assert_eq!(lines.len(), points.len());
        for (line, (contact, normal, rotary_rad)) in lines.iter().zip(wanted) {
            let axis = control.axis(rotary_rad);
            let place = |words: Vec3| if tcp { words } else { control.tip_mm(words, rotary_rad) };
            let off_mm = touched(actual, place(line.q) + axis * unknown_mm, axis, normal) - contact;
            prop_assert!(off_mm.norm() <= WRITTEN_MM, "{} {output}{text}", off_mm.norm());
            // The contact words mean the same point for the control that reads them.
            let stated_mm = place(line.uvw.expect("U V W")) - contact;
            prop_assert!(stated_mm.norm() <= WRITTEN_MM, "{} {output}{text}", stated_mm.norm());
        }
    }
}

/// `FROM/` in the middle says where the tool stands, whatever was moved before it.
#[test]
fn the_way_goes_on_from_where_a_program_says_that_the_tool_stands() {
    let mut text = "PARTNO/P\nUNITS/MM\nMULTAX/ON\nFEDRAT/900,MMPM\n".to_owned();
    for k in 0..60 {
        let (along, lean) = (0.2 * f64::from(k), 0.3 + 0.002 * f64::from(k));
        let word = if k == 30 { "FROM" } else { "GOTO" };
        writeln!(text, "{word}/{along:.4},5,{:.4},{:.7},0,{:.7}", 0.1 * along, lean.sin(), lean.cos())
            .expect("text");
    }
    text.push_str("FINI\n");
    let parameters = WearParameters {
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.9, 4.9)), at_zero())
    };
    let mut output = Vec::new();
    let machine = ac_machine();
    let go_on = || ControlFlow::Continue(());
    let report = compensate_wear(&machine, &parameters, &text.clone().into_bytes(), &mut output, &go_on);
    assert_eq!(report.expect("compensated").motions_shifted, 59);
    let output = String::from_utf8(output).expect("text");
    let from = |text: &str| text.lines().find(|line| line.starts_with("FROM")).map(str::to_owned);
    assert_eq!(from(&output), from(&text));
}

#[test]
fn a_larger_cutter_leaves_a_wall_as_it_stood_there() {
    let wall = "G90 G21 G94\nG0 X-30. Y5. Z10. A0. C0. U-30. V0. W10.\nG1 Z-10. U-30. V0. W0. F500\n\
                X0. U0. V0. W0.\nG0 Z-5.\nX10.\nZ30.\nM30\n";
    let side = |actual: f64| WearParameters {
        milling: Milling::Side,
        contact: ContactSource::Program,
        ..WearParameters::new(tool(5.0, 0.0), WornCutter::Tool(tool(actual, 0.0)), at_zero())
    };
    let (output, report) = plain(&side(5.2), wall).expect("a program");
    let stands: Vec<f64> = output.lines().filter_map(|line| word(line, 'Y')).collect();
    assert_eq!(stands, [5.2], "{output}");
    assert_eq!(report.after.max_mm, 0.0);
    assert!(report.warnings.iter().any(|warning| warning.kind.name() == "larger_cutter"));
    // A smaller one may go back.
    let (output, report) = plain(&side(4.8), wall).expect("a program");
    let stands: Vec<f64> = output.lines().filter_map(|line| word(line, 'Y')).collect();
    assert_eq!(stands, [4.8, 5.0], "{output}");
    assert!(report.warnings.iter().all(|warning| warning.kind.name() != "larger_cutter"));
}
