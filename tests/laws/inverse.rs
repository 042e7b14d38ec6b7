//! The exact candidates against the forward chain.

use proptest::prelude::*;
use trunnion::geometry::{Vec3, angle_about, angle_between};
use trunnion::kinematics::{InverseError, Joints, Kinematics, Setup, ToolPose};
use trunnion::machine::Machine;

use crate::machines::{any_machine, pose, preset_machine, setup, vector};

/// The tip comes back to this [mm].
const TIP_MM: f64 = 1e-9;
/// The axis comes back to this [rad].
const AXIS: f64 = 1e-12;

/// Checks every candidate and returns how many there are.
fn check(kinematics: &Kinematics, pose: &ToolPose) -> Result<usize, TestCaseError> {
    match kinematics.candidates(0, pose, 0.0) {
        Ok(candidates) => {
            for candidate in &candidates {
                let back = kinematics.forward(&candidate.joints);
                let residual = candidate.axis_residual_rad;
                let axis_miss = angle_between(back.axis, pose.axis);
                prop_assert!((back.tip_mm - pose.tip_mm).norm() <= TIP_MM, "{candidate:?}");
                prop_assert!((axis_miss - residual).abs() <= AXIS, "{axis_miss:e} {candidate:?}");
            }
            Ok(candidates.len())
        }
        Err(InverseError::OutOfReach { tilt_deg, min_deg, max_deg, .. }) => {
            prop_assert!(tilt_deg < min_deg || tilt_deg > max_deg);
            Ok(0)
        }
        Err(InverseError::OutOfTravel { commanded, min, max, .. }) => {
            prop_assert!(commanded < min || commanded > max);
            Ok(0)
        }
        Err(other) => Err(TestCaseError::fail(format!("{other}"))),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_candidate_of_a_preset_leads_back_to_its_pose(
        machine in preset_machine(true), setup in setup(), pose in pose(),
    ) {
        check(&Kinematics::new(&machine, &setup), &pose)?;
    }

    #[test]
    fn every_candidate_of_any_two_axes_leads_back_to_its_pose(
        machine in any_machine(), setup in setup(), pose in pose(),
    ) {
        check(&Kinematics::new(&machine, &setup), &pose)?;
    }

    #[test]
    fn joints_are_among_the_candidates_of_their_pose(
        machine in any_machine(), setup in setup(), linear in vector(300.0), rotary in [-3.1..3.1, -3.1..3.1],
    ) {
        let kinematics = Kinematics::new(&machine, &setup);
        let joints = Joints { linear_mm: linear, rotary_rad: rotary };
        let candidates = kinematics.candidates(0, &kinematics.forward(&joints), 0.0);
        let candidates = candidates.map_err(|error| TestCaseError::fail(format!("{error}")))?;
        prop_assume!(candidates.iter().all(|candidate| candidate.conditioning > 1e-3));
        let found = candidates.iter().any(|candidate| {
            (0..2).all(|k| {
                let step = candidate.joints.rotary_rad[k] - rotary[k];
                step.sin().abs() < 1e-10 && step.cos() > 0.0
            }) && (candidate.joints.linear_mm - linear).norm() < 1e-7
        });
        prop_assert!(found, "{candidates:?}");
    }

    #[test]
    fn poses_at_the_pole_and_at_the_reach_limit_are_solved(
        machine in any_machine(), setup in setup(), tip in vector(300.0), u_angle in -3.1..3.1, limit in 0..2, sign in 0..3,
    ) {
        // at the limit the axis lies in the plane of u and v; 1e-10 rad to either side still counts as on it
        let kinematics = Kinematics::new(&machine, &setup);
        let [u, v] = machine.workpiece_to_tool();
        let lines = machine.screws(true);
        let middle = angle_about(
            lines[v].direction, Machine::TOOL_AXIS, lines[u].direction,
        );
        let mut rotary = [0.0; 2];
        rotary[u] = u_angle;
        rotary[v] = middle + f64::from(limit) * std::f64::consts::PI;
        let axis = kinematics.axis(rotary);
        let across = lines[u].direction.cross(&axis);
        prop_assume!(across.norm() > 1e-3);
        let nudge = f64::from(sign - 1) * 1e-10;
        let axis = axis + across.normalize().cross(&axis) * nudge;
        let pose = ToolPose { tip_mm: tip, axis };
        let candidates = kinematics.candidates(0, &pose, 0.0).map_err(|e| TestCaseError::fail(format!("{e}")))?;
        for candidate in &candidates {
            let back = kinematics.forward(&candidate.joints);
            prop_assert!((back.tip_mm - tip).norm() <= TIP_MM);
            let allowed = if sign == 1 { AXIS } else { 1.001e-10 };
            prop_assert!((back.axis - axis.normalize()).norm() <= allowed);
        }
        prop_assert!(!candidates.is_empty());
    }

    #[test]
    fn poses_near_and_at_the_pole_are_solved(
        machine in preset_machine(true), setup in setup(), tip in vector(300.0), azimuth in -3.1_f64..3.1, decade in -18.0_f64..-1.0,
        down in any::<bool>(),
    ) {
        let kinematics = Kinematics::new(&machine, &setup);
        let u = machine.screws(true)[machine.workpiece_to_tool()[0]].direction;
        let side = u.cross(&Vec3::new(0.3, 0.4, 0.5)).normalize();
        let side = side * azimuth.cos() + u.cross(&side) * azimuth.sin();
        let tilt = 10_f64.powf(decade);
        let axis = u * tilt.cos() + side * tilt.sin();
        check(&kinematics, &ToolPose { tip_mm: tip, axis: if down { -axis } else { axis } })?;
    }

    #[test]
    fn without_errors_the_calibrated_machine_is_the_nominal_one(
        machine in preset_machine(false), setup in setup(), pose in pose(),
    ) {
        let with = Kinematics::new(&machine, &setup);
        let without = Kinematics::new(&machine, &Setup { apply_errors: false, ..setup });
        let (with, without) = (with.candidates(0, &pose, 0.0), without.candidates(0, &pose, 0.0));
        match (with, without) {
            (Ok(with), Ok(without)) => {
                prop_assert_eq!(with.len(), without.len());
                for (a, b) in with.iter().zip(&without) {
                    prop_assert!((a.joints.linear_mm - b.joints.linear_mm).norm() <= 1e-7);
                }
            }
            (with, without) => prop_assert_eq!(with.is_ok(), without.is_ok()),
        }
    }

    #[test]
    fn a_reversed_axis_changes_the_word_and_nothing_else(machine in preset_machine(true), degrees in -1e4..1e4) {
        for axis in machine.rotary_axes() {
            let sense = if axis.reversed { -1.0 } else { 1.0 };
            prop_assert!((axis.angle_rad(degrees).to_degrees() * sense - degrees).abs() <= 1e-11);
        }
    }
}
