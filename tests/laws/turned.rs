//! Turned programmable frames: their motions are those of the same places in the work offset.

#![expect(clippy::panic, reason = "a test stops at the first surprise, helpers included")]

use trunnion::motion::Unfollowable;
use trunnion::process::Interpreted;
use trunnion::program::Dialect;

use crate::models::told::{ac_table, all_told, nominal};

fn understood(text: &str) -> Vec<Interpreted> {
    all_told(&ac_table(), &nominal(Dialect::Siemens), text)
}

/// The tips of all motions whose tip is known.
fn tips(text: &str) -> Vec<[f64; 3]> {
    let told = understood(text).into_iter().filter_map(|told| match told {
        Interpreted::Motion(motion) => motion.tip_mm,
        Interpreted::LeftAlone { line, reason, .. } => panic!("{text}\nline {line}: {reason}"),
    });
    told.collect()
}

const START: &str = "G0 A90. C0.\nTRAORI\nG54\n";

/// Frames with motions in them, and where the tips are.
const TIPS: [(&str, &[[f64; 3]]); 7] = [
    ("ROT Z90\nG0 X1 Y2 Z3\nG1 X5 F100\n", &[[-2.0, 1.0, 3.0], [-2.0, 5.0, 3.0]]),
    ("AROT X-90.\nAROT Z90.\nG0 X1 Y2 Z3\n", &[[-2.0, 3.0, -1.0]]),
    // An offset before a turn, and one along the turned axes after it.
    ("TRANS X10\nAROT Z90\nG0 X1 Y2 Z3\n", &[[8.0, 1.0, 3.0]]),
    ("ROT Z90\nATRANS X10\nG0 X1 Y2 Z3\nX=IC(1)\n", &[[-2.0, 11.0, 3.0], [-2.0, 12.0, 3.0]]),
    // ROT replaces the turn before it, and TRANS ends it.
    ("ROT X90\nROT Z90\nG0 X1 Y2 Z3\n", &[[-2.0, 1.0, 3.0]]),
    ("AROT Z90\nG0 X1 Y2 Z3\nTRANS\nG0 X1 Y2 Z3\n", &[[-2.0, 1.0, 3.0], [1.0, 2.0, 3.0]]),
    // Words of one axis keep the others where they are in the frame.
    ("AROT Z90\nG0 X1 Y2 Z3\nY4\nZ5\n", &[[-2.0, 1.0, 3.0], [-4.0, 1.0, 3.0], [-4.0, 1.0, 5.0]]),
];

#[test]
fn tips_in_a_turned_frame_are_where_the_frame_puts_them() {
    for (text, expected) in TIPS {
        let found = tips(&format!("{START}{text}M30\n"));
        assert_eq!(found.len(), expected.len(), "{text}: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(near, "{text}: {found:?}, not {expected:?}");
        }
    }
}

#[test]
fn a_turn_that_is_not_certain_is_left_alone() {
    for text in [
        // The order of several turns depends on a setting. RPL turns in the plane. An angle is not known.
        "AROT X10 Z20\nG0 X1 Y2 Z3\n",
        "ROT RPL=30\nG0 X1 Y2 Z3\n",
        "AROT Z=R77\nG0 X1 Y2 Z3\n",
        "AROT X10 Y20\nAROT Z10\nG0 X1 Y2 Z3\n",
        "AROT Z90\nMIRROR X0\nAROT Z90\nG0 X1 Y2 Z3\n",
    ] {
        let found = understood(&format!("{START}{text}M30\n"));
        let last = found.last().unwrap();
        let is_left = matches!(last, Interpreted::LeftAlone { reason: Unfollowable::Transformation, .. });
        assert!(is_left, "{text}: {last:?}");
    }
}

#[test]
fn an_arc_in_a_turned_frame_is_the_arc_of_its_places_in_the_work_offset() {
    // The frame, the arc, and in W its centre, the axis about which it runs counter-clockwise, its middle and its end.
    let arcs = [
        (
            "AROT Z90\n",
            "G2 X2 Y0 I1 J0",
            [0.0, 1.0, 0.0],
            [0.0, 0.0, -1.0],
            [-1.0, 1.0, 0.0],
            [0.0, 2.0, 0.0],
        ),
        ("AROT X-90\n", "G3 X2 Y0 CR=1", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [2.0, 0.0, 0.0]),
        (
            "TRANS X5\nAROT X-90\n",
            "G18 G2 X2 Z0 I=AC(1) K=AC(0)",
            [6.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [6.0, -1.0, 0.0],
            [7.0, 0.0, 0.0],
        ),
    ];
    for (frame, arc, centre, normal, middle, end) in arcs {
        let found = understood(&format!("{START}{frame}G0 X0 Y0 Z0\n{arc} F100\nG1 X5\nM30\n"));
        let Interpreted::Motion(motion) = found[2] else { panic!("{frame}{arc}: {found:?}") };
        let course = motion.arc.unwrap();
        let half = motion.until(0.5).unwrap();
        let words: Vec<f64> = half.joints[..3].iter().map(|word| word.unwrap()).collect();
        let offset = if frame.starts_with("TRANS") { 5.0 } else { 0.0 };
        let by_words = [words[0] + offset, words[1], words[2]];
        let places =
            [course.centre_mm, course.normal, half.tip_mm.unwrap(), by_words, motion.tip_mm.unwrap()];
        for (place, expected) in places.iter().zip([centre, normal, middle, middle, end]) {
            let near = place.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(near, "{frame}{arc}: {place:?}, not {expected:?}");
        }
    }
}
