//! Rows as text: numbers as JSON writes them, many rows in pieces that are printed side by side and written in order.

use std::io::{self, Write};
use std::ops::Range;

use crate::side_by_side::SideBySide;

/// Rows printed at a time: their text is about 300 kB, which stays in the cache until it is written.
const PIECE_ROWS: usize = 2048;
/// Bytes of a printed row, as a rule.
const ROW_BYTES: usize = 160;

/// Longest text of a number as JSON, `-1.7976931348623157e308` \[bytes\].
pub const LONGEST_NUMBER: usize = 24;

/// Appends the numbers that there are, each after its prefix. They are written as JSON: the same bytes as serde writes.
///
/// All digits are printed before any are copied. Otherwise each copy would wait for the digits that were stored just
/// before, and a row would take 1.4 times as long.
#[inline]
pub(super) fn push_numbers<const N: usize>(out: &mut Vec<u8>, numbers: [(&str, Option<f64>); N]) {
    let mut digits = [(); N].map(|()| zmij::Buffer::new());
    let mut texts = [("", ""); N];
    for ((text, digits), (prefix, number)) in texts.iter_mut().zip(&mut digits).zip(numbers) {
        *text = match number {
            Some(number) if number.is_finite() => (prefix, digits.format_finite(number)),
            Some(_) => (prefix, "null"),
            None => ("", ""),
        };
    }
    for (prefix, number) in texts {
        out.extend_from_slice(prefix.as_bytes());
        out.extend_from_slice(number.as_bytes());
    }
}

/// Writes the text of `rows` rows. `print` appends the rows of a range to a text. A round of pieces is printed while
/// the round before is written.
///
/// # Errors
/// The writer's.
pub fn write_in_pieces(
    rows: usize,
    threads: &dyn SideBySide,
    writer: &mut (impl Write + Send),
    print: &(impl Fn(Range<usize>, &mut Vec<u8>) + Sync),
) -> io::Result<()> {
    if rows <= PIECE_ROWS {
        let mut text = Vec::with_capacity(rows * ROW_BYTES);
        print(0..rows, &mut text);
        return writer.write_all(&text);
    }
    let mut begin = 0;
    let take = |most: usize, round: &mut usize| {
        *round = begin;
        begin = rows.min(begin + most);
        Ok::<_, io::Error>(begin - *round)
    };
    write_as_made(rows, [0; 2], threads, writer, take, &|round: &usize, rows, text| {
        print(round + rows.start..round + rows.end, text);
    })
}

/// Writes the text of `rows` rows, which are made in rounds. While one round is made, the round before it is printed, and
/// the text of an earlier one is written. `make` fills a round with up to this number of rows, and returns how many
/// there are. `print` appends some rows of a round to a text. `rounds` are memory for two rounds.
///
/// # Errors
/// Those of `make`, and the writer's.
pub fn write_as_made<T: Send + Sync, E: From<io::Error> + Send>(
    rows: usize,
    [mut round, mut next]: [T; 2],
    threads: &dyn SideBySide,
    writer: &mut (impl Write + Send),
    mut make: impl FnMut(usize, &mut T) -> Result<usize, E> + Send,
    print: &(impl Fn(&T, Range<usize>, &mut Vec<u8>) + Sync),
) -> Result<(), E> {
    let width = threads.parts().min(rows.div_ceil(PIECE_ROWS)).max(1);
    let texts = || -> Vec<Vec<u8>> {
        (0..width).map(|_| Vec::with_capacity(rows.min(PIECE_ROWS) * ROW_BYTES)).collect()
    };
    let (mut printed, mut before) = (texts(), texts());
    let most = width * PIECE_ROWS;
    let mut count = make(most, &mut round)?;
    // The last round only writes.
    while count > 0 || before.iter().any(|text| !text.is_empty()) {
        let (mut written, mut made) = (Ok(()), Ok(0));
        let mut parts: Vec<Box<dyn FnOnce() + Send>> = Vec::with_capacity(width + 2);
        let (texts, kept, writer) = (&before, &mut written, &mut *writer);
        parts.push(Box::new(move || *kept = texts.iter().try_for_each(|text| writer.write_all(text))));
        if count > 0 {
            let (made, make, next) = (&mut made, &mut make, &mut next);
            parts.push(Box::new(move || *made = make(most, next)));
        }
        for (n, text) in printed.iter_mut().enumerate() {
            text.clear();
            // The last piece takes all that is left.
            let end = if n + 1 == width { count } else { count.min((n + 1) * PIECE_ROWS) };
            let (round, rows) = (&round, count.min(n * PIECE_ROWS)..end);
            if !rows.is_empty() {
                parts.push(Box::new(move || print(round, rows, text)));
            }
        }
        threads.run(parts);
        written?;
        count = made?;
        std::mem::swap(&mut printed, &mut before);
        std::mem::swap(&mut round, &mut next);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::side_by_side::OneAfterAnother;

    /// So many parts, in the reverse order.
    struct Backwards(usize);

    impl SideBySide for Backwards {
        fn parts(&self) -> usize {
            self.0
        }

        fn run<'a>(&self, parts: Vec<Box<dyn FnOnce() + Send + 'a>>) {
            parts.into_iter().rev().for_each(|part| part());
        }
    }

    fn print(rows: Range<usize>, text: &mut Vec<u8>) {
        for row in rows {
            push_numbers(text, [("", Some(row as f64))]);
            text.push(b'\n');
        }
    }

    #[test]
    fn no_number_is_longer_than_the_longest() {
        for number in [f64::MIN, -f64::MIN_POSITIVE, -1.234_567_890_123_456_7e-7, -5e-324, 0.1 + 0.2, 1e16] {
            let mut text = Vec::new();
            push_numbers(&mut text, [("", Some(number))]);
            assert!(text.len() <= LONGEST_NUMBER, "{number}");
        }
    }

    #[test]
    fn pieces_leave_in_order_whoever_prints_them() {
        for rows in [0, 1, PIECE_ROWS, PIECE_ROWS + 1, 5 * PIECE_ROWS, 7 * PIECE_ROWS - 1] {
            let mut whole = Vec::new();
            print(0..rows, &mut whole);
            for parts in 1..5 {
                for threads in [&Backwards(parts) as &dyn SideBySide, &OneAfterAnother] {
                    let mut text = Vec::new();
                    write_in_pieces(rows, threads, &mut text, &print).unwrap();
                    assert!(text == whole, "{rows} rows, {parts} parts");
                }
            }
        }
    }

    #[test]
    fn the_writer_s_fault_is_returned() {
        let mut room = vec![0; 100_000];
        let mut full = room.as_mut_slice();
        assert!(write_in_pieces(10 * PIECE_ROWS, &Backwards(2), &mut full, &print).is_err());
    }
}
