//! The eccentricity of a test: the first harmonic of its readings, as the shift across the axis that would cause it.

use nalgebra::{DMatrix, DVector, Dyn, Matrix3, QR};

use super::BarDirection;
use crate::geometry::{Screw, Vec3, trig};
use crate::machine::{RotaryAxis, RotaryLetter};

/// Two directions across an axis, and the bar direction whose turning distinguishes them.
#[derive(Debug, Clone)]
pub(super) struct Harmonic {
    axis: Vec3,
    pair: [Vec3; 2],
    bar: Vec3,
}

/// Step of the angles at which the model predicts a test's readings \[deg\].
const GRID_STEP_DEG: u16 = 15;
/// Assumed turn either way of an axis that cannot turn fully \[deg\], as for P4's trunnion.
const HALF_TURN_DEG: f64 = 90.0;
/// A harmonic is not determined if its triangular factor has a diagonal this small compared with its largest.
const UNDETERMINED: f64 = 1e-9;

impl Harmonic {
    /// The pair is (x, y) of a C axis, (y, z) of an A axis, (z, x) of a B axis. An axial test is evaluated like the
    /// radial test of its axis (§5: C `Δx = (r0 − r180)/2, Δy = (r270 − r90)/2`).
    pub(super) fn new(axis: &RotaryAxis, bar: BarDirection) -> Self {
        let toward = |bar: BarDirection| bar.unit(axis.letter, axis.direction);
        let (radial, tangential) = (toward(BarDirection::Radial), toward(BarDirection::Tangential));
        let pair = match axis.letter {
            RotaryLetter::A => [tangential, radial],
            RotaryLetter::B | RotaryLetter::C => [radial, tangential],
        };
        let bar = if bar == BarDirection::Tangential { tangential } else { radial };
        Self { axis: axis.direction, pair, bar }
    }

    /// The change of the reading at this angle by a unit shift along each direction of the pair, without a
    /// constant. It is the bar's components turned by −θ, as a table turns it. On a head the ball turns by θ before
    /// a bar at rest, which gives the same.
    pub(super) fn at(&self, (sin, cos): (f64, f64)) -> [f64; 2] {
        let turned = Screw { direction: self.axis, point_mm: Vec3::zeros() }.turn_by((-sin, cos), self.bar);
        self.pair.map(|direction| direction.dot(&turned))
    }
}

/// The linear map from readings at fixed angles to their eccentricity.
#[derive(Debug, Clone)]
pub(super) struct HarmonicFit {
    factors: QR<f64, Dyn, Dyn>,
}

impl HarmonicFit {
    /// For readings at these angles; `None` if they do not separate constant, sine and cosine.
    pub(super) fn new(harmonic: &Harmonic, turns: &[(f64, f64)]) -> Option<Self> {
        if turns.len() < 3 {
            return None;
        }
        let mut design = DMatrix::from_element(turns.len(), 3, 1.0);
        for (row, turn) in turns.iter().enumerate() {
            let [first, second] = harmonic.at(*turn);
            design[(row, 1)] = first;
            design[(row, 2)] = second;
        }
        let factors = design.qr();
        let diagonal = factors.r().diagonal().abs();
        (diagonal.min() > UNDETERMINED * diagonal.max()).then_some(Self { factors })
    }

    /// The eccentricity of these readings, in their unit.
    pub(super) fn of(&self, readings: &[f64]) -> [f64; 2] {
        let mut rotated = DVector::from_row_slice(readings);
        self.factors.q_tr_mul(&mut rotated);
        let triangle: Matrix3<f64> = self.factors.r().fixed_view::<3, 3>(0, 0).into_owned();
        let top = rotated.fixed_rows::<3>(0).into_owned();
        triangle.solve_upper_triangular(&top).map_or([0.0; 2], |solved| [solved[1], solved[2]])
    }
}

/// A full turn as sine and cosine, for an eccentricity given alone, even if the axis cannot turn so far. P4's half
/// differences of opposite readings are free of even harmonics, and so is the first harmonic over a full turn.
pub(super) fn full_turn() -> Vec<(f64, f64)> {
    (0..360 / GRID_STEP_DEG).map(|step| trig::sin_cos_deg(f64::from(step * GRID_STEP_DEG))).collect()
}

/// The angles, as sine and cosine, of a further test of this axis.
pub(super) fn reachable_turns(axis: &RotaryAxis) -> Vec<(f64, f64)> {
    let [from_deg, to_deg] = match axis.travel_deg {
        Some(travel) if travel.max - travel.min < 360.0 => {
            [travel.min.max(-HALF_TURN_DEG), travel.max.min(HALF_TURN_DEG)]
        }
        _ => return full_turn(),
    };
    let steps = 360 / GRID_STEP_DEG - 1;
    (0..=steps)
        .map(|step| from_deg + (to_deg - from_deg) * f64::from(step) / f64::from(steps))
        .map(|word_deg| trig::sin_cos(axis.angle_rad(word_deg)))
        .collect()
}
