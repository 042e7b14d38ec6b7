//! A turbine blade finished in one spiral, as a CAM system would post it: points at its tolerance, four decimals.

use std::f64::consts::TAU;
use std::fmt::Write;

use trunnion::geometry::{Vec3, angle_between};
use trunnion::kinematics::{Kinematics, Setup, ToolPose};
use trunnion::machine::Machine;
use trunnion::surface::{ParametricSurface, SurfacePoint};

/// How the blade is cut.
#[derive(Debug, Clone, Copy)]
pub struct Spiral {
    /// Radius of the ball [mm].
    pub radius_mm: f64,
    /// Rise from one turn to the next [mm].
    pub stepover_mm: f64,
    /// Largest distance between the ball's path and its chords [mm].
    pub tolerance_mm: f64,
    /// Angle between surface normal and tool axis, towards the blade's tip [rad].
    pub lean_rad: f64,
    /// Where the first and the last turn run [mm over the root].
    pub heights_mm: [f64; 2],
}

impl Spiral {
    /// The contacts: so close that neither the ball's path leaves its chord by more than the tolerance nor a step is
    /// longer than a quarter of the step-over's scale.
    pub fn contacts(&self, blade: &dyn ParametricSurface) -> Vec<SurfacePoint> {
        let [low, high] = self.heights_mm;
        let turns = (high - low) / self.stepover_mm;
        let at = |turn: f64| blade.at([turn.fract(), low + self.stepover_mm * turn]);
        let centre = |point: &SurfacePoint| point.point_mm + point.normal * self.radius_mm;
        let (mut points, mut turn) = (vec![at(0.0)], 0.0);
        while turn < turns {
            let from = at(turn);
            let mut step: f64 = 1.0 / 16.0;
            loop {
                let (middle, to) = (at(turn + 0.5 * step), at(turn + step));
                let sagitta_mm = (centre(&middle) - 0.5 * (centre(&from) + centre(&to))).norm();
                if sagitta_mm <= self.tolerance_mm && angle_between(from.normal, to.normal) < TAU / 12.0 {
                    break;
                }
                step *= 0.8;
            }
            turn += step;
            points.push(at(turn.min(turns)));
        }
        points
    }

    /// The table of a machine with A and C tables: words, contact normals, feed.
    pub fn table(&self, machine: &Machine, setup: &Setup, contacts: &[SurfacePoint]) -> String {
        let kinematics = Kinematics::new(machine, setup);
        let [first, second] = machine.rotary_axes();
        let mut text = "X,Y,Z,A,C,nx,ny,nz,F\n".to_owned();
        let mut before_deg = [0.0, 0.0];
        for (index, contact) in contacts.iter().enumerate() {
            let up = (Vec3::z() - contact.normal * contact.normal.z).normalize();
            let axis = contact.normal * self.lean_rad.cos() + up * self.lean_rad.sin();
            let tip_mm = |axis: Vec3| contact.point_mm + (contact.normal - axis) * self.radius_mm;
            let pose = ToolPose { tip_mm: tip_mm(axis), axis };
            let candidates = kinematics.candidates(index, &pose, before_deg[1]).expect("a reachable pose");
            let words = candidates.iter().map(|candidate| {
                let [a, c] = candidate.joints.rotary_rad;
                let words = [first.word_deg(a), second.word_deg(c)];
                // C turns without end; A stays on its side.
                [words[0], words[1] + 360.0 * ((before_deg[1] - words[1]) / 360.0).round()]
            });
            let nearest =
                |words: &[f64; 2]| (words[0] - before_deg[0]).abs() + 1e-3 * (words[1] - before_deg[1]).abs();
            let words = words.min_by(|a, b| nearest(a).total_cmp(&nearest(b))).expect("a candidate");
            before_deg = words;
            // The angles as they are written say where the tip has to be.
            let [a, c] = words.map(|word| (word * 1e4).round() / 1e4);
            let rotary_rad = [first.angle_rad(a), second.angle_rad(c)];
            let [x, y, z]: [f64; 3] =
                kinematics.linear_mm(tip_mm(kinematics.axis(rotary_rad)), rotary_rad).into();
            let [i, j, k]: [f64; 3] = contact.normal.into();
            writeln!(text, "{x:.4},{y:.4},{z:.4},{a:.4},{c:.4},{i:.9},{j:.9},{k:.9},1200").expect("text");
        }
        text
    }
}
