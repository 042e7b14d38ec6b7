//! The answer of the inverse kinematics, printed directly: rows of joints are most of the bytes that the
//! service sends.

use std::io::{self, Write};

use serde::{Serialize, Serializer};

use super::pieces::{LONGEST_NUMBER, write_as_made, write_in_pieces};
use super::{JointColumns, JointWords, PoseWarning};
use crate::description::ToSchema;
use crate::kinematics::{DecidedPath, InverseError, Path};
use crate::machine::{Machine, RotaryAxis};
use crate::side_by_side::SideBySide;

/// Solutions of poses, in the form that takes the least memory.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one for each request")]
pub enum Solutions {
    /// One solution for each pose.
    Path(PathWords),
    /// Every solution of each pose, one pose after the other.
    All {
        /// The solutions.
        joints: Vec<JointWords>,
        /// Where in `joints` the solutions of each pose end.
        ends: Vec<usize>,
    },
}

/// One solution for each pose, in the columns in which it was computed.
#[derive(Debug, Clone, PartialEq)]
pub struct PathWords {
    path: Path,
    axes: [RotaryAxis; 2],
}

impl PathWords {
    /// The words of a path on `machine`.
    #[must_use]
    pub fn new(machine: &Machine, path: Path) -> Self {
        Self { path, axes: machine.rotary_axes().clone() }
    }

    /// Replaces the words by those that `make` puts into the path, in the memory that there is.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn refill<E>(&mut self, make: impl FnOnce(&mut Path) -> Result<(), E>) -> Result<(), E> {
        make(&mut self.path)
    }

    /// The number of poses.
    #[must_use]
    pub fn len(&self) -> usize {
        self.path.conditioning.len()
    }

    /// Whether there is no pose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The words of one pose.
    #[must_use]
    #[inline]
    pub fn get(&self, pose: usize) -> Option<JointWords> {
        let conditioning = self.path.conditioning.get(pose).copied();
        Some(JointWords::of_axes(&self.axes, &self.path.get(pose)?, conditioning))
    }
}

impl Serialize for PathWords {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((0..self.len()).map_while(|pose| self.get(pose)))
    }
}

impl Solutions {
    /// The number of solutions.
    #[must_use]
    pub fn count(&self) -> usize {
        match self {
            Self::Path(words) => words.len(),
            Self::All { joints, .. } => joints.len(),
        }
    }

    /// Writes the solutions as the rows of a table, without its header.
    ///
    /// # Errors
    /// The writer's.
    pub fn write_rows(
        &self,
        columns: JointColumns,
        threads: &dyn SideBySide,
        writer: &mut (impl Write + Send),
    ) -> io::Result<()> {
        write_in_pieces(self.count(), threads, writer, &|rows, text| match self {
            Self::Path(words) => {
                for (pose, words) in rows.filter_map(|pose| Some((pose, words.get(pose)?))) {
                    columns.write_row(text, pose, &words);
                }
            }
            Self::All { joints, ends } => {
                let mut pose = ends.partition_point(|end| *end <= rows.start);
                for (row, words) in rows.clone().zip(joints.get(rows).unwrap_or_default()) {
                    while ends.get(pose).is_some_and(|end| *end <= row) {
                        pose += 1;
                    }
                    columns.write_row(text, pose, words);
                }
            }
        })
    }
}

/// Writes a path that is decided as the rows of a table, without its header. Its joints are made while others are
/// printed. `fault` tells why there are no more joints.
///
/// # Errors
/// That fault, and the writer's.
pub fn write_path_rows<E: From<io::Error> + Send>(
    machine: &Machine,
    decided: &mut DecidedPath<'_>,
    threads: &dyn SideBySide,
    writer: &mut (impl Write + Send),
    fault: impl Fn(InverseError) -> E + Sync,
) -> Result<(), E> {
    let (columns, rows) = (JointColumns::new(machine, false), decided.len());
    let rounds = [(); 2].map(|()| PathWords::new(machine, Path::default()));
    let make = |most: usize, words: &mut PathWords| {
        words.refill(|path| decided.next_piece(most, path)).map_err(&fault)?;
        Ok(words.len())
    };
    write_as_made(rows, rounds, threads, writer, make, &|words: &PathWords, rows, text| {
        for (row, words) in rows.filter_map(|row| Some((row, words.get(row)?))) {
            columns.write_row(text, row, &words);
        }
    })
}

/// Axis words of poses.
#[derive(Debug, Serialize, ToSchema)]
pub struct SolvedPoses {
    /// Revision of the machine that was used.
    machine_revision: i64,
    /// Selection `path`: one solution for each pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<JointWords>>)]
    joints: Option<PathWords>,
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
    /// The document of these solutions.
    #[must_use]
    pub fn new(machine_revision: i64, solutions: Solutions, warnings: Vec<PoseWarning>) -> Self {
        let (joints, candidates) = match solutions {
            Solutions::Path(words) => (Some(words), None),
            Solutions::All { joints, ends } => (None, Some(Candidates { joints, ends })),
        };
        Self { machine_revision, joints, candidates, warnings }
    }

    /// The largest length of the document as JSON \[bytes\].
    #[must_use]
    pub fn most_json_bytes(&self) -> u64 {
        const WORDS: usize = r#"{"X":,"Y":,"Z":,"A":,"B":,"C":,"conditioning":},"#.len() + 7 * LONGEST_NUMBER;
        const WARNING: usize =
            r#"{"pose":,"kind":"reach_limit","axis_residual_urad":},"#.len() + 2 * LONGEST_NUMBER;
        const POSE: usize = "[],".len();
        const AROUND: usize = 100;
        let words = self.joints.as_ref().map_or(0, PathWords::len);
        let [listed, poses] =
            self.candidates.as_ref().map_or([0; 2], |all| [all.joints.len(), all.ends.len()]);
        let parts = [(words + listed, WORDS), (poses, POSE), (self.warnings.len(), WARNING), (1, AROUND)];
        parts.into_iter().map(|(count, bytes)| count as u64 * bytes as u64).sum()
    }

    /// Writes the document as JSON text in pieces: the same bytes as serde writes. With one solution for each
    /// pose the pieces are printed side by side, and each takes a third of serde's time.
    ///
    /// # Errors
    /// The same as the writer's.
    pub fn write_json(
        &self,
        threads: &dyn SideBySide,
        writer: &mut (impl Write + Send),
    ) -> std::io::Result<()> {
        let Some(joints) = &self.joints else { return Ok(serde_json::to_writer(writer, self)?) };
        writer.write_all(b"{\"machine_revision\":")?;
        serde_json::to_writer(&mut *writer, &self.machine_revision)?;
        writer.write_all(b",\"joints\":[")?;
        write_in_pieces(joints.len(), threads, writer, &|poses, text| {
            for (pose, words) in poses.filter_map(|pose| Some((pose, joints.get(pose)?))) {
                if pose > 0 {
                    text.push(b',');
                }
                words.write_json(text);
            }
        })?;
        writer.write_all(b"],\"warnings\":")?;
        serde_json::to_writer(&mut *writer, &self.warnings)?;
        writer.write_all(b"}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Preset;
    use crate::side_by_side::OneAfterAnother;
    use crate::wire::PoseWarningKind;

    fn machine() -> Machine {
        Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap()
    }

    /// Words with numbers of every kind.
    fn words(count: usize) -> PathWords {
        let numbers = [1.0, -0.0, 1e-7, -33.25, 1e21, 0.1 + 0.2, f64::NAN, 5e-324, f64::INFINITY];
        let mut next = numbers.into_iter().cycle();
        let mut path = Path::default();
        for _ in 0..count {
            let mut five = || std::array::from_fn(|_| next.next().unwrap_or_default());
            path.joints.push(five(), [0.5, -1.25]);
            path.conditioning.push(next.next().unwrap_or_default());
        }
        PathWords::new(&machine(), path)
    }

    #[test]
    fn printing_by_hand_gives_the_bytes_of_serde() {
        let warnings =
            vec![PoseWarning { pose: 1, kind: PoseWarningKind::PoleHold, axis_residual_urad: Some(0.5) }];
        for (count, warnings) in [(0, &[][..]), (1, &warnings), (1, &[]), (3, &warnings), (5000, &warnings)] {
            let words = words(count);
            let joints: Vec<_> = (0..count).filter_map(|pose| words.get(pose)).collect();
            let all = Solutions::All { joints, ends: (1..=count).collect() };
            for solutions in [Solutions::Path(words), all] {
                let document = SolvedPoses::new(7, solutions, warnings.to_vec());
                let by_serde = serde_json::to_string(&document).unwrap();
                let mut text = Vec::new();
                document.write_json(&OneAfterAnother, &mut text).unwrap();
                assert!(text.len() as u64 <= document.most_json_bytes());
                assert!(String::from_utf8(text).unwrap() == by_serde, "{count}");
            }
        }
    }

    #[test]
    fn a_table_names_the_pose_of_every_solution() {
        let joints: Vec<_> = (0..5000).filter_map(|_| words(1).get(0)).collect();
        // Two, one and one solution in turns; the first pose has none.
        let ends: Vec<_> = (0..3751).map(|pose| (pose * 4_usize).div_ceil(3)).collect();
        let columns = JointColumns::new(&machine(), true);
        let mut text = Vec::new();
        let all = Solutions::All { joints, ends: ends.clone() };
        all.write_rows(columns, &OneAfterAnother, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        for (row, line) in text.lines().enumerate() {
            let pose = ends.iter().position(|end| *end > row).unwrap();
            assert_eq!(line.split(',').next().unwrap(), pose.to_string());
        }
        assert_eq!(text.lines().count(), 5000);
    }
}
