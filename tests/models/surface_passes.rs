//! Surfaces finished with a ball, as a CAM system would post it: points at its tolerance, four decimals.

use std::f64::consts::TAU;
use std::fmt::Write;

use trunnion::geometry::{Vec3, angle_between};
use trunnion::kinematics::{Kinematics, Setup, ToolPose};
use trunnion::machine::Machine;
use trunnion::surface::{ParametricSurface, SurfacePoint};

/// How a surface is cut.
#[derive(Debug, Clone, Copy)]
pub struct Finish {
    /// Radius of the ball [mm].
    pub radius_mm: f64,
    /// Largest distance between the ball's path and its chords [mm].
    pub tolerance_mm: f64,
    /// Where the tool axis leans from the normal.
    pub towards: Vec3,
}

/// A contact and how far the tool axis leans there [rad].
pub type Leaning = (SurfacePoint, f64);

/// A point as it is posted.
#[derive(Debug, Clone, Copy)]
pub struct Posted {
    pub contact: SurfacePoint,
    /// X Y Z A C.
    pub words: [f64; 5],
    /// U V W: linear words that would put the tip at the contact.
    pub contact_words_mm: Vec3,
}

impl Finish {
    /// Contacts along `at` from 0 to `end`: so close that neither the ball's path leaves its chord by more than the
    /// tolerance nor the normal turns by more than 30°.
    pub fn contacts(&self, at: impl Fn(f64) -> Leaning, end: f64, first_step: f64) -> Vec<Leaning> {
        let centre = |(point, _): Leaning| point.point_mm + point.normal * self.radius_mm;
        let (mut contacts, mut place) = (vec![at(0.0)], 0.0);
        while place < end {
            let from = at(place);
            let mut step = first_step;
            loop {
                let (middle, to) = (at(place + 0.5 * step), at(place + step));
                let sagitta_mm = (centre(middle) - 0.5 * (centre(from) + centre(to))).norm();
                if sagitta_mm <= self.tolerance_mm && angle_between(from.0.normal, to.0.normal) < TAU / 12.0 {
                    break;
                }
                step *= 0.8;
            }
            place += step;
            contacts.push(at(place.min(end)));
        }
        contacts
    }

    /// The words of a machine with A and C tables; C turns without end, A stays on its side.
    pub fn post(&self, machine: &Machine, setup: &Setup, contacts: &[Leaning]) -> Vec<Posted> {
        let kinematics = Kinematics::new(machine, setup);
        let [first, second] = machine.rotary_axes();
        let mut before_deg = [0.0, 0.0];
        let mut posted = Vec::new();
        for (index, (contact, lean_rad)) in contacts.iter().enumerate() {
            let side = (self.towards - contact.normal * contact.normal.dot(&self.towards)).normalize();
            let axis = contact.normal * lean_rad.cos() + side * lean_rad.sin();
            let tip_mm = |axis: Vec3| contact.point_mm + (contact.normal - axis) * self.radius_mm;
            let pose = ToolPose { tip_mm: tip_mm(axis), axis };
            let candidates = kinematics.candidates(index, &pose, before_deg[1]).expect("a reachable pose");
            let words = candidates.iter().map(|candidate| {
                let [a, c] = candidate.joints.rotary_rad;
                let words = [first.word_deg(a), second.word_deg(c)];
                [words[0], words[1] + 360.0 * ((before_deg[1] - words[1]) / 360.0).round()]
            });
            let travel =
                |words: &[f64; 2]| (words[0] - before_deg[0]).abs() + 1e-3 * (words[1] - before_deg[1]).abs();
            let words = words.min_by(|a, b| travel(a).total_cmp(&travel(b))).expect("a candidate");
            before_deg = words;
            // The angles as they are written say where the tip has to be.
            let [a, c] = words.map(|word| (word * 1e4).round() / 1e4);
            let rotary_rad = [first.angle_rad(a), second.angle_rad(c)];
            let [x, y, z]: [f64; 3] =
                kinematics.linear_mm(tip_mm(kinematics.axis(rotary_rad)), rotary_rad).into();
            let contact_words_mm = kinematics.linear_mm(contact.point_mm, rotary_rad);
            posted.push(Posted { contact: *contact, words: [x, y, z, a, c], contact_words_mm });
        }
        posted
    }
}

/// A table with contact normals.
pub fn table(posted: &[Posted]) -> String {
    let mut text = "X,Y,Z,A,C,nx,ny,nz,F\n".to_owned();
    for Posted { contact, words: [x, y, z, a, c], .. } in posted {
        let [i, j, k]: [f64; 3] = contact.normal.into();
        writeln!(text, "{x:.4},{y:.4},{z:.4},{a:.4},{c:.4},{i:.9},{j:.9},{k:.9},1200").expect("text");
    }
    text
}

/// A program with contact words, every pass entered from `clear_mm` above.
pub fn program(name: &str, passes: &[Vec<Posted>], clear_mm: f64) -> String {
    let mut text = format!("%\n({name})\nN10 G21 G90 G17 G54\nN20 T1 M6\nN30 S12000 M3\n");
    let mut number = 40;
    let mut block = |words: String| {
        writeln!(text, "N{number} {words}").expect("text");
        number += 10;
    };
    for pass in passes {
        for (index, Posted { words: [x, y, z, a, c], contact_words_mm, .. }) in pass.iter().enumerate() {
            let [u, v, w]: [f64; 3] = (*contact_words_mm).into();
            if index == 0 {
                block(format!("G0 X{x:.4} Y{y:.4} Z{clear_mm:.4} A{a:.4} C{c:.4}"));
            }
            let code = if index == 0 { "G1 " } else { "" };
            let feed = if index == 0 { " F1200." } else { "" };
            block(format!("{code}X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4} U{u:.4} V{v:.4} W{w:.4}{feed}"));
        }
        block(format!("G0 Z{clear_mm:.4}"));
    }
    block("M5".to_owned());
    block("M30".to_owned());
    text + "%\n"
}
