use std::fs::File;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use super::*;
use crate::jobs::{InverseTask, KinematicsFault, Limits, MachineUsed, ToolShelf};
use crate::kinematics::Setup;
use crate::machine::Preset;
use crate::shares::{NoShare, Quota, Share, Shares};
use crate::side_by_side::OneAfterAnother;
use crate::store::Blobs;
use crate::wire::{KinematicsOptions, MachineProfile, RotaryWords, Selection, write_path_rows};

const GO_ON: &Stop<'static> = &|| ControlFlow::Continue(());
const LIMITS: Limits = Limits { max_poses: 20_000, max_cost_s: f64::INFINITY };
/// Lengths at and beside the ends of blocks and of the pieces that are read.
const COUNTS: [usize; 8] = [1, 127, 128, 129, 1_024, 1_025, 2_000, 9_000];

/// What a request comes to.
#[derive(Debug, PartialEq)]
enum Outcome {
    Answered { text: String, warnings: usize },
    Rows(RowFault),
    Refused(KinematicsFault),
}

#[derive(Debug)]
enum Failed {
    Refused(KinematicsFault),
    Unwritten(io::Error),
}

impl From<KinematicsFault> for Failed {
    fn from(fault: KinematicsFault) -> Self {
        Self::Refused(fault)
    }
}

impl From<io::Error> for Failed {
    fn from(fault: io::Error) -> Self {
        Self::Unwritten(fault)
    }
}

fn task(options: &KinematicsOptions) -> InverseTask {
    let mut parts = Preset::by_id("ac-table").unwrap().parts();
    for axis in &mut parts.rotary_axes {
        // Without several turns.
        axis.travel_deg = axis.travel_deg.filter(|travel| travel.max - travel.min < 360.0);
    }
    let profile = MachineProfile::from(&parts);
    let on = MachineUsed::new("m".to_owned(), 1, profile, ToolShelf::default()).unwrap();
    let (_, start) = options.to_setup(&on.machine).unwrap();
    let setup = Setup { tool_length_mm: 80.0, ..Setup::default() };
    InverseTask::new(Arc::new(on), &setup, options.selection.unwrap_or_default(), start)
}

fn spool(folder: &Path) -> Spool {
    Spool::new(Blobs::open(folder).unwrap(), u64::MAX)
}

/// Files in the spool that have a name.
fn names(folder: &Path) -> usize {
    std::fs::read_dir(folder.join("spool")).unwrap().count()
}

/// A path that is inside the pole cone for its first `held` poses and now and then later, and turns about the pole.
fn rows(count: usize, held: usize) -> Vec<String> {
    let row = |n: usize| {
        let s = n as f64 * 1e-2;
        let tilt = if n < held || n % 700 < 3 { 0.0 } else { 0.4 + 0.3 * (3.0 * s).sin() };
        let [i, j] = [tilt.sin() * (0.7 * s).cos(), tilt.sin() * (0.7 * s).sin()];
        format!("{},{},{},{i},{j},{}", 40.0 * s.cos(), 30.0 * s.sin(), 5.0 + s, tilt.cos())
    };
    (0..count).map(row).collect()
}

fn table(rows: &[String]) -> String {
    format!("x,y,z,i,j,k\n{}\n", rows.join("\n"))
}

/// Receives a table in chunks of this length.
async fn receive(table: &mut PoseTable, text: &str, chunk: usize) -> io::Result<Result<(), RowFault>> {
    for chunk in text.as_bytes().chunks(chunk) {
        if let Err(fault) = table.feed(chunk) {
            return Ok(Err(fault));
        }
        table.settle().await?;
    }
    Ok(Ok(()))
}

fn printed(task: &InverseTask, poses: &WaitingPoses, text: &mut Vec<u8>) -> Result<usize, Failed> {
    let (options, stop) = (task.path_options(), poses.or_unread(GO_ON));
    let mut decided = task.decide(poses, &options, &stop)?;
    let fault = |error| Failed::Refused(task.fault(error));
    write_path_rows(task.machine(), &mut decided, &OneAfterAnother, text, fault)?;
    Ok(decided.warnings())
}

async fn outcome(task: &InverseTask, text: &str, chunk: usize, waits: Option<(&Spool, usize)>) -> Outcome {
    let mut table = PoseTable::in_memory(LIMITS.max_poses);
    if let Some((spool, most)) = waits {
        table = table.waiting_in(spool, most);
    }
    if let Err(fault) = receive(&mut table, text, chunk).await.unwrap() {
        return Outcome::Rows(fault);
    }
    let received = match table.finish().await.unwrap() {
        Ok(received) => received,
        Err(fault) => return Outcome::Rows(fault),
    };
    let is_long = waits.is_some_and(|(_, most)| received.len() > most);
    assert_eq!(received.file.is_some(), is_long);
    let done = || {
        let mut poses = task.waiting::<Failed>(received, LIMITS)?;
        let mut text = Vec::new();
        let warnings = printed(task, &poses, &mut text)?;
        assert!(poses.take_fault().is_none());
        Ok((text, warnings))
    };
    match done() {
        Ok((text, warnings)) => Outcome::Answered { text: String::from_utf8(text).unwrap(), warnings },
        Err(Failed::Refused(fault)) => Outcome::Refused(fault),
        Err(Failed::Unwritten(fault)) => panic!("{fault}"),
    }
}

#[tokio::test]
async fn a_table_has_the_same_answer_from_memory_and_from_a_file() {
    let folder = TempDir::new().unwrap();
    let spool = spool(folder.path());
    let started = RotaryWords { a: Some(-20.0), c: Some(100.0), ..RotaryWords::default() };
    for start in [None, Some(started)] {
        let task = task(&KinematicsOptions { start, ..KinematicsOptions::default() });
        assert!(task.may_wait());
        for (count, held) in COUNTS.into_iter().zip([0, 127, 128, 300, 0, 130, 2_000, 300]) {
            let text = table(&rows(count, held));
            let in_memory = outcome(&task, &text, 1 << 16, None).await;
            let Outcome::Answered { text: answer, .. } = &in_memory else { panic!("{in_memory:?}") };
            assert_eq!(answer.lines().count(), count);
            for (most, chunk) in [(0, 100_000), (100, 999), (1_000, 4_096), (8_999, 70_000)] {
                let waited = outcome(&task, &text, chunk, Some((&spool, most))).await;
                assert!(waited == in_memory, "{count} poses, {most} in memory, start {start:?}");
                assert_eq!(names(folder.path()), 0);
            }
        }
    }
}

#[tokio::test]
async fn a_refusal_is_the_same_and_names_the_same_row() {
    let folder = TempDir::new().unwrap();
    let spool = spool(folder.path());
    let task = task(&KinematicsOptions::default());
    let tables: [(&str, &[(usize, &str)]); 5] = [
        ("pose 2500", &[(2_500, "0,0,0,0,0,-1")]),
        ("pose 2999", &[(130, "0,0,0,0,0,1"), (2_999, "0,0,0,0,0,-1")]),
        ("3 values", &[(5, "0,0,0,0,0,0"), (2_000, "1e9,0,0,0,0,1"), (2_001, "0,0,0,0,0,0")]),
        ("line 2702", &[(7, "0,0,0,0,0,1"), (2_700, "0,x,0,0,0,1"), (2_900, "0,0,0,0,0")]),
        ("1 values", &[(1_000, "0,0,0,0,0,-1"), (2_000, "0,0,0,0,0,0")]),
    ];
    let mut refused = Vec::new();
    for (expected, changes) in tables {
        let mut rows = rows(3_000, 0);
        for (row, text) in changes {
            rows[*row] = (*text).to_owned();
        }
        refused.push((expected, table(&rows)));
    }
    refused.push(("too many", table(&rows(LIMITS.max_poses + 1, 0))));
    for (expected, text) in refused {
        let in_memory = outcome(&task, &text, 1 << 16, None).await;
        assert!(!matches!(in_memory, Outcome::Answered { .. }), "{expected}");
        for most in [0, 500] {
            assert_eq!(outcome(&task, &text, 5_000, Some((&spool, most))).await, in_memory, "{expected}");
        }
        let told = match &in_memory {
            Outcome::Refused(KinematicsFault::Unreachable { pose, .. }) => format!("pose {pose}"),
            Outcome::Refused(KinematicsFault::Values(faults)) => format!("{} values", faults.len()),
            Outcome::Rows(RowFault { too_many: true, .. }) => "too many".to_owned(),
            Outcome::Rows(RowFault { line, .. }) => format!("line {line}"),
            other => panic!("{other:?}"),
        };
        assert_eq!(told, expected);
    }
    assert_eq!(names(folder.path()), 0);
}

#[test]
fn only_one_answer_for_each_pose_of_axes_of_one_turn_may_wait() {
    let all = KinematicsOptions { selection: Some(Selection::All), ..KinematicsOptions::default() };
    assert!(!task(&all).may_wait());
    assert!(task(&KinematicsOptions::default()).may_wait());
}

/// Checked poses in a file, and the file itself.
fn in_file(count: usize) -> (WaitingPoses, File) {
    let mut read = PoseRows::new(count);
    read.feed(table(&rows(count, 0)).as_bytes()).unwrap();
    let file = tempfile::tempfile().unwrap();
    let writer = PoseFileWriter::new(file.try_clone().unwrap(), None);
    (WaitingPoses::new(read.finish().unwrap().into_core().unwrap(), Some(writer)).unwrap(), file)
}

#[test]
fn no_row_is_made_of_poses_that_cannot_be_read() {
    const COUNT: usize = 9_000;
    const POSE_BYTES: u64 = 48;
    let task = task(&KinematicsOptions::default());
    let (poses, _file) = in_file(COUNT);
    let mut whole = Vec::new();
    printed(&task, &poses, &mut whole).unwrap();
    for kept in [0, 1, 1_000, 5_000, 8_999] {
        // While the path is decided.
        let (mut poses, file) = in_file(COUNT);
        file.set_len(kept * POSE_BYTES).unwrap();
        let mut text = Vec::new();
        printed(&task, &poses, &mut text).unwrap_err();
        assert!(text.is_empty());
        assert_eq!(poses.take_fault().unwrap().kind(), io::ErrorKind::UnexpectedEof);
        // While its joints are made.
        let (mut poses, file) = in_file(COUNT);
        {
            let (options, stop) = (task.path_options(), poses.or_unread(GO_ON));
            let mut decided = task.decide(&poses, &options, &stop).unwrap();
            file.set_len(kept * POSE_BYTES).unwrap();
            let fault = |error| Failed::Refused(task.fault(error));
            write_path_rows(task.machine(), &mut decided, &OneAfterAnother, &mut text, fault).unwrap_err();
        }
        assert!(whole.starts_with(&text) && text.len() < whole.len());
        let made = String::from_utf8(text).unwrap().lines().count() as u64;
        assert!(made <= kept, "{made} of {kept}");
        assert_eq!(poses.take_fault().unwrap().kind(), io::ErrorKind::UnexpectedEof);
    }
}

#[tokio::test]
async fn a_spool_that_takes_no_more_refuses_the_table_and_keeps_nothing() {
    let folder = TempDir::new().unwrap();
    let text = table(&rows(3_000, 0));
    // Room for half of the poses.
    let shares = Shares::new(Quota::SpoolBytes, 1_500 * 48, Share(1.0));
    let narrow = spool(folder.path()).shared(shares.clone());
    let asked = crate::jobs::asked_by(crate::shares::Who::Others, async {
        let mut table = PoseTable::in_memory(3_000).waiting_in(&narrow, 500);
        receive(&mut table, &text, 5_000).await.unwrap_err()
    });
    let fault = asked.await;
    let cause = fault.get_ref().and_then(|cause| cause.downcast_ref::<NoShare>());
    assert!(matches!(cause, Some(NoShare::Full { quota: Quota::SpoolBytes, .. })), "{fault}");
    assert_eq!((shares.held(), names(folder.path())), (0, 0));
    let gone = spool(folder.path());
    std::fs::remove_dir(folder.path().join("spool")).unwrap();
    let mut table = PoseTable::in_memory(3_000).waiting_in(&gone, 500);
    let fault = receive(&mut table, &text, 5_000).await.unwrap_err();
    assert_eq!(fault.kind(), io::ErrorKind::NotFound);
}
