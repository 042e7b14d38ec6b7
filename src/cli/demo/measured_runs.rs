//! The calibration runs of the example: ball-bar readings of a machine whose errors grow slowly, made with the model of
//! the fit, with noise that is the same every time.

use serde_json::{Value, json};

use super::DemoFault;
use crate::calibration::expected_readings;
use crate::geometry::Vec3;
use crate::jobs::{MachineUsed, ToolShelf};
use crate::machine::LocationError;
use crate::units::{Angle, Length};
use crate::wire::{CalibrationRequest, Fault, FaultList, MachineProfile};

/// When each run was measured, and the temperature of the machine (°C).
const MEASURED: [(&str, f64); 6] = [
    ("2025-01-14T08:10:00Z", 19.8),
    ("2025-03-11T08:05:00Z", 20.1),
    ("2025-05-13T08:20:00Z", 20.6),
    ("2025-07-15T07:55:00Z", 21.4),
    ("2025-09-16T08:15:00Z", 20.7),
    ("2025-11-11T08:10:00Z", 20.0),
];
/// Location errors of A and C at the first run: shifts along X, Y, Z (µm), rotations about X, Y, Z (µrad). These are the
/// eight that place both axes.
const FIRST: [[f64; 6]; 2] = [[4.0, -8.0, 11.0, -12.0, 14.0, -9.0], [0.0, 3.0, 0.0, 0.0, 6.0, 0.0]];
/// How much each grows from run to run.
const GROWTH: [[f64; 6]; 2] = [[1.8, -1.5, 0.8, -0.6, 1.2, 0.0], [0.0, 0.4, 0.0, 0.0, 0.9, 0.0]];
/// The spindle ball is this far from the spindle's line, along X and Y (µm).
const SET_UP_UM: [f64; 2] = [4.0, -6.0];
/// Largest noise of a reading (µm), and the step in which the instrument shows one.
const NOISE_UM: f64 = 0.4;
const STEP_UM: f64 = 0.1;

/// The runs, oldest first.
pub(super) fn runs(profile: &Value) -> Result<Vec<Value>, DemoFault> {
    let profile: MachineProfile =
        serde_json::from_value(profile.clone()).map_err(|fault| DemoFault::Content(fault.to_string()))?;
    let used = MachineUsed::new("demo".to_owned(), 1, profile, ToolShelf::default())
        .map_err(|faults| listed(&faults))?;
    let mut noise = Noise(1);
    let mut runs = Vec::new();
    for (number, (measured_at, temperature_c)) in MEASURED.into_iter().enumerate() {
        let plan = plan(measured_at, temperature_c);
        let mut run: CalibrationRequest =
            serde_json::from_value(plan).map_err(|fault| DemoFault::Content(fault.to_string()))?;
        let mut faults = FaultList::default();
        let core = run.to_ballbar(&used.machine, &mut faults);
        faults.into_result().map_err(|faults| listed(&faults))?;
        let Some(core) = core else { return Err(DemoFault::Content("a run is no run".to_owned())) };
        let set_up = SET_UP_UM.map(|um| Length::from_um(um).mm());
        let readings = expected_readings(&used.machine, &core, &errors(number), set_up);
        let readings = readings
            .map_err(|faults| DemoFault::Content(faults.iter().map(ToString::to_string).collect()))?;
        for (test, lengths_mm) in run.tests.iter_mut().flatten().zip(readings) {
            for (reading, length_mm) in test.readings.iter_mut().flatten().zip(lengths_mm) {
                let um = Length::from_mm(length_mm).um() + noise.next_um();
                // Whole steps, written with one decimal.
                reading.length_change_um = (um / STEP_UM).round() / STEP_UM.recip();
            }
        }
        runs.push(serde_json::to_value(&run).map_err(|fault| DemoFault::Content(fault.to_string()))?);
    }
    Ok(runs)
}

fn listed(faults: &[Fault]) -> DemoFault {
    let all: Vec<String> =
        faults.iter().map(|fault| format!("{}: {}", fault.pointer, fault.detail)).collect();
    DemoFault::Content(all.join("; "))
}

/// The errors of both axes at a run.
fn errors(number: usize) -> [LocationError; 2] {
    let of_axis = |first: [f64; 6], growth: [f64; 6]| {
        let at = |place: usize| {
            let part = |values: &[f64; 6]| values.get(place).copied().unwrap_or_default();
            part(&first) + part(&growth) * number as f64
        };
        let mm = |place| Length::from_um(at(place)).mm();
        let rad = |place| Angle::from_urad(at(place)).rad();
        LocationError {
            translation_mm: Vec3::new(mm(0), mm(1), mm(2)),
            rotation_rad: Vec3::new(rad(3), rad(4), rad(5)),
        }
    };
    let ([first_a, first_c], [growth_a, growth_c]) = (FIRST, GROWTH);
    [of_axis(first_a, growth_a), of_axis(first_c, growth_c)]
}

/// A run without its readings: each axis turns there and back, with the bar along and across.
fn plan(measured_at: &str, temperature_c: f64) -> Value {
    let test = |axis: &str, bar: &str, ball_mm: [i32; 3], from: i32, to: i32| {
        let there: Vec<i32> = (from..=to).step_by(30).collect();
        let angles = there.iter().chain(there.iter().rev());
        let readings: Vec<Value> =
            angles.map(|angle| json!({"angle_deg": angle, "length_change_um": 0})).collect();
        json!({"rotary_axis": axis, "bar_direction": bar, "ball_mm": ball_mm, "readings": readings})
    };
    json!({
        "kind": "rtcp-ballbar", "measured_at": measured_at, "temperature_c": temperature_c,
        "instrument": "ball bar, 0.1 µm resolution", "operator": "demo",
        "note": "made by a simulation: errors that grow from run to run, up to 0.4 µm of noise",
        "bar_length_mm": 100, "setup_error_um": {"e_xs": SET_UP_UM[0], "e_ys": SET_UP_UM[1]},
        "tests": [
            test("C", "radial", [150, 20, 60], 0, 360),
            test("C", "axial", [150, 20, 60], 0, 360),
            test("A", "radial", [30, 10, 160], -90, 90),
            test("A", "axial", [30, 10, 160], -90, 90),
        ]
    })
}

/// Noise that is the same every time (a linear congruential generator).
struct Noise(u32);

impl Noise {
    fn next_um(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(self.0 >> 8) / f64::from(1 << 24) * 2.0 - 1.0) * NOISE_UM
    }
}
