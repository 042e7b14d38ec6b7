//! The paths of a servo simulation, as clients name them.

mod members;

use serde::{Deserialize, Serialize};

use super::{Dialect, Fault, FaultList, Fixed, Interpolation, ProgramUnit, StartWords, WorkOffsets};
use crate::description::ToSchema;
use crate::geometry::Vec3;
use crate::kinematics::ToolPose;
use crate::machine::{Machine, RotaryLetter};
use crate::servo::{AxisLetter, Circle, ToolPath};

/// A linear axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[expect(missing_docs, reason = "the letters say it")]
pub enum LinearLetter {
    X,
    Y,
    Z,
}

/// A plane that gives the contour error a sign: positive to the right of travel, seen from the plane's
/// normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// Seen from +Z.
    Xy,
    /// Seen from +X.
    Yz,
    /// Seen from +Y.
    Zx,
}

impl Plane {
    /// The plane's normal in W.
    #[must_use]
    pub fn normal(self) -> Vec3 {
        match self {
            Self::Xy => Vec3::z(),
            Self::Yz => Vec3::x(),
            Self::Zx => Vec3::y(),
        }
    }
}

/// A corner of a polyline: the tip (mm) and the tool axis, which is +Z if it is not given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PolylinePoint {
    /// X of the tip.
    pub x: f64,
    /// Y of the tip.
    pub y: f64,
    /// Z of the tip.
    pub z: f64,
    /// X component of the tool axis; give i j k together or leave out all three.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub i: Option<f64>,
    /// Y component of the tool axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub j: Option<f64>,
    /// Z component of the tool axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<f64>,
}

/// First and last rotary words (deg).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "UPPERCASE")]
pub struct RotarySweep {
    /// Words of A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<[f64; 2]>)]
    pub a: Option<Fixed<2>>,
    /// Words of B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<[f64; 2]>)]
    pub b: Option<Fixed<2>>,
    /// Words of C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<[f64; 2]>)]
    pub c: Option<Fixed<2>>,
}

/// The path that the axes are commanded to follow. All kinds except the two circles need a machine with
/// drives.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ServoPathDoc {
    /// X and C make a circle about `(center_x_mm, 0)` on the table.
    XcCircle {
        /// Radius of the circle.
        #[schema(example = 60.0)]
        radius_mm: f64,
        /// Distance of the centre from the C axis. It must differ from the radius, or the circle would run
        /// through the axis.
        #[schema(example = 100.0)]
        center_x_mm: f64,
    },
    /// Two linear axes make a circle, from the first axis towards the second.
    Circle {
        /// Two different axes.
        #[schema(min_items = 2, max_items = 2)]
        axes: [LinearLetter; 2],
        /// Radius of the circle.
        radius_mm: f64,
    },
    /// The bottom edge of a cone frustum, flank-milled: the tip is on a circle, the tool axis along the
    /// generatrix.
    ConeFrustum {
        /// Centre of the bottom circle in the workpiece.
        #[serde(default)]
        center_mm: Fixed<3>,
        /// Radius of the bottom circle.
        radius_mm: f64,
        /// Angle between generatrix and cone axis.
        half_apex_deg: f64,
        /// Tilt of the cone axis out of Z, about Y.
        #[serde(default)]
        tilt_deg: f64,
    },
    /// The tip rests on the workpiece while rotary axes go from one word to another and back. The feed then
    /// counts degrees per minute, along both axes together.
    TipHold {
        /// The tip in the workpiece.
        tip_mm: Fixed<3>,
        /// First and last words of the rotary axes; an axis that is not named stays at 0.
        sweep_deg: RotarySweep,
    },
    /// A program on its machine; the run is stored as a job. Post a larger program as a file to
    /// `/v1/machines/{machine_id}/servo-simulation`.
    Program {
        /// The program.
        text: String,
        /// File name of the program.
        #[serde(default)]
        file_name: Option<String>,
        /// Interpolation of the control. If it is absent, the program decides.
        #[serde(default)]
        interpolation: Option<Interpolation>,
        /// Unit of the lengths if the program does not state one. If it is absent, the machine's
        /// `program_unit` is used.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        unit: Option<ProgramUnit>,
        /// Origins of the work offsets that the program names.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        work_offsets_mm: Option<WorkOffsets>,
        /// Number of the tool to simulate, if the program has several.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        tool_number: Option<u32>,
        /// Positions before the first block, as words in the program's first work offset.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start: Option<StartWords>,
        /// Dialect of the text.
        #[serde(default)]
        dialect: Dialect,
        /// Plane that gives the contour error a sign.
        #[serde(default)]
        plane: Option<Plane>,
    },
    /// Straight lines of the tip; the tool axis turns along great circles.
    Polyline {
        /// At least two corners.
        points: Vec<PolylinePoint>,
        /// Plane that gives the contour error a sign.
        #[serde(default)]
        plane: Option<Plane>,
    },
}

/// A path in the core's terms.
#[derive(Debug, Clone, PartialEq)]
pub enum CorePath {
    /// Two axes make the path by themselves.
    Circle(Circle),
    /// The whole machine makes the path.
    Tool {
        /// The path.
        path: ToolPath,
        /// Normal of the plane that gives the contour error a sign.
        plane_normal: Option<Vec3>,
    },
}

/// Accepted radii \[mm\].
const RADIUS_RANGE_MM: [f64; 2] = [1e-3, 1e5];
/// Accepted coordinates \[mm\].
const MAX_COORDINATE_MM: f64 = 1e6;
/// Most corners of a polyline; longer ones should be programs.
const MAX_POINTS: usize = 100_000;

impl ServoPathDoc {
    /// Radius of a circle of two axes \[mm\].
    #[must_use]
    pub const fn circle_radius_mm(&self) -> Option<f64> {
        match self {
            Self::XcCircle { radius_mm, .. } | Self::Circle { radius_mm, .. } => Some(*radius_mm),
            _ => None,
        }
    }

    /// A short title with the path's numbers.
    #[must_use]
    pub fn title(&self) -> String {
        match self {
            Self::XcCircle { radius_mm, center_x_mm } => {
                format!("XC circle, r = {radius_mm} mm about x = {center_x_mm} mm")
            }
            Self::Circle { axes: [first, second], radius_mm } => {
                format!("{first:?}{second:?} circle, r = {radius_mm} mm")
            }
            Self::ConeFrustum { radius_mm, half_apex_deg, tilt_deg, .. } => {
                format!("Cone frustum, r = {radius_mm} mm, half apex {half_apex_deg}°, tilted by {tilt_deg}°")
            }
            Self::TipHold { tip_mm: Fixed([x, y, z]), .. } => format!("Tip held at {x} {y} {z} mm"),
            Self::Polyline { points, .. } => format!("Polyline of {} points", points.len()),
            Self::Program { file_name, .. } => file_name.clone().unwrap_or_else(|| "Program".to_owned()),
        }
    }

    /// Unit of the path's feed.
    #[must_use]
    pub const fn feed_unit(&self) -> &'static str {
        if matches!(self, Self::TipHold { .. }) { "deg/min" } else { "mm/min" }
    }

    /// Whether the path needs the machine's kinematics.
    #[must_use]
    pub const fn needs_machine(&self) -> bool {
        !matches!(self, Self::XcCircle { .. } | Self::Circle { .. })
    }

    /// Whether the path can be run in laps.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        !matches!(self, Self::Polyline { .. } | Self::Program { .. })
    }

    /// Normal of the plane that gives the contour error a sign.
    fn plane_normal(&self) -> Option<Vec3> {
        match self {
            Self::Polyline { plane, .. } => plane.map(Plane::normal),
            _ => None,
        }
    }

    /// The path; faults are added to `faults` under `/path`.
    pub(super) fn to_core(&self, machine: Option<&Machine>, faults: &mut FaultList) -> Option<CorePath> {
        let radius = |radius_mm: f64, faults: &mut FaultList| {
            let [min, max] = RADIUS_RANGE_MM;
            faults.check_range(|| "/path/radius_mm".to_owned(), radius_mm, min, max);
        };
        let tool = |path: ToolPath| CorePath::Tool { path, plane_normal: self.plane_normal() };
        Some(match self {
            Self::XcCircle { radius_mm, center_x_mm } => {
                radius(*radius_mm, faults);
                let at = || "/path/center_x_mm".to_owned();
                faults.check_range(at, *center_x_mm, -MAX_COORDINATE_MM, MAX_COORDINATE_MM);
                CorePath::Circle(Circle::XC { radius_mm: *radius_mm, center_x_mm: *center_x_mm })
            }
            Self::Circle { axes: [first, second], radius_mm } => {
                radius(*radius_mm, faults);
                if first == second {
                    faults.push(|| Fault::new("/path/axes", "a circle needs two different axes"));
                }
                let axes = [first, second].map(|axis| match axis {
                    LinearLetter::X => AxisLetter::X,
                    LinearLetter::Y => AxisLetter::Y,
                    LinearLetter::Z => AxisLetter::Z,
                });
                CorePath::Circle(Circle::Linear { axes, radius_mm: *radius_mm })
            }
            Self::ConeFrustum { center_mm, radius_mm, half_apex_deg, tilt_deg } => {
                radius(*radius_mm, faults);
                check_point(center_mm.0, "/path/center_mm", faults);
                faults.check_range(|| "/path/half_apex_deg".to_owned(), *half_apex_deg, 0.0, 89.0);
                faults.check_range(|| "/path/tilt_deg".to_owned(), *tilt_deg, -180.0, 180.0);
                tool(ToolPath::ConeFrustum {
                    center_mm: Vec3::from(center_mm.0),
                    radius_mm: *radius_mm,
                    half_apex_rad: half_apex_deg.to_radians(),
                    tilt_rad: tilt_deg.to_radians(),
                })
            }
            Self::TipHold { tip_mm, sweep_deg } => {
                check_point(tip_mm.0, "/path/tip_mm", faults);
                let rotary_rad = sweep_deg.rotary_rad(machine, faults)?;
                tool(ToolPath::TipHold { tip_mm: Vec3::from(tip_mm.0), rotary_rad })
            }
            Self::Program { .. } => {
                faults.push(|| Fault::new("/path/kind", "only servo-simulations accept a program"));
                return None;
            }
            Self::Polyline { points, .. } => {
                if !(2..=MAX_POINTS).contains(&points.len()) {
                    let detail = format!("a polyline has 2 to {MAX_POINTS} points, not {}", points.len());
                    faults.push(|| Fault::new("/path/points", detail));
                }
                let poses = points.iter().enumerate().map(|(index, point)| point.to_core(index, faults));
                tool(ToolPath::Polyline { poses: poses.collect() })
            }
        })
    }
}

fn check_point(point_mm: [f64; 3], pointer: &str, faults: &mut FaultList) {
    for (index, value) in point_mm.into_iter().enumerate() {
        faults.check_range(|| format!("{pointer}/{index}"), value, -MAX_COORDINATE_MM, MAX_COORDINATE_MM);
    }
}

impl PolylinePoint {
    fn to_core(self, index: usize, faults: &mut FaultList) -> ToolPose {
        let pointer = format!("/path/points/{index}");
        for (name, value) in [("x", self.x), ("y", self.y), ("z", self.z)] {
            faults.check_range(|| format!("{pointer}/{name}"), value, -MAX_COORDINATE_MM, MAX_COORDINATE_MM);
        }
        let axis = match (self.i, self.j, self.k) {
            (None, None, None) => Vec3::z(),
            (Some(i), Some(j), Some(k)) => {
                let unit = Vec3::new(i, j, k).try_normalize(1e-9);
                unit.filter(|unit| unit.iter().all(|value| value.is_finite())).unwrap_or_else(|| {
                    faults.push(|| {
                        Fault::new(
                            pointer.clone(),
                            "i j k is a zero vector; give the direction of the tool axis",
                        )
                    });
                    Vec3::z()
                })
            }
            _ => {
                faults.push(|| Fault::new(pointer.clone(), "give i j k together, or leave out all three"));
                Vec3::z()
            }
        };
        ToolPose { tip_mm: Vec3::new(self.x, self.y, self.z), axis }
    }
}

impl RotarySweep {
    /// Kinematic angles at both ends, in the profile's order \[rad\]. Without a machine only the numbers are
    /// checked.
    fn rotary_rad(&self, machine: Option<&Machine>, faults: &mut FaultList) -> Option<[[f64; 2]; 2]> {
        let words = [('A', self.a), ('B', self.b), ('C', self.c)];
        for (letter, word) in words {
            let Some(Fixed(ends)) = word else { continue };
            let pointer = format!("/path/sweep_deg/{letter}");
            let has =
                |machine: &Machine| machine.rotary_axes().iter().any(|axis| axis.letter.as_char() == letter);
            if !machine.is_none_or(has) {
                faults.push(|| Fault::new(&*pointer, format!("the machine has no axis {letter}")));
            }
            for (index, end) in ends.into_iter().enumerate() {
                let max = Machine::MAX_TRAVEL_DEG;
                faults.check_range(|| format!("{pointer}/{index}"), end, -max, max);
            }
        }
        let machine = machine?;
        let of = |end: usize| {
            machine.rotary_axes().each_ref().map(|axis| {
                let word = match axis.letter {
                    RotaryLetter::A => self.a,
                    RotaryLetter::B => self.b,
                    RotaryLetter::C => self.c,
                };
                axis.angle_rad(word.map_or(0.0, |Fixed(ends)| ends[end]))
            })
        };
        Some([of(0), of(1)])
    }
}
