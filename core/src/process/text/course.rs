//! A program in the order in which it runs: its whole text is kept, because loops and calls go back and forth in it.

use super::source::{CHUNK_BYTES, ProgramSource, read_some};
use crate::process::fault::Fault;
use crate::program::{Batch, Dialect, ProgramRun, ReadLimits, Reader};

/// The longest program whose loops and calls are followed \[bytes\]. A longer program is refused if it has loops, and
/// nothing is known after its calls.
const MAX_BYTES: usize = 4 * 1024 * 1024;
/// The most blocks of such a program. They stay in memory while it is followed.
const MAX_BLOCKS: usize = 250_000;

/// The run of a program from the block that begins at this byte of its text on; `None` if the text is too long.
pub(super) fn run_from(
    source: &dyn ProgramSource,
    dialect: Dialect,
    from: u64,
) -> Result<Option<ProgramRun>, Fault> {
    let mut reader = Reader::new(Some(dialect), ReadLimits::default());
    let mut input = source.open()?;
    let mut chunk = vec![0; CHUNK_BYTES];
    let (mut batches, mut batch) = (Vec::new(), Batch::new());
    let (mut bytes, mut blocks) = (0, 0);
    loop {
        let count = read_some(&mut *input, &mut chunk)?;
        bytes += count;
        if bytes > MAX_BYTES {
            return Ok(None);
        }
        match chunk.get(..count) {
            Some(text) if count > 0 => reader.feed(text),
            _ => reader.finish(),
        }
        while reader.next_batch(&mut batch)? {
            blocks += batch.blocks().len();
            if blocks > MAX_BLOCKS {
                return Ok(None);
            }
            batches.push(std::mem::take(&mut batch));
        }
        if count == 0 {
            return Ok(Some(ProgramRun::new(batches, from)));
        }
    }
}
