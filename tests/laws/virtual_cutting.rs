//! Laws of virtual cutting, for random cutters, machines, surfaces and programs.

use std::fmt::Write;
use std::ops::ControlFlow;

use proptest::prelude::*;
use trunnion::contact::rotary_rad;
use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup, ToolPose};
use trunnion::machine::{Machine, Tool};
use trunnion::process::{Verification, VerificationParameters, verify_part};
use trunnion::side_by_side::{OneAfterAnother, SideBySide};
use trunnion::surface::SurfacePoint;
use trunnion::units::Length;

use super::machines::{direction, preset_machine, vector};
use crate::models::set_ups::at_zero;

/// Needles that meet the cutter's surface at a small angle find their entry to a multiple of 1e-8 mm; words have nine
/// decimals [mm].
const FOUND_MM: f64 = 1e-6;
/// What surfaces that are so far apart may differ by along a needle, or along one that far beside it.
const APART: f64 = 3.0;
/// A needle and those beside it, all round.
const BESIDE: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [1.0, 1.0],
    [1.0, -1.0],
    [-1.0, 1.0],
    [-1.0, -1.0],
];

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

/// Tips as the linear words that reach them, for programs without TCP.
fn as_axis_words(machine: &Machine, points: &[Words]) -> Vec<Words> {
    let kinematics = Kinematics::new(machine, &Setup::default());
    points
        .iter()
        .map(|&[x, y, z, a, b]| {
            let linear_mm = kinematics.linear_mm(Vec3::new(x, y, z), rotary_rad(machine, [a, b]));
            [linear_mm.x, linear_mm.y, linear_mm.z, a, b]
        })
        .collect()
}

fn text(machine: &Machine, points: &[Words]) -> String {
    with_codes("G90 G21 G43.4 H1\n", machine, points)
}

fn with_codes(codes: &str, machine: &Machine, points: &[Words]) -> String {
    let letters = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    let mut text = codes.to_owned();
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

/// The patch, every needle with those beside it.
fn bunches(aside_mm: f64) -> Vec<SurfacePoint> {
    let beside = |sample: SurfacePoint| {
        let x = Vec3::y().cross(&sample.normal).normalize();
        let y = sample.normal.cross(&x);
        BESIDE.map(|[a, b]| SurfacePoint { point_mm: sample.point_mm + (x * a + y * b) * aside_mm, ..sample })
    };
    patch().into_iter().step_by(2).flat_map(beside).collect()
}

/// Whether two cuttings of the same bunches leave surfaces that are nowhere farther apart than `apart_mm`: steps and
/// steep flanks may stand a little aside. Uncut needles have the height of the stock.
fn are_near(a: &Verification, b: &Verification, apart_mm: f64) -> Result<(), TestCaseError> {
    let [a, b] = [a, b].map(|found| -> Vec<f64> {
        heights(found).into_iter().map(|height| height.unwrap_or(1.0)).collect()
    });
    for (a, b) in a.chunks(BESIDE.len()).zip(b.chunks(BESIDE.len())) {
        for (one, other) in [(a, b), (b, a)] {
            let low = other.iter().copied().fold(f64::INFINITY, f64::min) - apart_mm;
            let high = other.iter().copied().fold(f64::NEG_INFINITY, f64::max) + apart_mm;
            prop_assert!((low..=high).contains(&one[0]), "{one:?} {other:?}");
        }
    }
    Ok(())
}

/// A cutter by what is inside it, made larger or smaller all round: independent of any distance.
struct Solid {
    radius: f64,
    corner: f64,
    /// From the bottom, which may lie under or over the tip.
    bottom: f64,
    length: f64,
}

impl Solid {
    fn new(tool: &Tool, cutting_length_mm: f64, grown_mm: f64) -> Self {
        let (radius, corner) = (tool.radius().mm() + grown_mm, tool.corner_radius().mm() + grown_mm);
        let (corner, length) = (corner.max(0.0), cutting_length_mm + 2.0 * grown_mm);
        Self { radius, corner, bottom: -grown_mm, length }
    }

    fn holds(&self, pose: &ToolPose, q: Vec3) -> bool {
        let v = q - pose.tip_mm;
        let along = v.x * pose.axis.x + v.y * pose.axis.y + v.z * pose.axis.z;
        let rho = (v.x * v.x + v.y * v.y + v.z * v.z - along * along).max(0.0).sqrt();
        let z = along - self.bottom;
        let core = self.radius - self.corner;
        (0.0..=self.length).contains(&z)
            && rho <= self.radius
            && (z >= self.corner
                || rho <= core
                || (rho - core).powi(2) + (z - self.corner).powi(2) <= self.corner.powi(2))
    }
}

/// Places and normals about a motion, some of them out of reach.
fn anywhere_about(from: Vec3, to: Vec3, reach_mm: f64) -> impl Strategy<Value = SurfacePoint> {
    (0.0..1.0_f64, vector(1.0), direction()).prop_map(move |(u, aside, normal)| SurfacePoint {
        point_mm: from + (to - from) * u + aside * reach_mm,
        normal,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn residuals_are_the_same_bits_in_however_many_parts(
        machine in preset_machine(true),
        tool in tools(),
        points in points(4..30),
        count in 1..40_usize,
        is_reversed in any::<bool>(),
    ) {
        let parameters = VerificationParameters::new(tool, at_zero());
        let (samples, text) = (patch(), text(&machine, &points));
        let whole = cut(&machine, &parameters, &samples, &text);
        let shared = cut_in(&machine, &parameters, &samples, &text, &Parts { count, is_reversed });
        prop_assert_eq!(whole, shared);
    }

    #[test]
    fn the_order_of_passes_does_not_matter(
        machine in preset_machine(true),
        tool in tools(),
        passes in proptest::collection::vec(points(2..3), 2..9),
    ) {
        // the tool is taken far up between passes, so that only the passes cut
        let lifted = |[x, y, _, a, b]: Words| [x, y, 300.0, a, b];
        let there = |passes: &[Vec<Words>]| -> Vec<Words> {
            passes.iter().flat_map(|pass| [lifted(pass[0]), pass[0], pass[1], lifted(pass[1])]).collect()
        };
        let parameters = VerificationParameters::new(tool, at_zero());
        let samples = bunches(FOUND_MM);
        let straight = cut(&machine, &parameters, &samples, &text(&machine, &there(&passes)));
        let mut turned = passes;
        turned.reverse();
        let reversed = cut(&machine, &parameters, &samples, &text(&machine, &there(&turned)));
        are_near(&straight, &reversed, FOUND_MM)?;
    }

    #[test]
    fn more_motions_never_raise_a_residual(
        machine in preset_machine(true),
        tool in tools(),
        points in points(6..20),
        kept in 2..6_usize,
    ) {
        let parameters = VerificationParameters::new(tool, at_zero());
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
        machine in preset_machine(true),
        tool in tools(),
        points in points(3..8),
        is_tcp in any::<bool>(),
    ) {
        let apart_mm = APART * (0.01 + 0.000_5);
        let samples = bunches(apart_mm);
        let mut parameters = VerificationParameters::new(tool, at_zero());
        let text = if is_tcp {
            text(&machine, &points)
        } else {
            with_codes("G90 G21 G49\n", &machine, &as_axis_words(&machine, &points))
        };
        parameters.resolution = Length::from_mm(0.01);
        let coarse = cut(&machine, &parameters, &samples, &text);
        parameters.resolution = Length::from_mm(0.000_5);
        let fine = cut(&machine, &parameters, &samples, &text);
        are_near(&coarse, &fine, apart_mm)?;
    }

    #[test]
    fn a_block_divided_in_two_cuts_the_same(
        machine in preset_machine(true),
        tool in tools(),
        points in points(2..6),
        share in 0.1..0.9_f64,
        is_tcp in any::<bool>(),
    ) {
        let apart_mm = APART * 2.0 * 0.000_5;
        let samples = bunches(apart_mm);
        let parameters = VerificationParameters::new(tool, at_zero());
        let points = if is_tcp { points } else { as_axis_words(&machine, &points) };
        let codes = if is_tcp { "G90 G21 G43.4 H1\n" } else { "G90 G21 G49\n" };
        let whole = cut(&machine, &parameters, &samples, &with_codes(codes, &machine, &points));
        let mut divided = vec![points[0]];
        for pair in points.windows(2) {
            divided.push(std::array::from_fn(|k| pair[0][k] + (pair[1][k] - pair[0][k]) * share));
            divided.push(pair[1]);
        }
        let divided = cut(&machine, &parameters, &samples, &with_codes(codes, &machine, &divided));
        are_near(&whole, &divided, apart_mm)?;
    }

}

/// Cases of the most laborious law. `TRUNNION_THOROUGH_TESTS=1` looks at more.
fn laborious() -> u32 {
    if std::env::var_os("TRUNNION_THOROUGH_TESTS").is_some() { 200 } else { 60 }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: laborious(), ..ProptestConfig::default() })]

    #[test]
    fn no_position_enters_lower_than_what_is_found_and_one_enters_there(
        (machine, tool, from, to, length_share, samples) in (preset_machine(true), tools(), points(1..2), points(1..2))
            .prop_flat_map(|(machine, tool, from, to)| {
                let (from, to) = (from[0], to[0]);
                // motions of a few millimetres, so that ends and middle all matter
                let to: Words = std::array::from_fn(|k| from[k] + 0.2 * (to[k] - from[k]));
                let place = |w: &Words| Vec3::new(w[0], w[1], w[2]);
                let reach_mm = 1.5 * tool.radius().mm() + 1.0;
                let about = anywhere_about(place(&from), place(&to), reach_mm);
                let samples = proptest::collection::vec(about, 200);
                (Just(machine), Just(tool), Just(from), Just(to), 0.01..2.0_f64, samples)
            }),
        stock_mm in 0.2..3.0_f64,
        turns in any::<bool>(),
    ) {
        const POSES: u32 = 1500;
        let mut to = to;
        if !turns {
            (to[3], to[4]) = (from[3], from[4]);
        }
        let cutting_length_mm = tool.corner_radius().mm() + length_share * tool.radius().mm();
        let mut parameters = VerificationParameters::new(tool, at_zero());
        parameters.cutting_length = Some(Length::from_mm(cutting_length_mm));
        parameters.stock = Length::from_mm(stock_mm);
        let found = cut(&machine, &parameters, &samples, &text(&machine, &[from, to]));
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let poses: Vec<ToolPose> = (0..=POSES)
            .map(|k| {
                let u = f64::from(k) / f64::from(POSES);
                let [x, y, z, a, b]: Words = std::array::from_fn(|k| from[k] + (to[k] - from[k]) * u);
                ToolPose { tip_mm: Vec3::new(x, y, z), axis: kinematics.axis(rotary_rad(&machine, [a, b])) }
            })
            .collect();
        // from one pose to the next no point of the cutter goes farther than this
        let reach_mm = cutting_length_mm + tool.radius().mm();
        let step_mm = poses
            .windows(2)
            .map(|pair| (pair[1].tip_mm - pair[0].tip_mm).norm() + reach_mm * (pair[1].axis - pair[0].axis).norm())
            .fold(0.0, f64::max);
        let resolution_mm = if turns { parameters.resolution.mm() } else { 0.0 };
        let smaller = Solid::new(&tool, cutting_length_mm, -resolution_mm - FOUND_MM);
        let larger = Solid::new(&tool, cutting_length_mm, resolution_mm + step_mm + FOUND_MM);
        for (sample, residual) in samples.iter().zip(heights(&found)) {
            let at = |s: f64| sample.point_mm + sample.normal * s;
            let (top, foot) = (at(stock_mm), at(0.0));
            let lowest = residual.unwrap_or(stock_mm);
            for pose in &poses {
                let reaches = smaller.holds(pose, at(lowest));
                let gouges = smaller.holds(pose, foot) && (lowest > 0.0 || reaches);
                let enters = gouges || (reaches && smaller.holds(pose, top));
                prop_assert!(!enters, "{sample:?} {residual:?} {pose:?}");
            }
            if residual.is_some() {
                let counts = |pose: &ToolPose| larger.holds(pose, top) || larger.holds(pose, foot);
                let enters = |pose: &ToolPose| counts(pose) && larger.holds(pose, at(lowest));
                prop_assert!(poses.iter().any(enters), "{sample:?} {residual:?}");
            }
        }
        prop_assert!(found.summary.cut > 0 || length_share < 0.6, "nothing cut");
    }
}
