//! Poses and joints, many at a time.

use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

use super::pieces::push_numbers;
use super::{Fault, FaultList, Fixed, PoseColumns, Unreadable, read_json};
use crate::description::{IntoParams, ToSchema};
use crate::geometry::Vec3;
use crate::kinematics::{Joints, Setup, ToolPose};
use crate::machine::{Machine, RotaryAxis, RotaryLetter};

/// Largest coordinate or linear word that is accepted (mm).
const MAX_COORDINATE_MM: f64 = 1e6;
/// Largest component of a tool axis before it is normalised.
const MAX_AXIS_COMPONENT: f64 = 1e6;
/// A tool axis shorter than this counts as a zero vector.
const MIN_AXIS_LENGTH: f64 = 1e-9;
/// For a shorter document the faster way is not faster \[bytes\].
const SMALL_BYTES: usize = 2048;
/// Largest rotary word that is accepted (deg).
const MAX_ROTARY_DEG: f64 = Machine::MAX_TRAVEL_DEG;

/// A tool pose in the workpiece: tip in mm, tool axis from the tip into the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// X of the tip.
    pub x: f64,
    /// Y of the tip.
    pub y: f64,
    /// Z of the tip.
    pub z: f64,
    /// X component of the tool axis.
    pub i: f64,
    /// Y component of the tool axis.
    pub j: f64,
    /// Z component of the tool axis.
    pub k: f64,
}

/// Rotary words.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "UPPERCASE")]
pub struct RotaryWords {
    /// A word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a: Option<f64>,
    /// B word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub b: Option<f64>,
    /// C word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c: Option<f64>,
}

/// Axis words: mm for X Y Z, degrees for the two rotary axes of the machine (out of A B C).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[expect(non_snake_case, reason = "NC words go by their letters")]
pub struct JointWords {
    /// X word.
    pub X: f64,
    /// Y word.
    pub Y: f64,
    /// Z word.
    pub Z: f64,
    /// A word, on a machine that has A.
    #[serde(default)]
    pub A: Option<f64>,
    /// B word, on a machine that has B.
    #[serde(default)]
    pub B: Option<f64>,
    /// C word, on a machine that has C.
    #[serde(default)]
    pub C: Option<f64>,
    /// How well the rotary axes can turn the tool at this pose: 1 is best, 0 is at the pole or at the reach
    /// limit. The service returns it and ignores it in a request.
    #[serde(default)]
    pub conditioning: Option<f64>,
}

impl Serialize for JointWords {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("X", &self.X)?;
        map.serialize_entry("Y", &self.Y)?;
        map.serialize_entry("Z", &self.Z)?;
        for (name, word) in [("A", self.A), ("B", self.B), ("C", self.C), ("conditioning", self.conditioning)]
        {
            if let Some(word) = word {
                map.serialize_entry(name, &word)?;
            }
        }
        map.end()
    }
}

/// Which solutions the answer contains.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Selection {
    /// One solution for each pose, so that the whole path has the fewest rewinds and then the least rotary
    /// travel.
    #[default]
    Path,
    /// Every solution, for each pose separately.
    All,
}

/// Whether measured errors of the machine are applied.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LocationErrors {
    /// Location errors and squareness are applied.
    #[default]
    Apply,
    /// The machine is treated as nominal.
    Ignore,
}

/// Options of both directions; query parameters if the body is CSV.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub struct KinematicsOptions {
    /// Origin of the workpiece in machine coordinates at zero pose.
    #[param(value_type = [f64], style = Form, explode = false, example = json!([0.0, 0.0, 0.0]))]
    pub work_offset_mm: Fixed<3>,
    /// Tool length, added along the zero-pose tool axis; it matters only for head axes.
    pub tool_length_mm: f64,
    /// Which solutions the answer contains (inverse only).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[param(inline)]
    pub selection: Option<Selection>,
    /// Rotary words before the first pose, one query parameter for each: `start.A`, `start.C` (inverse only).
    #[param(inline)]
    pub start: Option<RotaryWords>,
    /// Whether measured errors of the machine are applied.
    #[param(inline)]
    pub location_errors: LocationErrors,
}

/// Poses to turn into axis words.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct InverseRequest {
    /// Tool poses in the workpiece.
    #[schema(value_type = Vec<Pose>)]
    pub poses: PoseColumns,
    /// Origin of the workpiece in machine coordinates at zero pose.
    #[serde(default)]
    pub work_offset_mm: Fixed<3>,
    /// Tool length, added along the zero-pose tool axis; it matters only for head axes.
    #[serde(default)]
    pub tool_length_mm: f64,
    /// Which solutions the answer contains.
    #[serde(default)]
    pub selection: Selection,
    /// Rotary words before the first pose.
    #[serde(default)]
    pub start: Option<RotaryWords>,
    /// Whether measured errors of the machine are applied.
    #[serde(default)]
    pub location_errors: LocationErrors,
}

/// Axis words to turn into poses.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ForwardRequest {
    /// Axis words.
    pub joints: Vec<JointWords>,
    /// Origin of the workpiece in machine coordinates at zero pose.
    #[serde(default)]
    pub work_offset_mm: Fixed<3>,
    /// Tool length, added along the zero-pose tool axis; it matters only for head axes.
    #[serde(default)]
    pub tool_length_mm: f64,
    /// Whether measured errors of the machine are applied.
    #[serde(default)]
    pub location_errors: LocationErrors,
}

/// The kind of a warning about a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PoseWarningKind {
    /// A rotary axis turns by more than 120° to reach this pose.
    Rewind,
    /// The rotary axis next to the workpiece is held inside the cone around the pole.
    PoleHold,
    /// The pose is at the limit of the directions that the rotary axes can reach.
    ReachLimit,
}

/// A warning about one pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PoseWarning {
    /// Index of the pose, from 0.
    pub pose: usize,
    /// Kind of the warning.
    pub kind: PoseWarningKind,
    /// Angle between the requested tool axis and the one that was reached.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_residual_urad: Option<f64>,
}

impl KinematicsOptions {
    /// The set-up, and the start words in the profile's order.
    ///
    /// # Errors
    /// Every bad value, with its pointer.
    pub fn to_setup(&self, machine: &Machine) -> Result<(Setup, Option<[f64; 2]>), Vec<Fault>> {
        let mut faults = FaultList::default();
        let setup = self.setup(&mut faults);
        let start = self.start.map(|start| start.in_profile_order(machine, "/start", &mut faults));
        faults.into_result()?;
        Ok((setup, start))
    }

    /// The set-up alone; this check needs no machine. Faults are added to `faults`.
    pub(super) fn setup(&self, faults: &mut FaultList) -> Setup {
        for (index, offset_mm) in self.work_offset_mm.0.into_iter().enumerate() {
            let at = || format!("/work_offset_mm/{index}");
            faults.check_range(at, offset_mm, -MAX_COORDINATE_MM, MAX_COORDINATE_MM);
        }
        let at = || "/tool_length_mm".to_owned();
        faults.check_range(at, self.tool_length_mm, -MAX_COORDINATE_MM, MAX_COORDINATE_MM);
        Setup {
            work_offset_mm: Vec3::from(self.work_offset_mm.0),
            tool_length_mm: self.tool_length_mm,
            apply_errors: self.location_errors == LocationErrors::Apply,
        }
    }
}

impl InverseRequest {
    /// Reads the document: [`read_json`] with a faster way through the poses.
    ///
    /// # Errors
    /// The first fault.
    pub fn read(text: &[u8]) -> Result<Self, Unreadable> {
        if text.len() < SMALL_BYTES {
            return read_json(text);
        }
        Self::read_poses_apart(text).map_or_else(|| read_json(text), Ok)
    }

    /// Reads the list of poses by [`PoseColumns::read_elements`], and the text around it by serde, with an empty list
    /// in its place. Serde refuses this text if the list is at any other place than the document's own: members of
    /// nested objects are known, and after a string comes no `:`. `None` if serde has to read the whole text.
    fn read_poses_apart(text: &[u8]) -> Option<Self> {
        const NAME: &[u8] = b"\"poses\"";
        let mut begin = memchr::memmem::find(text, NAME)? + NAME.len();
        for wanted in [b':', b'['] {
            let blanks = text.get(begin..)?.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            begin += blanks;
            (*text.get(begin)? == wanted).then_some(())?;
            begin += 1;
        }
        let (poses, length) = PoseColumns::read_elements(text.get(begin..)?)?;
        let around = [text.get(..begin)?, b"]", text.get(begin + length..)?].concat();
        Some(Self { poses, ..read_json(&around).ok()? })
    }

    /// The options apart from the poses.
    #[must_use]
    pub fn options(&self) -> KinematicsOptions {
        KinematicsOptions {
            work_offset_mm: self.work_offset_mm,
            tool_length_mm: self.tool_length_mm,
            selection: Some(self.selection),
            start: self.start,
            location_errors: self.location_errors,
        }
    }
}

impl ForwardRequest {
    /// The options apart from the joints.
    #[must_use]
    pub fn options(&self) -> KinematicsOptions {
        KinematicsOptions {
            work_offset_mm: self.work_offset_mm,
            tool_length_mm: self.tool_length_mm,
            selection: None,
            start: None,
            location_errors: self.location_errors,
        }
    }
}

impl Pose {
    /// The pose with its axis normalised; faults are added to `faults` under `/poses/{index}`.
    pub fn to_core(&self, index: usize, faults: &mut FaultList) -> Option<ToolPose> {
        let tip = [self.x, self.y, self.z];
        let axis = [self.i, self.j, self.k];
        let axis_vector = Vec3::from(axis);
        let length = axis_vector.norm();
        let sound = tip.iter().all(|value| value.abs() <= MAX_COORDINATE_MM)
            && axis.iter().all(|value| value.abs() <= MAX_AXIS_COMPONENT)
            && length >= MIN_AXIS_LENGTH;
        if sound {
            return Some(ToolPose { tip_mm: Vec3::from(tip), axis: axis_vector / length });
        }
        for (name, value) in ["x", "y", "z"].into_iter().zip(tip) {
            faults.check_range(
                || format!("/poses/{index}/{name}"),
                value,
                -MAX_COORDINATE_MM,
                MAX_COORDINATE_MM,
            );
        }
        for (name, value) in ["i", "j", "k"].into_iter().zip(axis) {
            faults.check_range(
                || format!("/poses/{index}/{name}"),
                value,
                -MAX_AXIS_COMPONENT,
                MAX_AXIS_COMPONENT,
            );
        }
        if length < MIN_AXIS_LENGTH {
            faults.push(|| {
                Fault::new(
                    format!("/poses/{index}"),
                    "i j k is a zero vector; give the direction of the tool axis",
                )
            });
        }
        None
    }
}

impl From<ToolPose> for Pose {
    fn from(pose: ToolPose) -> Self {
        let ToolPose { tip_mm: tip, axis } = pose;
        Self { x: tip.x, y: tip.y, z: tip.z, i: axis.x, j: axis.y, k: axis.z }
    }
}

impl RotaryWords {
    pub(super) fn in_profile_order(
        &self,
        machine: &Machine,
        pointer: &str,
        faults: &mut FaultList,
    ) -> [f64; 2] {
        let words = [('A', self.a), ('B', self.b), ('C', self.c)];
        for (letter, word) in words {
            let has = machine.rotary_axes().iter().any(|axis| axis.letter.as_char() == letter);
            match word {
                Some(word) if has => {
                    faults.check_range(
                        || format!("{pointer}/{letter}"),
                        word,
                        -MAX_ROTARY_DEG,
                        MAX_ROTARY_DEG,
                    );
                }
                Some(_) => faults.push(|| {
                    Fault::new(format!("{pointer}/{letter}"), format!("the machine has no axis {letter}"))
                }),
                None if has => faults.push(|| {
                    Fault::new(format!("{pointer}/{letter}"), format!("the word of axis {letter} is missing"))
                }),
                None => {}
            }
        }
        machine.rotary_axes().each_ref().map(|axis| match axis.letter {
            RotaryLetter::A => self.a.unwrap_or(0.0),
            RotaryLetter::B => self.b.unwrap_or(0.0),
            RotaryLetter::C => self.c.unwrap_or(0.0),
        })
    }
}

impl JointWords {
    /// The joints without the control's sense of rotation; faults are added to `faults` under
    /// `/joints/{index}`.
    pub fn to_core(&self, machine: &Machine, index: usize, faults: &mut FaultList) -> Option<Joints> {
        let linear = [self.X, self.Y, self.Z];
        let mut rotary_rad = [0.0; 2];
        let mut given = 0;
        let mut sound = linear.iter().all(|value| value.abs() <= MAX_COORDINATE_MM);
        for (angle_rad, axis) in rotary_rad.iter_mut().zip(machine.rotary_axes()) {
            match self.rotary(axis.letter) {
                Some(word) if word.abs() <= MAX_ROTARY_DEG => {
                    *angle_rad = axis.angle_rad(word);
                    given += 1;
                }
                _ => sound = false,
            }
        }
        let words = [self.A, self.B, self.C].iter().flatten().count();
        if sound && given == words {
            return Some(Joints { linear_mm: Vec3::from(linear), rotary_rad });
        }
        for (name, value) in ["X", "Y", "Z"].into_iter().zip(linear) {
            faults.check_range(
                || format!("/joints/{index}/{name}"),
                value,
                -MAX_COORDINATE_MM,
                MAX_COORDINATE_MM,
            );
        }
        let words = RotaryWords { a: self.A, b: self.B, c: self.C };
        words.in_profile_order(machine, &format!("/joints/{index}"), faults);
        None
    }

    /// The words of `joints` on `machine`.
    #[must_use]
    pub fn from_core(machine: &Machine, joints: &Joints, conditioning: Option<f64>) -> Self {
        Self::of_axes(machine.rotary_axes(), joints, conditioning)
    }

    /// The same with the rotary axes of the machine.
    #[inline]
    pub(super) fn of_axes(axes: &[RotaryAxis; 2], joints: &Joints, conditioning: Option<f64>) -> Self {
        let mut words = Self {
            X: joints.linear_mm.x,
            Y: joints.linear_mm.y,
            Z: joints.linear_mm.z,
            A: None,
            B: None,
            C: None,
            conditioning,
        };
        for (axis, angle_rad) in axes.iter().zip(joints.rotary_rad) {
            let word = Some(axis.word_deg(angle_rad));
            match axis.letter {
                RotaryLetter::A => words.A = word,
                RotaryLetter::B => words.B = word,
                RotaryLetter::C => words.C = word,
            }
        }
        words
    }

    /// Appends the words as a JSON object: the same bytes as serde writes, with fewer copies.
    #[inline]
    pub(super) fn write_json(&self, out: &mut Vec<u8>) {
        push_numbers(
            out,
            [
                ("{\"X\":", Some(self.X)),
                (",\"Y\":", Some(self.Y)),
                (",\"Z\":", Some(self.Z)),
                (",\"A\":", self.A),
                (",\"B\":", self.B),
                (",\"C\":", self.C),
                (",\"conditioning\":", self.conditioning),
            ],
        );
        out.push(b'}');
    }

    /// The word of one rotary axis.
    #[must_use]
    pub fn rotary(&self, letter: RotaryLetter) -> Option<f64> {
        match letter {
            RotaryLetter::A => self.A,
            RotaryLetter::B => self.B,
            RotaryLetter::C => self.C,
        }
    }
}
