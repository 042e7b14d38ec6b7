//! A table of poses on its way from the body to the path: in memory, or from some length on in a file.

use std::io;
use std::ops::ControlFlow;

use tokio::task::JoinHandle;

use super::Spool;
use super::pose_file::{PoseFile, PoseFileWriter};
use crate::kinematics::{PoseBlock, PoseLanes, PoseSource, Poses, ToolPose};
use crate::process::Stop;
use crate::wire::{PoseColumns, PoseRows, RowFault};

/// Poses of a table that stay in memory, if the table has no more: 6 MiB. A longer table waits in a file.
pub const POSES_IN_MEMORY: usize = 131_072;
/// Poses that are collected before they are written, once there is a file: 384 KiB.
const COLLECTED: usize = 8_192;

/// A table of poses that is being received.
#[derive(Debug)]
pub struct PoseTable {
    rows: PoseRows,
    /// Where the poses may wait, and how many of them do not.
    waits: Option<(Spool, usize)>,
    /// The file, from the first poses on that went there.
    writing: Option<Writing>,
}

impl PoseTable {
    /// A table of at most `max_rows` rows, all of them in memory.
    #[must_use]
    pub fn in_memory(max_rows: usize) -> Self {
        Self { rows: PoseRows::new(max_rows), waits: None, writing: None }
    }

    /// The same with a file in `spool` for all poses, once there are more than `most_in_memory`.
    #[must_use]
    pub fn waiting_in(self, spool: &Spool, most_in_memory: usize) -> Self {
        Self { waits: Some((spool.clone(), most_in_memory)), ..self }
    }

    /// Memory that one more row takes while the table grows \[bytes\].
    #[must_use]
    pub fn row_bytes(&self) -> usize {
        // What is collected for the file takes the memory of the poses that went there first.
        if self.writing.is_some() { 0 } else { PoseColumns::GROWING_BYTES }
    }

    /// Takes the next bytes; the cuts may be anywhere. Then [`PoseTable::settle`].
    ///
    /// # Errors
    /// A fault after which nothing can be read, or a hundred faulty cells.
    pub fn feed(&mut self, chunk: &[u8]) -> Result<(), RowFault> {
        self.rows.feed(chunk)
    }

    /// Begins to write the poses to the file, if there are more than should stay in memory. The next ones are read
    /// meanwhile.
    ///
    /// # Errors
    /// The file cannot be made or written, or there is no room for it in the spool.
    pub async fn settle(&mut self) -> io::Result<()> {
        let Some((spool, most_in_memory)) = &self.waits else { return Ok(()) };
        let most = if self.writing.is_some() { COLLECTED.min(*most_in_memory) } else { *most_in_memory };
        if self.rows.held() <= most {
            return Ok(());
        }
        let (file, memory) = written(self.writing.take()).await?.unzip();
        let poses = self.rows.take(memory.unwrap_or_default());
        let (blobs, room) = (spool.blobs().clone(), spool.room());
        self.writing = Some(tokio::task::spawn_blocking(move || {
            let Some(mut file) = file else {
                let mut file = PoseFileWriter::new(blobs.nameless()?, room);
                file.append(&poses)?;
                // Much more memory than the next ones need.
                return Ok((file, PoseLanes::default()));
            };
            file.append(&poses)?;
            Ok((file, poses))
        }));
        Ok(())
    }

    /// The poses, after the last byte: every faulty cell, or a missing header is a fault of the rows.
    ///
    /// # Errors
    /// As for [`PoseTable::settle`].
    pub async fn finish(self) -> io::Result<Result<ReceivedPoses, RowFault>> {
        let file = written(self.writing).await?.map(|(file, _)| file);
        Ok(self.rows.finish().map(|columns| ReceivedPoses { columns, file }))
    }
}

/// What comes of writing: the file, and memory for poses to use again.
type Writing = JoinHandle<io::Result<(PoseFileWriter, PoseLanes)>>;

/// The file once it is written.
async fn written(writing: Option<Writing>) -> io::Result<Option<(PoseFileWriter, PoseLanes)>> {
    match writing {
        Some(writing) => writing.await.map_err(io::Error::other)?.map(Some),
        None => Ok(None),
    }
}

/// Poses that were received, but not checked.
#[derive(Debug)]
pub struct ReceivedPoses {
    /// Those in memory; they count and know the faults of all.
    columns: PoseColumns,
    /// The file with those before.
    file: Option<PoseFileWriter>,
}

impl From<PoseColumns> for ReceivedPoses {
    fn from(columns: PoseColumns) -> Self {
        Self { columns, file: None }
    }
}

impl ReceivedPoses {
    /// The number of poses, faulty ones included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether there is no pose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The poses in memory.
    ///
    /// # Errors
    /// Some poses are in a file: the table itself.
    pub fn in_memory(self) -> Result<PoseColumns, Box<Self>> {
        if self.file.is_some() { Err(Box::new(self)) } else { Ok(self.columns) }
    }

    /// The poses in memory and the file with those before.
    pub(super) fn parts(self) -> (PoseColumns, Option<PoseFileWriter>) {
        (self.columns, self.file)
    }
}

/// Checked poses where they wait.
#[derive(Debug)]
pub struct WaitingPoses(Kept);

#[derive(Debug)]
enum Kept {
    InMemory(PoseLanes),
    InFile(PoseFile),
}

impl WaitingPoses {
    /// Poses in memory, or the last of those in a file. Blocks.
    ///
    /// # Errors
    /// The file cannot be written, or there is no room for it in the spool.
    pub(super) fn new(poses: PoseLanes, file: Option<PoseFileWriter>) -> io::Result<Self> {
        let Some(mut file) = file else { return Ok(Self(Kept::InMemory(poses))) };
        file.append(&poses)?;
        Ok(Self(Kept::InFile(file.finish())))
    }

    /// `stop`, which also stops once poses could not be read.
    pub fn or_unread<'a>(&'a self, stop: &'a Stop<'a>) -> impl Fn() -> ControlFlow<()> + Sync + 'a {
        move || match &self.0 {
            Kept::InFile(file) if file.has_failed() => ControlFlow::Break(()),
            _ => stop(),
        }
    }

    /// Why poses could not be read, if that happened.
    pub fn take_fault(&mut self) -> Option<io::Error> {
        match &mut self.0 {
            Kept::InMemory(_) => None,
            Kept::InFile(file) => file.take_fault(),
        }
    }

    fn source(&self) -> &dyn PoseSource {
        match &self.0 {
            Kept::InMemory(poses) => poses,
            Kept::InFile(file) => file,
        }
    }
}

impl PoseSource for WaitingPoses {
    fn count(&self) -> usize {
        self.source().count()
    }

    fn block<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> Poses<'a> {
        self.source().block(start, copy)
    }

    fn pose(&self, index: usize) -> ToolPose {
        self.source().pose(index)
    }

    fn tips<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> [&'a [f64; PoseBlock::LEN]; 3] {
        self.source().tips(start, copy)
    }
}

#[cfg(test)]
mod tests;
