//! The coordinates of a tilted working plane.

use super::Turn;

/// The frame of a working plane in the workpiece: where its zero is, and in which directions its axes point. Its
/// third axis is the normal of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneFrame {
    /// The directions of its axes in W.
    turn: Turn,
    /// Its zero in W \[mm\].
    zero_mm: [f64; 3],
}

impl PlaneFrame {
    /// A frame with this zero in W \[mm\], whose axes are turned in this way.
    #[must_use]
    pub const fn new(zero_mm: [f64; 3], turn: Turn) -> Self {
        Self { turn, zero_mm }
    }

    /// The frame whose zero is at this place of this frame \[mm\], with the same directions.
    #[must_use]
    pub fn shifted(self, by_mm: [f64; 3]) -> Self {
        Self { zero_mm: self.to_workpiece(by_mm), ..self }
    }

    /// A place of the plane \[mm\] in W.
    #[must_use]
    pub fn to_workpiece(self, plane_mm: [f64; 3]) -> [f64; 3] {
        let turned = self.turn.of(plane_mm);
        std::array::from_fn(|k| self.zero_mm[k] + turned[k])
    }

    /// A place of W \[mm\] in the plane.
    #[must_use]
    pub fn from_workpiece(self, workpiece_mm: [f64; 3]) -> [f64; 3] {
        self.turn.back(std::array::from_fn(|k| workpiece_mm[k] - self.zero_mm[k]))
    }

    /// The direction in which the plane faces, in W: the tool's axis when it stands on the plane.
    #[must_use]
    pub fn normal(self) -> [f64; 3] {
        self.turn.of([0.0, 0.0, 1.0])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|k| a[k] * b[k]).sum()
    }

    proptest! {
        /// Distances and hand are those of W, and the way back is the inverse, however the frame is turned.
        #[test]
        fn a_frame_is_orthonormal_and_right_handed(
            turns in prop::collection::vec((0_usize..3, -400.0_f64..400.0), 0..6),
            zero in prop::array::uniform3(-900.0_f64..900.0),
            by in prop::array::uniform3(-900.0_f64..900.0),
            at in prop::array::uniform3(-900.0_f64..900.0),
        ) {
            let turn = turns.iter().fold(Turn::NONE, |turn, (axis, deg)| turn.then_about(*axis, *deg));
            let frame = PlaneFrame::new(zero, turn).shifted(by);
            let origin = frame.to_workpiece([0.0; 3]);
            let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|axis| { let to = frame.to_workpiece(axis); std::array::from_fn(|k| to[k] - origin[k]) });
            for (a, b) in [(x, y), (y, z), (z, x)] {
                prop_assert!(dot(a, b).abs() < 1e-11 && (dot(a, a) - 1.0).abs() < 1e-11);
            }
            let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
            prop_assert!((dot(cross, z) - 1.0).abs() < 1e-11);
            prop_assert!((dot(frame.normal(), z) - 1.0).abs() < 1e-11);
            let back = frame.from_workpiece(frame.to_workpiece(at));
            prop_assert!((0..3).all(|k| (back[k] - at[k]).abs() < 1e-11 * 900.0));
        }

        /// A turn by its axes is that turn.
        #[test]
        fn axes_give_their_turn_back(
            turns in prop::collection::vec((0_usize..3, -400.0_f64..400.0), 0..6),
            lengths in prop::array::uniform2(0.01_f64..50.0),
            at in prop::array::uniform3(-9.0_f64..9.0),
        ) {
            let turn = turns.iter().fold(Turn::NONE, |turn, (axis, deg)| turn.then_about(*axis, *deg));
            let [x, z] = [turn.of([lengths[0], 0.0, 0.0]), turn.of([0.0, 0.0, lengths[1]])];
            let same = Turn::with_axes(x, z).unwrap();
            prop_assert!((0..3).all(|k| (same.of(at)[k] - turn.of(at)[k]).abs() < 1e-13 * 9.0));
            prop_assert!(Turn::with_axes(z, z).is_none() && Turn::with_axes([0.0; 3], z).is_none());
        }
    }
}
