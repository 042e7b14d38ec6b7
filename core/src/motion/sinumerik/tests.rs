//! Small Sinumerik programs: motions, frames, tools and what is refused. Every number was computed by hand.

mod values {
    mod tests;
}

use crate::machine::{Machine, Preset};
use crate::motion::{
    ArcCourse, FeedMode, Interpolation, Interpreter, InterpreterOptions, Motion, MotionKind, Unfollowable,
};
use crate::program::{Address, Batch, Diagnostics, Dialect, Keyword, ReadLimits, Reader, Severity, Word};

/// Digits that sums and products of the control's functions lose [mm].
const EXACT_MM: f64 = 1e-12;

/// A and C tables through the origin, no limits.
fn machine() -> Machine {
    let mut parts = Preset::by_id("ac-table").unwrap().parts();
    parts.rotary_axes[0].travel_deg = None;
    Machine::new(parts).unwrap()
}

fn read(text: &str) -> Vec<Batch> {
    let mut reader = Reader::new(Some(Dialect::Siemens), ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let (mut batch, mut batches) = (Batch::new(), Vec::new());
    while reader.next_batch(&mut batch).unwrap() {
        batches.push(batch.clone());
    }
    batches
}

fn interpreted(text: &str) -> (Interpreter, Vec<Motion>, Diagnostics) {
    let mut interpreter = Interpreter::new(&machine(), InterpreterOptions::in_mm());
    let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
    for mut batch in read(text) {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    (interpreter, motions, diagnostics)
}

/// The motions after a line that makes all five axes known at zero.
fn run(text: &str) -> Vec<Motion> {
    interpreted(&format!("G0 X0 Y0 Z0 A0 C0\n{text}")).1.split_off(1)
}

fn linear(motion: &Motion) -> Option<[f64; 3]> {
    motion.end.map(|end| end.linear_mm)
}

#[track_caller]
fn assert_ends(text: &str, expected: &[[f64; 3]]) {
    let motions = run(text);
    let ends: Vec<_> = motions.iter().map(linear).collect();
    assert_eq!(ends.len(), expected.len(), "{text}: {ends:?}");
    for (end, expected) in ends.iter().zip(expected) {
        let end = end.unwrap_or_else(|| panic!("{text}: {ends:?}"));
        let near = end.iter().zip(expected).all(|(a, b)| (a - b).abs() <= EXACT_MM * b.abs().max(1.0));
        assert!(near, "{text}: {ends:?}");
    }
}

#[test]
fn names_that_the_program_does_not_declare_may_be_axes() {
    // E1 and ELX are not among the machine's five axes. X1 and XH may be.
    let motions = run("G1 X1 ELX=5 F100\nX2\nX1=7\nX3\nXH=8\nX4\n");
    let left: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    let odd = Some(Unfollowable::ControlWord);
    assert_eq!(left, [odd, None, odd, None, odd, None]);
    let known: Vec<_> = motions.iter().map(|motion| motion.end.is_some()).collect();
    assert_eq!(known, [true, true, false, false, false, false]);
}

#[test]
fn programmable_offsets_are_told_and_keep_places_apart() {
    let motions = run("G1 X1 Y1 F100\nTRANS X100 Y2\nX1 Y1 Z0\nATRANS X50 Y2\nX1 Y1 Z0\nTRANS\nX5 Y5 Z5\n");
    let offsets: Vec<_> = motions.iter().map(|motion| motion.program_offset_mm).collect();
    assert_eq!(offsets, [Some([0.0; 3]), Some([100.0, 2.0, 0.0]), Some([150.0, 4.0, 0.0]), Some([0.0; 3])]);
    let changed: Vec<_> = motions.iter().map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [false, true, true, false]);
    assert!(motions[1].start.is_none() && linear(&motions[1]) == Some([1.0, 1.0, 0.0]));
    // After a rotation the axis positions are not known, and neither is an offset along turned axes.
    let motions = run("ROT Z30\nG1 X1 Y1 Z0 F100\nATRANS X5\nX2\nROT\nX1 Y1 Z1\nROT RPL=45\nX2\nTRANS\nX1\n");
    let left: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    let turned = Some(Unfollowable::Transformation);
    assert_eq!(left, [turned, turned, None, turned, None]);
    assert_eq!(motions[1].program_offset_mm, None);
    assert!(motions[2].end.is_none(), "rotary axes were forgotten with the offset");
}

#[test]
fn frames_that_are_not_there_may_be_taken_back() {
    let motions = run("MCALL\nG0 X0 Y0 Z0 A0 C0\nROT\nTRANS\nTRAFOOF\nCYCLE800()\nG1 X1 F100\n");
    assert!(motions[1].start.is_some() && motions[1].unfollowable.is_none());
}

#[test]
fn traori_interpolates_the_tip() {
    let motions = run("TRAORI\nG1 X1 Y1 Z1 F100\nX2\nTRAORI\nX3\nTRAFOOF\nX4\n");
    let tip: Vec<_> = motions.iter().map(|motion| motion.interpolation).collect();
    assert_eq!(tip, [Interpolation::Tcp, Interpolation::Tcp, Interpolation::Tcp, Interpolation::Machine]);
    let known: Vec<_> = motions.iter().map(|motion| motion.start.is_some()).collect();
    assert_eq!(known, [false, true, true, false]);
    let motions = run("TRAORI(1)\nG1 X1 F100\nTRACYL(40)\nX2\nTRAFOOF\nG0 X0 Y0 Z0 A0 C0\nX2\n");
    let left: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    assert_eq!(left, [None, Some(Unfollowable::Transformation), None, None]);
}

#[test]
fn another_transformation_than_the_first_is_left_alone_until_it_is_off() {
    let other = Some(Unfollowable::OtherTransformation);
    for on in ["TRAORI(2)", "TRAORI(R1)", "TRAORI(1,0,1,1)", "TRAORI(,,,,5,5)", "traori( 2 )"] {
        for off in ["TRAFOOF", "TRAORI", "TRAORI()", "TRAORI(1)"] {
            let before = "TRAORI\nG1 X1 Y1 Z1 A0 C0 F100\n";
            let motions = run(&format!("{before}{on}\nX2\nX3 A3=0 B3=0 C3=1\n{off}\nX4 Y4 Z4 A1 C1\nX5\n"));
            let left: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
            assert_eq!(left, [None, other, other, None, None], "{on} {off}");
            // When it ends, the position of the tip is not known. The modes are as before.
            assert!(motions[3].start.is_none() && motions[4].start.is_some(), "{on} {off}");
            assert_eq!(motions[4].feed.value, Some(100.0));
        }
    }
}

#[test]
fn arcs_with_further_turns_are_followed_to_their_ends() {
    use ArcCourse::{Carried, Centre};
    let turns = |block: &str| {
        let motions = run(&format!("G17 G0 X10 Y0 Z0\nR2=3 R3=0.5\nG2 G90 {block}\nG1 X0 F100\n"));
        assert_eq!(motions.len(), 3, "{block}");
        assert_eq!(motions[2].start, motions[1].end, "{block}");
        assert_eq!(motions[2].unfollowable, None, "{block}");
        (motions[1].kind, motions[1].further_turns, motions[1].unfollowable, motions[1].arc)
    };
    let arc = MotionKind::Arc;
    for (block, expected) in [
        ("X0 Y10 Z-1 I-10 J0 TURN=0", (arc, Some(0), None, Carried)),
        ("X0 Y10 Z-1 I-10 J0 TURN=2", (arc, Some(2), None, Carried)),
        ("X0 Y10 Z-1 CR=10 TURN = 12", (arc, Some(12), None, Carried)),
        ("X0 Y10 Z-1 CR=10 TURN=R2", (arc, Some(3), None, Carried)),
        ("X0 Y10 Z-1 I-10 J0", (arc, None, None, Carried)),
        // A centre that is a place stays at its position when the ends move.
        ("X10 Y0 Z-1 I=AC(0) J=AC(0) TURN=1", (arc, Some(1), None, Centre)),
        ("X10 Y0 Z-1 I=AC(0) J=IC(0)", (arc, None, None, Centre)),
    ] {
        assert_eq!(turns(block), expected, "{block}");
    }
    // A value that is not a number of circles, and circles in a straight line.
    let odd = Some(Unfollowable::ControlWord);
    for block in [
        "X0 Y10 Z-1 I-10 J0 TURN=.5",
        "X0 Y10 Z-1 I-10 J0 TURN=-1",
        "X0 Y10 Z-1 I-10 J0 TURN=1000",
        "X0 Y10 Z-1 I-10 J0 TURN=R3",
        "X0 Y10 Z-1 I-10 J0 TURN=R99",
    ] {
        assert_eq!(turns(block), (arc, None, odd, Carried), "{block}");
    }
    let straight = run("G1 X0 Y10 TURN=1 F100\n");
    assert_eq!((straight[0].kind, straight[0].unfollowable), (MotionKind::Linear, odd));
}

#[test]
fn an_argument_in_brackets_stays_with_its_m_code() {
    let text = "G1 X1 F100\nN20 M202(0.0059)\nX2 M202(0.5,(3)) Y1\nX3 M203 (7) H5(1)\nX4 M=8(1)\nX5\n";
    assert_eq!(interpreted(text).2.kept(), []);
    let (motions, batch) = (run(text), read(text).remove(0));
    assert!(motions.len() == 5 && motions.iter().all(|motion| motion.unfollowable.is_none()));
    assert_eq!(linear(&motions[4]), Some([5.0, 1.0, 0.0]));
    let texts: Vec<&[u8]> = batch
        .blocks()
        .iter()
        .flat_map(|block| batch.words(block))
        .filter(|word| matches!(word.address, Address::M | Address::H))
        .map(|word| batch.word_text(word))
        .collect();
    assert_eq!(texts, [&b"M202(0.0059)"[..], b"M202(0.5,(3))", b"M203 (7)", b"H5(1)", b"M=8(1)"]);
    // Words of axes have no arguments, and a bracket must be closed.
    for text in ["G1 X(5)\n", "M202(0.5\n", "G1(5)\n"] {
        let (_, _, diagnostics) = interpreted(text);
        assert_eq!(diagnostics.count(Severity::Refusal), 1, "{text}");
    }
}

#[test]
fn machine_coordinates_hold_in_their_block_only() {
    for code in ["SUPA", "G53", "G153"] {
        let motions = run(&format!("{code} G0 Z5 D0\nG0 Z1\n"));
        assert_eq!(motions[0].unfollowable, Some(Unfollowable::MachineCoordinates), "{code}");
        assert!(motions[0].end.is_none() && motions[1].unfollowable.is_none(), "{code}");
    }
}

#[test]
fn another_tool_or_edge_is_another_length() {
    let motions = run("D1 G0 X1 Y1 Z1\nX2 D1\nX3 D2\nX4 Y4 Z4\nT2\nX5\n");
    let known: Vec<_> = motions.iter().map(|motion| motion.end.is_some()).collect();
    assert_eq!(known, [true, true, false, true, false]);
}

#[test]
fn cycles_and_calls_are_left_alone() {
    let cycle = Some(Unfollowable::CannedCycle);
    let motions = run(
        "CYCLE81(10,0,2,,5)\nG0 X0 Y0 Z0 A0 C0\nX1\nMCALL CYCLE83(10,0,2,-20)\nX2\nMCALL\nG0 X0 Y0 Z0 A0 C0\nX1\n",
    );
    let left: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    assert_eq!(left, [cycle, None, None, Some(Unfollowable::ModalCall), None, None]);
    // Modes stay after a standard cycle and are unknown after a call. A statement without an effect on the path is not
    // a motion.
    let (_, motions, diagnostics) = interpreted(
        "G0 X0 Y0 Z0 A0 C0\nCYCLE832(0.02,1,1)\nCYCLE800()\nSTOPRE\nMSG(\"N10 ; X5\")\nFFWON SOFT COMPCAD\nG1 X1 F100\nSUB_5 P3\nX2\n",
    );
    assert_eq!((motions.len(), diagnostics.count(Severity::Warning)), (4, 1));
    assert_eq!(motions[1].unfollowable, None);
    assert_eq!(motions[2].unfollowable, Some(Unfollowable::Call));
    assert!(motions[3].unfollowable.is_some() && motions[3].end.is_none());
    let motions = run("CYCLE800(1,\"TC1\",0,57,0,0,0,0,30,0,0,0,0,1)\nG1 X1 F100\nCYCLE800()\nX0 Y0 Z0\n");
    let left: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    assert_eq!(left, [Some(Unfollowable::Transformation), Some(Unfollowable::PlaneSolution), None]);
}

#[test]
fn control_flow_is_refused_with_its_line_and_labels_are_not() {
    for text in [
        "GOTOF END_",
        "N20 IF R1>5 GOTOB START_",
        "FOR R1=1 TO 5",
        "WHILE R1<5",
        "REPEAT START_ P=3",
        "LOOP",
        "CASE R1 OF 1 GOTOF A_ DEFAULT GOTOF B_",
        "N10REPEAT START_",
        "DEFINE FAST AS G0",
    ] {
        let (_, _, diagnostics) = interpreted(&format!("G0 X0\n{text}\n"));
        assert_eq!(diagnostics.refusals().map(|refusal| refusal.line).collect::<Vec<_>>(), [2], "{text}");
    }
    let (_, motions, diagnostics) = interpreted("G0 X0 Y0 Z0 A0 C0\nSTART_: G1 X5 F100\nN20 END_:\n");
    assert_eq!(diagnostics.kept(), []);
    assert_eq!(linear(&motions[1]), Some([5.0, 0.0, 0.0]));
}

#[test]
fn what_no_block_contains_is_refused_with_its_line() {
    for text in
        ["G0=10", "M1[10]=10", "G505_VAR=10", "X=", "X=(1+2", "X=5)", "(COMMENT)", "X--5", "R5", "MSG(\"A"]
    {
        let (_, _, diagnostics) = interpreted(&format!("G0 X0\n{text}\n"));
        assert_eq!(diagnostics.refusals().map(|refusal| refusal.line).collect::<Vec<_>>(), [2], "{text}");
    }
}

#[test]
fn units_feeds_and_offsets_are_those_of_the_control() {
    let motions = run("G70 G1 X1 F10\nG710 X1 F100\nG93 X2 F2\nG96 S100 X3 F.2\nG500 X4\nG54 X4\n");
    let x: Vec<_> = motions.iter().filter_map(linear).map(|end| end[0]).collect();
    assert!((x[0] - 25.4).abs() < 1e-12 && x[1..4] == [1.0, 2.0, 3.0]);
    let modes: Vec<_> = motions.iter().map(|motion| motion.feed.mode.unwrap()).collect();
    assert_eq!(modes[1..4], [FeedMode::PerMinute, FeedMode::InverseTime, FeedMode::PerRevolution]);
    assert!(motions[4].offset_changed && motions[4].end.is_none(), "the offset before it is not known");
    assert!(motions[5].offset_changed && motions[5].end.is_none());
    // F of a dwell is a separate time.
    let motions = run("G1 X1 F100\nG4 F2\nX2\n");
    assert_eq!(motions[1].feed.value, Some(100.0));
    let motions = run("G1 X1 F=R1\nR1=300\nF=R1*2\nX2\n");
    assert_eq!((motions[0].feed.value, motions[1].feed.value), (None, Some(600.0)));
}

#[test]
fn arcs_end_where_they_say_and_nowhere_else() {
    let motions = run(
        "G2 X10 Y0 CR=5 F100\nG3 X20 Y0 I=AC(15) J0\nCIP X30 Y0 Z0 I1=25 J1=5 K1=0\nG2 AR=90 I5\nG0 X0 Y0 Z0\nG1 AP=30 RP=10\n",
    );
    let kinds: Vec<_> = motions.iter().map(|motion| (motion.kind, motion.end.is_some())).collect();
    let (arc, opaque) = (MotionKind::Arc, MotionKind::Opaque);
    assert_eq!(
        kinds,
        [
            (arc, true),
            (arc, true),
            (opaque, false),
            (opaque, false),
            (MotionKind::Rapid, true),
            (opaque, false)
        ]
    );
}

#[test]
fn corners_splines_probes_and_other_words_leave_their_blocks_alone() {
    use Unfollowable::{ControlWord, Corner, Probing, Spline};
    for (text, reason) in [
        ("G1 X1 RND=2 F100\n", Corner),
        ("G1 X1 CHF=1 F100\n", Corner),
        ("RNDM=2\nG1 X1 F100\n", Corner),
        ("BSPLINE X1\n", Spline),
        ("MEAS=1 G1 X1 F100\n", Probing),
        ("G1 X1 FB=20\n", ControlWord),
        ("G1 POS[Q]=5 X1\n", ControlWord),
        ("G1 A2=10 B2=0 C2=5 F100\n", ControlWord),
        ("G1 ANG=30 X5\n", Corner),
    ] {
        let motions = run(text);
        assert_eq!(motions.last().and_then(|motion| motion.unfollowable), Some(reason), "{text}");
    }
    assert_eq!(run("RNDM=2\nG1 X1 F100\nRNDM=0\nX2\n")[1].unfollowable, None);
}

#[test]
fn programs_end_where_they_end() {
    for (text, ends) in
        [("M17\n", true), ("M30\n", true), ("RET\n", true), ("M2=3\n", false), ("M=QU(2)\n", true)]
    {
        let (interpreter, ..) =
            interpreted(&format!("%_N_PART_MPF\n;$PATH=/_N_MPF_DIR\nPROC PART SAVE\n{text}X5\n"));
        assert_eq!(interpreter.has_ended(), ends, "{text}");
    }
    let (interpreter, ..) = interpreted("%_N_PART_MPF\nG0 X0\n%_N_OTHER_SPF\nX5\n");
    assert_eq!(interpreter.end_line(), Some(3));
}

#[test]
fn assignments_are_told_from_words() {
    let mut batches = read("DEF REAL _X\n_X=-365. _Y=2 R1=4\nX1=3\n");
    let mut interpreter = Interpreter::new(&machine(), InterpreterOptions::in_mm());
    interpreter.interpret(&mut batches[0], &mut Vec::new(), &mut Diagnostics::new());
    let batch = &batches[0];
    let keywords =
        |index: usize| batch.words(&batch.blocks()[index]).iter().map(Word::keyword).collect::<Vec<_>>();
    assert_eq!(keywords(1), [Some(Keyword::Assigned); 3]);
    assert_eq!(keywords(2), [Some(Keyword::MachineAxis)]);
}
