//! Facets of an STL text.

use std::io::Read;

use super::StlFault;
use super::stl::{Facet, Input};
use crate::geometry::Vec3;

/// Longest word of a text [bytes]; it holds any number.
const WORD_BYTES: usize = 64;

/// Reads the words of a text, and facets from them. Words may be in upper or lower case and on any line. The name
/// after `solid` and `endsolid` ends with its line. A file may hold several solids.
pub(super) struct TextFacets<R> {
    input: Input<R>,
    line: u64,
    word: [u8; WORD_BYTES],
    length: usize,
    in_solid: bool,
}

impl<R: Read> TextFacets<R> {
    pub(super) fn new(mut input: Input<R>) -> Result<Self, StlFault> {
        if input.look(3)? == [0xEF, 0xBB, 0xBF] {
            input.skip(3);
        }
        let mut text = Self { input, line: 1, word: [0; WORD_BYTES], length: 0, in_solid: false };
        if text.look_for_word()? && text.is("solid") {
            text.end_line()?;
            text.in_solid = true;
            return Ok(text);
        }
        Err(StlFault::NotStl)
    }

    /// The last line read.
    pub(super) fn line(&self) -> u64 {
        self.line
    }

    /// The next facet; `None` at the end.
    pub(super) fn next_facet(&mut self) -> Result<Option<Facet>, StlFault> {
        loop {
            if !self.look_for_word()? {
                return if self.in_solid {
                    Err(StlFault::TruncatedText { line: self.line })
                } else {
                    Ok(None)
                };
            }
            if self.in_solid && self.is("facet") {
                return self.facet().map(Some);
            }
            let expected = if self.in_solid { "endsolid" } else { "solid" };
            if !self.is(expected) {
                let expected = if self.in_solid { "facet or endsolid" } else { "solid" };
                return Err(StlFault::Syntax { line: self.line, expected });
            }
            self.in_solid = !self.in_solid;
            self.end_line()?;
        }
    }

    fn facet(&mut self) -> Result<Facet, StlFault> {
        self.require("normal")?;
        // The stated normal may be anything, even not a number: the winding is used.
        let normal = Vec3::new(self.any_number()?, self.any_number()?, self.any_number()?);
        self.require("outer")?;
        self.require("loop")?;
        let mut corners = [Vec3::zeros(); 3];
        for corner in &mut corners {
            self.require("vertex")?;
            *corner = Vec3::new(self.number()?, self.number()?, self.number()?);
        }
        self.require("endloop")?;
        self.require("endfacet")?;
        Ok(Facet { corners, normal })
    }

    fn require(&mut self, expected: &'static str) -> Result<(), StlFault> {
        self.need_word()?;
        if self.is(expected) { Ok(()) } else { Err(StlFault::Syntax { line: self.line, expected }) }
    }

    fn any_number(&mut self) -> Result<f64, StlFault> {
        self.need_word()?;
        let word = std::str::from_utf8(self.written()).unwrap_or_default();
        Ok(word.parse().unwrap_or(f64::NAN))
    }

    fn number(&mut self) -> Result<f64, StlFault> {
        let number = self.any_number()?;
        if number.is_finite() {
            return Ok(number);
        }
        Err(StlFault::Syntax { line: self.line, expected: "a finite number" })
    }

    fn need_word(&mut self) -> Result<(), StlFault> {
        if self.look_for_word()? { Ok(()) } else { Err(StlFault::TruncatedText { line: self.line }) }
    }

    fn written(&self) -> &[u8] {
        self.word.get(..self.length).unwrap_or(&[])
    }

    fn is(&self, word: &str) -> bool {
        self.written().eq_ignore_ascii_case(word.as_bytes())
    }

    /// Reads the next word; false at the end of the text. The white space after a word stays.
    fn look_for_word(&mut self) -> Result<bool, StlFault> {
        self.length = 0;
        loop {
            let byte = self.input.look(1)?.first().copied();
            let is_space = byte.is_none_or(|byte| byte.is_ascii_whitespace());
            match byte {
                Some(byte) if !is_space => {
                    let Some(place) = self.word.get_mut(self.length) else {
                        let expected = "a word of at most 64 bytes";
                        return Err(StlFault::Syntax { line: self.line, expected });
                    };
                    *place = byte;
                    self.length += 1;
                }
                _ if self.length > 0 => return Ok(true),
                None => return Ok(false),
                Some(byte) => self.line += u64::from(byte == b'\n'),
            }
            self.input.skip(1);
        }
    }

    /// Skips the rest of the line.
    fn end_line(&mut self) -> Result<(), StlFault> {
        while let Some(byte) = self.input.next()? {
            if byte == b'\n' {
                self.line += 1;
                break;
            }
        }
        Ok(())
    }
}
