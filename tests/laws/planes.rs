//! Tilted working planes: a motion in a plane has the tip and the tool axis of the same motion in the workpiece.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::fmt::Write as _;
use std::ops::ControlFlow;

use nalgebra::{Rotation3, Unit, Vector3};
use proptest::prelude::*;

use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup};
use trunnion::machine::{Machine, PRESETS, PlaneRule, PlaneSolution, Preset, RotaryLetter, Tool};
use trunnion::motion::{Interpolation, Unfollowable};
use trunnion::process::{
    Interpreted, InterpretedKind, InterpretedMotion, ProgramSetup, SimulationParameters,
    VerificationParameters, simulate, verify_part,
};
use trunnion::program::Dialect;
use trunnion::servo::{AxisLetter, DrivePreset, DriveSet};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::surface::SurfacePoint;
use trunnion::units::Length;

use crate::models::told::all_told;

/// Rounding of double precision at a few hundred millimetres [mm].
const ROUNDING_MM: f64 = 1e-9;

/// The machine of a preset; its control takes the position in which this axis is positive.
fn machine(id: &str, axis: RotaryLetter) -> Machine {
    let rule = PlaneSolution { rule: PlaneRule::PositiveFirst, axis: Some(axis) };
    Machine::new(Preset::by_id(id).unwrap().parts()).unwrap().with_plane_solution(Some(rule))
}

fn ac_table() -> Machine {
    machine("ac-table", RotaryLetter::A)
}

fn understood_on(machine: &Machine, dialect: Dialect, text: &str) -> Vec<Interpreted> {
    let setup =
        Setup { work_offset_mm: Vec3::new(70.0, -40.0, 95.0), tool_length_mm: 80.0, apply_errors: false };
    let program = ProgramSetup { dialect: Some(dialect), apply_errors: false, ..ProgramSetup::in_mm(&setup) };
    all_told(machine, &program, text)
}

fn understood(dialect: Dialect, text: &str) -> Vec<Interpreted> {
    understood_on(&ac_table(), dialect, text)
}

/// The motions of a text in which nothing is left alone but the turns of rotary axes to a plane.
fn motions(machine: &Machine, dialect: Dialect, text: &str) -> Vec<InterpretedMotion> {
    let told = understood_on(machine, dialect, text).into_iter().filter_map(|told| match told {
        Interpreted::Motion(motion) => Some(motion),
        Interpreted::LeftAlone { line, reason, .. } => {
            let is_turn = text.lines().nth(usize::try_from(line).unwrap() - 1).is_some_and(|line| {
                ["G53.1", "CYCLE800", "PLANE"].into_iter().any(|turn| line.contains(turn))
            });
            assert!(is_turn, "{text}\nline {line}: {reason}");
            None
        }
    });
    told.collect()
}

/// The last reason why something is left alone.
fn last_reason(found: &[Interpreted]) -> Option<Unfollowable> {
    match found.last() {
        Some(Interpreted::LeftAlone { reason, .. }) => Some(*reason),
        _ => None,
    }
}

/// Turns one after the other, each about an axis of the frame turned before [deg].
fn turned(turns: [(usize, f64); 3]) -> Rotation3<f64> {
    turns.into_iter().fold(Rotation3::identity(), |turn, (axis, deg)| {
        let mut about = Vector3::zeros();
        about[axis] = 1.0;
        turn * Rotation3::from_axis_angle(&Unit::new_normalize(about), deg.to_radians())
    })
}

fn is_near(found: Option<[f64; 3]>, wanted: Vector3<f64>) -> bool {
    found.is_some_and(|found| (Vector3::from(found) - wanted).norm() < ROUNDING_MM)
}

const PLACE: [f64; 3] = [7.25, -3.5, 12.0];

/// A statement of a plane, with its zero and turns.
type Stated = (Dialect, String, [f64; 3], [(usize, f64); 3]);

/// Statements of planes, with the zero and the turns that they mean.
fn statements() -> Vec<Stated> {
    let mut all = vec![
        (
            Dialect::Iso,
            "G68.2 X10. Y-20. Z30. I30. J40. K50.\nG53.1\n".to_owned(),
            [10.0, -20.0, 30.0],
            [(2, 30.0), (0, 40.0), (2, 50.0)],
        ),
        (Dialect::Iso, "G68.2 P0 I-60 J25 K0\nG53.1".to_owned(), [0.0; 3], [(2, -60.0), (0, 25.0), (2, 0.0)]),
        (
            Dialect::Heidenhain,
            "PLANE SPATIAL SPA+27.5 SPB-15 SPC+45 TURN FMAX SEQ+ COORD ROT".to_owned(),
            [0.0; 3],
            [(2, 45.0), (1, -15.0), (0, 27.5)],
        ),
        (
            Dialect::Heidenhain,
            "12 PLANE SPATIAL SPA+0 SPB+45 SPC+90 MOVE DIST50 F2000".to_owned(),
            [0.0; 3],
            [(2, 90.0), (1, 45.0), (0, 0.0)],
        ),
    ];
    for (mode, axes) in
        [(57, [0, 1, 2]), (45, [0, 2, 1]), (54, [1, 0, 2]), (30, [1, 2, 0]), (39, [2, 0, 1]), (27, [2, 1, 0])]
    {
        let text = format!("CYCLE800(1,\"TC1\",0,{mode},0,0,0,20,-30,40.5,0,0,0,1,100,1)");
        let [a, b, c] = axes;
        all.push((Dialect::Siemens, text, [0.0; 3], [(a, 20.0), (b, -30.0), (c, 40.5)]));
    }
    all
}

fn program(dialect: Dialect, plane: &str, lines: &str) -> String {
    match dialect {
        Dialect::Heidenhain => {
            let lines = lines.replace("G0 ", "L ").replace("G1 ", "L ");
            format!("BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL A+0 C+0 FMAX\n{plane}\n{lines}END PGM P MM\n")
        }
        Dialect::Siemens => format!("G54 G0 A0 C0\n{plane}\n{lines}M30\n"),
        _ => format!("G54\nG0 A0 C0\n{plane}\n{lines}M30\n"),
    }
}

#[test]
fn a_place_in_a_plane_is_where_its_angles_put_it_and_the_tool_stands_across() {
    let [x, y, z] = PLACE;
    for (dialect, plane, zero, turns) in statements() {
        let text = program(dialect, &plane, &format!("G0 X{x} Y{y} Z{z}\n"));
        let found = motions(&ac_table(), dialect, &text);
        let last = found.last().unwrap();
        let turn = turned(turns);
        let wanted = Vector3::from(zero) + turn * Vector3::from(PLACE);
        assert!(is_near(last.tip_mm, wanted), "{plane}: {:?}, not {wanted:?}", last.tip_mm);
        assert!(is_near(last.axis, turn * Vector3::z()), "{plane}: {:?}", last.axis);
    }
}

/// `CYCLE800` moves the zero before the turns and after them. A vector plane has its axes by their directions.
#[test]
fn zeros_and_vectors_are_taken_as_they_are_written() {
    let text = program(Dialect::Siemens, "CYCLE800(0,\"\",0,57,10,20,30,90,0,0,1,2,3,1)", "G0 X5 Y0 Z0\n");
    // About X by 90: Y points to Z, and Z to -Y.
    let last = *motions(&ac_table(), Dialect::Siemens, &text).last().unwrap();
    assert!(is_near(last.tip_mm, Vector3::new(10.0 + 1.0 + 5.0, 20.0 - 3.0, 30.0 + 2.0)), "{last:?}");
    assert!(is_near(last.axis, -Vector3::y()), "{last:?}");
    let plane = "PLANE VECTOR BX+0 BY+0.5 BZ+0 NX+3 NY+0 NZ+4 TURN FMAX";
    let last = *motions(
        &ac_table(),
        Dialect::Heidenhain,
        &program(Dialect::Heidenhain, plane, "L X+1 Y+10 Z+100 FMAX\n"),
    )
    .last()
    .unwrap();
    // Y across both: the normal × the first axis.
    let wanted = Vector3::y() + 10.0 * Vector3::new(-0.8, 0.0, 0.6) + 100.0 * Vector3::new(0.6, 0.0, 0.8);
    assert!(is_near(last.tip_mm, wanted), "{last:?}");
    assert!(is_near(last.axis, Vector3::new(0.6, 0.0, 0.8)), "{last:?}");
}

#[test]
fn the_rotary_axes_stand_where_the_rule_puts_them_and_stay_there_after_the_plane() {
    let text =
        "G54\nG0 X0 Y0 Z0 A0 C0\nG68.2 X0 Y0 Z0 I90 J30 K0\nG53.1\nG0 X1 Y2 Z3\nG69\nG0 X10 Y0 Z5\nM30\n";
    // About Z by 90 and about the turned X by 30: the normal is (sin 30, 0, cos 30).
    for (axis, rule, words) in [
        (RotaryLetter::A, PlaneRule::PositiveFirst, [30.0, 90.0]),
        (RotaryLetter::A, PlaneRule::NegativeFirst, [-30.0, -90.0]),
        (RotaryLetter::C, PlaneRule::NegativeFirst, [-30.0, -90.0]),
    ] {
        let machine = ac_table().with_plane_solution(Some(PlaneSolution { rule, axis: Some(axis) }));
        let found = motions(&machine, Dialect::Iso, text);
        for motion in &found[1..] {
            let [.., a, c] = motion.joints;
            let near = (a.unwrap() - words[0]).abs() < 1e-9 && (c.unwrap() - words[1]).abs() < 1e-9;
            assert!(near, "{rule:?} {axis:?}: {motion:?}");
        }
        // After G69 X Y Z are words of the machine again.
        assert_eq!(found[2].joints[..3], [Some(10.0), Some(0.0), Some(5.0)]);
    }
}

#[test]
fn planes_that_are_not_certain_are_left_alone() {
    let iso = |lines: &str| (Dialect::Iso, format!("G54\nG0 A0 C0\n{lines}"));
    let siemens = |lines: &str| (Dialect::Siemens, format!("G54\nG0 A0 C0\n{lines}"));
    let heidenhain = |lines: &str| {
        (Dialect::Heidenhain, format!("BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL A+0 C+0 FMAX\n{lines}"))
    };
    let plane = "G68.2 X0 Y0 Z0 I90 J30 K0\n";
    let cycle = "CYCLE800(1,\"TC1\",0,57,0,0,0,0,30,0,0,0,0,1,100,1)\n";
    let spatial = "PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN FMAX\n";
    let tilted = Unfollowable::TiltedPlane;
    let rows = [
        // Not turned to the plane, turned away again, or turned with a word whose meaning differs.
        (iso(&format!("{plane}G0 X1 Y2 Z3\n")), tilted),
        (iso(&format!("{plane}G53.1\nG0 X1 Y2 Z3\nC10\nX2\n")), tilted),
        (iso(&format!("{plane}G53.1 P1\nG0 X1 Y2 Z3\n")), tilted),
        (iso(&format!("{plane}G53.6\nG0 X1 Y2 Z3\n")), tilted),
        // Forms whose meaning differs between controls.
        (iso("G68.2 P1 X0 Y0 Z0 I90 J30 K0\nG53.1\nG0 X1 Y2 Z3\n"), tilted),
        (iso("G68.2 Q121 X0 Y0 Z0 I90 J30 K0\nG53.1\nG0 X1 Y2 Z3\n"), tilted),
        (iso("G68.2 X0 Y0 Z0 I90 J30\nG53.1\nG0 X1 Y2 Z3\n"), tilted),
        (iso("G68.2 X0 Y0 I90 J30 K0\nG53.1\nG0 X1 Y2 Z3\n"), tilted),
        // So far away that places are rounded too much.
        (iso("G68.2 X100000000 Y0 Z0 I90 J30 K0\nG53.1\nG0 X1 Y2 Z3\n"), tilted),
        (iso("G68.3 X0 Y0 Z0\nG53.1\nG0 X1 Y2 Z3\n"), tilted),
        (iso(&format!("G91\n{plane}G53.1\nG90 G0 X1 Y2 Z3\n")), tilted),
        (iso(&format!("G18\n{plane}G53.1\nG0 X1 Y2 Z3\n")), tilted),
        // A plane in a plane, and other changes of the zero in it.
        (iso(&format!("{plane}{plane}G53.1\nG0 X1 Y2 Z3\n")), tilted),
        (iso(&format!("{plane}G53.1\nG52 X5\nG0 X1 Y2 Z3\n")), tilted),
        (iso(&format!("{plane}G53.1\nG55\nG0 X1 Y2 Z3\n")), tilted),
        (iso(&format!("{plane}G53.1\nG43.4 H1\nG0 X1 Y2 Z3\n")), tilted),
        (iso(&format!("{plane}G53.1\nG41 D1\nG0 X1 Y2 Z3\n")), Unfollowable::CutterCompensation),
        (iso(&format!("{plane}G53.1\nG51 P2.\nG0 X1 Y2 Z3\n")), Unfollowable::Transformation),
        (siemens(&cycle.replace(",0,57", ",1,57")), Unfollowable::Transformation),
        (siemens(&format!("{}G0 X1 Y2 Z3\n", cycle.replace(",0,57", ",1,57"))), Unfollowable::Transformation),
        (siemens(&format!("{}G0 X1 Y2 Z3\n", cycle.replace(",57,", ",192,"))), Unfollowable::Transformation),
        (siemens(&format!("{}G0 X1 Y2 Z3\n", cycle.replace("TC1", "0"))), Unfollowable::Transformation),
        (siemens(&format!("{}G0 X1 Y2 Z3\n", cycle.replace(",30,", ",R1,"))), Unfollowable::Transformation),
        (siemens(&format!("{}G0 X1 Y2 Z3\n", cycle.replace(",1,100", ",0,100"))), tilted),
        (siemens(&format!("TRANS X5\n{cycle}G0 X1 Y2 Z3\n")), Unfollowable::Transformation),
        (siemens(&format!("{cycle}TRANS X5\nG0 X1 Y2 Z3\n")), tilted),
        (siemens(&format!("{cycle}AROT Z5\nG0 X1 Y2 Z3\n")), Unfollowable::Transformation),
        (
            siemens(&format!("G70\n{}G0 X1 Y2 Z3\n", cycle.replace(",57,0", ",57,5"))),
            Unfollowable::Transformation,
        ),
        (heidenhain(&format!("{}L X+1 Y+2 Z+3 FMAX\n", spatial.replace("TURN FMAX", "STAY"))), tilted),
        (heidenhain(&format!("{}L X+1 Y+2 Z+3 FMAX\n", spatial.replace("SPB+30", "SPB+Q5"))), tilted),
        (heidenhain(&format!("{}L X+1 Y+2 Z+3 FMAX\n", spatial.replace(" SPC+0", ""))), tilted),
        (heidenhain(&format!("{spatial}PLANE RELATIV SPB+5 TURN FMAX\nL X+1 Y+2 Z+3 FMAX\n")), tilted),
        (heidenhain(&format!("{spatial}M128\nL X+1 Y+2 Z+3 FMAX\n")), tilted),
        (heidenhain(&format!("{spatial}CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X+5\nL X+1 Y+2 Z+3 FMAX\n")), tilted),
        (heidenhain("PLANE VECTOR BX+1 BY+0 BZ+0.1 NX+0 NY+0 NZ+1 TURN FMAX\nL X+1 Y+2 Z+3 FMAX\n"), tilted),
        // The rule looks at a sign, and the rotary axis next to the workpiece is free.
        (iso("G68.2 X0 Y0 Z0 I0 J0 K0\nG53.1\nG0 X1 Y2 Z3\n"), Unfollowable::PlaneSolution),
        (
            heidenhain(&format!("{}L X+1 Y+2 Z+3 FMAX\n", spatial.replace("+30", "+130"))),
            Unfollowable::PlaneSolution,
        ),
    ];
    for ((dialect, text), expected) in rows {
        let found = understood(dialect, &text);
        assert_eq!(last_reason(&found), Some(expected), "{text}: {found:?}");
    }
    // Without a rule in the profile.
    let unstated = ac_table().with_plane_solution(None);
    let (dialect, text) = iso(&format!("{plane}G53.1\nG0 X1 Y2 Z3\n"));
    let found = understood_on(&unstated, dialect, &text);
    assert_eq!(last_reason(&found), Some(Unfollowable::PlaneSolution), "{found:?}");
    // On a head the tip is known if a length is in force.
    let head = machine("ac-head", RotaryLetter::A);
    assert_eq!(last_reason(&understood_on(&head, dialect, &text)), Some(tilted));
    let (_, text) = iso(&format!("{plane}G53.1\nG43 H1\nG0 X1 Y2 Z3\n"));
    assert!(is_near(
        motions(&head, dialect, &text).last().unwrap().axis,
        Vector3::new(0.5, 0.0, 0.75_f64.sqrt())
    ));
}

/// A course of straight motions and arcs in XY of the plane.
#[derive(Debug, Clone, Copy)]
enum Step {
    Rapid([f64; 3]),
    Line([f64; 3], u32),
    /// To the opposite side of a circle about this offset, with a rise.
    HalfCircle([f64; 2], f64, bool),
}

fn step() -> impl Strategy<Value = Step> {
    let place = || prop::array::uniform3((-90_000_i32..90_000).prop_map(|value| f64::from(value) / 1000.0));
    let offset = prop::array::uniform2((1_000_i32..20_000).prop_map(|value| f64::from(value) / 1000.0));
    prop_oneof![
        place().prop_map(Step::Rapid),
        (place(), 100_u32..900).prop_map(|(place, feed)| Step::Line(place, feed)),
        (offset, -5_i32..5, any::<bool>()).prop_map(|(offset, rise, is_clockwise)| {
            Step::HalfCircle(offset, f64::from(rise), is_clockwise)
        }),
    ]
}

/// A place in the plane; for an arc also its centre, and whether it runs clockwise.
type Place = ([f64; 3], Option<([f64; 3], bool)>);

/// The text of a course, and its places in the plane with the centres of its arcs.
fn drawn(steps: &[Step]) -> (String, Vec<Place>) {
    let (mut at, mut text, mut places) = ([0.0; 3], "G0 X0 Y0 Z0\n".to_owned(), vec![([0.0; 3], None)]);
    for step in steps {
        let mut arc = None;
        match *step {
            Step::Rapid(to) => {
                writeln!(text, "G0 X{:.3} Y{:.3} Z{:.3}", to[0], to[1], to[2]).unwrap();
                at = to;
            }
            Step::Line(to, feed) => {
                writeln!(text, "G1 X{:.3} Y{:.3} Z{:.3} F{feed}", to[0], to[1], to[2]).unwrap();
                at = to;
            }
            Step::HalfCircle(offset, rise, is_clockwise) => {
                let to = [at[0] + 2.0 * offset[0], at[1] + 2.0 * offset[1], at[2] + rise];
                let code = if is_clockwise { "G2" } else { "G3" };
                writeln!(
                    text,
                    "{code} X{:.3} Y{:.3} Z{:.3} I{:.3} J{:.3} F500",
                    to[0], to[1], to[2], offset[0], offset[1]
                )
                .unwrap();
                arc = Some(([at[0] + offset[0], at[1] + offset[1], at[2]], is_clockwise));
                at = to;
            }
        }
        places.push((at, arc));
    }
    (text, places)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// On every layout of machine the motions in a plane are those that its angles give. Joints are those of the same
    /// places under tool-centre-point control: with them the tool stands across the plane.
    #[test]
    fn motions_in_a_plane_are_the_same_motions_turned(
        preset in prop::sample::select(PRESETS.to_vec()),
        k in 0_usize..2,
        angles in prop::array::uniform3(-50_i32..50),
        zero in prop::array::uniform3(-90_i32..90),
        steps in prop::collection::vec(step(), 1..12),
    ) {
        let parts = preset.parts();
        let axis = parts.rotary_axes[k].letter;
        let machine = machine(preset.id, axis);
        let [i, j, third] = angles.map(f64::from);
        let turn = turned([(2, i), (0, j), (2, third)]);
        let zero = zero.map(f64::from);
        let (course, places) = drawn(&steps);
        let [x, y, z] = zero;
        let text = format!("G54\nG68.2 X{x} Y{y} Z{z} I{i} J{j} K{third}\nG53.1\nG43 H1\n{course}M30\n");
        let found = understood_on(&machine, Dialect::Iso, &text);
        // Which position the control takes may not be decided. Then nothing is followed.
        if last_reason(&found) == Some(Unfollowable::PlaneSolution) {
            let is_left = |told: &Interpreted| matches!(told, Interpreted::LeftAlone { .. });
            prop_assert!(found.iter().all(is_left), "{:?}", found);
            return Ok(());
        }
        let found = motions(&machine, Dialect::Iso, &text);
        prop_assert_eq!(found.len(), places.len(), "{}", text);
        let kinematics = Kinematics::new(&machine, &Setup { apply_errors: false, ..Setup::default() });
        let to_workpiece = |at: [f64; 3]| Vector3::from(zero) + turn * Vector3::from(at);
        for (motion, (place, arc)) in found.iter().zip(places) {
            let wanted = to_workpiece(place);
            prop_assert!(is_near(motion.tip_mm, wanted), "{}: {:?} not {:?}", text, motion, wanted);
            let [jx, jy, jz, first, second] = motion.joints.map(Option::unwrap);
            prop_assert!(is_near(Some([jx, jy, jz]), wanted));
            let axes = machine.rotary_axes();
            let axis = kinematics.axis([axes[0].angle_rad(first), axes[1].angle_rad(second)]);
            prop_assert!((axis - turn * Vector3::z()).norm() < 1e-9);
            prop_assert!(is_near(motion.axis, turn * Vector3::z()));
            match arc {
                None => prop_assert!(motion.kind != InterpretedKind::Arc),
                Some((centre, is_clockwise)) => {
                    let told = motion.arc.unwrap();
                    let side = if is_clockwise { -1.0 } else { 1.0 };
                    prop_assert!(is_near(Some(told.centre_mm), to_workpiece(centre)), "{}: {:?}", text, told);
                    prop_assert!(is_near(Some(told.normal), turn * Vector3::z() * side));
                    // Both ends are rounded, so the half circle is one within this.
                    prop_assert!((told.turns - 0.5).abs() < 1e-3);
                }
            }
        }
    }
}

/// A drilled hole, and the same hole with the words of its motions.
#[test]
fn a_cycle_in_a_plane_makes_the_motions_of_its_hole_in_the_plane() {
    let head = "G54\nG0 A0 C0\nG68.2 X10 Y0 Z-5 I90 J30 K0\nG53.1\nG0 X0 Y0 Z20\n";
    let cycle = format!("{head}G99 G81 X5 Y6 Z-8 R2 F100\nX15\nG80\nM30\n");
    let words = format!("{head}G0 X5 Y6\nZ2\nG1 Z-8 F100\nG0 Z2\nX15\nG1 Z-8\nG0 Z2\nM30\n");
    let seen = |text: &str| {
        let found = motions(&ac_table(), Dialect::Iso, text);
        found.iter().skip(1).map(|motion| (motion.kind, motion.tip_mm, motion.axis)).collect::<Vec<_>>()
    };
    let (cycle, words) = (seen(&cycle), seen(&words));
    assert_eq!(cycle.len(), words.len(), "{cycle:?}\n{words:?}");
    for (a, b) in cycle.iter().zip(&words) {
        assert!(
            a.0 == b.0 && is_near(a.1, b.1.unwrap().into()) && is_near(a.2, b.2.unwrap().into()),
            "{a:?} {b:?}"
        );
    }
}

/// A program with a plane, and the same with tool-centre-point control.
fn both_ways() -> [String; 2] {
    let plane = "G54\nG0 A0 C0\nG68.2 X10 Y-20 Z30 I90 J30 K0\nG53.1\nG0 X0 Y0 Z50\nZ1\nG1 Z-2 F300\nX40 F900\nY25\nG91 X-10\nG90 G0 Z50\nG69\nM30\n";
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    let workpiece = |[x, y, z]: [f64; 3]| {
        // About Z by 90: X points to Y, Y to -X. About the turned X by 30: Y and Z turn on.
        [10.0 - cos * y + sin * z, -20.0 + x, 30.0 + sin * y + cos * z]
    };
    let mut text = "G54\nG0 A0 C0\nG43.4 H1\n".to_owned();
    for (place, code) in [
        ([0.0, 0.0, 50.0], "G0"),
        ([0.0, 0.0, 1.0], "G0"),
        ([0.0, 0.0, -2.0], "G1 F300"),
        ([40.0, 0.0, -2.0], "G1 F900"),
        ([40.0, 25.0, -2.0], "G1"),
        ([30.0, 25.0, -2.0], "G1"),
        ([30.0, 25.0, 50.0], "G0"),
    ] {
        let [x, y, z] = workpiece(place);
        writeln!(text, "{code} X{x:.9} Y{y:.9} Z{z:.9} A30 C90").unwrap();
    }
    [plane.to_owned(), text]
}

#[test]
fn a_program_with_a_plane_is_the_program_with_tool_centre_point_control() {
    let [planes, tips] = both_ways().map(|text| motions(&ac_table(), Dialect::Iso, &text));
    assert_eq!(planes.len(), tips.len());
    for (a, b) in planes.iter().zip(&tips).skip(1) {
        assert!((a.kind, a.feed_mm_per_min, a.work_offset) == (b.kind, b.feed_mm_per_min, b.work_offset));
        for (a, b) in a.joints.iter().zip(b.joints) {
            assert!((a.unwrap() - b.unwrap()).abs() < 2e-9, "{planes:?}\n{tips:?}");
        }
        assert!((Vector3::from(a.tip_mm.unwrap()) - Vector3::from(b.tip_mm.unwrap())).norm() < 2e-9);
        assert!((Vector3::from(a.axis.unwrap()) - Vector3::from(b.axis.unwrap())).norm() < 1e-12);
    }
}

fn set_up() -> ProgramSetup {
    let setup =
        Setup { work_offset_mm: Vec3::new(70.0, -40.0, 95.0), tool_length_mm: 80.0, apply_errors: false };
    ProgramSetup { dialect: Some(Dialect::Iso), apply_errors: false, ..ProgramSetup::in_mm(&setup) }
}

/// Machine words follow another rule than the plane: a caller that states the interpolation does not change the plane.
#[test]
fn the_drives_follow_a_plane_as_they_follow_the_tip() {
    let mut drives = DriveSet::default();
    for axis in [AxisLetter::X, AxisLetter::Y, AxisLetter::Z] {
        drives.set(axis, DrivePreset::by_id("reference-linear").unwrap().drive);
    }
    for axis in [AxisLetter::A, AxisLetter::C] {
        drives.set(axis, DrivePreset::by_id("reference-rotary").unwrap().drive);
    }
    let [plane, tip] = both_ways();
    let simulated = [(plane, Some(Interpolation::Machine)), (tip, None)].map(|(text, interpolation)| {
        let program = ProgramSetup { interpolation, ..set_up() };
        let parameters = SimulationParameters::new(drives, program);
        let source = text.into_bytes();
        simulate(&ac_table(), &parameters, &source, &|| ControlFlow::Continue(())).unwrap()
    });
    let [plane, tip] = &simulated;
    assert_eq!((plane.motions, plane.passes), (tip.motions, tip.passes));
    assert!(plane.motions == 4 && (plane.duration_s - tip.duration_s).abs() < 1e-9, "{plane:?}");
    let [plane, tip] = [plane, tip].map(|found| found.outcome.contour.max_abs_mm);
    assert!((plane - tip).abs() < 1e-6 && plane > 1e-3, "{plane} {tip}");
}

#[test]
fn a_plane_is_cut_as_by_the_tip() {
    let normal = Vec3::new(0.5, 0.0, 0.75_f64.sqrt());
    let (across, beside) = (Vec3::new(-normal.z, 0.0, normal.x), Vec3::new(0.0, 1.0, 0.0));
    let zero = Vec3::new(10.0, -20.0, 30.0);
    let samples: Vec<SurfacePoint> = (0..63)
        .map(|k| SurfacePoint {
            point_mm: zero + beside * (f64::from(k % 9) * 5.0) + across * (f64::from(k / 9) * 4.0),
            normal,
        })
        .collect();
    let radius = Length::from_mm(3.0);
    let verified = both_ways().map(|text| {
        let parameters = VerificationParameters::new(Tool::new(radius, radius).unwrap(), set_up());
        let source = text.into_bytes();
        let stop = || ControlFlow::Continue(());
        verify_part(&ac_table(), &parameters, &samples, &source, &OneAfterAnother, &stop).unwrap()
    });
    let [plane, tip] = verified.map(|found| {
        found
            .residuals
            .iter()
            .map(|residual| residual.map(|residual| residual.residual_mm))
            .collect::<Vec<_>>()
    });
    let near = |(a, b): (&Option<f64>, &Option<f64>)| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-6,
        (a, b) => a == b,
    };
    assert!(plane.iter().zip(&tip).all(near), "{plane:?}\n{tip:?}");
    // The slot is 2 mm deep.
    assert!(plane.iter().flatten().any(|residual| (residual + 2.0).abs() < 1e-6), "{plane:?}");
}
