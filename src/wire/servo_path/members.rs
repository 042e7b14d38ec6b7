//! How a servo path is read: the members of all its kinds at once.

use serde::de::Error;
use serde::{Deserialize, Deserializer};

use super::{LinearLetter, Plane, PolylinePoint, RotarySweep, ServoPathDoc};
use crate::wire::{Dialect, Fixed, Interpolation, ProgramUnit, StartWords, WorkOffsets};

impl<'de> Deserialize<'de> for ServoPathDoc {
    /// Reads all members at once: a tagged enum would be buffered, and its faults would lose their location.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Members::deserialize(deserializer)?.into_path()
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    XcCircle,
    Circle,
    ConeFrustum,
    TipHold,
    Program,
    Polyline,
}

/// Exactly two axes, so that a third axis is a wrong value and not broken JSON.
#[derive(Debug)]
struct TwoAxes([LinearLetter; 2]);

impl<'de> Deserialize<'de> for TwoAxes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let letters = Vec::<LinearLetter>::deserialize(deserializer)?;
        let count = letters.len();
        let two = letters.try_into().map_err(|_all| D::Error::invalid_length(count, &"an array of 2 axes"));
        two.map(Self)
    }
}

/// The members of every kind of path.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Members {
    kind: Kind,
    radius_mm: Option<f64>,
    center_x_mm: Option<f64>,
    axes: Option<TwoAxes>,
    #[serde(default, deserialize_with = "stated")]
    center_mm: Option<Fixed<3>>,
    half_apex_deg: Option<f64>,
    #[serde(default, deserialize_with = "stated")]
    tilt_deg: Option<f64>,
    tip_mm: Option<Fixed<3>>,
    sweep_deg: Option<RotarySweep>,
    points: Option<Vec<PolylinePoint>>,
    plane: Option<Plane>,
    text: Option<String>,
    file_name: Option<String>,
    interpolation: Option<Interpolation>,
    unit: Option<ProgramUnit>,
    work_offsets_mm: Option<WorkOffsets>,
    tool_number: Option<u32>,
    start: Option<StartWords>,
    #[serde(default, deserialize_with = "stated")]
    dialect: Option<Dialect>,
}

/// A member that may be left out, but must not be null.
fn stated<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

fn needed<T, E: Error>(member: &mut Option<T>, name: &'static str) -> Result<T, E> {
    member.take().ok_or_else(|| E::missing_field(name))
}

impl Members {
    fn into_path<E: Error>(mut self) -> Result<ServoPathDoc, E> {
        let path = match self.kind {
            Kind::XcCircle => ServoPathDoc::XcCircle {
                radius_mm: needed(&mut self.radius_mm, "radius_mm")?,
                center_x_mm: needed(&mut self.center_x_mm, "center_x_mm")?,
            },
            Kind::Circle => ServoPathDoc::Circle {
                axes: needed(&mut self.axes, "axes")?.0,
                radius_mm: needed(&mut self.radius_mm, "radius_mm")?,
            },
            Kind::ConeFrustum => ServoPathDoc::ConeFrustum {
                center_mm: self.center_mm.take().unwrap_or_default(),
                radius_mm: needed(&mut self.radius_mm, "radius_mm")?,
                half_apex_deg: needed(&mut self.half_apex_deg, "half_apex_deg")?,
                tilt_deg: self.tilt_deg.take().unwrap_or_default(),
            },
            Kind::TipHold => ServoPathDoc::TipHold {
                tip_mm: needed(&mut self.tip_mm, "tip_mm")?,
                sweep_deg: needed(&mut self.sweep_deg, "sweep_deg")?,
            },
            Kind::Program => ServoPathDoc::Program {
                text: needed(&mut self.text, "text")?,
                file_name: self.file_name.take(),
                interpolation: self.interpolation.take(),
                unit: self.unit.take(),
                work_offsets_mm: self.work_offsets_mm.take(),
                tool_number: self.tool_number.take(),
                start: self.start.take(),
                dialect: self.dialect.take().unwrap_or_default(),
                plane: self.plane.take(),
            },
            Kind::Polyline => ServoPathDoc::Polyline {
                points: needed(&mut self.points, "points")?,
                plane: self.plane.take(),
            },
        };
        // The members that are left belong to another kind.
        match self.left() {
            Some(name) => Err(E::unknown_field(name, &[])),
            None => Ok(path),
        }
    }

    fn left(&self) -> Option<&'static str> {
        [
            ("radius_mm", self.radius_mm.is_some()),
            ("center_x_mm", self.center_x_mm.is_some()),
            ("axes", self.axes.is_some()),
            ("center_mm", self.center_mm.is_some()),
            ("half_apex_deg", self.half_apex_deg.is_some()),
            ("tilt_deg", self.tilt_deg.is_some()),
            ("tip_mm", self.tip_mm.is_some()),
            ("sweep_deg", self.sweep_deg.is_some()),
            ("points", self.points.is_some()),
            ("plane", self.plane.is_some()),
            ("text", self.text.is_some()),
            ("file_name", self.file_name.is_some()),
            ("interpolation", self.interpolation.is_some()),
            ("unit", self.unit.is_some()),
            ("work_offsets_mm", self.work_offsets_mm.is_some()),
            ("tool_number", self.tool_number.is_some()),
            ("start", self.start.is_some()),
            ("dialect", self.dialect.is_some()),
        ]
        .into_iter()
        .find_map(|(name, is_there)| is_there.then_some(name))
    }
}
