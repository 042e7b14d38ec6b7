//! Inner loops of the compensation: the step that repairs the contact path, alone in this process, and the deviation.
//! What users call is timed by the benchmark `operations`. A program of a million blocks, 2 % of them over tolerance,
//! lies in a temporary file, and the output goes to another. Prints throughput and peak memory. With a word after `--`
//! only measurements whose name contains it are made: `cargo bench --bench compensation -- apt`.
#![expect(clippy::print_stdout, reason = "a benchmark prints what it measured")]

use std::fs::File;
use std::io::{self, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use models::set_ups::at_zero;
use trunnion::contact::{Carry, CutterContact, SourceBlock, Station, quick_look, rotary_rad};
use trunnion::geometry::Vec3;
use trunnion::kinematics::{JointLanes, Kinematics, PoseLanes, Setup, ToolPose};
use trunnion::machine::Tool;
use trunnion::motion::{AxisWords, Interpolation};
use trunnion::process::{
    CcParameters, ContactSource, ProgramSource, WearParameters, WornCutter, compensate_side_by_side,
    compensate_wear_side_by_side,
};
use trunnion::side_by_side::{OneAfterAnother, SideBySide};
use trunnion::units::Length;

#[path = "../tests/models/mod.rs"]
mod models;
mod programs;
mod threads;

use programs::{Form, words, write_program};
use threads::Threads;

struct OnDisk(PathBuf);

impl ProgramSource for OnDisk {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(File::open(&self.0)?))
    }
}

/// Blocks of the benchmark program.
const BLOCKS: u32 = 1_000_000;

/// Peak resident memory of this process [MiB]; 0 where the system does not say.
fn peak_memory_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// Whether a measurement of this name is asked for.
fn is_asked_for(name: &str) -> bool {
    let asked = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    asked.is_none_or(|asked| name.to_lowercase().contains(&asked.to_lowercase()))
}

fn main() -> io::Result<()> {
    let machine = models::finishing::ac_machine();
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    let folder = tempfile::tempdir()?;
    for (name, form, contact) in [
        ("feed-plane", Form::Iso, ContactSource::FeedPlane),
        ("tip", Form::Iso, ContactSource::Tip),
        ("U V W words", Form::ContactWords, ContactSource::Program),
    ] {
        if !is_asked_for(name) {
            continue;
        }
        let path = folder.path().join("program.nc");
        let bytes = write_program(&path, form, BLOCKS)?;
        let parameters = CcParameters { contact, ..CcParameters::new(tool, at_zero()) };
        for (cores, parts) in [("one core", &OneAfterAnother as &dyn SideBySide), ("two", &Threads(2))] {
            let mut seconds = Vec::new();
            let mut report = None;
            for _ in 0..3 {
                let mut output = File::create(folder.path().join("output.nc"))?;
                let start = Instant::now();
                let source = OnDisk(path.clone());
                let stop = || ControlFlow::Continue(());
                let done = compensate_side_by_side(&machine, &parameters, &source, &mut output, parts, &stop);
                seconds.push(start.elapsed().as_secs_f64());
                report = Some(done.expect("compensated"));
            }
            let report = report.expect("three runs");
            let seconds = median(seconds);
            println!(
                "whole pipeline, contact {name}, {cores}: {:.2} M blocks/s, {:.0} MB/s; {} of {} motions over tolerance, {} blocks out; peak {:.0} MiB",
                f64::from(BLOCKS) / seconds / 1e6,
                bytes as f64 / seconds / 1e6,
                report.motions_over_tolerance,
                report.motions_checked,
                report.blocks_out,
                peak_memory_mib(),
            );
        }
    }
    for form in [Form::Siemens, Form::Heidenhain, Form::Okuma, Form::Table, Form::CutterLocations] {
        if is_asked_for(form.name()) {
            in_form(&machine, tool, form, &folder.path().join("program.txt"))?;
        }
    }
    if is_asked_for("worn ball") {
        worn(&machine, tool, &folder.path().join("worn.nc"))?;
    }
    if is_asked_for("deviation") {
        one_by_one(&machine, tool);
        in_lanes(&machine, tool);
    }
    Ok(())
}

/// The whole pipeline in another dialect.
fn in_form(machine: &trunnion::machine::Machine, tool: Tool, form: Form, path: &Path) -> io::Result<()> {
    let bytes = write_program(path, form, BLOCKS)?;
    let parameters = CcParameters::new(tool, at_zero());
    for (cores, parts) in [("one core", &OneAfterAnother as &dyn SideBySide), ("two", &Threads(2))] {
        let mut seconds = Vec::new();
        let mut report = None;
        for _ in 0..3 {
            let mut output = File::create(path.with_extension("out"))?;
            let stop = || ControlFlow::Continue(());
            let source = OnDisk(path.to_owned());
            let start = Instant::now();
            let done = compensate_side_by_side(machine, &parameters, &source, &mut output, parts, &stop);
            seconds.push(start.elapsed().as_secs_f64());
            report = Some(done.expect("compensated"));
        }
        let report = report.expect("three runs");
        let seconds = median(seconds);
        println!(
            "whole pipeline, {}, {cores}: {:.2} M blocks/s, {:.0} MB/s; {} of {} motions over tolerance; peak {:.0} MiB",
            report.dialect,
            f64::from(BLOCKS) / seconds / 1e6,
            bytes as f64 / seconds / 1e6,
            report.motions_over_tolerance,
            report.motions_checked,
            peak_memory_mib(),
        );
    }
    Ok(())
}

/// The same program for a worn ball: every block moves.
fn worn(machine: &trunnion::machine::Machine, tool: Tool, path: &Path) -> io::Result<()> {
    let actual = Tool::new(Length::from_mm(4.75), Length::from_mm(4.75)).expect("a ball");
    let contact = ContactSource::FeedPlane;
    let parameters =
        WearParameters { contact, ..WearParameters::new(tool, WornCutter::Tool(actual), at_zero()) };
    let bytes = write_program(path, Form::Iso, BLOCKS)?;
    for (cores, parts) in [("one core", &OneAfterAnother as &dyn SideBySide), ("two", &Threads(2))] {
        let mut seconds = Vec::new();
        let mut moved = 0;
        for _ in 0..3 {
            let mut output = File::create(path.with_extension("out"))?;
            let (source, stop) = (OnDisk(path.to_owned()), || ControlFlow::Continue(()));
            let start = Instant::now();
            let done = compensate_wear_side_by_side(machine, &parameters, &source, &mut output, parts, &stop);
            seconds.push(start.elapsed().as_secs_f64());
            moved = done.expect("moved").motions_shifted;
        }
        let seconds = median(seconds);
        println!(
            "worn ball, contact feed-plane, {cores}: {:.2} M blocks/s, {:.0} MB/s; {moved} motions moved; peak {:.0} MiB",
            f64::from(BLOCKS) / seconds / 1e6,
            bytes as f64 / seconds / 1e6,
            peak_memory_mib(),
        );
    }
    Ok(())
}

/// What the judge does for every motion: poses of ends and middles in lanes of 512, then one look at each block with
/// the contact's normal at both ends.
fn in_lanes(machine: &trunnion::machine::Machine, tool: Tool) {
    let kinematics = Kinematics::new(machine, &Setup::default());
    let mode = Interpolation::Machine;
    let mut state = [35.0, 0.0];
    let points: Vec<AxisWords> = (0..200_001).map(|index| words(&mut state, index)).collect();
    let (mut joints, mut ends, mut middles) =
        (JointLanes::default(), PoseLanes::default(), PoseLanes::default());
    let start = Instant::now();
    let (mut within, mut undecided) = (0_u32, 0_u32);
    for batch in points.windows(2).collect::<Vec<_>>().chunks(512) {
        joints.clear();
        joints.push(batch[0][0].linear_mm, rotary_rad(machine, batch[0][0].rotary_deg));
        for pair in batch {
            joints.push(pair[1].linear_mm, rotary_rad(machine, pair[1].rotary_deg));
        }
        kinematics.forward_lanes(&joints, &mut ends);
        joints.clear();
        for pair in batch {
            let half = |a: f64, b: f64| 0.5 * (a + b);
            let linear_mm = std::array::from_fn(|k| half(pair[0].linear_mm[k], pair[1].linear_mm[k]));
            let rotary_deg = std::array::from_fn(|k| half(pair[0].rotary_deg[k], pair[1].rotary_deg[k]));
            joints.push(linear_mm, rotary_rad(machine, rotary_deg));
        }
        kinematics.forward_lanes(&joints, &mut middles);
        for (k, pair) in batch.iter().enumerate() {
            let stations = [0, 1].map(|end| Station { words: pair[end], pose: pose(&ends, k + end) });
            let contacts = stations.map(|station| CutterContact::Normal {
                direction: (station.pose.axis + Vec3::new(0.1, 0.2, 0.0)).normalize(),
                magnitude: 1.0,
            });
            let contacts_mm = [0, 1].map(|end| {
                let pose = &stations[end].pose;
                pose.tip_mm + contacts[end].offset_mm(&tool, pose.axis)
            });
            let middle = pose(&middles, k);
            let references = [&contacts[0], &contacts[1]];
            let look =
                quick_look(&kinematics, &tool, mode, stations.each_ref(), references, contacts_mm, &middle);
            if look.is_some_and(|look| look.at_most_mm <= 0.01) {
                within += 1;
            } else {
                undecided += 1;
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "deviation at 10 µm in lanes, with normals: {:.2} M blocks/s ({within} decided, {undecided} to be sampled)",
        f64::from(within + undecided) / seconds / 1e6
    );
}

fn pose(lanes: &PoseLanes, k: usize) -> ToolPose {
    ToolPose {
        tip_mm: Vec3::new(lanes.x_mm[k], lanes.y_mm[k], lanes.z_mm[k]),
        axis: Vec3::new(lanes.i[k], lanes.j[k], lanes.k[k]),
    }
}

/// The deviation in the middle of a block, stations and contact included, one block at a time: what the batches are
/// measured against.
fn one_by_one(machine: &trunnion::machine::Machine, tool: Tool) {
    let kinematics = Arc::new(Kinematics::new(machine, &Setup::default()));
    let mode = Interpolation::Machine;
    let mut state = [35.0, 0.0];
    let points: Vec<AxisWords> = (0..200_000).map(|index| words(&mut state, index)).collect();
    let start = Instant::now();
    let mut largest: f64 = 0.0;
    for pair in points.windows(2) {
        let ends = [pair[0], pair[1]].map(|words| Station::new(machine, &kinematics, mode, words));
        let block = SourceBlock::new(machine, &kinematics, tool, mode, ends, Carry::Tip);
        largest = largest.max(block.deviation_at(&block.whole(), 0.5).distance_mm);
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "deviation at the middle, one block at a time: {:.2} M blocks/s (largest {:.1} µm)",
        points.len() as f64 / seconds / 1e6,
        largest * 1000.0
    );
}
