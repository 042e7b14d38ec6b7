//! The contact words of the parts of a divided block, interpolated between the words at the block's ends.

use super::checked::Checked;
use crate::contact::Node;
use crate::geometry::{GreatCircle, Vec3};
use crate::motion::{ContactWords, Interpolation, Motion};
use crate::program::{Address, round_to_decimals};

const POINT: [Address; 3] = [Address::U, Address::V, Address::W];
/// With fewer decimals a direction may be far off, or be no direction at all.
const NORMAL_DECIMALS: u8 = 4;
const NORMAL: [Address; 3] = [Address::NX, Address::NY, Address::NZ];

/// Contact words at both ends of the source block, if the program states them.
pub(super) enum ContactEnds {
    None,
    /// Stated at the end only. There is no start to interpolate from, so only the last part gets them.
    End([Address; 3], [f64; 3], f64),
    /// U V W: the target contact, by the definition of those words.
    Aimed,
    /// U V W of a program whose contacts come from another source: interpolated as written.
    Points([f64; 3], [f64; 3]),
    /// nx ny nz.
    Normals([f64; 3], [f64; 3]),
}

impl ContactEnds {
    /// The contact words at the ends of this block.
    pub(super) fn of(checked: &Checked<'_>, motion: &Motion) -> Self {
        match (checked.start_contact, motion.contact) {
            (Some(_), ContactWords::Point(_)) if checked.contact_from_words => Self::Aimed,
            (Some(a), ContactWords::Point(b)) => Self::Points(a, b),
            (Some(a), ContactWords::Normal(b)) => Self::Normals(a, b),
            (None, ContactWords::Point(b)) => Self::End(POINT, b, motion.mm_per_unit),
            (None, ContactWords::Normal(b)) => Self::End(NORMAL, b, 1.0),
            (_, ContactWords::None) => Self::None,
        }
    }

    /// The contact words of the part that ends at `node`, and the length of their unit \[mm\].
    pub(super) fn at(
        &self,
        checked: &Checked<'_>,
        motion: &Motion,
        node: &Node,
        last: bool,
    ) -> Option<([Address; 3], [f64; 3], f64)> {
        Some(match (self, motion.contact) {
            (Self::Aimed, ContactWords::Point(end)) => {
                let value = if last { end } else { aimed_words(checked, node) };
                (POINT, value, motion.mm_per_unit)
            }
            (Self::Normals(_, end), _) if last => (NORMAL, *end, 1.0),
            (Self::Points(a, b), _) => (POINT, between(a, b, node.fraction), motion.mm_per_unit),
            (Self::Normals(a, b), _) => (NORMAL, between_directions(a, b, node.fraction), 1.0),
            (Self::End(addresses, end, unit), _) if last => (*addresses, *end, *unit),
            (Self::None | Self::End(..) | Self::Aimed, _) => return None,
        })
    }
}

/// Decimals of the contact words of every part but the last.
pub(super) fn contact_decimals(addresses: [Address; 3], decimals: u8) -> u8 {
    if addresses == NORMAL { decimals.max(NORMAL_DECIMALS) } else { decimals }
}

/// The contact words of a node inside a divided block, as the control reads them. `None` if the part states no
/// contact.
pub(in crate::process) fn node_contact(
    checked: &Checked<'_>,
    motion: &Motion,
    node: &Node,
) -> Option<ContactWords> {
    let (addresses, values, unit) = ContactEnds::of(checked, motion).at(checked, motion, node, false)?;
    let decimals = contact_decimals(addresses, motion.decimals.contact);
    let read = values.map(|value| round_to_decimals(value / unit, decimals) * unit);
    Some(if addresses == NORMAL { ContactWords::Normal(read) } else { ContactWords::Point(read) })
}

/// U V W of the target contact: the linear words that would put the tip there (§2).
fn aimed_words(checked: &Checked<'_>, node: &Node) -> [f64; 3] {
    let block = &checked.block;
    match block.mode {
        Interpolation::Tcp => node.contact_mm.into(),
        Interpolation::Machine => {
            let rotary_rad = crate::contact::rotary_rad(block.machine, node.station.words.rotary_deg);
            block.kinematics.linear_mm(node.contact_mm, rotary_rad).into()
        }
    }
}

fn between(a: &[f64; 3], b: &[f64; 3], u: f64) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * u)
}

/// Normals move on their great circle, and their written lengths change linearly. If one end states no direction, the
/// contact there is not known. The result is then a zero vector.
fn between_directions(a: &[f64; 3], b: &[f64; 3], u: f64) -> [f64; 3] {
    let (from, to) = (Vec3::from(*a), Vec3::from(*b));
    let unit = |normal: Vec3| normal.try_normalize(f64::MIN_POSITIVE);
    let (Some(from_unit), Some(to_unit)) = (unit(from), unit(to)) else { return [0.0; 3] };
    let arc = GreatCircle::between(from_unit, to_unit, Vec3::z());
    (arc.at(u) * (from.norm() * (1.0 - u) + to.norm() * u)).into()
}
