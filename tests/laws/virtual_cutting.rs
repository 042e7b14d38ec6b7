//! Laws of virtual cutting, for random cutters, machines, surfaces and programs.

use std::fmt::Write;
use std::ops::ControlFlow;

use proptest::prelude::*;
use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Tool};
use trunnion::process::{Verification, VerificationParameters, verify_part};
use trunnion::surface::SurfacePoint;
use trunnion::units::Length;
use trunnion::wear::{OneAfterAnother, SideBySide};

use super::machines::preset_machine;

/// Needles that meet the cutter's surface at a small angle find their entry to a multiple of 1e-8 mm; words have nine
/// decimals [mm].
const FOUND_MM: f64 = 1e-6;
/// A residual moves by no more than the resolution over the sine of the angle between needle and surface, and the
/// samples here are taken only where that is no less than a third; coarse and fine each have their share.
const STEEPNESS: f64 = 3.0;

/// So many parts, run in the order given or against it.
struct Parts {
    count: usize,
    is_reversed: bool,
}

impl SideBySide for Parts {
    fn parts(&self) -> usize {
        self.count
    }

    fn run<'a>(&self, mut parts: Vec<Box<dyn FnOnce() + Send + 'a>>) {
        if self.is_reversed {
            parts.reverse();
        }
        for part in parts {
            part();
        }
    }
}

fn tools() -> impl Strategy<Value = Tool> {
    (1.0..8.0_f64, prop_oneof![Just(0.0), Just(1.0), 0.05..0.95_f64]).prop_map(|(radius_mm, share)| {
        Tool::new(Length::from_mm(radius_mm), Length::from_mm(radius_mm * share)).expect("a tool")
    })
}

/// A point of a program: X Y Z and both rotary words.
type Words = [f64; 5];

fn points(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Words>> {
    let point = ([-15.0..15.0_f64, -15.0..15.0, -0.5..0.8], [-12.0..12.0_f64, -12.0..12.0])
        .prop_map(|([x, y, z], [a, b])| [x, y, z, a, b]);
    proptest::collection::vec(point, count)
}

/// Samples of a gentle patch under the program.
fn patch() -> Vec<SurfacePoint> {
    (0..900)
        .map(|k| {
            let (x, y) = (f64::from(k % 30) - 14.5, f64::from(k / 30) - 14.5);
            let normal = Vec3::new(0.02 * x, -0.01 * y, 1.0).normalize();
            SurfacePoint { point_mm: Vec3::new(x, y, -0.01 * x * x + 0.005 * y * y), normal }
        })
        .collect()
}

fn text(machine: &Machine, points: &[Words]) -> String {
    let letters = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    let mut text = String::from("G90 G21 G43.4 H1\n");
    for (index, [x, y, z, a, b]) in points.iter().enumerate() {
        let code = if index == 0 { "G0" } else { "G1" };
        let [first, second] = letters;
        let _ = writeln!(text, "{code} X{x:.9} Y{y:.9} Z{z:.9} {first}{a:.9} {second}{b:.9}");
    }
    text
}

fn cut(
    machine: &Machine,
    parameters: &VerificationParameters,
    samples: &[SurfacePoint],
    text: &str,
) -> Verification {
    cut_in(machine, parameters, samples, text, &OneAfterAnother)
}

fn cut_in(
    machine: &Machine,
    parameters: &VerificationParameters,
    samples: &[SurfacePoint],
    text: &str,
    parts: &dyn SideBySide,
) -> Verification {
    let go_on = || ControlFlow::Continue(());
    let source = text.as_bytes().to_vec();
    verify_part(machine, parameters, samples, &source, parts, &go_on).expect("a verification")
}

fn heights(verification: &Verification) -> Vec<Option<f64>> {
    verification.residuals.iter().map(|found| found.map(|found| found.residual_mm)).collect()
}

/// The residuals of both, where both are cut; no more than a few samples may be cut in one only, at the very top.
fn pairs(a: &Verification, b: &Verification, near_top_mm: f64) -> Result<Vec<[f64; 2]>, TestCaseError> {
    let mut pairs = Vec::new();
    for found in heights(a).into_iter().zip(heights(b)) {
        match found {
            (Some(a), Some(b)) => pairs.push([a, b]),
            (None, None) => {}
            // the top of the needle is grazed in one of them
            (Some(height), None) | (None, Some(height)) => {
                prop_assert!(height > 1.0 - near_top_mm, "{height}")
            }
        }
    }
    Ok(pairs)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn residuals_are_the_same_bits_in_however_many_parts(
        machine in preset_machine(),
        tool in tools(),
        points in points(4..30),
        count in 1..40_usize,
        is_reversed in any::<bool>(),
    ) {
        let parameters = VerificationParameters::new(tool);
        let (samples, text) = (patch(), text(&machine, &points));
        let whole = cut(&machine, &parameters, &samples, &text);
        let shared = cut_in(&machine, &parameters, &samples, &text, &Parts { count, is_reversed });
        prop_assert_eq!(whole, shared);
    }

    #[test]
    fn the_order_of_passes_does_not_matter(
        machine in preset_machine(),
        tool in tools(),
        passes in proptest::collection::vec(points(2..3), 2..9),
    ) {
        // the tool is taken far up between passes, so that only the passes cut
        let lifted = |[x, y, _, a, b]: Words| [x, y, 300.0, a, b];
        let there = |passes: &[Vec<Words>]| -> Vec<Words> {
            passes.iter().flat_map(|pass| [lifted(pass[0]), pass[0], pass[1], lifted(pass[1])]).collect()
        };
        let parameters = VerificationParameters::new(tool);
        let samples = patch();
        let straight = cut(&machine, &parameters, &samples, &text(&machine, &there(&passes)));
        let mut turned = passes;
        turned.reverse();
        let reversed = cut(&machine, &parameters, &samples, &text(&machine, &there(&turned)));
        for [a, b] in pairs(&straight, &reversed, FOUND_MM)? {
            prop_assert!((a - b).abs() < FOUND_MM, "{a} {b}");
        }
    }

    #[test]
    fn more_motions_never_raise_a_residual(
        machine in preset_machine(),
        tool in tools(),
        points in points(6..20),
        kept in 2..6_usize,
    ) {
        let parameters = VerificationParameters::new(tool);
        let samples = patch();
        let few = heights(&cut(&machine, &parameters, &samples, &text(&machine, &points[..kept])));
        let many = heights(&cut(&machine, &parameters, &samples, &text(&machine, &points)));
        for (few, many) in few.into_iter().zip(many) {
            if let Some(few) = few {
                prop_assert!(many.is_some_and(|many| many <= few + FOUND_MM), "{few} {many:?}");
            }
        }
    }

    #[test]
    fn a_finer_resolution_moves_residuals_by_no_more_than_the_coarser_one_states(
        machine in preset_machine(),
        tool in tools(),
        points in points(3..8),
    ) {
        let samples = patch();
        let mut parameters = VerificationParameters::new(tool);
        parameters.setup = Setup { tool_length_mm: 120.0, ..Setup::default() };
        parameters.resolution = Length::from_mm(0.01);
        let coarse = cut(&machine, &parameters, &samples, &text(&machine, &points));
        parameters.resolution = Length::from_mm(0.000_5);
        let fine = cut(&machine, &parameters, &samples, &text(&machine, &points));
        let largest = STEEPNESS * (0.01 + 0.000_5);
        for [a, b] in pairs(&coarse, &fine, 2.0 * largest)? {
            prop_assert!((a - b).abs() < largest, "{a} {b}");
        }
    }

    #[test]
    fn a_block_divided_in_two_cuts_the_same(
        machine in preset_machine(),
        tool in tools(),
        points in points(2..6),
        share in 0.1..0.9_f64,
    ) {
        let samples = patch();
        let parameters = VerificationParameters::new(tool);
        let whole = cut(&machine, &parameters, &samples, &text(&machine, &points));
        let mut divided = vec![points[0]];
        for pair in points.windows(2) {
            divided.push(std::array::from_fn(|k| pair[0][k] + (pair[1][k] - pair[0][k]) * share));
            divided.push(pair[1]);
        }
        let divided = cut(&machine, &parameters, &samples, &text(&machine, &divided));
        let largest = STEEPNESS * 2.0 * 0.000_5;
        for [a, b] in pairs(&whole, &divided, 2.0 * largest)? {
            prop_assert!((a - b).abs() < largest, "{a} {b}");
        }
    }
}
