//! The answer of the inverse kinematics, printed directly: rows of joints are most of the bytes that the
//! service sends.

use std::io::Write;

use serde::{Serialize, Serializer};
use utoipa::ToSchema;

use super::{JointWords, PoseWarning};

/// Approximate number of bytes of a printed row of joints.
const ROW_BYTES: usize = 160;
/// Approximate number of bytes written at a time.
const PIECE_BYTES: usize = 64 << 10;

/// Axis words of poses.
#[derive(Debug, Serialize, ToSchema)]
pub struct SolvedPoses {
    /// Revision of the machine that was used.
    machine_revision: i64,
    /// Selection `path`: one solution for each pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    joints: Option<Vec<JointWords>>,
    /// Selection `all`: every solution of each pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<Vec<JointWords>>>)]
    candidates: Option<Candidates>,
    /// Warnings about some poses.
    warnings: Vec<PoseWarning>,
}

/// The solutions of all poses, one pose after the other.
#[derive(Debug)]
struct Candidates {
    joints: Vec<JointWords>,
    ends: Vec<usize>,
}

impl Serialize for Candidates {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let begins = std::iter::once(&0).chain(&self.ends);
        let slices =
            begins.zip(&self.ends).map(|(&begin, &end)| self.joints.get(begin..end).unwrap_or_default());
        serializer.collect_seq(slices)
    }
}

impl SolvedPoses {
    /// One solution for each pose. With `ends`: all solutions, and `ends` says where in `joints` those of
    /// each pose end.
    #[must_use]
    pub fn new(
        machine_revision: i64,
        joints: Vec<JointWords>,
        ends: Option<Vec<usize>>,
        warnings: Vec<PoseWarning>,
    ) -> Self {
        let (joints, candidates) = match ends {
            None => (Some(joints), None),
            Some(ends) => (None, Some(Candidates { joints, ends })),
        };
        Self { machine_revision, joints, candidates, warnings }
    }

    /// Writes the document as JSON text in pieces: the same bytes as serde writes. With one solution for each
    /// pose it takes a third of the time.
    ///
    /// # Errors
    /// The same as the writer's.
    /// As the writer.
    pub fn write_json(&self, writer: &mut impl Write) -> std::io::Result<()> {
        let Some(joints) = &self.joints else { return Ok(serde_json::to_writer(writer, self)?) };
        let mut out = Vec::with_capacity((joints.len() * ROW_BYTES + 64).min(PIECE_BYTES + 2 * ROW_BYTES));
        out.extend_from_slice(b"{\"machine_revision\":");
        serde_json::to_writer(&mut out, &self.machine_revision)?;
        out.extend_from_slice(b",\"joints\":[");
        for (index, words) in joints.iter().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            words.write_json(&mut out)?;
            if out.len() >= PIECE_BYTES {
                writer.write_all(&out)?;
                out.clear();
            }
        }
        out.extend_from_slice(b"],\"warnings\":");
        serde_json::to_writer(&mut out, &self.warnings)?;
        out.push(b'}');
        writer.write_all(&out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::PoseWarningKind;

    #[test]
    fn printing_by_hand_gives_the_bytes_of_serde() {
        let plain = JointWords {
            X: 1.0,
            Y: -0.0,
            Z: 1e-7,
            A: None,
            B: Some(-33.25),
            C: Some(1e21),
            conditioning: Some(0.1 + 0.2),
        };
        let bare = JointWords { X: f64::NAN, B: None, C: None, A: Some(5e-324), conditioning: None, ..plain };
        let warnings =
            vec![PoseWarning { pose: 1, kind: PoseWarningKind::PoleHold, axis_residual_urad: Some(0.5) }];
        for joints in [vec![], vec![plain], vec![plain, bare, plain]] {
            for ends in [None, Some((1..=joints.len()).collect())] {
                let document = SolvedPoses::new(7, joints.clone(), ends, warnings.clone());
                let by_serde = serde_json::to_string(&document).unwrap();
                let mut text = Vec::new();
                document.write_json(&mut text).unwrap();
                assert_eq!(String::from_utf8(text).unwrap(), by_serde);
            }
        }
    }
}
