//! Texts for controls, read back by readers of their own: they give the axes and the transform they were made from.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use nalgebra::{Rotation3, Unit, Vector3};
use trunnion::calibration::export::{absolute_errors, neutral};
use trunnion::geometry::{Screw, Vec3};
use trunnion::kinematics::{Joints, Kinematics, Setup};
use trunnion::machine::{
    LocationError, Machine, MachineParts, PRESETS, Preset, RotaryLetter, Side, Squareness,
};

type V = Vector3<f64>;

/// Rounding of two dozen operations on numbers of some hundred [mm].
const ROUNDING_MM: f64 = 2e-12;
/// The same on unit vectors.
const ROUNDING: f64 = 1e-14;

/// A repeatable stream of numbers in [−1, 1).
fn stream(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64) * 2.0_f64.powi(-52) - 1.0
    }
}

fn vector(next: &mut impl FnMut() -> f64, size: f64) -> V {
    V::from_fn(|_, _| next() * size)
}

/// A preset with points, errors and senses of its own.
fn measured(preset: &Preset, next: &mut impl FnMut() -> f64) -> MachineParts {
    let mut parts = preset.parts();
    for axis in &mut parts.rotary_axes {
        axis.travel_deg = None;
        axis.point_mm += vector(next, 150.0);
        axis.reversed = next() > 0.0;
        axis.location_error =
            LocationError { translation_mm: vector(next, 0.1), rotation_rad: vector(next, 5e-4) };
    }
    let v = vector(next, 2e-4);
    parts.squareness = Squareness { e_c0y_rad: v.x, e_b0z_rad: v.y, e_a0z_rad: v.z };
    parts
}

fn joints(next: &mut impl FnMut() -> f64) -> Joints {
    let linear_mm = vector(next, 200.0);
    Joints { linear_mm, rotary_rad: [0, 1].map(|_| next() * std::f64::consts::PI) }
}

fn turned(direction: V, angle_rad: f64, v: V) -> V {
    Rotation3::from_axis_angle(&Unit::new_normalize(direction), angle_rad) * v
}

/// A machine as a reader of lines sees it.
struct ReadMachine {
    /// Line, side, and +1 or −1 for the sense in which words count; tables from the bed, heads from the ram.
    axes: Vec<(Screw, Side, f64)>,
}

impl ReadMachine {
    /// Tip and tool axis in the workpiece for words [mm, rad].
    fn pose(&self, linear_mm: V, words_rad: [f64; 2]) -> (V, V) {
        let (mut tip, mut axis) = (V::zeros(), V::z());
        let indexed: Vec<_> = self.axes.iter().zip(words_rad).collect();
        for ((line, _, sense), word) in indexed.iter().rev().filter(|((_, side, _), _)| *side == Side::Head) {
            tip = turned(line.direction, sense * word, tip - line.point_mm) + line.point_mm;
            axis = turned(line.direction, sense * word, axis);
        }
        tip += linear_mm;
        for ((line, _, sense), word) in indexed.iter().filter(|((_, side, _), _)| *side == Side::Table) {
            // the table turns by −word; seen from the workpiece the tool turns by +word
            tip = turned(line.direction, sense * word, tip - line.point_mm) + line.point_mm;
            axis = turned(line.direction, sense * word, axis);
        }
        (tip, axis)
    }
}

fn numbers(value: &toml::Value) -> V {
    let list: Vec<f64> = value.as_array().unwrap().iter().map(|v| v.as_float().unwrap()).collect();
    V::new(list[0], list[1], list[2])
}

mod the_neutral_text {
    use super::*;

    #[test]
    fn gives_the_lines_and_their_transform_back_to_the_last_digit() {
        let mut next = stream(1);
        for preset in &PRESETS {
            let parts = measured(preset, &mut next);
            let machine = Machine::new(parts.clone()).unwrap();
            let text: toml::Table = neutral(&machine).parse().unwrap();
            let read = ReadMachine {
                axes: text["rotary_axes"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|axis| {
                        let line = Screw {
                            direction: numbers(&axis["calibrated_direction"]),
                            point_mm: numbers(&axis["calibrated_point_mm"]),
                        };
                        let side =
                            if axis["side"].as_str() == Some("head") { Side::Head } else { Side::Table };
                        let opposite = axis["counts_opposite_to_iso_841"].as_bool().unwrap();
                        (line, side, if opposite { -1.0 } else { 1.0 })
                    })
                    .collect(),
            };
            for ((line, ..), expected) in read.axes.iter().zip(machine.screws(true)) {
                assert_eq!(*line, expected, "{}", preset.id);
            }
            let straight = Machine::new(MachineParts { squareness: Squareness::default(), ..parts }).unwrap();
            let kinematics = Kinematics::new(&straight, &Setup::default());
            for _ in 0..40 {
                let joints = joints(&mut next);
                let axes = straight.rotary_axes();
                let words = [0, 1].map(|k| axes[k].word_deg(joints.rotary_rad[k]).to_radians());
                let (tip, axis) = read.pose(joints.linear_mm, words);
                let pose = kinematics.forward(&joints);
                assert!((pose.tip_mm - tip).norm() < ROUNDING_MM, "{}", (pose.tip_mm - tip).norm());
                assert!((pose.axis - axis).norm() < ROUNDING, "{}", (pose.axis - axis).norm());
            }
        }
    }

    #[test]
    fn gives_the_same_profile_from_its_cascaded_values() {
        let mut next = stream(2);
        for preset in &PRESETS {
            let mut parts = measured(preset, &mut next);
            let machine = Machine::new(parts.clone()).unwrap();
            let text: toml::Table = neutral(&machine).parse().unwrap();
            for (axis, read) in parts.rotary_axes.iter_mut().zip(text["rotary_axes"].as_array().unwrap()) {
                assert_eq!(read["name"].as_str().unwrap(), axis.letter.as_char().to_string());
                let value = |name: &str| read["location_error"][name].as_float().unwrap();
                axis.direction = numbers(&read["nominal_direction"]);
                axis.point_mm = numbers(&read["nominal_point_mm"]);
                axis.location_error = LocationError {
                    translation_mm: V::new(value("e_x_um"), value("e_y_um"), value("e_z_um")) / 1e3,
                    rotation_rad: V::new(value("e_a_urad"), value("e_b_urad"), value("e_c_urad")) / 1e6,
                };
            }
            let value = |name: &str| text["squareness_urad"][name].as_float().unwrap() / 1e6;
            parts.squareness = Squareness {
                e_c0y_rad: value("e_c0y"),
                e_b0z_rad: value("e_b0z"),
                e_a0z_rad: value("e_a0z"),
            };
            let again = Machine::new(parts).unwrap();
            let kinematics = [&machine, &again].map(|m| Kinematics::new(m, &Setup::default()));
            for _ in 0..40 {
                let joints = joints(&mut next);
                let [a, b] = [0, 1].map(|k| kinematics[k].forward(&joints));
                assert!((a.tip_mm - b.tip_mm).norm() < ROUNDING_MM && (a.axis - b.axis).norm() < ROUNDING);
            }
        }
    }

    #[test]
    fn gives_the_lines_back_from_its_absolute_values() {
        /// What is left out of the redundant components acts at second order: the products of two rotations of
        /// 1 mrad over 300 mm, and of a rotation and 0.2 mm [mm].
        const SECOND_ORDER_MM: f64 = 1e-3;
        let mut next = stream(3);
        for preset in &PRESETS {
            let machine = Machine::new(measured(preset, &mut next)).unwrap();
            let text: toml::Table = neutral(&machine).parse().unwrap();
            for (read, line) in text["rotary_axes"].as_array().unwrap().iter().zip(machine.screws(true)) {
                let letter = read["name"].as_str().unwrap();
                let iso = read["iso_230"].as_table().unwrap();
                let value = |of: char, unit: &str| {
                    iso.get(&format!("E_{of}0{letter}_{unit}")).map_or(0.0, |v| v.as_float().unwrap())
                };
                let shift = V::new(value('X', "um"), value('Y', "um"), value('Z', "um")) / 1e3;
                let rotation = V::new(value('A', "urad"), value('B', "urad"), value('C', "urad")) / 1e6;
                let direction = Rotation3::new(rotation) * numbers(&read["nominal_direction"]);
                let point = numbers(&read["nominal_point_mm"]) + shift;
                let off = (point - line.point_mm).cross(&line.direction).norm();
                assert!(off < SECOND_ORDER_MM, "{}: {off}", preset.id);
                assert!((direction - line.direction).norm() < 2e-6, "{}", preset.id);
                let redundant = iso["redundant"].as_array().unwrap().len();
                assert_eq!(iso.len() - 1 + redundant, 6);
            }
        }
    }

    #[test]
    fn keeps_a_name_that_would_break_it() {
        let mut parts = PRESETS[0].parts();
        "a \"quote\"\n\\ and [table]\u{7f} µ".clone_into(&mut parts.name);
        let machine = Machine::new(parts).unwrap();
        let text: toml::Table = neutral(&machine).parse().unwrap();
        assert_eq!(text["machine"].as_str(), Some(machine.name()));
    }
}

#[test]
fn absolute_errors_of_a_trunnion_are_those_of_the_closed_formula() {
    /// Products of two rotations of up to 63 µrad, [rad] and over 50 mm [mm].
    const SECOND_ORDER: f64 = 1e-8;
    const SECOND_ORDER_MM: f64 = 5e-7;
    let mut parts = Preset::by_id("ac-table").unwrap().parts();
    let (p_a, p_c) = (V::new(1.0, 2.0, -3.0), V::new(3.0, 2.3, -53.0));
    let (delta, omega) = (V::new(0.012, -0.021, 0.034), V::new(41e-6, -63e-6, 29e-6));
    let (delta_yca, beta_ac) = (0.015, 27e-6);
    parts.rotary_axes[0].point_mm = p_a;
    parts.rotary_axes[1].point_mm = p_c;
    parts.rotary_axes[0].location_error = LocationError { translation_mm: delta, rotation_rad: omega };
    parts.rotary_axes[1].location_error =
        LocationError { translation_mm: V::y() * delta_yca, rotation_rad: V::y() * beta_ac };
    let [a, c] = absolute_errors(&Machine::new(parts).unwrap());
    assert_eq!((a.letter, c.letter), (RotaryLetter::A, RotaryLetter::C));
    let j: Vec3 = p_c - p_a;
    for (found, symbol, expected) in [
        (a.translation_mm.y, a.symbol(1), ("E_Y0A", delta.y)),
        (a.translation_mm.z, a.symbol(2), ("E_Z0A", delta.z)),
        (a.rotation_rad.y, a.symbol(4), ("E_B0A", omega.y)),
        (a.rotation_rad.z, a.symbol(5), ("E_C0A", omega.z)),
        (c.rotation_rad.x, c.symbol(3), ("E_A0C", omega.x)),
        (c.rotation_rad.y, c.symbol(4), ("E_B0C", omega.y + beta_ac)),
        (c.translation_mm.x, c.symbol(0), ("E_X0C", delta.x + omega.y * j.z - omega.z * j.y)),
        (c.translation_mm.y, c.symbol(1), ("E_Y0C", delta.y + delta_yca + omega.z * j.x - omega.x * j.z)),
    ] {
        assert_eq!(symbol, expected.0);
        let tolerance = if "XYZ".contains(&symbol[2..3]) { SECOND_ORDER_MM } else { SECOND_ORDER };
        assert!((found - expected.1).abs() < tolerance, "{symbol}: {found} is not {}", expected.1);
    }
    let redundant = |error: &trunnion::calibration::export::AbsoluteError| {
        (0..6).filter(|&k| error.is_redundant(k)).map(|k| error.symbol(k)).collect::<Vec<_>>()
    };
    assert_eq!(redundant(&a), ["E_X0A", "E_A0A"]);
    assert_eq!(redundant(&c), ["E_Z0C", "E_C0C"]);
}
