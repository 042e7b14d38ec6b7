//! Throughput of the servo simulation, in one thread, as the best of several runs: `cargo bench --bench servo`.

use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

use trunnion::kinematics::{InstructionSet, Setup};
use trunnion::machine::{Machine, Preset};
use trunnion::process::{ProgramSetup, SimulationParameters, simulate};
use trunnion::servo::{
    AxisLetter, AxisServo, Circle, Drive, DrivePreset, DriveSet, Resonance, Run, ServoPath, StateSpace, Step,
    sweep_at_feed,
};
use trunnion::units::Feedrate;

const STEPS: usize = 1_000_000;
const AXES: usize = 5;
const PERIOD_S: f64 = 0.001;
const RUNS: usize = 25;
const GO_ON: &dyn Fn() -> ControlFlow<()> = &|| ControlFlow::Continue(());

fn best_seconds(runs: usize, mut run: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}

fn drive(id: &str) -> Drive {
    DrivePreset::by_id(id).map(|preset| preset.drive).expect("a preset")
}

fn command() -> Vec<f64> {
    (0..STEPS)
        .map(|k| {
            let t = k as f64 * PERIOD_S;
            5.0 * (12.0 * t).sin() + 0.02 * t
        })
        .collect()
}

/// The textbook way: one step after the other.
fn step_by_step(drive: &Drive, command: &[f64], positions: &mut Vec<f64>) {
    let system = StateSpace::of(drive);
    let step = Step::new(&system, PERIOD_S).expect("a step");
    let states = system.states();
    let mut state: Vec<f64> = system.at_rest(command[0]).iter().copied().collect();
    let mut after = vec![0.0; states];
    let mut old = command[0];
    positions.clear();
    for &new in command {
        for (row, value) in after.iter_mut().enumerate() {
            *value = step.from_old[row] * old + step.from_new[row] * new;
            for (column, state) in state.iter().enumerate() {
                *value += step.transition[(row, column)] * state;
            }
        }
        std::mem::swap(&mut state, &mut after);
        positions.push(state[step.output]);
        old = new;
    }
}

fn peak_memory_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}

#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn main() {
    let command = command();
    let rigid = drive("reference-linear");
    let resonance = Some(Resonance { frequency_hz: 60.0, damping_ratio: 0.1 });
    let mut positions = Vec::new();
    for (name, drive) in [("rigid", rigid), ("with a resonance", Drive { resonance, ..rigid })] {
        let plain = best_seconds(5, || {
            for _ in 0..AXES {
                step_by_step(&drive, &command, &mut positions);
                black_box(&positions);
            }
        });
        let expected = positions.clone();
        println!("5 axes x 1e6 steps, {name}: step by step {:6.2} ms   1.0", plain * 1e3);
        for (set_name, set) in [
            ("baseline", InstructionSet::Baseline),
            ("up to AVX2", InstructionSet::Avx2),
            ("up to AVX-512", InstructionSet::Avx512),
        ] {
            let seconds = best_seconds(RUNS, || {
                for _ in 0..AXES {
                    let servo = AxisServo::new(&drive, PERIOD_S, command[0]).expect("a step");
                    servo.with_instructions(set).follow(&command, &mut positions);
                    black_box(&positions);
                }
            });
            let size = expected.iter().fold(0.0_f64, |size, y| size.max(y.abs()));
            let off =
                expected.iter().zip(&positions).fold(0.0_f64, |off, (a, b)| off.max((a - b).abs())) / size;
            println!(
                "    blocks of eight, {set_name:<14} {:6.2} ms  {:5.1} times; off by {off:.1e} relative",
                seconds * 1e3,
                plain / seconds
            );
        }
    }
    sweep();
    program();
    println!("peak memory {:.0} MiB", peak_memory_mib());
}

/// 20 gains × 20 feeds of P2's circle, columns one after the other: the service runs them side by side.
#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn sweep() {
    let path = ServoPath::Circle(Circle::XC { radius_mm: 60.0, center_x_mm: 100.0 });
    let sets: Vec<DriveSet> = (0..20)
        .map(|k| {
            let mut drives = DriveSet::default();
            drives.set(AxisLetter::X, drive("reference-linear"));
            let scale = 0.5 + 0.05 * f64::from(k);
            drives.set(AxisLetter::C, drive("reference-rotary").with_position_gain_scaled(scale));
            drives
        })
        .collect();
    let mut samples = 0;
    let seconds = best_seconds(5, || {
        samples = 0;
        for k in 0..20 {
            let run = Run::at(Feedrate::from_mm_per_min(900.0 + 150.0 * f64::from(k)));
            let column = sweep_at_feed(&path, &run, &sets, GO_ON).expect("a circle");
            samples += column.iter().flatten().map(|cell| cell.samples).sum::<u64>();
        }
    });
    println!(
        "sweep 20 x 20 of the XC circle, one core: {:.0} ms, {:.1} M samples, {:.0} M samples/s",
        seconds * 1e3,
        samples as f64 / 1e6,
        samples as f64 / 1e6 / seconds
    );
}

/// A program of short blocks through five drives and the kinematics of an AC table.
#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn program() {
    let machine = Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine");
    let mut drives = DriveSet::default();
    for axis in [AxisLetter::X, AxisLetter::Y, AxisLetter::Z] {
        drives.set(axis, drive("reference-linear"));
    }
    for axis in [AxisLetter::A, AxisLetter::C] {
        drives.set(axis, drive("reference-rotary"));
    }
    let mut text = String::from("G90 G21 G94 G17\nG43.4 H1\nG0 X0 Y0 Z0 A-20 C0\n");
    for k in 1..=100_000 {
        use std::fmt::Write;
        let s = f64::from(k) * 1e-2;
        let (x, y, z) = (80.0 * (0.05 * s).sin(), 60.0 * (0.04 * s).sin(), 5.0 * (0.1 * s).sin());
        let (a, c) = (-20.0 - 10.0 * (0.03 * s).sin(), 40.0 * (0.02 * s).sin());
        writeln!(text, "G1 X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4} F2000").expect("a string takes it");
    }
    let source = text.into_bytes();
    let parameters = SimulationParameters::new(drives, ProgramSetup::in_mm(&Setup::default()));
    let mut found = None;
    let seconds = best_seconds(3, || {
        found = Some(simulate(&machine, &parameters, &source, GO_ON).expect("a program"));
    });
    let Some(found) = found else { return };
    println!(
        "program, {} blocks, {:.1} M samples of 5 axes: {:.0} ms, {:.2} M samples/s; contour error {:.1} um",
        found.blocks,
        found.outcome.samples as f64 / 1e6,
        seconds * 1e3,
        found.outcome.samples as f64 / 1e6 / seconds,
        found.outcome.contour.max_abs_mm * 1e3
    );
}
