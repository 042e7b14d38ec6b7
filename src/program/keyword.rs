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
    /// `BSPLINE`, `POLY` and their kin.
    Spline,
    /// `CIP`, `CT`: a circle.
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
    /// `FB=`, `PO[X]=`, `FLIN`: a word that changes its block in a way that is not followed.
    BlockWord,
    /// `TOFFL=`, `TCARR=`: another tool length.
    ToolOffset,
    /// `RNDM=2`: every corner is rounded.
    CornerRounding,
    /// `RNDM=0`.
    CornerRoundingOff,
    /// `PRESETON`: axes are given other positions.
    Preset,
    /// `REPOSA` and its kin.
    Reposition,
    /// A statement whose meaning for the path is not known.
    UnknownStatement,
    // --- Heidenhain
    /// `L`: a straight line.
    L,
    /// `FMAX`: at rapid traverse, in this block.
    Fmax,
    // --- APT
    /// `GOTO/`: a straight motion to a point.
    Goto,
    /// `RAPID`: the next motion is one at rapid traverse.
    Rapid,
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
