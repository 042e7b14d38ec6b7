//! Laws of how inserted blocks look: numbers between those of their neighbours, words that change and no others where
//! the program writes no others.

use std::collections::BTreeMap;

use trunnion::units::Length;

use crate::compensation::{parameters, run};
use crate::conversational::heidenhain;
use crate::models::finishing::{FeedForm, Finishing, Form, ac_machine, blade, dome_near_pole, tool};

/// Far finer than the programs' own step: many blocks are inserted [µm].
const TOLERANCE_UM: f64 = 1.0;
/// The same where the tip is interpolated.
const TCP_TOLERANCE_UM: f64 = 0.4;

/// The number of a line behind this mark, and what follows it.
fn number_of<'a>(line: &'a str, mark: &str) -> Option<(u64, &'a str)> {
    let (number, rest) = line.strip_prefix(mark)?.split_once(' ')?;
    Some((number.parse().ok()?, rest))
}

/// The text with its block numbers this far apart; without any where it is 0.
fn numbered(text: &str, step: u64, mark: &str) -> String {
    let mut number = 0;
    let lines = text.lines().map(|line| match number_of(line, mark) {
        Some((_, bare)) if step == 0 => format!("{bare}\n"),
        Some((_, bare)) => {
            number += step;
            format!("{mark}{number} {bare}\n")
        }
        None => format!("{line}\n"),
    });
    lines.collect()
}

fn numbers(text: &str, mark: &str) -> Vec<u64> {
    text.lines().filter_map(|line| Some(number_of(line, mark)?.0)).collect()
}

/// The part's program in every dialect that numbers its blocks, the mark of a number there, and a tolerance [µm].
fn in_every_dialect(part: &Finishing) -> [(String, &'static str, f64); 3] {
    let iso = part.program(Form::ContactWords, FeedForm::PerMinute);
    let words = iso.replace("G21", "G71").replace("N30 ", "N30 STOPRE ");
    let siemens = words.split_inclusive('\n').filter(|line| line.starts_with('N')).collect();
    let heidenhain = heidenhain(part, false).0;
    [(iso, "N", TOLERANCE_UM), (siemens, "N", TOLERANCE_UM), (heidenhain, "", TCP_TOLERANCE_UM)]
}

fn compensated(part: &Finishing, text: &str, tolerance_um: f64) -> String {
    let parameters =
        trunnion::process::CcParameters { tolerance: Length::from_um(tolerance_um), ..parameters(part) };
    run(part, &parameters, text).expect("compensated").0
}

#[test]
fn inserted_blocks_are_numbered_between_their_neighbours_or_not_at_all() {
    for part in
        [blade(ac_machine(), tool(5.0, 5.0), 25, 3), dome_near_pole(ac_machine(), tool(5.0, 5.0), 41, 3)]
    {
        for (text, mark, tolerance_um) in in_every_dialect(&part) {
            let plain = compensated(&part, &numbered(&text, 0, mark), tolerance_um);
            assert!(numbers(&plain, mark).is_empty());
            for step in [1, 2, 10, 1000] {
                let source = numbered(&text, step, mark);
                let output = compensated(&part, &source, tolerance_um);
                // The numbers are all that is different.
                assert_eq!(numbered(&output, 0, mark), plain, "step {step}");
                let found = numbers(&output, mark);
                assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "step {step}");
                assert!(numbers(&source, mark).iter().all(|number| found.contains(number)), "step {step}");
                let moving = output.lines().filter(|line| line.contains(" X") || line.starts_with('X'));
                let without = moving.filter(|line| number_of(line, mark).is_none()).count();
                let inserted = output.lines().count() - source.lines().count();
                assert!(inserted > 20, "{inserted}");
                match step {
                    1 => assert_eq!(without, inserted, "no room"),
                    1000 => assert_eq!(without, 0, "room for all"),
                    _ => {}
                }
            }
        }
    }
}

/// The text without the axis words that repeat what stands.
fn economical(text: &str) -> String {
    let mut standing = BTreeMap::new();
    let lines = text.lines().map(|line| {
        let words: Vec<&str> = line
            .split(' ')
            .filter(|word| {
                let Some(letter) = word.chars().next().filter(|letter| "XYZAC".contains(*letter)) else {
                    return true;
                };
                standing.insert(letter, word[1..].to_owned()).as_deref() != Some(&word[1..])
            })
            .collect();
        words.join(" ") + "\n"
    });
    lines.collect()
}

#[test]
fn where_a_program_leaves_standing_words_out_inserted_blocks_do() {
    // A cylinder along X: one coordinate stands for a whole pass.
    let mut part = blade(ac_machine(), tool(5.0, 5.0), 25, 3);
    for point in &mut part.points {
        point.rotary_deg[1] = 30.0;
    }
    let text = economical(&numbered(&part.program(Form::Plain, FeedForm::PerMinute), 1000, "N"));
    assert!(text.lines().any(|line| line.contains('X') && !line.contains('C')));
    let output = compensated(&part, &text, TOLERANCE_UM);
    let mut standing = BTreeMap::new();
    let mut inserted = 0;
    for line in output.lines() {
        let number = numbers(line, "N").first().copied().unwrap_or_default();
        let is_new = number % 1000 != 0;
        inserted += usize::from(is_new);
        for word in line.split(' ') {
            let Some(letter) = word.chars().next().filter(|letter| "XYZAC".contains(*letter)) else {
                continue;
            };
            let before = standing.insert(letter, word[1..].to_owned());
            assert!(!is_new || before.as_deref() != Some(&word[1..]), "{line}");
        }
    }
    assert!(inserted > 5, "{inserted}");
}
