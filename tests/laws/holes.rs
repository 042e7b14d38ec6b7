//! Cycles of Sinumerik and Heidenhain controls that make one hole are the motions that their manuals describe.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::fmt::Write as _;
use std::ops::ControlFlow;

use proptest::prelude::*;

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, PlaneRule, PlaneSolution, Preset, RotaryLetter};
use trunnion::motion::Unfollowable;
use trunnion::process::{Interpreted, InterpretedKind, ProgramSetup, interpret_program};
use trunnion::program::Dialect;

use InterpretedKind::{Linear, Rapid};

/// Lengths of these programs have three decimals [mm].
const ROUNDING_MM: f64 = 1e-9;

/// What a program makes: kind, X Y Z and feed of a motion, or the line and the reason of a block that is left alone.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Told {
    Motion(InterpretedKind, [Option<f64>; 3], Option<f64>),
    Left(u64, Unfollowable),
}

fn told(dialect: Dialect, text: &str) -> Vec<Told> {
    let rule = PlaneSolution { rule: PlaneRule::PositiveFirst, axis: Some(RotaryLetter::A) };
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let machine = machine.with_plane_solution(Some(rule));
    let program = ProgramSetup {
        dialect: Some(dialect),
        apply_errors: false,
        ..ProgramSetup::in_mm(&Setup::default())
    };
    let mut all = Vec::new();
    let mut take = |told: &Interpreted| {
        all.push(match told {
            Interpreted::Motion(motion) => {
                let tip = motion.tip_mm.map_or([None; 3], |tip| tip.map(Some));
                let [x, y, z, ..] = motion.joints;
                // In a tilted plane the machine's words are others.
                let at = if motion.joints[3].is_some_and(|turn| turn.abs() > 0.0) { tip } else { [x, y, z] };
                Told::Motion(motion.kind, at, motion.feed_mm_per_min)
            }
            Interpreted::LeftAlone { line, reason, .. } => Told::Left(*line, *reason),
        });
        Ok(())
    };
    let source = text.as_bytes().to_vec();
    interpret_program(&machine, &program, &source, &mut take, &|| ControlFlow::Continue(())).unwrap();
    all
}

fn motion(kind: InterpretedKind, at: [f64; 3], feed: f64) -> Told {
    Told::Motion(kind, at.map(Some), (kind == Linear).then_some(feed))
}

fn is_near(found: &[Told], wanted: &[Told]) -> bool {
    found.len() == wanted.len()
        && found.iter().zip(wanted).all(|(found, wanted)| match (found, wanted) {
            (Told::Motion(kind, at, feed), Told::Motion(other, to, other_feed)) => {
                let near = |a: &Option<f64>, b: &Option<f64>| match (a, b) {
                    (Some(a), Some(b)) => (a - b).abs() < ROUNDING_MM,
                    (a, b) => a == b,
                };
                kind == other && at.iter().zip(to).all(|(a, b)| near(a, b)) && near(feed, other_feed)
            }
            (found, wanted) => found == wanted,
        })
}

/// A hole by its levels, and its feeds down and up.
#[derive(Debug, Clone, Copy)]
struct Hole {
    plane: f64,
    depth: f64,
    end: f64,
    feeds: [f64; 2],
    /// Up to the plane at feed.
    slowly_up: bool,
}

/// The reference: the motions of a hole at X Y from this height, without those that do not move.
fn written_out([x, y]: [f64; 2], from: f64, hole: Hole) -> Vec<Told> {
    let mut course = vec![(Rapid, hole.plane, 0.0), (Linear, hole.depth, hole.feeds[0])];
    if hole.slowly_up {
        course.push((Linear, hole.plane, hole.feeds[1]));
    }
    course.push((Rapid, hole.end, 0.0));
    let mut at = from;
    let mut all = Vec::new();
    for (kind, to, feed) in course {
        if (to - at).abs() > 0.0 {
            all.push(motion(kind, [x, y, to], feed));
        }
        at = to;
    }
    all
}

/// All but the first motions, which make the positions known.
fn after_start(all: &[Told], start: usize) -> &[Told] {
    all.get(start..).unwrap_or_default()
}

const SIEMENS: &str = "G71 G17 G90 G94 G40\nG0 X1 Y2 Z50 A0 C0\nF100\n";
const HEIDENHAIN: &str = "BEGIN PGM P MM\nL X+1 Y+2 Z+50 A+0 C+0 R0 FMAX\n";

fn siemens(text: &str) -> Vec<Told> {
    after_start(&told(Dialect::Siemens, &format!("{SIEMENS}{text}")), 1).to_vec()
}

fn heidenhain(text: &str) -> Vec<Told> {
    after_start(&told(Dialect::Heidenhain, &format!("{HEIDENHAIN}{text}")), 1).to_vec()
}

const DEEP: Hole = Hole { plane: 5.0, depth: -12.5, end: 20.0, feeds: [100.0; 2], slowly_up: false };

/// One hole with surface 3, clearance 2, depth -12.5 and retract plane 20, as every cycle writes it.
#[test]
fn every_sinumerik_cycle_makes_the_motions_of_its_manual() {
    let bore = Hole { slowly_up: true, ..DEEP };
    let ream = Hole { feeds: [80.0, 250.0], slowly_up: true, ..DEEP };
    for (cycle, hole) in [
        ("CYCLE81(20,3,2,-12.5)", DEEP),
        ("CYCLE81(20,3,2,-12.5,0)", DEEP),
        ("CYCLE81(20,3,2,,15.5)", DEEP),
        ("N10 CYCLE81 ( 20. , 3 , 2 , -12.5 , 15.5 ) ; note", DEEP),
        ("CYCLE81(20,3,2,-12.5,,0,0,10)", DEEP),
        ("CYCLE81(20,3,2,-12.5,0,0.6,0,1,12)", DEEP),
        ("CYCLE81(20,3,2,-99,15.5,,0,0,11)", DEEP),
        ("CYCLE81(20,3,2,-12.5,99,,0,0,12)", DEEP),
        ("cycle82(20,3,2,-12.5,,1.5)", DEEP),
        ("CYCLE82(20,3,2,-12.5,,-2,0,0,10)", DEEP),
        ("CYCLE82(20,5,,-12.5)", DEEP),
        ("R1=3\nR2=R1-1\nCYCLE82(20,R1,R2,-10-2.5)", DEEP),
        ("DEF REAL TOP=3\nCYCLE81(TOP+17,TOP,2,,TOP*5+0.5)", DEEP),
        ("CYCLE83(20,3,2,-12.5,,-2,,1,0.1,0.2,1,0)", DEEP),
        ("CYCLE83(20,3,2,,15.5,,5,0,,,1,1,,2,1.4,0.6,1.6)", DEEP),
        ("CYCLE83(20,3,2,-12.5,,-2,,1,,0,1,1,,2,0,0,0,0,0,1001110)", DEEP),
        ("CYCLE85(20,3,2,-12.5,,0.5,80,250)", ream),
        ("CYCLE85(20,3,2,-12.5,,,80,250,0,1,2)", ream),
        ("CYCLE86(20,3,2,-12.5,,1,3,0,0,0,45)", DEEP),
        ("CYCLE86(20,3,2,-12.5,,1,3)", DEEP),
        ("CYCLE87(20,3,2,-12.5,,3)", DEEP),
        ("CYCLE88(20,3,2,-12.5,,1,3)", DEEP),
        ("CYCLE89(20,3,2,-12.5,,1)", bore),
    ] {
        let found = siemens(&format!("{cycle}\nG0 X9 Y2 Z30\n"));
        let mut wanted = written_out([1.0, 2.0], 50.0, hole);
        wanted.push(motion(Rapid, [9.0, 2.0, 30.0], 0.0));
        assert!(is_near(&found, &wanted), "{cycle}\n{found:?}\n{wanted:?}");
    }
}

#[test]
fn a_modal_cycle_makes_a_hole_after_every_block_that_names_a_place() {
    let text = "MCALL CYCLE82(20,3,2,-12.5,,1)\nX1 F60\nM8\n; note\nY7\nG4 F1\nF80\nG1 X5 Y5\nG91 G0 X2\nG90\nMCALL\nX9\nCYCLE81(20,3,2,,15.5)\n";
    let (sixty, eighty) = (Hole { feeds: [60.0; 2], ..DEEP }, Hole { feeds: [80.0; 2], ..DEEP });
    let mut wanted = vec![motion(Rapid, [1.0, 2.0, 50.0], 0.0)];
    wanted.extend(written_out([1.0, 2.0], 50.0, sixty));
    wanted.push(motion(Rapid, [1.0, 7.0, 20.0], 0.0));
    wanted.extend(written_out([1.0, 7.0], 20.0, sixty));
    wanted.push(motion(Linear, [5.0, 5.0, 20.0], 80.0));
    wanted.extend(written_out([5.0, 5.0], 20.0, eighty));
    wanted.push(motion(Rapid, [7.0, 5.0, 20.0], 0.0));
    wanted.extend(written_out([7.0, 5.0], 20.0, eighty));
    wanted.push(motion(Rapid, [9.0, 5.0, 20.0], 0.0));
    wanted.extend(written_out([9.0, 5.0], 20.0, eighty));
    let found = siemens(text);
    assert!(is_near(&found, &wanted), "{found:?}\n{wanted:?}");
}

#[test]
fn a_hole_is_along_the_axis_of_the_plane_in_the_unit_of_the_program() {
    let found = siemens("G19\nCYCLE82(1,-3,2,-12.5,,,0,3)\n");
    assert_eq!(found.first(), Some(&motion(Rapid, [-1.0, 2.0, 50.0], 0.0)), "{found:?}");
    assert_eq!(found.get(1), Some(&motion(Linear, [-12.5, 2.0, 50.0], 100.0)));
    assert_eq!(found.get(2), Some(&motion(Rapid, [1.0, 2.0, 50.0], 0.0)));
    let found = siemens("G70\nG0 X0 Y0 Z2\nCYCLE85(1,0,0.5,,1,,4,8)\n");
    let hole =
        Hole { plane: 12.7, depth: -25.4, end: 25.4, feeds: [4.0 * 25.4, 8.0 * 25.4], slowly_up: true };
    let wanted = written_out([0.0; 2], 50.8, hole);
    assert!(is_near(after_start(&found, 1), &wanted), "{found:?}\n{wanted:?}");
}

#[test]
fn offsets_turns_and_tip_control_move_the_hole_as_they_move_its_motions() {
    let written = "G0 Z5\nG1 Z-12.5\nG0 Z20\n";
    for (frame, place) in [
        ("TRANS X100 Y50 Z-7\nG0 X1 Y2 Z50\n", ""),
        ("ROT Z30\nG0 X1 Y2 Z50\n", ""),
        ("ROT X-90\nG0 X1 Y2 Z50\n", "G0 X4 Y-7\n"),
        ("TRAORI\nG0 X1 Y2 Z50 A0 C0\n", ""),
        ("TRAORI\nG0 X1 Y2 Z50 A30 C-20\n", "G0 X3\n"),
        ("CYCLE800(1,\"TC1\",0,57,0,0,0,30,0,20,0,0,0,1,100,1)\nG0 X1 Y2 Z50\n", "X2\n"),
    ] {
        let by_cycle = siemens(&format!("{frame}{place}CYCLE81(20,3,2,-12.5)\nG0 X9\n"));
        let by_words = siemens(&format!("{frame}{place}{written}G0 X9\n"));
        assert!(by_cycle.len() > 4 && is_near(&by_cycle, &by_words), "{frame}\n{by_cycle:?}\n{by_words:?}");
        let wide = siemens(&format!("{frame}MCALL CYCLE81(20,3,2,-12.5)\nX1 Y2\n{place}MCALL\nG0 X9\n"));
        assert!(wide.len() >= by_words.len(), "{frame}\n{wide:?}");
        let left = wide.iter().filter(|told| matches!(told, Told::Left(..))).count();
        assert_eq!(left, by_words.iter().filter(|told| matches!(told, Told::Left(..))).count(), "{frame}");
    }
}

/// Cycles that no manual makes certain, each at a known place.
const UNCERTAIN: [&str; 30] = [
    // A plane, the surface or the depth is missing or not known.
    "CYCLE81(20,3,2)",
    "CYCLE81(,3,2,-12.5)",
    "CYCLE81(20,,2,-12.5)",
    "CYCLE81(20,3,2,R77)",
    "CYCLE81(20,AC(3),2,-12.5)",
    // Two depths, no depth, a depth above the surface, a clearance below it.
    "CYCLE81(20,3,2,-12.5,10)",
    "CYCLE81(20,3,2,,0)",
    "CYCLE81(20,3,2,30)",
    "CYCLE81(20,3,2,3)",
    "CYCLE81(20,3,-2,-12.5)",
    "CYCLE81(20,3,2,,-15.5)",
    // The retract plane is below the surface, or the surface itself with a relative depth.
    "CYCLE81(2,3,2,-12.5)",
    "CYCLE81(3,3,2,,15.5)",
    // The place before it is below the clearance.
    "CYCLE81(90,80,2,-12.5)",
    // Another reference of the depth, another plane, arguments that are not known.
    "CYCLE82(20,3,2,-12.5,,1,1)",
    "CYCLE82(20,3,2,-12.5,,1,0,2)",
    "CYCLE82(20,3,2,-12.5,,1,0,1,13)",
    "CYCLE82(20,3,2,-12.5,,1,0,1,12,1)",
    // The first peck has another feed.
    "CYCLE83(20,3,2,-12.5,,-2,,1,,,0.5,1)",
    "CYCLE83(20,3,2,-12.5,,-2,,1,,,R5,1)",
    "CYCLE83(20,3,2,-12.5,,-2,,1,,,1,2)",
    "CYCLE83(20,3,2,-12.5,,-2,,1,,,1,1,2)",
    // No feeds of its own.
    "CYCLE85(20,3,2,-12.5,,1)",
    "CYCLE85(20,3,2,-12.5,,1,80,0)",
    // At feed the tool would end below the clearance.
    "CYCLE89(4,3,2,-12.5)",
    // Aside at the bottom.
    "CYCLE86(20,3,2,-12.5,,,3,-.2,0,.2,0)",
    // Other words, other modes, a pattern.
    "X5 CYCLE81(20,3,2,-12.5)",
    "/CYCLE81(20,3,2,-12.5)",
    "POCKET3(20,3,2,-12.5)",
    "HOLES2(0,0,20,0,90,4)",
];

#[test]
fn what_no_manual_makes_certain_is_left_alone_and_the_place_is_unknown_after_it() {
    for cycle in UNCERTAIN {
        let found = siemens(&format!("{cycle}\nG0 X9\n"));
        let is_skipped = cycle.starts_with('/');
        let made = found.iter().filter(|told| matches!(told, Told::Left(4, _))).count();
        assert_eq!(made, 1, "{cycle}: {found:?}");
        assert!(is_skipped || found.len() == 2, "{cycle}: {found:?}");
        let Some(Told::Motion(_, [x, _, z], _)) = found.last() else { panic!("{cycle}: {found:?}") };
        assert_eq!((*x, *z), (Some(9.0), None), "{cycle}");
    }
    for modes in ["G41 D1", "G93 F2", "SCALE X2", "MIRROR X0"] {
        let found = siemens(&format!("{modes}\nCYCLE81(20,3,2,-12.5)\nG40\n"));
        assert_eq!(found, [Told::Left(5, Unfollowable::CannedCycle)], "{modes}");
    }
}

#[test]
fn words_of_places_beside_a_dwell_or_behind_a_modal_cycle_are_never_lost() {
    let found = siemens("MCALL CYCLE81(20,3,2,-12.5)\nX5 G4 F1\nMCALL\nX7\n");
    assert_eq!(found[0], Told::Left(5, Unfollowable::ConflictingCodes), "{found:?}");
    let found = siemens("X5 G4 F1\nY7\n");
    assert_eq!(found[0], Told::Left(4, Unfollowable::ConflictingCodes), "{found:?}");
    let Told::Motion(_, [x, ..], _) = found[1] else { panic!("{found:?}") };
    assert_eq!(x, None);
    for cycle in ["CYCLE81(20,3,2,-12.5)", "CYCLE86(20,3,2,-12.5,,,3,-.2,0,.2,0)", "CYCLE840(1,2)"] {
        let found = siemens(&format!("MCALL {cycle} X5\nY7\n"));
        assert!(matches!(found[0], Told::Left(4, _)), "{cycle}: {found:?}");
        assert!(!found.iter().skip(1).any(|told| matches!(told, Told::Motion(..))), "{cycle}: {found:?}");
        let found = siemens(&format!("MCALL {cycle} ; a comment\nY7\n"));
        assert!(!matches!(found[0], Told::Left(4, _)), "{cycle}: {found:?}");
    }
}

#[test]
fn a_modal_cycle_that_is_not_followed_leaves_the_way_to_its_places_followed() {
    let found = siemens("MCALL CYCLE86(20,3,2,-12.5,,,3,-.2,0,.2,0)\nX5 Y6\nX7 Y8\nMCALL\nG0 X9 Y9 Z50\n");
    let left = |line| Told::Left(line, Unfollowable::CannedCycle);
    // After the block, no place is known.
    let unknown = Told::Motion(Rapid, [None; 3], None);
    let wanted = [
        motion(Rapid, [5.0, 6.0, 50.0], 0.0),
        left(5),
        unknown,
        left(6),
        motion(Rapid, [9.0, 9.0, 50.0], 0.0),
    ];
    assert!(is_near(&found, &wanted), "{found:?}");
}

/// A thread has the pitch times the speed as its feed, if the cycle states both.
#[test]
fn a_thread_goes_down_and_up_to_the_clearance_at_the_feed_of_its_pitch() {
    let thread = |plane: f64, depth: f64, end: f64, feeds: [Option<f64>; 2]| {
        let at = |z: f64| [1.0, 2.0, z].map(Some);
        let mut all = vec![
            Told::Motion(Rapid, at(plane), None),
            Told::Motion(Linear, at(depth), feeds[0]),
            Told::Motion(Linear, at(plane), feeds[1]),
        ];
        if end > plane {
            all.push(Told::Motion(Rapid, at(end), None));
        }
        all
    };
    for (cycle, feeds) in [
        ("CYCLE84(20,3,2,-12.5,,,3,,1.25,0,500,800)", [Some(625.0), Some(1000.0)]),
        ("CYCLE84(20,3,2,-12.5,,,3,,-1.25,0,500)", [Some(625.0); 2]),
        ("CYCLE84(20,3,2,-12.5,,,3,,1.25,0,500,0)", [Some(625.0); 2]),
        // The pitch of a standard thread, a speed of the program, and a speed that is not known.
        ("CYCLE84(20,3,2,-12.5,,,3,8,,0,500,500)", [None; 2]),
        ("CYCLE84(20,3,2,-12.5,,,3,,1.25,0)", [None; 2]),
        ("CYCLE84(20,3,2,-12.5,,,3,,1.25,0,500,R7)", [None; 2]),
        ("CYCLE84(20,3,2,,15.5)", [None; 2]),
        ("CYCLE840(20,3,2,-12.5,,0,4,3,0,,1.25)", [None; 2]),
    ] {
        let found = siemens(&format!("{cycle}\nG0 X1\n"));
        let mut wanted = thread(5.0, -12.5, 20.0, feeds);
        wanted.push(motion(Rapid, [1.0, 2.0, 20.0], 0.0));
        assert!(is_near(&found, &wanted), "{cycle}\n{found:?}\n{wanted:?}");
    }
    // F of the program is no feed of a thread, and it is not known after the thread.
    let found = siemens("G95 F0.5\nCYCLE84(20,3,2,-12.5,,,3,,1.25,0,500)\nG94 G1 X5\n");
    assert_eq!(found.get(1), Some(&Told::Motion(Linear, [1.0, 2.0, -12.5].map(Some), None)), "{found:?}");
    for (cycle, feeds) in [
        (with_levels(206, &[(206, "+80"), (211, "+0")]), [Some(80.0); 2]),
        (with_levels(207, &[(239, "+1")]), [None; 2]),
        (with_levels(209, &[(239, "+1"), (257, "+5"), (256, "+1"), (336, "+0"), (403, "+1")]), [None; 2]),
    ] {
        let found = heidenhain(&format!("{cycle}CYCL CALL\nL X+1 FMAX\n"));
        let mut wanted = thread(5.0, -12.5, 20.0, feeds);
        wanted.push(motion(Rapid, [1.0, 2.0, 20.0], 0.0));
        assert!(is_near(&found, &wanted), "{cycle}\n{found:?}\n{wanted:?}");
    }
    // A thread does not run at F. Under M136 F has another unit, so the feed is left out.
    for (number, more) in [(206, vec![(206, "+80"), (211, "+0")]), (207, vec![(239, "+1")])] {
        let found = heidenhain(&format!("{}M136\nCYCL CALL\n", with_levels(number, &more)));
        assert!(is_near(&found, &thread(5.0, -12.5, 20.0, [None; 2])), "{number}\n{found:?}");
    }
    // At feed the tool would end below the clearance, and a parameter is not known.
    for cycle in ["CYCLE84(4,3,2,-12.5,,,3,,1.25,0,500)", "CYCLE84(20,3,2,-12.5,,,3,,1.25,0,500,500,1)"] {
        let found = siemens(&format!("{cycle}\nG0 X9\n"));
        assert_eq!(found.first(), Some(&Told::Left(4, Unfollowable::CannedCycle)), "{cycle}: {found:?}");
    }
}

#[test]
fn a_modal_cycle_leaves_nothing_in_doubt_that_is_in_doubt() {
    let modal = "MCALL CYCLE81(20,3,2,-12.5)\n";
    let height_after = |text: &str| {
        let found = siemens(&format!("{modal}{text}MCALL\nG0 X77\n"));
        match found.last() {
            Some(Told::Motion(_, [Some(_), _, z], _)) => *z,
            other => panic!("{text}: {other:?}"),
        }
    };
    assert_eq!(height_after("X5\n"), Some(20.0));
    for doubt in [
        // Only a rotary axis, machine coordinates, a thread, a block that may be skipped, a pattern, another program.
        "C20\n",
        "SUPA X5\n",
        "G33 Z5 K2\nG0\n",
        "/X5\n",
        "HOLES2(0,0,20,0,90,4)\n",
        "CYCLE81(20,3,2,-12.5)\n",
        "X=R99\n",
        "G74 Z1=0\nG0\n",
        "X5 MCALL CYCLE81(20,3,2,-12.5)\n",
    ] {
        assert_eq!(height_after(doubt), None, "{doubt}");
    }
    // It may have been begun, and it may have ended.
    for text in [
        "/MCALL CYCLE81(20,3,2,-12.5)\nX5\nMCALL\nG0 X77\n",
        "MCALL CYCLE81(20,3,2,-12.5)\n/MCALL\nX5\nMCALL\nG0 X77\n",
    ] {
        let found = siemens(text);
        let Some(Told::Motion(_, [.., z], _)) = found.last() else { panic!("{found:?}") };
        assert_eq!(*z, None, "{text}: {found:?}");
    }
    // Another program at every motion stays a macro.
    let found = siemens(&format!("{modal}MCALL OWN(5)\nG0 X5\n"));
    assert!(matches!(found.last(), Some(Told::Left(_, Unfollowable::ModalCall))), "{found:?}");
}

#[test]
fn operations_that_write_leave_cycles_alone_as_before() {
    use trunnion::motion::{Interpreter, InterpreterOptions};
    use trunnion::program::{Batch, Diagnostics, ReadLimits, Reader};
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    for (dialect, text, wanted) in [
        (
            Dialect::Siemens,
            format!(
                "{SIEMENS}G2 X2 Y2 I0.5 J0\nCYCLE81(20,3,2,-12.5)\nG0 X1 Y1 Z1 A0 C0\nG2 X2 Y1 CR=2\nMCALL CYCLE82(20,3,2,,15)\nX5 Y5\nMCALL\nG0 X1\n"
            ),
            vec![
                None,
                None,
                Some(Unfollowable::CannedCycle),
                None,
                None,
                Some(Unfollowable::ModalCall),
                None,
            ],
        ),
        (
            Dialect::Heidenhain,
            format!("{HEIDENHAIN}{DRILL}L X+2 FMAX M99\nL X+1 Y+1 Z+1\nCYCL CALL M3\nL X+1 Y+1 Z+1\n"),
            vec![None, Some(Unfollowable::CannedCycle), None, Some(Unfollowable::CannedCycle), None],
        ),
    ] {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        reader.feed(text.as_bytes());
        reader.finish();
        let mut interpreter = Interpreter::new(&machine, InterpreterOptions::in_mm());
        let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
        while reader.next_batch(&mut batch).unwrap() {
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
        }
        let left: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
        assert_eq!(left, wanted, "{text}");
    }
}

const DRILL: &str = "CYCL DEF 200 DRILLING ~\n  Q200=+2 ;SET-UP CLEARANCE ~\n  Q201=-15.5 ;DEPTH ~\n  Q206=+80 ;FEED ~\n  Q202=+5 ;PECK ~\n  Q210=+0 ;DWELL ~\n  Q203=+3 ;SURFACE ~\n  Q204=+17 ;2ND ~\n  Q211=+0.2 ;DWELL\n";
/// The hole of [`DRILL`].
const DRILLED: Hole = Hole { feeds: [80.0; 2], ..DEEP };

/// A cycle with these parameters on lines of their own.
fn cycle(number: u32, parameters: &[(u32, &str)]) -> String {
    let mut text = format!("CYCL DEF {number} HOLE ~\n");
    for (index, (parameter, value)) in parameters.iter().enumerate() {
        let more = if index + 1 < parameters.len() { " ~" } else { "" };
        writeln!(text, "    Q{parameter}={value} ;NOTE Q999=5{more}").unwrap();
    }
    text
}

const LEVELS: [(u32, &str); 4] = [(200, "+2"), (201, "-15.5"), (203, "+3"), (204, "+17")];

fn with_levels(number: u32, further: &[(u32, &str)]) -> String {
    cycle(number, &[&LEVELS, further].concat())
}

#[test]
fn every_heidenhain_cycle_makes_the_motions_of_its_manual() {
    let ream = Hole { feeds: [80.0, 250.0], slowly_up: true, ..DEEP };
    let bore = Hole { feeds: [80.0; 2], slowly_up: true, ..DEEP };
    let second = |second: &str| DRILL.replace("Q204=+17", &format!("Q204={second}"));
    for (cycle, hole) in [
        (DRILL.to_owned(), DRILLED),
        // The second clearance counts only above the first.
        (second("+1.5"), Hole { end: 5.0, ..DRILLED }),
        (second("0"), Hole { end: 5.0, ..DRILLED }),
        (second("+2"), Hole { end: 5.0, ..DRILLED }),
        // Decimal commas, blanks, parameters of the program.
        (DRILL.replace("-15.5", " -15,5").replace("Q203=+3", "Q203 = +3"), DRILLED),
        (
            format!(
                "Q1 = 3\nQL2 = 5 * -3.1\n{}",
                DRILL.replace("Q203=+3", "Q203=+Q1").replace("-15.5", "+QL2")
            ),
            DRILLED,
        ),
        (with_levels(200, &[(206, "+80"), (202, "+15.5"), (395, "+0")]), DRILLED),
        (with_levels(201, &[(206, "+80"), (211, "+1"), (208, "+250")]), ream),
        (with_levels(201, &[(206, "+80"), (208, "+0")]), bore),
        (with_levels(202, &[(206, "+80"), (211, "+1"), (208, "+250"), (214, "+0"), (336, "+45")]), ream),
        (
            with_levels(
                203,
                &[
                    (206, "+80"),
                    (202, "+5"),
                    (210, "+0"),
                    (212, "+1"),
                    (213, "+3"),
                    (205, "+2"),
                    (211, "+0"),
                    (208, "+250"),
                    (256, "+0.2"),
                    (395, "+0"),
                ],
            ),
            ream,
        ),
        (with_levels(203, &[(206, "+80"), (202, "+5"), (208, "0")]), bore),
        (with_levels(240, &[(343, "+0"), (344, "+0"), (206, "+80"), (211, "+0")]), DRILLED),
    ] {
        let mut holes = vec![motion(Rapid, [4.0, 6.0, 50.0], 0.0)];
        holes.extend(written_out([4.0, 6.0], 50.0, hole));
        let found = heidenhain(&format!("{cycle}L X+4 Y+6 FMAX M99\n"));
        assert!(is_near(&found, &holes), "{cycle}\n{found:?}\n{holes:?}");
        let found = heidenhain(&format!("{cycle}L X+4 Y+6 R0 FMAX M3\nCYCL CALL M8 ; note\n"));
        assert!(is_near(&found, &holes), "{cycle}\n{found:?}\n{holes:?}");
        // The next hole begins where this one ends.
        holes.push(motion(Rapid, [5.0, 6.0, hole.end], 0.0));
        holes.extend(written_out([5.0, 6.0], hole.end, hole));
        let found = heidenhain(&format!("{cycle}L X+4 Y+6 FMAX M99\nL IX+1 FMAX M99\n"));
        assert!(is_near(&found, &holes), "{cycle}\n{found:?}\n{holes:?}");
    }
}

#[test]
fn a_defined_cycle_waits_for_its_call_and_stays_until_another_one() {
    let between = "CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL 1\nCYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.02\nL X+7 F500\n";
    let found = heidenhain(&format!("{DRILL}{between}CYCL CALL\nL Z+60 FMAX\nL Y+9 M99\n"));
    let mut wanted = vec![motion(Linear, [7.0, 2.0, 50.0], 500.0)];
    wanted.extend(written_out([7.0, 2.0], 50.0, DRILLED));
    wanted.push(motion(Rapid, [7.0, 2.0, 60.0], 0.0));
    wanted.push(motion(Linear, [7.0, 9.0, 60.0], 500.0));
    wanted.extend(written_out([7.0, 9.0], 60.0, DRILLED));
    assert!(is_near(&found, &wanted), "{found:?}\n{wanted:?}");
    for other in [
        with_levels(205, &[(206, "+80")]),
        "CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SET UP 2\nCYCL DEF 1.2 DEPTH -20\n".to_owned(),
        "Q201 = -30\n".to_owned(),
        "FN 0: Q203 = +7\n".to_owned(),
        format!("/{DRILL}").replace("-15.5", "-30"),
    ] {
        let found = heidenhain(&format!("{DRILL}{other}L X+4 FMAX M99\nL X+5 FMAX\n"));
        assert!(
            found.iter().any(|told| matches!(told, Told::Left(_, Unfollowable::CannedCycle))),
            "{other}: {found:?}"
        );
        let Some(Told::Motion(_, [.., z], _)) = found.last() else { panic!("{found:?}") };
        assert_eq!(*z, None, "{other}");
    }
}

#[test]
fn holes_in_a_loop_are_at_the_places_that_its_parameter_counts() {
    let text =
        format!("Q1 = 0\n{DRILL}LBL 1\nQ1 = Q1 + 10\nL X+Q1 FMAX M99\nCALL LBL 1 REP 2\nL Z+50 FMAX\n");
    let found = heidenhain(&text);
    let mut wanted = Vec::new();
    let mut height = 50.0;
    for x in [10.0, 20.0, 30.0] {
        wanted.push(motion(Rapid, [x, 2.0, height], 0.0));
        wanted.extend(written_out([x, 2.0], height, DRILLED));
        height = DRILLED.end;
    }
    wanted.push(motion(Rapid, [30.0, 2.0, 50.0], 0.0));
    assert!(is_near(&found, &wanted), "{found:?}\n{wanted:?}");
}

#[test]
fn conversational_cycles_that_are_not_certain_are_left_alone() {
    let drill = |change: [&str; 2]| {
        assert!(DRILL.contains(change[0]), "{change:?}");
        format!("{}L X+4 FMAX M99\n", DRILL.replace(change[0], change[1]))
    };
    let called = |cycle: String| format!("{cycle}L X+4 FMAX M99\n");
    for text in [
        // Upwards, no depth, unknown, a negative clearance, no peck, a formula, a word, a parameter of cycles.
        drill(["-15.5", "+15.5"]),
        drill(["-15.5", "+0"]),
        drill(["-15.5", "+Q77"]),
        drill(["Q200=+2", "Q200=-2"]),
        drill(["Q204=+17", "Q204=-1"]),
        drill(["Q202=+5", "Q202=+0"]),
        drill(["-15.5", "-Q1*2"]),
        drill(["+80", "FAUTO"]),
        drill(["+80", "+0"]),
        drill(["-15.5", "+Q203"]),
        drill(["Q203=+3", "Q203=+60"]),
        drill(["Q211=+0.2", "Q395=+1"]),
        drill(["Q211=+0.2", "Q777=+1"]),
        drill(["Q211=+0.2", "Q201=-15.5"]),
        drill(["  Q206=+80 ;FEED ~\n", ""]),
        called(with_levels(202, &[(206, "+80"), (208, "+250"), (214, "+1"), (336, "+45")])),
        called(with_levels(240, &[(343, "+1"), (344, "-5"), (206, "+80")])),
        called(with_levels(205, &[(206, "+80"), (202, "+5"), (208, "+0")])),
        called(with_levels(208, &[(206, "+80")])),
        // Called in another way, or in another state.
        format!("{DRILL}CYCL CALL POS X+4 Y+2 Z+0 FMAX\n"),
        format!("{DRILL}CYCL CALL PAT FMAX\n"),
        format!("{DRILL}L X+4 FMAX M89\n"),
        format!("{DRILL}L X+4 FMAX M91 M99\n"),
        format!("{DRILL}L X+4 RL F100 M99\n"),
        format!("{DRILL}M136\nL X+4 FMAX M99\n"),
        "CYCL CALL\n".to_owned(),
    ] {
        let found = heidenhain(&format!("{text}M99\nL X+5 R0 FMAX\n"));
        assert!(found.iter().any(|told| matches!(told, Told::Left(..))), "{text}: {found:?}");
        let feeds_down =
            found.iter().filter(|told| matches!(told, Told::Motion(Linear, [.., Some(z)], _) if *z < 0.0));
        assert_eq!(feeds_down.count(), 0, "{text}: {found:?}");
        let Some(Told::Motion(_, [.., z], _)) = found.last() else { panic!("{text}: {found:?}") };
        assert_eq!(*z, None, "{text}: {found:?}");
    }
}

/// A length with three decimals as written and as a number.
fn length(range: std::ops::Range<i32>) -> impl Strategy<Value = f64> {
    range.prop_map(|thousandths| f64::from(thousandths) / 1000.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Levels as numbers, as R parameters or as differences give the motions of the reference, at every place.
    #[test]
    fn any_levels_and_places_make_the_holes_of_the_reference(
        surface in length(-40_000..20_000),
        clearance in length(0..5000),
        depth in length(1..30_000),
        above in length(0..9000),
        places in prop::collection::vec((length(-90_000..90_000), length(-90_000..90_000)), 1..5),
        is_relative in any::<bool>(),
        by_parameters in any::<bool>(),
    ) {
        let (plane, bottom) = (surface + clearance, surface - depth);
        let end = plane + above;
        let drilled = Hole { plane, depth: bottom, end, feeds: [100.0; 2], slowly_up: false };
        let is_relative = is_relative && end > surface;
        let depths = if is_relative { format!(",{depth:.3}") } else { format!("{bottom:.3}") };
        let mut text = if by_parameters {
            format!("R1={end:.3} R2={surface:.3} R3={clearance:.3}\nMCALL CYCLE81(R1,R2,R3,{depths})\n")
        } else {
            format!("MCALL CYCLE81({end:.3},{surface:.3},{clearance:.3},{depths})\n")
        };
        let (mut wanted, mut height) = (Vec::new(), 50.0);
        let mut calls = String::new();
        for (x, y) in &places {
            writeln!(text, "X{x:.3} Y{y:.3}").unwrap();
            writeln!(calls, "L X{x:+.3} Y{y:+.3} FMAX M99").unwrap();
            wanted.push(motion(Rapid, [*x, *y, height], 0.0));
            wanted.extend(written_out([*x, *y], height, drilled));
            height = end;
        }
        let found = siemens(&text);
        prop_assert!(is_near(&found, &wanted), "{}\n{:?}\n{:?}", text, found, wanted);
        let second = clearance + above;
        let cycle = with_levels_of(&[
            (200, format!("{clearance:+.3}")),
            (201, format!("{:+.3}", -depth)),
            (203, format!("{surface:+.3}")),
            (204, format!("{second:+.3}")),
            (206, "+100".to_owned()),
            (202, "+1".to_owned()),
        ]);
        let found = heidenhain(&format!("{cycle}{calls}"));
        prop_assert!(is_near(&found, &wanted), "{}{}\n{:?}\n{:?}", cycle, calls, found, wanted);
    }
}

fn with_levels_of(parameters: &[(u32, String)]) -> String {
    let parameters: Vec<_> = parameters.iter().map(|(number, value)| (*number, value.as_str())).collect();
    cycle(200, &parameters)
}
