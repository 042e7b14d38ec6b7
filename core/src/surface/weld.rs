//! Equal corners become one vertex.

use std::collections::BTreeMap;

use super::MeshFault;
use super::asking::{ASK_EVERY, Asking};
use crate::geometry::Vec3;

/// Vertices by their exact coordinates.
///
/// An open table whose slots hold vertex numbers. A corner that does not find its slot within [`MAX_PROBES`] slots
/// goes to an ordered map, so that a file made to collide costs a logarithm and not a walk over everything.
pub(super) struct Weld {
    vertices: Vec<Vec3>,
    slots: Vec<u32>,
    overflow: BTreeMap<[u64; 3], u32>,
}

const EMPTY: u32 = u32::MAX;
const MAX_PROBES: usize = 64;
const FIRST_SLOTS: usize = 1 << 12;
/// Slots filled between two questions: 4 MiB of memory.
const MAX_FILL: usize = 1 << 20;

impl Weld {
    pub(super) fn new() -> Self {
        Self { vertices: Vec::new(), slots: vec![EMPTY; FIRST_SLOTS], overflow: BTreeMap::new() }
    }

    /// The number of the vertex at this position; a new number if it is the first there. Coordinates must be
    /// finite.
    ///
    /// # Errors
    /// The caller no longer waits.
    pub(super) fn vertex(&mut self, place_mm: Vec3, asking: &mut Asking<'_>) -> Result<u32, MeshFault> {
        // −0 is 0
        let place_mm = place_mm.map(|x| x + 0.0);
        let key = key(place_mm);
        match self.find(key) {
            Found::Vertex(number) => Ok(number),
            found => {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "three for each of fewer than 2²⁴ facets"
                )]
                let number = self.vertices.len() as u32;
                self.vertices.push(place_mm);
                self.put(key, number, &found);
                if self.vertices.len() * 4 > self.slots.len() * 3 {
                    self.grow(asking)?;
                }
                Ok(number)
            }
        }
    }

    /// The vertices \[mm\].
    pub(super) fn into_vertices(self) -> Vec<Vec3> {
        self.vertices
    }

    fn find(&self, key: [u64; 3]) -> Found {
        let mask = self.slots.len() - 1;
        let start = hash(key);
        for step in 0..MAX_PROBES {
            let slot = (start + step) & mask;
            let number = self.slots.get(slot).copied().unwrap_or(EMPTY);
            let Some(vertex) = self.vertices.get(number as usize) else { return Found::Slot(slot) };
            if self::key(*vertex) == key {
                return Found::Vertex(number);
            }
        }
        self.overflow.get(&key).map_or(Found::NoSlot, |number| Found::Vertex(*number))
    }

    fn put(&mut self, key: [u64; 3], number: u32, found: &Found) {
        match found {
            Found::Slot(slot) => {
                if let Some(place) = self.slots.get_mut(*slot) {
                    *place = number;
                }
            }
            Found::NoSlot | Found::Vertex(_) => {
                self.overflow.insert(key, number);
            }
        }
    }

    fn grow(&mut self, asking: &mut Asking<'_>) -> Result<(), MeshFault> {
        let slots = self.slots.len() * 2;
        self.slots = Vec::new();
        self.slots.reserve_exact(slots);
        while self.slots.len() < slots {
            asking.after(ASK_EVERY)?;
            self.slots.resize((self.slots.len() + MAX_FILL).min(slots), EMPTY);
        }
        self.overflow.clear();
        for number in 0..self.vertices.len() {
            asking.after(1)?;
            let Some(vertex) = self.vertices.get(number) else { break };
            let key = key(*vertex);
            // All vertices differ, so this one is in no slot yet.
            let found = self.find(key);
            #[expect(clippy::cast_possible_truncation, reason = "three for each of fewer than 2²⁴ facets")]
            self.put(key, number as u32, &found);
        }
        Ok(())
    }
}

enum Found {
    Vertex(u32),
    Slot(usize),
    NoSlot,
}

fn key(place_mm: Vec3) -> [u64; 3] {
    [place_mm.x.to_bits(), place_mm.y.to_bits(), place_mm.z.to_bits()]
}

/// Three numbers folded by wide products.
#[expect(clippy::cast_possible_truncation, reason = "the lower half is taken, then the bits in use")]
fn hash(key: [u64; 3]) -> usize {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for word in key {
        let product = u128::from(state ^ word) * 0xa076_1d64_78bd_642f_u128;
        state = (product >> 64) as u64 ^ product as u64;
    }
    state as usize
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;

    fn go_on() -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    #[test]
    fn equal_places_are_one_vertex_and_others_are_not() {
        let mut weld = Weld::new();
        let place = |k: u32| Vec3::new(f64::from(k % 100) * 0.1, f64::from(k / 100) * 0.1, -0.0);
        for turn in 0..3 {
            for k in 0..40_000 {
                let mut place = place(k);
                if turn == 1 {
                    place.z = 0.0;
                }
                assert_eq!(weld.vertex(place, &mut Asking::new(&go_on)).unwrap(), k);
            }
        }
        assert_eq!(weld.into_vertices().len(), 40_000);
    }

    #[test]
    fn a_crowded_table_still_finds_everything() {
        let mut weld = Weld::new();
        let places: Vec<Vec3> = (0..3000).map(|k| Vec3::new(f64::from(k), 1.0, 2.0)).collect();
        // Every slot except the last ones is taken by other vertices, so that hardly any slot is free.
        weld.vertices = (0..4000).map(|k| Vec3::new(0.5, f64::from(k), 0.25)).collect();
        weld.slots = (0..4000).chain(std::iter::repeat_n(EMPTY, 96)).collect();
        let numbers: Vec<u32> = places
            .iter()
            .map(|place| match weld.find(key(*place)) {
                Found::Vertex(number) => number,
                found => {
                    let number = u32::try_from(weld.vertices.len()).unwrap();
                    weld.vertices.push(*place);
                    weld.put(key(*place), number, &found);
                    number
                }
            })
            .collect();
        assert!(weld.overflow.len() > 2000, "{}", weld.overflow.len());
        for (place, number) in places.iter().zip(&numbers) {
            assert_eq!(weld.vertex(*place, &mut Asking::new(&go_on)).unwrap(), *number);
        }
        weld.grow(&mut Asking::new(&go_on)).unwrap();
        for (place, number) in places.iter().zip(&numbers) {
            assert_eq!(weld.vertex(*place, &mut Asking::new(&go_on)).unwrap(), *number);
        }
    }
}
