//! Statement words: words in letters that some controls have instead of ISO codes.

use crate::listed::listed;

listed! {
    /// A statement word of some dialect. Its meaning for the path is in `motion`.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Keyword {
        // --- Siemens
        /// `TRAORI`: tool-centre-point control on.
        Traori,
        /// `TRAORI(2)`, `TRAORI(1,0,1,1)`: a further transformation of the control, or one with another basic
        /// orientation.
        OtherTraori,
        /// `TRAFOOF`: transformations off.
        Trafoof,
        /// `SUPA`: machine coordinates with offsets suppressed, in this block only.
        Supa,
        /// `TRANSMIT`, `TRACYL` and similar words: a transformation that is not for five axes.
        OtherTransformation,
        /// `TRANS`: the programmable offset. It replaces every programmable frame.
        Trans,
        /// `ATRANS`: the same, added.
        Atrans,
        /// `ROT`: a rotation. It replaces every programmable frame.
        Rot,
        /// `AROT`: a rotation, added.
        Arot,
        /// `SCALE`.
        Scale,
        /// `ASCALE`.
        Ascale,
        /// `MIRROR`.
        Mirror,
        /// `AMIRROR`.
        Amirror,
        /// `RPL=`: the angle of a rotation in the plane.
        PlaneAngle,
        /// `TOROT`, `TOFRAME`: a frame along the tool.
        ToolFrame,
        /// `TOROTOF`.
        ToolFrameOff,
        /// `PAROT`: a frame along the part.
        PartFrame,
        /// `PAROTOF`.
        PartFrameOff,
        /// `CYCLE800(…)`: swivels the plane.
        Swivel,
        /// `CYCLE800()`.
        SwivelOff,
        /// `PTP`: from point to point under a transformation.
        PointToPoint,
        /// `CP`.
        PointToPointOff,
        /// `ORIPLANE`, `ORICONCW`, `ORIPATH`, …: the tool axis has a course of its own.
        OrientationPath,
        /// `ORIAXES`, `ORIVECT`.
        OrientationAxes,
        /// `ORIMKS`: tool vectors are in machine coordinates.
        OrientationMachine,
        /// `ORIWKS`: tool vectors are in workpiece coordinates.
        OrientationWorkpiece,
        /// `A2=`, `A4=`, `LEAD=`, …: an orientation in a form that is not followed.
        OrientationWord,
        /// `DIAMON`.
        Diameter,
        /// `DIAMOF`.
        DiameterOff,
        /// `BSPLINE`, `POLY` and similar words, and circles that are given by points other than the centre (`CIP`,
        /// `CT`).
        Spline,
        /// `FB=`: the motion ends at its stated place but takes another time.
        OtherCourse,
        /// `TURN=`: full circles that an arc makes in addition to the path to its end. The P word after it is their
        /// number.
        Turns,
        /// `CIRCLE/` of cutter location data. If it is read, its words are I J K the centre, P Q S the axis, R the radius
        /// if it is stated, and H the number of turns (`TIMES`).
        Circle,
        /// A standard cycle, executed once.
        Cycle,
        /// The block states a cycle that makes one hole at a place, and has its parameters as words. P is the number of
        /// the cycle, Q the coordinate of the surface, K the clearance above it, S and L the feeds down and up. In
        /// Sinumerik programs R is the retract plane, I the coordinate of the depth, J the depth below the surface, and
        /// H names the plane (1 to 3 for G17 to G19). In conversational programs J is the depth from the surface,
        /// negative downwards, and R the second clearance.
        Hole,
        /// `MCALL CYCLE81(…)`: a standard cycle at every motion.
        ModalCycle,
        /// `MCALL NAME(…)`: another program at every motion.
        ModalCall,
        /// `MCALL` alone, `EXECUTE`.
        ModalCallEnd,
        /// `CONTPRON`: the motions after it are put into a table.
        ContourTable,
        /// `MEAS=`: the motion ends where the probe triggers.
        Probing,
        /// `AP=`, `RP=`, `AR=`: angles state the end.
        PolarEnd,
        /// `X1=`, `AX[1]=`, `POS[X]=`, or a name that may be an axis of the machine.
        MachineAxis,
        /// A name that is not a variable of the program, and not a known axis.
        ForeignAxis,
        /// A name that is assigned. The constants tell whether it is a variable.
        Named,
        /// An assignment of a variable.
        Assigned,
        /// `DEF …`.
        Declaration,
        /// `PO[X]=`, `FLIN`: a word that changes its block in a way that is not followed.
        BlockWord,
        /// `TOFFL=`, `TCARR=`: another tool length.
        ToolOffset,
        /// `RNDM=2`: the control rounds every corner.
        CornerRounding,
        /// `RNDM=0`.
        CornerRoundingOff,
        /// `PRESETON`: gives axes other positions.
        AxisPreset,
        /// A datum preset of a conversational program.
        Preset,
        /// A statement with an unknown meaning for the path.
        UnknownStatement,
        /// `REPOSA` and similar words.
        Reposition,
        // --- Heidenhain
        /// `L`: a straight line.
        L,
        /// `LN`: a straight line with a contact normal or a tool axis.
        Ln,
        /// `C`: an arc about the pole, or a full circle.
        ArcAboutCentre,
        /// `CR`: an arc with a stated radius.
        ArcOfRadius,
        /// `CT`: an arc that continues from the end of the element before.
        TangentArc,
        /// `CC`: the pole; no motion.
        CircleCentre,
        /// `LP`, `CP`, `CTP`, `RND`, `CHF`, `APPR`, `DEP`, free contours: the control computes where the motion goes.
        ContourElement,
        /// `DR+`, `DR-`: the sense of an arc.
        Sense,
        /// A rounding or a chamfer cuts the end of this motion, or the next motion continues in its direction.
        CornerFollows,
        /// `FMAX`: at rapid traverse, in this block.
        Fmax,
        /// `M140 MB MAX`: back along the tool to the end of the travel, at rapid traverse.
        RetractToLimit,
        /// The same with a feed.
        RetractToLimitAtFeed,
        /// `FAUTO`, `FU`, `FZ`, and feeds in other units: the feed is not stated as a path feed.
        FeedElsewhere,
        /// `R0`, `CUTCOM/OFF`: no radius compensation.
        R0,
        /// `RL`, `RR`, `CUTCOM/…`: radius compensation.
        RadiusCompensation,
        /// `BEGIN PGM … MM`, `UNITS/MM`.
        BeginMm,
        /// `BEGIN PGM … INCH`, `UNITS/INCHES`.
        BeginInch,
        /// `END PGM`, `FINI`.
        EndPgm,
        /// `TOOL CALL` of a tool, `LOADTL/`.
        ToolCall,
        /// A tool axis other than Z.
        OtherToolAxis,
        /// Cycle 7, `TRANS DATUM AXIS`: the datum along the named axes.
        DatumShift,
        /// `TRANS DATUM RESET`: no datum shift.
        DatumReset,
        /// A datum shift from a table.
        DatumTable,
        /// `PLANE …` except RESET, cycle 19.
        TiltOn,
        /// `PLANE RESET`, cycle 19 with angles of 0 or without angles.
        TiltOff,
        /// Cycle 10.
        RotationOn,
        /// Cycle 10 with an angle of 0.
        RotationOff,
        /// Cycle 8 with axes.
        MirrorOn,
        /// Cycle 8 without axes.
        MirrorOff,
        /// Cycle 11.
        ScalingOn,
        /// Cycle 11 with factor 1.
        ScalingOff,
        /// Cycle 26: each axis has its own scale.
        AxisScaling,
        /// `FUNCTION TCPM F TCP AXIS POS`.
        TcpmOn,
        /// `FUNCTION RESET TCPM`.
        TcpmOff,
        /// `FUNCTION TCPM` with other settings.
        TcpmOther,
        /// `LBL 5`
        Label,
        /// `LBL 0`: the end of a section that can be called.
        LabelEnd,
        /// `CALL LBL 5`
        CallLabel,
        /// `CALL LBL 5 REP 2`
        RepeatLabel,
        /// `CYCL CALL`, and cycles that act at their own place.
        CycleCall,
        /// `CYCL CALL` alone: the defined cycle runs at the present position.
        CycleCallHere,
        /// `CYCL DEF` of a cycle that waits for its call and is not read.
        OtherCycle,
        /// `TCH PROBE`
        Probe,
        /// A statement that changes nothing on which the path depends.
        Statement,
        // --- APT
        /// `GOTO/`: a straight motion to a point; after `CIRCLE/`, an arc.
        Goto,
        /// `FROM/`: the position of the tool.
        From,
        /// `RAPID`: the next motion is at rapid traverse.
        Rapid,
        /// `FEDRAT/`
        Fedrat,
        /// `MMPM`
        MmPerMinute,
        /// `IPM`
        InchPerMinute,
        /// `PERMIN`, `UPM`: in the unit of the program.
        UnitPerMinute,
        /// `MMPR`
        MmPerRevolution,
        /// `IPR`
        InchPerRevolution,
        /// `PERREV`, `UPR`: in the unit of the program.
        UnitPerRevolution,
        /// `CYCLE/…`: the points after it belong to a cycle. A drilling cycle that is read has words: R the height above a
        /// point from which it feeds, D the depth below it, Q the height to which it retracts, P and K the first and the
        /// further pecks, S the feed, and H the number of the feed's unit as a keyword.
        CycleOn,
        /// `CYCLE/OFF`
        CycleOff,
        /// `CUTTER/`: the shape of the tool. Equal shapes have equal P words.
        Cutter,
        /// `MULTAX/ON`
        MultaxOn,
        /// `MULTAX/OFF`
        MultaxOff,
        /// `TLAXIS/`: the tool axis of points with three values.
        ToolAxis,
        /// `CSYS/`, `MSYS/`: the coordinate system of a set-up.
        CoordinateSystem,
        /// `TRNTYP/WORLD,0,0,0`: the points count in one system, whatever system a set-up states.
        WorldPoints,
        /// `TRACUT/`, `ROTABL/` with an angle and others: the points after it are moved, or count in another way.
        PointsMoved,
        /// `GOHOME`
        GoHome,
        /// `GOFWD/`, `RETRCT` and others: a motion whose end is not stated.
        SurfaceMotion,
        /// A word for the post-processor that does not move the points.
        PostWord,
    }
}

impl Keyword {
    /// The keyword's number, which is the value of its words.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// Whether it is an assignment to a name, whatever the name is.
    #[must_use]
    pub const fn is_assignment(self) -> bool {
        matches!(self, Self::Named | Self::Assigned | Self::MachineAxis | Self::ForeignAxis)
    }

    /// The keyword with this number.
    #[must_use]
    pub fn of_number(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_keywords_belong_together() {
        for (number, keyword) in (0..).zip(Keyword::ALL) {
            assert_eq!(keyword.number(), number);
            assert_eq!(Keyword::of_number(number), Some(keyword));
        }
        assert_eq!(Keyword::of_number(u16::MAX), None);
    }
}
