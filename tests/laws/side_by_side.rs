//! Whoever works side by side with whom, the program that comes out is the same.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

use trunnion::process::{
    CcParameters, ContactSource, Fault, OutputForm, Stop, WearParameters, WornCutter, compensate,
    compensate_side_by_side, compensate_wear, compensate_wear_side_by_side,
};
use trunnion::side_by_side::SideBySide;
use trunnion::units::Length;

use crate::models::finishing::{ac_machine, tool};
use crate::models::set_ups::at_zero;

/// Parts in threads of their own, or the last one first.
enum Hands {
    Threads,
    Reversed,
}

impl SideBySide for Hands {
    fn parts(&self) -> usize {
        2
    }

    fn run<'a>(&self, mut parts: Vec<Box<dyn FnOnce() + Send + 'a>>) {
        match self {
            Self::Threads => std::thread::scope(|scope| {
                for part in parts {
                    scope.spawn(part);
                }
            }),
            Self::Reversed => {
                parts.reverse();
                for part in parts {
                    part();
                }
            }
        }
    }
}

/// Bytes before the first point of such a program.
const HEAD: usize = "%\nG21 G90 G94\nG1 F3000\n".len();

/// More blocks than a stretch has; one in `long_every` turns far, and one rests.
fn program(blocks: u32, long_every: u32, feed: u32) -> Vec<u8> {
    let mut text = format!("%\nG21 G90 G94\nG1 F{feed}\n");
    let mut c = 0.0;
    for block in 0..blocks {
        c += if block.is_multiple_of(long_every) { 2.6 } else { 0.31 }
            * if block % 1400 < 700 { 1.0 } else { -1.0 };
        let p = f64::from(block) / 400.0;
        let (x, y, z) = (80.0 + 15.0 * (0.7 * p).cos(), -20.0 + 11.0 * (0.9 * p).sin(), 40.0 + 5.0 * p.cos());
        let a = 35.0 + 12.0 * p.sin();
        writeln!(text, "X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4}").expect("a string");
        if block == 8000 {
            text.push_str("(a rest)\nG4 P1\nM8\n");
        }
    }
    text.push_str("M30\n%\n");
    text.into_bytes()
}

fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn threads_and_their_order_change_nothing() {
    let machine = ac_machine();
    let fine =
        CcParameters { tolerance: Length::from_mm(0.002), ..CcParameters::new(tool(5.0, 5.0), at_zero()) };
    // So many steps a block that a stretch is handed over in pieces.
    let steps =
        CcParameters { output: OutputForm::Interpolated, ..CcParameters::new(tool(5.0, 5.0), at_zero()) };
    for (text, parameters) in [(program(18_000, 50, 3000), &fine), (program(9_000, 4, 150), &steps)] {
        let mut alone = Vec::new();
        let report = compensate(&machine, parameters, &text, &mut alone, &go_on).expect("compensated");
        assert!(report.motions_over_tolerance > 300 && report.blocks_out > report.blocks_in);
        for hands in [Hands::Threads, Hands::Reversed] {
            let mut output = Vec::new();
            let again = compensate_side_by_side(&machine, parameters, &text, &mut output, &hands, &go_on);
            assert!(output == alone, "the bytes differ");
            assert_eq!(again.expect("compensated"), report);
        }
    }
}

#[test]
fn threads_and_their_order_change_nothing_for_a_worn_cutter() {
    let machine = ac_machine();
    let worn = WornCutter::Tool(tool(4.9, 4.9));
    let contact = ContactSource::FeedPlane;
    let parameters = WearParameters { contact, ..WearParameters::new(tool(5.0, 5.0), worn, at_zero()) };
    let text = program(9_000, 50, 3000);
    let mut alone = Vec::new();
    let report = compensate_wear(&machine, &parameters, &text, &mut alone, &go_on).expect("compensated");
    assert!(report.motions_shifted > 8_000, "{}", report.motions_shifted);
    // Refused as a whole; from the middle on not to be moved; and from there on cut by another tool.
    let refused = [&text[..text.len() - 6], b"G4 X\n"].concat();
    let half = text.len() / 2 + text[text.len() / 2..].iter().position(|byte| *byte == b'\n').unwrap() + 1;
    let faulty = [&text[..half], b"G41 D1\n", &text[half..]].concat();
    let two_tools = [b"T1 M6\n", &text[2..half], b"T2 M6\n", &text[half..]].concat();
    let programs = [&refused, &faulty, &two_tools];
    let said = |fault: Result<_, Fault>| format!("{:?}", fault.map(|_report| ()).expect_err("a fault"));
    let alone_said =
        programs.map(|text| said(compensate_wear(&machine, &parameters, text, &mut Vec::new(), &go_on)));
    for (said, kind) in alone_said.iter().zip(["Program", "Lines", "Tool"]) {
        assert!(said.starts_with(kind), "{said}");
    }
    for hands in [Hands::Threads, Hands::Reversed] {
        let mut output = Vec::new();
        let go = |text: &Vec<u8>, output: &mut Vec<u8>, stop: &Stop<'_>| {
            compensate_wear_side_by_side(&machine, &parameters, text, output, &hands, stop)
        };
        let again = go(&text, &mut output, &go_on).expect("compensated");
        assert!(output == alone, "the bytes differ");
        assert_eq!(format!("{again:?}"), format!("{report:?}"));
        let hands_said = programs.map(|text| said(go(text, &mut Vec::new(), &go_on)));
        assert_eq!(hands_said, alone_said);
        for left in [1, 40, 300] {
            let left = AtomicU64::new(left);
            let stopped = go(&text, &mut Vec::new(), &|| breaking(&left));
            assert!(matches!(stopped, Err(Fault::Cancelled)), "{stopped:?}");
        }
    }
}

/// Goes on so many times more.
fn breaking(left: &AtomicU64) -> ControlFlow<()> {
    let before = left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
    if before.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}

#[test]
fn a_refused_program_is_refused_however_long_it_is() {
    let text = program(9_000, 50, 3000);
    let refusable = [&text[..HEAD], b"G4 X\n", &text[HEAD..]].concat();
    let mut parameters = CcParameters::new(tool(5.0, 5.0), at_zero());
    parameters.budget.max_blocks_out = 5_000;
    let refused = compensate(&ac_machine(), &parameters, &refusable, &mut Vec::new(), &go_on);
    assert!(matches!(refused, Err(Fault::Program(_))), "{refused:?}");
    let dear = compensate(&ac_machine(), &parameters, &text, &mut Vec::new(), &go_on);
    assert!(matches!(dear, Err(Fault::TooCostly { .. })), "{dear:?}");
}

#[test]
fn a_fault_at_the_end_of_a_long_program_is_named_as_in_a_short_one() {
    let mut text = program(9_000, 50, 3000);
    text.truncate(text.len() - 6);
    text.extend_from_slice(b"G1 X900000 A10\nX1 F0.0000001 C359\nG4 X\n");
    let parameters = CcParameters::new(tool(5.0, 5.0), at_zero());
    let machine = ac_machine();
    let faults: Vec<_> = [None, Some(Hands::Threads), Some(Hands::Reversed)]
        .into_iter()
        .map(|hands| {
            let mut output = Vec::new();
            match hands {
                None => compensate(&machine, &parameters, &text, &mut output, &go_on),
                Some(hands) => {
                    compensate_side_by_side(&machine, &parameters, &text, &mut output, &hands, &go_on)
                }
            }
            .map(|_report| ())
        })
        .collect();
    assert!(matches!(faults[0], Err(Fault::Program(_))), "{:?}", faults[0]);
    let said: Vec<_> = faults.iter().map(|fault| format!("{fault:?}")).collect();
    assert!(said.iter().all(|fault| *fault == said[0]), "{said:?}");
}

#[test]
fn stop_is_asked_all_along() {
    // Asked at least once for every batch of 512 blocks in each of survey and work.
    let text = program(9_000, 50, 3000);
    let parameters = CcParameters::new(tool(5.0, 5.0), at_zero());
    let asked = AtomicU64::new(0);
    let counting = || {
        asked.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    compensate(&ac_machine(), &parameters, &text, &mut Vec::new(), &counting).expect("compensated");
    let often = asked.into_inner();
    assert!(often > 2 * 9_000 / 512, "{often}");
    // And where it breaks, whenever that is, nothing is called done.
    for share in 1..8 {
        let left = AtomicU64::new(often * share / 8);
        let stopped = compensate(&ac_machine(), &parameters, &text, &mut Vec::new(), &|| breaking(&left));
        assert!(matches!(stopped, Err(Fault::Cancelled)), "share {share} of 8");
    }
}
