//! What a statement says about a tilted working plane: `G68.2`, `PLANE SPATIAL`, `PLANE VECTOR`, `CYCLE800(…)`.

/// A tilted working plane as a statement of the program defines it, from the directions of the work offset. Only forms
/// that all controls of the dialect understand alike are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneStatement {
    /// The zero of the plane, in coordinates of the work offset.
    pub zero: [f64; 3],
    /// The directions of the plane.
    pub directions: PlaneDirections,
    /// Where the zero goes from there, along the axes of the plane.
    pub shift: [f64; 3],
    /// `zero` and `shift` count in the unit of the program. Otherwise their unit depends on settings of the control,
    /// unless the program counts in millimetres.
    pub counts_in_unit: bool,
    /// The statement replaces a plane that is active. Otherwise it needs the active one to end first.
    pub replaces: bool,
    /// How the rotary axes come to stand on the plane.
    pub turning: PlaneTurning,
    /// The sign that the statement asks of a rotary axis.
    pub side: Option<StatedSide>,
    /// What the statement says about an axis that does not change the direction of the tool.
    pub free_axis: Option<FreeAxisWord>,
}

/// The directions of a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlaneDirections {
    /// Turns one after the other \[deg\], each about an axis (0 X, 1 Y, 2 Z) of the directions turned before.
    Turns([(usize, f64); 3]),
    /// By the direction of the first axis and that of the normal.
    Axes {
        /// Along the first axis.
        x: [f64; 3],
        /// Along the normal.
        normal: [f64; 3],
    },
}

/// How the rotary axes come to stand on a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneTurning {
    /// The statement turns them.
    Here,
    /// A code of its own turns them: `G53.1`.
    ByCode,
    /// The program turns them, or this is not known.
    Elsewhere,
}

/// The sign that a statement asks of a rotary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StatedSide {
    /// Positive, or negative.
    pub positive: bool,
    /// The control takes the other position if this one is out of travel. Otherwise it stops.
    pub or_other: bool,
}

/// What a statement says about an axis that does not change the direction of the tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FreeAxisWord {
    /// `COORD ROT`: it does not turn.
    Stays,
    /// `TABLE ROT`: it turns, and the text alone does not say where to.
    Turns,
}

/// A number as plain digits with an optional sign and one point; `None` for anything else.
pub(in crate::program) fn plain_number(text: &[u8]) -> Option<f64> {
    let text = text.trim_ascii();
    let digits = text.strip_prefix(b"-").or_else(|| text.strip_prefix(b"+")).unwrap_or(text);
    let is_plain = digits.iter().any(u8::is_ascii_digit)
        && digits.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.')
        && digits.split(|byte| *byte == b'.').count() <= 2;
    let value: f64 = std::str::from_utf8(text).ok().filter(|_| is_plain)?.parse().ok()?;
    (value.abs() <= super::MAX_MAGNITUDE).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_numbers_are_read() {
        let rows: [(&[u8], Option<f64>); 12] = [
            (b" +270.000 ", Some(270.0)),
            (b"-.5", Some(-0.5)),
            (b"7.", Some(7.0)),
            (b"0", Some(0.0)),
            (b"", None),
            (b"-", None),
            (b".", None),
            (b"1.2.3", None),
            (b"1e3", None),
            (b"R1", None),
            (b"1+2", None),
            (b"99999999999999999999", None),
        ];
        for (text, value) in rows {
            assert_eq!(plain_number(text), value, "{text:?}");
        }
    }
}
