//! The position of the control, as far as the text states it. `None` is an unknown value.

use super::sections::behind;
use super::{AxisWords, Decimals};

/// The last values of the words that name places, and the digits with which they were written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Position {
    /// X Y Z \[mm\] and the machine's two rotary axes \[deg\].
    pub(super) axes: [Option<f64>; 5],
    /// The letter among A B C that the machine lacks \[deg\].
    pub(super) foreign_deg: Option<f64>,
    /// The tool axis as a vector, if it is programmed as one.
    pub(super) tool_axis: [Option<f64>; 3],
    /// U V W \[mm\].
    pub(super) contact_mm: [Option<f64>; 3],
    /// nx ny nz.
    pub(super) normal: [Option<f64>; 3],
    /// E, program units.
    pub(super) extruder: Option<f64>,
    /// Decimals of X Y Z and of the two rotary axes.
    pub(super) decimals: [u8; 5],
    pub(super) contact_decimals: [u8; 3],
    pub(super) extra_decimals: u8,
}

impl Position {
    pub(super) const UNKNOWN: Self = Self {
        axes: [None; 5],
        foreign_deg: None,
        tool_axis: [None; 3],
        contact_mm: [None; 3],
        normal: [None; 3],
        extruder: None,
        decimals: [0; 5],
        contact_decimals: [0; 3],
        extra_decimals: 0,
    };

    /// All five axes, if known.
    #[inline]
    pub(super) fn axis_words(&self) -> Option<AxisWords> {
        let [Some(x), Some(y), Some(z), Some(first), Some(second)] = self.axes else { return None };
        Some(AxisWords { linear_mm: [x, y, z], rotary_deg: [first, second] })
    }

    /// X Y Z, if known.
    #[inline]
    pub(super) fn linear_mm(&self) -> Option<[f64; 3]> {
        let [Some(x), Some(y), Some(z), ..] = self.axes else { return None };
        Some([x, y, z])
    }

    /// The tool axis, if it is known as a vector.
    #[inline]
    pub(super) fn tool_axis(&self) -> Option<[f64; 3]> {
        let [Some(i), Some(j), Some(k)] = self.tool_axis else { return None };
        Some([i, j, k])
    }

    pub(super) fn forget_linear(&mut self) {
        self.axes[..3].fill(None);
        self.contact_mm = [None; 3];
    }

    pub(super) fn forget_rotary(&mut self) {
        self.forget_rotary_words();
        self.forget_tool_axis();
    }

    /// Forgets the rotary axes. A vector still states the direction of the tool.
    #[inline]
    pub(super) fn forget_rotary_words(&mut self) {
        self.axes[3..].fill(None);
        self.foreign_deg = None;
    }

    #[inline]
    pub(super) fn forget_tool_axis(&mut self) {
        self.tool_axis = [None; 3];
    }

    pub(super) fn forget_axes(&mut self) {
        self.axes = [None; 5];
        self.foreign_deg = None;
        self.tool_axis = [None; 3];
        self.contact_mm = [None; 3];
        self.normal = [None; 3];
    }

    pub(super) fn forget_all(&mut self) {
        self.forget_axes();
        self.extruder = None;
    }

    /// The position of the control after a section of the program that is called here. It follows from the section's
    /// effect on the program's state and on another state.
    pub(super) fn behind(&self, program: [&Self; 2], stranger: [&Self; 2]) -> Self {
        fn each<const N: usize>(
            caller: [Option<f64>; N],
            program: [[Option<f64>; N]; 2],
            stranger: [[Option<f64>; N]; 2],
        ) -> [Option<f64>; N] {
            std::array::from_fn(|i| behind(caller[i], program.map(|at| at[i]), stranger.map(|at| at[i])))
        }
        Self {
            axes: each(self.axes, program.map(|at| at.axes), stranger.map(|at| at.axes)),
            foreign_deg: each(
                [self.foreign_deg],
                program.map(|at| [at.foreign_deg]),
                stranger.map(|at| [at.foreign_deg]),
            )[0],
            tool_axis: each(self.tool_axis, program.map(|at| at.tool_axis), stranger.map(|at| at.tool_axis)),
            contact_mm: [None; 3],
            normal: [None; 3],
            extruder: None,
            ..*program[1]
        }
    }

    /// The values that are the same whether a block was executed or skipped.
    pub(super) fn common(&self, skipped: &Self) -> Self {
        fn same<const N: usize>(a: [Option<f64>; N], b: [Option<f64>; N]) -> [Option<f64>; N] {
            std::array::from_fn(|i| if a[i] == b[i] { a[i] } else { None })
        }
        Self {
            axes: same(self.axes, skipped.axes),
            foreign_deg: same([self.foreign_deg], [skipped.foreign_deg])[0],
            tool_axis: same(self.tool_axis, skipped.tool_axis),
            contact_mm: same(self.contact_mm, skipped.contact_mm),
            normal: same(self.normal, skipped.normal),
            extruder: same([self.extruder], [skipped.extruder])[0],
            ..*self
        }
    }

    /// Digits of the present values.
    #[inline]
    pub(super) fn modal_decimals(&self) -> Decimals {
        let [x, y, z, first, second] = self.decimals;
        let [u, v, w] = self.contact_decimals;
        Decimals {
            linear: x.max(y).max(z),
            rotary: first.max(second),
            contact: u.max(v).max(w),
            extra: self.extra_decimals,
        }
    }
}
