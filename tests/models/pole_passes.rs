//! Passes over the pole of any layout: the tool leans across the axis next to the workpiece and misses it by a little.

use std::fmt::Write;
use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, PathOptions, Setup, ToolPose};
use trunnion::machine::{Machine, Preset, Tool};
use trunnion::units::Length;

/// A program over the pole, with its machine.
#[derive(Debug, Clone)]
pub struct PolePass {
    pub machine: Machine,
    pub setup: Setup,
    pub tool: Tool,
    pub text: String,
    pub tcp: bool,
}

/// How the passes run.
#[derive(Debug, Clone, Copy)]
pub struct PassShape {
    /// The tool leans from so far on the one side to so far on the other \[deg\].
    pub lean_deg: f64,
    /// It misses the pole by this angle \[deg\].
    pub miss_deg: f64,
    /// Motions of the pass.
    pub motions: usize,
    /// Decimals of every word.
    pub decimals: usize,
    pub inverse_time: bool,
    pub incremental: bool,
}

impl PassShape {
    pub const PLAIN: Self = Self {
        lean_deg: 6.0,
        miss_deg: 0.2,
        motions: 40,
        decimals: 4,
        inverse_time: false,
        incremental: false,
    };
}

/// The preset of this name with axes that do not meet, and room for several turns.
pub fn machine(id: &str) -> Machine {
    let mut parts = Preset::by_id(id).expect("a preset").parts();
    for (k, axis) in parts.rotary_axes.iter_mut().enumerate() {
        axis.travel_deg = None;
        axis.point_mm += Vec3::new(3.0, -5.0, 8.0) * (k as f64 + 1.0);
    }
    Machine::new(parts).expect("a machine")
}

/// The pass on one machine: the tip runs 60 mm along a line, aslant in space.
pub fn pole_pass(id: &str, tcp: bool, shape: PassShape) -> PolePass {
    let machine = machine(id);
    let setup =
        Setup { work_offset_mm: Vec3::new(40.0, -20.0, 55.0), tool_length_mm: 80.0, apply_errors: true };
    let kinematics = Kinematics::new(&machine, &setup);
    // The axis next to the workpiece, and two directions across it.
    let u = machine.rotary_axes()[kinematics.workpiece_to_tool()[0]].direction;
    let along = u.cross(&Vec3::new(0.3, 0.8, -0.5)).normalize();
    let beside = u.cross(&along);
    let poses: Vec<ToolPose> = (0..=shape.motions)
        .map(|k| {
            let s = 2.0 * k as f64 / shape.motions as f64 - 1.0;
            let (lean, miss) = ((shape.lean_deg * s).to_radians(), shape.miss_deg.to_radians());
            let axis = (u + along * lean.tan() + beside * miss.tan()).normalize();
            ToolPose { tip_mm: Vec3::new(30.0 * s, 12.0 * s + 4.0, 5.0 - 3.0 * s), axis }
        })
        .collect();
    let path = kinematics
        .path(&poses, &PathOptions::default(), &|| ControlFlow::Continue(()))
        .expect("poses within reach");
    let [first, second] = machine.rotary_axes();
    let letters = [first.letter.as_char(), second.letter.as_char()];
    let (decimals, scale) = (shape.decimals, 10.0_f64.powi(i32::try_from(shape.decimals).expect("a few")));
    let round = |value: f64| (value * scale).round() / scale + 0.0;
    let mut text = String::from("%\nG21 G17 G90 G54\n");
    if tcp {
        text.push_str("G43.4 H1\n");
    }
    let mut before: Option<[f64; 5]> = None;
    for (k, pose) in poses.iter().enumerate() {
        let joints = path.get(k).expect("a pose");
        let [a, b] = [first.word_deg(joints.rotary_rad[0]), second.word_deg(joints.rotary_rad[1])].map(round);
        let angles = [first.angle_rad(a), second.angle_rad(b)];
        let linear = if tcp { pose.tip_mm } else { kinematics.linear_mm(pose.tip_mm, angles) };
        let words = [round(linear.x), round(linear.y), round(linear.z), a, b];
        let from = before.filter(|_| shape.incremental).unwrap_or([0.0; 5]);
        let code = match (k, shape.incremental) {
            (0, _) => "G0 ",
            (1, true) => "G91 G1 ",
            (1, false) => "G1 ",
            _ => "",
        };
        write!(text, "N{} {code}", 10 * (k + 1)).expect("text");
        let names = ['X', 'Y', 'Z', letters[0], letters[1]];
        for (n, name) in names.into_iter().enumerate() {
            // Words that do not change are left out, as posts do.
            if before.is_none_or(|before| before[n].to_bits() != words[n].to_bits()) {
                write!(text, "{name}{:.decimals$} ", round(words[n] - from[n])).expect("text");
            }
        }
        match (k, shape.inverse_time) {
            (0, _) => {}
            (1, true) => text.push_str("G93 F400"),
            (_, true) => text.push_str("F400"),
            (1, false) => text.push_str("F1500"),
            _ => {}
        }
        text.push('\n');
        before = Some(words);
    }
    text.push_str("G90 G94 G0 Z200.\nM30\n%\n");
    let radius = Length::from_mm(5.0);
    PolePass { machine, setup, tool: Tool::new(radius, radius).expect("a ball"), text, tcp }
}
