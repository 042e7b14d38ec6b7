//! Poses that are checked while they are read and kept in columns. No list of documents is held beside them.

use std::fmt;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::decimal::number_at;
use super::{Fault, FaultList, Pose};
use crate::kinematics::PoseLanes;

/// Poses in the order in which they were read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseColumns {
    lanes: PoseLanes,
    /// All poses, faulty ones included.
    count: usize,
    faults: FaultList,
}

impl PoseColumns {
    /// Memory of one pose while the columns grow by doubling \[bytes\].
    pub const GROWING_BYTES: usize = 2 * size_of::<Pose>();

    /// No poses, with memory for a few.
    fn with_room_for_few() -> Self {
        const FEW: usize = 8;
        Self { lanes: PoseLanes::with_capacity(FEW), ..Self::default() }
    }

    /// The number of poses, faulty ones included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no pose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Adds a pose.
    #[inline]
    pub fn push(&mut self, pose: &Pose) {
        if let Some(pose) = pose.to_core(self.count, &mut self.faults) {
            self.lanes.push(pose);
        }
        self.count += 1;
    }

    /// How many poses are in memory: those that are not faulty and were not taken.
    #[must_use]
    pub fn held(&self) -> usize {
        self.lanes.len()
    }

    /// Takes the poses that are in memory, in their order, and leaves `memory` for the next ones. They still count, and
    /// the faults stay.
    pub fn take(&mut self, mut memory: PoseLanes) -> PoseLanes {
        memory.clear();
        std::mem::replace(&mut self.lanes, memory)
    }

    /// The poses with unit axes, except those that were taken.
    ///
    /// # Errors
    /// Every bad value, with its pointer.
    pub fn into_core(self) -> Result<PoseLanes, Vec<Fault>> {
        self.faults.into_result()?;
        Ok(self.lanes)
    }

    /// Reads the elements of a JSON array, from its first byte after `[` to its `]`, and returns the number of bytes
    /// up to and including that. `None` if anything is not as the service itself would write it; then serde reads
    /// the text, and says what is wrong if something is.
    pub(super) fn read_elements(text: &[u8]) -> Option<(Self, usize)> {
        let mut poses = Self::with_room_for_few();
        let mut rest = Rest { text, at: 0 };
        if rest.takes(b']') {
            return Some((poses, rest.at));
        }
        loop {
            let pose = rest.pose()?;
            poses.push(&pose);
            if rest.takes(b']') {
                return Some((poses, rest.at));
            }
            if !rest.takes(b',') {
                return None;
            }
        }
    }
}

/// The part of a JSON text that was not read yet.
struct Rest<'a> {
    text: &'a [u8],
    at: usize,
}

impl Rest<'_> {
    /// Takes blanks and then this byte, if it comes next.
    #[inline]
    fn takes(&mut self, wanted: u8) -> bool {
        while let Some(byte) = self.text.get(self.at) {
            if *byte == wanted {
                self.at += 1;
                return true;
            }
            if !matches!(byte, b' ' | b'\n' | b'\t' | b'\r') {
                return false;
            }
            self.at += 1;
        }
        false
    }

    /// A pose: an object with its six numbers in any order.
    #[inline]
    fn pose(&mut self) -> Option<Pose> {
        const NAMES: &[u8; 6] = b"xyzijk";
        if !self.takes(b'{') {
            return None;
        }
        let mut values = [f64::NAN; 6];
        for position in 0..NAMES.len() {
            if (position > 0 && !self.takes(b',')) || !self.takes(b'"') {
                return None;
            }
            let [name, b'"'] = *self.text.get(self.at..)?.first_chunk()? else { return None };
            self.at += 2;
            // Usually the names come in this order.
            let column = if NAMES.get(position) == Some(&name) {
                position
            } else {
                NAMES.iter().position(|known| *known == name)?
            };
            if !self.takes(b':') {
                return None;
            }
            while self.text.get(self.at) == Some(&b' ') {
                self.at += 1;
            }
            let (number, length) = number_at(self.text.get(self.at..)?)?;
            self.at += length;
            let value = values.get_mut(column)?;
            // A number that was read is finite, so this name came before.
            if !value.is_nan() {
                return None;
            }
            *value = number;
        }
        let [x, y, z, i, j, k] = values;
        self.takes(b'}').then_some(Pose { x, y, z, i, j, k })
    }
}

struct Elements;

impl<'de> Visitor<'de> for Elements {
    type Value = PoseColumns;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a sequence")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<PoseColumns, A::Error> {
        let mut poses = PoseColumns::with_room_for_few();
        while let Some(pose) = seq.next_element::<Pose>()? {
            poses.push(&pose);
        }
        Ok(poses)
    }
}

impl<'de> Deserialize<'de> for PoseColumns {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Elements)
    }
}

#[cfg(test)]
mod tests {
    use crate::wire::{InverseRequest, read_json};

    /// A document that is long enough for the faster way, around these poses.
    fn document(before: &str, poses: &str, after: &str) -> String {
        format!("{{{before}\"poses\"{poses}{after}}}{}", " ".repeat(3000))
    }

    #[test]
    fn the_faster_way_reads_what_serde_reads_and_refuses_what_serde_refuses() {
        let pose = r#"{"x":1,"y":-2.5,"z":3e2,"i":0,"j":0.1,"k":0.99}"#;
        let turned =
            r#" { "k" : 1.0 , "x":0.30000000000000004,"y": 12345678901234567890,"z":-0,"i":1e-7,"j":0 } "#;
        let zero = r#"{"x":1e300,"y":0,"z":0,"i":0,"j":0,"k":0}"#;
        let lists = [
            ":[]".to_owned(),
            " :\n[ ]".to_owned(),
            format!(":[{pose}]"),
            format!(":[{pose},{turned},{pose}]"),
            format!(":[{pose},{zero}]"),
            format!(":[{pose},]"),
            format!(":[{pose} {pose}]"),
            format!(":[{pose}"),
            format!(":{pose}"),
            ":null".to_owned(),
            r#":[{"x":1,"y":2,"z":3,"i":0,"j":0}]"#.to_owned(),
            r#":[{"x":1,"x":1,"y":2,"z":3,"i":0,"j":0,"k":1}]"#.to_owned(),
            r#":[{"x":01,"y":2,"z":3,"i":0,"j":0,"k":1}]"#.to_owned(),
            r#":[{"x":1e999,"y":2,"z":3,"i":0,"j":0,"k":1}]"#.to_owned(),
            r#":[{"x":"1","y":2,"z":3,"i":0,"j":0,"k":1}]"#.to_owned(),
            r#":[{"x":1,"y":2,"z":3,"i":0,"j":0,"k":1,"l":1}]"#.to_owned(),
            r#":[{"\u0078":1,"y":2,"z":3,"i":0,"j":0,"k":1}]"#.to_owned(),
            r":[[1,2,3,0,0,1]]".to_owned(),
        ];
        let around = [
            ("", ""),
            (r#""work_offset_mm":[1,2,3],"#, r#","selection":"all""#),
            (r#""tool_length_mm":5 , "#, r#","tool_length_mm":5"#),
            (r#""start":{"A":1,"C":2},"#, ""),
            (r#""start":{"poses":[]},"#, ""),
            (r#""start":{"A":1,"#, "}"),
            (r#""selection":"\"poses\":[]","#, ""),
            (r#""selektion":1,"#, ""),
            ("\u{b}", ""),
            ("", r#","poses":[]"#),
            ("", ",\u{e9}"),
            ("", "} x"),
        ];
        for list in &lists {
            for (before, after) in around {
                let text = document(before, list, after);
                let (fast, serde) = (InverseRequest::read(text.as_bytes()), read_json(text.as_bytes()));
                assert_eq!(fast, serde, "{text}");
            }
        }
        let far = turned.replace("12345678901234567890", "12.5");
        let many = format!(":[{}]", vec![far; 500].join(","));
        let read = InverseRequest::read(document("", &many, "").as_bytes()).unwrap();
        assert_eq!(read.poses.len(), 500);
        assert_eq!(read.poses.lanes.x_mm, [0.1 + 0.2; 500]);
    }
}
