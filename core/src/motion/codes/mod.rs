//! What codes and statement words mean, one table a dialect.

mod apt;
mod heidenhain;
mod iso;
mod siemens;

use super::FeedMode;
use super::modal::{MotionMode, ToolLength, Transformation};
use crate::program::{Dialect, Keyword, Word, WordForm};

/// G codes count in tenths; statement words stand behind them.
const FIRST_KEYWORD: u32 = 1_000_000;

/// The code of a word with address G or M: tenths, or the number of a statement word behind all of these.
#[inline]
pub(super) fn code_of(word: &Word) -> Option<u32> {
    if word.form == WordForm::Keyword {
        return word.keyword().map(|keyword| FIRST_KEYWORD + u32::from(keyword.number()));
    }
    word.code_tenths()
}

/// The statement word of a code, if it is one.
pub(super) fn keyword_of(code: u32) -> Option<Keyword> {
    Keyword::of_number(u16::try_from(code.checked_sub(FIRST_KEYWORD)?).ok()?)
}

/// The meaning of a code in a dialect.
pub(super) fn meaning(dialect: Dialect, code: u32) -> Code {
    if let Some(keyword) = keyword_of(code) {
        return match dialect {
            Dialect::Siemens => siemens::keyword_meaning(keyword),
            Dialect::Heidenhain => heidenhain::keyword_meaning(keyword),
            Dialect::Apt => apt::keyword_meaning(keyword),
            Dialect::Iso | Dialect::Csv => Code::Unknown,
        };
    }
    match dialect {
        Dialect::Iso | Dialect::Csv => iso::meaning(code),
        Dialect::Siemens => siemens::meaning(code),
        Dialect::Heidenhain | Dialect::Apt => Code::Unknown,
    }
}

/// The meaning of a G code of ISO programs.
pub(super) fn iso_meaning(tenths: u32) -> Code {
    iso::meaning(tenths)
}

/// The meaning of an M code of so many tenths.
pub(super) fn m_meaning(dialect: Dialect, tenths: u32) -> MCode {
    match dialect {
        Dialect::Iso | Dialect::Csv => iso::m_meaning(tenths),
        Dialect::Siemens => siemens::m_meaning(tenths),
        Dialect::Heidenhain => heidenhain::m_meaning(tenths),
        Dialect::Apt => MCode::Plain,
    }
}

/// What an M code means for the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MCode {
    /// Nothing.
    Plain,
    /// The end of the program.
    End,
    /// The end of a subprogram, or the program again.
    Return,
    Call,
    ToolChange,
    /// A code of the machine's builder that switches the kinematics.
    KinematicsSwitch,
    ExtruderAbsolute,
    ExtruderRelative,
    /// Axis words of the block count from another place.
    MachineCoordinates,
    /// A cycle runs at the block's end; modal ones at every motion from here on.
    CycleCall,
    CycleModal,
    /// Tool-centre-point control; off behind the motion.
    Tcp(bool),
    /// Another state of the control's compensation of rotary motions.
    TcpOther,
    /// Rotary axes take the shorter way; off behind the motion.
    ShortestPath(bool),
    /// F of rotary axes counts millimetres.
    RotaryFeedInMm(bool),
    Feed(FeedMode),
    /// Displays of rotary axes are reduced.
    ForgetRotary,
    /// Axes move that are not named.
    Elsewhere,
    /// Modes are again what they were where another code kept them, or it is a code of the machine's builder.
    RestoresModes,
}

/// What a statement word means beyond what codes mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Statement {
    /// An arc; a full circle where no axis word says where it ends.
    ArcAboutCentre,
    /// An arc that goes on where the motion before ends.
    TangentArc,
    /// At rapid traverse, in this block.
    RapidHere,
    /// The end of this motion is cut off.
    Corner,
    /// A feed is stated, whatever its unit.
    Feedrate,
    /// The feed is not a path feed in the program's unit.
    OtherFeed,
    /// What F is counted in, and its unit where that is not the program's.
    FeedUnit(FeedMode, Option<f64>),
    End,
    ToolCall,
    OtherToolAxis,
    DatumShift,
    DatumReset,
    DatumTable,
    AxisScaling,
    Preset,
    TiltOff,
    Tcp(bool),
    TcpOther,
    Label,
    LabelEnd,
    CallLabel,
    RepeatLabel,
    CycleCall,
    /// A motion whose end is not stated.
    Contour,
    Probe,
    /// A point to go to.
    Point,
    /// A point where the tool is.
    From,
    /// How the next point is reached.
    Next(MotionMode),
    InCycle(bool),
    Multax(bool),
    ToolAxis,
    CoordinateSystem,
    GoHome,
    /// Full circles that an arc runs beside the way to its end.
    FurtherTurns,
}

/// A part of the programmable frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ProgramFrame {
    Offset,
    Rotation,
    Scaling,
    Mirror,
}

/// The meaning of a G code.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Code {
    Motion(MotionMode),
    /// A motion only where axis words stand in the block; a mode of the control otherwise (G5.1, G60).
    MotionWithAxes(MotionMode),
    /// Cancels a canned cycle.
    EndCycle,
    Plane(u8),
    Incremental(bool),
    Units(f64),
    Feed(FeedMode),
    Compensation(bool),
    ToolLength(ToolLength),
    /// G54 and its kin; those with a P word are told apart by it.
    WorkOffset,
    Transform(Transformation, bool),
    /// Axis words of the block are no motion: dwell, stroke limits, tables of offsets that are not active.
    NoMotion,
    /// G10: L2 and L20 write work offsets, others tool offsets.
    WriteOffsets,
    /// G92, G52 with axis words.
    Shift,
    /// G92.1 to G92.3.
    OtherShift,
    /// G53.
    MachineCoordinates,
    /// G28, G30: the axes named go to a reference position.
    Reference,
    /// Moves axes that are not named.
    Elsewhere,
    Call,
    ModalCall,
    EndModalCall,
    /// A statement word with a meaning of its own.
    Statement(Statement),
    /// TRANS, ROT, SCALE, MIRROR; true: added to the programmable frame, not in place of it.
    ProgramFrame(ProgramFrame, bool),
    /// MCALL of a standard cycle, which leaves modes as they are.
    ModalCycle,
    /// A standard cycle, once.
    Cycle,
    /// CYCLE800: a plane is swivelled, perhaps with the axes that do it, or no more.
    Swivel(bool),
    /// MEAS.
    Probing,
    /// The end is given in polar words.
    PolarEnd,
    /// An orientation in a form that is not followed.
    OrientationWord,
    /// Another axis moves, perhaps one of the machine's five under another name.
    OtherAxis,
    /// A word that nothing is known of, or that changes the course of the motion and not its end.
    ForeignWord,
    /// Changes the motion of its block.
    BlockWord,
    /// Another tool length.
    ToolOffset,
    RoundsCorners(bool),
    VectorsInMachine(bool),
    /// The machine stops at the end of every block, or does not.
    ExactStop(bool),
    /// It stops at the end of this block.
    ExactStopHere,
    /// Changes nothing that matters for the path's ends.
    Harmless,
    Unknown,
}
