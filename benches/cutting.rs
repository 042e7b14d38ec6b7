//! Virtual cutting of whole programs over many samples: `cargo bench --bench cutting`.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::time::Instant;

use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup};
use trunnion::machine::{Machine, Preset, Tool};
use trunnion::process::{ProgramSetup, VerificationParameters, verify_part};
use trunnion::side_by_side::{OneAfterAnother, SideBySide};
use trunnion::surface::SurfacePoint;
use trunnion::units::Length;

mod threads;

use threads::Threads;

const SAMPLES: usize = 200_000;
const BLOCKS: usize = 50_000;

fn peak_memory_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}

/// A wavy patch of 100 × 100 mm.
fn surface(x: f64, y: f64) -> SurfacePoint {
    let (a, b) = (0.06 * x, 0.05 * y);
    let z = 3.0 * a.sin() * b.cos();
    let normal = Vec3::new(-3.0 * 0.06 * a.cos() * b.cos(), 3.0 * 0.05 * a.sin() * b.sin(), 1.0).normalize();
    SurfacePoint { point_mm: Vec3::new(x, y, z), normal }
}

fn samples() -> Vec<SurfacePoint> {
    let side = SAMPLES.isqrt() + 1;
    (0..SAMPLES)
        .map(|k| {
            let at = |k: usize| (k as f64 + 0.5) / side as f64 * 100.0 - 50.0;
            surface(at(k % side), at(k / side))
        })
        .collect()
}

/// Zigzag over the patch with the axis off the normal, and (five-axis) swinging along.
fn program(machine: &Machine, tool: &Tool, blocks: usize, five_axis: bool, tcp: bool) -> String {
    let kinematics = Kinematics::new(machine, &Setup::default());
    let per_pass = 250;
    let count = blocks / per_pass;
    let mut text = String::from(if tcp { "G90 G21 G43.4 H1\n" } else { "G90 G21\n" });
    for pass in 0..count {
        let y = -50.0 + 100.0 * (pass as f64 + 0.5) / count as f64;
        for k in 0..=per_pass {
            let along = k as f64 / per_pass as f64;
            let x = if pass % 2 == 0 { 100.0 * along - 50.0 } else { 50.0 - 100.0 * along };
            let SurfacePoint { point_mm, normal } = surface(x, y);
            let rotary_deg =
                if five_axis { [15.0 + 0.1 * y, 30.0 + 40.0 * (0.03 * x).sin()] } else { [15.0, 0.0] };
            let rotary_rad = rotary_deg.map(f64::to_radians);
            let t = kinematics.axis(rotary_rad);
            let core = tool.core_radius().mm();
            let m = if core > 0.0 { (normal - t * normal.dot(&t)).normalize() } else { Vec3::zeros() };
            let r = tool.corner_radius().mm();
            let tip = point_mm + normal * r + m * core - t * r;
            let at = if tcp { tip } else { kinematics.linear_mm(tip, rotary_rad) };
            let code = if k == 0 && pass == 0 { "G0" } else { "G1" };
            let _ = writeln!(
                text,
                "{code} X{:.4} Y{:.4} Z{:.4} A{:.4} C{:.4}",
                at.x, at.y, at.z, rotary_deg[0], rotary_deg[1]
            );
        }
    }
    text
}

#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn main() {
    let machine =
        Machine::new(Preset::by_id("example-ac-table").expect("the preset").parts()).expect("a machine");
    let samples = samples();
    let go_on = || ControlFlow::Continue(());
    let tool = |radius, corner| Tool::new(Length::from_mm(radius), Length::from_mm(corner)).expect("a tool");
    let cases = [
        ("ball 5, three axes", tool(5.0, 5.0), BLOCKS, false, false),
        ("ball 5, five axes, TCP", tool(5.0, 5.0), BLOCKS, true, true),
        ("ball 5, five axes, machine", tool(5.0, 5.0), BLOCKS, true, false),
        ("bull-nose 5/1, five axes, TCP", tool(5.0, 1.0), BLOCKS, true, true),
        ("flat 5, five axes, TCP", tool(5.0, 0.0), BLOCKS, true, true),
        ("ball 5, five axes, TCP, two million blocks", tool(5.0, 5.0), 2_000_000, true, true),
    ];
    let only = std::env::args().nth(1).filter(|name| !name.starts_with("--"));
    for (name, tool, blocks, five_axis, tcp) in cases {
        if only.as_ref().is_some_and(|only| !name.contains(only.as_str())) {
            continue;
        }
        let text = program(&machine, &tool, blocks, five_axis, tcp).into_bytes();
        let parameters = VerificationParameters::new(tool, ProgramSetup::in_mm(&Setup::default()));
        let several = Threads(2);
        let ways: [(&str, &dyn SideBySide); 2] =
            [("one thread", &OneAfterAnother), ("two threads", &several)];
        for (way, parts) in ways {
            if blocks > BLOCKS && way == "one thread" {
                continue;
            }
            let start = Instant::now();
            let found =
                verify_part(&machine, &parameters, &samples, &text, parts, &go_on).expect("a verification");
            let seconds = start.elapsed().as_secs_f64();
            let summary = &found.summary;
            let um = |extreme: Option<trunnion::process::Extreme>| {
                extreme.map_or(0.0, |found| found.residual.residual_mm * 1e3)
            };
            println!(
                "{name}, {way}: {blocks} blocks, {} samples: {seconds:6.2} s; {} pieces, {:.1} million pairs, \
                 {:.2} cuts a sample; uncut {}, {:.2} … {:.2} µm, moved {:.4} µm; peak memory {:.0} MiB",
                samples.len(),
                found.effort.pieces,
                found.effort.pairs as f64 / 1e6,
                found.effort.cuts as f64 / samples.len() as f64,
                summary.uncut,
                um(summary.max_gouge),
                um(summary.max_excess),
                found.convergence.max_change.mm() * 1e3,
                peak_memory_mib(),
            );
        }
    }
}
