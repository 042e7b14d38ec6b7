//! The poses of a long table in a file without a name, so that they hold no memory while the path through them is
//! decided and its joints are printed.

use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::kinematics::{PoseBlock, PoseLanes, PoseSource, Poses, ToolPose};
use crate::shares::Held;

/// Numbers of a pose: x y z \[mm\], i j k.
const NUMBERS: usize = 6;
/// A pose in the file: its numbers one after the other, the lowest byte of each first \[bytes\].
const POSE_BYTES: usize = NUMBERS * size_of::<f64>();
/// Poses that are written and read at a time, a whole number of blocks: 48 KiB, which stay in the second-nearest cache.
const PIECE: usize = 8 * PoseBlock::LEN;
/// Stands for a pose that cannot be read. No joints that are made of it are sent.
const UNREAD: [f64; NUMBERS] = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// A file of poses that is being written.
#[derive(Debug)]
pub(super) struct PoseFileWriter {
    file: File,
    /// Its share of the spool, if the spool is shared.
    room: Option<Held>,
    count: usize,
}

impl PoseFileWriter {
    /// An empty file of poses. Its bytes are counted in `room`.
    pub(super) fn new(file: File, room: Option<Held>) -> Self {
        Self { file, room, count: 0 }
    }

    /// Writes poses after the others. Blocks.
    ///
    /// # Errors
    /// The file cannot be written, or there is no room for it in the spool.
    pub(super) fn append(&mut self, poses: &PoseLanes) -> io::Result<()> {
        let count = poses.len();
        if let Some(room) = &mut self.room {
            room.take_more((count * POSE_BYTES) as u64).map_err(io::Error::other)?;
        }
        let PoseLanes { x_mm, y_mm, z_mm, i, j, k } = poses;
        let mut rows = x_mm.iter().zip(y_mm).zip(z_mm).zip(i).zip(j).zip(k);
        let mut piece = Vec::with_capacity(count.min(PIECE) * POSE_BYTES);
        for _ in 0..count.div_ceil(PIECE) {
            piece.clear();
            for (((((x, y), z), i), j), k) in rows.by_ref().take(PIECE) {
                piece.extend_from_slice([x, y, z, i, j, k].map(|value| value.to_le_bytes()).as_flattened());
            }
            self.file.write_all(&piece)?;
        }
        self.count += count;
        Ok(())
    }

    /// The file, to be read.
    pub(super) fn finish(self) -> PoseFile {
        let Self { file, room, count } = self;
        PoseFile { file, _room: room, count, latest: Mutex::default(), fault: OnceLock::new() }
    }
}

/// A file of poses that is read piece by piece.
#[derive(Debug)]
pub(super) struct PoseFile {
    file: File,
    _room: Option<Held>,
    count: usize,
    /// The piece that was read last: a path goes along the poses in order.
    latest: Mutex<Piece>,
    /// Why poses could not be read.
    fault: OnceLock<io::Error>,
}

/// Some poses of the file, one after the other.
#[derive(Debug, Default)]
struct Piece {
    /// The index of the first.
    first: usize,
    bytes: Vec<u8>,
}

impl Piece {
    /// Some poses; fewer if the piece does not have all of them.
    fn rows(&self, start: usize, count: usize) -> &[[u8; POSE_BYTES]] {
        let Some(from) = start.checked_sub(self.first) else { return &[] };
        let (poses, _) = self.bytes.as_chunks::<POSE_BYTES>();
        poses.get(from..poses.len().min(from.saturating_add(count))).unwrap_or_default()
    }
}

/// The numbers of a pose.
fn numbers(row: &[u8; POSE_BYTES]) -> [f64; NUMBERS] {
    let mut numbers = UNREAD;
    for (number, bytes) in numbers.iter_mut().zip(row.as_chunks().0) {
        *number = f64::from_le_bytes(*bytes);
    }
    numbers
}

impl PoseFile {
    /// Whether poses could not be read: then nothing that was made of poses since then may be sent.
    pub(super) fn has_failed(&self) -> bool {
        self.fault.get().is_some()
    }

    /// Why poses could not be read.
    pub(super) fn take_fault(&mut self) -> Option<io::Error> {
        self.fault.take()
    }

    /// Shows `count` poses from `start` on to `look`, at most a block; none if they cannot be read.
    fn look<T>(&self, start: usize, count: usize, look: impl FnOnce(&[[u8; POSE_BYTES]]) -> T) -> T {
        // A piece is read whole or is not used, also after a panic.
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let rows = latest.rows(start, count);
        if rows.len() == count {
            return look(rows);
        }
        let begin = start - start % PoseBlock::LEN;
        if let Err(fault) = self.read(&mut latest, begin) {
            let _first_stays = self.fault.set(fault);
            return look(&[]);
        }
        look(latest.rows(start, count))
    }

    /// Reads the piece that begins with this pose.
    fn read(&self, piece: &mut Piece, first: usize) -> io::Result<()> {
        let Piece { first: has, bytes } = piece;
        let length = PIECE.min(self.count.saturating_sub(first)) * POSE_BYTES;
        bytes.resize(length, 0);
        let read = self.file.read_exact_at(bytes, first as u64 * POSE_BYTES as u64);
        if read.is_err() {
            bytes.clear();
        }
        *has = first;
        read
    }
}

impl PoseSource for PoseFile {
    fn count(&self) -> usize {
        self.count
    }

    fn block<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> Poses<'a> {
        let count = PoseBlock::LEN.min(self.count.saturating_sub(start));
        self.look(start, count, |rows| {
            let unread = std::iter::repeat_n(UNREAD, count - rows.len());
            copy.fill(rows.iter().map(numbers).chain(unread))
        })
    }

    fn pose(&self, index: usize) -> ToolPose {
        let [x, y, z, i, j, k] = self.look(index, 1, |rows| rows.first().map_or(UNREAD, numbers));
        ToolPose { tip_mm: [x, y, z].into(), axis: [i, j, k].into() }
    }
}
