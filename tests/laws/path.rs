//! Path selection against brute force and against itself.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;

use proptest::prelude::*;
use trunnion::geometry::{Vec3, angle_between};
use trunnion::kinematics::{
    COMPUTED_WORD_SLACK, InstructionSet, InverseError, Kinematics, Lanes, Path, PathOptions, PoseBlock,
    PoseLanes, PoseSource, Poses, Selection, Setup, ToolPose, WarningKind,
};
use trunnion::machine::{Machine, MachineParts, Preset, Travel};

use crate::machines::{direction, preset_machine, vector};

const GO_ON: &dyn Fn() -> ControlFlow<()> = &|| ControlFlow::Continue(());
/// Travels of two ways this close tie [deg].
const TIE_DEG: f64 = 3e-6;
/// Travels of two ways this close are the same but for rounding [deg]: clearly inside the tie of the choice.
const SAME_DEG: f64 = 1e-9;

fn parts_of(machine: &Machine) -> MachineParts {
    MachineParts {
        name: String::new(),
        rotary_axes: machine.rotary_axes().to_vec(),
        linear_travel_mm: *machine.linear_travel_mm(),
        squareness: *machine.squareness(),
        interpolation_period_s: machine.interpolation_period_s(),
    }
}

fn with_travels(machine: &Machine, travels: [Option<Travel>; 2]) -> Machine {
    let mut parts = parts_of(machine);
    for (axis, travel) in parts.rotary_axes.iter_mut().zip(travels) {
        axis.travel_deg = travel;
    }
    Machine::new(parts).unwrap()
}

/// The same machine, with this travel of X to both sides of zero \[mm\].
fn with_x_up_to(machine: &Machine, max: Option<f64>) -> Machine {
    let mut parts = parts_of(machine);
    parts.linear_travel_mm = [max.map(|max| Travel { min: -max, max }), None, None];
    Machine::new(parts).unwrap()
}

/// Ends of the travel of X among which paths of these tests are in reach, partly in reach and out of reach \[mm\].
fn x_ends() -> impl Strategy<Value = Option<f64>> {
    prop::option::of(20.0..400.0_f64)
}

fn travel() -> impl Strategy<Value = Option<Travel>> {
    prop_oneof![
        Just(None),
        Just(Some(Travel { min: -120.0, max: 120.0 })),
        Just(Some(Travel { min: -360.0, max: 360.0 })),
        Just(Some(Travel { min: -190.0, max: 250.0 })),
        Just(Some(Travel { min: 20.0, max: 500.0 })),
    ]
}

/// A wandering path: steps of a size that now and then asks for a rewind.
fn poses(count: usize) -> impl Strategy<Value = Vec<ToolPose>> {
    (direction(), prop::collection::vec((vector(50.0), direction()), count), 0.05..1.0_f64).prop_map(
        |(start, steps, size)| {
            let mut axis = start;
            steps
                .into_iter()
                .map(|(tip_mm, step)| {
                    axis = (axis + step * size).try_normalize(1e-6).unwrap_or(start);
                    ToolPose { tip_mm, axis }
                })
                .collect()
        },
    )
}

/// Some blocks of a finishing pass: tilt and azimuth swing about any middle, at any speed.
fn smooth_poses() -> impl Strategy<Value = Vec<ToolPose>> {
    let swing = || (-1.6..1.6_f64, 0.0..1.5_f64, -2.0..2.0_f64);
    (500..1500_usize, prop_oneof![Just(1e-4), Just(1e-3), Just(1e-2)], swing(), swing()).prop_map(
        |(count, speed, tilt, azimuth)| {
            let poses = (0..count).map(|n| {
                let s = n as f64 * speed;
                let at = |(middle, width, rate): (f64, f64, f64)| middle + width * (rate * s).sin();
                let ((sin, cos), (sin_azimuth, cos_azimuth)) =
                    (at(tilt).sin_cos(), (at(azimuth) + s).sin_cos());
                let axis = Vec3::new(sin * cos_azimuth, sin * sin_azimuth, cos);
                ToolPose { tip_mm: Vec3::new(80.0 * s.cos(), 60.0 * s.sin(), 0.01 * s), axis }
            });
            poses.collect()
        },
    )
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Cost {
    rewinds: usize,
    travel: f64,
    sum: f64,
}

/// The cost of NC words along a path.
fn cost(words: &[[f64; 2]], start: Option<[f64; 2]>) -> Cost {
    let mut total = Cost { rewinds: 0, travel: 0.0, sum: 0.0 };
    let mut previous = start;
    for word in words {
        if let Some(p) = previous {
            let steps = [(word[0] - p[0]).abs(), (word[1] - p[1]).abs()];
            total.rewinds += usize::from(steps[0] > 120.0 || steps[1] > 120.0);
            total.travel += steps[0] + steps[1];
        }
        total.sum += word[0].abs() + word[1].abs();
        previous = Some(*word);
    }
    total
}

fn words_of(machine: &Machine, path: &Path, count: usize) -> Vec<[f64; 2]> {
    (0..count)
        .map(|n| {
            let rotary = path.get(n).unwrap().rotary_rad;
            [machine.rotary_axes()[0].word_deg(rotary[0]), machine.rotary_axes()[1].word_deg(rotary[1])]
        })
        .collect()
}

/// All ways through the candidates, the unlimited axes by the nearest turn.
fn brute_force(
    machine: &Machine,
    choices: &[Vec<[f64; 2]>],
    start: Option<[f64; 2]>,
    so_far: &mut Vec<[f64; 2]>,
    best: &mut Option<Cost>,
) {
    let Some(here) = choices.get(so_far.len()) else {
        let total = cost(so_far, start);
        let better = best.is_none_or(|best| {
            total.rewinds < best.rewinds
                || (total.rewinds == best.rewinds
                    && (total.travel < best.travel - SAME_DEG
                        || (total.travel < best.travel + SAME_DEG && total.sum < best.sum)))
        });
        if better {
            *best = Some(total);
        }
        return;
    };
    let previous = so_far.last().copied().or(start);
    for candidate in here {
        let mut words = *candidate;
        for k in 0..2 {
            if let (Some(previous), None) = (previous, machine.rotary_axes()[k].travel_deg) {
                words[k] += 360.0 * ((previous[k] - words[k]) / 360.0).round();
            }
        }
        so_far.push(words);
        brute_force(machine, choices, start, so_far, best);
        so_far.pop();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_chosen_path_costs_what_brute_force_finds(
        machine in preset_machine(true), travels in [travel(), travel()], poses in poses(4), started in any::<bool>(),
    ) {
        let machine = with_travels(&machine, travels);
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let start = started.then(|| {
            travels.map(|travel| travel.map_or(30.0, |t| 30.0_f64.clamp(t.min, t.max)))
        });
        let options = PathOptions { start_words_deg: start, ..PathOptions::default() };
        let mut choices = Vec::new();
        for (n, pose) in poses.iter().enumerate() {
            let Ok(candidates) = kinematics.candidates(n, pose, 0.0) else {
                prop_assert!(kinematics.path(&poses, &options, GO_ON).is_err());
                return Ok(());
            };
            let [first, second] = machine.rotary_axes();
            let words = candidates.iter().map(|c| {
                [first.word_deg(c.joints.rotary_rad[0]), second.word_deg(c.joints.rotary_rad[1])]
            });
            choices.push(words.collect::<Vec<_>>());
        }
        let path = kinematics.path(&poses, &options, GO_ON).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assume!(path.warnings.iter().all(|w| w.kind != WarningKind::PoleHold));
        let words = words_of(&machine, &path, poses.len());
        let found = cost(&words, start);
        let mut best = None;
        brute_force(&machine, &choices, start, &mut Vec::new(), &mut best);
        let best = best.unwrap();
        prop_assert_eq!(found.rewinds, best.rewinds, "{:?} {:?}", words, best);
        prop_assert!((found.travel - best.travel).abs() < TIE_DEG, "{words:?} {found:?} {best:?}");
        prop_assert!(found.sum <= best.sum + 1e-3, "{words:?} {found:?} {best:?}");
        let rewinds = path.warnings.iter().filter(|w| w.kind == WarningKind::Rewind).count();
        prop_assert_eq!(rewinds, found.rewinds);
    }

    #[test]
    fn a_path_keeps_tips_and_axes_and_lanes_change_no_bit(
        machine in preset_machine(true), travels in [travel(), travel()], poses in poses(700), nearest in any::<bool>(),
        linear in x_ends(),
    ) {
        let machine = with_x_up_to(&with_travels(&machine, travels), linear);
        let kinematics = Kinematics::new(&machine, &Setup { tool_length_mm: 80.0, ..Setup::default() });
        let selection = if nearest { Selection::Nearest } else { Selection::Cheapest };
        let options = PathOptions { selection, ..PathOptions::default() };
        // what this machine can do of it
        let poses: Vec<_> = poses.into_iter().filter(|p| kinematics.candidates(0, p, 0.0).is_ok()).collect();
        let path = kinematics.path(&poses, &options, GO_ON);
        for instructions in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
            for lanes in [Lanes::Always, Lanes::Never] {
                let other = kinematics.path(&poses, &PathOptions { instructions, lanes, ..options }, GO_ON);
                prop_assert_eq!(&other, &path);
            }
        }
        let Ok(path) = path else { return Ok(()) };
        for (n, pose) in poses.iter().enumerate() {
            let back = kinematics.forward(&path.get(n).unwrap());
            prop_assert!((back.tip_mm - pose.tip_mm).norm() <= 1e-9);
            let residual = path.warnings.iter().find(|w| w.pose == n).map_or(0.0, |w| w.axis_residual_rad);
            prop_assert!((angle_between(back.axis, pose.axis) - residual).abs() <= 2e-12);
        }
    }

    #[test]
    fn a_smooth_path_is_the_same_to_the_last_bit_in_blocks_and_one_by_one(
        machine in preset_machine(true), travels in [travel(), travel()], poses in smooth_poses(), nearest in any::<bool>(),
        start in prop::option::of([-170.0..170.0_f64, -170.0..170.0_f64]),
        rewind_deg in prop_oneof![Just(120.0), Just(30.0), Just(200.0)], linear in x_ends(),
    ) {
        let machine = with_x_up_to(&with_travels(&machine, travels), linear);
        let kinematics = Kinematics::new(&machine, &Setup { tool_length_mm: 80.0, ..Setup::default() });
        let selection = if nearest { Selection::Nearest } else { Selection::Cheapest };
        let options = PathOptions { selection, start_words_deg: start, rewind_deg, ..PathOptions::default() };
        let poses: Vec<_> = poses.into_iter().filter(|p| kinematics.candidates(0, p, 0.0).is_ok()).collect();
        let singly = kinematics.path(&poses, &PathOptions { lanes: Lanes::Never, ..options }, GO_ON);
        for instructions in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
            let in_lanes = kinematics.path(&poses, &PathOptions { instructions, ..options }, GO_ON);
            prop_assert_eq!(&in_lanes, &singly);
            if let (Ok(in_lanes), Ok(singly)) = (&in_lanes, &singly) {
                prop_assert_eq!(bits(in_lanes), bits(singly));
            }
        }
    }

    #[test]
    fn few_poses_are_solved_singly_to_the_last_bit(
        machine in preset_machine(true), travels in [travel(), travel()], poses in (1..40_usize).prop_flat_map(poses),
        nearest in any::<bool>(), start in prop::option::of([-170.0..170.0_f64, -170.0..170.0_f64]),
        linear in x_ends(),
    ) {
        let machine = with_x_up_to(&with_travels(&machine, travels), linear);
        let kinematics = Kinematics::new(&machine, &Setup { tool_length_mm: 80.0, ..Setup::default() });
        let selection = if nearest { Selection::Nearest } else { Selection::Cheapest };
        let options = PathOptions { selection, start_words_deg: start, ..PathOptions::default() };
        let mut poses: Vec<_> = poses.into_iter().filter(|p| kinematics.candidates(0, p, 0.0).is_ok()).collect();
        // one on the pole
        if let Some(pose) = poses.get_mut(2) { pose.axis = Vec3::z(); }
        let mut lanes = PoseLanes::with_capacity(poses.len());
        for pose in &poses {
            lanes.push(*pose);
        }
        // memory that was used for something else
        let (mut used, mut used_too) = (Path::default(), Path::default());
        for path in [&mut used, &mut used_too] {
            let _solved_or_not = kinematics.path_lanes_into(&lanes, &PathOptions::default(), GO_ON, path);
        }
        let of = |lanes_used, path: &mut Path| {
            kinematics.path_lanes_into(&lanes, &PathOptions { lanes: lanes_used, ..options }, GO_ON, path)
        };
        let (singly, in_lanes) = (of(Lanes::Never, &mut used), of(Lanes::Always, &mut used_too));
        prop_assert_eq!(&singly, &in_lanes);
        if singly.is_ok() {
            prop_assert_eq!(bits(&used), bits(&used_too));
            prop_assert_eq!(&used.warnings, &used_too.warnings);
        }
    }

    #[test]
    fn a_single_pose_is_reached_as_the_first_of_a_path_that_stays_there(
        machine in preset_machine(true), travels in [travel(), travel()], poses in poses(40), on_pole in any::<bool>(),
        start in prop::option::of([-170.0..170.0_f64, -170.0..170.0_f64]), linear in x_ends(),
    ) {
        let machine = with_x_up_to(&with_travels(&machine, travels), linear);
        let kinematics = Kinematics::new(&machine, &Setup { tool_length_mm: 80.0, ..Setup::default() });
        let options = PathOptions { start_words_deg: start, ..PathOptions::default() };
        for mut pose in poses {
            if on_pole { pose.axis = Vec3::z(); }
            let alone = kinematics.path(&[pose], &options, GO_ON);
            // The choice among ways, none of which is cheaper for going on elsewhere.
            let twice = kinematics.path(&[pose, pose], &options, GO_ON);
            prop_assert_eq!(alone.as_ref().err(), twice.as_ref().err());
            let (Ok(alone), Ok(twice)) = (alone, twice) else { continue };
            prop_assert_eq!(alone.get(0), twice.get(0));
            prop_assert_eq!(alone.conditioning.first(), twice.conditioning.first());
            prop_assert_eq!(alone.warnings.first(), twice.warnings.first());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(80))]

    #[test]
    fn a_path_in_pieces_is_the_path_to_the_last_bit(
        machine in preset_machine(true), travels in [travel(), travel()],
        poses in prop_oneof![poses(700), smooth_poses(), (0..300_usize).prop_flat_map(poses)],
        begins_on_pole in prop_oneof![Just(0), 1..3_usize, 100..400_usize],
        start in prop::option::of([-170.0..170.0_f64, -170.0..170.0_f64]),
        rewind_deg in prop_oneof![Just(120.0), Just(30.0), Just(200.0)], linear in x_ends(), piece in 1..600_usize,
    ) {
        let machine = with_x_up_to(&with_travels(&machine, travels), linear);
        let kinematics = Kinematics::new(&machine, &Setup { tool_length_mm: 80.0, ..Setup::default() });
        let options = PathOptions { start_words_deg: start, rewind_deg, ..PathOptions::default() };
        let mut poses: Vec<_> = poses.into_iter().filter(|p| kinematics.candidates(0, p, 0.0).is_ok()).collect();
        poses.iter_mut().take(begins_on_pole).for_each(|pose| pose.axis = Vec3::z());
        let whole = kinematics.path(&poses, &options, GO_ON);
        let mut lanes = PoseLanes::with_capacity(poses.len());
        for pose in &poses {
            lanes.push(*pose);
        }
        let sources: [&dyn PoseSource; 2] = [&lanes, &Elsewhere(poses)];
        for source in sources {
            let in_pieces = in_pieces(&kinematics, source, &options, piece);
            prop_assert_eq!(&in_pieces, &whole);
            if let (Ok(in_pieces), Ok(whole)) = (&in_pieces, &whole) {
                prop_assert_eq!(bits(in_pieces), bits(whole));
            }
        }
    }
}

/// Poses that are handed over as those in a file are: copied, block by block.
struct Elsewhere(Vec<ToolPose>);

impl PoseSource for Elsewhere {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn block<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> Poses<'a> {
        let numbers = |pose: &ToolPose| {
            let ToolPose { tip_mm, axis } = pose;
            [tip_mm.x, tip_mm.y, tip_mm.z, axis.x, axis.y, axis.z]
        };
        copy.fill(self.0[start..].iter().map(numbers))
    }
}

/// A path that is decided first, and then put together from its pieces.
fn in_pieces(
    kinematics: &Kinematics,
    poses: &dyn PoseSource,
    options: &PathOptions,
    size: usize,
) -> Result<Path, InverseError> {
    let mut decided = kinematics.decide_path(poses, options, &|| ControlFlow::Continue(()))?;
    let (warnings, mut whole, mut piece) = (decided.warnings(), Path::default(), Path::default());
    loop {
        decided.next_piece(size, &mut piece)?;
        let Path { joints, conditioning, warnings } = &piece;
        if joints.is_empty() {
            break;
        }
        assert!(joints.len() >= size || whole.joints.len() + joints.len() == poses.count());
        for lane in 0..joints.len() {
            let linear_mm = [joints.x_mm[lane], joints.y_mm[lane], joints.z_mm[lane]];
            whole.joints.push(linear_mm, [joints.first_rad[lane], joints.second_rad[lane]]);
        }
        whole.conditioning.extend(conditioning);
        whole.warnings.extend(warnings);
    }
    assert_eq!(warnings, whole.warnings.len());
    Ok(whole)
}

/// Every number of a path, to the bit.
fn bits(path: &Path) -> Vec<u64> {
    let Path { joints, conditioning, .. } = path;
    let lanes =
        [&joints.x_mm, &joints.y_mm, &joints.z_mm, &joints.first_rad, &joints.second_rad, conditioning];
    lanes.into_iter().flatten().map(|value| value.to_bits()).collect()
}

/// The cheapest way through all candidates, every step from every candidate to every other.
fn cheapest_of_all(choices: &[Vec<[f64; 2]>], start: Option<[f64; 2]>) -> Cost {
    let step = |so_far: Cost, from: Option<[f64; 2]>, to: [f64; 2]| {
        let step = cost(&[to], from);
        Cost {
            rewinds: so_far.rewinds + step.rewinds,
            travel: so_far.travel + step.travel,
            sum: so_far.sum + step.sum,
        }
    };
    let order = |a: &Cost, b: &Cost| {
        let by_travel = if (a.travel - b.travel).abs() < SAME_DEG {
            a.sum.total_cmp(&b.sum)
        } else {
            a.travel.total_cmp(&b.travel)
        };
        a.rewinds.cmp(&b.rewinds).then(by_travel)
    };
    let nothing = Cost { rewinds: 0, travel: 0.0, sum: 0.0 };
    let mut costs: Vec<_> = choices[0].iter().map(|to| step(nothing, start, *to)).collect();
    for pair in choices.windows(2) {
        costs = pair[1]
            .iter()
            .map(|to| {
                let ways = costs.iter().zip(&pair[0]).map(|(so_far, from)| step(*so_far, Some(*from), *to));
                ways.min_by(order).unwrap()
            })
            .collect();
    }
    costs.into_iter().min_by(order).unwrap()
}

/// Travels of one turn and of several, the limits anywhere.
fn wide_travel() -> impl Strategy<Value = Option<Travel>> {
    (prop_oneof![Just(360.0), Just(720.0), Just(1500.0), Just(3600.0)], -200.0..200.0_f64)
        .prop_map(|(half, middle)| Some(Travel { min: middle - half, max: middle + half }))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn several_turns_cost_what_every_step_between_candidates_costs(
        calibrated in preset_machine(true), nominal in any::<bool>(), wide in (wide_travel(), travel()),
        wide_first in any::<bool>(), poses in poses(60), wound in any::<bool>(), started in any::<bool>(),
    ) {
        let travels = if wide_first { [wide.0, wide.1] } else { [wide.1, wide.0] };
        // one end for each axis that has one: the unlimited are covered above
        let travels = travels.map(|travel| travel.or(Some(Travel { min: -500.0, max: 500.0 })));
        let setup = Setup { apply_errors: !nominal, ..Setup::default() };
        let machine = with_travels(&calibrated, travels);
        let kinematics = Kinematics::new(&machine, &setup);
        let poses = if wound { spiral(150, 3.0 + poses[0].tip_mm.x.abs() * 0.1, 25.0) } else { poses };
        let poses: Vec<_> = poses.into_iter().filter(|p| kinematics.candidates(0, p, 0.0).is_ok()).collect();
        prop_assume!(!poses.is_empty());
        let start = started.then(|| travels.map(|travel| travel.map_or(0.0, |t| 30.0_f64.clamp(t.min, t.max))));
        let options = PathOptions { start_words_deg: start, ..PathOptions::default() };
        let [first, second] = machine.rotary_axes();
        let choices: Vec<Vec<_>> = poses
            .iter()
            .enumerate()
            .map(|(n, pose)| {
                let words = |joints: [f64; 2]| [first.word_deg(joints[0]), second.word_deg(joints[1])];
                let candidates = kinematics.candidates(n, pose, 0.0).unwrap();
                candidates.iter().map(|c| words(c.joints.rotary_rad)).collect()
            })
            .collect();
        let path = kinematics.path(&poses, &options, GO_ON).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assume!(path.warnings.iter().all(|w| w.kind != WarningKind::PoleHold));
        let words = words_of(&machine, &path, poses.len());
        for (word, travel) in words.iter().flat_map(|words| words.iter().zip(travels)) {
            prop_assert!(travel.is_none_or(|t| t.contains(*word, COMPUTED_WORD_SLACK)), "{} {:?}", word, travel);
        }
        let (found, best) = (cost(&words, start), cheapest_of_all(&choices, start));
        prop_assert_eq!(found.rewinds, best.rewinds, "{:?} {:?}", found, best);
        prop_assert!((found.travel - best.travel).abs() < TIE_DEG, "{found:?} {best:?}");
        // with very many turns a tie may be decided before the travels are looked at
        let ties_by_sum = kinematics.path_states() > 2;
        prop_assert!(!ties_by_sum || found.sum <= best.sum + 1e-3, "{found:?} {best:?}");
    }
}

/// A C table that winds: poses on a cone about the pole.
fn spiral(count: usize, turns: f64, tilt_deg: f64) -> Vec<ToolPose> {
    (0..count)
        .map(|n| {
            let azimuth = std::f64::consts::TAU * turns * n as f64 / (count - 1) as f64;
            let tilt = tilt_deg.to_radians();
            ToolPose {
                tip_mm: Vec3::new(10.0, 0.0, 0.0),
                axis: Vec3::new(tilt.sin() * azimuth.sin(), -tilt.sin() * azimuth.cos(), tilt.cos()),
            }
        })
        .collect()
}

fn ac_table(travels: [Option<Travel>; 2]) -> Machine {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    with_travels(&machine, travels)
}

#[test]
fn a_limited_axis_starts_where_its_turns_suffice() {
    let poses = spiral(4000, 19.0, 20.0);
    for limit in [3600.0, 36_000.0, 360_000.0] {
        let wound = Some(Travel { min: -limit, max: limit });
        let machine = ac_table([Some(Travel { min: -120.0, max: 120.0 }), wound]);
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let path = kinematics.path(&poses, &PathOptions::default(), GO_ON).unwrap();
        assert_eq!(path.warnings, [], "{limit}");
        let words = words_of(&machine, &path, poses.len());
        let total = cost(&words, None);
        assert!((total.travel - 19.0 * 360.0).abs() < 1e-6, "{total:?}");
        // 19 turns lie best with their middle near zero
        let (first, last) = (words[0][1], words[poses.len() - 1][1]);
        assert!((first + last).abs() <= 360.0 + 1e-6, "{first} {last}");
    }
}

#[test]
fn too_few_turns_cost_the_fewest_rewinds() {
    let poses = spiral(4000, 19.0, 20.0);
    let wound = Some(Travel { min: -900.0, max: 900.0 });
    let machine = ac_table([Some(Travel { min: -5.0, max: 120.0 }), wound]);
    let path =
        Kinematics::new(&machine, &Setup::default()).path(&poses, &PathOptions::default(), GO_ON).unwrap();
    // 19 turns in a travel of five: at least four pieces, three rewinds
    assert_eq!(path.warnings.len(), 3);
    assert!(path.warnings.iter().all(|w| w.kind == WarningKind::Rewind));
}

#[test]
fn the_pole_is_passed_with_the_table_held() {
    let machine = ac_table([Some(Travel { min: -120.0, max: 120.0 }), None]);
    let kinematics = Kinematics::new(&machine, &Setup::default());
    let poses: Vec<_> = (-50..=50)
        .map(|n| {
            let tilt = f64::from(n) * 0.001_f64.to_radians();
            ToolPose { tip_mm: Vec3::zeros(), axis: Vec3::new(tilt.sin(), 0.0, tilt.cos()) }
        })
        .collect();
    let path = kinematics.path(&poses, &PathOptions::default(), GO_ON).unwrap();
    let held = path.warnings.iter().filter(|w| w.kind == WarningKind::PoleHold).count();
    assert_eq!(held, 21);
    assert_eq!(path.warnings.len(), held);
    let words = words_of(&machine, &path, poses.len());
    assert!(words.iter().all(|w| (w[1] - words[0][1]).abs() < 1e-9), "C stands still");
    // a path that begins in the cone takes C from its first pose outside, or from the start
    let late = kinematics.path(&poses[50..], &PathOptions::default(), GO_ON).unwrap();
    let words = words_of(&machine, &late, 51);
    assert!(words.iter().all(|w| (w[1].abs() - 90.0).abs() < 1e-9), "{words:?}");
    let options = PathOptions { start_words_deg: Some([0.0, 33.0]), ..PathOptions::default() };
    let late = kinematics.path(&poses[50..], &options, GO_ON).unwrap();
    let words = words_of(&machine, &late, 51);
    assert!((words[0][1] - 33.0).abs() < 1e-9 && (words[10][1] - 33.0).abs() < 1e-9);
    let alone = kinematics.path(&poses[50..52], &PathOptions::default(), GO_ON).unwrap();
    assert!(words_of(&machine, &alone, 2).iter().all(|w| w[1] == 0.0));
}

#[test]
fn faults_name_pose_axis_and_numbers() {
    let machine = ac_table([Some(Travel { min: -30.0, max: 30.0 }), None]);
    let kinematics = Kinematics::new(&machine, &Setup::default());
    let mut poses = spiral(10, 0.1, 20.0);
    poses.extend(spiral(10, 0.1, 45.0));
    let error = kinematics.path(&poses, &PathOptions::default(), GO_ON).unwrap_err();
    let InverseError::OutOfTravel { pose: 10, commanded, min: -30.0, max: 30.0, .. } = error else {
        panic!("{error}");
    };
    assert!((commanded.abs() - 45.0).abs() < 1e-9);
    poses[3].axis = Vec3::zeros();
    let error = kinematics.path(&poses, &PathOptions::default(), GO_ON).unwrap_err();
    assert_eq!(error, InverseError::NoDirection { pose: 3 });
    poses[3].axis = Vec3::new(f64::NAN, 0.0, 1.0);
    let error = kinematics.path(&poses, &PathOptions::default(), GO_ON).unwrap_err();
    assert_eq!(error, InverseError::NoDirection { pose: 3 });
    let stopped = kinematics.path(&poses, &PathOptions::default(), &|| ControlFlow::Break(()));
    assert_eq!(stopped.unwrap_err(), InverseError::Stopped);
    let options = PathOptions { start_words_deg: Some([31.0, 0.0]), ..PathOptions::default() };
    assert!(matches!(
        kinematics.path(&poses[..3], &options, GO_ON),
        Err(InverseError::StartOutOfTravel { commanded: 31.0, .. })
    ));
    let nutating = Machine::new(Preset::by_id("nutating-bc-table").unwrap().parts()).unwrap();
    let down = [ToolPose { tip_mm: Vec3::zeros(), axis: Vec3::new(1.0, 0.0, -1.0) }];
    let error = Kinematics::new(&nutating, &Setup::default())
        .path(&down, &PathOptions::default(), GO_ON)
        .unwrap_err();
    let InverseError::OutOfReach { pose: 0, tilt_deg, max_deg, .. } = error else { panic!("{error}") };
    assert!((tilt_deg - 135.0).abs() < 1e-9 && (max_deg - 90.0).abs() < 1e-9);
}

#[test]
fn linear_travels_choose_the_branch() {
    for (id, limits) in [("ac-table", [-1000.0, -1.0]), ("ac-table", [1.0, 1000.0])] {
        let mut parts = Preset::by_id(id).unwrap().parts();
        parts.linear_travel_mm[1] = Some(Travel { min: limits[0], max: limits[1] });
        let machine = Machine::new(parts).unwrap();
        let kinematics = Kinematics::new(&machine, &Setup::default());
        let mut poses = spiral(50, 0.2, 30.0);
        for pose in &mut poses {
            pose.tip_mm = pose.axis * 100.0 + Vec3::new(0.0, 0.0, 50.0);
        }
        let path = kinematics.path(&poses, &PathOptions::default(), GO_ON).unwrap();
        assert!(path.joints.y_mm.iter().all(|y| (limits[0]..=limits[1]).contains(y)), "{id}");
    }
}
