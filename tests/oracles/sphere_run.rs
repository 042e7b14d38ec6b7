//! Runs of probed spheres on both axes, against the machine of chained bodies.

use trunnion::calibration::ErrorParameter;
use trunnion::calibration::rotary_sphere::{AxisCenters, Center, identify_spheres};
use trunnion::geometry::Vec3;
use trunnion::machine::{Machine, Preset};

use crate::bar_machine::{AxisErrors, BarMachine, Seeded};

/// P4's eight errors, in mm and rad.
const ERRORS: AxisErrors = [[0.012, -0.021, 0.034, 41e-6, -63e-6, 29e-6], [0.0, 0.015, 0.0, 0.0, 27e-6, 0.0]];

fn machine() -> Machine {
    let mut parts = Preset::by_id("ac-table").expect("a preset").parts();
    parts.rotary_axes[0].point_mm = Vec3::new(1.0, -2.0, -50.0);
    parts.rotary_axes[1].point_mm = Vec3::new(2.0, 0.3, -20.0);
    Machine::new(parts).expect("a machine")
}

fn probed(machine: &Machine, seeded: &mut Seeded, noise_mm: f64) -> Vec<AxisCenters> {
    let bodies = BarMachine::new(machine, 0.0);
    [(0, 11, -75.0, 15.0), (1, 12, 0.0, 30.0)]
        .into_iter()
        .map(|(axis, count, from_deg, step_deg)| {
            let centers = (0..count)
                .map(|k| {
                    let angle_rad = (from_deg + step_deg * f64::from(k)).to_radians();
                    let mut angles = [0.0; 2];
                    angles[axis] = angle_rad;
                    let mut noise = || seeded.normal() * noise_mm;
                    let noise = Vec3::new(noise(), noise(), noise());
                    let center_mm = bodies.on_table(&ERRORS, angles, [120.0, 30.0, 90.0]) + noise;
                    Center { ball: 0, angle_rad: Some(angle_rad), center_mm }
                })
                .collect();
            AxisCenters { axis, centers }
        })
        .collect()
}

#[test]
fn both_axes_give_the_errors_back_without_noise() {
    /// Rounding of coordinates of 100 mm, over arms of as much [mm, rad].
    const RECOVERED: f64 = 1e-10;
    let machine = machine();
    let found = identify_spheres(&machine, &probed(&machine, &mut Seeded(1), 0.0)).expect("two axes");
    for parameter in ErrorParameter::every() {
        let off = parameter.value(&found.errors) - ERRORS[parameter.axis][parameter.component];
        assert!(off.abs() < RECOVERED, "{parameter:?}: {off:e}");
    }
    assert_eq!(found.parameters.len(), 8);
}

#[test]
fn the_truth_lies_where_the_covariance_of_both_lines_says() {
    const DRAWS: u32 = 600;
    /// Four standard deviations of a share of 600 draws at 68.3 %; some thirty degrees of freedom take a little off.
    const ONE_SIGMA: std::ops::Range<f64> = 0.60..0.76;
    let machine = machine();
    let mut seeded = Seeded(17);
    let mut within = vec![0_u32; 8];
    for _ in 0..DRAWS {
        let found = identify_spheres(&machine, &probed(&machine, &mut seeded, 0.002)).expect("two axes");
        let covariance = found.covariance.expect("many centres");
        for (index, parameter) in found.parameters.iter().enumerate() {
            let off = parameter.value(&found.errors) - ERRORS[parameter.axis][parameter.component];
            within[index] += u32::from(off.abs() <= covariance[(index, index)].sqrt());
        }
    }
    for (index, within) in within.into_iter().enumerate() {
        let share = f64::from(within) / f64::from(DRAWS);
        assert!(ONE_SIGMA.contains(&share), "component {index}: {share} within one sigma");
    }
}
