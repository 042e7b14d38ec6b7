//! The results of probed spheres.

use serde::{Deserialize, Serialize};

use super::calibration_answer::CalibrationHead;
use super::{CalibrationDocument, CalibrationRequest, CovarianceDoc, Estimate, Fixed};
use crate::calibration::rotary_sphere::{AxisFit, SphereIdentified};
use crate::calibration::{Unknown, told_per_unit};
use crate::description::ToSchema;
use crate::machine::Machine;
use crate::units::UM_PER_MM;

/// The circle of one sphere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SphereCircle {
    /// Index of the sphere.
    pub sphere: usize,
    /// Centre of its circle, on the axis.
    pub centre_mm: Fixed<3>,
    /// Radius of the circle.
    pub radius_mm: f64,
}

/// A centre that does not agree with the others. The fit still uses it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SphereOutlier {
    /// Index of the centre, from 0.
    pub centre: usize,
    /// Distance from the position that the other centres give.
    pub distance_um: f64,
}

/// One axis from the probed spheres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SphereAxisAnswer {
    /// Letter of the axis.
    pub rotary_axis: String,
    /// Unit direction, in the nominal sense.
    pub direction: Fixed<3>,
    /// Point where the line meets the plane through the nominal reference point, perpendicular to the nominal
    /// direction.
    pub point_mm: Fixed<3>,
    /// Number of centres.
    pub centres: usize,
    /// Circle of each sphere.
    pub spheres: Vec<SphereCircle>,
    /// Root of the mean square of the distances from the circles' planes.
    pub axial_rms_um: f64,
    /// Root of the mean square of the radial distances.
    pub radial_rms_um: f64,
    /// Root of the mean square of the distances along the circles; null if the angles are not known.
    pub tangential_rms_um: Option<f64>,
    /// Centres to check.
    pub outliers: Vec<SphereOutlier>,
}

/// Line coordinates of an axis: two tilts, two offsets.
const PER_AXIS: usize = 4;

impl CalibrationDocument {
    /// The document of probed spheres.
    #[must_use]
    pub fn of_spheres(
        head: CalibrationHead<'_>,
        request: &CalibrationRequest,
        machine: &Machine,
        found: &SphereIdentified,
    ) -> Self {
        let mut document = Self::empty(head, request, machine);
        for (index, parameter) in found.parameters.iter().copied().enumerate() {
            let unit = told_per_unit(parameter.component);
            let variance = found.covariance.as_ref().map(|matrix| matrix[(index, index)]);
            let standard_uncertainty = variance.map(|variance| variance.max(0.0).sqrt() * unit);
            let value = parameter.value(&found.errors) * unit;
            document.set(machine, parameter, Estimate { value, standard_uncertainty });
        }
        document.set_absolute(machine, &found.absolute);
        let unknowns: Vec<Unknown> = found.parameters.iter().copied().map(Unknown::Error).collect();
        document.covariance =
            found.covariance.as_ref().map(|matrix| CovarianceDoc::of(machine, &unknowns, matrix));
        document.rank = PER_AXIS * found.fits.len();
        document.unknowns = document.rank;
        document.degrees_of_freedom = found.fits.iter().map(|fit| fit.degrees_of_freedom).sum();
        document.residual_rms_um = rms_um(&found.fits);
        let posted = request.axes.iter().flatten();
        document.axes = Some(
            posted
                .zip(&found.fits)
                .map(|(posted, fit)| SphereAxisAnswer::of(&posted.rotary_axis, fit))
                .collect(),
        );
        document
    }
}

impl SphereAxisAnswer {
    fn of(letter: &str, fit: &AxisFit) -> Self {
        let (axial_mm, radial_mm, tangential_mm) = fit.rms_mm();
        Self {
            rotary_axis: letter.to_owned(),
            direction: Fixed(fit.line.direction.into()),
            point_mm: Fixed(fit.line.point_mm.into()),
            centres: fit.residuals.len(),
            spheres: fit
                .balls
                .iter()
                .map(|ball| SphereCircle {
                    sphere: ball.ball,
                    centre_mm: Fixed(ball.center_mm.into()),
                    radius_mm: ball.radius_mm,
                })
                .collect(),
            axial_rms_um: axial_mm * UM_PER_MM,
            radial_rms_um: radial_mm * UM_PER_MM,
            tangential_rms_um: tangential_mm.map(|mm| mm * UM_PER_MM),
            outliers: fit
                .outliers
                .iter()
                .map(|outlier| SphereOutlier {
                    centre: outlier.reading,
                    distance_um: outlier.distance_mm * UM_PER_MM,
                })
                .collect(),
        }
    }
}

/// The root of the mean square over all coordinates of all centres.
fn rms_um(fits: &[AxisFit]) -> f64 {
    let residuals = fits.iter().flat_map(|fit| &fit.residuals);
    let (mut squares, mut count) = (0.0, 0.0);
    for residual in residuals {
        for part in
            [Some(residual.axial_mm), Some(residual.radial_mm), residual.tangential_mm].into_iter().flatten()
        {
            squares += part * part;
            count += 1.0;
        }
    }
    if count > 0.0 { f64::sqrt(squares / count) * UM_PER_MM } else { 0.0 }
}
