//! Laws of parameters: a program whose coordinates are expressions is the program whose coordinates are their values.

use trunnion::process::CcParameters;
use trunnion::units::Length;

use crate::compensation::{parameters, run};
use crate::models::finishing::{FeedForm, Form, ac_machine, blade, impeller_flank, tool};

const OPENING: &str = "#1=0.5\n#<s>=[#1*2]\n";

/// The program with every coordinate as a product with a parameter that is one.
fn with_parameters(text: &str) -> String {
    let lines = text.lines().map(|line| {
        if !line.contains(" X") {
            return line.to_owned() + "\n";
        }
        let words: Vec<String> = line
            .split(' ')
            .map(|word| match word.chars().next() {
                Some(letter @ ('X' | 'Y' | 'Z' | 'A' | 'C')) => format!("{letter}[#<s>*{}]", &word[1..]),
                _ => word.to_owned(),
            })
            .collect();
        words.join(" ") + "\n"
    });
    let body: String = lines.collect();
    body.replacen("%\n", &format!("%\n{OPENING}"), 1)
}

fn without_parameters(text: &str) -> String {
    text.replacen(OPENING, "", 1).replace("[#<s>*", "").replace(']', "")
}

#[test]
fn expressions_are_compensated_as_their_values_are() {
    let mut over = 0;
    for part in
        [blade(ac_machine(), tool(5.0, 5.0), 25, 3), impeller_flank(ac_machine(), tool(6.0, 1.5), 30, 3)]
    {
        for form in [Form::ContactWords, Form::Plain, Form::Tcp] {
            let parameters = CcParameters { tolerance: Length::from_um(5.0), ..parameters(&part) };
            let plain = part.program(form, FeedForm::PerMinute);
            let text = with_parameters(&plain);
            assert_eq!(without_parameters(&text), plain);
            let (expected, by_values) = run(&part, &parameters, &plain).expect("compensated");
            let (output, by_expressions) = run(&part, &parameters, &text).expect("compensated");
            assert!(without_parameters(&output) == expected, "{} {form:?}", part.name);
            over += by_values.motions_over_tolerance;
            let after = [by_expressions, by_values].map(|report| report.after.max_mm.to_bits());
            assert_eq!(after[0], after[1]);
            // What does not move keeps its expression.
            assert!(output.matches("[#<s>*").count() > 10);
        }
    }
    assert!(over > 100, "{over}");
}
