//! The candidates of poses against the chain of screws in numbers of twice the digits: at random, near the pole and the
//! reach limits, and at the ends of travels.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use trunnion::geometry::Vec3;
use trunnion::kinematics::{Joints, Kinematics, Setup, ToolPose};
use trunnion::machine::{LocationError, Machine, PRESETS, Preset, Side};

use crate::double_double::Double2;

/// Largest angle between the axis of a pose and that of its joints \[rad\]: two arc tangents, a sum and the words in
/// degrees, each below 4.5e-16.
const AXIS_RAD: f64 = 1.8e-15;
/// Closer than this to a reach limit \[rad\] both solutions are one, exactly at the limit.
const MERGED_RAD: f64 = 1e-13;
/// Largest distance of the tip of the joints from that of the pose, as a part of the lengths that turn: a dozen
/// roundings of 1.1e-16, which do not all have the same direction.
const TIP: f64 = 5e-16;

type Vec2fold = [Double2; 3];

fn exactly(v: Vec3) -> Vec2fold {
    [v.x, v.y, v.z].map(Double2::from)
}

fn plus(a: Vec2fold, b: Vec2fold) -> Vec2fold {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn times(a: Vec2fold, factor: Double2) -> Vec2fold {
    a.map(|component| component * factor)
}

fn minus(a: Vec2fold, b: Vec2fold) -> Vec2fold {
    plus(a, b.map(|component| -component))
}

fn dot(a: Vec2fold, b: Vec2fold) -> Double2 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec2fold, b: Vec2fold) -> Vec2fold {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: Vec2fold) -> Vec2fold {
    let length = dot(v, v).sqrt();
    v.map(|component| component / length)
}

fn length(v: Vec2fold) -> f64 {
    v[0].0.hypot(v[1].0).hypot(v[2].0)
}

/// Sine and cosine by their series, for |angle| up to a turn.
fn sin_cos(angle: Double2) -> [Double2; 2] {
    let mut sums = [Double2::from(0.0), Double2::from(1.0)];
    let mut term = Double2::from(1.0);
    for n in 1..60 {
        term = term * angle / Double2::from(f64::from(n));
        let signed = if n % 4 < 2 { term } else { -term };
        let sum = &mut sums[usize::from(n % 2 == 0)];
        *sum = *sum + signed;
    }
    sums
}

/// A line and the angle about it.
struct Turn {
    direction: Vec2fold,
    point_mm: Vec2fold,
    sin_cos: [Double2; 2],
}

impl Turn {
    fn of(&self, v: Vec2fold) -> Vec2fold {
        let [sin, cos] = self.sin_cos;
        let along = times(self.direction, dot(self.direction, v));
        plus(plus(along, times(minus(v, along), cos)), times(cross(self.direction, v), sin))
    }

    fn carry(&self, p: Vec2fold) -> Vec2fold {
        plus(self.of(minus(p, self.point_mm)), self.point_mm)
    }
}

/// Tip \[mm\] and axis at these joints: `w = E_t⁻¹(S q + o + E_h·0) − o`, `t = R_t⁻¹ R_h t0`.
fn forward(machine: &Machine, setup: &Setup, joints: &Joints) -> [Vec2fold; 2] {
    let screws = machine.screws(true);
    let axes = machine.rotary_axes();
    let [u, v] = machine.workpiece_to_tool().map(|index| {
        let longer = if axes[index].side == Side::Head { setup.tool_length_mm } else { 0.0 };
        Turn {
            direction: unit(exactly(screws[index].direction)),
            point_mm: exactly(screws[index].point_mm + Machine::TOOL_AXIS * longer),
            sin_cos: sin_cos(Double2::from(joints.rotary_rad[index])),
        }
    });
    let heads = axes.iter().filter(|axis| axis.side == Side::Head).count();
    let offset = exactly(setup.work_offset_mm);
    let columns = machine.squareness().matrix();
    let linear = (0..3).fold(offset, |sum, k| {
        plus(sum, times(exactly(columns.column(k).into_owned()), Double2::from(joints.linear_mm[k])))
    });
    let mut p = [Double2::from(0.0); 3];
    for (stage, turn) in [&v, &u].into_iter().enumerate() {
        if stage == heads {
            p = plus(p, linear);
        }
        p = turn.carry(p);
    }
    if heads == 2 {
        p = plus(p, linear);
    }
    [minus(p, offset), u.of(v.of(exactly(Machine::TOOL_AXIS)))]
}

/// A repeatable stream of numbers in [−1, 1).
fn stream() -> impl FnMut() -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64) * 2.0_f64.powi(-52) - 1.0
    }
}

fn calibrated(preset: &Preset) -> Machine {
    let mut parts = preset.parts();
    for (axis, sign) in parts.rotary_axes.iter_mut().zip([1.0, -1.0]) {
        axis.point_mm += Vec3::new(0.3, -0.2, 0.7) * sign;
        axis.location_error = LocationError {
            translation_mm: Vec3::new(0.012, -0.021, 0.034) * sign,
            rotation_rad: Vec3::new(41e-6, -63e-6, 29e-6),
        };
    }
    parts.linear_travel_mm = [None; 3];
    parts.squareness.e_c0y_rad = 20e-6;
    Machine::new(parts).unwrap()
}

#[test]
fn candidates_keep_their_bounds_in_twice_the_digits() {
    let mut next = stream();
    let setup =
        Setup { work_offset_mm: Vec3::new(70.0, -40.0, 95.0), tool_length_mm: 120.0, ..Setup::default() };
    for preset in &PRESETS {
        let machine = calibrated(preset);
        let kinematics = Kinematics::new(&machine, &setup);
        let [u, v] = machine.workpiece_to_tool();
        let points_mm: f64 = machine.screws(true).iter().map(|screw| screw.point_mm.norm()).sum();
        let mut solved = 0;
        for n in 0..200 {
            let mut rotary_rad = [std::f64::consts::PI * next(), std::f64::consts::PI * next()];
            let near = 10.0_f64.powf(-1.0 - 3.0 * next().abs()) * next();
            rotary_rad[v] = match n % 4 {
                1 => near,
                2 => std::f64::consts::PI + near,
                _ => rotary_rad[v],
            };
            if n % 4 == 3 {
                for k in [u, v] {
                    let axis = &machine.rotary_axes()[k];
                    let Some(travel) = axis.travel_deg else { continue };
                    let end_deg = if next() < 0.0 { travel.min } else { travel.max };
                    let sense = if axis.reversed { -1.0 } else { 1.0 };
                    rotary_rad[k] = sense * end_deg.to_radians();
                }
            }
            let axis = kinematics.axis(rotary_rad).normalize();
            let pose = ToolPose { tip_mm: Vec3::new(500.0 * next(), 500.0 * next(), 300.0 * next()), axis };
            let Ok(candidates) = kinematics.candidates(0, &pose, 0.0) else { continue };
            let longest_mm = pose.tip_mm.norm() + setup.work_offset_mm.norm() + points_mm + 120.0;
            for candidate in candidates {
                let [tip_mm, axis] = forward(&machine, &setup, &candidate.joints);
                let miss = length(cross(axis, unit(exactly(pose.axis))));
                let merged = if candidate.conditioning == 0.0 { MERGED_RAD } else { 0.0 };
                assert!(miss <= AXIS_RAD + merged, "{} {n}: {miss} rad", preset.id);
                let off = length(minus(tip_mm, exactly(pose.tip_mm))) / longest_mm;
                assert!(off <= TIP, "{} {n}: {off} of {longest_mm} mm", preset.id);
                solved += 1;
            }
        }
        assert!(solved >= 100, "{}: only {solved}", preset.id);
    }
}
