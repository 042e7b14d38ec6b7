//! Texts for controls, read back by readers of their own: they give the axes and the transform they were made from.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what it did not expect")]
#![expect(clippy::float_cmp, reason = "what is printed exactly reads back to the bit")]

use std::collections::BTreeMap;
use std::num::NonZeroU16;

use nalgebra::{Rotation3, Unit, Vector3};
use trunnion::calibration::export::{LinuxCncFault, LinuxCncModule, SiemensForm, linuxcnc, neutral, siemens};
use trunnion::calibration::{CommonPerpendicular, absolute_errors, iso_230_symbol};
use trunnion::geometry::{Screw, Vec3};
use trunnion::kinematics::{Joints, Kinematics, Setup};
use trunnion::machine::{LocationError, Machine, MachineParts, PRESETS, Preset, Side, Squareness};

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
    /// Rounding of a few products of some tens [mm, rad].
    const ROUNDING: f64 = 1e-16;
    let mut parts = Preset::by_id("ac-table").unwrap().parts();
    let (p_a, p_c) = (V::new(1.0, 2.0, -3.0), V::new(3.0, 2.3, -53.0));
    let (delta, omega) = (V::new(0.012, -0.021, 0.034), V::new(41e-6, -63e-6, 29e-6));
    let (delta_yca, beta_ac) = (0.015, 27e-6);
    parts.rotary_axes[0].point_mm = p_a;
    parts.rotary_axes[1].point_mm = p_c;
    parts.rotary_axes[0].location_error = LocationError { translation_mm: delta, rotation_rad: omega };
    parts.rotary_axes[1].location_error =
        LocationError { translation_mm: V::y() * delta_yca, rotation_rad: V::y() * beta_ac };
    let machine = Machine::new(parts).unwrap();
    let found = absolute_errors(&machine);
    let j: Vec3 = p_c - p_a;
    let expected = [
        ("E_Y0A", delta.y),
        ("E_Z0A", delta.z),
        ("E_B0A", omega.y),
        ("E_C0A", omega.z),
        ("E_X0C", delta.x + omega.y * j.z - omega.z * j.y),
        ("E_Y0C", delta.y + delta_yca + omega.z * j.x - omega.x * j.z),
        ("E_A0C", omega.x),
        ("E_B0C", omega.y + beta_ac),
    ];
    assert_eq!(found.len(), expected.len(), "none along or about the axes themselves");
    for (error, (symbol, value)) in found.iter().zip(expected) {
        assert_eq!(iso_230_symbol(machine.rotary_axes()[error.axis].letter, error.component), symbol);
        assert!((error.value - value).abs() < ROUNDING, "{symbol}: {} is not {value}", error.value);
        assert_eq!(error.variance, None);
    }
    let text: toml::Table = neutral(&machine).parse().unwrap();
    let redundant = |axis: usize| text["rotary_axes"][axis]["iso_230"]["redundant"].to_string();
    assert_eq!(redundant(0), r#"["E_X0A", "E_A0A"]"#);
    assert_eq!(redundant(1), r#"["E_Z0C", "E_C0C"]"#);
}

mod linuxcnc_pins {
    use super::*;

    /// Five pins of six decimals, each off by half a unit of the last, turned twice [mm].
    const PRINTED_MM: f64 = 5e-6;
    /// Words that count as ISO 841, or opposite.
    type Senses = [bool; 2];

    /// `setp` commands of a text.
    fn read(text: &str) -> BTreeMap<String, f64> {
        text.lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| {
                let words: Vec<_> = line.split(' ').collect();
                assert_eq!((words.len(), words[0]), (3, "setp"), "{line}");
                (words[1].to_owned(), words[2].parse().unwrap())
            })
            .collect()
    }

    /// The module's forward kinematics as its source defines it, for the tip: position in the workpiece at words
    /// [mm, rad] of X Y Z and, in the order of the profile, of the rotary axes.
    fn forward(module: LinuxCncModule, pins: &BTreeMap<String, f64>, q: V, words: [f64; 2]) -> V {
        let pin = |name: &str| *pins.get(&format!("{}.{name}", module.name())).unwrap_or(&0.0);
        let r = V::new(pin("x-rot-point"), pin("y-rot-point"), pin("z-rot-point"));
        let d = V::new(pin("x-offset"), pin("y-offset"), pin("z-offset"));
        match module {
            LinuxCncModule::XyzacTrt | LinuxCncModule::XyzbcTrt => {
                let con = if pin("conventional-directions") == 1.0 { 1.0 } else { -1.0 };
                let tilting = if module == LinuxCncModule::XyzacTrt { V::x() } else { V::y() };
                r + turned(V::z(), con * words[1], d + turned(tilting, con * words[0], q - r - d))
            }
            LinuxCncModule::XyzabTdr => {
                let d = V::z() * d.z;
                r + d + turned(V::x(), words[1], turned(V::y(), words[0], q - r) - d)
            }
            LinuxCncModule::FiveAxis => {
                let l = pin("pivot-length");
                let ((sin_c, cos_c), (sin_b, cos_b)) = (words[0].sin_cos(), words[1].sin_cos());
                q + V::z() * l + V::new(sin_b * cos_c, sin_b * sin_c, -cos_b) * l
            }
        }
    }

    const CASES: [(LinuxCncModule, &str, Senses); 6] = [
        (LinuxCncModule::XyzacTrt, "ac-table", [true, true]),
        (LinuxCncModule::XyzacTrt, "ac-table", [false, false]),
        (LinuxCncModule::XyzbcTrt, "bc-table", [true, true]),
        (LinuxCncModule::XyzbcTrt, "bc-table", [false, false]),
        (LinuxCncModule::XyzabTdr, "ab-table", [true, true]),
        (LinuxCncModule::FiveAxis, "bc-head", [true, false]),
    ];

    fn machine(preset: &str, senses: Senses, tilt_rad: f64, next: &mut impl FnMut() -> f64) -> Machine {
        let mut parts = measured(Preset::by_id(preset).unwrap(), next);
        parts.squareness = Squareness::default();
        for (axis, iso) in parts.rotary_axes.iter_mut().zip(senses) {
            axis.reversed = !iso;
            axis.location_error.rotation_rad *= tilt_rad / 5e-4;
            if axis.side == Side::Head {
                // on the spindle's line, as the module has it
                axis.point_mm = V::z() * (150.0 + 20.0 * next());
                if tilt_rad == 0.0 {
                    axis.location_error.translation_mm.x = 0.0;
                    axis.location_error.translation_mm.y = 0.0;
                }
            }
        }
        Machine::new(parts).unwrap()
    }

    #[test]
    fn give_the_transform_of_a_machine_without_tilts() {
        let mut next = stream(11);
        for (module, preset, senses) in CASES {
            let machine = machine(preset, senses, 0.0, &mut next);
            let export = linuxcnc(&machine, 200.0).unwrap();
            assert_eq!(export.module, module);
            let pins = read(&export.text);
            let kinematics = Kinematics::new(&machine, &Setup::default());
            for _ in 0..60 {
                let joints = joints(&mut next);
                let words = [0, 1].map(|k| if senses[k] { 1.0 } else { -1.0 } * joints.rotary_rad[k]);
                let tip = forward(module, &pins, joints.linear_mm, words);
                let off = (kinematics.forward(&joints).tip_mm - tip).norm();
                assert!(off < PRINTED_MM, "{preset}: {off}");
            }
            assert!(export.remaining.tip_mm < PRINTED_MM && export.remaining.axis_rad < 1e-12, "{preset}");
        }
    }

    #[test]
    fn turn_as_the_modules_maintainers_expect() {
        // LinuxCNC issue 2435: position in the workpiece, then the joints of a table B C that counts as ISO 841
        let mut parts = Preset::by_id("bc-table").unwrap().parts();
        parts.rotary_axes.iter_mut().for_each(|axis| axis.travel_deg = None);
        let export = linuxcnc(&Machine::new(parts).unwrap(), 100.0).unwrap();
        let pins = read(&export.text);
        for (b, c, q) in
            [(0.0, 0.0, [1.0, 0.0, 2.0]), (90.0, 0.0, [-2.0, 0.0, 1.0]), (0.0, 90.0, [0.0, -1.0, 2.0])]
        {
            let words = [f64::to_radians(b), f64::to_radians(c)];
            let tip = forward(LinuxCncModule::XyzbcTrt, &pins, V::from(q), words);
            assert!((tip - V::new(1.0, 0.0, 2.0)).norm() < 1e-12, "B{b} C{c}: {tip}");
        }
    }

    #[test]
    fn take_tilted_lines_where_they_come_nearest_and_tell_what_remains() {
        /// Distance of the tips from the pivot, and length of a tool in a head [mm].
        const RADIUS_MM: f64 = 120.0;
        let mut next = stream(12);
        for (module, preset, senses) in CASES {
            let machine = machine(preset, senses, 5e-4, &mut next);
            let export = linuxcnc(&machine, RADIUS_MM).unwrap();
            let pins = read(&export.text);
            let lines = machine.screws(true);
            let pivot = CommonPerpendicular::of(&lines[0], &lines[1]).unwrap().feet_mm[1];
            let head = module == LinuxCncModule::FiveAxis;
            let tool_length_mm = if head { RADIUS_MM } else { 0.0 };
            let kinematics = Kinematics::new(&machine, &Setup { tool_length_mm, ..Setup::default() });
            let mut pins_with_tool = pins.clone();
            if head {
                *pins_with_tool.get_mut("5axiskins.pivot-length").unwrap() += RADIUS_MM;
            }
            let ideal = Kinematics::new(&machine, &Setup { apply_errors: false, ..Setup::default() });
            let (mut worst, mut worst_axis) = (0.0_f64, 0.0_f64);
            for _ in 0..4000 {
                let words = joints(&mut next).rotary_rad;
                let tip =
                    if head { V::zeros() } else { pivot + vector(&mut next, 1.0).normalize() * RADIUS_MM };
                // the words with which the module reaches the tip: its forward is rigid in q
                let at_zero = forward(module, &pins_with_tool, V::zeros(), words);
                let columns =
                    [V::x(), V::y(), V::z()].map(|e| forward(module, &pins_with_tool, e, words) - at_zero);
                let q = nalgebra::Matrix3::from_columns(&columns).transpose() * (tip - at_zero);
                let rotary_rad = [0, 1].map(|k| if senses[k] { 1.0 } else { -1.0 } * words[k]);
                let pose = kinematics.forward(&Joints { linear_mm: q, rotary_rad });
                worst = worst.max((pose.tip_mm - tip).norm());
                let angle = trunnion::geometry::angle_between(pose.axis, ideal.axis(rotary_rad));
                worst_axis = worst_axis.max(angle);
            }
            let stated = export.remaining;
            assert!(worst > 0.01, "{preset}: {worst}");
            // a bound: never passed but for the grid's 0.2 %, and a random search comes near
            assert!(
                (0.75..1.003).contains(&(worst / stated.tip_mm)),
                "{preset}: {worst} of {}",
                stated.tip_mm
            );
            assert!((0.75..1.003).contains(&(worst_axis / stated.axis_rad)), "{preset}: {worst_axis}");
            assert!(export.text.contains("wrong by up to") && export.text.contains("urad about X, Y, Z"));
        }
    }

    #[test]
    fn are_refused_to_machines_that_the_modules_do_not_fit() {
        let faults = |preset: &str, change: &dyn Fn(&mut MachineParts)| {
            let mut parts = Preset::by_id(preset).unwrap().parts();
            change(&mut parts);
            linuxcnc(&Machine::new(parts).unwrap(), 100.0).unwrap_err()
        };
        assert!(matches!(
            faults("b-head-c-table", &|_| ())[..],
            [LinuxCncFault::NoModule { first: 'B', .. }]
        ));
        assert!(matches!(faults("ac-head", &|_| ())[..], [LinuxCncFault::NoModule { .. }]));
        assert!(matches!(
            faults("nutating-bc-table", &|_| ())[..],
            [LinuxCncFault::Tilted { axis: 'B', tilt_rad, .. }] if (tilt_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-12
        ));
        assert!(matches!(
            faults("ac-table", &|parts| parts.rotary_axes[0].reversed = true)[..],
            [LinuxCncFault::UnlikeSenses { axis: 'C', .. }]
        ));
        assert!(matches!(
            faults("ab-table", &|parts| parts.rotary_axes[1].reversed = true)[..],
            [LinuxCncFault::Sense { axis: 'A', as_iso_841: true, .. }]
        ));
        let head = faults("bc-head", &|parts| parts.rotary_axes[1].point_mm.x = 30.0);
        assert!(matches!(
            head[..],
            [LinuxCncFault::OffSpindle { axis: 'B', distance_mm, .. }, LinuxCncFault::Sense { axis: 'B', .. }]
                if (distance_mm - 30.0).abs() < 1e-12
        ));
        let machine = Machine::new(PRESETS[0].parts()).unwrap();
        for radius_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(linuxcnc(&machine, radius_mm).unwrap_err()[..], [LinuxCncFault::Radius { .. }]));
        }
    }

    #[test]
    fn do_not_break_over_a_name() {
        let mut parts = PRESETS[0].parts();
        "x\nsetp xyzac-trt-kins.y-offset 99".clone_into(&mut parts.name);
        let machine = Machine::new(parts).unwrap();
        assert!(!read(&linuxcnc(&machine, 1.0).unwrap().text).values().any(|v| *v == 99.0));
        assert_eq!(
            siemens(&machine, SiemensForm::MachineData).lines().filter(|l| l.contains("99")).count(),
            1
        );
    }
}

mod siemens_vectors {
    use super::*;

    /// Three offsets of six decimals, each off by half a unit of the last [mm].
    const PRINTED_MM: f64 = 5e-6;
    /// Twelve decimals of two directions.
    const PRINTED: f64 = 5e-12;

    fn read(text: &str) -> BTreeMap<String, String> {
        text.lines()
            .filter(|line| !line.starts_with(';'))
            .map(|line| {
                let (name, value) = line.split_once('=').unwrap();
                (name.to_owned(), value.to_owned())
            })
            .collect()
    }

    /// Offsets base, joint, joint of the part, part, and both axis vectors, with the kind of chain.
    struct Chain {
        kind: u16,
        base: V,
        joint: V,
        joint_part: V,
        part: V,
        axes: [V; 2],
    }

    fn from_machine_data(text: &str) -> Chain {
        let read = read(text);
        let vector = |name: &str| {
            V::from_fn(|k, _| {
                read.get(&format!("$MC_TRAFO5_{name}_1[{k}]")).map_or(0.0, |v| v.parse().unwrap())
            })
        };
        Chain {
            kind: read["$MC_TRAFO_TYPE_1"].parse().unwrap(),
            base: vector("BASE_TOOL"),
            joint: vector("JOINT_OFFSET"),
            joint_part: vector("JOINT_OFFSET_PART"),
            part: vector("PART_OFFSET"),
            axes: [vector("AXIS1"), vector("AXIS2")],
        }
    }

    fn from_carrier(text: &str) -> Chain {
        let read = read(text);
        let vector =
            |first: usize| V::from_fn(|k, _| read[&format!("$TC_CARR{}[3]", first + k)].parse().unwrap());
        let [l1, l2, l3, l4] = [1, 4, 15, 18].map(vector);
        let axes = [7, 10].map(vector);
        let none = V::zeros();
        match read["$TC_CARR23[3]"].as_str() {
            "\"T\"" => {
                assert_eq!(l4, none);
                Chain { kind: 24, base: l3, joint: l2, joint_part: none, part: l1, axes }
            }
            "\"P\"" => {
                assert_eq!(l1, none);
                Chain { kind: 40, base: l2, joint: l3, joint_part: none, part: l4, axes }
            }
            "\"M\"" => Chain { kind: 56, base: l2, joint: l1, joint_part: l3, part: l4, axes },
            other => panic!("{other}"),
        }
    }

    impl Chain {
        /// Tip and tool axis in the workpiece; words in the order of the transformation.
        fn pose(&self, q: V, tool_mm: f64, words: [f64; 2]) -> (V, V) {
            let [r1, r2] = [0, 1].map(|k| move |v: V| turned(self.axes[k], words[k], v));
            let back2 = |v: V| turned(self.axes[1], -words[1], v);
            let back1 = |v: V| turned(self.axes[0], -words[0], v);
            let tool = V::z() * tool_mm;
            match self.kind {
                // what the control counts as position is the tip with all axes at zero
                24 => (q + tool - self.part - r1(self.joint + r2(self.base + tool)), r1(r2(V::z()))),
                40 => (back2(back1(q - self.base) - self.joint) - self.part, back2(back1(V::z()))),
                56 => {
                    let tip = q + tool - self.joint - r1(self.base + tool);
                    (back2(tip - self.joint_part) - self.part, back2(r1(V::z())))
                }
                other => panic!("{other}"),
            }
        }
    }

    #[test]
    fn give_the_transform_back_for_every_layout() {
        let mut next = stream(21);
        for preset in &PRESETS {
            let parts = MachineParts { squareness: Squareness::default(), ..measured(preset, &mut next) };
            let machine = Machine::new(parts).unwrap();
            let number = NonZeroU16::new(3).unwrap();
            let chains = [
                from_machine_data(&siemens(&machine, SiemensForm::MachineData)),
                from_carrier(&siemens(&machine, SiemensForm::ToolCarrier(number))),
            ];
            let axes = machine.rotary_axes();
            // of a mixed machine the head's axis is the first of the transformation
            let order =
                if axes[0].side == Side::Table && axes[1].side == Side::Head { [1, 0] } else { [0, 1] };
            let tool_length_mm = 80.0;
            let kinematics = Kinematics::new(&machine, &Setup { tool_length_mm, ..Setup::default() });
            for chain in chains {
                // closed to the last digit printed
                let sum = chain.base + chain.joint + chain.joint_part + chain.part;
                assert!(sum.norm() < 1e-9, "{}: {sum}", preset.id);
                for _ in 0..40 {
                    let joints = joints(&mut next);
                    let words = order.map(|k| axes[k].word_deg(joints.rotary_rad[k]).to_radians());
                    let (tip, axis) = chain.pose(joints.linear_mm, tool_length_mm, words);
                    let pose = kinematics.forward(&joints);
                    let off = (pose.tip_mm - tip).norm();
                    assert!(off < PRINTED_MM, "{}: {off}", preset.id);
                    assert!((pose.axis - axis).norm() < PRINTED, "{}", preset.id);
                }
            }
        }
    }

    #[test]
    fn are_reversed_for_axes_that_move_the_workpiece() {
        let text = siemens(&Machine::new(PRESETS[0].parts()).unwrap(), SiemensForm::MachineData);
        let chain = from_machine_data(&text);
        assert_eq!((chain.kind, chain.axes), (40, [-V::x(), -V::z()]));
        let text = siemens(
            &Machine::new(Preset::by_id("bc-head").unwrap().parts()).unwrap(),
            SiemensForm::MachineData,
        );
        let chain = from_machine_data(&text);
        assert_eq!((chain.kind, chain.axes), (24, [V::z(), V::y()]));
        assert!(!text.contains("-0.000000"));
    }
}
