//! Compensation of the cutter's radius: the tool runs at its radius beside the programmed path, without a gap.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test stops at the first surprise, helpers included, and ends in whole numbers are exact"
)]

use std::fmt::Write as _;

use proptest::prelude::*;

use trunnion::motion::Unfollowable;
use trunnion::process::{Interpreted, InterpretedKind, InterpretedMotion};
use trunnion::program::Dialect;

use crate::models::told::{ac_table, all_told, nominal};

fn understood(dialect: Dialect, text: &str) -> Vec<Interpreted> {
    all_told(&ac_table(), &nominal(dialect), text)
}

fn motions(text: &str) -> Vec<InterpretedMotion> {
    let told = understood(Dialect::Iso, text).into_iter().map(|told| match told {
        Interpreted::Motion(motion) => motion,
        Interpreted::LeftAlone { line, reason, .. } => panic!("{text}\nline {line}: {reason}"),
    });
    told.collect()
}

/// X and Y after a motion.
fn end(motion: &InterpretedMotion) -> [f64; 2] {
    [motion.joints[0].unwrap(), motion.joints[1].unwrap()]
}

/// A piece of a programmed path: its ends, and for an arc its centre and sense.
#[derive(Debug, Clone, Copy)]
struct Programmed {
    ends: [[f64; 2]; 2],
    arc: Option<([f64; 2], bool)>,
}

/// What is drawn of a piece: the turn before it [deg], its length or radius [mm], and for an arc its angle [deg],
/// negative clockwise.
type Drawn = (f64, f64, Option<f64>);

/// A path from drawn pieces, and its text.
fn path(drawn: &[Drawn]) -> (Vec<Programmed>, String) {
    let (mut at, mut heading_deg) = ([0.0, 0.0], 0.0_f64);
    let (mut pieces, mut text) = (Vec::new(), String::new());
    // As the text has it.
    let written = |value: f64| format!("{value:.7}").parse::<f64>().unwrap();
    for (turn_deg, size, arc_deg) in drawn {
        heading_deg += turn_deg;
        let (sin, cos) = heading_deg.to_radians().sin_cos();
        let from = at;
        let Some(arc_deg) = arc_deg else {
            at = [from[0] + size * cos, from[1] + size * sin].map(written);
            writeln!(text, "G1 X{:.7} Y{:.7}", at[0], at[1]).unwrap();
            pieces.push(Programmed { ends: [from, at], arc: None });
            continue;
        };
        let side = arc_deg.signum();
        let offset = [-side * size * sin, side * size * cos].map(written);
        let centre = [from[0] + offset[0], from[1] + offset[1]];
        let (sin, cos) = arc_deg.to_radians().sin_cos();
        let arm = [-offset[0], -offset[1]];
        at = [centre[0] + cos * arm[0] - sin * arm[1], centre[1] + sin * arm[0] + cos * arm[1]].map(written);
        let code = if side < 0.0 { "G2" } else { "G3" };
        writeln!(text, "{code} X{:.7} Y{:.7} I{:.7} J{:.7}", at[0], at[1], offset[0], offset[1]).unwrap();
        heading_deg += arc_deg;
        pieces.push(Programmed { ends: [from, at], arc: Some((centre, side < 0.0)) });
    }
    (pieces, text)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// How far left of the line or circle of a piece a point is [mm].
fn left_of(piece: &Programmed, at: [f64; 2]) -> f64 {
    let [from, to] = piece.ends;
    match piece.arc {
        None => {
            let along = [to[0] - from[0], to[1] - from[1]];
            (along[0] * (at[1] - from[1]) - along[1] * (at[0] - from[0])) / distance(from, to)
        }
        Some((centre, is_clockwise)) => {
            let outwards = distance(centre, at) - distance(centre, from);
            if is_clockwise { outwards } else { -outwards }
        }
    }
}

/// Points on the course of a motion from a place on.
fn course(from: [f64; 2], motion: &InterpretedMotion) -> Vec<[f64; 2]> {
    let to = end(motion);
    (0..=16)
        .map(|k| {
            let u = f64::from(k) / 16.0;
            let Some(arc) = motion.arc.filter(|_| motion.kind == InterpretedKind::Arc) else {
                return [from[0] + u * (to[0] - from[0]), from[1] + u * (to[1] - from[1])];
            };
            let (sin, cos) = (u * arc.turns * std::f64::consts::TAU * arc.normal[2]).sin_cos();
            let arm = [from[0] - arc.centre_mm[0], from[1] - arc.centre_mm[1]];
            [arc.centre_mm[0] + cos * arm[0] - sin * arm[1], arc.centre_mm[1] + sin * arm[0] + cos * arm[1]]
        })
        .collect()
}

/// Rounding of words with seven decimals [mm].
const ROUNDING_MM: f64 = 2e-6;

fn drawn() -> impl Strategy<Value = Vec<Drawn>> {
    let turn = prop_oneof![Just(0.0), -75.0..-4.0, 4.0..75.0];
    let line = (turn.clone(), 15.0..40.0).prop_map(|(turn, size)| (turn, size, None));
    let arc = (turn, 10.0..20.0, prop_oneof![-120.0..-50.0, 50.0..120.0])
        .prop_map(|(turn, size, arc)| (turn, size, Some(arc)));
    let way_in = (15.0..40.0).prop_map(|size| (0.0, size, None));
    (way_in, prop::collection::vec(prop_oneof![line, arc], 1..8)).prop_map(|(first, mut rest)| {
        rest.insert(0, first);
        rest
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn the_tool_runs_at_its_radius_beside_the_path_and_around_its_corners(
        drawn in drawn(),
        radius in 0.4_f64..1.5,
        is_left in any::<bool>(),
    ) {
        let (pieces, text) = path(&drawn);
        let code = if is_left { "G41.1" } else { "G42.1" };
        let beside = if is_left { radius } else { -radius };
        let text =
            format!("G17 G0 X0 Y0 Z5 A0 C0\n{code} D{:.9}\nF100\n{text}G40\nG1 X-50 Y-50\n", 2.0 * radius);
        let found = motions(&text);
        let mut at = end(&found[0]);
        for (index, piece) in pieces.iter().enumerate() {
            let line = index as u64 + 4;
            let own: Vec<_> = found.iter().filter(|motion| motion.line == line).collect();
            prop_assert!((1..=2).contains(&own.len()), "{}\nline {}: {}", text, line, own.len());
            if let [around, _] = own[..] {
                let corner = piece.ends[0];
                prop_assert_eq!(around.kind, InterpretedKind::Arc);
                for point in course(at, around) {
                    prop_assert!((distance(point, corner) - radius).abs() < ROUNDING_MM, "{}\nline {}", text, line);
                }
                // Around the outer side of the corner, which is less than a half turn.
                prop_assert!(around.arc.unwrap().turns < 0.5);
                at = end(around);
            }
            let last = own[own.len() - 1];
            let points = course(at, last);
            prop_assert!(distance(points[points.len() - 1], end(last)) < ROUNDING_MM, "{}\nline {}", text, line);
            // The first piece is the way in.
            let beside_it = if index == 0 { &points[points.len() - 1..] } else { &points[..] };
            for point in beside_it {
                let left = left_of(piece, *point);
                prop_assert!(
                    (left - beside).abs() < ROUNDING_MM,
                    "{}\nline {}: {:?} is {} left", text, line, point, left
                );
            }
            at = end(last);
            if let Some(next) = pieces.get(index + 1) {
                // Where the tool begins the next piece, or the arc around the corner, it is at its radius from both.
                let is_around = found.iter().filter(|motion| motion.line == line + 1).count() == 2;
                let left = if is_around { beside } else { left_of(next, at) };
                prop_assert!((left - beside).abs() < ROUNDING_MM, "{}\nline {}: {}", text, line, left);
            }
        }
        let last = found.last().unwrap();
        prop_assert_eq!(end(last), [-50.0, -50.0]);
    }
}

/// X Y Z after the last motion of a program whose motions before may be left alone.
fn last_place(dialect: Dialect, text: &str) -> [Option<f64>; 3] {
    let found = understood(dialect, text);
    let Some(Interpreted::Motion(last)) = found.last() else { panic!("{text}\n{found:?}") };
    [last.joints[0], last.joints[1], last.joints[2]]
}

const START: &str = "G17 G90 G94 G0 X0 Y0 Z5 A0 C0\n";

#[test]
fn the_way_in_and_the_way_out_are_straight() {
    let found = motions(&format!("{START}G41.1 D4\nG1 X10 F100\nX20\nG1 Z1\nY10\nG40\nG1 X30 Y0\nX40\n"));
    let ends: Vec<_> = found.iter().map(end).collect();
    let ends_in_order =
        [[0.0, 0.0], [10.0, 2.0], [18.0, 2.0], [18.0, 2.0], [18.0, 10.0], [30.0, 0.0], [40.0, 0.0]];
    assert_eq!(ends, ends_in_order);
    // The tool goes down in the corner.
    assert_eq!(found[3].joints[2], Some(1.0));
    // A motion without the axes of the plane goes back to the programmed place, too.
    let found = motions(&format!("{START}G41.1 D4\nG1 X10 F100\nX20\nG40\nG0 Z50\n"));
    assert_eq!(found.last().unwrap().joints[..3], [Some(20.0), Some(0.0), Some(50.0)]);
    // A negative diameter changes the side, and none is no compensation.
    assert_eq!(end(&motions(&format!("{START}G42.1 D-4\nG1 X10 F100\nG40\nG1 X0 Y9\n"))[1]), [10.0, 2.0]);
    assert_eq!(end(&motions(&format!("{START}G42.1 D0\nG1 X10 F100\nG40\nG1 X0 Y9\n"))[1]), [10.0, 0.0]);
    // Inches.
    assert_eq!(
        end(&motions("G20 G17 G0 X0 Y0 Z1 A0 C0\nG41.1 D2\nG1 X10 F9\nG40\nX0 Y9\n")[1]),
        [254.0, 25.4]
    );
}

#[test]
fn a_path_is_held_back_until_its_next_motion_wherever_that_is() {
    // Comments put the next motion into another batch, and the program ends without G40.
    let comments = "(x)\n".repeat(9000);
    let text = format!("{START}G41.1 D4\nG1 X10 F100\nX20\n{comments}Y10\nY20\n{comments}");
    let ends: Vec<_> = motions(&text).iter().map(end).collect();
    assert_eq!(ends, [[0.0, 0.0], [10.0, 2.0], [18.0, 2.0], [18.0, 10.0], [18.0, 20.0]]);
    // In loops.
    let text =
        format!("{START}G41.1 D4\nG1 X10 F100\nG91\no1 repeat [2]\nX10\nY10\no1 endrepeat\nG40\nG90 X0 Y0\n");
    let lines: Vec<_> = motions(&text).iter().map(|motion| motion.line).collect();
    assert_eq!(lines, [1, 3, 6, 7, 6, 6, 7, 10]);
}

/// Blocks under compensation that are left alone with those after them, until a block names X and Y without it.
const LEFT_ALONE: [&str; 18] = [
    // Its radius is not in the text.
    "G41 D1\nG1 X10 F100\nX20\n",
    "G41\nG1 X10 F100\nX20\n",
    "G41.1\nG1 X10 F100\nX20\n",
    "G41.1 D#500\nG1 X10 F100\nX20\n",
    "G41.1 D1 L2\nG1 X10 F100\nX20\n",
    // It is switched on twice.
    "G41.1 D1\nG1 X10 F100\nG41.1 D2\nX20\n",
    // The way in is too short, it is an arc, or the block does not move in the plane.
    "G41.1 D4\nG1 X2 F100\nX20\n",
    "G41.1 D4\nG2 X10 I5 F100\nG1 X20\n",
    "G41.1 D4\nG1 Z2 F100\nX20\n",
    // An arc misses its end by 0.006 mm.
    "G41.1 D4\nG1 X10 F100\nG2 X20.006 Y0 I5 J0\nG1 X40\n",
    // An arc behind a turn of 0.04 rad grows before an outer corner, and another one leaves its circle.
    "G42.1 D6\nG1 X-6.7 Y0.5328 F100\nG2 X10.8448 Y17.1294 I0.5494 J16.9911\nG1 X12.3157 Y35.9861\n",
    "G41.1 D10\nG1 X9.5293565 Y4.1611063 F100\nG3 X13.2447783 Y17.1072963 I-4.0437178 J8.1667436\nG1 Z-1.97\n",
    // The way out is an arc.
    "G41.1 D4\nG1 X10 F100\nX20\nG40\nG2 X30 I5\n",
    // Too narrow an arc, and pieces too short for an inner corner.
    "G41.1 D4\nG1 X10 F100\nG3 X10 Y2 J1\n",
    "G41.1 D4\nG1 X10 F100\nX11\nY10\nX-20\n",
    "G41.1 D4\nG1 X10 F100\nX20\nY1\nX10\n",
    // Rotary axes turn, a word is not known.
    "G41.1 D4\nG1 X10 F100\nX20 C10\n",
    "G41.1 D4\nG1 X10 F100\nX#500\nX30 Y10\n",
];

#[test]
fn a_path_that_is_not_known_is_left_alone_and_so_is_the_place_after_it() {
    for blocks in LEFT_ALONE {
        let before = understood(Dialect::Iso, &format!("{START}{blocks}"));
        let left = before.iter().filter(|told| matches!(told, Interpreted::LeftAlone { .. })).count();
        assert!(left > 0, "{blocks}");
        let place = |after: &str| last_place(Dialect::Iso, &format!("{START}{blocks}G40\n{after}"));
        assert_eq!(place("G90 G0 Z50\n"), [None, None, Some(50.0)], "{blocks}");
        assert_eq!(place("G90 G1 X3\n")[..2], [Some(3.0), None], "{blocks}");
        assert_eq!(place("G90 G1 X3\nY4\n")[..2], [Some(3.0), Some(4.0)], "{blocks}");
        assert_eq!(place("G90 G1 X3 Y4\nX9\n")[..2], [Some(9.0), Some(4.0)], "{blocks}");
    }
}

#[test]
fn the_plane_yz_is_left_alone() {
    let found = understood(Dialect::Iso, &format!("{START}G19 G41.1 D4\nG1 Y10 F100\nY20\nG40\nG1 X3\n"));
    let is_left = |told: &Interpreted| matches!(told, Interpreted::LeftAlone { .. });
    assert_eq!(found.iter().map(is_left).collect::<Vec<_>>(), [false, true, true, false]);
    let Some(Interpreted::Motion(last)) = found.last() else { panic!("{found:?}") };
    assert_eq!(last.joints[..3], [Some(3.0), None, None]);
}

#[test]
fn after_compensation_other_dialects_name_both_axes_too() {
    let blocks = "L X+0 Y+0 Z+5 R0 FMAX\nL X+10 RL F100\nL X+20\n";
    let place = |after: &str| last_place(Dialect::Heidenhain, &format!("{blocks}{after}"));
    assert_eq!(place("L Z+50 R0 FMAX\n"), [None, None, Some(50.0)]);
    assert_eq!(place("L X+3 Y+4 R0\n"), [Some(3.0), Some(4.0), Some(5.0)]);
    let found = understood(Dialect::Siemens, "G17 G0 X0 Y0 Z5 A0 C0\nT1 D1\nG41 G1 X10 F100\nX20\nG40 X30\n");
    assert!(matches!(found[1], Interpreted::LeftAlone { reason: Unfollowable::CutterCompensation, .. }));
    let Some(Interpreted::Motion(last)) = found.last() else { panic!("{found:?}") };
    assert_eq!(last.joints[..2], [Some(30.0), None]);
}
