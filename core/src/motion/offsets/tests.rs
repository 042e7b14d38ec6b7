//! Which work offset is in force, and whether it is known.

use std::sync::Arc;

use super::tests::{end, run, run_with};
use super::*;

#[test]
fn work_offsets_lose_the_position_when_they_change() {
    let text = "G54\nG0 X1 Y1 Z1 A1 C1\nX1\nG55 X1 Y1 Z1 A1 C1\nX2\nG54 X1 Y1 Z1 A1 C1\nG54.1 P3\nX1\n";
    let motions = run(text);
    let changed: Vec<_> = motions.iter().map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [false, false, true, true, false, true]);
    assert!(motions[1].start.is_some() && motions[2].start.is_none() && motions[2].end.is_some());
    assert!(motions[5].end.is_none());
    let offsets: Vec<_> = motions.iter().filter_map(|motion| motion.work_offset).collect();
    let (g54, g55) = (WorkOffset::G54, WorkOffset::Code(OffsetCode::new(55, 0)));
    assert_eq!(offsets, [g54, g54, g55, g55, g54, WorkOffset::Numbered(OffsetCode::new(54, 1), 3)]);
}

#[test]
fn what_is_in_force_before_any_offset_is_named_counts_as_g54() {
    for (first, changed) in [("G54", [false, false, true]), ("G55", [false, true, false])] {
        let other = if first == "G54" { "G55" } else { "G54" };
        let motions = run(&format!("G0 X0 Y0 Z0 A0 C0\n{first}\nX1 Y1 Z1 A1 C1\n{other} X1 Y1 Z1 A1 C1\n"));
        let found: Vec<_> = motions.iter().map(|motion| motion.offset_changed).collect();
        assert_eq!(found, changed, "{first}");
        assert_eq!(motions[0].work_offset, Some(WorkOffset::Unnamed));
        assert!(motions[1].start.is_none(), "the places before are those of another zero perhaps");
    }
}

#[test]
fn a_shift_in_the_program_leaves_the_offset_unknown_also_before_the_first_motion() {
    let point = "G0 X1 Y1 Z1 A1 C1\nX2\n";
    let changed = |head: &str| {
        let motions = run(&format!("{head}\n{point}"));
        let found = motions.iter().filter(|motion| motion.end.is_some());
        found.map(|motion| motion.offset_changed).collect::<Vec<_>>()
    };
    for head in [
        "G52 X50. Y20.",
        "G52 C10.",
        "G92 X0 Y0 Z0",
        "G92 C0.",
        "G10 L2 P1 X100.",
        "G10 L20 P1 C10.",
        "#5221=100.",
        "G52",
        "G92",
        "G92.3",
        "G92.3 X0",
        "G52 X0 C1",
    ] {
        assert_eq!(changed(head), [true, true], "{head}");
    }
    for head in ["G92.1", "G92.2", "G52 X0 Y0 Z0", "G52 X0. A0. C0.", "G10 L10 P1 Z5.", "G92 S2000"] {
        assert_eq!(changed(head), [false, false], "{head}");
    }
    assert_eq!(changed("G52 X5\nG52 X0"), [true, true], "what was shifted stays unknown");
}

#[test]
fn stated_offsets_are_followed_and_keep_the_rotary_axes_where_they_are() {
    let work_offsets = WorkOffsets {
        only_mm: Some([1.0, 2.0, 3.0]),
        of_machine_mm: [(WorkOffset::Code(OffsetCode::new(55, 0)), [4.0, 5.0, 6.0])].into(),
        ..WorkOffsets::default()
    };
    let options = InterpreterOptions { work_offsets: Arc::new(work_offsets), ..InterpreterOptions::in_mm() };
    let text = "G54 G0 X0 Y0 Z0 A10 C20\nG55 X1 Y1\nZ1\nG1 X2 F100\nG56\nX1 Y1 Z1 A1 C1\nX2\nG54 X0 Y0 Z0 A0 C0\nX1\n";
    let (motions, _) = run_with(text, options);
    let changed: Vec<_> = motions.iter().map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [false, false, false, false, true, true, false, false]);
    assert_eq!(end(&motions[2]), [1.0, 1.0, 1.0, 10.0, 20.0]);
    assert!(motions[3].start.is_some());
    let only: Vec<_> = motions.iter().map(|motion| motion.is_only_offset).collect();
    assert_eq!(only, [true, false, false, false, false, false, true, true]);
}
