//! Published kinematics of the AC trunnion, and a second method for the inverse.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use proptest::prelude::*;
use trunnion::geometry::{Vec3, angle_about, angle_between};
use trunnion::kinematics::{Joints, Kinematics, Setup, ToolPose};
use trunnion::machine::{Machine, PRESETS, Preset};

/// Nine decimals are printed [mm].
const PRINTED_MM: f64 = 6e-10;
/// Nine decimals of a direction.
const PRINTED_AXIS: f64 = 6e-10;
/// Rounding of a few dozen operations on numbers of some hundred [mm].
const ROUNDING_MM: f64 = 1e-11;
/// The same on unit vectors.
const ROUNDING: f64 = 1e-14;

fn ac_table(p_a_mm: [f64; 3], p_c_mm: [f64; 3]) -> Machine {
    let mut parts = Preset::by_id("ac-table").unwrap().parts();
    parts.rotary_axes[0].point_mm = Vec3::from(p_a_mm);
    parts.rotary_axes[1].point_mm = Vec3::from(p_c_mm);
    parts.rotary_axes[0].travel_deg = None;
    Machine::new(parts).unwrap()
}

#[test]
fn the_table_of_values_is_met_both_ways() {
    let setup = Setup { work_offset_mm: Vec3::new(70.0, -40.0, 95.0), ..Setup::default() };
    let words = [10.0, 20.0, 30.0, 35.0, -50.0];
    for (p_a, p_c, tip, other) in [
        (
            [0.0; 3],
            [0.0; 3],
            [-86.050_258_878, -77.900_349_452, -4.077_523_191],
            [-150.0, 60.0, 30.0, -35.0, 130.0],
        ),
        (
            [1.0, 2.0, -3.0],
            [1.5, 2.2, -30.0],
            [-88.240_818_050, -76.838_985_357, -5.767_219_931],
            [-147.0, 64.327_660_818, 30.229_430_575, -35.0, 130.0],
        ),
    ] {
        let kinematics = Kinematics::new(&ac_table(p_a, p_c), &setup);
        let joints = Joints {
            linear_mm: Vec3::new(words[0], words[1], words[2]),
            rotary_rad: [words[3].to_radians(), words[4].to_radians()],
        };
        let pose = kinematics.forward(&joints);
        let axis = Vec3::new(-0.439_385_042, -0.368_687_826, 0.819_152_044);
        assert!((pose.tip_mm - Vec3::from(tip)).amax() <= PRINTED_MM, "{}", pose.tip_mm);
        assert!((pose.axis - axis).amax() <= PRINTED_AXIS);
        let candidates = kinematics.candidates(0, &pose, 0.0).unwrap();
        assert_eq!(candidates.len(), 2);
        for expected in [words, other] {
            let found = candidates.iter().any(|candidate| {
                let degrees = candidate.joints.rotary_rad.map(f64::to_degrees);
                (candidate.joints.linear_mm - Vec3::new(expected[0], expected[1], expected[2])).amax()
                    <= PRINTED_MM
                    && (degrees[0] - expected[3]).abs() < 1e-12
                    && (degrees[1] - expected[4]).abs() < 1e-12
            });
            assert!(found, "{expected:?} not in {candidates:?}");
        }
        for candidate in candidates {
            // |sin A| on an orthogonal AC machine
            assert!((candidate.conditioning - 35.0_f64.to_radians().sin()).abs() < ROUNDING);
        }
    }
}

proptest! {
    /// P0 eq. (1), the X Y Z rows of (2) and (4), and (3) as it should be: A = ±atan2(hypot(I, J), K),
    /// C = atan2(±I, ∓J).
    #[test]
    fn the_published_trunnion_is_the_chain_with_both_axes_through_one_point(
        q in [-300.0..300.0_f64, -300.0..300.0, -300.0..300.0], a in -3.1..3.1_f64, c in -3.1..3.1_f64,
        x_w in -100.0..100.0_f64, y_w in -100.0..100.0_f64, d in 0.0..200.0_f64, m in 0.0..200.0_f64,
    ) {
        let kinematics = Kinematics::new(&ac_table([-x_w, -y_w, -d], [-x_w, -y_w, -d]), &Setup::default());
        let [x, y, z] = q;
        let pose = kinematics.forward(&Joints { linear_mm: Vec3::new(x, y, z + m), rotary_rad: [a, c] });
        let ((sa, ca), (sc, cc)) = (a.sin_cos(), c.sin_cos());
        prop_assert!((pose.axis - Vec3::new(sa * sc, -sa * cc, ca)).amax() <= ROUNDING);
        let tip = Vec3::new(
            (x + x_w) * cc - (y + y_w) * ca * sc + (z + d + m) * sa * sc - x_w,
            (x + x_w) * sc + (y + y_w) * ca * cc - (z + d + m) * sa * cc - y_w,
            (y + y_w) * sa + (z + d + m) * ca - d,
        );
        prop_assert!((pose.tip_mm - tip).amax() <= ROUNDING_MM);
        let [px, py, pz]: [f64; 3] = tip.into();
        let linear = Vec3::new(
            (px + x_w) * cc + (py + y_w) * sc - x_w,
            -(px + x_w) * ca * sc + (pz + d) * sa + (py + y_w) * ca * cc - y_w,
            (px + x_w) * sa * sc + (pz + d) * ca - (py + y_w) * cc * sa - d - m,
        );
        let back = kinematics.linear_mm(tip, [a, c]) - Vec3::new(0.0, 0.0, m);
        prop_assert!((back - linear).amax() <= ROUNDING_MM);
        prop_assume!(sa.abs() > 1e-3);
        let (i, j, k) = (pose.axis.x, pose.axis.y, pose.axis.z);
        let found = kinematics.candidates(0, &pose, 0.0).unwrap();
        for sign in [1.0, -1.0] {
            let expected = [sign * i.hypot(j).atan2(k), (sign * i).atan2(-sign * j)];
            let there = found.iter().any(|candidate| {
                (0..2).all(|n| (candidate.joints.rotary_rad[n] - expected[n]).sin().abs() < 1e-10)
            });
            prop_assert!(there, "{expected:?} {found:?}");
        }
    }

    /// Paden–Kahan subproblem 2 as the textbook has it: intersect two cones, then two angles.
    #[test]
    fn the_textbook_form_finds_the_same_angles(
        preset in 0..PRESETS.len(), axis in [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64],
    ) {
        /// The textbook form loses half the digits near the pole and the reach limit; away from them none.
        const ANGLE: f64 = 1e-9;
        let machine = Machine::new(PRESETS[preset].parts()).unwrap();
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let axis = Vec3::from(axis);
        prop_assume!(axis.norm() > 0.1);
        let t = axis.normalize();
        let order = machine.workpiece_to_tool();
        let lines = machine.screws(true);
        let (u, v, t0) = (lines[order[0]].direction, lines[order[1]].direction, Machine::TOOL_AXIS);
        let uv = u.dot(&v);
        let alpha = (uv * v.dot(&t0) - u.dot(&t)) / (uv * uv - 1.0);
        let beta = (uv * u.dot(&t) - v.dot(&t0)) / (uv * uv - 1.0);
        let gamma2 = (1.0 - alpha * alpha - beta * beta - 2.0 * alpha * beta * uv) / u.cross(&v).norm_squared();
        let found = kinematics.candidates(0, &ToolPose { tip_mm: Vec3::zeros(), axis }, 0.0);
        if gamma2 < -1e-6 {
            prop_assert!(found.is_err());
        }
        prop_assume!(gamma2 > 1e-4 && u.cross(&t).norm() > 1e-3);
        for gamma in [gamma2.sqrt(), -gamma2.sqrt()] {
            // the direction in between: exp(v) t0 = c = exp(−u) t
            let between = u * alpha + v * beta + u.cross(&v) * gamma;
            let mut expected = [0.0; 2];
            expected[order[1]] = angle_about(v, t0, between);
            expected[order[0]] = angle_about(u, between, t);
            prop_assert!(angle_between(kinematics.axis(expected), t) < ANGLE);
            let within = (0..2).all(|n| machine.rotary_axes()[n].travel_deg.is_none_or(|travel| {
                travel.contains(expected[n].to_degrees(), -1e-6)
            }));
            let there = found.iter().flatten().any(|candidate| {
                (0..2).all(|n| {
                    let step = candidate.joints.rotary_rad[n] - expected[n];
                    step.sin().abs() < ANGLE && step.cos() > 0.0
                })
            });
            prop_assert!(there || !within, "{expected:?} {found:?}");
        }
    }
}

/// Where the C axis is tilted by 50 µrad, the tool trammed at zero makes the pole go round in a circle of twice that:
/// the largest correction of C is arcsin(2·50e-6/sin A), 0.33° at a lean of 1°.
#[test]
fn rotary_words_next_to_nominal_ones_differ_as_far_as_a_tilt_of_50_urad_demands() {
    use trunnion::machine::{LocationError, MachineParts, RotaryAxis};
    let parts = Preset::by_id("ac-table").expect("a preset").parts();
    let tilted = LocationError { translation_mm: Vec3::zeros(), rotation_rad: Vec3::new(0.0, 5e-5, 0.0) };
    let [first, second] = [0, 1].map(|k| RotaryAxis { travel_deg: None, ..parts.rotary_axes[k].clone() });
    let machine = Machine::new(MachineParts {
        rotary_axes: vec![first, RotaryAxis { location_error: tilted, ..second }],
        ..parts
    })
    .expect("a machine");
    let [meant, real] = [false, true]
        .map(|apply_errors| Kinematics::new(&machine, &Setup { apply_errors, ..Setup::default() }));
    for (lean_deg, largest_deg) in [(1.0, 0.33), (0.03, 11.01)] {
        let mut most = 0.0_f64;
        for c_deg in 0..360 {
            let words = [lean_deg, f64::from(c_deg)];
            let axis = meant.axis(words.map(f64::to_radians));
            let near = real.words_near(axis, words, 0.0).expect("within reach");
            assert!(!near.held && near.axis_residual_rad == 0.0);
            assert!(real.axis_miss_rad(axis, near.words_deg.map(f64::to_radians)) < 1e-12);
            most = most.max((near.words_deg[1] - words[1]).abs());
            // Inside the cone the word is held, and the axis misses by no more than its circle.
            let upright = meant.axis([0.005_f64.to_radians(), words[1].to_radians()]);
            let held = real.words_near(upright, [0.005, words[1]], 2.5).expect("within reach");
            assert!(held.held && (held.words_deg[1] - words[1] - 2.5).abs() < 1e-12);
            assert!(held.axis_residual_rad <= 1e-4 + 0.005_f64.to_radians() * 2.6_f64.to_radians());
        }
        assert!((most / largest_deg - 1.0).abs() < 0.02, "{lean_deg}: {most}");
    }
}
