//! Deviation, and the whole compensation of a program of a million blocks, 2 % of them over tolerance. Prints
//! throughput and peak memory; the program lies in a temporary file and the output goes to another. With a word behind
//! `--` only measurements whose name contains it are made, as in `cargo bench --bench compensation -- apt`.
#![expect(clippy::print_stdout, reason = "a benchmark prints what it measured")]

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
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
mod threads;

use threads::Threads;

struct OnDisk(PathBuf);

impl ProgramSource for OnDisk {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(File::open(&self.0)?))
    }
}

/// Blocks of the benchmark program.
const BLOCKS: u32 = 1_000_000;
/// One block in fifty turns further.
const LONG_EVERY: u32 = 50;

fn words(state: &mut [f64; 2], index: u32) -> AxisWords {
    let long = index.is_multiple_of(LONG_EVERY);
    let sense = if (index / 700).is_multiple_of(2) { 1.0 } else { -1.0 };
    state[1] += sense * if long { 2.6 } else { 0.31 };
    let phase = f64::from(index) / 400.0;
    state[0] = 35.0 + 12.0 * phase.sin();
    let x = 80.0 + 15.0 * (phase * 0.7).cos();
    let y = -20.0 + 11.0 * (phase * 0.9).sin();
    AxisWords { linear_mm: [x, y, 40.0 + 5.0 * phase.cos()], rotary_deg: *state }
}

fn write_program(path: &Path, contact_words: bool) -> io::Result<u64> {
    let mut out = BufWriter::new(File::create(path)?);
    writeln!(out, "%\nG21 G90 G94 G54\nG1 F3000")?;
    let mut state = [35.0, 0.0];
    for index in 0..BLOCKS {
        let AxisWords { linear_mm: [x, y, z], rotary_deg: [a, c] } = words(&mut state, index);
        write!(out, "X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4}")?;
        if contact_words {
            write!(out, " U{:.4} V{:.4} W{:.4}", x + 1.4, y - 2.2, z + 0.7)?;
        }
        writeln!(out)?;
    }
    writeln!(out, "M30\n%")?;
    out.flush()?;
    Ok(std::fs::metadata(path)?.len())
}

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
    asked.is_none_or(|asked| name.contains(&asked))
}

fn main() -> io::Result<()> {
    let machine = models::finishing::ac_machine();
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    let folder = tempfile::tempdir()?;
    for (name, contact_words, contact) in [
        ("feed-plane", false, ContactSource::FeedPlane),
        ("tip", false, ContactSource::Tip),
        ("U V W words", true, ContactSource::Program),
    ] {
        if !is_asked_for(name) {
            continue;
        }
        let path = folder.path().join("program.nc");
        let bytes = write_program(&path, contact_words)?;
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
    for form in [Form::Siemens, Form::Conversational, Form::Table, Form::CutterLocations] {
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

/// Another dialect than ISO.
#[derive(Debug, Clone, Copy)]
enum Form {
    Siemens,
    Conversational,
    Table,
    CutterLocations,
}

impl Form {
    /// What it is called in reports.
    const fn name(self) -> &'static str {
        match self {
            Self::Siemens => "siemens",
            Self::Conversational => "heidenhain",
            Self::Table => "csv",
            Self::CutterLocations => "apt",
        }
    }
}

/// The same program in another form: points and vectors where it is of cutter locations.
fn write_in_form(path: &Path, form: Form) -> io::Result<u64> {
    let mut out = BufWriter::new(File::create(path)?);
    match form {
        Form::Siemens => writeln!(out, "; a program\nN1 G71 G90 G94 G54\nN2 G1 F3000")?,
        Form::Conversational => {
            writeln!(out, "0 BEGIN PGM P MM\n1 L X+80 Y-20 Z+40 A+35 C+0 R0 F3000 M3")?;
        }
        Form::Table => writeln!(out, "X,Y,Z,A,C,F")?,
        Form::CutterLocations => writeln!(out, "PARTNO/P\nUNITS/MM\nMULTAX/ON\nFEDRAT/3000.,MMPM")?,
    }
    let mut state = [35.0, 0.0];
    for index in 0..BLOCKS {
        let AxisWords { linear_mm: [x, y, z], rotary_deg: [a, c] } = words(&mut state, index);
        match form {
            Form::Siemens => writeln!(out, "N{} X{x:.4} Y{y:.4} Z{z:.4} A={a:.4} C={c:.4}", index + 3)?,
            Form::Conversational => {
                writeln!(out, "{} L X{x:+.4} Y{y:+.4} Z{z:+.4} A{a:+.4} C{c:+.4}", index + 2)?;
            }
            Form::Table => writeln!(out, "{x:.4},{y:.4},{z:.4},{a:.4},{c:.4},3000")?,
            Form::CutterLocations => {
                let ((sa, ca), (sc, cc)) = (a.to_radians().sin_cos(), c.to_radians().sin_cos());
                writeln!(out, "GOTO/{x:.4},{y:.4},{z:.4},{:.7},{:.7},{ca:.7}", sa * sc, -sa * cc)?;
            }
        }
    }
    match form {
        Form::Siemens => writeln!(out, "M30")?,
        Form::Conversational => writeln!(out, "{} END PGM P MM", BLOCKS + 2)?,
        Form::Table => {}
        Form::CutterLocations => writeln!(out, "FINI")?,
    }
    out.flush()?;
    Ok(std::fs::metadata(path)?.len())
}

/// The whole pipeline in another dialect.
fn in_form(machine: &trunnion::machine::Machine, tool: Tool, form: Form, path: &Path) -> io::Result<()> {
    let bytes = write_in_form(path, form)?;
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
    let bytes = write_program(path, false)?;
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
