//! Canned cycles are the motions that they make: those of the same holes written out.

#![expect(clippy::panic, reason = "a test stops at the first surprise, helpers included")]

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset};
use trunnion::motion::Unfollowable;
use trunnion::process::{Interpreted, InterpretedKind, ProgramSetup, StartPosition};
use trunnion::program::Dialect;

use crate::models::told::{ac_table, all_told, nominal};

fn understood(dialect: Dialect, text: &str) -> Vec<Interpreted> {
    understood_on(&ac_table(), dialect, text)
}

fn understood_on(machine: &Machine, dialect: Dialect, text: &str) -> Vec<Interpreted> {
    all_told(machine, &nominal(dialect), text)
}

/// Kind, X Y Z and feed of every motion.
fn motions(dialect: Dialect, text: &str) -> Vec<(InterpretedKind, [Option<f64>; 3], Option<f64>)> {
    followed(understood(dialect, text), text)
}

fn followed(told: Vec<Interpreted>, text: &str) -> Vec<(InterpretedKind, [Option<f64>; 3], Option<f64>)> {
    let told = told.into_iter().map(|told| match told {
        Interpreted::Motion(motion) => {
            let [x, y, z, ..] = motion.joints;
            (motion.kind, [x, y, z], motion.feed_mm_per_min)
        }
        Interpreted::LeftAlone { line, reason, .. } => panic!("{text}\nline {line}: {reason}"),
    });
    told.collect()
}

const START: &str = "G90 G17 G94 G0 X0 Y0 Z50 A0 C0\n";

/// Blocks with cycles, and the same holes written out.
const ALIKE: [(&str, &str); 11] = [
    (
        "G98 G81 X1 Y2 Z-5 R3 F100\nX4\nG80\nG0 X9\n",
        "X1 Y2\nZ3\nG1 Z-5 F100\nG0 Z50\nX4\nZ3\nG1 Z-5\nG0 Z50\nX9\n",
    ),
    ("G99 G82 Z-5 R3 P500 F100\nY7\nG80 X9\nG0 X9", "Z3\nG1 Z-5 F100\nG0 Z3\nY7\nG1 Z-5\nG0 Z3\nX9\n"),
    ("G98\nG83 X1 Z-5 R3 Q2 F100\nG0 X9\n", "X1\nZ3\nG1 Z-5 F100\nG0 Z50\nX9\n"),
    ("G99 G85 X1 Z-5 R3 F100\nG0 X9\n", "X1\nZ3\nG1 Z-5 F100\nZ3\nG0 X9\n"),
    // The spindle turns back on the way up.
    ("G99 G84 X1 Z-5 R3 F100\nX2\nG0 X9\n", "X1\nZ3\nG1 Z-5 F100\nZ3\nG0 X2\nG1 Z-5\nZ3\nG0 X9\n"),
    ("G99 G74 X1 Z-5 R3 P500 F100\nG0 X9\n", "X1\nZ3\nG1 Z-5 F100\nZ3\nG0 X9\n"),
    // After a series that G0 preceded, G0 is in force again.
    ("G99 G81 X1 Z-5 R3 F100\nG80\nX4 Z7\n", "X1\nZ3\nG1 Z-5 F100\nG0 Z3\nX4 Z7\n"),
    // R and the depth count from each other in G91, and the place moves on.
    (
        "G98 G91 G81 X1 Z-8 R-47 L2 F100\nG90 G0 X9\n",
        "X1\nZ3\nG1 Z-5 F100\nG0 Z50\nX2\nZ3\nG1 Z-5\nG0 Z50\nX9\n",
    ),
    // The level at which the series began, not the one before the block.
    ("G99 G81 X1 Z-5 R3 F100\nG98 X2\nG0 X9\n", "X1\nZ3\nG1 Z-5 F100\nG0 Z3\nX2\nG1 Z-5\nG0 Z50\nX9\n"),
    // Another cycle states its values again.
    ("G99 G81 X1 Z-5 R3 F100\nG86 Z-6 R3\nG0 X9\n", "X1\nZ3\nG1 Z-5 F100\nG0 Z3\nG1 Z-6\nG0 Z3\nX9\n"),
    // Without G98 and G99 the level is known if both are the same.
    ("G0 Z3\nG81 X1 Z-5 R3 F100\nG0 X9\n", "Z3\nX1\nG1 Z-5 F100\nG0 Z3\nX9\n"),
];

#[test]
fn a_cycle_makes_the_motions_of_its_hole_written_out() {
    for (cycles, written_out) in ALIKE {
        // `G80 X9` is a motion whose mode is not known.
        let cycles = cycles.replace("G80 X9\n", "G80\n");
        let cycles = format!("{START}{cycles}");
        assert_eq!(
            motions(Dialect::Iso, &cycles),
            motions(Dialect::Iso, &format!("{START}G0 {written_out}")),
            "{cycles}"
        );
    }
}

/// Blocks with cycles of an RS274/NGC control, and the same holes written out.
const OF_RS274: [(&str, &str); 6] = [
    // Below the retract plane: first up to it, then above the hole.
    ("G98 G81 X1 Z-5 R60 F100\nG0 X9\n", "Z60\nX1\nG1 Z-5 F100\nG0 Z60\nX9\n"),
    (
        "G99 G81 X1 Z-5 R60 F100\nX2 R70\nG0 X9\n",
        "Z60\nX1\nG1 Z-5 F100\nG0 Z60\nZ70\nX2\nG1 Z-5\nG0 Z70\nX9\n",
    ),
    (
        "G98 G91 G81 X1 Z-65 R10 L2 F100\nG90 G0 X9\n",
        "Z60\nX1\nG1 Z-5 F100\nG0 Z60\nX2\nG1 Z-5\nG0 Z60\nX9\n",
    ),
    // Along the axis across the plane.
    ("G18 G98 G81 X1 Z3 Y-5 R-2 F100\nG0 X9\n", "G18 X1 Z3\nY-2\nG1 Y-5 F100\nG0 Y0\nX9\n"),
    ("G19 G99 G81 Y1 Z3 X-5 R-2 F100\nG0 Y9\n", "G19 Y1 Z3\nX-2\nG1 X-5 F100\nG0 X-2\nY9\n"),
    ("G19 G98 G82 Y1 X-5 R2 P1 F100\nG0 Y9\n", "G19 X2\nY1\nG1 X-5 F100\nG0 X2\nY9\n"),
];

#[test]
fn on_an_rs274_control_a_cycle_first_rises_and_runs_along_the_axis_of_its_plane() {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap().with_rs274_control(true);
    for (cycles, written_out) in OF_RS274 {
        let cycles = format!("{START}{cycles}");
        assert_eq!(
            followed(understood_on(&machine, Dialect::Iso, &cycles), &cycles),
            motions(Dialect::Iso, &format!("{START}G0 {written_out}")),
            "{cycles}"
        );
    }
}

#[test]
fn cycles_that_rs274_controls_run_differently_are_left_alone() {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap().with_rs274_control(true);
    // The level before the second cycle is not the one before the first.
    for cycles in [
        "G99 G81 X1 Z-5 R3 F100\nG98 X2\n",
        "G98 G81 X1 Z-5 R60 F100\nX2 R55\n",
        "G99 G81 X1 Z-5 R60 F100\nX2 R55\n",
    ] {
        let found = understood_on(&machine, Dialect::Iso, &format!("{START}{cycles}"));
        let left: Vec<_> = found
            .iter()
            .filter_map(|told| match told {
                Interpreted::LeftAlone { line, reason, .. } => Some((*line, *reason)),
                Interpreted::Motion(_) => None,
            })
            .collect();
        assert_eq!(left, [(3, Unfollowable::CannedCycle)], "{cycles}");
    }
}

/// A cycle that begins below R first rises to R. Without a known place before it, the cycle is left alone.
#[test]
fn a_cycle_that_rises_at_an_unknown_place_is_left_alone() {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap().with_rs274_control(true);
    let text = "G90 G17 G94 G21\nG0 Y0 Z-5 A0 C0\nG99 G81 X9 Y1 Z-8 R0.5 F100\nG80 G0 X1 Y2\n";
    let found = understood_on(&machine, Dialect::Iso, text);
    let of_cycle = |told: &&Interpreted| match told {
        Interpreted::LeftAlone { line, .. } => *line == 3,
        Interpreted::Motion(motion) => motion.line == 3,
    };
    let told: Vec<_> = found.iter().filter(of_cycle).collect();
    assert!(
        matches!(told[..], [Interpreted::LeftAlone { reason: Unfollowable::CannedCycle, .. }]),
        "{told:?}"
    );
    // After it the height is that of R.
    let Some(Interpreted::Motion(last)) = found.last() else { panic!("{found:?}") };
    assert!((last.tip_mm.unwrap()[2] - 0.5).abs() < 1e-9, "{last:?}");
}

/// Blocks whose cycle is left alone, after which the drilled axis is not known.
const LEFT_ALONE: [&str; 20] = [
    // No level of retraction, another sense, not below the plane, below the plane before it.
    "G81 X1 Z-5 R3 F100\n",
    "G98 G81 X1 Z5 R3 F100\n",
    "G98 G81 X1 Z-5 R60 F100\n",
    "G98 G91 G81 X1 Z8 R-47 F100\n",
    // Nothing states R or the depth.
    "G98 G81 X1 R3 F100\n",
    "G98 G81 X1 Z-5 F100\n",
    // Controls differ in the way aside, in what is kept, in a repetition of none.
    "G98 G76 X1 Z-5 R3 Q1 F100\n",
    "G98 G87 X1 Z-5 R3 F100\n",
    "G98 G88 X1 Z-5 R3 F100\n",
    "G98 G81 X1 Z-5 R3 L0 F100\n",
    "G98 G81 X1 Z-5 R3 L2 K2 F100\n",
    // Along Z or across the plane; repetitions or increments; no increment.
    "G18 G99 G81 X1 Y-5 Z3 R-2 F100\n",
    "G19 G99 G81 Y1 X-5 Z3 R-2 F100\n",
    "G98 G83 X1 Z-5 R3 Q2 K3 F100\n",
    "G98 G73 X1 Z-5 R3 F100\n",
    "G98 G83 X1 Z-5 R3 Q0 F100\n",
    // Rotary words, incremental time, unknown values.
    "G98 G81 X1 Z-5 R3 C10 F100\n",
    "G93 G98 G81 X1 Z-5 R3 F100\n",
    "G98 G81 X1 Z#500 R3 F100\n",
    "G98 G81 X#500 Z-5 R3 F100\n",
];

#[test]
fn a_cycle_that_controls_run_differently_is_left_alone() {
    for cycle in LEFT_ALONE {
        let found = understood(Dialect::Iso, &format!("{START}{cycle}G90 G94 G0 X9\n"));
        let reasons: Vec<_> = found
            .iter()
            .filter_map(|told| match told {
                Interpreted::LeftAlone { reason, .. } => Some(*reason),
                Interpreted::Motion(_) => None,
            })
            .collect();
        assert_eq!(reasons, [Unfollowable::CannedCycle], "{cycle}");
        let Some(Interpreted::Motion(last)) = found.last() else { panic!("{cycle}") };
        assert_eq!(last.joints[2], None, "{cycle}");
    }
}

#[test]
fn above_r_no_feed_of_a_bore_or_a_thread_is_certain() {
    for cycle in ["G74", "G84", "G85", "G89"] {
        let text = format!("{START}G98 {cycle} X1 Z-5 R3 F100\nX2\nG0 X9\n");
        let found = motions(Dialect::Iso, &text);
        let at = |x: f64, z: f64| [x, 0.0, z].map(Some);
        let (rapid, linear) = (InterpretedKind::Rapid, InterpretedKind::Linear);
        let hole = |x: f64| {
            [
                (rapid, at(x, 50.0), None),
                (rapid, at(x, 3.0), None),
                (linear, at(x, -5.0), Some(100.0)),
                (linear, at(x, 3.0), Some(100.0)),
                (linear, at(x, 50.0), None),
            ]
        };
        let wanted = [&hole(1.0)[..], &hole(2.0), &[(rapid, at(9.0, 50.0), None)]].concat();
        assert_eq!(found[1..], wanted, "{text}");
        // Such a control goes on at the feed.
        let rs274 =
            Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap().with_rs274_control(true);
        let found = followed(understood_on(&rs274, Dialect::Iso, &text), &text);
        assert_eq!(found[4], (linear, at(1.0, 50.0), Some(100.0)), "{text}");
    }
}

#[test]
fn the_mode_after_a_series_is_known_where_all_controls_agree() {
    let left = |machine: &Machine, text: &str| {
        let found = understood_on(machine, Dialect::Iso, &format!("{START}{text}"));
        found.iter().filter(|told| matches!(told, Interpreted::LeftAlone { .. })).count()
    };
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let series = "G99 G81 X1 Z-5 R3 F100\n";
    assert_eq!(left(&machine, &format!("{series}X2\nG80\nX4\n")), 0);
    // Some controls go back to G1, and others begin G0.
    assert_eq!(left(&machine, &format!("G1 X0 F100\n{series}G80\nX4\n")), 1);
    // Words beside G80, and a control that refuses words without a mode.
    assert_eq!(left(&machine, &format!("{series}G80 X4\n")), 1);
    assert_eq!(left(&machine.with_rs274_control(true), &format!("{series}G80\nX4\n")), 1);
}

/// After a tool change no place is known until the program names it.
#[test]
fn at_an_unknown_place_the_height_after_a_cycle_is_known() {
    let ends = |text: &str| {
        let found = understood(Dialect::Iso, &format!("G90 G17 G94 G0 X0 Y0 A0 C0\n{text}"));
        let end = |told: &Interpreted| match told {
            Interpreted::Motion(motion) => Ok([motion.joints[0], motion.joints[1], motion.joints[2]]),
            Interpreted::LeftAlone { line, .. } => Err(*line),
        };
        found.iter().skip(1).map(end).collect::<Vec<_>>()
    };
    let at = |x: f64, y: f64, z: f64| Ok([x, y, z].map(Some));
    let found = ends("M6\nZ50\nG98 G81 Z-5 R3 F100\nX4\nY6\nG0 X9\n");
    let wanted = [
        Ok([None, None, Some(50.0)]),
        Err(4),
        Err(5),
        at(4.0, 6.0, 50.0),
        at(4.0, 6.0, 3.0),
        at(4.0, 6.0, -5.0),
        at(4.0, 6.0, 50.0),
        at(9.0, 6.0, 50.0),
    ];
    assert_eq!(found, wanted);
    // A block that states the place makes it known. Steps from an unknown place do not.
    let found = ends("M6\nZ50\nG99 G81 X4 Y6 Z-5 R3 F100\nG91 G98\nG0 X1 Z0\n");
    let wanted = [at(4.0, 6.0, 50.0), at(4.0, 6.0, 3.0), at(4.0, 6.0, -5.0), at(4.0, 6.0, 3.0)];
    assert_eq!(found[1..5], wanted);
    assert_eq!(found[5], at(5.0, 6.0, 3.0));
    let found = ends("M6\nZ50\nG91 G98 G81 X1 Z-8 R-47 L3 F100\nG90 G0 Y6\n");
    assert_eq!(found[1..], [Err(4), Ok([None, Some(6.0), Some(50.0)])]);
}

#[test]
fn words_of_cycles_without_a_place_make_the_level_unknown() {
    for words in ["R2\n", "Q1\n", "K2\n"] {
        let found = understood(Dialect::Iso, &format!("{START}G99 G81 X1 Z-5 R3 F100\n{words}G0 X9\n"));
        let Some(Interpreted::Motion(last)) = found.last() else { panic!("{words}") };
        assert_eq!(last.joints[2], None, "{words}");
    }
}

#[test]
fn a_few_bytes_do_not_ask_for_motions_without_end() {
    let followed = |lines: usize| {
        let text = format!("{START}G91 G98 G81 X1 Z-8 R-47 F100\n{}G80\nM30\n", "X1 L999\n".repeat(lines));
        let all = understood(Dialect::Iso, &text);
        let left = all.iter().filter(|told| matches!(told, Interpreted::LeftAlone { .. })).count();
        (all.len() - left, left)
    };
    // One motion to the start, and four for each hole.
    assert_eq!(followed(1), (1 + 4 * 1000, 0));
    assert_eq!(followed(20), (1 + 4 * (1 + 20 * 999), 0));
    // 20 000 repetitions and no more: the next block is left unchanged, and nothing is known after it.
    assert_eq!(followed(21), (1 + 4 * (1 + 20 * 999), 1));
    assert_eq!(followed(1000), (1 + 4 * (1 + 20 * 999), 980));
}

#[test]
fn points_of_cutter_location_data_are_followed_from_a_stated_start() {
    let start = StartPosition { linear_mm: [Some(1.0); 3], rotary_deg: [Some(0.0); 2] };
    let program = ProgramSetup { start, ..ProgramSetup::in_mm(&Setup::default()) };
    let text = "FEDRAT/100,MMPM\nGOTO/2,0,0\nGOTO/3,0,0\nGOTO/3,0,5,0,0,1\n";
    let ends = all_told(&ac_table(), &program, text).into_iter().map(|told| match told {
        Interpreted::Motion(motion) => motion.joints,
        Interpreted::LeftAlone { line, reason, .. } => panic!("line {line}: {reason}"),
    });
    let at = |x: f64, z: f64| [x, 0.0, z, 0.0, 0.0].map(Some);
    assert_eq!(ends.collect::<Vec<_>>(), [at(2.0, 0.0), at(3.0, 0.0), at(3.0, 5.0)]);
}
