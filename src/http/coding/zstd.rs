//! The zstd coding (RFC 8878): frames one after the other, including skippable frames.

use std::fmt;

use zstd_safe::{DCtx, DParameter, InBuffer, OutBuffer, get_error_name};

use super::{CodingFault, Step};

/// Binary logarithm of the largest window: 8 MiB, the limit of the coding over HTTP (RFC 9659 §3).
const WINDOW_LOG: u32 = 23;

/// Reads frames.
pub(super) struct Zstd {
    context: DCtx<'static>,
    /// Whether a frame was begun and is not complete.
    within: bool,
}

impl fmt::Debug for Zstd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Zstd").field("within", &self.within).finish_non_exhaustive()
    }
}

impl Zstd {
    /// A reader before the first frame.
    pub(super) fn new() -> Result<Self, CodingFault> {
        let mut context = DCtx::try_create().ok_or(CodingFault::NoDecoder)?;
        context
            .set_parameter(DParameter::WindowLogMax(WINDOW_LOG))
            .map_err(|_code| CodingFault::NoDecoder)?;
        Ok(Self { context, within: false })
    }

    /// Whether the last frame is complete.
    pub(super) fn is_between(&self) -> bool {
        !self.within
    }

    /// Memory that the reader holds now, its window included \[bytes\].
    pub(super) fn bytes(&self) -> usize {
        self.context.sizeof()
    }

    /// Continues to read.
    pub(super) fn step(&mut self, input: &[u8], room: &mut [u8]) -> Result<Step, CodingFault> {
        let size = room.len();
        let mut given = InBuffer::around(input);
        let mut made = OutBuffer::around(room);
        let left =
            self.context.decompress_stream(&mut made, &mut given).map_err(|code| {
                match get_error_name(code) {
                    "Frame requires too much memory for decoding" => CodingFault::WideWindow,
                    "Restored data doesn't match checksum" => CodingFault::WrongCheck,
                    "Unknown frame descriptor" => CodingFault::NoMember,
                    _ => CodingFault::Damaged,
                }
            })?;
        self.within = left != 0;
        let (taken, made) = (given.pos(), made.pos());
        Ok(Step { taken, made, full: made == size && self.within })
    }
}
