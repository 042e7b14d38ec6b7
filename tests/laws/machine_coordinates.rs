//! Machine coordinates and reference positions: the gauge point stands where the profile's zero of the machine and the
//! stated numbers place it, whatever the work offset and the tool are.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at the first surprise, helpers included"
)]

use std::collections::BTreeMap;
use std::sync::Arc;

use proptest::prelude::*;

use trunnion::machine::{Machine, MachineCoordinates, PlaneRule, PlaneSolution, Preset, RotaryLetter};
use trunnion::motion::{ModalGroup, Unfollowable, WorkOffset, WorkOffsets};
use trunnion::process::{
    Interpreted, InterpretedKind, InterpretedMotion, ListedTool, ProgramSetup, StartPosition, ToolTable,
    Tools,
};
use trunnion::program::Dialect;
use trunnion::units::{Length, LengthUnit};

use crate::models::told::all_told;

/// Rounding of double precision at a few hundred millimetres [mm].
const ROUNDING_MM: f64 = 1e-9;

const ZERO_MM: [f64; 3] = [12.5, -7.25, 640.0];
const OFFSET_MM: [f64; 3] = [70.0, -40.0, 95.0];
const SECOND_MM: [f64; 3] = [-110.0, 35.5, 60.25];
/// Lengths of T1 and T2 [mm].
const LENGTHS_MM: [f64; 2] = [80.0, 123.4];
const HOME: [Option<f64>; 5] = [Some(5.0), Some(300.0), Some(-0.5), Some(0.0), Some(10.0)];

fn machine(length_counts: Option<bool>) -> Machine {
    let second = [Some(-20.0), None, Some(-100.0), None, None];
    let coordinates = MachineCoordinates {
        zero_mm: ZERO_MM,
        length_counts,
        references: vec![HOME, second],
        ..MachineCoordinates::default()
    };
    bare().with_machine_coordinates(Some(coordinates))
}

fn bare() -> Machine {
    Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap()
}

/// Two tools, two work offsets, and axes that stand at zero.
fn set_up(dialect: Dialect) -> ProgramSetup {
    let tools = [1, 2].map(|number| ListedTool {
        number: Some(number),
        name: None,
        cutter: None,
        length: Some(Length::from_mm(LENGTHS_MM[number as usize - 1])),
        worn: None,
    });
    let named_mm = BTreeMap::from(
        [("G54", OFFSET_MM), ("G55", SECOND_MM)].map(|(name, mm)| (WorkOffset::from_name(name).unwrap(), mm)),
    );
    ProgramSetup {
        dialect: Some(dialect),
        unit: Some(LengthUnit::Millimetre),
        work_offsets: Arc::new(WorkOffsets { only_mm: Some(OFFSET_MM), named_mm, ..WorkOffsets::default() }),
        tools: Tools::with(None, None, Arc::new(ToolTable::new(tools.into()))),
        start: StartPosition { linear_mm: [Some(0.0); 3], rotary_deg: [Some(0.0); 2] },
        apply_errors: false,
        ..ProgramSetup::default()
    }
}

fn told(machine: &Machine, dialect: Dialect, text: &str) -> Vec<Interpreted> {
    all_told(machine, &set_up(dialect), text)
}

/// The motions of a text that is followed whole.
fn followed(machine: &Machine, dialect: Dialect, text: &str) -> Vec<InterpretedMotion> {
    let told = told(machine, dialect, text).into_iter().map(|told| match told {
        Interpreted::Motion(motion) => motion,
        Interpreted::LeftAlone { line, reason, .. } => panic!("{text}\nline {line}: {reason}"),
    });
    told.collect()
}

fn reasons(machine: &Machine, dialect: Dialect, text: &str) -> Vec<Unfollowable> {
    let reasons = told(machine, dialect, text).into_iter().filter_map(|told| match told {
        Interpreted::Motion(_) => None,
        Interpreted::LeftAlone { reason, .. } => Some(reason),
    });
    reasons.collect()
}

fn assert_at(motion: &InterpretedMotion, wanted: [f64; 5]) {
    for (found, wanted) in motion.joints.into_iter().zip(wanted) {
        assert!((found.unwrap() - wanted).abs() < ROUNDING_MM, "{:?} {wanted:?}", motion.joints);
    }
}

/// Words of the program where the gauge point stands at these machine coordinates.
fn words(machine_mm: [f64; 3], offset_mm: [f64; 3], length_mm: f64) -> [f64; 3] {
    let gauge_mm: [f64; 3] = std::array::from_fn(|k| ZERO_MM[k] + machine_mm[k]);
    let tip_mm = [gauge_mm[0], gauge_mm[1], gauge_mm[2] - length_mm];
    std::array::from_fn(|k| tip_mm[k] - offset_mm[k])
}

proptest! {
    #[test]
    fn the_gauge_point_stands_where_the_numbers_say(
        at in prop::array::uniform3(-400i32..400),
        tool in 1usize..=2,
        second in any::<bool>(),
    ) {
        let machine_mm = at.map(|mm| f64::from(mm) / 8.0);
        let [x, y, z] = machine_mm;
        let (name, offset_mm) = if second { ("G55", SECOND_MM) } else { ("G54", OFFSET_MM) };
        let text = format!(
            "G21 G90 {name}\nT{tool} M6\nG43 H{tool}\nG0 X1. Y2. Z3. A20. C30.\nG53 Z{z:.3}\nG53 X{x:.3} Y{y:.3} A0. C0.\n\
             G1 X1. F500\nM30\n"
        );
        let found = followed(&machine(Some(false)), Dialect::Iso, &text);
        let [wanted_x, wanted_y, wanted_z] = words(machine_mm, offset_mm, LENGTHS_MM[tool - 1]);
        prop_assert_eq!(found.len(), 4);
        assert_at(&found[1], [1.0, 2.0, wanted_z, 20.0, 30.0]);
        assert_at(&found[2], [wanted_x, wanted_y, wanted_z, 0.0, 0.0]);
        // The words count in the work offset again.
        assert_at(&found[3], [1.0, wanted_y, wanted_z, 0.0, 0.0]);
        // With the rotary axes at zero, the tip is at the words.
        let tip = found[2].tip_mm.unwrap();
        prop_assert!(tip.iter().zip([wanted_x, wanted_y, wanted_z]).all(|(a, b)| (a - b).abs() < ROUNDING_MM));
    }
}

#[test]
fn g28_and_g30_pass_their_point_and_end_at_the_reference_position() {
    let text = "G21 G90 G54\nT1 M6\nG43 H1\nG0 X1. Y2. Z3. A20. C30.\nG28 Z50.\nG91 G28 X0. Y0.\nG90\nG28 A5. C6.\n\
                G30 P2 X1.\nG30 Z200.\nM30\n";
    let found = followed(&machine(Some(false)), Dialect::Iso, text);
    let [x, y, z] = words([5.0, 300.0, -0.5], OFFSET_MM, LENGTHS_MM[0]);
    let [second_x, _, second_z] = words([-20.0, 0.0, -100.0], OFFSET_MM, LENGTHS_MM[0]);
    let wanted = [
        [1.0, 2.0, 3.0, 20.0, 30.0],
        [1.0, 2.0, 50.0, 20.0, 30.0],
        [1.0, 2.0, z, 20.0, 30.0],
        [x, y, z, 20.0, 30.0],
        [x, y, z, 5.0, 6.0],
        [x, y, z, 0.0, 10.0],
        [1.0, y, z, 0.0, 10.0],
        [second_x, y, z, 0.0, 10.0],
        [second_x, y, 200.0, 0.0, 10.0],
        [second_x, y, second_z, 0.0, 10.0],
    ];
    assert_eq!(found.len(), wanted.len(), "{found:#?}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert_at(found, wanted);
    }
}

#[test]
fn another_length_tool_or_offset_leaves_z_unknown_until_a_word_states_it() {
    let at = |changes: &str| {
        format!("G21 G90 G54\nT1 M6\nG0 X1. Y2. Z3. A0. C0.\nG53 Z0.\n{changes}\nG0 X4. Y5.\nM30\n")
    };
    // Some controls move the axis by another length or offset, others do not; a changer moves all axes.
    for changes in ["G43 H1", "G49", "G55", "T2 M6", "T1 M6", "G43 H2"] {
        let found = followed(&machine(Some(false)), Dialect::Iso, &at(changes));
        let last = found.last().unwrap();
        assert_eq!((last.joints[2], last.tip_mm), (None, None), "{changes}");
    }
    // Nobody has stated the length of T3, H names another tool's length, and G10 changes it.
    for before in ["T3 M6", "T1 M6\nG43 H2", "T1 M6\nG10 L10 P1 R120."] {
        let text = format!("G21 G90 G54\n{before}\nG0 X1. Y2. Z3. A0. C0.\nG53 Z0.\nG0 X4.\nM30\n");
        let found = followed(&machine(Some(false)), Dialect::Iso, &text);
        assert_eq!(found[1].joints[2], None, "{before}");
        assert_eq!(found[2].tip_mm, None, "{before}");
    }
    let text = "BEGIN PGM P MM\nTOOL CALL 1 Z S5000 DL+0.5\nL X+1 Y+2 Z+3 A+0 C+0 R0 FMAX\nL Z-1.5 R0 FMAX M91\nEND PGM P MM\n";
    assert_eq!(followed(&machine(Some(false)), Dialect::Heidenhain, text)[1].joints[2], None);
}

#[test]
fn where_no_length_is_in_force_a_word_z_does_not_place_the_tip() {
    let group = |blocks: &str, dialect: Dialect| {
        let text = format!("G90 G54\nT1 M6\nD1\nG0 X1 Y2 Z3 A0 C0\n{blocks}\nM30\n");
        let text = if dialect == Dialect::Iso { text.replace("D1", "G43 H1 G21") } else { text };
        reasons(&machine(Some(false)), dialect, &text)
    };
    let unknown = [Unfollowable::ModeUnknown { group: ModalGroup::ToolLength }];
    assert_eq!(group("SUPA Z0 D0\nG0 X5\nG0 Z50", Dialect::Siemens), unknown);
    assert_eq!(group("G49\nG53 Z0\nG0 X5\nG0 Z50", Dialect::Iso), unknown);
    assert_eq!(group("G43 H0\nG0 X5\nG0 Z50", Dialect::Iso), unknown);
    let text = "G90 G21 G15 H1\nG0 X1 Y2 Z3 A0 C0\nG56 H1 Z50\nG53\nG0 X5\nG0 Z40\nM2\n";
    assert_eq!(reasons(&machine(Some(false)), Dialect::Okuma, text), unknown);
    // A program without lengths runs in a work offset of its tool's tip.
    let text = "G21 G90 G54 G49\nT1 M6\nG0 X1 Y2 Z3 A0 C0\nG53 Z0\nG0 Z50\nM30\n";
    assert_eq!(followed(&machine(Some(false)), Dialect::Iso, text)[2].tip_mm, Some([1.0, 2.0, 50.0]));
    let text = "G90 G54\nT1 M6\nD1\nG0 X1 Y2 Z3 A0 C0\nSUPA Z0 D0\nG0 Z50\nG0 X5\nM30\n";
    let Some(Interpreted::Motion(last)) = told(&machine(Some(false)), Dialect::Siemens, text).pop() else {
        panic!("X5 is a motion")
    };
    assert_eq!(last.tip_mm, None);
    assert_eq!(group("G49\nG0 X5\nG43 H1 Z50", Dialect::Iso), []);
    // A length that would count has to be in force, and in ISO programs this is not certain.
    let text = "G21 G90 G54\nT1 M6\nG43 H1\nG0 X1 Y2 Z3 A0 C0\nG53 Z0\nM30\n";
    assert_eq!(reasons(&machine(Some(true)), Dialect::Iso, text), [Unfollowable::MachineCoordinates]);
    let text = text.replace("G43 H1\n", "").replace("G53", "G49 G53");
    let found = followed(&machine(Some(true)), Dialect::Iso, &text);
    let [_, _, gauge] = words([0.0; 3], OFFSET_MM, LENGTHS_MM[0]);
    assert_at(&found[1], [1.0, 2.0, gauge, 0.0, 0.0]);
}

#[test]
fn whether_the_length_counts_is_asked_for_where_one_is_in_force() {
    let sinumerik = |block: &str| format!("G90 G54\nT1 M6\nD1\nG0 X1 Y2 Z3 A0 C0\n{block}\nG0 X4\nM30\n");
    let [x, y, gauge] = words([9.0, 8.0, -1.5], OFFSET_MM, LENGTHS_MM[0]);
    let [_, _, tip] = words([0.0, 0.0, -1.5], OFFSET_MM, 0.0);
    for block in ["SUPA G0 Z-1.5 D0", "G153 Z-1.5 D0"] {
        let found = followed(&machine(None), Dialect::Siemens, &sinumerik(block));
        assert!((found[1].joints[2].unwrap() - gauge).abs() < ROUNDING_MM, "{block}");
    }
    let found = followed(&machine(None), Dialect::Siemens, &sinumerik("SUPA X9 Y8"));
    assert_at(&found[1], [x, y, 3.0, 0.0, 0.0]);
    let supa = sinumerik("SUPA Z-1.5");
    let left = reasons(&machine(None), Dialect::Siemens, &supa);
    assert_eq!(left, [Unfollowable::MachineCoordinates]);
    let found = followed(&machine(Some(true)), Dialect::Siemens, &supa);
    assert_at(&found[1], [1.0, 2.0, tip, 0.0, 0.0]);
    let found = followed(&machine(Some(false)), Dialect::Siemens, &supa);
    assert_at(&found[1], [1.0, 2.0, gauge, 0.0, 0.0]);

    let text = "BEGIN PGM P MM\nTOOL CALL 1 Z S5000\nL X+1 Y+2 Z+3 A+0 C+0 R0 FMAX\nL Z-1.5 R0 FMAX M91\n\
                L X+9 Y+8 FMAX M91\nEND PGM P MM\n";
    let left = reasons(&machine(None), Dialect::Heidenhain, text);
    assert_eq!(left, [Unfollowable::MachineCoordinates]);
    let found = followed(&machine(Some(false)), Dialect::Heidenhain, text);
    assert_at(&found[2], [x, y, gauge, 0.0, 0.0]);
}

#[test]
fn what_does_not_say_where_the_axes_go_is_left_alone() {
    use Unfollowable::{MachineCoordinates, Reference};
    let iso = |blocks: &str| format!("G21 G90 G54\nT1 M6\nG43 H1\nG0 X1. Y2. Z3. A0. C0.\n{blocks}\nM30\n");
    let stated = machine(Some(false));
    let left = |blocks: &str| reasons(&stated, Dialect::Iso, &iso(blocks));
    // A machine whose owner has not stated its zero.
    assert_eq!(reasons(&bare(), Dialect::Iso, &iso("G53 Z0.")), [MachineCoordinates]);
    assert_eq!(reasons(&bare(), Dialect::Iso, &iso("G91 G28 Z0.")), [Reference]);
    // No control counts in machine coordinates from the place before.
    assert_eq!(left("G91 G53 Z0."), [MachineCoordinates]);
    assert_eq!(left("G2 G53 X0. I5. F100"), [MachineCoordinates]);
    assert_eq!(left("G92 Z0.\nG53 Z0."), [MachineCoordinates]);
    assert_eq!(left("G52 X5.\nG53 Z0."), [MachineCoordinates]);
    assert_eq!(left("G57\nG53 Z0."), [MachineCoordinates]);
    assert_eq!(left("/G53 Z0."), [MachineCoordinates]);
    assert_eq!(left("G53 Z0. B5."), [MachineCoordinates]);
    // The changer moves before the axes or after them. The end of G28 is the same, but nothing is known after it.
    let changed = told(&stated, Dialect::Iso, &iso("G91 G28 Z0. T2 M6\nG90 G0 X5."));
    let [.., Interpreted::Motion(home), Interpreted::Motion(last)] = &changed[..] else {
        panic!("{changed:?}")
    };
    assert_eq!((&home.joints[..3], &last.joints[..3]), (&[None; 3][..], &[Some(5.0), None, None][..]));
    assert_eq!(left("G53 Z0. T2 M6"), [MachineCoordinates]);
    // A control of the tip, a turned frame, and a compensated path.
    assert!(!left("G43.4 H1\nG53 Z0.").is_empty());
    assert!(!left("G68 X0. Y0. R30.\nG53 Z0.").is_empty());
    assert!(!left("G41 D1 G1 X5. F500\nG53 Z0.").is_empty());
    // A position that the profile lacks, and an axis that it lacks there.
    assert_eq!(left("G91 G30 P3 Z0."), [Reference]);
    assert_eq!(left("G91 G30 P2 Y0."), [Reference]);
    assert_eq!(left("G91 G30 P0 Z0."), [Reference]);
    // G28 with zeros in G90 goes through the zero of the program on some controls, and straight home on others.
    assert_eq!(left("G28 Z0."), [Reference]);
    // The basic frame stays in force, and M92 counts from a place of the machine's builder.
    let text = "G90 G54\nT1 M6\nD1\nG0 X1 Y2 Z3 A0 C0\nG53 X0\nM30\n";
    assert_eq!(reasons(&stated, Dialect::Siemens, text), [MachineCoordinates]);
    // Rotary axes that take the shorter way, or whose F counts along a circle.
    for block in
        ["L X-1.5 R0 FMAX M92", "L X-1.5 R0 FMAX M91 M92", "M126\nL C+350 FMAX M91", "M116\nL C+90 F500 M91"]
    {
        let text = format!(
            "BEGIN PGM P MM\nTOOL CALL 1 Z S5000\nL X+1 Y+2 Z+3 A+0 C+0 R0 FMAX\n{block}\nEND PGM P MM\n"
        );
        assert_eq!(reasons(&stated, Dialect::Heidenhain, &text), [MachineCoordinates], "{block}");
    }
}

/// G28 whose way is not certain ends at the reference position all the same.
#[test]
fn a_return_home_is_left_alone_and_its_end_is_known() {
    for home in ["G28 Z0.", "G28 Z230. F5000"] {
        let text = format!("G21 G90 G54\nT1 M6\nG43 H1\nG0 X1. Y2. Z3. A0. C0.\n{home}\nG0 X7.\nM30\n");
        let found = told(&machine(Some(false)), Dialect::Iso, &text);
        let [_, Interpreted::LeftAlone { reason: Unfollowable::Reference, .. }, Interpreted::Motion(last)] =
            found[..]
        else {
            panic!("{home}: {found:?}")
        };
        let [_, _, z] = words([0.0, 0.0, -0.5], OFFSET_MM, LENGTHS_MM[0]);
        assert_at(&last, [7.0, 2.0, z, 0.0, 0.0]);
    }
}

/// `M140 MB MAX` goes back along the tool to the end of the travel that the profile states.
#[test]
fn a_retraction_to_the_end_of_the_travel_ends_where_the_profile_says() {
    let text = |retract: &str, before: &str| {
        format!(
            "BEGIN PGM P MM\nTOOL CALL 1 Z S5000\nL X+1 Y+2 Z+3 A+0 C+0 R0 FMAX\n{before}{retract}\nL X+7 R0 FMAX\nEND PGM P MM\n"
        )
    };
    let coordinates = MachineCoordinates {
        retract_z_mm: Some(-4.5),
        ..machine(Some(false)).machine_coordinates().unwrap().clone()
    };
    let stated = bare().with_machine_coordinates(Some(coordinates.clone()));
    let [_, _, z] = words([0.0, 0.0, -4.5], OFFSET_MM, LENGTHS_MM[0]);
    for (retract, kind) in [
        ("M140 MB MAX", InterpretedKind::Rapid),
        ("L M140 MB MAX FMAX ; up", InterpretedKind::Rapid),
        ("m140 mb max f9999", InterpretedKind::Linear),
    ] {
        let found = followed(&stated, Dialect::Heidenhain, &text(retract, ""));
        assert_at(&found[1], [1.0, 2.0, z, 0.0, 0.0]);
        assert_eq!((found[1].kind, found[1].feed_mm_per_min), (kind, None), "{retract}");
        assert_at(&found[2], [7.0, 2.0, z, 0.0, 0.0]);
    }
    // Under tool-centre-point control the words of that place are not known, but the rotary axes rest.
    let found = followed(&stated, Dialect::Heidenhain, &text("M140 MB MAX", "M128\nL X+1 Y+2 Z+3 FMAX\n"));
    let last = found.last().unwrap();
    assert_eq!(last.joints, [Some(7.0), None, None, Some(0.0), Some(0.0)]);
    // A way of another length, a head that turns the tool, a block that may be skipped, and a silent profile.
    let head = Machine::new(Preset::by_id("ac-head").unwrap().parts()).unwrap();
    let head = head.with_machine_coordinates(Some(coordinates));
    for (machine, retract) in [
        (&stated, "M140 MB 50"),
        (&stated, "M140 MB+50 F9999"),
        (&stated, "M140 MB MAX F Q5"),
        (&stated, "M140"),
        (&stated, "/M140 MB MAX"),
        // The change of the tool moves axes too, before or after.
        (&stated, "M6 M140 MB MAX"),
        (&stated, "M140 MB MAX M6"),
        (&head, "M140 MB MAX"),
        (&machine(Some(false)), "M140 MB MAX"),
    ] {
        let found = told(machine, Dialect::Heidenhain, &text(retract, ""));
        assert!(matches!(found[1], Interpreted::LeftAlone { .. }), "{retract}: {found:?}");
        let Some(Interpreted::Motion(last)) = found.last() else { panic!("{retract}: {found:?}") };
        assert_eq!(last.joints[2], None, "{retract}");
    }
}

/// The hole of a cycle that the same block calls would begin at the end of the retraction.
#[test]
fn a_retraction_in_a_block_that_calls_a_cycle_is_not_lost() {
    let coordinates = MachineCoordinates {
        retract_z_mm: Some(-4.5),
        ..machine(Some(false)).machine_coordinates().unwrap().clone()
    };
    let stated = bare().with_machine_coordinates(Some(coordinates));
    let cycle =
        "CYCL DEF 200 DRILLING Q200=+2 Q201=-20 Q206=+100 Q202=+20 Q210=+0 Q203=+0 Q204=+10 Q211=+0\n";
    let is_left_alone = |block: &str| {
        let text = format!(
            "BEGIN PGM P MM\nTOOL CALL 1 Z S5000\nL X+1 Y+2 Z+50 A+0 C+0 R0 FMAX\n{cycle}{block}\nEND PGM P MM\n"
        );
        let found = told(&stated, Dialect::Heidenhain, &text);
        found.iter().any(|told| matches!(told, Interpreted::LeftAlone { .. }))
    };
    assert!(!is_left_alone("L M99"), "the reference of the cases below");
    for block in ["L M140 MB MAX M99", "L M140 MB 50 M99", "L X+10 M140 MB MAX M99"] {
        assert!(is_left_alone(block), "{block}");
    }
}

/// Behind an axis of the machine's own, other words than its own are not known either if words are the tip's or count
/// in a turned frame.
#[test]
fn a_place_of_the_machine_says_nothing_of_a_tip_or_of_a_turned_frame() {
    use Unfollowable::MachineCoordinates;
    let head = Machine::new(Preset::by_id("ac-head").unwrap().parts()).unwrap();
    let rule = PlaneSolution { rule: PlaneRule::PositiveFirst, axis: Some(RotaryLetter::A) };
    let solved = |machine: Machine| machine.with_plane_solution(Some(rule));
    let plane = |turn: &str, moves: &str| {
        format!(
            "G21 G90 G94 G54 G17\nT1 M6\nG43 H1\nG0 X0 Y0 Z100 A0 C0\nG68.2 X0 Y0 Z0 {turn}\nG53.1\nG0 X1 Y2 Z50\n{moves}\nM30\n"
        )
    };
    let joints = |machine: &Machine, dialect: Dialect, text: &str| {
        let told = told(machine, dialect, text);
        let Some(Interpreted::Motion(last)) = told.last() else { panic!("{text}\n{told:?}") };
        (last.joints, last.tip_mm)
    };
    for machine in [solved(head), solved(bare())] {
        for moves in ["G53 Z0\nG0 Z60", "G91 G28 Z0\nG90\nG0 Z60", "G53 X0\nG0 X3"] {
            let (_, tip) = joints(&machine, Dialect::Iso, &plane("I0 J30 K90", moves));
            assert_eq!(tip, None, "{moves}");
        }
    }
    let turned = "G90 G54\nT1 M6\nD1\nG0 X0 Y0 Z100 A0 C0\nAROT Z30\nG0 X1 Y2 Z50\nSUPA X0\nG0 X3\nM30\n";
    assert_eq!(
        reasons(&machine(Some(false)), Dialect::Siemens, turned),
        [MachineCoordinates, Unfollowable::Transformation]
    );
    let tilted = "BEGIN PGM P MM\nTOOL CALL 1 Z S5000\nL X+0 Y+0 Z+100 A+0 C+0 R0 FMAX\nPLANE SPATIAL SPA+30 SPB+0 SPC+90 TURN FMAX\n\
                  L X+1 Y+2 Z+50 R0 FMAX\nL X+0 R0 FMAX M91\nL X+3 R0 FMAX\nEND PGM P MM\n";
    assert_eq!(joints(&solved(bare()), Dialect::Heidenhain, tilted).1, None);
    // Under control of the tip, Y and X of the tip move with an axis that a table has tilted.
    let tcp =
        "G21 G90 G54\nT1 M6\nG0 X0 Y0 Z100 A30 C0\nG43.4 H1\nG0 X1 Y2 Z50\nG53 Z0\nG0 Z60\nG0 X8\nM30\n";
    assert_eq!(
        joints(&machine(Some(false)), Dialect::Iso, tcp),
        ([Some(8.0), None, Some(60.0), Some(30.0), Some(0.0)], None)
    );
    assert_eq!(reasons(&machine(Some(false)), Dialect::Iso, tcp), [MachineCoordinates]);
}
