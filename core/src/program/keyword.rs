//! Statement words: what controls write in letters where ISO has a code.

macro_rules! keywords {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        /// A statement word of some dialect. Its meaning for the path is in `motion`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Keyword {
            $($(#[$doc])* $name,)*
        }

        impl Keyword {
            /// All of them, by number.
            pub const ALL: &[Self] = &[$(Self::$name),*];
        }
    };
}

keywords! {
    // --- Siemens
    /// `TRAORI`: tool-centre-point control on.
    Traori,
    /// `TRAORI(2)`, `TRAORI(1,0,1,1)`: a further transformation of the control, or one with another orientation.
    OtherTraori,
    /// `TRAFOOF`: transformations off.
    Trafoof,
    /// `SUPA`: machine coordinates, offsets suppressed, in this block.
    Supa,
    /// `TRANSMIT`, `TRACYL` and their kin: another transformation than for five axes.
    OtherTransformation,
    /// `TRANS`: the programmable offset, in place of every programmable frame.
    Trans,
    /// `ATRANS`: the same, added.
    Atrans,
    /// `ROT`: a rotation in place of every programmable frame.
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
    /// `ORIPLANE`, `ORICONCW`, `ORIPATH`, …: the tool axis takes a course of its own.
    OrientationPath,
    /// `ORIAXES`, `ORIVECT`.
    OrientationAxes,
    /// `ORIMKS`: tool vectors are meant in the machine.
    OrientationMachine,
    /// `ORIWKS`: tool vectors are meant in the workpiece.
    OrientationWorkpiece,
    /// `A2=`, `A4=`, `LEAD=`, …: an orientation in a form that is not followed.
    OrientationWord,
    /// `DIAMON`.
    Diameter,
    /// `DIAMOF`.
    DiameterOff,
    /// `BSPLINE`, `POLY` and their kin, and circles by other points than their centre (`CIP`, `CT`).
    Spline,
    /// `FB=`: the motion ends where it says, but takes another time there.
    OtherCourse,
    /// `TURN=`: full circles that an arc runs beside the way to its end; their number is the P word behind it.
    Turns,
    /// `CIRCLE/`: of cutter location data.
    Circle,
    /// A standard cycle, executed once.
    Cycle,
    /// `MCALL CYCLE81(…)`: a standard cycle at every motion.
    ModalCycle,
    /// `MCALL NAME(…)`: another program at every motion.
    ModalCall,
    /// `MCALL` alone, `EXECUTE`.
    ModalCallEnd,
    /// `CONTPRON`: motions that follow are put into a table.
    ContourTable,
    /// `MEAS=`: ends where the probe says.
    Probing,
    /// `AP=`, `RP=`, `AR=`: the end is given by angles.
    PolarEnd,
    /// `X1=`, `AX[1]=`, `POS[X]=`, or a name that may be an axis of the machine.
    MachineAxis,
    /// A name that is no variable of the program, and no axis that is known.
    ForeignAxis,
    /// A name that is assigned; whether it is a variable, the constants tell.
    Named,
    /// An assignment of a variable.
    Assigned,
    /// `DEF …`.
    Declaration,
    /// `PO[X]=`, `FLIN`: a word that changes its block in a way that is not followed.
    BlockWord,
    /// `TOFFL=`, `TCARR=`: another tool length.
    ToolOffset,
    /// `RNDM=2`: every corner is rounded.
    CornerRounding,
    /// `RNDM=0`.
    CornerRoundingOff,
    /// `PRESETON`: axes are given other positions.
    AxisPreset,
    /// A datum preset of a conversational program.
    Preset,
    /// A statement whose meaning for the path is not known.
    UnknownStatement,
    /// `REPOSA` and its kin.
    Reposition,
    // --- Heidenhain
    /// `L`: a straight line.
    L,
    /// `LN`: a straight line with a contact normal or a tool axis.
    Ln,
    /// `C`: an arc about the pole, or a full circle.
    ArcAboutCentre,
    /// `CR`: an arc of a radius.
    ArcOfRadius,
    /// `CT`: an arc that goes on where the element before ends.
    TangentArc,
    /// `CC`: the pole; no motion.
    CircleCentre,
    /// `LP`, `CP`, `CTP`, `RND`, `CHF`, `APPR`, `DEP`, free contours: the control works out where it goes.
    ContourElement,
    /// `DR+`, `DR-`: the sense of an arc.
    Sense,
    /// A rounding or a chamfer cuts the end of this motion, or what follows goes on in its direction.
    CornerFollows,
    /// `FMAX`: at rapid traverse, in this block.
    Fmax,
    /// `FAUTO`, `FU`, `FZ`, and feeds in other measures: the feed is not stated as a path feed.
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
    /// Cycle 7, `TRANS DATUM AXIS`: the datum along the axes named.
    DatumShift,
    /// `TRANS DATUM RESET`: no datum shift.
    DatumReset,
    /// A datum shift from a table.
    DatumTable,
    /// `PLANE …` but for RESET, cycle 19.
    TiltOn,
    /// `PLANE RESET`, cycle 19 with angles of 0 or none.
    TiltOff,
    /// Cycle 10.
    RotationOn,
    /// Cycle 10 by nothing.
    RotationOff,
    /// Cycle 8 with axes.
    MirrorOn,
    /// Cycle 8 without axes.
    MirrorOff,
    /// Cycle 11.
    ScalingOn,
    /// Cycle 11 with factor 1.
    ScalingOff,
    /// Cycle 26: axes scaled each for itself.
    AxisScaling,
    /// `FUNCTION TCPM F TCP AXIS POS`.
    TcpmOn,
    /// `FUNCTION RESET TCPM`.
    TcpmOff,
    /// `FUNCTION TCPM` in other senses.
    TcpmOther,
    /// `LBL 5`
    Label,
    /// `LBL 0`: the end of a section that is called.
    LabelEnd,
    /// `CALL LBL 5`
    CallLabel,
    /// `CALL LBL 5 REP 2`
    RepeatLabel,
    /// `CYCL CALL`, and cycles that act where they stand.
    CycleCall,
    /// `TCH PROBE`
    Probe,
    /// A statement that changes nothing the path depends on.
    Statement,
    // --- APT
    /// `GOTO/`: a straight motion to a point; an arc behind `CIRCLE/`.
    Goto,
    /// `FROM/`: where the tool is.
    From,
    /// `RAPID`: the next motion is one at rapid traverse.
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
    /// `CYCLE/…`: the points behind it are those of a cycle.
    CycleOn,
    /// `CYCLE/OFF`
    CycleOff,
    /// `CUTTER/`: the shape of the tool; equal shapes have equal P words.
    Cutter,
    /// `MULTAX/ON`
    MultaxOn,
    /// `MULTAX/OFF`
    MultaxOff,
    /// `TLAXIS/`: the tool axis of points with three values.
    ToolAxis,
    /// `CSYS/`, `MSYS/`: the coordinate system of a set-up.
    CoordinateSystem,
    /// `TRACUT/`, `ROTABL/` by an angle and others: the points behind it are moved, or count otherwise.
    PointsMoved,
    /// `GOHOME`
    GoHome,
    /// `GOFWD/`, `RETRCT` and others: a motion whose end is not stated.
    SurfaceMotion,
    /// A word for the post-processor that does not move the points.
    PostWord,
}

impl Keyword {
    /// Its number, the value of its words.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// Whether it stands for an assignment to a name, whatever the name is.
    #[must_use]
    pub const fn is_assignment(self) -> bool {
        matches!(self, Self::Named | Self::Assigned | Self::MachineAxis | Self::ForeignAxis)
    }

    /// The keyword of this number.
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
            assert_eq!(Keyword::of_number(number), Some(*keyword));
        }
        assert_eq!(Keyword::of_number(u16::MAX), None);
    }
}
