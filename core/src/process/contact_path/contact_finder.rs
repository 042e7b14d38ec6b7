//! Where the cutter touches at a program point: from the point's own words, the part's surface, or the feed.

use super::parameters::CcParameters;
use crate::contact::{ContactFault, Effort, Station, Touch, contact_on_surface, stated_point_mm};
use crate::geometry::Vec3;
use crate::kinematics::Kinematics;
use crate::machine::{Machine, Tool};
use crate::motion::{ContactWords, Interpolation};
use crate::process::set_up::ContactSource;

/// Finds contacts from one source.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct ContactFinder<'a> {
    pub(in crate::process) machine: &'a Machine,
    pub(in crate::process) parameters: &'a CcParameters,
    /// Where contacts come from, `auto` resolved.
    pub(in crate::process) source: ContactSource,
}

impl ContactFinder<'_> {
    /// Whether contacts are assumed from the feed, motion by motion.
    #[inline]
    pub(in crate::process) fn assumes(&self) -> bool {
        self.source == ContactSource::FeedPlane
    }

    /// The contact of `tool` at a point that states `words`, or `None` if the source has no contact for this point. A
    /// contact assumed from the feed belongs to a motion, not to a point, so this function does not find it. The
    /// result is meaningless once the effort has ended.
    ///
    /// # Errors
    /// The stated contact is impossible.
    pub(in crate::process) fn find(
        &self,
        kinematics: &Kinematics,
        tool: &Tool,
        station: &Station,
        mode: Interpolation,
        words: ContactWords,
        effort: &mut Effort<'_>,
    ) -> Result<Option<Touch>, ContactFault> {
        let pose = &station.pose;
        effort.pass(1);
        match (self.source, words) {
            (ContactSource::Tip, _) => Ok(Some(Touch::TIP)),
            (ContactSource::Program, ContactWords::Point(point)) => {
                let rotary_deg = station.words.rotary_deg;
                let contact_mm = stated_point_mm(self.machine, kinematics, mode, point, rotary_deg);
                Touch::from_point(tool, pose, contact_mm).map(Some)
            }
            (ContactSource::Normals, ContactWords::Normal(normal)) => {
                Touch::from_normal(tool, pose, Vec3::from(normal)).map(Some)
            }
            (ContactSource::Surface, _) => {
                let part = self.parameters.part.as_ref();
                let found = part.and_then(|part| contact_on_surface(part, tool, pose, effort));
                found.map(|found| Touch::from_normal(tool, pose, found.normal)).transpose()
            }
            _ => Ok(None),
        }
    }
}

/// The contacts that follow from the feed at both ends of a motion. `None` if the feed leaves one of them open, or if
/// there is no feed. The caller then takes the tip for both.
pub(in crate::process) fn assumed(stations: [&Station; 2], feed: Option<Vec3>) -> Option<[Touch; 2]> {
    let feed = feed?;
    let [start, end] = stations.map(|station| Touch::from_feed(&station.pose, feed));
    Some([start?, end?])
}
