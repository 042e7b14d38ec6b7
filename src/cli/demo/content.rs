//! The example: a machine, its tools, the wear of two cutters, and the jobs. The same every time.

use serde_json::{Value, json};

use super::DemoFault;
use crate::wire::example_machine;

/// Id of the machine of the example.
pub(super) const MACHINE: &str = "demo-ac-table";
/// Index of the run that is applied: the last but one, so that the newest shows what has changed since.
pub(super) const CALIBRATION_APPLIED: usize = 4;
/// The job that is refused.
pub(super) const FAILS: &str = "a program out of travel, refused";

const BLADE: &str = include_str!("../../../docs/examples/blade.nc");
const FLANK: &str = include_str!("../../../docs/examples/flank.apt");
const DOME: &str = include_str!("../../../docs/examples/dome.nc");
/// A turns past its end in the last line.
const OUT_OF_TRAVEL: &str = "%\n(BEYOND THE END OF A)\nG21 G90 G17 G54\nT1 M6\nG0 X0.000 Y0.000 Z50.000 A0.000 C0.000\n\
                             G94 G1 X10.000 A60.000 C2.000 F800.\nX20.000 A125.000 C4.000\nM30\n%\n";

/// A job with its program.
#[derive(Debug, Clone)]
pub(super) struct Job {
    /// Its name for people, which is its external id too.
    pub(super) name: &'static str,
    pub(super) operation: &'static str,
    pub(super) parameters: Value,
    pub(super) file_name: &'static str,
    pub(super) program: &'static str,
    /// Whether the job draws a figure.
    pub(super) has_plot: bool,
}

/// The profile of the machine: the example machine with its drives, and what it states about programs.
pub(super) fn profile() -> Result<Value, DemoFault> {
    let (_, mut profile) =
        example_machine().ok_or_else(|| DemoFault::Content("there is no example machine".to_owned()))?;
    "Demo machine with an AC table".clone_into(&mut profile.name);
    profile.max_feed_mm_per_min = Some(15_000.0);
    serde_json::to_value(&profile).map_err(|fault| DemoFault::Content(fault.to_string()))
}

/// The tools of the machine by their ids.
pub(super) fn tools() -> [(&'static str, Value); 2] {
    [
        ("T1", json!({"number": 1, "name": "BALL-10", "kind": "ball", "radius_mm": 5, "length_mm": 98.4})),
        (
            "T12",
            json!({"number": 12, "name": "BALL-10-ROUGH", "kind": "ball", "radius_mm": 5, "length_mm": 112.7}),
        ),
    ]
}

/// The wear of two cutters in the holder of T12: parts cut and radius wear (µm). The first was changed near its limit,
/// the second is in use.
const WEAR: [(&str, &[(u32, f64)]); 2] = [
    (
        "1",
        &[
            (10, 12.4),
            (25, 17.9),
            (40, 21.2),
            (60, 26.8),
            (80, 31.1),
            (100, 36.3),
            (120, 41.5),
            (140, 47.9),
            (160, 55.6),
        ],
    ),
    ("2", &[(10, 11.8), (25, 17.2), (40, 20.6), (60, 26.1), (80, 31.2), (100, 35.9)]),
];
/// The months in which each cutter was measured; days follow from the parts.
const WEAR_MONTHS: [u32; 2] = [9, 10];

/// The entries of both cutters.
pub(super) fn wear_entries() -> Value {
    let mut all = Vec::new();
    for ((cutter, entries), month) in WEAR.into_iter().zip(WEAR_MONTHS) {
        for (index, (parts, wear)) in entries.iter().enumerate() {
            all.push(json!({
                "measured_at": format!("2025-{month:02}-{:02}T14:30:00Z", 2 + 3 * index),
                "parts_cut": parts,
                "radius_wear_um": wear,
                "cutter_id": cutter,
                "note": "tool setter",
            }));
        }
    }
    Value::Array(all)
}

/// The jobs, in the order in which they are posted.
pub(super) fn jobs() -> Vec<Job> {
    let offset = json!([12, -7, 35]);
    let blade = |name, operation, parameters, has_plot| Job {
        name,
        operation,
        parameters,
        file_name: "blade.nc",
        program: BLADE,
        has_plot,
    };
    vec![
        blade(
            "blade, contact path",
            "cc-compensation",
            json!({"tool_radius_mm": 5, "tolerance_um": 10, "work_offset_mm": offset}),
            true,
        ),
        blade(
            "blade, all in one pass",
            "compensation",
            json!({
                "wear": {"nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.95}},
                "location_errors": true, "cc": {"tolerance_um": 5}, "work_offset_mm": offset
            }),
            true,
        ),
        blade(
            "blade, worn cutter",
            "wear-compensation",
            json!({
                "nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.97}, "work_offset_mm": offset
            }),
            true,
        ),
        blade("blade, servo simulation", "servo-simulation", json!({"work_offset_mm": offset}), true),
        Job {
            name: "dome, virtual cutting",
            operation: "verification",
            parameters: json!({
                "surface": {"kind": "sphere", "radius_mm": 20, "half_angle_deg": 20}, "tool": {"radius_mm": 4.5},
                "work_offset_mm": offset
            }),
            file_name: "dome.nc",
            program: DOME,
            has_plot: true,
        },
        Job {
            name: "flank, posted from APT",
            operation: "posting",
            parameters: json!({"work_offset_mm": offset}),
            file_name: "flank.apt",
            program: FLANK,
            has_plot: false,
        },
        Job {
            name: FAILS,
            operation: "cc-compensation",
            parameters: json!({"tool_radius_mm": 5, "work_offset_mm": offset, "contact": "tip"}),
            file_name: "beyond.nc",
            program: OUT_OF_TRAVEL,
            has_plot: false,
        },
    ]
}
