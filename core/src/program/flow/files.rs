//! The files of a program: the main program, and the files of the subprograms that it may call.

use std::collections::BTreeMap;
use std::ops::Range;

use super::places::statement_at;
use crate::program::course::{PlaceName, Step};
use crate::program::{Batch, Block, BlockKind, Excerpt};

/// A file beside the main program, which calls name by its name.
#[derive(Debug)]
pub struct SubprogramFile {
    /// The name of the file, with or without a path and an extension.
    pub name: String,
    /// Its blocks.
    pub batches: Vec<Batch>,
}

/// Where the blocks of one file are among those of the whole program.
#[derive(Debug)]
struct Extent {
    /// All of its blocks.
    blocks: Range<usize>,
    /// The blocks that a call runs: without tape marks, the name of the program, and text behind the tape mark.
    body: Range<usize>,
    /// The name of the program in its text.
    name: Option<PlaceName>,
    /// The name with which the file was sent, without its folders; empty for the main program.
    file_name: Excerpt,
}

/// All files of a program by the blocks that they have.
#[derive(Debug, Default)]
pub(super) struct Files {
    extents: Vec<Extent>,
    /// The files of every name; two files may have one name.
    names: BTreeMap<PlaceName, Vec<usize>>,
}

impl Files {
    /// The files of a program. The main program has the first `main_blocks` blocks, then come the subprograms.
    pub(super) fn new(main_blocks: usize, subprograms: &[SubprogramFile]) -> Self {
        let main = 0..main_blocks;
        let mut files = Self {
            extents: vec![Extent {
                blocks: main.clone(),
                body: main,
                name: None,
                file_name: Excerpt::default(),
            }],
            ..Self::default()
        };
        let mut first = main_blocks;
        for (index, SubprogramFile { name, batches }) in subprograms.iter().enumerate() {
            let count: usize = batches.iter().map(|batch| batch.blocks().len()).sum();
            let (body, own) = body(batches);
            let body = first + body.start..first + body.end;
            let file_name = Excerpt::new(without_folders(name).as_bytes());
            files.extents.push(Extent { blocks: first..first + count, body, name: own, file_name });
            for name in names(name) {
                let files = files.names.entry(name).or_default();
                if !files.contains(&(index + 1)) {
                    files.push(index + 1);
                }
            }
            first += count;
        }
        files
    }

    /// The blocks of a file.
    pub(super) fn blocks(&self, file: usize) -> Range<usize> {
        self.extents.get(file).map_or(0..0, |extent| extent.blocks.clone())
    }

    /// The blocks of a file that a call runs.
    pub(super) fn body(&self, file: usize) -> Range<usize> {
        self.extents.get(file).map_or(0..0, |extent| extent.body.clone())
    }

    /// The name of the program in a file's text, if the text has one.
    pub(super) fn name(&self, file: usize) -> Option<&PlaceName> {
        self.extents.get(file)?.name.as_ref()
    }

    /// The name with which a file was sent, for messages.
    pub(super) fn file_name(&self, file: usize) -> Excerpt {
        self.extents.get(file).map_or_else(Excerpt::default, |extent| extent.file_name)
    }

    /// How many files there are, the main program included.
    pub(super) fn count(&self) -> usize {
        self.extents.len()
    }

    /// The first block of every file.
    pub(super) fn starts(&self) -> Vec<usize> {
        self.extents.iter().map(|extent| extent.blocks.start).collect()
    }

    /// The file of this name, if only one has it.
    pub(super) fn named(&self, name: &PlaceName) -> Option<usize> {
        match self.names.get(name)?.as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }
}

/// The blocks that a call of these runs, and the name of the program before them.
fn body(batches: &[Batch]) -> (Range<usize>, Option<PlaceName>) {
    let blocks = || batches.iter().flat_map(|batch| batch.blocks().iter().map(move |block| (batch, block)));
    let is_before = |(_, block): &(&Batch, &Block)| {
        use BlockKind::{Banner, Blank, Comment, Header, Percent};
        matches!(block.kind, Banner | Blank | Comment | Header | Percent)
    };
    let mut start = blocks().take_while(is_before).count();
    let mut name = None;
    if let Some((batch, block)) = blocks().nth(start) {
        let statement = statement_at(batch, block);
        if statement.step == Step::Entry {
            start += 1;
            name = statement.place;
        }
    }
    let rest = blocks().skip(start).take_while(|(_, block)| block.kind != BlockKind::Percent);
    (start..start + rest.count(), name)
}

/// The name of a file without its path. Long paths would leave no room for the name in a message.
pub(crate) fn without_folders(file: &str) -> &str {
    file.rsplit(['/', '\\', ':']).next().unwrap_or(file)
}

/// The names by which calls may mean a file, in upper case: as it is written without its path, without its extension,
/// without the marks `_N_`, `_SPF` and `_MPF`, and with its number alone or after O.
fn names(file: &str) -> Vec<PlaceName> {
    let whole = without_folders(file).to_ascii_uppercase();
    let stem = whole.rsplit_once('.').map_or(whole.as_str(), |(stem, _)| stem);
    let mut names = vec![whole.clone(), stem.to_owned()];
    if let Some(marked) = stem.strip_prefix("_N_") {
        for ending in ["SPF", "MPF"] {
            if let Some(bare) = marked.strip_suffix(ending).and_then(|bare| bare.strip_suffix('_')) {
                names.extend([bare.to_owned(), format!("{bare}.{ending}")]);
            }
        }
    }
    let digits = stem.strip_prefix('O').unwrap_or(stem);
    if let Ok(number) = digits.parse::<u32>()
        && digits.bytes().all(|byte| byte.is_ascii_digit())
    {
        names.extend([number.to_string(), format!("O{number}")]);
    }
    names.into_iter().filter(|name| !name.is_empty()).map(|name| name.into_bytes().into()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_the_names_that_calls_use() {
        let found = |file: &str, name: &str| names(file).iter().any(|known| **known == *name.as_bytes());
        for (file, name) in [
            ("O1000.nc", "O1000"),
            ("1000", "O1000"),
            ("o0007.NC", "O7"),
            ("100.ngc", "100"),
            ("square.ngc", "SQUARE"),
            ("TNC:\\parts\\Pocket.h", "POCKET.H"),
            ("TNC:\\parts\\Pocket.h", "POCKET"),
            ("_N_L100_SPF", "L100"),
            ("_N_L100_SPF", "L100.SPF"),
            ("L100.SPF", "L100"),
            ("SUB.1.SPF", "SUB.1"),
        ] {
            assert!(found(file, name), "{file} is not {name}");
        }
        for (file, name) in
            [("O1000.nc", "O100"), ("L01.SPF", "L1"), ("A.MPF", "A.SPF"), ("O.nc", "O0"), (".nc", "")]
        {
            assert!(!found(file, name), "{file} is {name}");
        }
    }
}
