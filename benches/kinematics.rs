//! Throughput of the kinematics, in one thread, as the best of 99 runs: `cargo bench --bench kinematics`.
//!
//! Every instruction set and two kinds of plain code for the ratios, one pose at a time with the platform's
//! trigonometry. They take turns with the lanes. The first is the inverse with textbook formulas. The second is the
//! anchor: it gets the rotary angles and only computes X Y Z. A controller does this if the program names the angles.

use std::hint::black_box;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use trunnion::geometry::{Screw, Vec3, angle_about, angle_between, wrap_rad};
use trunnion::jobs::{InverseAnswer, InverseTask, Limits, MachineUsed, ToolShelf};
use trunnion::kinematics::{
    InstructionSet, JointLanes, Joints, Kinematics, Path, PathOptions, PoseLanes, Selection, Setup, ToolPose,
};
use trunnion::machine::{LocationError, Machine, MachineParts, Preset, Travel};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::wire::{InverseRequest, MachineProfile, SolvedPoses};

const POSES: usize = 16_384;
const GO_ON: &dyn Fn() -> ControlFlow<()> = &|| ControlFlow::Continue(());

fn calibrated(id: &str) -> Option<Machine> {
    Machine::new(calibrated_parts(id)?).ok()
}

fn calibrated_parts(id: &str) -> Option<MachineParts> {
    let mut parts = Preset::by_id(id)?.parts();
    for (k, axis) in parts.rotary_axes.iter_mut().enumerate() {
        let sign = if k == 0 { 1.0 } else { -1.0 };
        axis.point_mm += Vec3::new(0.3, -0.2, 0.7) * sign;
        axis.location_error = LocationError {
            translation_mm: Vec3::new(0.012, -0.021, 0.034) * sign,
            rotation_rad: Vec3::new(41e-6, -63e-6, 29e-6),
        };
    }
    parts.squareness.e_c0y_rad = 20e-6;
    Some(parts)
}

/// A finishing pass: the axis wanders between 10° and 50° of tilt, the azimuth to and fro.
fn poses() -> (Vec<ToolPose>, PoseLanes) {
    let mut lanes = PoseLanes::default();
    let mut list = Vec::new();
    for n in 0..POSES {
        let s = n as f64 * 1e-3;
        let tilt = 0.52 + 0.34 * (s * 1.3).sin();
        let azimuth = 2.4 * (s * 0.37).sin();
        let axis = Vec3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
        let tip_mm = Vec3::new(80.0 * s.cos(), 60.0 * (s * 0.7).sin(), 10.0 + 0.01 * s);
        list.push(ToolPose { tip_mm, axis });
        for (lane, value) in [
            (&mut lanes.x_mm, tip_mm.x),
            (&mut lanes.y_mm, tip_mm.y),
            (&mut lanes.z_mm, tip_mm.z),
            (&mut lanes.i, axis.x),
            (&mut lanes.j, axis.y),
            (&mut lanes.k, axis.z),
        ] {
            lane.push(value);
        }
    }
    (list, lanes)
}

/// A path that winds twice as far as a travel of so many turns to either side: it cannot do without a rewind.
fn wound(turns: f64) -> PoseLanes {
    let mut lanes = PoseLanes::default();
    for n in 0..POSES {
        let azimuth = std::f64::consts::TAU * 4.0 * turns * n as f64 / POSES as f64;
        let (sin, cos) = 0.4_f64.sin_cos();
        let axis = Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
        lanes.push(ToolPose { tip_mm: Vec3::new(10.0, 20.0, 30.0), axis });
    }
    lanes
}

/// Millions a second, the best of 99 runs: other work on the machine only ever slows a run down.
fn rate(mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..99)
        .map(|_| {
            let begin = Instant::now();
            run();
            begin.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    POSES as f64 / times[0] / 1e6
}

/// Millions a second of works that take turns, each the best of 99 runs.
fn rates(works: &mut [Box<dyn FnMut() + '_>]) -> Vec<f64> {
    let mut best_s = vec![f64::INFINITY; works.len()];
    for _ in 0..99 {
        for (work, best_s) in works.iter_mut().zip(&mut best_s) {
            let begin = Instant::now();
            work();
            *best_s = best_s.min(begin.elapsed().as_secs_f64());
        }
    }
    best_s.into_iter().map(|seconds| POSES as f64 / seconds / 1e6).collect()
}

/// The anchor: X Y Z of a table A that carries a table C, for angles that are given. Nothing is chosen or calibrated.
struct AnglesGiven {
    /// Points of A and of C.
    points_mm: [Vec3; 2],
    /// The work offset.
    offset_mm: Vec3,
}

impl AnglesGiven {
    fn joints(&self, tip_mm: Vec3, [a_rad, c_rad]: [f64; 2]) -> Joints {
        let ((sin_a, cos_a), (sin_c, cos_c)) = (a_rad.sin_cos(), c_rad.sin_cos());
        let [a_mm, c_mm] = self.points_mm;
        let p = tip_mm + self.offset_mm - c_mm;
        let p = Vec3::new(cos_c * p.x + sin_c * p.y, cos_c * p.y - sin_c * p.x, p.z) + c_mm - a_mm;
        let p = Vec3::new(p.x, cos_a * p.y + sin_a * p.z, cos_a * p.z - sin_a * p.y) + a_mm;
        Joints { linear_mm: p - self.offset_mm, rotary_rad: [a_rad, c_rad] }
    }
}

/// Plain code: textbook subproblem 2 with the platform's functions, both branches, the nearest kept.
struct Plain<'a> {
    kinematics: &'a Kinematics,
    u: Screw,
    v: Screw,
    order: [usize; 2],
}

impl Plain<'_> {
    fn nearest(&self, pose: &ToolPose, previous: [f64; 2]) -> Option<Joints> {
        let (u, v, t) = (self.u.direction, self.v.direction, pose.axis.normalize());
        let (sigma, tau, phi) =
            (angle_between(u, v), angle_between(v, Machine::TOOL_AXIS), angle_between(u, t));
        let cos_b = (phi.cos() - sigma.cos() * tau.cos()) / (sigma.sin() * tau.sin());
        let b = cos_b.clamp(-1.0, 1.0).acos();
        let b0 = angle_about(v, Machine::TOOL_AXIS, u);
        let mut best: Option<(f64, [f64; 2])> = None;
        for v_angle in [b0 + b, b0 - b] {
            let u_angle = angle_about(u, self.v.turn(v_angle, Machine::TOOL_AXIS), t);
            let words: [f64; 2] =
                std::array::from_fn(|k| previous[k] + wrap_rad([u_angle, v_angle][k] - previous[k]));
            let travel = (words[0] - previous[0]).abs() + (words[1] - previous[1]).abs();
            if best.is_none_or(|(least, _)| travel < least) {
                best = Some((travel, words));
            }
        }
        let (_, words) = best?;
        let mut rotary_rad = [0.0; 2];
        rotary_rad[self.order[0]] = words[0];
        rotary_rad[self.order[1]] = words[1];
        Some(Joints { linear_mm: self.kinematics.linear_mm(pose.tip_mm, rotary_rad), rotary_rad })
    }
}

#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn main() {
    let sets = [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512];
    let (list, lanes) = poses();
    println!(
        "M poses/s, one thread, {POSES} poses, calibrated machines; in brackets the ratios to the anchor (angles given, X Y Z computed) and to a plain inverse"
    );
    for id in ["ac-table", "nutating-b-head-c-table", "bc-head"] {
        let Some(machine) = calibrated(id) else { continue };
        let setup = Setup { work_offset_mm: Vec3::new(70.0, -40.0, 95.0), ..Setup::default() };
        let kinematics = Kinematics::new(&machine, &setup);
        let screws = machine.screws(true);
        let order = machine.workpiece_to_tool();
        let plain = Plain { kinematics: &kinematics, u: screws[order[0]], v: screws[order[1]], order };
        let kept = inverse(id, &kinematics, &plain, &list, &lanes);
        let mut joints = JointLanes::default();
        for joint in &kept {
            joints.push(joint.linear_mm.into(), joint.rotary_rad);
        }
        let mut out = PoseLanes::default();
        let mut poses = Vec::with_capacity(POSES);
        let base = rate(|| {
            poses.clear();
            poses.extend(kept.iter().map(|joint| kinematics.forward(joint)));
            black_box(&poses);
        });
        print!("  forward one by one {base:.1}");
        for set in sets {
            let fast = rate(|| {
                kinematics.forward_lanes_on(set, &joints, &mut out);
                black_box(&out);
            });
            print!(", {set:?} {fast:.1} ({:.1}x)", fast / base);
        }
        println!();
    }
    if let Some(machine) = calibrated("ac-table") {
        let mut parts = Preset::by_id("ac-table").map(Preset::parts);
        if let Some(parts) = &mut parts {
            parts.rotary_axes = machine.rotary_axes().to_vec();
            for turns in [2.0, 10.0, 100.0] {
                parts.rotary_axes[1].travel_deg = Some(Travel { min: -360.0 * turns, max: 360.0 * turns });
                let Ok(machine) = Machine::new(parts.clone()) else { continue };
                let kinematics = Kinematics::new(&machine, &Setup::default());
                let fast = rate(|| {
                    black_box(kinematics.path_lanes(&lanes, &PathOptions::default(), GO_ON).is_ok());
                });
                let wound = wound(turns + 1.0);
                let too_long = rate(|| {
                    black_box(kinematics.path_lanes(&wound, &PathOptions::default(), GO_ON).is_ok());
                });
                println!(
                    "ac-table, C limited to ±{turns} turns, Cheapest Fastest: {fast:.1}; wound too far: {too_long:.2}"
                );
            }
        }
    }
    json(&list);
    let peak = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(line) = peak.lines().find(|line| line.starts_with("VmHWM")) {
        println!("{line}");
    }
}

/// Plain code, the anchor and all lanes, in turns. Returns the joints of the plain inverse.
#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn inverse(
    id: &str,
    kinematics: &Kinematics,
    plain: &Plain<'_>,
    list: &[ToolPose],
    lanes: &PoseLanes,
) -> Vec<Joints> {
    let solve = |kept: &mut Vec<Joints>| {
        kept.clear();
        let mut previous = [0.0; 2];
        for pose in list {
            if let Some(joints) = plain.nearest(pose, previous) {
                previous = plain.order.map(|index| joints.rotary_rad[index]);
                kept.push(joints);
            }
        }
    };
    let mut kept = Vec::with_capacity(POSES);
    solve(&mut kept);
    let given: Vec<(Vec3, [f64; 2])> =
        list.iter().zip(&kept).map(|(pose, joints)| (pose.tip_mm, joints.rotary_rad)).collect();
    let anchor = AnglesGiven {
        points_mm: [Vec3::new(0.3, -0.2, 0.7), Vec3::new(-0.3, 0.2, -0.7)],
        offset_mm: Vec3::new(70.0, -40.0, 95.0),
    };
    let (mut out, mut plainly) = (Vec::with_capacity(POSES), Vec::with_capacity(POSES));
    let mut works: Vec<Box<dyn FnMut() + '_>> = vec![
        Box::new(|| {
            out.clear();
            out.extend(given.iter().map(|(tip_mm, rotary_rad)| anchor.joints(*tip_mm, *rotary_rad)));
            black_box(&out);
        }),
        Box::new(|| {
            solve(&mut plainly);
            black_box(&plainly);
        }),
    ];
    let mut names = Vec::new();
    for selection in [Selection::Nearest, Selection::Cheapest] {
        for instructions in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
            let options = PathOptions { selection, instructions, ..PathOptions::default() };
            names.push(format!("{selection:?} {instructions:?}"));
            let (mut path, mut path_too) = (Path::default(), Path::default());
            works.push(Box::new(move || {
                black_box(kinematics.path_lanes_into(lanes, &options, GO_ON, &mut path).is_ok());
            }));
            works.push(Box::new(move || {
                black_box(kinematics.path_into(list, &options, GO_ON, &mut path_too).is_ok());
            }));
            works.push(Box::new(move || {
                black_box(kinematics.path(list, &options, GO_ON).is_ok());
            }));
        }
    }
    let rates = rates(&mut works);
    drop(works);
    let (anchor, plain) = (rates[0], rates[1]);
    println!("{id}: anchor {anchor:.1}, plain inverse {plain:.1}");
    for (name, rates) in names.iter().zip(rates[2..].chunks_exact(3)) {
        let [arrays, listed, fresh] = [0, 1, 2].map(|n| rates[n]);
        println!(
            "  {name}: {arrays:.1} ({:.2}x anchor, {:.1}x plain), from a list of poses {listed:.1} ({:.2}x anchor), into new memory {fresh:.1}",
            arrays / anchor,
            arrays / plain,
            listed / anchor
        );
    }
    kept
}

/// The JSON route without HTTP: text in, text out.
#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn json(list: &[ToolPose]) {
    let Some(profile) = calibrated_parts("ac-table").map(|parts| MachineProfile::from(&parts)) else {
        return;
    };
    let Ok(on) = MachineUsed::new(String::new(), 1, profile, ToolShelf::default()) else { return };
    let on = Arc::new(on);
    let limits = Limits { max_poses: POSES, max_cost_s: f64::INFINITY };
    for (name, decimals) in [("6 decimals", Some(6)), ("all digits", None)] {
        let mut text = String::from("{\"poses\": [");
        for (n, pose) in list.iter().enumerate() {
            let separator = if n == 0 { "" } else { ", " };
            text += separator;
            for (key, value) in ["{\"x\": ", ", \"y\": ", ", \"z\": ", ", \"i\": ", ", \"j\": ", ", \"k\": "]
                .into_iter()
                .zip([pose.tip_mm.x, pose.tip_mm.y, pose.tip_mm.z, pose.axis.x, pose.axis.y, pose.axis.z])
            {
                text += key;
                text += &decimals.map_or_else(|| value.to_string(), |decimals| format!("{value:.decimals$}"));
            }
            text += "}";
        }
        text += "], \"work_offset_mm\": [70, -40, 95]}";
        let read = || InverseRequest::read(text.as_bytes()).ok();
        let Some(document) = read() else { continue };
        let solve = |document: &InverseRequest| {
            let options = document.options();
            let (setup, start_words_deg) = options.to_setup(&on.machine).ok()?;
            let task = InverseTask::new(Arc::clone(&on), &setup, document.selection, start_words_deg);
            task.solve(document.poses.clone(), limits, GO_ON).ok()
        };
        let Some(answer) = solve(&document) else { continue };
        let text_of = |document: &SolvedPoses| {
            let mut text = Vec::new();
            document.write_json(&OneAfterAnother, &mut text).map(|()| text)
        };
        let print = |answer: InverseAnswer| text_of(&SolvedPoses::new(1, answer.solutions, answer.warnings));
        let parse = rate(|| drop(black_box(read())));
        let solved = rate(|| drop(black_box(solve(&document))));
        let document_out = SolvedPoses::new(1, answer.solutions.clone(), answer.warnings.clone());
        let printed = rate(|| drop(black_box(text_of(&document_out))));
        let total = rate(|| {
            black_box(read().and_then(|document| solve(&document)).map(print));
        });
        println!(
            "JSON, {name}, {} bytes a pose in, {} out: parse {parse:.2}, solve {solved:.2}, print {printed:.2}, total {total:.2}",
            text.len() / POSES,
            print(answer.clone()).map_or(0, |text| text.len()) / POSES
        );
    }
}
