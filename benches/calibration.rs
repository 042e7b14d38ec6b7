//! Identification from a ball-bar run: `cargo bench --bench calibration`.

use std::hint::black_box;
use std::time::Instant;

use trunnion::calibration::{
    BallBarRun, BallBarTest, BarDirection, Observed, Reading, SetupError, expected_readings, identify,
};
use trunnion::geometry::Vec3;
use trunnion::machine::{LocationError, Machine, Preset};

const RUNS: usize = 50;
const READINGS: usize = 360;

fn best_ms(mut run: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
    }
    best
}

fn run(noise_mm: f64, outliers: bool) -> Option<(Machine, BallBarRun)> {
    let machine = Machine::new(Preset::by_id("ac-table")?.parts()).ok()?;
    let mut tests = Vec::new();
    for (axis, from_deg, to_deg, z) in [(1, 0.0, 360.0, 60.0), (0, -90.0, 90.0, 160.0)] {
        for bar in [BarDirection::Radial, BarDirection::Axial] {
            let readings = (0..READINGS)
                .map(|k| from_deg + (to_deg - from_deg) * k as f64 / READINGS as f64)
                .map(|deg| Reading { angle_rad: deg.to_radians(), length_change_mm: 0.0 })
                .collect();
            tests.push(BallBarTest {
                axis,
                bar,
                ball_mm: Vec3::new(150.0, 0.0, z),
                tool_length_mm: 0.0,
                reading_uncertainty: 1.0,
                observed: Observed::Readings(readings),
            });
        }
    }
    let mut run = BallBarRun {
        bar_length_mm: 100.0,
        offset_per_test: true,
        instrument_uncertainty_mm: Some(5e-4),
        setup_error: SetupError::Known([0.0; 2]),
        tests,
    };
    let error = LocationError {
        translation_mm: Vec3::new(0.012, -0.021, 0.034),
        rotation_rad: Vec3::new(41e-6, -63e-6, 29e-6),
    };
    let expected = expected_readings(&machine, &run, &[error, LocationError::default()], [0.0; 2]).ok()?;
    let mut state = 1_u32;
    for (test, expected) in run.tests.iter_mut().zip(expected) {
        let Observed::Readings(readings) = &mut test.observed else { continue };
        for (number, (reading, value)) in readings.iter_mut().zip(expected).enumerate() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state >> 8) / f64::from(1 << 24) - 0.5;
            let outlier = if outliers && number % 20 == 7 { 0.05 } else { 0.0 };
            reading.length_change_mm = value + noise * noise_mm + outlier;
        }
    }
    Some((machine, run))
}

#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn main() {
    for (name, noise_mm, outliers) in
        [("no noise", 0.0, false), ("noise", 2e-3, false), ("noise and 5 % outliers", 2e-3, true)]
    {
        let Some((machine, run)) = run(noise_mm, outliers) else { continue };
        let ms = best_ms(|| drop(black_box(identify(&machine, &run))));
        let readings = run.readings() as f64;
        println!(
            "4 tests x {READINGS} readings, {name}: {ms:.2} ms, {:.2} M readings/s",
            readings / ms * 1e-3
        );
    }
    let peak = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(line) = peak.lines().find(|line| line.starts_with("VmHWM")) {
        println!("{line}");
    }
}
