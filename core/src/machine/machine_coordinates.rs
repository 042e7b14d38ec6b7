//! Where the control's machine coordinates count from, as the machine's owner states it.

/// Most reference positions of a machine: those of G28, G30 P2, P3 and P4.
pub const MAX_REFERENCE_POSITIONS: usize = 4;

/// The machine coordinates of one machine's control: those of G53, G153, SUPA and M91.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MachineCoordinates {
    /// The place of the gauge point in M, with every rotary axis at zero, when X Y Z stand at zero in machine
    /// coordinates \[mm\].
    pub zero_mm: [f64; 3],
    /// Whether the tool length that is in force counts in machine coordinates, so that they place the tip. `None` if
    /// this is not known.
    pub length_counts: Option<bool>,
    /// The reference positions in machine coordinates, first that of G28, then those of G30 P2, P3 and P4: X Y Z
    /// \[mm\], then the rotary axes in the profile's order \[deg\]. `None` for an axis whose position is not stated.
    pub references: Vec<[Option<f64>; 5]>,
    /// The offset that the control adds to all work offsets that a program writes \[mm\]. `None` if it is not known.
    pub external_mm: Option<[f64; 3]>,
    /// Z in machine coordinates at which a retraction along the tool to the end of the travel ends \[mm\]. `None` if it is
    /// not known.
    pub retract_z_mm: Option<f64>,
}
