//! Sinumerik codes.

use super::{Code, MCode, ToolLength, iso};
use crate::program::Keyword;

/// The meaning of the G code of so many tenths.
pub(super) fn meaning(tenths: u32) -> Code {
    iso::meaning(tenths)
}

/// The meaning of an M code of so many tenths.
pub(super) fn m_meaning(tenths: u32) -> MCode {
    match tenths {
        20 | 170 | 300 => MCode::End,
        60 => MCode::ToolChange,
        _ => MCode::Plain,
    }
}

/// The meaning of a statement word.
pub(super) fn keyword_meaning(keyword: Keyword) -> Code {
    match keyword {
        Keyword::Traori => Code::ToolLength(ToolLength::Tcp),
        Keyword::Trafoof => Code::ToolLength(ToolLength::Plain),
        Keyword::Supa => Code::MachineCoordinates,
        _ => Code::Unknown,
    }
}
