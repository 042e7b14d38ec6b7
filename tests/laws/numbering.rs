//! Laws of how inserted blocks look: numbers between those of their neighbours, words that change and no others where
//! the program writes no others.

use std::collections::BTreeMap;

use trunnion::units::Length;

use crate::compensation::{parameters, run};
use crate::models::finishing::{FeedForm, Finishing, Form, ac_machine, blade, dome_near_pole, tool};

/// Far finer than the programs' own step: many blocks are inserted [µm].
const TOLERANCE_UM: f64 = 1.0;

/// The text with its block numbers this far apart; without any where it is 0.
fn numbered(text: &str, step: u64) -> String {
    let mut number = 0;
    let lines = text.lines().map(|line| {
        let bare = line
            .strip_prefix('N')
            .map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start());
        match bare {
            Some(bare) if step == 0 => format!("{bare}\n"),
            Some(bare) => {
                number += step;
                format!("N{number} {bare}\n")
            }
            None => format!("{line}\n"),
        }
    });
    lines.collect()
}

fn numbers(text: &str) -> Vec<u64> {
    let number = |line: &str| line.strip_prefix('N')?.split_whitespace().next()?.parse().ok();
    text.lines().filter_map(number).collect()
}

fn compensated(part: &Finishing, text: &str) -> String {
    let parameters =
        trunnion::process::CcParameters { tolerance: Length::from_um(TOLERANCE_UM), ..parameters(part) };
    run(part, &parameters, text).expect("compensated").0
}

#[test]
fn inserted_blocks_are_numbered_between_their_neighbours_or_not_at_all() {
    for part in
        [blade(ac_machine(), tool(5.0, 5.0), 25, 3), dome_near_pole(ac_machine(), tool(5.0, 5.0), 41, 3)]
    {
        let text = part.program(Form::ContactWords, FeedForm::PerMinute);
        let plain = compensated(&part, &numbered(&text, 0));
        assert!(numbers(&plain).is_empty());
        for step in [1, 2, 10, 1000] {
            let source = numbered(&text, step);
            let output = compensated(&part, &source);
            // The numbers are all that is different.
            assert_eq!(numbered(&output, 0), plain, "step {step}");
            let found = numbers(&output);
            assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "step {step}");
            assert!(numbers(&source).iter().all(|number| found.contains(number)), "step {step}");
            let moving = output.lines().filter(|line| line.contains('X'));
            let without = moving.filter(|line| !line.starts_with('N')).count();
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
    let text = economical(&numbered(&part.program(Form::Plain, FeedForm::PerMinute), 1000));
    assert!(text.lines().any(|line| line.contains('X') && !line.contains('C')));
    let output = compensated(&part, &text);
    let mut standing = BTreeMap::new();
    let mut inserted = 0;
    for line in output.lines() {
        let number = numbers(line).first().copied().unwrap_or_default();
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
