//! The meanings of codes and statement words for motions. The tables in `dialect` state the meaning of each code.

use super::FeedMode;
use super::cycle::Retract;
use super::modal::{MotionMode, ToolLength, Transformation};
use super::work_offset::OffsetCode;

/// The meaning of an M code for the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MFunction {
    /// Nothing.
    Plain,
    /// The end of the program.
    End,
    /// The end of a subprogram, or the program starts again.
    Return,
    Call,
    ToolChange,
    /// A code of the machine's builder that switches the kinematics.
    KinematicsSwitch,
    ExtruderAbsolute,
    ExtruderRelative,
    /// The axis words of the block count from the zero of the machine.
    MachineCoordinates,
    /// The axis words of the block count from another place.
    OtherCoordinates,
    /// A cycle runs at the block's end. A modal cycle runs at every motion from here on.
    CycleCall,
    CycleModal,
    /// Tool-centre-point control on or off. Off takes effect after the motion.
    Tcp(bool),
    /// Another state of the control's compensation of rotary motions.
    TcpOther,
    /// Whether rotary axes take the shorter way. Off takes effect after the motion.
    ShortestPath(bool),
    /// F of rotary axes counts millimetres.
    RotaryFeedInMm(bool),
    Feed(FeedMode),
    /// Displays of rotary axes are reduced.
    ForgetRotary,
    /// Moves axes that are not named.
    Elsewhere,
    /// Another spindle, with a tool that the text does not name.
    OtherSpindle,
    /// The tool points along another axis, until a code of its length names the axis.
    TurnsHead,
    /// It changes modes, or the way to a position, and the text does not say how.
    Unknown,
}

/// The meaning of a statement word, beyond the meanings of codes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Statement {
    /// An arc; a full circle if no axis word states its end.
    ArcAboutCentre,
    /// An arc that continues from the end of the motion before.
    TangentArc,
    /// At rapid traverse, in this block.
    RapidHere,
    /// The end of this motion is cut off.
    Corner,
    /// A feed is stated, whatever its unit.
    Feedrate,
    /// The feed is not a path feed in the program's unit.
    OtherFeed,
    /// The mode in which F counts, and its unit if that is not the program's.
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
    /// The defined cycle runs at the present position.
    CycleCallHere,
    /// A cycle that makes one hole is defined.
    DefineHole,
    /// A cycle that waits for its call and is not followed.
    OtherCycle,
    /// A motion whose end is not stated.
    Contour,
    Probe,
    /// A point to go to.
    Point,
    /// A point at which the tool is.
    From,
    /// The next point is reached at rapid traverse.
    NextRapid,
    /// The next point is reached on the circle in the words of the block.
    Circle,
    InCycle(bool),
    /// Points count in one system, whatever system a set-up states.
    WorldPoints,
    Multax(bool),
    ToolAxis,
    CoordinateSystem,
    GoHome,
    /// Full circles that an arc makes in addition to the path to its end.
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
    /// A motion only if the block has axis words; otherwise a mode of the control (G5.1, G60).
    MotionWithAxes(MotionMode),
    /// Cancels a canned cycle.
    EndCycle,
    /// G98, G99: the level to which canned cycles retract.
    CycleRetract(Retract),
    Plane(u8),
    Incremental(bool),
    Units(f64),
    Feed(FeedMode),
    Compensation(bool),
    /// G41.1, G42.1: D is the diameter of the cutter, which runs left or right of the path.
    CompensationByDiameter {
        left: bool,
    },
    /// G41, G42: a register of the control has the radius of the cutter, which runs left or right of the path.
    CompensationByRegister {
        left: bool,
    },
    /// A tool length: G43, G44.
    ToolLength(ToolLength),
    /// A code that states what is interpolated, whatever a code of the machine's builder stated before: G43.4, G43.5,
    /// G49.
    TipControl(ToolLength),
    /// TRAORI and TRAFOOF. They end all other transformations of the kinematics.
    SwitchTip(ToolLength),
    /// G43.1: on some controls the length along the tool, whatever its direction; on other controls the length along
    /// Z.
    LengthAlongTool,
    /// G169 and G170 of OSP. Axis words in the same block are not a plain motion.
    TipControlApart(ToolLength),
    /// G54, G55 and G56 of OSP: the tool's length along X, Y or Z; G53: none.
    LengthAlong(Option<u8>),
    /// G15 of OSP: the work offset of this H.
    OffsetByH,
    /// G16 of OSP: the work offset of this H, in this block.
    OffsetByHHere,
    /// G54 and similar codes.
    WorkOffset(OffsetCode),
    /// G54, G54.1 and G154: a P word selects among the offsets of the code.
    WorkOffsetByP(OffsetCode),
    /// G54.2 and G54.4: separate modes beside the work offset. P0 ends them.
    ModeByP(Transformation),
    Transform(Transformation, bool),
    /// G69: ends a rotation and a tilted plane. In some dialects its block may have axis words that are not a motion.
    EndRotation {
        names_axes: bool,
    },
    /// G50: axis words in its block may not be a motion.
    EndScaling,
    /// G51.1 and G50.1: act on the axes that they name, or on all axes if they name none.
    MirrorNamed(bool),
    /// G15: ends polar words. With H it names a work offset on some controls.
    EndPolarOrOffset,
    /// G107: on with an axis word, whatever its value; off without one.
    CylinderOfAxis,
    /// G07: on with an axis at 0, which then does not move, and off with the axis at 1.
    HypotheticalAxis,
    /// A unit: G70, G71. With words of cycles, and without a code that states how the block moves, it is a cycle that
    /// is not followed.
    UnitsUnlessCycle(f64),
    /// No effect: G11, G62. With axis words, and without a code that states how the block moves, it is a frame that is
    /// not followed.
    HarmlessUnlessAxes,
    /// The axis words of the block are not a motion: dwell, stroke limits, tables of offsets that are not active.
    NoMotion,
    /// G10: L2 and L20 write work offsets. Others write tool offsets.
    WriteOffsets,
    /// G92, with axis words.
    Shift,
    /// G52, with axis words. With zeros it ends the shift.
    LocalShift,
    /// G92.1 and G92.2: end the shift by G92.
    EndShift,
    /// Another change of the zero.
    OtherShift,
    /// G53, SUPA: the block counts from the zero of the machine.
    MachineCoordinates,
    /// The block counts from a place near it: an offset stays that the text does not state.
    NearMachineZero,
    /// G28, G30: the named axes go to a reference position.
    Reference,
    /// G28.1 of RS274/NGC: stores the place for G28. On other controls it is not known.
    StoreReference,
    /// Moves axes that are not named.
    Elsewhere,
    /// G53.1: the rotary axes turn to the tilted plane.
    ToPlane,
    Call,
    ModalCall,
    EndModalCall,
    /// A statement word with a meaning of its own.
    Statement(Statement),
    /// TRANS, ROT, SCALE, MIRROR. `true`: it is added to the programmable frame instead of replacing it.
    ProgramFrame(ProgramFrame, bool),
    /// MCALL of a standard cycle. It leaves the modes unchanged.
    ModalCycle,
    /// A standard cycle, once.
    Cycle,
    /// CYCLE800: swivels a plane, perhaps together with its axes, or ends the swivelling.
    Swivel(bool),
    /// MEAS.
    Probing,
    /// The end is given in polar words.
    PolarEnd,
    /// An orientation in a form that is not followed.
    OrientationWord,
    /// Another axis moves. It may be one of the machine's five under another name.
    OtherAxis,
    /// An unknown word, or a word that changes the course of the motion but not its end.
    ForeignWord,
    /// Changes the motion of its block.
    BlockWord,
    /// Another tool length.
    ToolOffset,
    RoundsCorners(bool),
    VectorsInMachine(bool),
    /// Whether the machine stops at the end of every block.
    ExactStop(bool),
    /// The machine stops at the end of this block.
    ExactStopHere,
    /// Has no effect on the ends of the path.
    Harmless,
    Unknown,
}

/// What a code or statement word says about the motion of its block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockMotion {
    /// Axis words are a motion at rapid traverse, here and in the blocks after it.
    Rapid,
    /// Axis words are a motion at feed, here and in the blocks after it.
    AtFeed,
    /// The axis words of the block are not a place to go to.
    NotByAxisWords,
}

impl Meaning {
    /// What it says about the motion of its block, if it says anything.
    pub(super) const fn block_motion(self) -> Option<BlockMotion> {
        match self {
            Self::Motion(MotionMode::Rapid) => Some(BlockMotion::Rapid),
            Self::Motion(_) => Some(BlockMotion::AtFeed),
            Self::NoMotion
            | Self::WriteOffsets
            | Self::Shift
            | Self::LocalShift
            | Self::EndShift
            | Self::OtherShift
            | Self::CylinderOfAxis
            | Self::Transform(Transformation::PartFrame, _)
            | Self::Transform(_, true)
            | Self::ProgramFrame(..)
            | Self::Statement(
                Statement::DatumShift | Statement::AxisScaling | Statement::From | Statement::ToolAxis,
            ) => Some(BlockMotion::NotByAxisWords),
            _ => None,
        }
    }

    /// The tool length that the code puts in force, if it does so.
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

    /// The transformation that the code switches on or off, if it does so whatever else its block has.
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
