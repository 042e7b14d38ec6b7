//! Poses and joints as CSV: a header row, then numbers. The reader takes chunks and knows no stream or file.

use thiserror::Error;

use super::decimal::number_at;
use super::pieces::push_numbers;
use super::{Fault, FaultList, JointWords, Pose, PoseColumns};
use crate::kinematics::PoseLanes;
use crate::machine::{Machine, RotaryLetter};

/// Why a table cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("line {line}: {} values are wrong", .faults.len())]
pub struct RowFault {
    /// First faulty line of the upload, 1-based.
    pub line: u64,
    /// The faults, the first hundred; the pointers name the array elements that the rows represent.
    pub faults: Vec<Fault>,
    /// Whether the table has more rows than allowed.
    pub too_many: bool,
}

/// A kind of row: its columns, and the document that it makes.
trait Row: Sized {
    /// Rows that were read.
    type Rows: Default;
    /// Name of the array that the rows represent.
    const LIST: &'static str;
    /// Names of the columns, and whether each is needed.
    const COLUMNS: &'static [(&'static str, bool)];
    fn from_cells(cells: [Option<f64>; 8]) -> Self;
    fn add_to(self, rows: &mut Self::Rows);
    fn count(rows: &Self::Rows) -> usize;
}

impl Row for Pose {
    type Rows = PoseColumns;
    const LIST: &'static str = "poses";
    const COLUMNS: &'static [(&'static str, bool)] =
        &[("x", true), ("y", true), ("z", true), ("i", true), ("j", true), ("k", true)];

    fn from_cells([x, y, z, i, j, k, ..]: [Option<f64>; 8]) -> Self {
        let [x, y, z, i, j, k] = [x, y, z, i, j, k].map(Option::unwrap_or_default);
        Self { x, y, z, i, j, k }
    }

    fn add_to(self, rows: &mut PoseColumns) {
        rows.push(&self);
    }

    fn count(rows: &PoseColumns) -> usize {
        rows.len()
    }
}

impl Row for JointWords {
    type Rows = Vec<Self>;
    const LIST: &'static str = "joints";
    const COLUMNS: &'static [(&'static str, bool)] = &[
        ("X", true),
        ("Y", true),
        ("Z", true),
        ("A", false),
        ("B", false),
        ("C", false),
        ("conditioning", false),
        ("pose", false),
    ];

    fn from_cells([x, y, z, a, b, c, conditioning, _pose]: [Option<f64>; 8]) -> Self {
        let [x, y, z] = [x, y, z].map(Option::unwrap_or_default);
        Self { X: x, Y: y, Z: z, A: a, B: b, C: c, conditioning }
    }

    fn add_to(self, rows: &mut Vec<Self>) {
        rows.push(self);
    }

    fn count(rows: &Vec<Self>) -> usize {
        rows.len()
    }
}

/// Reads rows from chunks of bytes.
#[derive(Debug)]
struct Reader<T: Row> {
    rows: T::Rows,
    max_rows: usize,
    /// Column of the upload for each column of the kind; empty before the header has been read.
    cells: Vec<usize>,
    line: u64,
    partial: Vec<u8>,
    /// Faulty cells so far, and the line of the first.
    faults: Vec<Fault>,
    first_faulty: u64,
}

/// Longest line of a table (bytes).
const MAX_LINE_BYTES: usize = 4096;

impl<T: Row> Reader<T> {
    fn new(max_rows: usize) -> Self {
        Self {
            rows: T::Rows::default(),
            max_rows,
            cells: Vec::new(),
            line: 0,
            partial: Vec::new(),
            faults: Vec::new(),
            first_faulty: 0,
        }
    }

    fn feed(&mut self, mut chunk: &[u8]) -> Result<(), RowFault> {
        loop {
            if self.partial.is_empty() {
                chunk = self.take_plain_lines(chunk);
            }
            let Some(end) = memchr::memchr(b'\n', chunk) else { break };
            let (head, tail) = chunk.split_at(end);
            chunk = tail.get(1..).unwrap_or_default();
            if self.partial.is_empty() {
                self.take_line(head)?;
            } else {
                let mut line = std::mem::take(&mut self.partial);
                line.extend_from_slice(head);
                self.take_line(&line)?;
            }
        }
        self.partial.extend_from_slice(chunk);
        if self.partial.len() > MAX_LINE_BYTES {
            self.line += 1;
            return Err(self.refuse("", &format!("the line is longer than {MAX_LINE_BYTES} bytes")));
        }
        Ok(())
    }

    /// Takes the lines at the beginning of the text that consist of plain numbers and commas, and returns the rest.
    /// All other lines are read by [`Reader::take_line`], which also reads these.
    fn take_plain_lines<'a>(&mut self, mut text: &'a [u8]) -> &'a [u8] {
        while !self.cells.is_empty() && T::count(&self.rows) < self.max_rows {
            let Some((cells, length)) = self.plain_line(text) else { break };
            self.line += 1;
            T::from_cells(cells).add_to(&mut self.rows);
            text = text.get(length..).unwrap_or_default();
        }
        text
    }

    /// The cells of a line of plain numbers, and its length with its end.
    #[inline]
    fn plain_line(&self, text: &[u8]) -> Option<([Option<f64>; 8], usize)> {
        let mut found = [None; 8];
        let mut at = 0;
        for (column, cell) in self.cells.iter().enumerate() {
            if column > 0 {
                (text.get(at) == Some(&b',')).then_some(())?;
                at += 1;
            }
            let (number, length) = number_at(text.get(at..)?)?;
            at += length;
            *found.get_mut(*cell)? = Some(number);
        }
        if text.get(at) == Some(&b'\r') {
            at += 1;
        }
        (text.get(at) == Some(&b'\n') && at <= MAX_LINE_BYTES).then_some((found, at + 1))
    }

    fn finish(mut self) -> Result<T::Rows, RowFault> {
        let last = std::mem::take(&mut self.partial);
        if !last.is_empty() {
            self.take_line(&last)?;
        }
        if self.cells.is_empty() {
            return Err(self.refuse("", "the header row is missing"));
        }
        if self.faults.is_empty() { Ok(self.rows) } else { Err(self.faulty(false)) }
    }

    /// Notes a fault and continues, until there are more faults than are reported.
    fn note(&mut self, name: &str, detail: &str) -> Result<(), RowFault> {
        if self.faults.is_empty() {
            self.first_faulty = self.line.max(1);
        }
        let fault = self.fault(name, detail);
        self.faults.push(fault);
        if self.faults.len() < FaultList::KEPT { Ok(()) } else { Err(self.faulty(false)) }
    }

    /// A fault after which nothing can be read, added to those noted so far.
    fn refuse(&mut self, name: &str, detail: &str) -> RowFault {
        self.note(name, detail).err().unwrap_or_else(|| self.faulty(false))
    }

    fn faulty(&mut self, too_many: bool) -> RowFault {
        RowFault { line: self.first_faulty, faults: std::mem::take(&mut self.faults), too_many }
    }

    fn fault(&self, name: &str, detail: &str) -> Fault {
        let row = if self.cells.is_empty() { String::new() } else { format!("/{}", T::count(&self.rows)) };
        let slash = if name.is_empty() { "" } else { "/" };
        let pointer = format!("/{}{row}{slash}{name}", T::LIST);
        Fault::new(pointer, format!("line {}: {detail}", self.line.max(1)))
    }

    fn take_line(&mut self, line: &[u8]) -> Result<(), RowFault> {
        self.line += 1;
        if line.len() > MAX_LINE_BYTES {
            return Err(self.refuse("", &format!("the line is longer than {MAX_LINE_BYTES} bytes")));
        }
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let Ok(text) = std::str::from_utf8(line) else {
            return Err(self.refuse("", "the line is not UTF-8"));
        };
        if self.cells.is_empty() {
            let text = text.strip_prefix('\u{feff}').unwrap_or(text);
            return if text.trim().is_empty() { Ok(()) } else { self.take_header(text) };
        }
        if text.trim().is_empty() {
            return Ok(());
        }
        if T::count(&self.rows) >= self.max_rows {
            let detail = format!("there are more than {} rows", self.max_rows);
            return Err(RowFault { too_many: self.faults.is_empty(), ..self.refuse("", &detail) });
        }
        let mut found = [None; 8];
        let mut count = 0;
        for (column, text) in text.split(',').enumerate() {
            count += 1;
            let Some(cell) = self.cells.get(column).copied() else { break };
            let (name, needed) = T::COLUMNS.get(cell).copied().unwrap_or_default();
            let text = bare(text);
            let number: f64 = match text.parse() {
                Ok(number) if f64::is_finite(number) => number,
                Ok(_) => {
                    self.note(name, &format!("{text:?} is not a finite number"))?;
                    continue;
                }
                Err(_) if text.is_empty() && !needed => continue,
                Err(_) => {
                    self.note(name, &format!("{text:?} is not a number"))?;
                    continue;
                }
            };
            if let Some(place) = found.get_mut(cell) {
                *place = Some(number);
            }
        }
        if count != self.cells.len() {
            let detail = format!("the row does not have the header's {} columns", self.cells.len());
            self.note("", &detail)?;
        }
        T::from_cells(found).add_to(&mut self.rows);
        Ok(())
    }

    fn take_header(&mut self, text: &str) -> Result<(), RowFault> {
        let mut cells = Vec::new();
        for name in text.split(',').map(bare) {
            let Some(cell) = T::COLUMNS.iter().position(|(known, _)| *known == name) else {
                let known: Vec<_> = T::COLUMNS.iter().map(|(known, _)| *known).collect();
                self.note("", &format!("unknown column {name:?}; the columns are {}", known.join(", ")))?;
                continue;
            };
            if cells.contains(&cell) {
                self.note("", &format!("column {name:?} occurs more than once"))?;
            }
            cells.push(cell);
        }
        for (cell, (name, needed)) in T::COLUMNS.iter().enumerate() {
            if *needed && !cells.contains(&cell) {
                self.note("", &format!("column {name:?} is missing"))?;
            }
        }
        // Without a valid header no cell has a meaning.
        if !self.faults.is_empty() {
            return Err(self.faulty(false));
        }
        self.cells = cells;
        Ok(())
    }
}

fn bare(text: &str) -> &str {
    let text = text.trim();
    text.strip_prefix('"').and_then(|inner| inner.strip_suffix('"')).unwrap_or(text)
}

macro_rules! row_reader {
    ($(#[doc = $doc:literal])* $name:ident of $row:ty, $rows:ty) => {
        $(#[doc = $doc])*
        #[derive(Debug)]
        pub struct $name(Reader<$row>);

        impl $name {
            /// A reader that takes at most `max_rows` rows.
            #[must_use]
            pub fn new(max_rows: usize) -> Self {
                Self(Reader::new(max_rows))
            }

            /// Takes the next bytes; the cuts may be anywhere.
            ///
            /// # Errors
            /// A fault after which nothing can be read, or a hundred faulty cells.
            pub fn feed(&mut self, chunk: &[u8]) -> Result<(), RowFault> {
                self.0.feed(chunk)
            }

            /// All rows, after the last byte.
            ///
            /// # Errors
            /// Every faulty cell, or a missing header.
            pub fn finish(self) -> Result<$rows, RowFault> {
                self.0.finish()
            }
        }
    };
}

row_reader! {
    /// Reads a table of poses.
    PoseRows of Pose, PoseColumns
}
row_reader! {
    /// Reads a table of joints.
    JointRows of JointWords, Vec<JointWords>
}

impl PoseRows {
    /// How many poses are in memory.
    #[must_use]
    pub fn held(&self) -> usize {
        self.0.rows.held()
    }

    /// Takes the poses that are in memory: see [`PoseColumns::take`].
    pub fn take(&mut self, memory: PoseLanes) -> PoseLanes {
        self.0.rows.take(memory)
    }
}

/// The columns of a table of joints on one machine.
#[derive(Debug, Clone, Copy)]
pub struct JointColumns {
    letters: [RotaryLetter; 2],
    with_pose: bool,
}

impl JointColumns {
    /// The columns on `machine`; `with_pose` adds the index of the pose as the first column.
    #[must_use]
    pub fn new(machine: &Machine, with_pose: bool) -> Self {
        Self { letters: machine.rotary_axes().each_ref().map(|axis| axis.letter), with_pose }
    }

    /// Writes the header row.
    pub fn write_header(&self, out: &mut Vec<u8>) {
        let [u, v] = self.letters.map(RotaryLetter::as_char);
        let pose = if self.with_pose { "pose," } else { "" };
        out.extend_from_slice(format!("{pose}X,Y,Z,{u},{v},conditioning\n").as_bytes());
    }

    /// Writes one row; the joints are those of the pose with index `pose`.
    pub fn write_row(&self, out: &mut Vec<u8>, pose: usize, words: &JointWords) {
        if self.with_pose {
            out.extend_from_slice(pose.to_string().as_bytes());
            out.push(b',');
        }
        let [u, v] = self.letters.map(|letter| words.rotary(letter).unwrap_or_default());
        write_numbers(out, [words.X, words.Y, words.Z, u, v, words.conditioning.unwrap_or_default()]);
    }
}

impl Pose {
    /// The header row of a table of poses.
    pub const CSV_HEADER: &'static str = "x,y,z,i,j,k\n";

    /// Writes one row of a table of poses.
    pub fn write_row(&self, out: &mut Vec<u8>) {
        write_numbers(out, [self.x, self.y, self.z, self.i, self.j, self.k]);
    }
}

#[inline]
fn write_numbers(out: &mut Vec<u8>, [first, second, third, fourth, fifth, sixth]: [f64; 6]) {
    push_numbers(
        out,
        [
            ("", Some(first)),
            (",", Some(second)),
            (",", Some(third)),
            (",", Some(fourth)),
            (",", Some(fifth)),
            (",", Some(sixth)),
        ],
    );
    out.push(b'\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of a table that comes in pieces of this length, or its faults.
    fn read(text: &str, piece: usize) -> Result<PoseColumns, RowFault> {
        let mut rows = PoseRows::new(50);
        text.as_bytes().chunks(piece).try_for_each(|chunk| rows.feed(chunk))?;
        rows.finish()
    }

    #[test]
    fn plain_lines_give_what_every_other_line_gives() {
        let lines = [
            "1,2,3,0,0.5,1",
            "-1.25,1e3,0.30000000000000004,0,-0,12345678.12345678",
            "1,2,3,0,0,0",
            "1e9,2,3,0,0,1",
            "007,2,3,0,0,1",
            "+1,2,3,0,0,1",
            ".5,2.,3,0,0,1",
            "1,2,3,0,0",
            "1,2,3,0,0,1,1",
            "1,,3,0,0,1",
            "1,2,x,0,0,1",
            "1e999,2,3,0,0,1",
            "",
        ];
        let quoted = |line: &str| -> String {
            let cells = line
                .split(',')
                .map(|cell| if cell.is_empty() { String::new() } else { format!("\"{cell}\"") });
            cells.collect::<Vec<_>>().join(",")
        };
        for header in ["x,y,z,i,j,k", "k,j,i,z,y,x"] {
            for first in lines {
                for second in lines {
                    for end in ["\n", "\r\n"] {
                        let plain = [header, first, second, first, second].join(end);
                        // No line with quotation marks is a plain line.
                        let (one, two) = (quoted(first), quoted(second));
                        let other = [header, &one, &two, &one, &two].join(end);
                        let whole = read(&plain, 10_000);
                        assert_eq!(whole, read(&other, 10_000), "{plain:?}");
                        for piece in [1, 7, 20] {
                            assert_eq!(whole, read(&plain, piece), "{plain:?}");
                        }
                    }
                }
            }
        }
        let most = format!("x,y,z,i,j,k\n{}", "1,2,3,0,0,1\n".repeat(51));
        assert!(read(&most, 10_000).unwrap_err().too_many);
        assert_eq!(read(&most[..most.len() - 12], 10_000).unwrap().len(), 50);
        let long = format!("x,y,z,i,j,k\n1,2,3,0,0,0.{}\n", "1".repeat(5000));
        assert!(read(&long, 10_000).unwrap_err().faults[0].detail.contains("longer than"));
    }
}
