//! What codes and statement words mean for motions. Which code means what is in the tables of `dialect`.

use super::FeedMode;
use super::modal::{MotionMode, ToolLength, Transformation};
use super::work_offset::OffsetCode;

/// What an M code means for the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MFunction {
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

/// The meaning of a G code or a statement word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Meaning {
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
    /// A tool length: G43, G44.
    ToolLength(ToolLength),
    /// One that says what is interpolated, whatever a code of the machine's builder said before: G43.4, G43.5, G49.
    TipControl(ToolLength),
    /// TRAORI and TRAFOOF, which end all other transformations of the kinematics.
    SwitchTip(ToolLength),
    /// G43.1: on some controls the length along the tool, whichever way it points; on others along Z.
    LengthAlongTool,
    /// G169 and G170 of OSP, beside which axis words are no plain motion.
    TipControlApart(ToolLength),
    /// G54, G55 and G56 of OSP: the tool's length along X, Y or Z; G53: none.
    LengthAlong(Option<u8>),
    /// G15 of OSP: the work offset of this H.
    OffsetByH,
    /// G16 of OSP: the work offset of this H, in this block.
    OffsetByHHere,
    /// G54 and its kin.
    WorkOffset(OffsetCode),
    /// G54, G54.1 and G154, which a P word tells apart from others of their code.
    WorkOffsetByP(OffsetCode),
    /// G54.2 and G54.4: modes of their own beside the work offset; P0 ends them.
    ModeByP(Transformation),
    Transform(Transformation, bool),
    /// G69: ends a rotation and a tilted plane; where axis words may stand beside it that are no motion.
    EndRotation {
        names_axes: bool,
    },
    /// G50, beside which axis words may be no motion.
    EndScaling,
    /// G51.1 and G50.1: of the axes it names; without any, of all.
    MirrorNamed(bool),
    /// G15: ends polar words; with H it names a work offset on some controls.
    EndPolarOrOffset,
    /// G107: on with an axis, whatever the value beside its letter; off without.
    CylinderOfAxis,
    /// G07: on with an axis at 0, which does not move then, and off with the axis at 1.
    HypotheticalAxis,
    /// A unit; beside words of cycles, where no code says how the block moves, a cycle that is not followed: G70, G71.
    UnitsUnlessCycle(f64),
    /// Nothing; beside axis words, where no code says how the block moves, a frame that is not followed: G11, G62.
    HarmlessUnlessAxes,
    /// Axis words of the block are no motion: dwell, stroke limits, tables of offsets that are not active.
    NoMotion,
    /// G10: L2 and L20 write work offsets, others tool offsets.
    WriteOffsets,
    /// G92, with axis words.
    Shift,
    /// G52, with axis words; with zeros it ends.
    LocalShift,
    /// G92.1 and G92.2: end what G92 shifted.
    EndShift,
    /// Another change of the zero.
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

impl Meaning {
    /// The tool length that it puts in force, if it is one that does.
    pub(super) const fn tool_length(self) -> Option<ToolLength> {
        match self {
            Self::ToolLength(length)
            | Self::TipControl(length)
            | Self::TipControlApart(length)
            | Self::SwitchTip(length) => Some(length),
            Self::LengthAlongTool => Some(ToolLength::Plain),
            _ => None,
        }
    }

    /// The transformation that it puts on or off, if it does so whatever stands beside it.
    pub(super) const fn transformation(self) -> Option<(Transformation, bool)> {
        match self {
            Self::Transform(which, on) => Some((which, on)),
            Self::EndRotation { .. } => Some((Transformation::Rotation, false)),
            Self::LengthAlong(axis) => Some((Transformation::ToolAxis, matches!(axis, Some(0 | 1)))),
            Self::EndScaling => Some((Transformation::Scaling, false)),
            Self::MirrorNamed(on) => Some((Transformation::Mirror, on)),
            Self::EndPolarOrOffset => Some((Transformation::PolarWords, false)),
            Self::CylinderOfAxis | Self::HypotheticalAxis => Some((Transformation::Cylinder, true)),
            _ => None,
        }
    }
}
