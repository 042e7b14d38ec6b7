//! The nominal surface of a part, if a formula gives it.

use serde::{Deserialize, Serialize};

use super::{Fault, FaultList, Fixed, SurfaceKind};
use crate::description::ToSchema;
use crate::geometry::{RigidMotion, Vec3, rotation_from_vector};
use crate::surface::{
    Blade, BladeSizes, Bulge, Cylinder, ParametricSurface, Placed, Plane, Saddle, Sphere, SurfaceFault,
    SurfaceQuantity,
};

/// Which formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FormulaKind {
    /// A rectangle across Z: `length_mm` along X, `width_mm` along Y.
    Plane,
    /// A patch of a sphere about its top (hollow: its bottom) along Z: `radius_mm`, `half_angle_deg`, `side`.
    Sphere,
    /// A strip of a cylinder along Y: `radius_mm`, `length_mm`, `half_angle_deg`, `side`.
    Cylinder,
    /// Convex along X, concave along Y: `convex_radius_mm`, `concave_radius_mm`, `length_mm`, `width_mm`.
    Saddle,
    /// A twisted blade with rounded edges that points along Z; all sizes have defaults.
    Blade,
}

/// A surface given by a formula, in W. Members that do not belong to its `kind` are refused.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NominalSurface)]
pub struct NominalSurfaceDoc {
    /// Which formula.
    pub kind: FormulaKind,
    /// Position of the centre; for a blade the middle of the camber line at the root.
    #[serde(default)]
    pub center_mm: Fixed<3>,
    /// Rotation about the centre: the direction is the axis, the length is the angle.
    #[serde(default)]
    pub rotation_vector_deg: Fixed<3>,
    /// Length of a plane, cylinder or saddle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 40.0)]
    pub length_mm: Option<f64>,
    /// Width of a plane or saddle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 30.0)]
    pub width_mm: Option<f64>,
    /// Radius of a sphere or cylinder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Half the angle that the patch spans; default 45.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_angle_deg: Option<f64>,
    /// Convex or concave, for a sphere or cylinder; default convex.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<SurfaceKind>,
    /// Convex radius of a saddle, along X.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convex_radius_mm: Option<f64>,
    /// Concave radius of a saddle, along Y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub concave_radius_mm: Option<f64>,
    /// Length of a blade's camber line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camber_length_mm: Option<f64>,
    /// Angle by which a blade's camber line turns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camber_deg: Option<f64>,
    /// Largest thickness of a blade.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_mm: Option<f64>,
    /// Radius of a blade's leading edge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub leading_radius_mm: Option<f64>,
    /// Radius of a blade's trailing edge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trailing_radius_mm: Option<f64>,
    /// Height of a blade.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub span_mm: Option<f64>,
    /// Angle by which a blade's profile at the tip is turned against the profile at the root.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twist_deg: Option<f64>,
}

/// Half angle of a patch if none is stated \[deg\].
const HALF_ANGLE_DEG: f64 = 45.0;

/// A surface of any kind.
pub type AnySurface = Box<dyn ParametricSurface + Send + Sync>;

impl NominalSurfaceDoc {
    /// The surface; faults are added to `faults` under `pointer`.
    pub fn to_core(&self, pointer: &str, faults: &mut FaultList) -> Option<AnySurface> {
        let mut sizes = Sizes { doc: self, pointer, faults, used: Vec::new() };
        let bulge = match self.side {
            None | Some(SurfaceKind::Convex) => Bulge::Convex,
            Some(SurfaceKind::Concave) => Bulge::Concave,
            Some(SurfaceKind::Flat) => {
                sizes.refuse("side", "only a sphere or cylinder has a side; remove this member".to_owned());
                Bulge::Convex
            }
        };
        let centre = Vec3::zeros();
        match self.kind {
            FormulaKind::Plane => {
                let [length, width] = ["length_mm", "width_mm"].map(|name| sizes.needed(name));
                sizes.finish(|| Plane::new(centre, length, width))
            }
            FormulaKind::Sphere => {
                sizes.used.push("side");
                let radius = sizes.needed("radius_mm");
                let half_angle = sizes.or("half_angle_deg", HALF_ANGLE_DEG).to_radians();
                sizes.finish(|| Sphere::new(centre, radius, half_angle, bulge))
            }
            FormulaKind::Cylinder => {
                sizes.used.push("side");
                let [radius, length] = ["radius_mm", "length_mm"].map(|name| sizes.needed(name));
                let half_angle = sizes.or("half_angle_deg", HALF_ANGLE_DEG).to_radians();
                sizes.finish(|| Cylinder::new(centre, radius, half_angle, length, bulge))
            }
            FormulaKind::Saddle => {
                let [convex, concave, length, width] =
                    ["convex_radius_mm", "concave_radius_mm", "length_mm", "width_mm"]
                        .map(|name| sizes.needed(name));
                sizes.finish(|| Saddle::new(centre, convex, concave, length, width))
            }
            FormulaKind::Blade => {
                let usual = BladeSizes::default();
                let blade = BladeSizes {
                    camber_length_mm: sizes.or("camber_length_mm", usual.camber_length_mm),
                    camber_rad: sizes.or("camber_deg", usual.camber_rad.to_degrees()).to_radians(),
                    thickness_mm: sizes.or("thickness_mm", usual.thickness_mm),
                    leading_radius_mm: sizes.or("leading_radius_mm", usual.leading_radius_mm),
                    trailing_radius_mm: sizes.or("trailing_radius_mm", usual.trailing_radius_mm),
                    span_mm: sizes.or("span_mm", usual.span_mm),
                    twist_rad: sizes.or("twist_deg", usual.twist_rad.to_degrees()).to_radians(),
                };
                sizes.finish(|| Blade::new(centre, blade))
            }
        }
    }

    /// The members that only some kinds have.
    fn members(&self) -> [(&'static str, Option<f64>); 13] {
        [
            ("length_mm", self.length_mm),
            ("width_mm", self.width_mm),
            ("radius_mm", self.radius_mm),
            ("half_angle_deg", self.half_angle_deg),
            ("convex_radius_mm", self.convex_radius_mm),
            ("concave_radius_mm", self.concave_radius_mm),
            ("camber_length_mm", self.camber_length_mm),
            ("camber_deg", self.camber_deg),
            ("thickness_mm", self.thickness_mm),
            ("leading_radius_mm", self.leading_radius_mm),
            ("trailing_radius_mm", self.trailing_radius_mm),
            ("span_mm", self.span_mm),
            ("twist_deg", self.twist_deg),
        ]
    }

    fn motion(&self) -> RigidMotion {
        RigidMotion {
            rotation: rotation_from_vector(Vec3::from(self.rotation_vector_deg.0.map(f64::to_radians))),
            shift_mm: Vec3::from(self.center_mm.0),
        }
    }
}

/// Takes the members of a kind one by one, then reports the members that do not belong to it.
struct Sizes<'a> {
    doc: &'a NominalSurfaceDoc,
    pointer: &'a str,
    faults: &'a mut FaultList,
    used: Vec<&'static str>,
}

impl Sizes<'_> {
    fn given(&mut self, name: &'static str) -> Option<f64> {
        self.used.push(name);
        self.doc.members().into_iter().find(|(member, _)| *member == name).and_then(|(_, value)| value)
    }

    fn or(&mut self, name: &'static str, usual: f64) -> f64 {
        self.given(name).unwrap_or(usual)
    }

    fn needed(&mut self, name: &'static str) -> f64 {
        self.given(name).unwrap_or_else(|| {
            self.refuse(name, "missing: this kind of surface needs it".to_owned());
            1.0
        })
    }

    fn refuse(&mut self, name: &str, detail: String) {
        let pointer = format!("{}/{name}", self.pointer);
        self.faults.push(|| Fault::new(pointer, detail));
    }

    fn finish<S: ParametricSurface + Send + Sync + 'static>(
        mut self,
        build: impl FnOnce() -> Result<S, Vec<SurfaceFault>>,
    ) -> Option<AnySurface> {
        let strange: Vec<_> = self
            .doc
            .members()
            .into_iter()
            .filter(|(name, value)| value.is_some() && !self.used.contains(name))
            .map(|(name, _)| name)
            .chain((self.doc.side.is_some() && !self.used.contains(&"side")).then_some("side"))
            .collect();
        for name in strange {
            self.refuse(name, "is not a size of this kind of surface".to_owned());
        }
        for (member, values, max) in [
            ("center_mm", self.doc.center_mm, MAX_PLACE_MM),
            ("rotation_vector_deg", self.doc.rotation_vector_deg, MAX_TURN_DEG),
        ] {
            for (index, value) in values.0.into_iter().enumerate() {
                let pointer = || format!("{}/{member}/{index}", self.pointer);
                self.faults.check_range(pointer, value, -max, max);
            }
        }
        match build() {
            Ok(surface) => Some(Box::new(Placed { surface, motion: self.doc.motion() })),
            Err(faults) => {
                for fault in faults {
                    self.refuse(member_at_fault(&fault), fault.to_string());
                }
                None
            }
        }
    }
}

/// Largest distance of a surface from the origin \[mm\].
const MAX_PLACE_MM: f64 = 1e5;
/// One full turn covers every rotation.
const MAX_TURN_DEG: f64 = 360.0;

/// The member that a fault concerns.
fn member_at_fault(fault: &SurfaceFault) -> &'static str {
    let (SurfaceFault::Length { quantity, .. }
    | SurfaceFault::Angle { quantity, .. }
    | SurfaceFault::EdgeTooThick { quantity, .. }) = fault
    else {
        return if matches!(fault, SurfaceFault::TooSteep { .. }) {
            "camber_length_mm"
        } else {
            "camber_deg"
        };
    };
    match quantity {
        SurfaceQuantity::Position => "center_mm",
        SurfaceQuantity::Length => "length_mm",
        SurfaceQuantity::Width => "width_mm",
        SurfaceQuantity::Radius => "radius_mm",
        SurfaceQuantity::ConvexRadius => "convex_radius_mm",
        SurfaceQuantity::ConcaveRadius => "concave_radius_mm",
        SurfaceQuantity::HalfAngle => "half_angle_deg",
        SurfaceQuantity::CamberLength => "camber_length_mm",
        SurfaceQuantity::CamberAngle => "camber_deg",
        SurfaceQuantity::Thickness => "thickness_mm",
        SurfaceQuantity::LeadingRadius => "leading_radius_mm",
        SurfaceQuantity::TrailingRadius => "trailing_radius_mm",
        SurfaceQuantity::Span => "span_mm",
        SurfaceQuantity::Twist => "twist_deg",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (NominalSurfaceDoc, Vec<String>) {
        let doc: NominalSurfaceDoc = serde_json::from_str(text).expect("a document");
        let mut faults = FaultList::default();
        let surface = doc.to_core("/surface", &mut faults);
        let pointers: Vec<_> =
            faults.into_result().err().into_iter().flatten().map(|fault| fault.pointer).collect();
        assert!(surface.is_some() || !pointers.is_empty());
        (doc, pointers)
    }

    #[test]
    fn every_fault_of_a_surface_is_named() {
        let none: [&str; 0] = [];
        assert_eq!(read(r#"{"kind": "blade"}"#).1, none);
        assert_eq!(read(r#"{"kind": "sphere", "radius_mm": 20, "side": "concave"}"#).1, none);
        assert_eq!(read(r#"{"kind": "plane", "length_mm": 20}"#).1, ["/surface/width_mm"]);
        assert_eq!(
            read(r#"{"kind": "cylinder", "radius_mm": -1, "length_mm": 5, "span_mm": 3, "half_angle_deg": 200}"#)
                .1,
            ["/surface/span_mm", "/surface/radius_mm", "/surface/half_angle_deg"]
        );
        assert_eq!(
            read(r#"{"kind": "plane", "length_mm": 1, "width_mm": 1, "side": "convex", "center_mm": [0, 0, 1e9]}"#).1,
            ["/surface/side", "/surface/center_mm/2"]
        );
        assert_eq!(
            read(r#"{"kind": "blade", "leading_radius_mm": 9}"#).1.first().map(String::as_str),
            Some("/surface/leading_radius_mm")
        );
    }

    #[test]
    fn a_surface_stands_where_it_was_put() {
        let (doc, _) = read(
            r#"{"kind": "plane", "length_mm": 20, "width_mm": 10, "center_mm": [1, 2, 3], "rotation_vector_deg": [0, 90, 0]}"#,
        );
        let surface = doc.to_core("", &mut FaultList::default()).expect("a surface");
        let point = surface.at([5.0, 0.0]);
        assert!((point.normal - Vec3::x()).norm() < 1e-15);
        assert!((point.point_mm - Vec3::new(1.0, 2.0, -2.0)).norm() < 1e-14);
    }
}
