//! Virtual cutting against closed forms: scallops, plunges, gouges, flanks, thin walls, worn cutters.

use std::f64::consts::PI;
use std::fmt::Write;
use std::ops::ControlFlow;

use crate::set_ups::{at_zero, in_mm};
use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset, Tool};
use trunnion::process::{Fault, Verification, VerificationFault, VerificationParameters, verify_part};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::surface::SurfacePoint;
use trunnion::units::{Angle, Length};
use trunnion::wear::{Surface, effective_radius, scallop_height};

/// Words in the programs here have nine decimals, and entries are found to 3e-8 mm along needles that meet the cutter's
/// surface at no less than 30° [mm].
const FOUND_MM: f64 = 6e-8;
/// The default resolution, met by the surface at no less than 45° [mm].
const RESOLVED_MM: f64 = 1.5 * 5e-4;

fn tool(radius_mm: f64, corner_mm: f64) -> Tool {
    Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)).expect("a tool")
}

/// A and C tables through the machine's origin.
fn machine() -> Machine {
    Machine::new(Preset::by_id("example-ac-table").expect("the preset").parts()).expect("a machine")
}

fn run(
    parameters: &VerificationParameters,
    samples: &[SurfacePoint],
    text: &str,
) -> Result<Verification, Fault> {
    let go_on = || ControlFlow::Continue(());
    let source = text.as_bytes().to_vec();
    verify_part(&machine(), parameters, samples, &source, &OneAfterAnother, &go_on)
}

fn verify(tool: Tool, samples: &[SurfacePoint], text: &str) -> Verification {
    run(&VerificationParameters::new(tool, at_zero()), samples, text).expect("a verification")
}

fn residuals_mm(verification: &Verification) -> Vec<f64> {
    verification.residuals.iter().map(|residual| residual.expect("cut").residual_mm).collect()
}

fn up(x: f64, y: f64, z: f64) -> SurfacePoint {
    SurfacePoint { point_mm: Vec3::new(x, y, z), normal: Vec3::z() }
}

/// A program of straight passes with the axes of the tool at `a_deg`, from and to tips in W, a rapid between them far
/// above or aside (`clear`).
fn passes(a_deg: f64, passes: &[[Vec3; 2]], clear: Vec3) -> String {
    let mut text = String::from("G90 G21 G43.4 H1\n");
    for [from, to] in passes {
        for (code, at) in [("G0", from + clear), ("G0", *from), ("G1", *to), ("G0", to + clear)] {
            let _ = writeln!(text, "{code} X{:.9} Y{:.9} Z{:.9} A{a_deg:.9} C0", at.x, at.y, at.z);
        }
    }
    text
}

/// The tool's axis on this machine at A, C = 0.
fn axis_at(a_deg: f64) -> Vec3 {
    let (sin, cos) = a_deg.to_radians().sin_cos();
    Vec3::new(0.0, -sin, cos)
}

/// Tip of a cutter that touches a surface at a point with this normal.
fn tip_at(tool: &Tool, contact: Vec3, n: Vec3, t: Vec3) -> Vec3 {
    let core = tool.core_radius().mm();
    let m = if core > 0.0 { (n - t * n.dot(&t)).normalize() } else { Vec3::zeros() };
    let r = tool.corner_radius().mm();
    contact + n * r + m * core - t * r
}

#[test]
fn parallel_passes_of_a_ball_leave_the_scallops_of_the_closed_form() {
    let (radius, stepover) = (5.0, 0.8);
    let lines: Vec<[Vec3; 2]> =
        (0..6).map(|k| [-10.0, 10.0].map(|x| Vec3::new(x, f64::from(k) * stepover, 0.0))).collect();
    let samples: Vec<_> = (0..=200).map(|k| up(0.01 * f64::from(k % 7), 0.02 * f64::from(k), 0.0)).collect();
    let verification = verify(tool(radius, radius), &samples, &passes(0.0, &lines, Vec3::z() * 20.0));
    for (sample, residual_mm) in samples.iter().zip(residuals_mm(&verification)) {
        let y = sample.point_mm.y;
        let aside = y - stepover * (y / stepover).round();
        let expected = radius - (radius * radius - aside * aside).sqrt();
        assert!((residual_mm - expected).abs() < FOUND_MM, "{y}: {residual_mm} {expected}");
    }
    let height = scallop_height(Length::from_mm(stepover), Length::from_mm(radius), Surface::Flat);
    let highest = verification.summary.max_excess.expect("excess");
    assert!((highest.residual.residual_mm - height.expect("a height").mm()).abs() < FOUND_MM);
    assert_eq!((verification.motions.linear, verification.motions.rapids), (6, 17));
    assert_eq!(verification.summary.over_gouge, 0);
    // between the third and the fourth pass
    let residual = verification.residuals[90].expect("cut");
    assert!([12, 16].contains(&residual.line), "{residual:?}");
}

#[test]
fn inclined_bull_nose_and_flat_cutters_cut_with_their_effective_radius() {
    /// A circle of the effective radius stands for an ellipse, or for the offset of one: of the fourth order in
    /// stepover over radius (share).
    const CIRCLE: f64 = 2e-3;
    let (stepover, lead_deg) = (0.4, 12.0);
    for (radius, corner) in [(5.0, 1.0), (5.0, 0.0), (5.0, 4.9)] {
        let cutter = tool(radius, corner);
        let t = axis_at(lead_deg);
        let contact = |x: f64, y: f64| tip_at(&cutter, Vec3::new(x, y, 0.0), Vec3::z(), t);
        let lines: Vec<[Vec3; 2]> =
            (0..5).map(|k| [-12.0, 12.0].map(|y| contact(f64::from(k) * stepover, y))).collect();
        let samples: Vec<_> = (0..=160).map(|k| up(0.01 * f64::from(k), 0.3, 0.0)).collect();
        let verification = verify(cutter, &samples, &passes(lead_deg, &lines, Vec3::z() * 30.0));
        let lead = Angle::from_deg(lead_deg);
        let effective = effective_radius(&cutter, lead).expect("an effective radius");
        let expected =
            scallop_height(Length::from_mm(stepover), effective, Surface::Flat).expect("a height").mm();
        let highest_mm = verification.summary.max_excess.expect("excess").residual.residual_mm;
        assert!((highest_mm / expected - 1.0).abs() < CIRCLE, "{corner}: {highest_mm} {expected}");
        if corner == 0.0 {
            for (sample, residual_mm) in samples.iter().zip(residuals_mm(&verification)) {
                let x = sample.point_mm.x;
                let aside = x - stepover * (x / stepover).round();
                let ellipse = lead.rad().sin() * (radius - (radius * radius - aside * aside).sqrt());
                assert!((residual_mm - ellipse).abs() < FOUND_MM, "{x}: {residual_mm} {ellipse}");
            }
        }
        assert!(verification.summary.max_gouge.is_none_or(|gouge| gouge.residual.residual_mm > -FOUND_MM));
    }
}

#[test]
fn passes_along_cylinders_leave_the_scallops_of_convex_and_concave_surfaces() {
    let (rs, radius, stepover): (f64, f64, f64) = (10.0, 5.0, 0.6);
    let step_rad = 2.0 * (0.5 * stepover / rs).asin();
    for k in [1.0, -1.0] {
        // the crest of a convex cylinder, the trough of a concave one, both at z = 0
        let place = |angle: f64| {
            let radial = Vec3::new(0.0, angle.sin(), angle.cos());
            if k > 0.0 { (radial * rs, radial) } else { (-radial * rs, radial) }
        };
        let lines: Vec<[Vec3; 2]> = (-4..=4)
            .map(|index| {
                let (point, normal) = place(f64::from(index) * step_rad);
                [-6.0, 6.0].map(|x| tip_at(&tool(radius, radius), point + Vec3::x() * x, normal, Vec3::z()))
            })
            .collect();
        let samples: Vec<_> = (-60..=60)
            .map(|index| {
                let (point_mm, normal) = place(f64::from(index) * 0.05 * step_rad);
                SurfacePoint { point_mm, normal }
            })
            .collect();
        let verification = verify(tool(radius, radius), &samples, &passes(0.0, &lines, Vec3::z() * 40.0));
        let curved = Length::from_mm(rs);
        let surface =
            if k > 0.0 { Surface::Convex { radius: curved } } else { Surface::Concave { radius: curved } };
        let expected = scallop_height(Length::from_mm(stepover), Length::from_mm(radius), surface);
        let highest_mm = verification.summary.max_excess.expect("excess").residual.residual_mm;
        assert!((highest_mm - expected.expect("a height").mm()).abs() < FOUND_MM, "{k}: {highest_mm}");
        let deepest_mm = verification.summary.max_gouge.map_or(0.0, |gouge| gouge.residual.residual_mm);
        assert!(deepest_mm > -FOUND_MM, "{deepest_mm}");
    }
}

#[test]
fn a_plunge_leaves_its_own_hole_and_nothing_beside_it() {
    let samples: Vec<_> = (0..60).map(|k| up(0.1 * f64::from(k) + 0.05, 0.0, 0.0)).collect();
    let text = "G90 G21\nG0 X0 Y0 Z30 A0 C0\nG1 X0 Y0 Z0\nG1 Z30\n";
    let ball = verify(tool(5.0, 5.0), &samples, text);
    let bull = verify(tool(5.0, 2.0), &samples, text);
    let flat = verify(tool(5.0, 0.0), &samples, text);
    for (index, sample) in samples.iter().enumerate() {
        let rho = sample.point_mm.x;
        // 1 mm of stock over the surface
        let expected = |core: f64, corner: f64| {
            let aside = (rho - core).max(0.0);
            let height = corner - (corner * corner - aside * aside).max(0.0).sqrt();
            (aside < corner && height < 1.0).then_some(height)
        };
        for (found, core, corner) in [(&ball, 0.0, 5.0), (&bull, 3.0, 2.0)] {
            match (found.residuals[index], expected(core, corner)) {
                (Some(found), Some(height)) => {
                    assert!((found.residual_mm - height).abs() < FOUND_MM, "{rho}: {found:?} {height}");
                }
                (None, None) => {}
                other => panic!("{corner} {rho}: {other:?}"),
            }
        }
        let expected = (rho < 5.0).then_some(0.0);
        assert_eq!(
            flat.residuals[index].map(|found| found.residual_mm.abs() < FOUND_MM),
            expected.map(|_| true)
        );
    }
    assert_eq!(ball.summary.uncut + ball.summary.cut, 60);
    assert_eq!(ball.summary.uncut, 30);
}

#[test]
fn a_gouge_has_its_depth_and_its_line_and_a_rapid_is_told() {
    let samples: Vec<_> = (0..50).map(|k| up(0.2 * f64::from(k), 0.0, 0.0)).collect();
    let text = "G90 G21\nG0 X-20 Y0 Z30 A0 C0\nG0 X-20 Y0 Z0\nG1 X4\nG1 Z-0.05\nG1 X4.5\nG1 Z0\nG1 X20\n\
                G0 Y30\nG0 X7 Z-0.2\nG0 Y-30\n";
    let verification = verify(tool(5.0, 5.0), &samples, text);
    let summary = &verification.summary;
    let gouge = summary.max_gouge.expect("a gouge");
    assert!((gouge.residual.residual_mm + 0.2).abs() < FOUND_MM, "{gouge:?}");
    assert_eq!((gouge.residual.line, gouge.residual.by_rapid, gouge.index), (11, true, 35));
    assert_eq!(summary.worst_line, Some(11));
    // a ball sunk by h reaches √(h(2R − h)) to either side at depth 0, and more than 30 µm down a little less
    let by_feed = verification.residuals[21].expect("cut");
    assert!((by_feed.residual_mm + 0.05).abs() < FOUND_MM);
    assert!((5..=7).contains(&by_feed.line) && !by_feed.by_rapid, "{by_feed:?}");
    let bottom = |x: f64, from: f64, to: f64| 5.0 - (25.0 - (x - x.clamp(from, to)).powi(2)).max(0.0).sqrt();
    let (mut deeper, mut by_rapid) = (0, 0);
    for (sample, residual) in samples.iter().zip(&verification.residuals) {
        let x = sample.point_mm.x;
        let [feed, rapid] = [bottom(x, 4.0, 4.5) - 0.05, bottom(x, 7.0, 7.0) - 0.2];
        deeper += u64::from(feed.min(rapid) < -0.03);
        by_rapid += u64::from(rapid < feed && rapid < -0.03);
        assert!((residual.expect("cut").residual_mm - feed.min(rapid).min(0.0)).abs() < FOUND_MM, "{x}");
    }
    assert_eq!((summary.over_gouge, summary.gouged_by_rapid), (deeper, by_rapid));
    assert!(summary.gouged_by_rapid > 3 && summary.gouged_by_rapid < summary.over_gouge);
}

#[test]
fn a_flank_cuts_a_wall_as_far_as_it_reaches() {
    let samples: Vec<_> = (0..100)
        .map(|k| SurfacePoint { point_mm: Vec3::new(0.3, 0.0, 0.25 * f64::from(k)), normal: Vec3::y() })
        .collect();
    let offset = 0.012;
    let line = [-15.0, 15.0].map(|x| Vec3::new(x, 4.0 + offset, 0.0));
    let text = passes(0.0, &[line], Vec3::y() * 40.0);
    for corner in [0.0, 1.0, 4.0] {
        let mut parameters = VerificationParameters::new(tool(4.0, corner), at_zero());
        parameters.cutting_length = Some(Length::from_mm(18.1));
        let verification = run(&parameters, &samples, &text).expect("a verification");
        for (sample, residual) in samples.iter().zip(&verification.residuals) {
            let z = sample.point_mm.z;
            if z > 18.1 {
                assert_eq!(*residual, None, "{z}");
                continue;
            }
            let below = (corner - z).max(0.0);
            let expected = offset + corner - (corner * corner - below * below).sqrt();
            if expected < 0.999 {
                let found = residual.expect("cut").residual_mm;
                assert!((found - expected).abs() < FOUND_MM, "{corner} {z}: {found} {expected}");
            }
        }
    }
}

#[test]
fn a_thin_wall_cut_from_both_sides_shows_no_gouge() {
    let thickness = 0.6;
    let faces = [(0.5 * thickness, Vec3::y()), (-0.5 * thickness, -Vec3::y())];
    let samples: Vec<_> = faces
        .iter()
        .flat_map(|&(y, normal)| {
            (0..80).map(move |k| SurfacePoint {
                point_mm: Vec3::new(0.1 * f64::from(k % 9), y, 5.0 + 0.1 * f64::from(k)),
                normal,
            })
        })
        .collect();
    for corner in [5.0, 0.0] {
        let lines = faces.map(|(y, normal)| [-15.0, 15.0].map(|x| Vec3::new(x, y + 5.0 * normal.y, 0.0)));
        let text: String =
            passes(0.0, &lines[..1], Vec3::y() * 40.0) + &passes(0.0, &lines[1..], -Vec3::y() * 40.0);
        // between the sides the program goes over the wall
        let text = text.replacen("G90 G21 G43.4 H1\nG0", "G90 G21 G43.4 H1\nG0 Z60\nG0", 2);
        let text = text.replace("A0.000000000 C0\nG90 G21 G43.4 H1\nG0 Z60", "A0 C0\nG0 Z60\nG0 Y-40");
        let verification = verify(tool(5.0, corner), &samples, &text);
        assert_eq!(verification.summary.uncut, 0);
        for residual_mm in residuals_mm(&verification) {
            assert!(residual_mm.abs() < FOUND_MM, "{residual_mm}");
        }
    }
}

#[test]
fn an_uncompensated_worn_cutter_leaves_what_the_formula_says() {
    for tilt_deg in [15.0_f64, 40.0, 70.0] {
        let t = axis_at(tilt_deg);
        for (nominal, worn) in [((5.0, 5.0), (4.6, 4.6)), ((5.0, 1.0), (4.7, 0.8)), ((3.0, 3.0), (3.2, 3.2))]
        {
            let (nominal, worn) = (tool(nominal.0, nominal.1), tool(worn.0, worn.1));
            let line = [-12.0, 12.0].map(|y| tip_at(&nominal, Vec3::new(0.0, y, 0.0), Vec3::z(), t));
            let text = passes(tilt_deg, &[line], Vec3::z() * 30.0);
            let samples: Vec<_> = (0..20).map(|k| up(0.0, 0.1 * f64::from(k), 0.0)).collect();
            let n_t = tilt_deg.to_radians().cos();
            let corner = nominal.corner_radius().mm() - worn.corner_radius().mm();
            let core = nominal.core_radius().mm() - worn.core_radius().mm();
            let expected = corner * (1.0 - n_t) + core * (1.0 - n_t * n_t).sqrt();
            for residual_mm in residuals_mm(&verify(worn, &samples, &text)) {
                assert!((residual_mm - expected).abs() < FOUND_MM, "{tilt_deg}: {residual_mm} {expected}");
            }
        }
    }
}

/// A bull-nose cutter, by what is inside it: independent of any distance.
struct Solid {
    radius: f64,
    corner: f64,
    length: f64,
}

impl Solid {
    /// Whether a point at this distance from the axis and height over the tip is inside.
    fn holds(&self, rho: f64, z: f64) -> bool {
        let core = self.radius - self.corner;
        (0.0..=self.length).contains(&z)
            && rho <= self.radius
            && (z >= self.corner
                || rho <= core
                || (rho - core).powi(2) + (z - self.corner).powi(2) <= self.corner.powi(2))
    }

    /// Where the part of the needle that holds its top or its foot begins, if below `known`: by bisection, the inside
    /// of the needle being one stretch.
    fn entry(
        &self,
        tip: [f64; 3],
        t: [f64; 3],
        sample: &SurfacePoint,
        stock: f64,
        known: f64,
    ) -> Option<f64> {
        let inside = |s: f64| {
            let q = sample.point_mm + sample.normal * s;
            let v = [q.x - tip[0], q.y - tip[1], q.z - tip[2]];
            let z = v[0] * t[0] + v[1] * t[1] + v[2] * t[2];
            let rho = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - z * z).max(0.0).sqrt();
            self.holds(rho, z)
        };
        let begins = |known: f64| {
            let (mut low, mut high) = (known - 100.0, known);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if inside(middle) { high = middle } else { low = middle }
            }
            high
        };
        let below = known.min(0.0);
        let gouges = inside(0.0) && inside(below);
        let from_outside = inside(stock) && inside(known);
        if gouges { Some(begins(below)) } else { from_outside.then(|| begins(known)) }
    }
}

/// Tip and axis in W of a trunnion table A C through the machine's origin, from its rotation matrices.
fn pose(words: [f64; 5], offset: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let ((sa, ca), (sc, cc)) = (words[3].to_radians().sin_cos(), words[4].to_radians().sin_cos());
    let turn = |p: [f64; 3]| {
        let q = [p[0], ca * p[1] - sa * p[2], sa * p[1] + ca * p[2]];
        [cc * q[0] - sc * q[1], sc * q[0] + cc * q[1], q[2]]
    };
    let at = turn([words[0] + offset[0], words[1] + offset[1], words[2] + offset[2]]);
    ([at[0] - offset[0], at[1] - offset[1], at[2] - offset[2]], turn([0.0, 0.0, 1.0]))
}

#[test]
fn turning_axes_cut_as_a_dense_series_of_poses_does() {
    /// Poses are so dense that the best of them is within a tenth of the resolution of the true one.
    const POSES: usize = 8000;
    let offset = [3.0, -2.0, 25.0];
    // one block that turns both axes by a lot while it moves, over a dome-like patch
    let ends = [[-6.0, -1.0, 2.0, 4.0, -8.0], [6.0, 2.5, 1.0, 16.0, 21.0]];
    // `TRUNNION_THOROUGH_TESTS=1` looks at all of the patch.
    let each = if std::env::var_os("TRUNNION_THOROUGH_TESTS").is_some() { 1 } else { 3 };
    let samples: Vec<_> = (0..400)
        .step_by(each)
        .map(|k| {
            let (x, y) = (f64::from(k % 20) * 0.7 - 6.5, f64::from(k / 20) * 0.5 - 5.0);
            let normal = Vec3::new(0.06 * x, 0.04 * y, 1.0).normalize();
            SurfacePoint { point_mm: Vec3::new(x, y, 1.5 - 0.03 * x * x - 0.02 * y * y), normal }
        })
        .collect();
    for (radius, corner) in [(5.0, 5.0), (4.0, 1.0), (4.0, 0.0)] {
        let solid = Solid { radius, corner, length: 4.0 * radius };
        let mut expected = vec![None::<f64>; samples.len()];
        for k in 0..=POSES {
            let u = k as f64 / POSES as f64;
            let words = std::array::from_fn(|axis| ends[0][axis] + (ends[1][axis] - ends[0][axis]) * u);
            let (tip, t) = pose(words, offset);
            for (sample, lowest) in samples.iter().zip(&mut expected) {
                *lowest = solid.entry(tip, t, sample, 1.0, lowest.unwrap_or(1.0)).or(*lowest);
            }
        }
        let words = |w: &[f64; 5]| format!("X{} Y{} Z{} A{} C{}", w[0], w[1], w[2], w[3], w[4]);
        let text = format!("G90 G21\nG0 {}\nG1 {}\n", words(&ends[0]), words(&ends[1]));
        let setup = Setup { work_offset_mm: Vec3::from(offset), ..Setup::default() };
        let mut parameters = VerificationParameters::new(tool(radius, corner), in_mm(&setup));
        parameters.cutting_length = Some(Length::from_mm(solid.length));
        let verification = run(&parameters, &samples, &text).expect("a verification");
        let mut worst: f64 = 0.0;
        let mut both = 0;
        for ((sample, found), expected) in samples.iter().zip(&verification.residuals).zip(expected) {
            match (found, expected) {
                (Some(found), Some(expected)) => {
                    both += 1;
                    worst = worst.max((found.residual_mm - expected).abs());
                }
                (None, None) => {}
                (found, expected) => {
                    // only where the top of the needle is grazed
                    let height = found.map(|found| found.residual_mm).or(expected).expect("one of them");
                    assert!(height > 0.9, "{sample:?} {found:?} {expected:?}");
                }
            }
        }
        assert!(both > samples.len() / 4, "{both}");
        assert!(worst < RESOLVED_MM, "{corner}: {worst}");
        assert!(verification.convergence.max_change.mm() < RESOLVED_MM, "{:?}", verification.convergence);
    }
}

#[test]
fn an_arc_cuts_its_groove_on_its_side_only() {
    let (radius, around) = (3.0, 12.0);
    let samples: Vec<_> = (0..72)
        .flat_map(|k| {
            let angle = f64::from(k) * PI / 36.0 + 0.01;
            (0..9).map(move |j| {
                let rho = around - 1.6 + 0.4 * f64::from(j);
                up(rho * angle.cos() + 1.0, rho * angle.sin() - 2.0, 0.0)
            })
        })
        .collect();
    let start = "G90 G21 G17\nG0 X13 Y-2 Z40 A0 C0\nG0 Z0\n";
    let full = verify(tool(radius, radius), &samples, &format!("{start}G2 X13 Y-2 I-12 J0\n"));
    let angle_of = |sample: &SurfacePoint| (sample.point_mm.y + 2.0).atan2(sample.point_mm.x - 1.0);
    let groove = |sample: &SurfacePoint| {
        let rho = (sample.point_mm.x - 1.0).hypot(sample.point_mm.y + 2.0);
        radius - (radius * radius - (rho - around).powi(2)).sqrt()
    };
    for (sample, residual_mm) in samples.iter().zip(residuals_mm(&full)) {
        assert!((residual_mm - groove(sample)).abs() < RESOLVED_MM, "{sample:?} {residual_mm}");
    }
    for (text, is_upper) in [
        ("G3 X-11 Y-2 I-12 J0\n", true),
        ("G2 X-11 Y-2 I-12 J0\n", false),
        ("G3 X-11 Y-2 R12.\n", true),
        ("G90.1\nG2 X-11 Y-2 I1 J-2\n", false),
        ("G91\nG3 X-24 Y0 I-12 J0\n", true),
        ("G2\nX-11 Y-2 I-12\n", false),
    ] {
        let half = verify(tool(radius, radius), &samples, &format!("{start}{text}"));
        assert_eq!(half.motions.arcs, 1, "{text}");
        for (sample, residual) in samples.iter().zip(&half.residuals) {
            let angle = angle_of(sample);
            // clear of the ball at the ends
            if angle.abs() < 0.35 || angle.abs() > PI - 0.35 {
                continue;
            }
            let expected = ((angle > 0.0) == is_upper).then(|| groove(sample));
            match (residual, expected) {
                (Some(found), Some(expected)) => assert!((found.residual_mm - expected).abs() < RESOLVED_MM),
                (None, None) => {}
                other => panic!("{text} {angle}: {other:?}"),
            }
        }
    }
}

#[test]
fn a_helix_goes_down_as_it_turns() {
    let samples: Vec<_> = (5..67)
        .map(|k| {
            let angle = f64::from(k) * PI / 36.0;
            // the bottom of the ball on a helix lies across its slope
            let (slope, around) = (-1.0 / PI, 10.0_f64);
            let z = slope * angle;
            let along = Vec3::new(-around * angle.sin(), around * angle.cos(), slope).normalize();
            let normal = (Vec3::z() - along * along.z).normalize();
            let centre = Vec3::new(around * angle.cos(), around * angle.sin(), z + 4.0);
            SurfacePoint { point_mm: centre - normal * 4.0, normal }
        })
        .collect();
    let text = "G90 G21 G17\nG0 X10 Y0 Z40 A0 C0\nG0 Z0\nG3 X10 Y0 Z-2 I-10 J0\n";
    let verification = verify(tool(4.0, 4.0), &samples, text);
    for residual_mm in residuals_mm(&verification) {
        assert!(residual_mm.abs() < RESOLVED_MM, "{residual_mm}");
    }
}

#[test]
fn what_cannot_be_followed_is_left_out_and_counted() {
    let samples = [up(0.0, 0.0, 0.0)];
    let text =
        "G90 G21 G17\nG0 X0 Y0 Z5 A0 C0\nG1 Z0\nG2 X5 Y5 R2\nG1 X1 Y0 Z5\nG2 X2 Y0 I0.5 A3\nG1 X0\nG28 Z0\n";
    let verification = verify(tool(5.0, 5.0), &samples, text);
    let found: Vec<_> =
        verification.left_out.iter().map(|kind| (kind.reason.name(), kind.count, kind.first_line)).collect();
    assert_eq!(found, [("position_unknown", 1, 2), ("arc", 2, 4), ("not_followed", 1, 8)]);
    // of the arcs the first one's reason
    let short =
        "an arc whose path is not known: its radius of 2.0000 mm is 1.5355 mm less than half its chord";
    assert_eq!(verification.left_out[1].reason.text(), short);
    assert_eq!(verification.motions.total(), 3);
    let nothing =
        run(&VerificationParameters::new(tool(5.0, 5.0), at_zero()), &samples, "G90 G21\nG1 X5\nM30\n");
    assert!(matches!(nothing, Err(Fault::NothingToCut { left_out: 1, .. })), "{nothing:?}");
}

#[test]
fn an_arc_that_is_left_out_says_why() {
    let samples = [up(0.0, 0.0, 0.0)];
    for (arc, why) in [
        ("G2 X2 Y0 I1 J0 A3", "rotary axes turn along it, by 3.000 and 0.000 deg"),
        ("G2 X2 Y0 I1 J0 P2", "it has the word P2, for several turns"),
        ("G2 X2 Y0", "it states neither its radius nor its whole centre"),
        ("G90.1\nG2 X2 Y0 I1", "it states neither its radius nor its whole centre"),
        ("G2 X2 Y0 I1 R1", "it states both a centre and a radius of 1.0000 mm"),
        ("G2 X0 Y0 R4", "it ends where it starts and states only its radius of 4.0000 mm"),
        ("G2 X2 Y0 I1.25", "its end misses the circle of 1.2500 mm about its centre by -0.5000 mm"),
        ("G2 X2 Y0 I0 J0", "its centre is its start or its end"),
    ] {
        let text = format!("G90 G21 G17\nG0 X0 Y0 Z5 A0 C0\nG1 Z0\n{arc}\n");
        let verification = verify(tool(5.0, 5.0), &samples, &text);
        let last = verification.left_out.last().expect("left out");
        assert_eq!((last.reason.name(), last.count), ("arc", 1), "{arc}");
        assert_eq!(last.reason.text(), format!("an arc whose path is not known: {why}"), "{arc}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_at_once() {
    let mut parameters = VerificationParameters::new(tool(5.0, 5.0), at_zero());
    parameters.cutting_length = Some(Length::from_mm(4.0));
    parameters.stock = Length::from_mm(0.0);
    parameters.resolution = Length::from_mm(f64::NAN);
    parameters.limit = Length::from_mm(1e9);
    let odd = [
        up(0.0, 0.0, 0.0),
        up(f64::NAN, 0.0, 0.0),
        SurfacePoint { point_mm: Vec3::zeros(), normal: Vec3::zeros() },
    ];
    let Err(Fault::Verification(faults)) = run(&parameters, &odd, "G0 X0\n") else { panic!("accepted") };
    assert_eq!(faults.len(), 5, "{faults:?}");
    assert!(faults.contains(&VerificationFault::Samples { first: 1, count: 2 }));
    let none = run(&VerificationParameters::new(tool(5.0, 5.0), at_zero()), &[], "G0 X0\n");
    assert!(matches!(none, Err(Fault::Verification(faults)) if faults == [VerificationFault::NoSamples]));
}
