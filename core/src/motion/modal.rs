//! The modal state of a control. `None` is an unknown value.

use super::cycle::{Cycle, HoleCycle, PointCycle};
use super::plane::TiltedPlane;
use super::radius::Radius;
use super::sections::behind;
use super::{FeedMode, ModalGroup, Spindle, Unfollowable, WorkOffset};
use crate::geometry::Turn;

/// The motion group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MotionMode {
    Rapid,
    Linear,
    Arc,
    Cycle,
    Spline,
    Thread,
    Probing,
}

/// The tool length group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ToolLength {
    /// No length, or a length along Z.
    Plain,
    /// Tool-centre-point control with rotary words.
    Tcp,
    /// The same with a tool vector.
    Vector,
    /// A transformation of the control other than the one that the profile describes.
    OtherTcp,
}

/// Coordinate transformations, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Transformation {
    Rotation,
    Scaling,
    Mirror,
    PolarWords,
    PolarInterpolation,
    Cylinder,
    /// A tilted working plane of a conversational program.
    Tilt,
    /// The tool points along an axis other than Z.
    ToolAxis,
    /// TOROT, TOFRAME.
    ToolFrame,
    /// PAROT.
    PartFrame,
    /// CYCLE800.
    Swivel,
    /// PTP.
    PointToPoint,
    /// The tool axis has a course of its own.
    Orientation,
    /// DIAMON.
    Diameter,
    /// Cycle 26 of a conversational program: each axis has its own scale.
    AxisScaling,
    /// G54.2: an offset that follows the table.
    FixtureOffset,
    /// G54.4: compensation of the error of a set-up.
    SetupError,
}

/// The axis across G17: Z.
pub(super) const ACROSS_G17: u8 = 2;
/// How many transformations there are.
const TRANSFORMATIONS: usize = 17;

/// The present value of F.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ModalFeed {
    /// No F word so far.
    NeverGiven,
    /// An F word was or may have been given, but its number does not hold here.
    Unknown,
    /// As written, and its decimals.
    Given(f64, u8),
}

/// All modal values except positions.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "independent modes")]
pub(super) struct Modal {
    pub(super) motion: Option<MotionMode>,
    pub(super) plane: Option<u8>,
    pub(super) incremental: Option<bool>,
    pub(super) mm_per_unit: Option<f64>,
    feed_mode: Option<FeedMode>,
    pub(super) compensation: Option<bool>,
    /// What is known of it.
    pub(super) radius: Radius,
    pub(super) tool_length: Option<ToolLength>,
    /// M428 to M430 since the last G43.4, G43.5 or G49, or M138, and the caller has not stated their meaning.
    pub(super) kinematics_switched: bool,
    /// By [`Transformation`].
    pub(super) transformations: [Option<bool>; TRANSFORMATIONS],
    pub(super) macro_call: Option<bool>,
    /// Axes that G51.1 has mirrored and axes that cycle 26 scales, as bits. All bits are set if the axes are not
    /// known.
    pub(super) mirrored_axes: u32,
    pub(super) scaled_axes: u32,
    /// The work offset in force.
    pub(super) work_offset: Option<WorkOffset>,
    /// The tool in the spindle, and the tool that is made ready.
    pub(super) spindle: Spindle,
    /// Changes when G92, G52 or G10 moves an offset.
    pub(super) shifts: u32,
    /// The offset that TRANS and ATRANS add to the words X Y Z \[mm\].
    pub(super) program_offset_mm: Option<[f64; 3]>,
    /// The turn of the programmable frame, if ROT and AROT have turned it by known angles and its motions are followed.
    pub(super) turn: Option<Turn>,
    /// The tilted plane, if its definition is understood.
    pub(super) tilt: Option<TiltedPlane>,
    /// The D number of the tool's edge, if it decides the tool's length.
    pub(super) edge: Option<f64>,
    /// The H number of the tool's length in ISO programs.
    pub(super) length_number: Option<f64>,
    /// A tool length has been in force, so that the work offset is that of words with a length.
    pub(super) had_length: bool,
    /// G43: a tool length is in force since the last G49.
    pub(super) length_on: bool,
    /// G49: no tool length is in force.
    pub(super) has_no_length: bool,
    /// The program changes lengths of tools: DL, G10.
    pub(super) writes_lengths: bool,
    /// The program changes radii of tools: G10 with R.
    pub(super) writes_radii: bool,
    /// RNDM: the control rounds every corner.
    pub(super) rounds_corners: bool,
    /// ORIMKS: tool vectors are in machine coordinates.
    pub(super) vectors_in_machine: bool,
    /// M83.
    pub(super) relative_extruder: bool,
    /// G61: the machine stops at the end of every block.
    pub(super) exact_stop: bool,
    pub(super) feed: ModalFeed,
    /// The datum shift of a conversational program \[mm\].
    pub(super) datum_mm: [Option<f64>; 3],
    /// M126: rotary axes take the shorter way.
    pub(super) shortest_path: bool,
    /// M116: F of rotary axes counts millimetres along a circle that the text does not state.
    pub(super) rotary_feed_in_mm: bool,
    /// A call or a code that is not known may have changed what no code states again.
    pub(super) is_lost: bool,
    /// How the next point of a cutter location program is reached.
    pub(super) next_motion: Option<MotionMode>,
    /// The canned cycle under way.
    pub(super) cycle: Cycle,
    /// The cycle of one hole that is defined, and whether it runs at the end of every motion.
    pub(super) hole: Option<HoleCycle>,
    pub(super) hole_at_motions: bool,
    /// The program's points are points of a cycle.
    pub(super) in_cycle: bool,
    /// How it drills at its points, if that is known.
    pub(super) point_cycle: Option<PointCycle>,
    /// `TRNTYP/WORLD`: points count in one system, whatever system a set-up states.
    pub(super) points_in_world: bool,
    /// MULTAX/ON: a tool axis that is left out does not change.
    pub(super) multax: bool,
    /// A point has stated the tool axis since TLAXIS.
    pub(super) axis_stated: bool,
}

impl Modal {
    /// A start without G0: G90 G94 G17 G40 G49, no unit, no named work offset, no transformation, no motion mode.
    pub(super) const START: Self = Self {
        motion: None,
        plane: Some(2),
        incremental: Some(false),
        mm_per_unit: None,
        feed_mode: Some(FeedMode::PerMinute),
        compensation: Some(false),
        radius: Radius::START,
        tool_length: Some(ToolLength::Plain),
        kinematics_switched: false,
        transformations: [Some(false); TRANSFORMATIONS],
        macro_call: Some(false),
        mirrored_axes: 0,
        scaled_axes: 0,
        work_offset: Some(WorkOffset::Unnamed),
        spindle: Spindle::START,
        shifts: 0,
        is_lost: false,
        program_offset_mm: Some([0.0; 3]),
        turn: None,
        tilt: None,
        edge: None,
        length_number: None,
        had_length: false,
        length_on: false,
        has_no_length: false,
        writes_lengths: false,
        writes_radii: false,
        rounds_corners: false,
        vectors_in_machine: false,
        relative_extruder: false,
        exact_stop: false,
        feed: ModalFeed::NeverGiven,
        datum_mm: [Some(0.0); 3],
        shortest_path: false,
        rotary_feed_in_mm: false,
        next_motion: None,
        cycle: Cycle::NONE,
        hole: None,
        hole_at_motions: false,
        in_cycle: false,
        point_cycle: None,
        points_in_world: false,
        multax: false,
        axis_stated: false,
    };

    /// Forgets what a call may change. Subprograms may leave a rotation or a tilted plane active, so G69 has to end
    /// it. Scaling, mirror, polar words and modal calls are assumed to be as before.
    pub(super) fn forget(&mut self) {
        self.motion = None;
        self.plane = None;
        self.incremental = None;
        self.mm_per_unit = None;
        self.feed_mode = None;
        self.compensation = None;
        self.radius.forget();
        self.tool_length = None;
        self.transformations[Transformation::Rotation as usize] = None;
        self.transformations[Transformation::Tilt as usize] = None;
        self.work_offset = None;
        self.spindle.pass_call();
        self.program_offset_mm = None;
        self.edge = None;
        (self.length_number, self.has_no_length, self.length_on) = (None, false, false);
        self.feed = ModalFeed::Unknown;
        self.cycle = Cycle::NONE;
        self.hole = None;
        self.point_cycle = None;
        self.points_in_world = false;
        self.turn = None;
        self.tilt = None;
    }

    /// Forgets what a call in a conversational program may change. Units, the sense of words and feeds are those of
    /// the program. Radius compensation, TCP, tilted planes, rotations and datum shifts may be others.
    pub(super) fn forget_conversational(&mut self) {
        let before = *self;
        self.forget();
        self.mm_per_unit = before.mm_per_unit;
        self.incremental = before.incremental;
        self.feed_mode = before.feed_mode;
        // Offsets and edges of Sinumerik programs.
        (self.program_offset_mm, self.edge) = (before.program_offset_mm, before.edge);
        self.transformations[Transformation::Tilt as usize] = None;
        self.datum_mm = [None; 3];
    }

    /// Whether the zero may be elsewhere than in the work offset in force, or the work offset itself is not known.
    pub(super) fn is_shifted(&self) -> bool {
        let has_datum = self.datum_mm.iter().any(|shift| shift.is_none_or(|shift| shift.abs() > 0.0));
        self.shifts > 0 || has_datum || self.work_offset.is_none()
    }

    /// How F counts; `None` if this is not known.
    pub(super) const fn feed_mode(&self) -> Option<FeedMode> {
        self.feed_mode
    }

    /// Sets how F counts from here on, `None` if it is not known. If F counted in another way before, its number has
    /// no meaning now.
    pub(super) fn count_feed(&mut self, mode: Option<FeedMode>) {
        if mode.is_none() || self.feed_mode != mode {
            self.void_feed();
        }
        self.feed_mode = mode;
    }

    /// Another unit or sense of F. The present number has no meaning now.
    pub(super) fn void_feed(&mut self) {
        if self.feed != ModalFeed::NeverGiven {
            self.feed = ModalFeed::Unknown;
        }
    }

    /// The state after a section of the program that is called here. It follows from the section's effect on the
    /// program's state and on another state.
    pub(super) fn behind(&self, program: [&Self; 2], stranger: [&Self; 2]) -> Self {
        macro_rules! each {
            ($($field:ident),*) => {
                Self { $($field: behind(
                    self.$field,
                    program.map(|state| state.$field),
                    stranger.map(|state| state.$field),
                ),)* transformations: std::array::from_fn(|i| behind(
                    self.transformations[i],
                    program.map(|state| state.transformations[i]),
                    stranger.map(|state| state.transformations[i]),
                )),
                // Sections are not passed while a program is followed as it runs, and only then are these followed.
                cycle: Cycle::NONE,
                hole: None,
                hole_at_motions: false,
                point_cycle: None,
                points_in_world: self.points_in_world,
                turn: None,
                tilt: None,
                radius: Radius::START,
                // Every shift counts: after a second call the offset has changed once more.
                shifts: self.shifts.saturating_add(stranger[1].shifts.saturating_sub(stranger[0].shifts)) }
            };
        }
        each!(
            motion,
            plane,
            incremental,
            mm_per_unit,
            feed_mode,
            compensation,
            tool_length,
            kinematics_switched,
            macro_call,
            mirrored_axes,
            scaled_axes,
            work_offset,
            spindle,
            relative_extruder,
            feed,
            datum_mm,
            shortest_path,
            next_motion,
            in_cycle,
            multax,
            axis_stated,
            program_offset_mm,
            edge,
            length_number,
            had_length,
            length_on,
            has_no_length,
            writes_lengths,
            writes_radii,
            rounds_corners,
            vectors_in_machine,
            exact_stop,
            rotary_feed_in_mm,
            is_lost
        )
    }

    /// The values that are the same whether a block was executed or skipped.
    pub(super) fn common(&self, skipped: &Self) -> Self {
        fn same<T: PartialEq + Copy>(a: Option<T>, b: Option<T>) -> Option<T> {
            if a == b { a } else { None }
        }
        Self {
            motion: same(self.motion, skipped.motion),
            plane: same(self.plane, skipped.plane),
            incremental: same(self.incremental, skipped.incremental),
            mm_per_unit: same(self.mm_per_unit, skipped.mm_per_unit),
            feed_mode: same(self.feed_mode, skipped.feed_mode),
            compensation: same(self.compensation, skipped.compensation),
            radius: self.radius.common(skipped.radius),
            tool_length: same(self.tool_length, skipped.tool_length),
            kinematics_switched: self.kinematics_switched || skipped.kinematics_switched,
            transformations: std::array::from_fn(|i| {
                same(self.transformations[i], skipped.transformations[i])
            }),
            macro_call: same(self.macro_call, skipped.macro_call),
            mirrored_axes: self.mirrored_axes | skipped.mirrored_axes,
            scaled_axes: self.scaled_axes | skipped.scaled_axes,
            work_offset: same(self.work_offset, skipped.work_offset),
            spindle: self.spindle.common(&skipped.spindle),
            // A shift that may have happened counts as a shift.
            shifts: self.shifts,
            program_offset_mm: same(self.program_offset_mm, skipped.program_offset_mm),
            turn: same(self.turn, skipped.turn),
            tilt: same(self.tilt, skipped.tilt),
            edge: same(self.edge, skipped.edge),
            length_number: same(self.length_number, skipped.length_number),
            had_length: self.had_length || skipped.had_length,
            length_on: self.length_on && skipped.length_on,
            has_no_length: self.has_no_length && skipped.has_no_length,
            writes_lengths: self.writes_lengths || skipped.writes_lengths,
            writes_radii: self.writes_radii || skipped.writes_radii,
            rotary_feed_in_mm: self.rotary_feed_in_mm || skipped.rotary_feed_in_mm,
            rounds_corners: self.rounds_corners || skipped.rounds_corners,
            vectors_in_machine: self.vectors_in_machine || skipped.vectors_in_machine,
            relative_extruder: self.relative_extruder || skipped.relative_extruder,
            exact_stop: self.exact_stop || skipped.exact_stop,
            is_lost: self.is_lost || skipped.is_lost,
            feed: if self.feed == skipped.feed { self.feed } else { ModalFeed::Unknown },
            datum_mm: std::array::from_fn(|i| same(self.datum_mm[i], skipped.datum_mm[i])),
            shortest_path: self.shortest_path || skipped.shortest_path,
            cycle: self.cycle.common(skipped.cycle),
            hole: same(self.hole, skipped.hole),
            hole_at_motions: self.hole_at_motions || skipped.hole_at_motions,
            point_cycle: self.point_cycle.filter(|cycle| skipped.point_cycle == Some(*cycle)),
            ..*self
        }
    }

    /// Why no motion can be followed in this state besides the turn of its frame.
    pub(super) fn obstacle_beside_turn(&self) -> Option<Unfollowable> {
        let mut straight = *self;
        straight.transformations[Transformation::Rotation as usize] = Some(false);
        straight.obstacle()
    }

    /// Why no motion can be followed in this state, whatever the motion.
    pub(super) fn obstacle(&self) -> Option<Unfollowable> {
        let unknown = |group| Some(Unfollowable::ModeUnknown { group });
        if self.is_lost {
            return Some(Unfollowable::StateLost);
        }
        if self.macro_call != Some(false) {
            return Some(Unfollowable::ModalCall);
        }
        if let Some(plane) = self.tilt.as_ref().filter(|_| self.is_tilted()) {
            return Some(plane.obstacle());
        }
        if self.transformations[Transformation::Tilt as usize] == Some(true) {
            return Some(Unfollowable::TiltedPlane);
        }
        if self.transformations.contains(&Some(true)) {
            return Some(Unfollowable::Transformation);
        }
        if self.transformations.contains(&None) {
            return unknown(ModalGroup::Transformation);
        }
        match self.compensation {
            Some(false) => {}
            // Its path is computed from the motions of the program.
            Some(true) if self.radius.beside_mm.is_some() => {}
            Some(true) => return Some(Unfollowable::CutterCompensation),
            None => return unknown(ModalGroup::CutterCompensation),
        }
        if self.rounds_corners {
            return Some(Unfollowable::Corner);
        }
        if self.kinematics_switched {
            return Some(Unfollowable::KinematicsSwitched);
        }
        match self.tool_length {
            Some(ToolLength::Vector) => return Some(Unfollowable::ToolVector),
            Some(ToolLength::OtherTcp) => return Some(Unfollowable::OtherTransformation),
            Some(_) => {}
            None => return unknown(ModalGroup::ToolLength),
        }
        if self.incremental.is_none() {
            return unknown(ModalGroup::Distance);
        }
        if self.mm_per_unit.is_none() {
            return unknown(ModalGroup::Units);
        }
        if self.feed_mode.is_none() {
            return unknown(ModalGroup::FeedMode);
        }
        None
    }
}
