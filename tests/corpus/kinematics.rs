//! Programs posted by others as answers of the inverse kinematics (programs/INDEX.md, "Cross-checks" 1 and 2).

use std::ops::ControlFlow;

use trunnion::geometry::{Vec3, angle_between};
use trunnion::kinematics::{Kinematics, PathOptions, Setup, ToolPose, WarningKind};
use trunnion::machine::{Machine, Preset};
use trunnion::units::MM_PER_INCH;

use crate::shared_file;

const GO_ON: &dyn Fn() -> ControlFlow<()> = &|| ControlFlow::Continue(());

/// The value after `letter` in a block without comments, if there.
fn word(block: &str, letter: char) -> Option<f64> {
    let rest = &block[block.find(letter)? + 1..];
    let end = rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

/// Half a unit of the third decimal [deg]: how far a posted rotary word is from the true one.
const ROUNDED_DEG: f64 = 0.0005 + 1e-9;

#[test]
fn a_printed_part_is_posted_as_the_inverse_of_its_way_points() {
    /// Half a unit of the third decimal in X Y Z, and 0.0005° of two axes at up to 50 mm [mm].
    const LINEAR_MM: f64 = 0.0013;
    let (Some(program), Some(points)) = (
        shared_file("programs/5axis/zhangty_simple_curve_bc_machine.gcode"),
        shared_file("programs/5axis/zhangty_simple_curve_waypoints.txt"),
    ) else {
        return;
    };
    let mut parts = Preset::by_id("bc-table").unwrap().parts();
    for axis in &mut parts.rotary_axes {
        axis.reversed = true;
        axis.travel_deg = None;
    }
    let machine = Machine::new(parts).unwrap();
    let kinematics = Kinematics::new(&machine, &Setup::default());
    let posted: Vec<[f64; 5]> = std::fs::read_to_string(program)
        .unwrap()
        .lines()
        .filter(|line| line.starts_with("G1 X") && line.contains('E'))
        .filter_map(|line| {
            let mut words = [0.0; 5];
            for (value, letter) in words.iter_mut().zip("XYZBC".chars()) {
                *value = word(line, letter)?;
            }
            Some(words)
        })
        .collect();
    let points: Vec<Vec3> = std::fs::read_to_string(points)
        .unwrap()
        .lines()
        .map(|line| {
            let mut numbers = line.split_whitespace().map(|number| number.parse::<f64>().unwrap());
            Vec3::from_fn(|_, _| numbers.next().unwrap())
        })
        .collect();
    assert_eq!((posted.len(), points.len()), (41_494, 41_494));
    let poses: Vec<ToolPose> = posted
        .iter()
        .zip(&points)
        .map(|(&[.., b, c], point)| {
            let ((sb, cb), (sc, cc)) = (b.to_radians().sin_cos(), c.to_radians().sin_cos());
            // the part stands 40.5 mm above the table's centre
            ToolPose { tip_mm: point + Vec3::new(0.0, 0.0, 40.5), axis: Vec3::new(-cc * sb, sb * sc, cb) }
        })
        .collect();
    let mut worst_mm: f64 = 0.0;
    for (n, (pose, &[x, y, z, b, c])) in poses.iter().zip(&posted).enumerate() {
        let same = |word: f64, posted: f64| {
            let turns = (word - posted) / 360.0;
            (turns - turns.round()).abs() * 360.0 <= ROUNDED_DEG
        };
        let candidates = kinematics.candidates(n, pose, c).unwrap();
        let found = candidates.iter().find(|candidate| {
            let [first, second] = candidate.joints.rotary_rad;
            same(machine.rotary_axes()[0].word_deg(first), b)
                && same(machine.rotary_axes()[1].word_deg(second), c)
        });
        let found = found.unwrap_or_else(|| panic!("block {n}: B{b} C{c} is not among {candidates:?}"));
        worst_mm = worst_mm.max((found.joints.linear_mm - Vec3::new(x, y, z)).amax());
    }
    println!("worst linear word {worst_mm:.5} mm");
    assert!(worst_mm <= LINEAR_MM);
    // the path through all poses: same tips and axes, never more expensive than what was posted
    let options = PathOptions { start_words_deg: Some([0.0, 0.0]), ..PathOptions::default() };
    let path = kinematics.path(&poses, &options, GO_ON).unwrap();
    let (mut posted_cost, mut path_cost) = ((0, 0.0), (0, 0.0));
    let add = |cost: &mut (usize, f64), steps: [f64; 2]| {
        cost.0 += usize::from(steps[0].abs() > 120.0 || steps[1].abs() > 120.0);
        cost.1 += steps[0].abs() + steps[1].abs();
    };
    let mut previous = ([0.0; 2], [0.0; 2]);
    let mut equal = 0;
    for (n, &[.., b, c]) in posted.iter().enumerate() {
        let rotary = path.get(n).unwrap().rotary_rad;
        let words =
            [machine.rotary_axes()[0].word_deg(rotary[0]), machine.rotary_axes()[1].word_deg(rotary[1])];
        add(&mut posted_cost, [b - previous.0[0], c - previous.0[1]]);
        add(&mut path_cost, [words[0] - previous.1[0], words[1] - previous.1[1]]);
        equal += usize::from((words[0] - b).abs() <= ROUNDED_DEG && (words[1] - c).abs() <= ROUNDED_DEG);
        previous = ([b, c], words);
    }
    println!("posted {posted_cost:?}, path {path_cost:?}, {equal} blocks with the same words");
    assert!(path_cost.0 <= posted_cost.0);
    let holds = path.warnings.iter().filter(|warning| warning.kind == WarningKind::PoleHold).count();
    assert_eq!(holds, posted.iter().filter(|words| words[3].abs() <= 0.01).count());
}

#[test]
fn one_operation_posted_for_two_machines_is_one_inverse_of_the_other() {
    /// Three decimals in B and C on both machines: the axes differ by no more [deg].
    const AXIS_DEG: f64 = 0.001;
    /// Four decimals of an inch on both sides, and 0.001° at up to 2 in [in].
    const LINEAR_IN: f64 = 1.5e-4;
    /// Where the part stands on the second machine's table [in].
    const CENTRE_IN: Vec3 = Vec3::new(0.984_25, 0.984_25, 1.9685);
    let (Some(dmu), Some(mori)) = (
        shared_file("programs/5axis/nx_dmu70evo_840d_bc_traori.mpf"),
        shared_file("programs/5axis/nx_mori_nmv5000_bc_g43.4.txt"),
    ) else {
        return;
    };
    let rows = |path, skip: usize, count: usize, mut modal: [f64; 5]| -> Vec<[f64; 5]> {
        String::from_utf8_lossy(&std::fs::read(path).unwrap())
            .lines()
            .skip(skip)
            .take(count)
            .map(|line| {
                for (value, letter) in modal.iter_mut().zip("XYZBC".chars()) {
                    *value = word(line, letter).unwrap_or(*value);
                }
                modal
            })
            .collect()
    };
    let tips = rows(dmu, 479, 291, [0.9843, 0.9843, 1.5804, 0.0, 185.644]);
    let posted = rows(mori, 438, 291, [0.0, 0.0, -0.3881, 0.0, 315.0]);
    let nutating = Machine::new(Preset::by_id("nutating-b-head-c-table").unwrap().parts()).unwrap();
    let nutating = Kinematics::new(&nutating, &Setup::default());
    let table = {
        let mut parts = Preset::by_id("bc-table").unwrap().parts();
        parts.rotary_axes[0].travel_deg = None;
        Machine::new(parts).unwrap()
    };
    let kinematics = Kinematics::new(&table, &Setup::default());
    let poses: Vec<ToolPose> = tips
        .iter()
        .map(|&[x, y, z, b, c]| ToolPose {
            tip_mm: (Vec3::new(x, y, z) - CENTRE_IN) * MM_PER_INCH,
            axis: nutating.axis([b.to_radians(), c.to_radians()]),
        })
        .collect();
    let options = PathOptions { start_words_deg: Some([0.0, 315.0]), ..PathOptions::default() };
    let path = kinematics.path(&poses, &options, GO_ON).unwrap();
    let (mut worst_axis_deg, mut worst_in): (f64, f64) = (0.0, 0.0);
    for (n, (pose, &[x, y, z, b, c])) in poses.iter().zip(&posted).enumerate() {
        let joints = path.get(n).unwrap();
        let words = joints.rotary_rad.map(f64::to_degrees);
        let posted_axis = kinematics.axis([b.to_radians(), c.to_radians()]);
        worst_axis_deg = worst_axis_deg.max(angle_between(posted_axis, pose.axis).to_degrees());
        // the same branch and the same turn; near the pole C is as uncertain as the axis over sin B
        assert!((words[0] - b).abs() <= AXIS_DEG, "row {n}: {words:?}, posted B{b} C{c}");
        let across = (words[1] - c).abs() * b.to_radians().sin().abs();
        assert!(across <= AXIS_DEG && (words[1] - c).abs() < 1.0, "row {n}: {words:?}, posted B{b} C{c}");
        worst_in = worst_in.max((joints.linear_mm / MM_PER_INCH - Vec3::new(x, y, z)).amax());
    }
    println!("worst axis {worst_axis_deg:.5}°, worst linear word {worst_in:.6} in");
    assert!(worst_axis_deg <= AXIS_DEG && worst_in <= LINEAR_IN);
}
