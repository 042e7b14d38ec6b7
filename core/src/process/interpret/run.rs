//! The interpretation of a program, motion by motion. People check it first, and other program readers can be
//! compared with it.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

use crate::contact::{Station, rotary_rad};
use crate::geometry::{Vec3, trig};
use crate::machine::Machine;
use crate::motion::{
    AxisWords, CalledTool, FeedMode, Interpolation, Motion, MotionKind, ToolName, Unfollowable, WorkOffset,
    WorkOffsets,
};
use crate::process::arc_path::{ArcModes, ArcPath};
use crate::process::fault::{Fault, Warning, Warnings};
use crate::process::set_up::{Need, ProgramSetup, SetUps, Tools};
use crate::process::text::{Passage, Passages, ProgramReading, ProgramSource};
use crate::program::{Dialect, PlaceInFile};

/// The kind of an interpreted motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterpretedKind {
    /// At the speed of the axes.
    Rapid,
    /// All axes linear, or the tip straight.
    Linear,
    /// An arc or a helix.
    Arc,
}

/// The course of an arc in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterpretedArc {
    /// Its centre, at the height of its start \[mm\].
    pub centre_mm: [f64; 3],
    /// The axis about which the arc runs counter-clockwise.
    pub normal: [f64; 3],
    /// Number of turns; 0.25 for a quarter circle.
    pub turns: f64,
    /// Its course in words.
    course: ArcPath,
}

/// A motion as interpreted. Unknown values are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterpretedMotion {
    /// 1-based line of the main program: of the motion, or of the call of its file.
    pub line: u64,
    /// Its place, if it is in a file that the program calls.
    pub called: Option<PlaceInFile>,
    /// The kind.
    pub kind: InterpretedKind,
    /// The words at its end, absolute, as the control counts them: X Y Z \[mm\], the rotary axes in the profile's
    /// order \[deg\]. Under tool-centre-point control X Y Z are the tip's.
    pub joints: [Option<f64>; 5],
    /// The tip at its end in W \[mm\].
    pub tip_mm: Option<[f64; 3]>,
    /// The tool axis at its end in W, from the tip to the spindle; `None` also if the offset may turn the
    /// workpiece.
    pub axis: Option<[f64; 3]>,
    /// The speed of the tip that F asks for \[mm/min\]; `None` for rapids and for feed per spindle turn.
    pub feed_mm_per_min: Option<f64>,
    /// The tool in the spindle.
    pub tool: CalledTool,
    /// Its name, if it was called by name.
    pub tool_name: Option<ToolName>,
    /// The work offset in force; `None` if it is unknown, or shifted by an unknown amount.
    pub work_offset: Option<WorkOffset>,
    /// The course of an arc.
    pub arc: Option<InterpretedArc>,
}

impl InterpretedMotion {
    /// An arc up to this share of its course, above 0 and at most 1: its words and its tip there. The tool axis rests
    /// along an arc. `None` if this is no arc, or if its course is not known.
    #[must_use]
    pub fn until(&self, share: f64) -> Option<Self> {
        let InterpretedArc { centre_mm, normal, turns, course } = self.arc?;
        let AxisWords { linear_mm: [x, y, z], rotary_deg: [first, second] } = course.words_at(share);
        let (centre_mm, normal) = (Vec3::from(centre_mm), Vec3::from(normal));
        let tip_mm = self.tip_mm.map(|end_mm| {
            let arm_mm = Vec3::from(end_mm) - centre_mm;
            let rise_mm = normal * arm_mm.dot(&normal);
            // Back from the end, which is known.
            let (sin, cos) = trig::sin_cos(TAU * turns * (share - 1.0));
            let flat_mm = arm_mm - rise_mm;
            (centre_mm + flat_mm * cos + normal.cross(&flat_mm) * sin + rise_mm * share).into()
        });
        Some(Self { joints: [x, y, z, first, second].map(Some), tip_mm, ..*self })
    }
}

/// One entry of the interpretation: a motion, or the reason why a motion is left unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time, and nearly all are motions")]
pub enum Interpreted {
    /// A motion that was interpreted.
    Motion(InterpretedMotion),
    /// A motion that was not interpreted. Every operation that changes programs leaves it unchanged.
    LeftAlone {
        /// 1-based line of the main program: of the motion, or of the call of its file.
        line: u64,
        /// Its place, if it is in a file that the program calls.
        called: Option<PlaceInFile>,
        /// The reason.
        reason: Unfollowable,
    },
}

/// What is known after the whole program was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpretation {
    /// The dialect in which it was read.
    pub dialect: Dialect,
    /// How it was read.
    pub reading: ProgramReading,
    /// Blocks: non-empty lines that are not only comments.
    pub blocks: u64,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
}

/// Reads a program and returns its interpretation, motion by motion and in order. If `program` does not apply the
/// machine's errors, tips and axes are those of the nominal machine. Memory does not grow with the program.
///
/// # Errors
/// The program cannot be read or followed as a whole, its unit is not stated, `take` fails, or the caller no longer
/// waits.
pub fn interpret_program(
    machine: &Machine,
    program: &ProgramSetup,
    source: &dyn ProgramSource,
    take: &mut dyn FnMut(&Interpreted) -> Result<(), Fault>,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Interpretation, Fault> {
    let program = match program.with_surveyed_tools(None, Need::LENGTH, machine, source, stop) {
        Ok(program) => program,
        // Tips that depend on an unknown length are left out.
        Err(Fault::Tool(_)) => ProgramSetup { tools: Tools::default(), ..program.clone() },
        Err(fault) => return Err(fault),
    };
    let mut passages =
        Passages::open(source, machine, &program)?.following_its_run(machine, &program).keeping_positions();
    let mut reader = Understanding {
        machine,
        set_ups: SetUps::new(machine, &program),
        interpolation: program.interpolation,
        work_offsets: Arc::clone(&program.work_offsets),
        modes: ArcModes::default(),
        names: Vec::new(),
    };
    while let Some((passage, _)) = passages.next()? {
        if stop().is_break() {
            return Err(Fault::Cancelled);
        }
        if !passages.is_refused() {
            reader.names = passages.tools_told().0;
            reader.passage(&passage, take)?;
        }
        passages.recycle(passage);
    }
    passages.refusals()?;
    let mut warnings = Warnings::default();
    passages.warn(&mut warnings);
    Ok(Interpretation {
        dialect: passages.dialect(),
        reading: passages.reading(),
        blocks: passages.blocks,
        warnings: warnings.into_list(),
    })
}

struct Understanding<'a> {
    machine: &'a Machine,
    set_ups: SetUps,
    interpolation: Option<Interpolation>,
    work_offsets: Arc<WorkOffsets>,
    modes: ArcModes,
    names: Vec<ToolName>,
}

impl Understanding<'_> {
    fn passage(
        &mut self,
        Passage { batch, motions, positions, .. }: &Passage,
        take: &mut dyn FnMut(&Interpreted) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let mut seen = 0;
        let mut see = |modes: &mut ArcModes, until: usize| {
            for block in batch.blocks().get(seen..until).unwrap_or_default() {
                modes.see(batch.words(block));
            }
            seen = seen.max(until);
        };
        for (motion, position) in motions.iter().zip(positions) {
            see(&mut self.modes, motion.block as usize + 1);
            let kind = match motion.kind {
                MotionKind::Rapid => Some(InterpretedKind::Rapid),
                MotionKind::Linear => Some(InterpretedKind::Linear),
                MotionKind::Arc => Some(InterpretedKind::Arc),
                MotionKind::Opaque => None,
            };
            let told = match (motion.unfollowable, kind) {
                (None, Some(kind)) => {
                    let arc = if kind == InterpretedKind::Arc { self.arc_path(batch, motion) } else { None };
                    Interpreted::Motion(self.motion(motion, kind, *position, arc.as_ref()))
                }
                (reason, _) => Interpreted::LeftAlone {
                    line: motion.line,
                    called: motion.called,
                    reason: reason.unwrap_or(Unfollowable::UnknownCode),
                },
            };
            take(&told)?;
        }
        see(&mut self.modes, batch.blocks().len());
        Ok(())
    }

    fn arc_path(&self, batch: &crate::program::Batch, motion: &Motion) -> Option<ArcPath> {
        let ends = [motion.start?, motion.end?];
        ArcPath::of(self.modes, batch, motion, ends).ok()
    }

    fn motion(
        &mut self,
        motion: &Motion,
        kind: InterpretedKind,
        position: [Option<f64>; 5],
        arc: Option<&ArcPath>,
    ) -> InterpretedMotion {
        self.set_ups.enter(motion);
        let mut joints = position;
        if let Some(AxisWords { linear_mm: [x, y, z], rotary_deg: [first, second] }) = motion.end {
            // A stated tool axis has become words of the machine.
            joints = [x, y, z, first, second].map(Some);
        } else if let Some(linear_mm) = motion.linear_end_mm {
            // A block may make several motions.
            joints[..3].copy_from_slice(&linear_mm.map(Some));
        } else if motion.frame.is_some() {
            // Places of the plane are none of the work offset.
            joints[..3].fill(None);
        }
        let name = self.names.iter().find(|name| Some(name.key()) == motion.tool.key());
        InterpretedMotion {
            line: motion.line,
            called: motion.called,
            kind,
            joints,
            tip_mm: self.tip_mm(motion, joints).map(Into::into),
            axis: self.axis(motion, joints).map(Into::into),
            feed_mm_per_min: self.feed_mm_per_min(motion),
            tool: motion.tool,
            tool_name: name.copied(),
            work_offset: motion.work_offset.filter(|_| !motion.is_shifted),
            arc: arc.and_then(|arc| self.arc(motion, arc)),
        }
    }

    fn mode(&self, motion: &Motion) -> Interpolation {
        motion.mode(self.interpolation)
    }

    fn tip_mm(&self, motion: &Motion, joints: [Option<f64>; 5]) -> Option<Vec3> {
        let [x, y, z, first, second] = joints;
        let linear_mm = [x?, y?, z?];
        if self.mode(motion) == Interpolation::Tcp {
            return Some(in_workpiece_mm(motion, linear_mm)?.into());
        }
        self.place(motion, &AxisWords { linear_mm, rotary_deg: [first?, second?] })
    }

    /// Position of the tip in W at these words. `None` if it depends on a work offset or a tool length that is not
    /// stated.
    fn place(&self, motion: &Motion, words: &AxisWords) -> Option<Vec3> {
        let mode = self.mode(motion);
        let is_at_zero = words.rotary_deg.iter().all(|word| word.abs() <= 0.0);
        let is_known = mode == Interpolation::Tcp || is_at_zero || self.set_ups.now.is_stated();
        let linear_mm = in_workpiece_mm(motion, words.linear_mm).filter(|_| is_known)?;
        let words = AxisWords { linear_mm, ..*words };
        Some(Station::new(self.machine, &self.set_ups.now.kinematics, mode, words).pose.tip_mm)
    }

    /// Whether the offset in force may turn the workpiece by an unstated angle: it is shifted, or the program
    /// changed to an unknown offset. The program's first offset never counts as turned: by the contract it does not
    /// turn.
    fn may_be_turned(&self, motion: &Motion) -> bool {
        let is_stated =
            motion.work_offset.is_some_and(|offset| self.work_offsets.of(offset, false).is_some());
        motion.is_shifted || motion.program_offset_mm.is_none() || !(motion.is_only_offset || is_stated)
    }

    fn axis(&self, motion: &Motion, joints: [Option<f64>; 5]) -> Option<Vec3> {
        if self.may_be_turned(motion) {
            return None;
        }
        if let Some(stated) = motion.tool_axis {
            return Vec3::from(stated).try_normalize(f64::EPSILON);
        }
        let [.., first, second] = joints;
        let rotary_rad = rotary_rad(self.machine, [first?, second?]);
        Some(self.set_ups.now.kinematics.axis(rotary_rad))
    }

    fn feed_mm_per_min(&self, motion: &Motion) -> Option<f64> {
        if motion.kind == MotionKind::Rapid {
            return None;
        }
        let value = motion.feed.value?;
        match motion.feed.mode? {
            FeedMode::PerMinute => Some(value),
            FeedMode::InverseTime if motion.kind == MotionKind::Linear => {
                let [from, to] = [motion.start?, motion.end?].map(|words| self.place(motion, &words));
                Some((to? - from?).norm() * value)
            }
            FeedMode::InverseTime | FeedMode::PerRevolution => None,
        }
    }

    fn arc(&self, motion: &Motion, path: &ArcPath) -> Option<InterpretedArc> {
        let [centre, beside] = path.centre();
        let at_centre = self.place(motion, &centre)?;
        let normal = (self.place(motion, &beside)? - at_centre).try_normalize(f64::EPSILON)?;
        let turns = path.sweep_rad() / TAU;
        Some(InterpretedArc {
            centre_mm: at_centre.into(),
            normal: (normal * turns.signum()).into(),
            turns: turns.abs(),
            course: *path,
        })
    }
}

/// Linear words relative to the work offset, if the program's text shifts its zero by known values.
fn in_workpiece_mm(motion: &Motion, linear_mm: [f64; 3]) -> Option<[f64; 3]> {
    let offset_mm = motion.program_offset_mm.filter(|_| !motion.is_shifted)?;
    Some(std::array::from_fn(|k| linear_mm[k] + offset_mm[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::Setup;
    use crate::machine::Preset;

    fn understood(program: &ProgramSetup, text: &str) -> Vec<Interpreted> {
        let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
        let mut all = Vec::new();
        let mut take = |told: &Interpreted| {
            all.push(*told);
            Ok(())
        };
        let source = text.as_bytes().to_vec();
        interpret_program(&machine, program, &source, &mut take, &|| ControlFlow::Continue(())).unwrap();
        all
    }

    fn motions(program: &ProgramSetup, text: &str) -> Vec<InterpretedMotion> {
        let motions = understood(program, text).into_iter().map(|told| match told {
            Interpreted::Motion(motion) => motion,
            Interpreted::LeftAlone { line, reason, .. } => panic!("line {line}: {reason}"),
        });
        motions.collect()
    }

    fn stated() -> ProgramSetup {
        ProgramSetup { apply_errors: false, ..ProgramSetup::in_mm(&Setup::default()) }
    }

    #[test]
    fn what_is_known_is_told_and_what_is_not_is_left_out() {
        let found = motions(&stated(), "G90 G0 Z50\nX10 Y20\nA30 C40\nG1 X11 F500\nG20 G1 X1 F10\n");
        assert_eq!(found[0].joints, [None, None, Some(50.0), None, None]);
        assert_eq!((found[0].tip_mm, found[0].axis, found[0].feed_mm_per_min), (None, None, None));
        assert_eq!(found[1].joints, [Some(10.0), Some(20.0), Some(50.0), None, None]);
        assert_eq!(found[1].tip_mm, None);
        assert!(found[2].tip_mm.is_some() && found[2].axis.is_some());
        assert_eq!((found[3].kind, found[3].feed_mm_per_min), (InterpretedKind::Linear, Some(500.0)));
        assert_eq!((found[4].joints[0], found[4].feed_mm_per_min), (Some(25.4), Some(254.0)));
    }

    #[test]
    fn tips_need_an_offset_only_where_an_axis_stands_off_zero() {
        let unstated = ProgramSetup { work_offsets: std::sync::Arc::default(), ..stated() };
        let found =
            motions(&unstated, "G90 G0 X1 Y2 Z3 A0 C0\nG1 X2 F100\nC10\nG43.4 H1 X0 Y0 Z0 A0 C0\nX5 C20\n");
        assert_eq!(found[1].tip_mm, Some([2.0, 2.0, 3.0]));
        assert_eq!((found[2].tip_mm, found[2].axis.is_some()), (None, true));
        assert_eq!(found[4].tip_mm, Some([5.0, 0.0, 0.0]));
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "coordinates that are exact")]
    fn arcs_tell_their_centre_and_how_far_they_run() {
        let text = "G90 G0 X10 Y0 Z0 A0 C0\nG3 X0 Y10 I-10 J0 F100\nG2 X0 Y10 Z4 I0 J-10\nG18 G3 X0 Z14 R5\n";
        let arcs: Vec<_> = motions(&stated(), text)[1..].iter().map(|motion| motion.arc.unwrap()).collect();
        assert_eq!(arcs[0].centre_mm, [0.0; 3]);
        assert_eq!((arcs[0].normal, arcs[0].turns), ([0.0, 0.0, 1.0], 0.25));
        assert_eq!((arcs[1].normal, arcs[1].turns), ([-0.0, -0.0, -1.0], 1.0));
        assert_eq!((arcs[2].normal, arcs[2].turns), ([0.0, 1.0, 0.0], 0.5));
        assert_eq!(arcs[2].centre_mm, [0.0, 10.0, 9.0]);
    }

    #[test]
    fn an_arc_up_to_a_share_is_the_arc_that_ends_there() {
        // A helix with the table turned: 210 degrees about its centre, up by 7.
        let words = |turned_deg: f64, height_mm: f64| {
            let (sin, cos) = trig::sin_cos(turned_deg.to_radians());
            format!("X{:.12} Y{:.12} Z{height_mm:.12}", 20.0 + 10.0 * cos, -5.0 + 10.0 * sin)
        };
        let start = format!("G90 G17 G1 A30 C40 F100\n{}\n", words(0.0, 3.0));
        let arc = |share: f64| {
            let text = format!("{start}G3 {} I-10 J0\n", words(210.0 * share, 3.0 + 7.0 * share));
            *motions(&stated(), &text).last().unwrap()
        };
        let whole = arc(1.0);
        for share in [0.1, 0.5, 0.99, 1.0] {
            let (until, ends) = (whole.until(share).unwrap(), arc(share));
            let values = |motion: &InterpretedMotion| {
                let joints = motion.joints.map(Option::unwrap);
                [&joints[..], &motion.tip_mm.unwrap(), &motion.axis.unwrap()].concat()
            };
            for (one, other) in values(&until).into_iter().zip(values(&ends)) {
                assert!((one - other).abs() < 1e-9, "{share}: {until:?} {ends:?}");
            }
        }
        assert_eq!(motions(&stated(), &start)[1].until(0.5), None);
    }

    #[test]
    fn tools_and_offsets_go_with_the_motions() {
        let text = "G54 T5 M6\nG0 X0 Y0 Z0 A0 C0\nG55 G0 X1 Y1 Z1 A0 C10\nG52 X1\nG1 X2 Y2 Z2 A0 C0 F1\nM98 P1\nG1 X9\n";
        let all = understood(&stated(), text);
        let of = |index: usize| match all[index] {
            Interpreted::Motion(motion) => (motion.tool, motion.work_offset, motion.tip_mm.is_some()),
            Interpreted::LeftAlone { .. } => panic!("motion {index} is left alone"),
        };
        let five = CalledTool::Changed(crate::motion::ToolKey::Number(5));
        assert_eq!(of(0), (five, Some(WorkOffset::G54), true));
        // Nobody states G55.
        assert_eq!(of(1), (five, Some(WorkOffset::Code(crate::motion::OffsetCode::new(55, 0))), false));
        assert!(
            matches!(all[3], Interpreted::LeftAlone { line: 6, reason: Unfollowable::Call, .. }),
            "{:?}",
            all[3]
        );
    }
}
