//! Radius compensation by a register whose radius the caller states. Which control runs the program is not known, so only
//! what all controls do alike is followed: a way in and a way out towards the tool, inner corners, and pieces that go on
//! in one direction.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at the first surprise, helpers included"
)]

use std::fmt::Write as _;
use std::sync::Arc;

use proptest::prelude::*;

use trunnion::motion::{RadiusOffsets, RadiusRegister, Unfollowable};
use trunnion::process::{Interpreted, ProgramSetup};
use trunnion::program::Dialect;

use crate::models::told::{ac_table, all_told, nominal};

/// Rounding of words with seven decimals [mm].
const ROUNDING_MM: f64 = 2e-6;
const START: &str = "G17 G90 G94 G0 X0 Y0 Z5 A0 C0\n";

fn understood(radii: &[(&str, f64)], is_rs274: bool, text: &str) -> Vec<Interpreted> {
    let machine = ac_table().with_rs274_control(is_rs274);
    let named = radii.iter().map(|(name, radius_mm)| (RadiusRegister::from_name(name).unwrap(), *radius_mm));
    let program = ProgramSetup {
        radius_offsets: Arc::new(RadiusOffsets { by_register_mm: named.collect() }),
        ..nominal(Dialect::Iso)
    };
    all_told(&machine, &program, text)
}

/// Line and X Y Z after every motion.
fn ends(radii: &[(&str, f64)], is_rs274: bool, text: &str) -> Vec<(u64, [f64; 3])> {
    let told = understood(radii, is_rs274, text).into_iter().map(|told| match told {
        Interpreted::Motion(motion) => (motion.line, std::array::from_fn(|k| motion.joints[k].unwrap())),
        Interpreted::LeftAlone { line, reason, .. } => panic!("{text}\nline {line}: {reason}"),
    });
    told.collect()
}

fn is_near(found: &[(u64, [f64; 3])], wanted: &[(u64, [f64; 3])]) -> bool {
    found.len() == wanted.len()
        && found.iter().zip(wanted).all(|((line, at), (other, to))| {
            line == other && at.iter().zip(to).all(|(a, b)| (a - b).abs() < ROUNDING_MM)
        })
}

/// A pocket of 40 by 30 from its middle, counter-clockwise, with a round corner. The corner at (40, 0) is an arc of 8.
const POCKET: &str = "G1 G41 D4 X20 Y0 F100\nX32\nG3 X40 Y8 J8\nG1 Y30\nX0\nY0\nX20\nG40 Y15\nG0 Z50\n";

#[test]
fn a_pocket_is_cut_at_the_radius_that_the_register_has() {
    for radius in [0.0, 0.5, 3.0, 7.5] {
        let (low, right, high) = (radius, 40.0 - radius, 30.0 - radius);
        let text = format!("{START}G0 X20 Y15\n{POCKET}");
        let wanted = [
            [20.0, 15.0, 5.0],
            // Beside the beginning of the next piece.
            [20.0, low, 5.0],
            [32.0, low, 5.0],
            [right, 8.0, 5.0],
            [right, high, 5.0],
            [low, high, 5.0],
            [low, low, 5.0],
            [20.0, low, 5.0],
            [20.0, 15.0, 5.0],
            [20.0, 15.0, 50.0],
        ];
        let wanted: Vec<_> = wanted.into_iter().zip(2..).map(|(at, line)| (line, at)).collect();
        let found = ends(&[("D4", radius)], false, &text);
        assert!(is_near(&found[1..], &wanted), "{radius}\n{found:?}\n{wanted:?}");
        // On the other side in the other sense, by an H that is stated as a radius.
        let text =
            text.replace("G41 D4", "G42 H19").replace('Y', "Y-").replace("G3", "G2").replace('J', "J-");
        let mirrored: Vec<_> = wanted.iter().map(|(line, [x, y, z])| (*line, [*x, -y, *z])).collect();
        let found = ends(&[("H19", radius)], false, &text);
        assert!(is_near(&found[1..], &mirrored), "{radius}\n{found:?}\n{mirrored:?}");
    }
}

#[test]
fn a_radius_by_h_leaves_the_length_of_the_tool_as_it_is() {
    let text = format!("{START}G43 H3 Z20\nG1 G41 H19 X10 F100\nY20\nG40 X0\nG0 X5\n");
    let found = ends(&[("H19", 2.0)], false, &text);
    assert!(is_near(&found[found.len() - 1..], &[(6, [5.0, 20.0, 20.0])]), "{found:?}");
}

/// The turn before each side of a path that turns to the left alone, and its length.
fn inner() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((10.0_f64..100.0, 25.0_f64..40.0), 2..7)
}

proptest! {
    /// `LinuxCNC` runs inner corners as all controls do. Only its ways in differ.
    #[test]
    fn inner_corners_are_those_of_linuxcnc(sides in inner(), radius in 0.3_f64..2.0) {
        let mut text = format!("{START}G1 G41 D4 X30 F100\n");
        let (mut at, mut heading_deg) = ([30.0, 0.0], 0.0_f64);
        for (turn_deg, size) in &sides {
            heading_deg += turn_deg;
            let (sin, cos) = heading_deg.to_radians().sin_cos();
            at = [at[0] + size * cos, at[1] + size * sin];
            writeln!(text, "X{:.7} Y{:.7}", at[0], at[1]).unwrap();
        }
        let (sin, cos) = (heading_deg + 90.0).to_radians().sin_cos();
        writeln!(text, "G40 X{:.7} Y{:.7}", at[0] + 20.0 * cos, at[1] + 20.0 * sin).unwrap();
        let (found, other) = (ends(&[("D4", radius)], false, &text), ends(&[("D4", radius)], true, &text));
        prop_assert!(is_near(&found[2..], &other[2..]), "{}\n{:?}\n{:?}", text, found, other);
        // The way in ends at the radius beside the beginning of the next piece.
        let (sin, cos) = sides[0].0.to_radians().sin_cos();
        let wanted = [(2, [30.0 - radius * sin, radius * cos, 5.0])];
        prop_assert!(is_near(&found[1..2], &wanted), "{}\n{:?}\n{:?}", text, found, wanted);
    }
}

/// Blocks of which controls make different motions, or none. Line 2 of the program is their first.
const LEFT_ALONE: [&str; 32] = [
    // No radius is stated for the register, and none is named.
    "G1 G41 D5 X20 F100\nY20\nG40 X0\n",
    "G1 G41 X20 F100\nY20\nG40 X0\n",
    "G1 G41 H4 X20 F100\nY20\nG40 X0\n",
    "G1 G41 D#500 X20 F100\nY20\nG40 X0\n",
    // A way in that turns away from the tool, that stands in no block with G41, or that another block follows.
    "G1 G41 D4 X20 F100\nY-20\nG40 X0\n",
    "G41 D4\nG1 X20 F100\nY20\nG40 X0\n",
    "G1 G41 D4 X20 F100\nZ1\nY20\nG40 X0\n",
    "G1 G41 D4 X20 F100\nM8\nY20\nG40 X0\n",
    // It is too short, or it is an arc.
    "G1 G41 D4 X1 F100\nY20\nG40 X0\n",
    "G3 G41 D4 X20 I10 F100\nG1 X0\nG40 Y9\n",
    // An outer corner, and one that is nearly straight on.
    "G1 G41 D4 X20 F100\nY20\nX40\nY60\nG40 X0\n",
    "G1 G41 D4 X20 F100\nY20\nX20.2 Y40\nG40 X0\n",
    // Two blocks that do not move in the plane.
    "G1 G41 D4 X20 F100\nY20\nZ1\nZ2\nX0\nG40 Y0\n",
    // A way out that turns away from the tool, that is an arc, or that stands in no block with G40.
    "G1 G41 D4 X20 F100\nY20\nG40 X40\n",
    "G1 G41 D4 X20 F100\nY20\nG40 G3 X0 I-10\n",
    "G1 G41 D4 X20 F100\nY20\nG40\nX0\n",
    // The program ends under compensation.
    "G1 G41 D4 X20 F100\nY20\n",
    // A cutter that is too large for an inner corner, and another radius on the way.
    "G1 G41 D4 X20 F100\nY20\nX19\nY0\nG40 X20\n",
    "G1 G41 D4 X20 F100\nY20\nG41 D6 X0\nG40 Y0\n",
    // Another register without a code, and one without a radius.
    "G1 G41 D4 X20 F100\nY20\nD6 X0\nG40 Y0\n",
    "G1 G41 D4 X20 F100\nY20\nD6\nX0\nG40 Y0\n",
    "G1 G41 D6 X20 F100\nY20\nX0 D9\nG40 Y0\n",
    "G43 H3 Z5\nG1 G41 D4 X20 F100\nY20\nX0 H3\nG40 Y0\n",
    // A motion over no distance, to a place that the block names or not.
    "G1 G41 D4 X20 F100\nY20\nX20\nX0\nG40 Y0\n",
    "G1 G41 D4 X20 F100\nY20\nZ5\nX0\nG40 Y0\n",
    "G1 G41 D4 X20 F100\nY20\nX20 Y20 Z2\nX0\nG40 Y0\n",
    // An arc around a corner, and codes that move by offsets.
    "G1 G41 D4 X20 F100\nY20\nG39\nX0\nG40 Y0\n",
    "G1 G41 D4 X20 F100\nY20\nG39 I1 J0\nX0\nG40 Y0\n",
    "G1 G41 D4 X20 F100\nY20\nG45\nX0\nG40 Y0\n",
    // A stop, and a shift of all zeros, by nothing.
    "G1 G41 D4 X20 F100\nY20\nM0\nX0\nG40 Y0\n",
    "G1 G41 D4 X20 F100\nY20\nM1\nX0\nG40 Y0\n",
    "G1 G41 D4 X20 F100\nY20\nG52 X0 Y0\nX0\nG40 Y0\n",
];

#[test]
fn a_radius_that_the_program_writes_is_not_that_of_the_request() {
    let is_followed = |is_rs274: bool, block: &str| {
        let path = "G54 G49\nG0 X0 Y0 Z5 A0 C0\nG1 G41 D4 X20 F100\nY20\nX0\nG40 Y0\n";
        let found = understood(&[("D4", 2.0)], is_rs274, &format!("{START}{block}{path}"));
        let mut left = found.iter().filter(|told| matches!(told, Interpreted::LeftAlone { .. }));
        left.all(|told| {
            !matches!(told, Interpreted::LeftAlone { reason: Unfollowable::CutterCompensation, .. })
        })
    };
    for is_rs274 in [true, false] {
        assert!(is_followed(is_rs274, ""));
        for block in [
            "G10 L10 P4 R3\n",
            "G10 L11 P4 R3\n",
            "G10 L12 P4 R3\n",
            "G10 L13 P4 R3\n",
            "G10 L#500 P4 R3\n",
            "G10 P4 R3\n",
            "#2004=3\n",
            "#13004=3\n",
        ] {
            assert!(!is_followed(is_rs274, block), "{is_rs274} {block}");
        }
    }
    assert!(is_followed(true, "G10 L1 P4 Z80\n"));
    assert!(!is_followed(true, "G10 L1 P4 R3\n"));
}

#[test]
fn what_controls_run_differently_is_left_alone_and_so_is_the_place_after_it() {
    for blocks in LEFT_ALONE {
        let text = format!("{START}{blocks}G40 G0 Z50\nX7 Y8\nX9\n");
        let found = understood(&[("D4", 2.0), ("D6", 1.0), ("H19", 1.0)], false, &text);
        let reasons: Vec<_> = found
            .iter()
            .filter_map(|told| match told {
                Interpreted::LeftAlone { reason, .. } => Some(*reason),
                Interpreted::Motion(_) => None,
            })
            .collect();
        assert!(
            !reasons.is_empty() && reasons.iter().all(|reason| *reason == Unfollowable::CutterCompensation),
            "{blocks}\n{reasons:?}"
        );
        let [.., Interpreted::Motion(before), Interpreted::Motion(named), Interpreted::Motion(_)] = found[..]
        else {
            panic!("{blocks}\n{found:?}")
        };
        assert_eq!(before.joints[2], Some(50.0), "{blocks}");
        assert_eq!(named.joints[..2], [Some(7.0), Some(8.0)], "{blocks}");
    }
}

#[test]
fn one_block_between_two_pieces_is_followed() {
    let text = format!("{START}G1 G41 D4 X20 F100\nY20\nZ1\nX0\nG40 Y0\n");
    let wanted = [
        (1, [0.0, 0.0, 5.0]),
        (2, [18.0, 0.0, 5.0]),
        (3, [18.0, 18.0, 5.0]),
        (4, [18.0, 18.0, 1.0]),
        (5, [0.0, 18.0, 1.0]),
        (6, [0.0, 0.0, 1.0]),
    ];
    let found = ends(&[("D4", 2.0)], false, &text);
    assert!(is_near(&found, &wanted), "{found:?}");
}

#[test]
fn an_axis_stays_unknown_until_the_program_names_it() {
    let lost = "G17\nG1 G41 D4 X20 F100\nY-20\nG40 X0\n";
    for (blocks, wanted) in [
        // A second path is lost in another plane.
        ("G18\nG1 G41 D4 X30 Z-5\nX50\nG40 X0\nG0 X7 Z50\n", [Some(7.0), None, Some(50.0)]),
        // An increment counts from a place that is not known.
        ("G91 G0 X5 Y5\n", [Some(5.0), None, Some(5.0)]),
        ("G0 X7 Z50\n", [Some(7.0), None, Some(50.0)]),
        ("G0 X7 Y8\n", [Some(7.0), Some(8.0), Some(5.0)]),
    ] {
        let found = understood(&[("D4", 2.0)], false, &format!("{START}{lost}{blocks}"));
        let Some(Interpreted::Motion(last)) = found.last() else { panic!("{blocks}{found:?}") };
        assert_eq!(last.joints[..3], wanted, "{blocks}");
    }
}

/// A piece that the cutter cannot enter: some controls stop before the motion before it, others end that elsewhere.
#[test]
fn the_motion_before_a_piece_that_is_too_short_is_not_certain() {
    let text = format!("{START}G1 G41 D4 X20 F100\nY20\nX19.9 Y20.05\nX0\nG40 Y0\n");
    for is_rs274 in [true, false] {
        let found = understood(&[("D4", 2.0)], is_rs274, &text);
        let left: Vec<_> = found
            .iter()
            .filter_map(|told| match told {
                Interpreted::LeftAlone { line, .. } => Some(*line),
                Interpreted::Motion(_) => None,
            })
            .collect();
        assert_eq!(left[..3], [3, 4, 5], "{is_rs274} {found:?}");
    }
}

#[test]
fn a_cycle_at_a_place_that_is_not_known_is_left_alone() {
    let lost = "G1 G41 D4 X20 F100\nY20\nX40\nG40 Y60\n";
    for cycle in ["G98 G81 Y5 Z-3 R2 F100\n", "G99 G81 X1 Y5 Z-3 R2 F100\n", "G28 Z9\n"] {
        let found = understood(&[("D4", 2.0)], false, &format!("{START}{lost}{cycle}G80\nG0 X1 Y2\n"));
        let of_cycle = |told: &&Interpreted| matches!(told, Interpreted::Motion(motion) if motion.line == 6);
        assert_eq!(found.iter().filter(of_cycle).count(), 0, "{cycle}{found:?}");
        let Some(Interpreted::Motion(last)) = found.last() else { panic!("{cycle}{found:?}") };
        assert_eq!(last.joints[..3], [Some(1.0), Some(2.0), None], "{cycle}");
    }
}
