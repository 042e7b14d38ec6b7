//! Finishing passes of our own: a twisted blade, an impeller flank, a dome cut through the pole. Contact points and
//! normals come from the surface itself, so that every number of a compensation can be checked.

use std::fmt::Write;

use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup, ToolPose};
use trunnion::machine::{
    LocationError, Machine, MachineParts, RotaryAxis, RotaryLetter, Side, Squareness, Tool,
};
use trunnion::surface::ParametricSurface;
use trunnion::units::Length;

/// One programmed point.
#[derive(Debug, Clone, Copy)]
pub struct FinishingPoint {
    /// Contact on the surface, W [mm].
    pub contact_mm: Vec3,
    /// Unit surface normal, W.
    pub normal: Vec3,
    /// Tool tip and axis, W.
    pub pose: ToolPose,
    /// X Y Z [mm].
    pub linear_mm: Vec3,
    /// Rotary words [deg], profile order.
    pub rotary_deg: [f64; 2],
    /// U V W: linear words that would put the tip at the contact.
    pub contact_words_mm: Vec3,
    /// Whether a new pass starts here.
    pub first_of_pass: bool,
}

/// A part with its machine, tool and points.
#[derive(Debug, Clone)]
pub struct Finishing {
    pub name: &'static str,
    pub machine: Machine,
    pub setup: Setup,
    pub tool: Tool,
    pub points: Vec<FinishingPoint>,
}

/// What a program states beside the five axis words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Nothing.
    Plain,
    /// U V W.
    ContactWords,
    /// The same with TCP: X Y Z and U V W in W.
    Tcp,
    /// A table with normals.
    NormalTable,
}

/// How F is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedForm {
    /// G94, once.
    PerMinute,
    /// G93 in every block.
    InverseTime,
}

/// A and C tables whose axes do not meet, A through (0, 10, −20), C through (0, 0, 0).
pub fn ac_machine() -> Machine {
    let axis = |letter, direction, point_mm| RotaryAxis {
        letter,
        side: Side::Table,
        direction,
        point_mm,
        travel_deg: None,
        reversed: false,
        location_error: LocationError::default(),
    };
    Machine::new(MachineParts {
        name: "AC tables, offset".into(),
        rotary_axes: vec![
            axis(RotaryLetter::A, Vec3::x(), Vec3::new(0.0, 10.0, -20.0)),
            axis(RotaryLetter::C, Vec3::z(), Vec3::zeros()),
        ],
        linear_travel_mm: [None; 3],
        squareness: Squareness::default(),
        interpolation_period_s: 0.002,
    })
    .expect("a plain machine")
}

/// Corner radius equal to the radius: a ball.
pub fn tool(radius_mm: f64, corner_radius_mm: f64) -> Tool {
    Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_radius_mm)).expect("a tool")
}

type Surface = fn(f64, f64) -> Vec3;
/// Tool axis from normal and feed direction.
type Orientation = fn(Vec3, Vec3) -> Vec3;

/// Blade: 40 mm chord, 60 mm high, 35° twist, cut along the chord with the tool 60° off the normal.
pub fn blade(machine: Machine, tool: Tool, points_per_pass: usize, passes: usize) -> Finishing {
    fn surface(s: f64, h: f64) -> Vec3 {
        let x = 40.0 * (s - 0.5);
        let y = 6.0 * (1.0 - (2.0 * s - 1.0).powi(2)) + 3.0;
        let (sin, cos) = (35.0_f64.to_radians() * h).sin_cos();
        Vec3::new(x * cos - y * sin, x * sin + y * cos, 60.0 * h)
    }
    fn axis(n: Vec3, _feed: Vec3) -> Vec3 {
        let up = (Vec3::z() - n * n.z).normalize();
        (n * 0.5 + up * 0.75_f64.sqrt()).normalize()
    }
    cut("blade", machine, tool, surface, axis, points_per_pass, passes)
}

/// A conical wall, cut with the flank of the tool: its axis lies in the surface, across the feed.
pub fn wall(machine: Machine, tool: Tool, points_per_pass: usize, passes: usize) -> Finishing {
    fn surface(s: f64, h: f64) -> Vec3 {
        let (sin, cos) = (0.9 * s + 0.2 * h).sin_cos();
        Vec3::new((40.0 + 8.0 * h) * cos, (40.0 + 8.0 * h) * sin, 30.0 * h)
    }
    fn axis(n: Vec3, _feed: Vec3) -> Vec3 {
        (Vec3::z() - n * n.z).normalize()
    }
    cut("wall", machine, tool, surface, axis, points_per_pass, passes)
}

/// Impeller flank: a conical helicoid, cut along the flow with the tool 70° off the normal.
pub fn impeller_flank(machine: Machine, tool: Tool, points_per_pass: usize, passes: usize) -> Finishing {
    fn surface(s: f64, h: f64) -> Vec3 {
        let angle = 1.1 * s * s + 0.25 * h;
        let radius = 18.0 + 22.0 * s + 10.0 * h * (1.0 - 0.4 * s);
        let height = 30.0 * (1.0 - s).powi(2) + 14.0 * h * s;
        Vec3::new(radius * angle.cos(), radius * angle.sin(), height)
    }
    fn axis(n: Vec3, _feed: Vec3) -> Vec3 {
        let up = (Vec3::z() - n * n.z).normalize();
        let tilt = 70.0_f64.to_radians();
        (n * tilt.cos() + up * tilt.sin()).normalize()
    }
    cut("impeller flank", machine, tool, surface, axis, points_per_pass, passes)
}

/// Dome of radius 80 mm cut past its apex with 1.5° lead: the tool axis passes through the pole's neighbourhood.
pub fn dome_near_pole(machine: Machine, tool: Tool, points_per_pass: usize, passes: usize) -> Finishing {
    fn surface(s: f64, h: f64) -> Vec3 {
        let (x, y) = (24.0 * (s - 0.5), 3.0 * (h - 0.5) + 0.35);
        Vec3::new(x, y, (6400.0 - x * x - y * y).sqrt() - 80.0)
    }
    fn axis(n: Vec3, feed: Vec3) -> Vec3 {
        let lead = 1.5_f64.to_radians();
        (n * lead.cos() + feed * lead.sin()).normalize()
    }
    cut("dome near the pole", machine, tool, surface, axis, points_per_pass, passes)
}

/// Passes over a part of an analytic surface, shares of its domain, the tool leaning from the normal toward the feed
/// and aside by these angles.
pub fn patch(
    name: &'static str,
    tool: Tool,
    surface: &dyn ParametricSurface,
    window: [[f64; 2]; 2],
    lean_deg: [f64; 2],
    [points_per_pass, passes]: [usize; 2],
) -> Finishing {
    let [[u0, u1], [v0, v1]] = surface.domain();
    let place = |s: f64, h: f64| {
        let [[a, b], [c, d]] = window;
        [u0 + (u1 - u0) * (a + (b - a) * s), v0 + (v1 - v0) * (c + (d - c) * h)]
    };
    let [lead, tilt] = lean_deg.map(|deg| deg.to_radians().tan());
    cut_over(
        name,
        ac_machine(),
        tool,
        &|s, h| {
            let found = surface.derivatives(place(s, h));
            (found.point_mm, found.normal(), found.by_u.normalize())
        },
        &|n, feed| (n + feed * lead + n.cross(&feed) * tilt).normalize(),
        [points_per_pass, passes],
    )
}

fn cut(
    name: &'static str,
    machine: Machine,
    tool: Tool,
    surface: Surface,
    axis: Orientation,
    points_per_pass: usize,
    passes: usize,
) -> Finishing {
    let at = |s: f64, h: f64| {
        let step = 1e-5;
        let ds = surface(s + step, h) - surface(s - step, h);
        let dh = surface(s, h + step) - surface(s, h - step);
        let mut normal = ds.cross(&dh).normalize();
        let contact_mm = surface(s, h);
        // Out of the part: upward for the dome, away from the axis for the flanks.
        let outward =
            if name.starts_with("dome") { Vec3::z() } else { Vec3::new(contact_mm.x, contact_mm.y, 0.0) };
        if name == "blade" {
            let inside = Vec3::new(0.0, 0.0, contact_mm.z);
            if normal.dot(&(contact_mm - inside)) < 0.0 {
                normal = -normal;
            }
        } else if normal.dot(&outward) < 0.0 {
            normal = -normal;
        }
        (contact_mm, normal, ds.normalize())
    };
    cut_over(name, machine, tool, &at, &axis, [points_per_pass, passes])
}

/// Contact, normal and direction of rising s by (s, h) in [0, 1].
type Place<'a> = &'a dyn Fn(f64, f64) -> (Vec3, Vec3, Vec3);

fn cut_over(
    name: &'static str,
    machine: Machine,
    tool: Tool,
    place: Place<'_>,
    axis: &dyn Fn(Vec3, Vec3) -> Vec3,
    [points_per_pass, passes]: [usize; 2],
) -> Finishing {
    let setup = Setup { work_offset_mm: Vec3::new(12.0, -7.0, 35.0), ..Setup::default() };
    let kinematics = Kinematics::new(&machine, &setup);
    let mut points: Vec<FinishingPoint> = Vec::new();
    for pass in 0..passes {
        let h = if passes > 1 { pass as f64 / (passes - 1) as f64 } else { 0.5 };
        for k in 0..points_per_pass {
            // Back and forth.
            let along = k as f64 / (points_per_pass - 1) as f64;
            let (s, sense) = if pass % 2 == 0 { (along, 1.0) } else { (1.0 - along, -1.0) };
            let (contact_mm, normal, forward) = place(s, h);
            let feed = forward * sense;
            let t = axis(normal, feed);
            let (r, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
            let across = normal - t * normal.dot(&t);
            let m = if core > 0.0 { across.normalize() } else { Vec3::zeros() };
            let pose = ToolPose { tip_mm: contact_mm + normal * r + m * core - t * r, axis: t };
            let previous = points.last().map_or([0.0, 0.0], |point| point.rotary_deg);
            let rotary_deg = nearest(&machine, &kinematics, points.len(), &pose, previous);
            let [first, second] = machine.rotary_axes();
            let rotary_deg = rotary_deg.map(|deg| (deg * 1e4).round() / 1e4);
            let rotary_rad = [first.angle_rad(rotary_deg[0]), second.angle_rad(rotary_deg[1])];
            // The written angles are the truth: tip and contact follow from them.
            let t = kinematics.axis(rotary_rad);
            let across = normal - t * normal.dot(&t);
            let m = if core > 0.0 { across.normalize() } else { Vec3::zeros() };
            let pose = ToolPose { tip_mm: contact_mm + normal * r + m * core - t * r, axis: t };
            points.push(FinishingPoint {
                contact_mm,
                normal,
                pose,
                linear_mm: kinematics.linear_mm(pose.tip_mm, rotary_rad),
                rotary_deg,
                contact_words_mm: kinematics.linear_mm(contact_mm, rotary_rad),
                first_of_pass: k == 0,
            });
        }
    }
    Finishing { name, machine, setup, tool, points }
}

fn nearest(
    machine: &Machine,
    kinematics: &Kinematics,
    index: usize,
    pose: &ToolPose,
    previous_deg: [f64; 2],
) -> [f64; 2] {
    let [first, second] = machine.rotary_axes();
    let free = previous_deg[1];
    kinematics
        .candidates(index, pose, free)
        .expect("a reachable pose")
        .iter()
        .map(|candidate| {
            let [a, c] = candidate.joints.rotary_rad;
            let words = [first.word_deg(a), second.word_deg(c)];
            // Both axes turn without end here: take the turn nearest to the previous word.
            std::array::from_fn(|k| words[k] + 360.0 * ((previous_deg[k] - words[k]) / 360.0).round())
        })
        .min_by(|a: &[f64; 2], b: &[f64; 2]| {
            let travel = |w: &[f64; 2]| (w[0] - previous_deg[0]).abs() + (w[1] - previous_deg[1]).abs();
            travel(a).total_cmp(&travel(b))
        })
        .expect("a candidate")
}

impl Finishing {
    /// The program as a post would write it, four decimals.
    pub fn program(&self, form: Form, feed: FeedForm) -> String {
        let mut text = String::new();
        let [first, second] = self.machine.rotary_axes();
        let (a, c) = (first.letter.as_char(), second.letter.as_char());
        if form == Form::NormalTable {
            writeln!(text, "X,Y,Z,{a},{c},nx,ny,nz,F").expect("text");
            for point in &self.points {
                let [x, y, z]: [f64; 3] = point.linear_mm.into();
                let [n1, n2, n3]: [f64; 3] = point.normal.into();
                let [p, q] = point.rotary_deg;
                writeln!(text, "{x:.4},{y:.4},{z:.4},{p:.4},{q:.4},{n1:.7},{n2:.7},{n3:.7},1200")
                    .expect("text");
            }
            return text;
        }
        writeln!(text, "%\n({})\nN10 G21 G90 G17 G54", self.name).expect("text");
        writeln!(text, "N20 T1 M6\nN30 S12000 M3").expect("text");
        if form == Form::Tcp {
            writeln!(text, "N40 G43.4 H1").expect("text");
        }
        let mut number = 50;
        for (k, point) in self.points.iter().enumerate() {
            let linear = if form == Form::Tcp { point.pose.tip_mm } else { point.linear_mm };
            let contact = if form == Form::Tcp { point.contact_mm } else { point.contact_words_mm };
            let [x, y, z]: [f64; 3] = linear.into();
            let [p, q] = point.rotary_deg;
            let code = match (point.first_of_pass, feed) {
                (true, _) => "G0 ",
                (false, FeedForm::InverseTime) => "G93 G1 ",
                (false, FeedForm::PerMinute) if self.points[k - 1].first_of_pass => "G94 G1 ",
                (false, FeedForm::PerMinute) => "",
            };
            write!(text, "N{number} {code}X{x:.4} Y{y:.4} Z{z:.4} {a}{p:.4} {c}{q:.4}").expect("text");
            if form != Form::Plain {
                let [u, v, w]: [f64; 3] = contact.into();
                write!(text, " U{u:.4} V{v:.4} W{w:.4}").expect("text");
            }
            match feed {
                FeedForm::InverseTime if !point.first_of_pass => write!(text, " F600.").expect("text"),
                FeedForm::PerMinute if code.starts_with("G94") => write!(text, " F1200.").expect("text"),
                _ => {}
            }
            text.push('\n');
            number += 10;
        }
        writeln!(text, "N{number} M5\nN{} M30\n%", number + 10).expect("text");
        text
    }
}
