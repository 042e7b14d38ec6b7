//! Feeds: stated, given from outside, and of blocks that do not move.

use super::tests::*;
use super::*;

#[test]
fn inverse_time_feed_holds_for_its_block_only() {
    let motions = run_from_zero("G93 G1 X1 F10\nX2\nG94 X3\nX4 F500\nX5\n");
    let feeds: Vec<_> = motions.iter().map(|motion| (motion.feed.value, motion.feed.word_in_block)).collect();
    assert_eq!(
        feeds,
        [(Some(10.0), true), (None, false), (None, false), (Some(500.0), true), (Some(500.0), false)]
    );
}

#[test]
fn a_given_feed_serves_until_the_program_has_one() {
    let options = InterpreterOptions { feed_mm_per_min: Some(254.0), ..InterpreterOptions::in_mm() };
    let (motions, _) = run_with("G20 G1 X1\nX2 F5\n", options);
    assert_eq!(motions[0].feed.value, Some(254.0));
    assert!((motions[0].feed.raw - 10.0).abs() < 1e-12);
    assert_eq!(motions[1].feed.value, Some(5.0 * 25.4));
}

#[test]
fn a_given_feed_does_not_stand_in_for_one_that_is_not_known() {
    let options = InterpreterOptions { feed_mm_per_min: Some(254.0), ..InterpreterOptions::in_mm() };
    for before in [
        "F#101",
        "F100\nF#101",
        "F100\nG20",
        "G20 F100\nG21",
        "G93 X2 F3\nG94",
        "G95 F.1\nG94",
        "M98 P1\nG0 G90 G21 G94 G40 G49 G69 G54",
        "/F100",
        "G4 F100",
    ] {
        let (motions, _) = run_with(&format!("G1\n{before}\nG1 X1\n"), options.clone());
        let feed = motions.last().unwrap().feed;
        assert_eq!((feed.value, feed.raw, feed.decimals), (None, 0.0, 0), "{before}");
    }
    for before in ["G20", "G20\nG21", "G93\nG94", "G95\nG94", "/G1", "G4 P1"] {
        let (motions, _) = run_with(&format!("G1\n{before}\nG1 X1\n"), options.clone());
        assert_eq!(motions.last().unwrap().feed.value, Some(254.0), "{before}");
    }
    for mode in ["G93", "G95"] {
        assert_eq!(run_with(&format!("{mode} G1 X1\n"), options.clone()).0[0].feed.value, None, "{mode}");
    }
}

#[test]
fn a_given_feed_is_a_number_that_can_be_written() {
    for (feed_mm_per_min, units, raw, decimals) in [
        (1500.0, "G21", 1500.0, 0),
        (1500.5, "G21", 1500.5, 1),
        (1000.0, "G20", 39.3701, 4),
        (0.01, "G21", 0.01, 2),
        (1.0 / 3.0, "G21", 0.333_333, 6),
    ] {
        let options =
            InterpreterOptions { feed_mm_per_min: Some(feed_mm_per_min), ..InterpreterOptions::in_mm() };
        let feed = run_with(&format!("{units} G1 X1\n"), options.clone()).0[0].feed;
        let mut text = format!("{units} G1 X1 F").into_bytes();
        crate::program::print_decimal(feed.raw, feed.decimals, &mut text);
        let again = run(&String::from_utf8(text).unwrap())[0].feed;
        assert_eq!((again.value, again.raw, again.decimals), (feed.value, feed.raw, feed.decimals));
        assert_eq!((feed.raw, feed.decimals), (raw, decimals), "{feed_mm_per_min}");
    }
    let options = InterpreterOptions { feed_mm_per_min: Some(1e-9), ..InterpreterOptions::in_mm() };
    assert_eq!(run_with("G1 X1\n", options).0[0].feed.value, None);
}

#[test]
fn feeds_of_blocks_that_do_not_move_hold_behind_them() {
    for block in ["G92 X0 F7", "G53 F7", "G28 Z0 F7", "G53.1 F7", "G5.1 X1 Q2 F7", "G45 X1 F7"] {
        let motions = run_from_zero(&format!("G1 X1 F100\n{block}\nG1 X1\n"));
        assert_eq!(motions.last().unwrap().feed.raw, 7.0, "{block}");
    }
}
