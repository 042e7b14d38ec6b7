//! The path of a job's program with its errors before and after, as a table.

use std::collections::BTreeMap;
use std::io::Write;

use serde::Deserialize;
use serde_json::Value;

use super::{DeviationSeries, InterpretationParameters, MotionKindDoc, ResolvedInputs};
use crate::machine::Machine;
use crate::process::{InterpretedKind, InterpretedMotion};

/// The errors of a job along its program, as its report has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ErrorsByLine(BTreeMap<u64, [f64; 2]>);

impl ErrorsByLine {
    /// The errors of a report, before and after; none if the operation corrects nothing.
    #[must_use]
    pub fn of(report: &str) -> Self {
        #[derive(Deserialize)]
        struct Changes {
            series: Sums,
        }
        #[derive(Deserialize)]
        struct Sums {
            line: Vec<u64>,
            error_before_um: Vec<f64>,
            error_after_um: Vec<f64>,
        }
        #[derive(Default, Deserialize)]
        #[serde(default)]
        struct Report {
            series: Option<DeviationSeries>,
            changes: Option<Changes>,
        }
        let Report { series, changes } = serde_json::from_str(report).unwrap_or_default();
        let (lines, before, after) = match (changes, series) {
            (Some(Changes { series }), _) => (series.line, series.error_before_um, series.error_after_um),
            (None, Some(series)) => (series.line, series.before_um, series.after_um),
            (None, None) => return Self::default(),
        };
        let mut by_line = BTreeMap::<u64, [f64; 2]>::new();
        for ((line, before), after) in lines.into_iter().zip(before).zip(after) {
            let known = by_line.entry(line).or_default();
            *known = [known[0].max(before), known[1].max(after)];
        }
        Self(by_line)
    }

    /// The errors of a line: of the sample there, or of the last one before it.
    fn at(&self, line: u64) -> [Option<f64>; 2] {
        let found = self.0.range(..=line).next_back();
        found.map_or([None; 2], |(_, errors)| errors.map(Some))
    }
}

/// The tools of the tool table that a report names, with their revisions.
#[must_use]
pub fn tools_of_report(report: &str) -> Vec<(String, i64)> {
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Report {
        resolved: Option<ResolvedInputs>,
    }
    let Report { resolved } = serde_json::from_str(report).unwrap_or_default();
    let mut tools: Vec<_> = resolved
        .into_iter()
        .flat_map(|resolved| resolved.tools)
        .filter_map(|tool| tool.tool_id.zip(tool.tool_revision))
        .collect();
    tools.sort();
    tools.dedup();
    tools
}

/// What a request states about its program, whatever its operation.
const STATEMENTS: [&str; 10] = [
    "interpolation",
    "unit",
    "work_offset_mm",
    "work_offsets_mm",
    "radius_offsets_mm",
    "tool_length_mm",
    "tool_number",
    "start",
    "feed_mm_per_min",
    "dialect",
];

impl InterpretationParameters {
    /// What the parameters of a job, whatever its operation, state about its program.
    ///
    /// # Errors
    /// A member is not what every operation takes.
    pub fn of_job(parameters: &Value) -> Result<Self, serde_json::Error> {
        let stated = |name: &str| parameters.get(name).map(|value| (name.to_owned(), value.clone()));
        serde_json::from_value(Value::Object(STATEMENTS.into_iter().filter_map(stated).collect()))
    }
}

/// One pose of the path: the end of a motion, of a piece of an arc, or of several that follow each other.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PathPose {
    line: u64,
    kind: InterpretedKind,
    joints: [Option<f64>; 5],
    tip_mm: [f64; 3],
    axis: [f64; 3],
    errors_um: [Option<f64>; 2],
}

impl PathPose {
    /// The same pose after this one: its place, and the larger errors of both.
    fn and(self, next: Self) -> Self {
        let is_cut = |pose: &Self| pose.kind != InterpretedKind::Rapid;
        let kind = if is_cut(&self) && !is_cut(&next) { self.kind } else { next.kind };
        let larger = |k: usize| match (self.errors_um[k], next.errors_um[k]) {
            (Some(one), Some(other)) => Some(one.max(other)),
            (one, other) => one.or(other),
        };
        Self { errors_um: [larger(0), larger(1)], kind, ..next }
    }
}

/// Poses of one turn of an arc, which looks round then: one every 5 degrees.
const POSES_PER_TURN: f64 = 72.0;
/// Most poses of one arc: a helix may have any number of turns. Beyond ten thousand it would no longer look like one.
const MOST_POSES_OF_ARC: f64 = 20_000.0;

/// A path with a largest number of poses. A longer program does not make it longer: each pose then stands for several
/// motions.
#[derive(Debug)]
pub struct JobPath {
    errors: ErrorsByLine,
    most: usize,
    /// Motions in each pose.
    together: u64,
    open: Option<(PathPose, u64)>,
    poses: Vec<PathPose>,
}

impl JobPath {
    /// An empty path with these errors. It will have at most `most` poses, and at least 2.
    #[must_use]
    pub fn new(errors: ErrorsByLine, most: usize) -> Self {
        Self { errors, most: most.max(2), together: 1, open: None, poses: Vec::new() }
    }

    /// Adds a motion, an arc in pieces. One whose place is not known is left out.
    pub fn add(&mut self, motion: &InterpretedMotion) {
        let is_rapid = motion.kind == InterpretedKind::Rapid;
        let errors_um = if is_rapid { [None; 2] } else { self.errors.at(motion.line) };
        let turns = motion.arc.map_or(0.0, |arc| arc.turns);
        // Pieces that would be put together again are not made.
        let pieces = ((turns * POSES_PER_TURN).min(MOST_POSES_OF_ARC) / self.together as f64).ceil();
        let mut piece = 1.0;
        while piece < pieces {
            if let Some(part) = motion.until(piece / pieces) {
                self.add_end(&part, errors_um);
            }
            piece += 1.0;
        }
        self.add_end(motion, errors_um);
    }

    /// Adds the end of a motion.
    fn add_end(&mut self, motion: &InterpretedMotion, errors_um: [Option<f64>; 2]) {
        let (Some(tip_mm), Some(axis)) = (motion.tip_mm, motion.axis) else { return };
        let InterpretedMotion { line, kind, joints, .. } = *motion;
        let pose = PathPose { line, kind, joints, tip_mm, axis, errors_um };
        let (pose, count) = match self.open.take() {
            Some((open, count)) => (open.and(pose), count + 1),
            None => (pose, 1),
        };
        // The path begins where the first motion ends.
        if count < self.together && !self.poses.is_empty() {
            self.open = Some((pose, count));
            return;
        }
        self.poses.push(pose);
        while self.poses.len() > self.room() {
            self.thin();
        }
    }

    /// The largest number of complete poses: where a pose stands for several motions, the last one may be incomplete.
    fn room(&self) -> usize {
        if self.together == 1 { self.most } else { self.most - 1 }
    }

    fn thin(&mut self) {
        self.together *= 2;
        let mut all = std::mem::take(&mut self.poses).into_iter();
        self.poses.extend(all.next());
        while let Some(pose) = all.next() {
            match all.next() {
                Some(next) => self.poses.push(pose.and(next)),
                None => self.open = Some((pose, self.together / 2)),
            }
        }
    }

    /// Writes the table. Returns how many motions, or pieces of arcs, a pose stands for at most.
    ///
    /// # Errors
    /// The rows cannot be written.
    pub fn write<W: Write>(mut self, out: W, machine: &Machine) -> Result<(W, u64), csv::Error> {
        self.poses.extend(self.open.take().map(|(pose, _)| pose));
        let [first, second] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char().to_string());
        let mut rows = csv::Writer::from_writer(out);
        rows.write_record([
            "line",
            "kind",
            "X",
            "Y",
            "Z",
            &first,
            &second,
            "tip_x_mm",
            "tip_y_mm",
            "tip_z_mm",
            "axis_i",
            "axis_j",
            "axis_k",
            "before_um",
            "after_um",
        ])?;
        for PathPose { line, kind, joints, tip_mm, axis, errors_um } in &self.poses {
            rows.serialize((line, MotionKindDoc::of(*kind), joints, tip_mm, axis, errors_um))?;
        }
        let out = rows.into_inner().map_err(csv::IntoInnerError::into_error)?;
        Ok((out, self.together))
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::kinematics::Setup;
    use crate::machine::Preset;
    use crate::motion::CalledTool;
    use crate::process::{Interpreted, ProgramSetup, interpret_program};

    fn motion(line: u32, kind: InterpretedKind) -> InterpretedMotion {
        let place = f64::from(line);
        InterpretedMotion {
            line: line.into(),
            called: None,
            kind,
            joints: [Some(place); 5],
            tip_mm: Some([place, 0.0, 0.0]),
            axis: Some([0.0, 0.0, 1.0]),
            feed_mm_per_min: None,
            tool: CalledTool::NotCalled,
            tool_name: None,
            work_offset: None,
            arc: None,
        }
    }

    fn machine() -> Machine {
        Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap()
    }

    fn table(motions: u32, most: usize) -> (Vec<Vec<String>>, u64) {
        let report = r#"{"series": {
            "path_mm": [1, 2, 3], "line": [2, 40, 60], "before_um": [1, 9, 3], "after_um": [0.5, 0.75, 0.25]}}"#;
        let mut path = JobPath::new(ErrorsByLine::of(report), most);
        path.add(&motion(1, InterpretedKind::Rapid));
        for line in 2..=motions {
            path.add(&motion(line, InterpretedKind::Linear));
        }
        let (text, together) = path.write(Vec::new(), &machine()).unwrap();
        let mut rows = csv::Reader::from_reader(&*text);
        assert_eq!(rows.headers().unwrap().len(), 15);
        let rows = rows.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect();
        (rows, together)
    }

    #[test]
    fn a_short_path_has_every_motion_and_the_error_of_its_line_or_of_the_one_before() {
        let (rows, together) = table(100, 1000);
        assert_eq!((rows.len(), together), (100, 1));
        assert_eq!((rows[0][1].as_str(), rows[0][13].as_str()), ("rapid", ""));
        for (line, before, after) in
            [(2, "1.0", "0.5"), (39, "1.0", "0.5"), (41, "9.0", "0.75"), (100, "3.0", "0.25")]
        {
            let row = &rows[line - 1];
            assert_eq!(
                (row[0].as_str(), row[13].as_str(), row[14].as_str()),
                (&*line.to_string(), before, after)
            );
        }
    }

    #[test]
    fn a_long_path_keeps_its_ends_and_its_largest_errors() {
        for (motions, most) in [(7, 2), (8, 3), (9, 4), (300, 2)] {
            let (rows, _) = table(motions, most);
            assert!((2..=most).contains(&rows.len()), "{motions} in {most}: {}", rows.len());
            assert_eq!(rows.last().unwrap()[0], motions.to_string());
        }
        for motions in [101, 150, 199, 1000, 12_345] {
            let (rows, together) = table(motions, 100);
            assert!(rows.len() <= 100 && rows.len() > 25, "{motions}: {}", rows.len());
            assert!(
                together.is_power_of_two() && together >= u64::from(motions / 101),
                "{motions}: {together}"
            );
            assert_eq!(rows[0][0], "1");
            assert_eq!(rows.last().unwrap()[0], motions.to_string());
            assert!(rows.iter().any(|row| row[13] == "9.0"), "{motions}: the largest error is lost");
            let lines: Vec<u64> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
            assert!(lines.is_sorted(), "{lines:?}");
        }
    }

    #[test]
    fn an_arc_has_a_pose_every_five_degrees_and_fewer_in_a_long_path() {
        let interpreted = |text: &str| {
            let mut all = Vec::new();
            let mut take = |told: &Interpreted| {
                if let Interpreted::Motion(motion) = told {
                    all.push(*motion);
                }
                Ok(())
            };
            let program = ProgramSetup { apply_errors: false, ..ProgramSetup::in_mm(&Setup::default()) };
            let text = text.as_bytes().to_vec();
            interpret_program(&machine(), &program, &text, &mut take, &|| ControlFlow::Continue(())).unwrap();
            all
        };
        let motions = interpreted("G90 G17 G1 X10 Y0 Z0 A0 C0 F100\nG3 X-10 Y0 I-10 J0\nG1 X-20\n");
        let mut path = JobPath::new(ErrorsByLine::default(), 1000);
        for motion in &motions {
            path.add(motion);
        }
        assert_eq!(path.poses.len(), 1 + 36 + 1);
        for (k, pose) in path.poses[1..37].iter().enumerate() {
            let angle = (5.0 * (k as f64 + 1.0)).to_radians();
            assert_eq!((pose.line, pose.kind), (2, InterpretedKind::Arc));
            for (found, expected) in
                pose.tip_mm.into_iter().zip([10.0 * angle.cos(), 10.0 * angle.sin(), 0.0])
            {
                assert!((found - expected).abs() < 1e-9, "{k}: {pose:?}");
            }
        }
        let mut long = JobPath::new(ErrorsByLine::default(), 100);
        for _ in 0..100 {
            for motion in &motions {
                long.add(motion);
            }
        }
        assert!((25..=100).contains(&long.poses.len()), "{}", long.poses.len());
        // A helix of a million turns is not longer than one of some hundred.
        let mut helix = motions[1];
        helix.arc.as_mut().unwrap().turns = 1e6;
        let mut path = JobPath::new(ErrorsByLine::default(), 100_000);
        path.add(&helix);
        assert_eq!(path.poses.len(), 20_000);
    }

    #[test]
    fn the_statements_are_all_parameters_of_an_interpretation() {
        let schema =
            serde_json::to_value(<InterpretationParameters as utoipa::PartialSchema>::schema()).unwrap();
        let mut named: Vec<_> =
            schema["properties"].as_object().unwrap().keys().map(String::as_str).collect();
        let mut stated = STATEMENTS;
        named.sort_unstable();
        stated.sort_unstable();
        assert_eq!(named, stated);
    }

    #[test]
    fn a_report_without_errors_has_none() {
        for report in ["{}", "", r#"{"series": 7}"#] {
            assert_eq!(ErrorsByLine::of(report), ErrorsByLine::default(), "{report}");
        }
        assert_eq!(ErrorsByLine::default().at(7), [None; 2]);
    }
}
