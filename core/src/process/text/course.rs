//! A program in the order in which it runs: its whole text is kept, because loops and calls go back and forth in it.

use std::io::Read;

use super::source::{CHUNK_BYTES, OpenSubprogram, ProgramSource, read_some};
use crate::process::fault::Fault;
use crate::program::{Batch, Dialect, ProgramRun, ReadLimits, Reader, SubprogramFile};

/// The longest program whose loops and calls are followed, with the files that it may call \[bytes\]. A longer program is refused if it has loops, and
/// nothing is known after its calls.
const MAX_BYTES: usize = 4 * 1024 * 1024;
/// The most blocks of such a program. They stay in memory while it is followed.
const MAX_BLOCKS: usize = 250_000;

/// The blocks of one file after the other, together no more than the limits.
#[derive(Default)]
struct Kept {
    bytes: usize,
    blocks: usize,
}

impl Kept {
    /// The blocks of a file; `None` if the files are too long.
    fn file(&mut self, input: &mut dyn Read, dialect: Dialect) -> Result<Option<Vec<Batch>>, Fault> {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        let mut chunk = vec![0; CHUNK_BYTES];
        let (mut batches, mut batch) = (Vec::new(), Batch::new());
        loop {
            let count = read_some(input, &mut chunk)?;
            self.bytes += count;
            if self.bytes > MAX_BYTES {
                return Ok(None);
            }
            match chunk.get(..count) {
                Some(text) if count > 0 => reader.feed(text),
                _ => reader.finish(),
            }
            while reader.next_batch(&mut batch)? {
                self.blocks += batch.blocks().len();
                if self.blocks > MAX_BLOCKS {
                    return Ok(None);
                }
                batches.push(std::mem::take(&mut batch));
            }
            if count == 0 {
                return Ok(Some(batches));
            }
        }
    }
}

/// The run of a program from the block that begins at this byte of its text on, with the files that it may call;
/// `None` if the texts are too long.
pub(super) fn run_from(
    source: &dyn ProgramSource,
    dialect: Dialect,
    from: u64,
) -> Result<Option<ProgramRun>, Fault> {
    let mut kept = Kept::default();
    let Some(main) = kept.file(&mut *source.open()?, dialect)? else { return Ok(None) };
    let mut files = Vec::new();
    while let Some(OpenSubprogram { name, mut text }) = source.open_subprogram(files.len())? {
        let batches = kept.file(&mut *text, dialect).map_err(|fault| match fault {
            Fault::Unreadable(fault) => Fault::UnreadableFile { file: name.clone(), fault },
            other => other,
        })?;
        let Some(batches) = batches else { return Ok(None) };
        files.push(SubprogramFile { name, batches });
    }
    Ok(Some(ProgramRun::new(main, from, files)))
}
