//! Codes of Okuma OSP for machining centres. Some have the number of an ISO code but another meaning. G15 and G16
//! select work coordinate systems, G53 to G56 select tool lengths, G10 and G11 shift and turn the coordinates, and G71
//! sets a level.
//!
//! A code that is not in the table is not known, whatever it means in ISO programs.

use super::{MotionRules, ToolRules, ToolWords};
use crate::motion::meaning::{MFunction, Meaning};
use crate::motion::modal::{MotionMode, ToolLength, Transformation};
use crate::motion::{FeedForm, FeedMode, FeedRules};
use crate::program::{Address, Code};
use crate::units::MM_PER_INCH;

/// The meaning of OSP programs.
pub(super) const RULES: MotionRules = MotionRules {
    feed: FEED,
    g: g_meaning,
    m: m_function,
    tool_words: ToolWords::LengthByH,
    counts_points: true,
    two_codes_conflict: true,
    has_parallel_axes: true,
    has_extruder: false,
    unknown_is_final: true,
    tools: ToolRules { second_t_changes: true, ..ToolRules::CHANGED_BY_M6 },
    ..MotionRules::PLAIN
};

/// The meaning of F in OSP programs.
const FEED: FeedRules = FeedRules {
    paths: FeedRules::BY_MODE,
    form: FeedForm::Word,
    // G04 takes its time from F.
    dwell_may_set_feed: true,
    dwell_times: Address::X.bit() | Address::U.bit(),
    modes: &[(Code::G(940), FeedMode::PerMinute, None), (Code::G(950), FeedMode::PerRevolution, None)],
    otherwise: &[Code::G(200), Code::G(210)],
};

/// The meaning of a G code in tenths.
fn g_meaning(tenths: u32) -> Meaning {
    use Meaning::{
        Compensation, EndCycle, EndScaling, ExactStop, ExactStopHere, Feed, Incremental, LengthAlong, Motion,
        NoMotion, OffsetByH, OffsetByHHere, Plane, Reference, Shift, TipControlApart, Transform, Units,
        Unknown,
    };
    use MotionMode::{Arc, Cycle, Linear, Probing, Rapid};
    match tenths {
        0 => Motion(Rapid),
        10 => Motion(Linear),
        20 | 30 => Motion(Arc),
        // A dwell, the limits of the stroke, the level to which cycles return, and smoothing.
        40 | 220 | 230 | 710 | 1300 | 1310 => NoMotion,
        90 => ExactStopHere,
        610 => ExactStop(true),
        640 => ExactStop(false),
        // A shift and a rotation of the coordinates.
        100 => Transform(Transformation::PartFrame, false),
        110 => Transform(Transformation::PartFrame, true),
        150 => OffsetByH,
        160 => OffsetByHHere,
        170 => Plane(2),
        180 => Plane(1),
        190 => Plane(0),
        // The control stops if its unit is another one.
        200 => Units(MM_PER_INCH),
        210 => Units(1.0),
        300 => Reference,
        310 => Motion(Probing),
        400 => Compensation(false),
        410 | 420 => Compensation(true),
        500 => EndScaling,
        510 => Transform(Transformation::Scaling, true),
        530 => LengthAlong(None),
        540 => LengthAlong(Some(0)),
        550 => LengthAlong(Some(1)),
        560 => LengthAlong(Some(2)),
        // A frame in space. Sources differ in which of the two ends it, so neither does.
        680 | 690 => Transform(Transformation::Rotation, true),
        730 | 740 | 760 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 => Motion(Cycle),
        800 => EndCycle,
        900 => Incremental(false),
        910 => Incremental(true),
        920 => Shift,
        // The block goes to a place with the length in force, by its own words.
        1690 => TipControlApart(ToolLength::Tcp),
        1700 => TipControlApart(ToolLength::Plain),
        code => FEED.mode(Code::G(code)).map_or(Unknown, |(mode, _)| Feed(mode)),
    }
}

/// The meaning of an M code in tenths. Codes of the machine's builder are assumed to leave the path unchanged. The
/// codes here are in the table of the control itself.
fn m_function(tenths: u32) -> MFunction {
    match tenths {
        20 | 300 => MFunction::End,
        60 => MFunction::ToolChange,
        // From one spindle or attachment to another.
        660 | 670 | 700 | 710 | 770 | 1700 | 1710 | 1720 | 1730 | 1770 => MFunction::OtherSpindle,
        // The head turns to a side, and the way in which it turns.
        170 | 730 | 740 | 750 | 760 => MFunction::TurnsHead,
        // Pallets, and places of the axis W.
        600 | 1010..=1120 | 1600 | 1610 | 810..=850 | 1900..=1990 => MFunction::Elsewhere,
        // The direction in which a rotary axis turns to its words. No code takes it back.
        150 | 160 | 1150 | 1160 => MFunction::Unknown,
        _ => MFunction::Plain,
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values as the text has them, exact")]
mod tests {
    use crate::machine::{Machine, Preset};
    use crate::motion::{
        CalledTool, Interpolation, Interpreter, InterpreterOptions, Motion, Unfollowable, WorkOffset,
    };
    use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader};

    fn run(text: &str) -> (Vec<Motion>, Diagnostics) {
        let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
        let options = InterpreterOptions {
            start: [None, None, None, Some(0.0), Some(0.0)],
            ..InterpreterOptions::in_mm()
        };
        let mut interpreter = Interpreter::new(&machine, options);
        let mut reader = Reader::new(Some(Dialect::Okuma), ReadLimits::default());
        reader.feed(text.as_bytes());
        reader.finish();
        let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
        while reader.next_batch(&mut batch).unwrap() {
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
        }
        (motions, diagnostics)
    }

    fn motions(text: &str) -> Vec<Motion> {
        let (motions, diagnostics) = run(text);
        assert_eq!(diagnostics.kept(), [], "{text}");
        motions
    }

    /// A start with a length along Z and a known position.
    const BEGIN: &str = "$PART.MIN%\nOPART\nG15 H1\nT1 M6\nG90 G0 X0 Y0\nG56 Z50. H1\n";

    #[test]
    fn a_work_offset_is_named_by_h_and_a_length_by_g56_is_none() {
        let text = format!("{BEGIN}G1 X10. F500\nG15 H2\nG0 X0 Y0 Z0 A0 C0\nG56 Z5.\nG56 Z6. H2\nX1.\n");
        let all = motions(&text);
        let offsets: Vec<_> = all.iter().map(|motion| motion.work_offset).collect();
        let [first, second] = [1, 2].map(|number| Some(WorkOffset::by_h(number)));
        assert_eq!(offsets, [first, first, first, second, second, second, second]);
        // The length stays known if only the level changes. Another number is another length.
        assert_eq!(all[2].start.unwrap().linear_mm, [0.0, 0.0, 50.0]);
        assert!(all[4].start.is_some() && all[5].start.is_none());
        assert_eq!(all[6].end.unwrap().linear_mm, [1.0, 0.0, 6.0]);
        assert!(all[2].unfollowable.is_none() && !all[2].offset_changed);
    }

    #[test]
    fn the_number_of_an_offset_is_no_length() {
        // H2 of G15 is between H1 and H2 of G56. The length changes at the second G56.
        let all = motions(&format!("{BEGIN}G15 H2\nG0 X0 Y0 Z9. A0 C0\nG56 X1. H2\n"));
        assert!(all[2].end.is_some());
        assert!(all[3].start.is_none() && all[3].end.is_none(), "Z is elsewhere after another length");
    }

    #[test]
    fn an_offset_of_one_block_and_tools_along_other_axes_are_left_alone() {
        let all = motions(&format!("{BEGIN}G16 H0 G0 Z300.\nG0 Z50.\nG16 H3 X1.\nX2.\n"));
        assert_eq!(all[2].unfollowable, Some(Unfollowable::MachineCoordinates));
        assert_eq!((all[3].start, all[3].unfollowable), (None, None));
        assert_eq!(all[4].unfollowable, Some(Unfollowable::OffsetHere));
        assert!(all[4].end.is_none() && all[5].start.is_none());
        assert!(all.iter().all(|motion| motion.work_offset == Some(WorkOffset::by_h(1))));
        for code in ["G54", "G55"] {
            let all = motions(&format!("{BEGIN}{code} X5. H2\nG1 X6. F100\nG56 X0 Y0 Z5. H1\nX1.\n"));
            assert_eq!(all[3].unfollowable, Some(Unfollowable::Transformation), "{code}");
            assert_eq!(all[5].unfollowable, None, "{code}");
        }
    }

    #[test]
    fn levels_frames_and_axes_beside_the_five_are_no_motion_of_theirs() {
        // G71 is not a unit, and its Z is not a motion.
        let all = motions(&format!("{BEGIN}G71 Z100.\nG1 X5. F100\n"));
        assert_eq!(all[2].end.unwrap().linear_mm, [5.0, 0.0, 50.0]);
        let all = motions(&format!("{BEGIN}G11 X5. P30.\nG1 X5. F100\nG10\nX0 Y0 Z0\nX1.\n"));
        for frame in ["G68", "G69"] {
            let all = motions(&format!(
                "{BEGIN}{frame} X0 Y0 Z0 P30. Q0 R0\nG0 X5. Y0 Z5.\nG69\nG68\nX0 Y0 Z0\nX1.\n"
            ));
            assert!(all.iter().skip(2).all(|motion| motion.unfollowable.is_some()), "{frame}: {all:?}");
        }
        assert_eq!(all[3].unfollowable, Some(Unfollowable::Transformation));
        assert_eq!(all[5].unfollowable, None);
        // Z may count in another way after W moves to another place.
        let all = motions(&format!("{BEGIN}G0 W3.\nX5.\nX6. Z5.\nX7.\n"));
        assert!(all[2].end.is_none() && all[4].start.is_none(), "{all:?}");
    }

    #[test]
    fn the_tip_is_followed_behind_g169_and_its_own_block_is_left_alone() {
        let all = motions(&format!(
            "{BEGIN}G169 X0 Y0 Z400. A0 C0 H1\nG0 X1. Y1. Z60. A0 C0\nG1 X2. A5. F500\nG170\nG0 X0 Y0 Z90.\n"
        ));
        assert!(all[2].unfollowable.is_some() && all[2].end.is_none());
        assert_eq!((all[4].unfollowable, all[4].interpolation), (None, Interpolation::Tcp));
        assert_eq!(all[5].interpolation, Interpolation::Machine);
    }

    #[test]
    fn nothing_is_followed_after_a_code_or_a_call_that_no_code_takes_back() {
        let restated =
            "G21 G90 G17 G94 G40 G10 G50\nG15 H1\nG56 H1\nG170 X0 Y0 Z50. A0 C0\nG0 X0 Y0 Z50. A0 C0\n";
        for line in ["G62 X0", "G605", "CALL O100", "G1 X2. M16", "M115", "G0 C5. M15", "G445"] {
            let (all, _) = run(&format!("{BEGIN}{line}\n{restated}G1 X1. C20. F100\n"));
            assert_eq!(all.last().unwrap().unfollowable, Some(Unfollowable::StateLost), "{line}");
        }
        // Smoothing and limits of the stroke move nothing, and F of their block is no feed.
        for line in ["G131 F1000. J1 E0.01", "G130", "G22 X100. Y100. Z100. I0 J0 K0", "G23"] {
            let all = motions(&format!("{BEGIN}{line}\nG1 X1. A5. F100\n"));
            assert_eq!((all.len(), all[2].unfollowable), (3, None), "{line}");
            assert!(all[2].start.is_some() && all[2].end.is_some(), "{line}");
        }
    }

    #[test]
    fn the_control_s_own_m_codes_change_spindle_head_and_place() {
        for code in ["M66", "M67", "M70", "M77", "M173"] {
            let all = motions(&format!("{BEGIN}T2\n{code}\nG0 X0 Y0 Z50.\nG1 X1. F100\n"));
            assert!(matches!(all[3].tool, CalledTool::Unknown(_)), "{code}: {:?}", all[3].tool);
            assert_eq!(all[2].start, None, "{code}");
        }
        for code in ["M73", "M76", "M17"] {
            let all =
                motions(&format!("{BEGIN}{code}\nG0 X0 Y0 Z50.\nG56 H1\nG0 X0 Y0 Z50. A0 C0\nG1 X1. F100\n"));
            assert_eq!(all[2].unfollowable, Some(Unfollowable::Transformation), "{code}");
            assert_eq!((all[4].start.is_some(), all[4].unfollowable), (true, None), "{code}");
        }
        for code in ["M60", "M81", "M101", "M199"] {
            let all = motions(&format!("{BEGIN}{code}\nG1 X1. F100\n"));
            assert!(all.last().unwrap().start.is_none(), "{code}: the place is another one");
        }
    }

    #[test]
    fn the_machine_s_zero_is_no_work_offset_and_e_is_no_extruder() {
        let all = motions(&format!(
            "{BEGIN}G15 H0\nG0 X0 Y0 Z300. A0 C0\nG15 H1\nG0 X0 Y0 Z50. A0 C0\nG1 X1. F100\n"
        ));
        let offsets: Vec<_> = all.iter().skip(2).map(|motion| motion.work_offset).collect();
        assert_eq!(offsets, [None, Some(WorkOffset::by_h(1)), Some(WorkOffset::by_h(1))]);
        assert!(all[2].offset_changed && all[2].is_shifted);
        let all = motions(&format!("{BEGIN}G1 X5. E3. F100\nX6.\n"));
        assert_eq!((all[2].unfollowable, all[2].extra), (Some(Unfollowable::ControlWord), None));
        assert_eq!(all[3].unfollowable, None);
        // Two axes of the length in one block.
        let all = motions(&format!("{BEGIN}G53 G56 Z5. H1\nG1 X1. F100\n"));
        assert!(all.last().unwrap().unfollowable.is_some());
    }

    #[test]
    fn codes_of_other_controls_are_not_known_and_variables_are_refused() {
        for code in ["G43 H1", "G43.4 H1", "G54.1 P1", "G57", "G28 Z0", "G5.1 Q1", "G68.2 X0"] {
            let (all, diagnostics) = run(&format!("{BEGIN}{code}\nG1 X5. F100\n"));
            assert_eq!(diagnostics.kept().len(), 1, "{code}");
            assert!(all.last().unwrap().unfollowable.is_some(), "{code}");
        }
        let (_, diagnostics) = run(&format!("{BEGIN}VC1=5\nG1 X=VC1 F100\n"));
        assert_eq!(diagnostics.refusals().map(|refusal| refusal.line).collect::<Vec<_>>(), [7, 8]);
    }
}
