//! Whether a program was read in the right dialect.

use super::source::{CHUNK_BYTES, ProgramSource, read_some};
use crate::motion::{Motion, MotionKind, Unfollowable};
use crate::process::fault::Fault;
use crate::program::{Address, Batch, Dialect, ReadLimits, Reader, Word};

/// What was found out about a program's motions at feed.
#[derive(Debug, Clone, Copy, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about one program")]
pub(in crate::process) struct DialectFit {
    /// A motion was followed, or left unchanged for a known reason: an arc with radius compensation, a cycle, a
    /// tilted plane.
    is_understood: bool,
    /// Something may move at feed.
    has_motion: bool,
    /// The program has an unknown code.
    has_code: bool,
    /// A block with coordinates has such a code, or comes after one.
    has_unknown: bool,
}

impl DialectFit {
    /// Takes a motion into account.
    pub(in crate::process) fn see(&mut self, batch: &Batch, motion: &Motion) {
        if self.is_understood || motion.kind == MotionKind::Rapid {
            return;
        }
        let is_foreign = match motion.unfollowable {
            Some(Unfollowable::UnknownCode | Unfollowable::ModeUnknown { .. }) => true,
            Some(Unfollowable::Call | Unfollowable::ControlWord) => motion.kind == MotionKind::Opaque,
            // Program ends and reference positions occur in every dialect.
            Some(Unfollowable::Reference | Unfollowable::Return) => return,
            _ => false,
        };
        self.is_understood = !is_foreign;
        self.has_motion = true;
        let block = batch.blocks().get(motion.block as usize);
        let words = block.map_or(&[][..], |block| batch.words(block));
        let is_unknown = match motion.unfollowable {
            Some(Unfollowable::UnknownCode) => {
                self.has_code = true;
                words.iter().any(is_place)
            }
            Some(Unfollowable::ModeUnknown { .. }) => self.has_code,
            _ => false,
        };
        self.has_unknown |= is_unknown;
    }

    /// Whether no motion at feed was understood because the dialect is wrong: codes are unknown in blocks with
    /// coordinates, or the text itself shows another dialect than `stated`.
    ///
    /// # Errors
    /// The source cannot be read.
    pub(in crate::process) fn is_unread(
        self,
        stated: Option<Dialect>,
        source: &dyn ProgramSource,
    ) -> Result<bool, Fault> {
        if self.is_understood || !self.has_motion {
            return Ok(false);
        }
        if self.has_unknown {
            return Ok(true);
        }
        Ok(stated.is_some() && detected(source)? != stated)
    }
}

/// X Y Z, A B C.
fn is_place(word: &Word) -> bool {
    matches!(word.address, Address::X | Address::Y | Address::Z | Address::A | Address::B | Address::C)
}

/// The dialect that the text itself shows.
fn detected(source: &dyn ProgramSource) -> Result<Option<Dialect>, Fault> {
    let mut reader = Reader::new(None, ReadLimits::default());
    let mut input = source.open()?;
    let mut batch = Batch::new();
    let mut chunk = vec![0; CHUNK_BYTES];
    while reader.dialect().is_none() {
        match read_some(&mut *input, &mut chunk)? {
            0 => {
                reader.finish();
                return Ok(reader.next_batch(&mut batch).ok().and_then(|_| reader.dialect()));
            }
            count => reader.feed(chunk.get(..count).unwrap_or_default()),
        }
        if reader.next_batch(&mut batch).is_err() {
            break;
        }
    }
    Ok(reader.dialect())
}
