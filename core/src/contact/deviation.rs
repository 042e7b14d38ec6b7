//! The distance of the contact point from its line (P0 eq. (12)).

use super::{Segment, SourceBlock};
use crate::geometry::Vec3;
use crate::kinematics::ToolPose;

/// The line the contact point should follow during a block, in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLine {
    /// Contact at the start `c_s` \[mm\].
    pub start_mm: Vec3,
    /// `l = c_e − c_s` \[mm\].
    pub along_mm: Vec3,
    /// |l| \[mm\].
    pub length_mm: f64,
}

/// A line shorter than this is a point. The deviation is then the distance from that point \[mm\].
pub(super) const POINT_LENGTH_MM: f64 = 1e-9;

impl ContactLine {
    /// The line between two contact points.
    #[must_use]
    pub fn new(start_mm: Vec3, end_mm: Vec3) -> Self {
        let along_mm = end_mm - start_mm;
        Self { start_mm, along_mm, length_mm: along_mm.norm() }
    }

    /// The point of the line nearest to `point_mm` (the whole line, not only the stretch between its ends).
    #[must_use]
    pub fn foot_mm(&self, point_mm: Vec3) -> Vec3 {
        if self.length_mm < POINT_LENGTH_MM {
            return self.start_mm;
        }
        let direction = self.along_mm / self.length_mm;
        self.start_mm + direction * direction.dot(&(point_mm - self.start_mm))
    }

    /// The point at the fraction `u` of the line.
    #[must_use]
    pub fn at_mm(&self, u: f64) -> Vec3 {
        self.start_mm + self.along_mm * u
    }
}

/// The contact point's distance from its line at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// ε \[mm\], never negative.
    pub distance_mm: f64,
    /// The part of it along the surface normal \[mm\]: + excess, − gouge. 0 if no normal is known.
    pub along_normal_mm: f64,
}

impl SourceBlock<'_> {
    /// The deviation at `s` in [0, 1] of a segment of this block.
    #[must_use]
    pub fn deviation_at(&self, segment: &Segment, s: f64) -> Deviation {
        self.deviation_of(segment, s, &self.pose_at(segment, s))
    }

    /// [`Self::deviation_at`] at several places, to the same bits.
    #[must_use]
    pub fn deviations_at<const N: usize>(&self, segment: &Segment, places: &[f64; N]) -> [Deviation; N] {
        let poses = self.poses_at(segment, places);
        std::array::from_fn(|index| self.deviation_of(segment, places[index], &poses[index]))
    }

    /// The deviation of the tool's pose at `s`.
    #[inline]
    fn deviation_of(&self, segment: &Segment, s: f64, pose: &ToolPose) -> Deviation {
        let [from, to] = segment.fraction;
        let carried = self.carry.at(&self.tool, from + (to - from) * s, pose.axis);
        let contact_mm = pose.tip_mm + carried.offset_mm;
        let off_line = contact_mm - self.line.foot_mm(contact_mm);
        Deviation {
            distance_mm: off_line.norm(),
            along_normal_mm: carried.normal.map_or(0.0, |n| n.dot(&off_line)),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::contact::{Carry, CutterContact, Station};
    use crate::kinematics::{Kinematics, Setup};
    use crate::machine::{Machine, PRESETS, Tool};
    use crate::motion::{AxisWords, Interpolation};
    use crate::units::Length;

    /// Several places at once are a trick for speed. One place at a time is the plain version.
    #[test]
    fn several_places_give_the_bits_of_one() {
        let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(2.0)).unwrap();
        let places: [f64; 7] = [0.0, 0.11, 0.25, 0.5, 0.77, 0.999, 1.0];
        for preset in &PRESETS {
            let machine = Machine::new(preset.parts()).unwrap();
            let setup =
                Setup { work_offset_mm: Vec3::new(7.0, -4.0, 9.0), tool_length_mm: 80.0, ..Setup::default() };
            let kinematics = Arc::new(Kinematics::new(&machine, &setup));
            for mode in [Interpolation::Machine, Interpolation::Tcp] {
                let ends = [([1.0, 2.0, 3.0], [11.0, 20.0]), ([4.0, 0.5, 2.0], [17.0, 29.0])].map(
                    |(linear_mm, rotary_deg)| {
                        Station::new(&machine, &kinematics, mode, AxisWords { linear_mm, rotary_deg })
                    },
                );
                let axes = ends.map(|end| end.pose.axis);
                let contacts = axes.map(|axis| CutterContact::Normal {
                    direction: (axis + Vec3::new(0.3, 0.4, 0.1)).normalize(),
                    magnitude: 1.0,
                });
                let by_normal = Carry::between(&tool, contacts.each_ref(), axes);
                for carry in [Carry::Tip, by_normal] {
                    let block = SourceBlock::new(&machine, &kinematics, tool, mode, ends, carry);
                    let whole = block.whole();
                    let one_by_one = places.map(|s| block.deviation_at(&whole, s));
                    assert_eq!(block.deviations_at(&whole, &places), one_by_one, "{} {mode:?}", preset.id);
                }
            }
        }
    }
}
