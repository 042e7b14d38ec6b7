//! Why a motion has to be left unchanged.

use thiserror::Error;

use crate::program::Address;

/// A modal group whose value can be lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModalGroup {
    /// G0 G1 G2 G3.
    Motion,
    /// G17 G18 G19.
    Plane,
    /// G90 G91.
    Distance,
    /// G20 G21.
    Units,
    /// G93 G94 G95.
    FeedMode,
    /// G40 G41 G42.
    CutterCompensation,
    /// G43 G43.4 G49.
    ToolLength,
    /// G69, G50, G50.1, G15, G13.1: rotation, tilted plane, scaling, mirror, polar words, polar interpolation.
    Transformation,
}

impl ModalGroup {
    /// The codes by which a program makes the group known again.
    #[must_use]
    pub fn codes(self) -> &'static str {
        match self {
            Self::Motion => "G0 G1 G2 G3",
            Self::Plane => "G17 G18 G19",
            Self::Distance => "G90 G91",
            Self::Units => "G20 G21",
            Self::FeedMode => "G93 G94 G95 (OSP: G94 G95)",
            Self::CutterCompensation => "G40 G41 G42 (R0 RL RR)",
            Self::ToolLength => "G43 G43.4 G49 (M128 M129, TRAORI TRAFOOF, OSP: G169 G170)",
            Self::Transformation => {
                "G69 G50 G50.1 G15 G13.1 (PLANE RESET, cycles 8 10 11 19, OSP: G10 G50 G56)"
            }
        }
    }
}

/// Why a motion is left unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Unfollowable {
    /// A modal group is unknown.
    #[error("the state of {} is not known here; state it again before this motion", group.codes())]
    ModeUnknown {
        /// The group.
        group: ModalGroup,
    },
    /// The value of a word is an expression or a parameter.
    #[error("the value of {address} is an expression or a parameter; write a number")]
    Expression {
        /// Address of the word.
        address: Address,
    },
    /// The block has two words of the same address.
    #[error("the block has {address} twice; keep only the word that is meant")]
    RepeatedAddress {
        /// The repeated address.
        address: Address,
    },
    /// A word of an axis that the machine does not have, whose value changes.
    #[error("the machine has no axis {address}")]
    NoSuchAxis {
        /// Address of the word.
        address: Address,
    },
    /// A `/` block, which the operator may have skipped.
    #[error("the operator can skip the block")]
    BlockDelete,
    /// Cutter radius compensation.
    #[error("cutter radius compensation is active")]
    CutterCompensation,
    /// G68.2 to G68.4, PLANE: the words are those of a tilted plane.
    #[error("a tilted working plane is active")]
    TiltedPlane,
    /// A tilted plane whose rotary positions are not decided.
    #[error(
        "the machine's profile does not decide which rotary positions the control takes for the tilted plane"
    )]
    PlaneSolution,
    /// The rotary axes turn to a tilted plane, to positions that are known. Nothing else moves by words.
    #[error("the rotary axes turn to the tilted plane")]
    TurnToPlane,
    /// Rotation, scaling, mirror, polar words, cylinder or diameter mode.
    #[error("a coordinate transformation is active")]
    Transformation,
    /// `TRAORI(2)`: a transformation of the control other than its first one.
    #[error(
        "TRAORI selects a second transformation or another basic orientation, but the profile describes only the first transformation of the control"
    )]
    OtherTransformation,
    /// G43.5: the tool axis is given as a vector.
    #[error("the tool axis is programmed as a vector, and it is not known how the rotary axes turn to it")]
    ToolVector,
    /// M428, M429, M430: codes of the machine's builder, whose meaning is not in the text. M138 of conversational
    /// programs.
    #[error("an M code switches the kinematics; state the interpolation")]
    KinematicsSwitched,
    /// I, J or K in a straight motion.
    #[error("a straight motion has the word {address}, whose effect is not known")]
    VectorWord {
        /// Address of the word.
        address: Address,
    },
    /// `,R` `,C` `,A` or R: the control changes the corner to the next block.
    #[error(
        "the control changes the corner next to this motion, or the next motion continues in its direction"
    )]
    Corner,
    /// G53.
    #[error("the motion is in machine coordinates")]
    MachineCoordinates,
    /// G16 of OSP.
    #[error("G16 selects another work offset for this block only")]
    OffsetHere,
    /// A canned cycle.
    #[error("a canned cycle is active")]
    CannedCycle,
    /// Splines and NURBS.
    #[error("the motion is a spline")]
    Spline,
    /// Threads (G33), single-direction positioning (G60), moves by tool offsets (G45–G48).
    #[error("the motion is a thread, a single-direction positioning or a move by tool offsets")]
    SpecialMotion,
    /// Probing and skip.
    #[error("the motion is a probing move")]
    Probing,
    /// G28, G30 and similar codes.
    #[error("the motion goes to a reference position")]
    Reference,
    /// A subprogram or macro call.
    #[error("a subprogram or macro is called")]
    Call,
    /// M99: the block ends a subprogram, or starts the program again.
    #[error("the block returns from a subprogram")]
    Return,
    /// A G code that is not known, or not known as a motion.
    #[error("a code in the block is not known")]
    UnknownCode,
    /// A code that is not known, or a call, on a control where no code states again everything that it may have
    /// changed.
    #[error(
        "a call or a code before this motion (also one in INSERT, PREFUN or LOAD) is not known, and it may have changed what no later code states again; remove the line if the machine does not need it, or post the program without it"
    )]
    StateLost,
    /// A modal macro (G66) runs at every motion.
    #[error("a macro is called at every motion")]
    ModalCall,
    /// U V W in G91.
    #[error("U V W count from the block before")]
    IncrementalContact,
    /// M83, or E in G91: E counts from the block before.
    #[error("the extruder word counts from the block before")]
    RelativeExtruder,
    /// Polar coordinates, tangent arcs, roundings, approaches, free contours, motions along surfaces.
    #[error("the control computes where this motion ends")]
    ContourElement,
    /// A point on the circle of the arc before it, without a `CIRCLE/` of its own.
    #[error(
        "the point is on the circle of the CIRCLE before it, and the text does not say whether the tool goes there along the circle or straight"
    )]
    OnCircle,
    /// A `CIRCLE/` with items that are not understood.
    #[error("the CIRCLE before the point states turns (TIMES) or other items that are not followed")]
    CircleUnread,
    /// The text is a section that is also called from elsewhere.
    #[error("the block is in a section that is called from elsewhere in the program")]
    CalledText,
    /// M126, and a turn by half a turn or more.
    #[error("a rotary axis takes the shorter way around, not the way that its words say")]
    ShortestPath,
    /// M116, and a turn at feed.
    #[error("F counts millimetres along the turn of a rotary axis, at a radius that the text does not state")]
    RotaryFeed,
    /// A word that changes the block's end, its course or other axes in a way that is not followed: `AP=`, `FB=`,
    /// `POS[X]=`.
    #[error("a word of the block changes the motion in a way that the service does not follow")]
    ControlWord,
    /// Two codes of the motion group in one block, or two codes that use the same words.
    #[error("two codes of the block use the same words")]
    ConflictingCodes,
}

impl Unfollowable {
    /// What to change so that the motion can be followed; `None` if the reason says it.
    #[must_use]
    pub const fn cure(self) -> Option<&'static str> {
        Some(match self {
            Self::ModeUnknown { .. }
            | Self::Expression { .. }
            | Self::RepeatedAddress { .. }
            | Self::KinematicsSwitched
            | Self::TurnToPlane
            | Self::StateLost => return None,
            Self::NoSuchAxis { .. } => {
                "Choose the machine that has this axis, or post the program without the word"
            }
            Self::BlockDelete => "Remove the `/` or the block",
            Self::CutterCompensation => {
                "Post the path of the cutter without radius compensation; operations that only read follow G41 and G42 with D if `radius_offsets_mm` states the radius, and if it is certain how the control runs the corners and the ways in and out"
            }
            Self::TiltedPlane => {
                "Write the plane in a form that is followed, with X Y Z words alone in it, and state `plane_solution` in the profile; or post the program without a tilted plane"
            }
            Self::PlaneSolution => {
                "State `plane_solution` with its axis in the profile, and the rotary positions before the plane; if both are stated, the travels of the rotary axes do not reach the plane"
            }
            Self::Transformation => "Post the program in plain workpiece coordinates",
            Self::OtherTransformation => {
                "Describe the transformation of this program in the machine's profile, and select it by TRAORI"
            }
            Self::ToolVector => {
                "Post rotary words, or check whether the rotary axes reach this vector within their travel"
            }
            Self::Corner => "Post the corner as lines or arcs",
            Self::MachineCoordinates => {
                "Post the motion in workpiece coordinates; operations that only read also follow it if the profile states `machine_coordinates`"
            }
            Self::OffsetHere => "Select the work offset by G15 in a block before",
            Self::CannedCycle => "End the cycle before this motion, or post the motions of the cycle",
            Self::Spline => "Post it as lines",
            Self::SpecialMotion => "Post it as plain lines; put a thread into a program of its own",
            Self::Probing => "Probe in a program of its own",
            Self::Reference => {
                "Post the place with axis words; operations that only read also follow it if the profile states it in `machine_coordinates`"
            }
            Self::Call => "Replace the call by the blocks that it runs",
            Self::Return => "Post the program without subprograms",
            Self::UnknownCode => "Remove the code if the machine does not need it",
            Self::ModalCall => "End the macro before this motion, or replace it by the blocks that it runs",
            Self::IncrementalContact => "Post U V W with absolute values",
            Self::RelativeExtruder => "Post E with absolute values",
            Self::ContourElement => "Post the motion with its end point, as lines or arcs",
            Self::OnCircle => {
                "State a CIRCLE before each point that ends an arc, or write arcs as points without CIRCLE (Creo: CIRC_INTERPOLATION POINTS_ONLY)"
            }
            Self::CircleUnread => {
                "State CIRCLE/x,y,z,i,j,k,r with one end at most one turn away, or write the course as points"
            }
            Self::CalledText => "Replace every call by the blocks that it runs",
            Self::ShortestPath => "Switch the shorter way off (M127) before this motion",
            Self::RotaryFeed => "Switch this feed off (M117) before this motion",
            Self::ControlWord | Self::VectorWord { .. } => "Post the motion without this word",
            Self::ConflictingCodes => "Write each code in a block of its own",
        })
    }
}
