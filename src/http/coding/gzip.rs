//! The gzip coding (RFC 1952): members one after the other, each with its header, its deflated bytes and its trailer.

use flate2::{Crc, Decompress, FlushDecompress, Status};

use super::{CodingFault, Step};

/// Longest header of a member with all its optional fields \[bytes\]: the extra field alone may have 65 535.
const MAX_HEADER_BYTES: usize = 128 * 1024;
/// What one decoder holds: the tables and the window of the inflater, rounded up \[bytes\].
pub(super) const STATE_BYTES: usize = 64 * 1024;

/// Flags of a header (RFC 1952 §2.3.1); the first says that the content may be text and changes nothing.
const HEADER_CHECK: u8 = 1 << 1;
const EXTRA: u8 = 1 << 2;
const NAME: u8 = 1 << 3;
const COMMENT: u8 = 1 << 4;
const RESERVED: u8 = 0b1110_0000;

/// Reads members.
#[derive(Debug)]
pub(super) struct Gzip {
    at: At,
    inflater: Decompress,
    content: Crc,
}

/// Position of the reader within a member.
#[derive(Debug)]
enum At {
    /// Before a member, or at the end.
    Between,
    Header(Header),
    Content,
    Trailer {
        bytes: [u8; 8],
        read: usize,
    },
}

/// A header that is being read.
#[derive(Debug)]
struct Header {
    field: Field,
    /// Optional fields that are still to come.
    flags: u8,
    /// Length of all bytes that were read.
    length: usize,
    /// Check of all bytes that were read.
    check: Crc,
}

/// The field of a header that is being read.
#[derive(Debug)]
enum Field {
    /// The ten bytes that every header has.
    Fixed { read: usize },
    /// Length of the extra field.
    ExtraLength { first: Option<u8> },
    /// The extra field.
    Extra { left: u16 },
    /// A name or a comment, which ends with a zero.
    Text,
    /// The check of the header.
    Check { expected: u16, first: Option<u8> },
}

impl Gzip {
    /// A reader before the first member.
    pub(super) fn new() -> Self {
        Self { at: At::Between, inflater: Decompress::new(false), content: Crc::new() }
    }

    /// Whether the last member is complete.
    pub(super) fn is_between(&self) -> bool {
        matches!(self.at, At::Between)
    }

    /// Continues to read.
    pub(super) fn step(&mut self, input: &[u8], room: &mut [u8]) -> Result<Step, CodingFault> {
        let mut taken = 0;
        loop {
            match &mut self.at {
                At::Content => {
                    let rest = input.get(taken..).unwrap_or_default();
                    let (read, made) = (self.inflater.total_in(), self.inflater.total_out());
                    let status = self.inflater.decompress(rest, room, FlushDecompress::None);
                    let status = status.map_err(|_unreadable| CodingFault::Damaged)?;
                    // Neither number is larger than the length of a slice.
                    let count = |now: u64, before: u64| usize::try_from(now - before).unwrap_or(usize::MAX);
                    taken += count(self.inflater.total_in(), read);
                    let made = count(self.inflater.total_out(), made);
                    self.content.update(room.get(..made).unwrap_or_default());
                    if status == Status::StreamEnd {
                        self.at = At::Trailer { bytes: [0; 8], read: 0 };
                    }
                    let full = made == room.len() && status != Status::StreamEnd;
                    return Ok(Step { taken, made, full });
                }
                before_content => {
                    let Some(byte) = input.get(taken).copied() else {
                        return Ok(Step { taken, made: 0, full: false });
                    };
                    taken += 1;
                    match before_content {
                        At::Between => {
                            let mut header = Header::new();
                            header.take(byte)?;
                            self.at = At::Header(header);
                        }
                        At::Header(header) => {
                            if header.take(byte)? {
                                self.inflater.reset(false);
                                self.content.reset();
                                self.at = At::Content;
                            }
                        }
                        At::Trailer { bytes, read } => {
                            if let Some(place) = bytes.get_mut(*read) {
                                *place = byte;
                            }
                            *read += 1;
                            if *read == bytes.len() {
                                let [a, b, c, d, e, f, g, h] = *bytes;
                                let given =
                                    (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
                                if given != (self.content.sum(), self.content.amount()) {
                                    return Err(CodingFault::WrongCheck);
                                }
                                self.at = At::Between;
                            }
                        }
                        At::Content => {}
                    }
                }
            }
        }
    }
}

impl Header {
    fn new() -> Self {
        Self { field: Field::Fixed { read: 0 }, flags: 0, length: 0, check: Crc::new() }
    }

    /// Takes one byte; true if the header is complete.
    fn take(&mut self, byte: u8) -> Result<bool, CodingFault> {
        self.length += 1;
        if self.length > MAX_HEADER_BYTES {
            return Err(CodingFault::Damaged);
        }
        let field_ends = match &mut self.field {
            Field::Fixed { read } => {
                match (*read, byte) {
                    (0, 0x1f) | (1, 0x8b) | (2, 8) | (4..=9, _) => {}
                    (3, flags) if flags & RESERVED == 0 => self.flags = flags,
                    _ => return Err(CodingFault::NoMember),
                }
                *read += 1;
                *read == 10
            }
            Field::ExtraLength { first: None } => {
                self.field = Field::ExtraLength { first: Some(byte) };
                false
            }
            Field::ExtraLength { first: Some(first) } => {
                let left = u16::from_le_bytes([*first, byte]);
                self.field = Field::Extra { left };
                left == 0
            }
            Field::Extra { left } => {
                *left -= 1;
                *left == 0
            }
            Field::Text => byte == 0,
            Field::Check { expected, first: None } => {
                self.field = Field::Check { expected: *expected, first: Some(byte) };
                false
            }
            Field::Check { expected, first: Some(first) } => {
                if u16::from_le_bytes([*first, byte]) != *expected {
                    return Err(CodingFault::WrongCheck);
                }
                true
            }
        };
        self.check.update(&[byte]);
        Ok(field_ends && !self.begins_another())
    }

    /// Begins the next optional field, if there is one.
    fn begins_another(&mut self) -> bool {
        let next = [EXTRA, NAME, COMMENT, HEADER_CHECK].into_iter().find(|flag| self.flags & flag != 0);
        let Some(flag) = next else { return false };
        self.flags &= !flag;
        self.field = match flag {
            EXTRA => Field::ExtraLength { first: None },
            HEADER_CHECK => {
                let [low, high, ..] = self.check.sum().to_le_bytes();
                Field::Check { expected: u16::from_le_bytes([low, high]), first: None }
            }
            _ => Field::Text,
        };
        true
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, GzBuilder};

    use super::*;

    fn unpacked(mut packed: &[u8], at_once: usize, room: usize) -> Result<Vec<u8>, CodingFault> {
        let mut gzip = Gzip::new();
        let (mut whole, mut room) = (Vec::new(), vec![0; room]);
        while !packed.is_empty() {
            let (mut now, rest) = packed.split_at(at_once.min(packed.len()));
            packed = rest;
            loop {
                let step = gzip.step(now, &mut room)?;
                whole.extend_from_slice(&room[..step.made]);
                now = &now[step.taken..];
                if now.is_empty() && !step.full {
                    break;
                }
            }
        }
        if gzip.is_between() { Ok(whole) } else { Err(CodingFault::Cut) }
    }

    fn member(text: &[u8], builder: GzBuilder) -> Vec<u8> {
        let mut writer = builder.write(Vec::new(), Compression::best());
        writer.write_all(text).unwrap();
        writer.finish().unwrap()
    }

    #[test]
    fn every_optional_field_is_passed_over_whatever_the_chunks() {
        let text = b"G1 X1\n".repeat(500);
        let whole = GzBuilder::new().filename("a.nc").comment("of a part").extra(vec![7; 300]).mtime(9);
        let mut packed = member(&text, whole);
        packed.extend(member(b"M30\n", GzBuilder::new().extra(Vec::new())));
        let expected = [&text[..], b"M30\n"].concat();
        for at_once in [1, 3, 1000, 1 << 20] {
            for room in [1, 7, 4096] {
                assert_eq!(unpacked(&packed, at_once, room), Ok(expected.clone()), "{at_once} {room}");
            }
        }
    }

    #[test]
    fn the_check_of_a_header_is_looked_at() {
        let plain = member(b"M30\n", GzBuilder::new());
        let mut head = plain[..10].to_vec();
        head[3] = HEADER_CHECK;
        let mut check = Crc::new();
        check.update(&head);
        head.extend_from_slice(&check.sum().to_le_bytes()[..2]);
        let right = [&head, &plain[10..]].concat();
        assert_eq!(unpacked(&right, 1, 16), Ok(b"M30\n".to_vec()));
        let mut wrong = right;
        wrong[10] ^= 1;
        assert_eq!(unpacked(&wrong, 1, 16), Err(CodingFault::WrongCheck));
    }

    #[test]
    fn a_member_cut_anywhere_is_no_member() {
        let packed = member(&b"G1 X1\n".repeat(50), GzBuilder::new().filename("a.nc"));
        for end in 1..packed.len() {
            assert_eq!(unpacked(&packed[..end], 5, 64), Err(CodingFault::Cut), "{end}");
        }
    }

    #[test]
    fn every_changed_bit_that_changes_the_text_is_found() {
        let text = b"G1 X12.5 Y-3 A20 C40\nM30\n".to_vec();
        let packed = member(&text, GzBuilder::new());
        for place in 0..packed.len() {
            for bit in 0..8 {
                let mut changed = packed.clone();
                changed[place] ^= 1 << bit;
                // Time, system and the hint at text may be anything.
                assert!(unpacked(&changed, 8, 64).map_or(true, |read| read == text), "{place} {bit}");
            }
        }
    }

    #[test]
    fn a_header_has_an_end() {
        let mut endless = member(b"", GzBuilder::new())[..10].to_vec();
        endless[3] = NAME;
        endless.resize(MAX_HEADER_BYTES + 1, b'a');
        assert_eq!(unpacked(&endless, 4096, 16), Err(CodingFault::Damaged));
    }
}
