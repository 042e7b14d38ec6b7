//! What a first look through the text tells: where contacts are stated, and its finest decimals.

use super::numbering::Numbering;
use crate::process::fault::Fault;
use crate::process::set_up::{ContactSource, ToolCalls};
use crate::program::{Address, Batch, Borne, Grammar, Steps, Word, WordForm};
use crate::units::MM_PER_INCH;

/// The result of one pass over the text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::process) struct Survey {
    /// Contacts the program states: the first available of points and normals.
    pub(in crate::process) stated: Option<ContactSource>,
    /// Most decimals of an X Y Z word.
    pub(in crate::process) linear_decimals: u8,
    /// Most decimals of a rotary word.
    pub(in crate::process) rotary_decimals: u8,
    /// False for a table without a column F.
    pub(in crate::process) has_feed_column: bool,
    /// The numbering of its blocks.
    pub(in crate::process) numbering: Numbering,
    /// The tools that it calls.
    pub(in crate::process) tools: ToolCalls,
    /// Steps that were done to it before, according to its stamps.
    pub(in crate::process) borne: Borne,
}

/// Fewest decimals of linear words that are written anew, in mm and in inches, and of rotary words: the increments of
/// a control.
const LEAST_MM_DECIMALS: u8 = 3;
const LEAST_INCH_DECIMALS: u8 = 4;
const LEAST_ROTARY_DECIMALS: u8 = 3;
/// Units that differ by less are one \[mm\].
const SAME_UNIT_MM: f64 = 1e-9;
/// Further decimals are arithmetic of the post, not resolution of the control.
pub(in crate::process) const CONTROL_DECIMALS: u8 = 6;
/// G codes that a block with a contact point may have, in tenths: motion, plane, units, distance, feed and
/// compensation off, tool-centre-point control, work offsets.
const CUTTING_CODES: [u32; 22] =
    [0, 10, 20, 30, 170, 180, 190, 200, 210, 400, 430, 434, 490, 540, 550, 560, 570, 580, 590, 900, 930, 940];

impl Survey {
    /// The survey before the first byte.
    pub(in crate::process) fn nothing() -> Self {
        Self {
            stated: None,
            linear_decimals: 0,
            rotary_decimals: 0,
            has_feed_column: true,
            numbering: Numbering::default(),
            tools: ToolCalls::default(),
            borne: Borne::default(),
        }
    }

    /// Refuses steps that were done to the program before, unless they may be repeated and the caller allows it. A
    /// stamp whose steps cannot be read may be that of any step.
    pub(in crate::process) fn refuse_repeated(self, asked: Steps, allow_repeated: bool) -> Result<(), Fault> {
        if let Some(text) = self.borne.unreadable.filter(|_| !asked.is_empty()) {
            return Err(Fault::StampUnreadable { text });
        }
        let done = asked.not_done_before(allow_repeated).shared_with(self.borne.steps);
        done.map_or(Ok(()), |step| Err(Fault::AlreadyCompensated { step }))
    }

    /// Whether a step that used this survey is still right after the survey of the whole program.
    pub(in crate::process) fn holds_for(&self, whole: &Self) -> bool {
        self.stated == whole.stated
            && self.linear_decimals == whole.linear_decimals
            && self.rotary_decimals == whole.rotary_decimals
            && self.has_feed_column == whole.has_feed_column
            && self.numbering.holds_for(&whole.numbering)
            && self.tools.holds_for(&whole.tools)
            && self.borne == whole.borne
    }

    /// Looks at the next batch. `rotary` are the addresses of the rotary axes.
    pub(in crate::process) fn see(&mut self, batch: &Batch, rotary: [Address; 2]) {
        if batch.dialect().rules().grammar == Grammar::Cells {
            self.has_feed_column = batch.columns().contains(&Address::F);
            if batch.columns().contains(&Address::NX) {
                self.stated = Some(ContactSource::Normals);
            }
        }
        for block in batch.blocks() {
            let words = batch.words(block);
            let (mut addresses, mut points) = (0, 0);
            for word in words {
                addresses |= word.address.bit();
                if word.form != WordForm::Number {
                    continue;
                }
                let decimals = word.decimals.min(CONTROL_DECIMALS);
                match word.address {
                    Address::X | Address::Y | Address::Z => {
                        self.linear_decimals = self.linear_decimals.max(decimals);
                    }
                    Address::U | Address::V | Address::W => points += 1,
                    other if rotary.contains(&other) => {
                        self.rotary_decimals = self.rotary_decimals.max(decimals);
                    }
                    _ => {}
                }
            }
            if addresses & Address::N.bit() != 0 {
                self.numbering.see(words);
            }
            self.tools.see(batch, block, addresses);
            if self.stated.is_some() {
                continue;
            }
            if addresses & Address::NX.bit() != 0 {
                self.stated = Some(ContactSource::Normals);
            } else if points == 3 && is_cutting(words) {
                self.stated = Some(ContactSource::Program);
            }
        }
    }

    /// Decimals of linear and rotary words that are written anew: those of the program's finest, and no fewer than a
    /// control's increments have.
    pub(in crate::process) fn written_decimals(&self, mm_per_unit: f64) -> [u8; 2] {
        let inches = (mm_per_unit - MM_PER_INCH).abs() < SAME_UNIT_MM;
        let least = if inches { LEAST_INCH_DECIMALS } else { LEAST_MM_DECIMALS };
        [self.linear_decimals.max(least), self.rotary_decimals.max(LEAST_ROTARY_DECIMALS)]
    }

    /// The contact source for this program. `auto` takes the first available of program, normals and surface,
    /// otherwise the tip. Any other source must be available.
    pub(in crate::process) fn contact(
        self,
        asked: ContactSource,
        has_part: bool,
    ) -> Result<ContactSource, Fault> {
        let beside = if has_part { ContactSource::Surface } else { ContactSource::Tip };
        let missing = match (asked, self.stated) {
            (ContactSource::FeedPlane | ContactSource::Tip, _) => return Ok(asked),
            (ContactSource::Auto, stated) => return Ok(stated.unwrap_or(beside)),
            (ContactSource::Surface, _) if has_part => return Ok(asked),
            (ContactSource::Surface, _) => "surface of the part sent with it",
            (asked, Some(stated)) if asked == stated => return Ok(asked),
            (ContactSource::Program, _) => "U V W words",
            (ContactSource::Normals, _) => "contact normals nx ny nz",
        };
        Err(Fault::NoContactInProgram { contact: asked.name(), missing })
    }
}

/// Whether the block has no code that gives U V W another meaning, such as incremental axes of a reference return.
fn is_cutting(words: &[Word]) -> bool {
    words
        .iter()
        .filter(|word| word.address == Address::G)
        .all(|word| word.code_tenths().is_some_and(|code| CUTTING_CODES.contains(&code)))
}
