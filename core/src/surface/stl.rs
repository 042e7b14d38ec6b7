//! Facets from an STL file, binary or text, as it arrives.
//!
//! Numbers in a text are read in double precision; binary ones are single precision. A file is binary if one of its
//! first 84 bytes is zero. The count of facets at the end of the binary header is below 2²⁴, so its last byte is
//! zero; a text has no zero byte. The words of the header do not matter (binary files may begin with `solid`).

use std::io::Read;

use super::stl_text::TextFacets;
use super::{MAX_FACETS, StlFault};
use crate::geometry::Vec3;

/// One facet as the file states it, in the file's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Facet {
    /// Its corners.
    pub(super) corners: [Vec3; 3],
    /// The normal that the file states, even if it is wrong.
    pub(super) normal: Vec3,
}

/// Bytes of a binary file before its facets.
pub const STL_HEADER_BYTES: usize = 84;
/// Bytes of a binary facet.
const FACET_BYTES: usize = 50;
/// Smallest length of a facet in a text: its words with one figure each take 86 bytes.
const TEXT_FACET_BYTES: u64 = 80;

/// Largest number of facets in an STL file: the exact number for a complete binary file.
///
/// `start` are its first [`STL_HEADER_BYTES`] bytes, or all bytes of a shorter file. `length` is the length of the
/// file \[bytes\].
#[must_use]
pub fn stl_facets_at_most(start: &[u8], length: u64) -> u64 {
    if is_binary(start) {
        length.saturating_sub(STL_HEADER_BYTES as u64) / FACET_BYTES as u64
    } else {
        length / TEXT_FACET_BYTES + 1
    }
}

/// Whether a file with these first bytes is binary.
fn is_binary(start: &[u8]) -> bool {
    start.iter().take(STL_HEADER_BYTES).any(|byte| *byte == 0)
}

/// Reads facets one by one, in memory that does not depend on the file.
pub(super) enum StlReader<R> {
    Binary { input: Input<R>, stated: u32, read: u32 },
    Text(TextFacets<R>),
}

impl<R: Read> StlReader<R> {
    /// Looks at the beginning of the file.
    pub(super) fn new(source: R) -> Result<Self, StlFault> {
        let mut input = Input::new(source);
        let start = input.look(STL_HEADER_BYTES)?;
        if is_binary(start) {
            let &[.., a, b, c, d] = start else { return Err(StlFault::NotStl) };
            let (bytes, stated) = (start.len(), u32::from_le_bytes([a, b, c, d]));
            if bytes < STL_HEADER_BYTES {
                return Err(StlFault::TruncatedHeader { bytes });
            }
            if stated > MAX_FACETS {
                // A short file with any bytes in place of the number is no large part.
                let bytes = input.look(WINDOW_BYTES)?.len();
                if bytes < WINDOW_BYTES {
                    let facets = (bytes - STL_HEADER_BYTES) / FACET_BYTES;
                    return Err(StlFault::Truncated {
                        stated,
                        facets: u32::try_from(facets).unwrap_or(u32::MAX),
                    });
                }
                return Err(StlFault::TooManyFacets {
                    facets: u64::from(stated),
                    max: u64::from(MAX_FACETS),
                });
            }
            input.skip(STL_HEADER_BYTES);
            return Ok(Self::Binary { input, stated, read: 0 });
        }
        Ok(Self::Text(TextFacets::new(input)?))
    }

    /// The next facet; `None` at the regular end of a file.
    pub(super) fn next_facet(&mut self) -> Result<Option<Facet>, StlFault> {
        match self {
            Self::Text(text) => text.next_facet(),
            Self::Binary { input, stated, read } if *read < *stated => {
                let bytes = input.look(FACET_BYTES)?;
                let Some((facet, _)) = bytes.split_first_chunk::<FACET_BYTES>() else {
                    return Err(StlFault::Truncated { stated: *stated, facets: *read });
                };
                let facet = binary_facet(facet);
                input.skip(FACET_BYTES);
                *read += 1;
                Ok(Some(facet))
            }
            Self::Binary { input, stated, .. } => {
                if input.look(1)?.is_empty() {
                    return Ok(None);
                }
                Err(StlFault::TrailingBytes { stated: *stated })
            }
        }
    }

    /// The last line read, if the file is a text.
    pub(super) fn line(&self) -> Option<u64> {
        match self {
            Self::Binary { .. } => None,
            Self::Text(text) => Some(text.line()),
        }
    }
}

fn binary_facet(bytes: &[u8; FACET_BYTES]) -> Facet {
    let (words, _) = bytes.as_chunks::<4>();
    let mut numbers = words.iter().map(|word| f64::from(f32::from_le_bytes(*word)));
    let mut vector = || {
        let mut next = || numbers.next().unwrap_or(f64::NAN);
        Vec3::new(next(), next(), next())
    };
    let normal = vector();
    Facet { normal, corners: [vector(), vector(), vector()] }
}

/// A window on a stream.
pub(super) struct Input<R> {
    source: R,
    buffer: Vec<u8>,
    from: usize,
    to: usize,
}

/// Bytes read at once.
const WINDOW_BYTES: usize = 1 << 16;

impl<R: Read> Input<R> {
    pub(super) fn new(source: R) -> Self {
        Self { source, buffer: vec![0; WINDOW_BYTES], from: 0, to: 0 }
    }

    /// The next `count` bytes (at most a window); fewer at the end of the stream.
    pub(super) fn look(&mut self, count: usize) -> Result<&[u8], StlFault> {
        while self.to - self.from < count {
            self.buffer.copy_within(self.from..self.to, 0);
            (self.from, self.to) = (0, self.to - self.from);
            match self.source.read(self.buffer.get_mut(self.to..).unwrap_or(&mut [])) {
                Ok(0) => break,
                Ok(more) => self.to += more,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(StlFault::Read(error)),
            }
        }
        Ok(self.buffer.get(self.from..self.to.min(self.from + count)).unwrap_or(&[]))
    }

    /// Skips bytes that were looked at.
    pub(super) fn skip(&mut self, count: usize) {
        self.from = (self.from + count).min(self.to);
    }

    /// The next byte.
    pub(super) fn next(&mut self) -> Result<Option<u8>, StlFault> {
        if self.from == self.to {
            self.look(1)?;
        }
        let byte = if self.from < self.to { self.buffer.get(self.from).copied() } else { None };
        self.from += usize::from(byte.is_some());
        Ok(byte)
    }
}
