//! The parameters of a posting.

use std::ops::RangeInclusive;

use crate::kinematics::REWIND_DEG;
use crate::process::set_up::ProgramSetup;
use crate::units::{Feedrate, Length};

/// The meaning of X Y Z in the posted program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PostForm {
    /// Tool tips in W under G43.4; F is the tip's feed.
    #[default]
    Tcp,
    /// Axis positions in the work offset. F is inverse time (G93), except where the path to a point is not
    /// known.
    Machine,
}

/// The parameters of a posting.
#[derive(Debug, Clone, PartialEq)]
pub struct PostParameters {
    /// The caller's statements that the text does not have: unit, work offset, tool length, dialect of the
    /// source.
    pub program: ProgramSetup,
    /// The meaning of X Y Z.
    pub form: PostForm,
    /// H of G43.4, and of G43 in the machine form. If it is missing, the length register or the number of the tool.
    pub length_number: Option<u32>,
    /// Each `LOADTL/` of another tool becomes `T… M6`, and a new approach follows. Without this, the program has one
    /// tool, and the caller puts it in.
    pub changes_tools: bool,
    /// The largest F in millimetres per minute that the machine takes.
    pub max_feed: Option<Feedrate>,
    /// Rotary words before the first point, in the profile's order \[deg\].
    pub start_words_deg: Option<[f64; 2]>,
    /// A rotary step above this is a rewind \[deg\].
    pub rewind_deg: f64,
    /// Decimals of X Y Z.
    pub linear_decimals: u8,
    /// Decimals of the rotary words.
    pub rotary_decimals: u8,
    /// Largest distance from an arc to the lines that replace it.
    pub arc_tolerance: Length,
    /// Most blocks written.
    pub max_blocks_out: u64,
}

impl PostParameters {
    /// Valid numbers of a length: H0 is no length, and controls have four digits.
    pub const LENGTH_NUMBERS: RangeInclusive<u32> = 1..=9999;

    /// Whether the program switches a length on whose number the data may state.
    pub(super) fn takes_length_of_data(&self) -> bool {
        self.length_number.is_none() && (self.form == PostForm::Tcp || self.changes_tools)
    }

    /// The defaults of the contract: tool tips under G43.4, four decimals.
    #[must_use]
    pub fn new(program: ProgramSetup) -> Self {
        Self {
            program,
            form: PostForm::Tcp,
            length_number: None,
            changes_tools: false,
            max_feed: None,
            start_words_deg: None,
            rewind_deg: REWIND_DEG,
            linear_decimals: 4,
            rotary_decimals: 4,
            arc_tolerance: Length::from_mm(0.005),
            max_blocks_out: 20_000_000,
        }
    }
}
