//! From a line of the written program to its line of the source.

use crate::process::fault::Fault;

/// Inserted lines, stored in a few bytes for each stretch of them.
#[derive(Debug, Default)]
pub(in crate::process) struct LineMap {
    /// Pairs of numbers: source lines since the previous pair, and lines inserted after that line.
    pairs: Vec<u8>,
    /// The last pair. It can still grow.
    last: Option<(u64, u64)>,
    /// The source line of the previous pair.
    before: u64,
}

/// Most bytes of a map. Twenty million blocks, the most that a program may become, need less.
const MAX_BYTES: usize = 48 << 20;

impl LineMap {
    /// Records `extra` inserted lines after this line of the source. Lines must not decrease.
    ///
    /// # Errors
    /// A line before the last one, or more lines than a map can hold.
    pub(in crate::process) fn insert(&mut self, line: u64, extra: u64) -> Result<(), Fault> {
        match &mut self.last {
            Some((same, count)) if *same == line => *count += extra,
            _ if extra == 0 => {}
            Some((at, _)) if line < *at => {
                let what = "inserted lines are out of order";
                return Err(Fault::VerificationFailed { line, what });
            }
            last => {
                if let Some((at, count)) = last.replace((line, extra)) {
                    put(at - self.before, &mut self.pairs);
                    put(count, &mut self.pairs);
                    self.before = at;
                }
            }
        }
        if self.pairs.len() > MAX_BYTES {
            return Err(Fault::TooCostly { what: "bytes for inserted lines", limit: MAX_BYTES as u64 });
        }
        Ok(())
    }
}

/// Seven bits per byte, the lowest first. The eighth bit marks that more bytes follow.
fn put(mut value: u64, out: &mut Vec<u8>) {
    while value > 0x7F {
        #[expect(clippy::cast_possible_truncation, reason = "eight bits")]
        out.push(((value & 0x7F) | 0x80) as u8);
        value >>= 7;
    }
    #[expect(clippy::cast_possible_truncation, reason = "seven bits")]
    out.push(value as u8);
}

fn take(bytes: &[u8], at: &mut usize) -> Option<u64> {
    let (mut value, mut shift) = (0, 0);
    loop {
        let byte = *bytes.get(*at)?;
        *at += 1;
        value |= u64::from(byte & 0x7F).checked_shl(shift)?;
        shift += 7;
        if byte < 0x80 {
            return Some(value);
        }
    }
}

/// Walks through a map with increasing lines.
#[derive(Debug, Clone)]
pub(in crate::process) struct LineCursor<'a> {
    map: &'a LineMap,
    at: usize,
    /// The source line of the last pair read.
    line: u64,
    pair: Option<(u64, u64)>,
    /// The map's last pair, until it is read.
    last: Option<(u64, u64)>,
    /// Lines inserted before that pair.
    shift: u64,
}

impl<'a> LineCursor<'a> {
    pub(in crate::process) fn new(map: &'a LineMap) -> Self {
        let mut cursor = Self { map, at: 0, line: 0, pair: None, last: map.last, shift: 0 };
        cursor.step();
        cursor
    }

    fn step(&mut self) {
        let pairs = &self.map.pairs;
        self.pair = match (take(pairs, &mut self.at), take(pairs, &mut self.at)) {
            (Some(delta), Some(count)) => {
                self.line += delta;
                Some((self.line, count))
            }
            _ => self.last.take(),
        };
    }

    /// The line of the source from which this line of the written program comes.
    pub(in crate::process) fn source_line(&mut self, line: u64) -> u64 {
        while let Some((at, extra)) = self.pair {
            if line <= at + self.shift {
                break;
            }
            if line <= at + self.shift + extra {
                return at;
            }
            self.shift += extra;
            self.step();
        }
        line - self.shift
    }
}

/// Number of line ends in this text: LF, CR LF or CR.
pub(in crate::process) fn line_ends(text: &[u8]) -> u64 {
    let mut count = 0;
    let mut at = 0;
    while let Some(found) = memchr::memchr2(b'\n', b'\r', text.get(at..).unwrap_or_default()) {
        let end = at + found;
        let both = text.get(end) == Some(&b'\r') && text.get(end + 1) == Some(&b'\n');
        at = end + 1 + usize::from(both);
        count += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_finds_its_source() {
        let mut map = LineMap::default();
        let (mut written, mut seed) = (Vec::new(), 7_u64);
        for line in 1..=5000_u64 {
            written.push(line);
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let extra = match seed >> 60 {
                0 => 300,
                1..=4 => seed >> 58 & 3,
                _ => 0,
            };
            map.insert(line, extra).unwrap();
            for _ in 0..extra {
                written.push(line);
            }
        }
        let mut cursor = LineCursor::new(&map);
        for (index, source) in written.iter().enumerate() {
            assert_eq!(cursor.source_line(index as u64 + 1), *source, "{index}");
        }
        assert_eq!(cursor.source_line(written.len() as u64 + 9), 5009);
        let mut sparse = LineCursor::new(&map);
        for index in (0..written.len()).step_by(97) {
            assert_eq!(sparse.source_line(index as u64 + 1), written[index]);
        }
        assert_eq!(LineCursor::new(&LineMap::default()).source_line(12), 12);
        let mut one = LineMap::default();
        one.insert(3, 2).unwrap();
        one.insert(3, 1).unwrap();
        let mut cursor = LineCursor::new(&one);
        assert_eq!([1, 3, 4, 6, 7].map(|line| cursor.source_line(line)), [1, 3, 3, 3, 4]);
    }

    #[test]
    fn lines_that_go_back_are_no_map() {
        let mut map = LineMap::default();
        map.insert(7, 2).unwrap();
        map.insert(3, 0).unwrap();
        assert!(matches!(map.insert(6, 1), Err(Fault::VerificationFailed { line: 6, .. })));
    }

    #[test]
    fn line_endings_of_every_kind_count_once() {
        assert_eq!([&b"a\r\nb\nc\rd"[..], b"", b"\n", b"x"].map(line_ends), [3, 0, 1, 0]);
    }
}
