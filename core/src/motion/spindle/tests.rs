//! Which tool is in the spindle after each line.

use super::CalledTool::{Changed, NotCalled, Selected};
use super::*;
use crate::program::{Dialect, ReadLimits, Reader};

/// The tool after each line of a program.
fn tools(dialect: Dialect, text: &str) -> Vec<CalledTool> {
    let mut reader = Reader::new(Some(dialect), ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let (mut batch, mut spindle, mut tools) = (Batch::new(), Spindle::START, Vec::new());
    while reader.next_batch(&mut batch).unwrap() {
        for block in batch.blocks() {
            let _name = spindle.see(&batch, block);
            tools.push(told(spindle.tool()));
            if batch.words(block).iter().any(|word| word.address == Address::X) {
                spindle.is_described = false;
            }
        }
    }
    tools
}

const UNKNOWN: CalledTool = CalledTool::Unknown(0);

/// The tool. All unknown tools count as the same tool.
fn told(tool: CalledTool) -> CalledTool {
    if matches!(tool, CalledTool::Unknown(_)) { UNKNOWN } else { tool }
}

const fn changed(number: u32) -> CalledTool {
    Changed(ToolKey::Number(number))
}

fn key(name: &str) -> ToolKey {
    ToolName::new(name.as_bytes()).unwrap().key()
}

#[test]
fn the_tool_before_a_change_comes_in_and_the_one_after_it_is_made_ready() {
    let text = "G0 X1\nT1 M6 T2\nG1 X2\nM6\nM6 T3\nT4\nT5 M6\nT#1 M6\n";
    let expected =
        [NotCalled, changed(1), changed(1), changed(2), changed(3), changed(3), changed(5), UNKNOWN];
    assert_eq!(tools(Dialect::Iso, text), expected);
}

#[test]
fn a_change_that_the_text_does_not_tell_leaves_the_tool_unknown() {
    for (text, last) in [
        ("T8 M6\nM61 Q9\n", changed(9)),
        ("T8 M6\nM61 Q#1\n", UNKNOWN),
        ("T8 M6\nT9 M16\n", UNKNOWN),
        ("T8 M6\nT9 M66\n", UNKNOWN),
        ("T8 M6\nT9 M3\n", changed(8)),
        ("T8\nT9\n", UNKNOWN),
        ("T8\nT8\n", NotCalled),
        ("T8 M6\nM6\n", UNKNOWN),
        ("T8 M6\nT9\nT10\n", changed(8)),
        ("T8 M6\nT9\nM6\n", changed(9)),
    ] {
        assert_eq!(tools(Dialect::Iso, text).last(), Some(&last), "{text}");
    }
}

#[test]
fn tools_are_told_apart_by_their_names_whatever_their_case() {
    let text = "T=\"BALL_10\"\nM6\nT1=\"ball_10\"\nM6\nT=\"FLAT 5\" M6\nT7 M6\nT=\"A\"<<\"B\"\nM6\n";
    let ball = key("Ball_10");
    assert_eq!(
        tools(Dialect::Siemens, text),
        [
            Selected(ball),
            Changed(ball),
            Changed(ball),
            Changed(ball),
            Changed(key("FLAT 5")),
            changed(7),
            changed(7),
            UNKNOWN
        ]
    );
    let conversational =
        "1 TOOL CALL \"BALL_10\" Z S1000\n2 TOOL CALL S500\n3 TOOL CALL 5 Z\n4 TOOL CALL QS1 Z\n";
    assert_eq!(
        tools(Dialect::Heidenhain, conversational),
        [Changed(ball), Changed(ball), changed(5), UNKNOWN]
    );
}

#[test]
fn a_name_is_kept_up_to_64_bytes_and_no_name_is_none() {
    let longest = "B".repeat(ToolName::MAX_BYTES);
    assert_eq!(ToolName::new(longest.as_bytes()).unwrap().as_bytes(), longest.as_bytes());
    assert_eq!(ToolName::new(format!("{longest}B").as_bytes()), None);
    assert_eq!(ToolName::new(b"  "), None);
    let text = format!("T=\"{longest}B\" M6\nT=\"\" M6\n");
    assert_eq!(tools(Dialect::Siemens, &text), [UNKNOWN, UNKNOWN]);
    // The digests of FNV-1a.
    assert_eq!(key("A"), ToolKey::Name(0xaf63_fc4c_8602_22ec));
}

#[test]
fn without_an_m6_t_is_what_a_sinumerik_program_calls_and_another_edge_is_not_told() {
    let text = "T5\nD1\nG1 X1\nD2\nD1\nT6 D3\nT7\nM6\nT8\n";
    let of = |number| Selected(ToolKey::Number(number));
    let expected = [of(5), of(5), of(5), UNKNOWN, of(5), UNKNOWN, of(7), changed(7), changed(7)];
    assert_eq!(tools(Dialect::Siemens, text), expected);
}

#[test]
fn a_cutter_statement_describes_the_tool_beside_it_and_alone_is_another_tool() {
    let text = "CUTTER/10.,5.\nLOADTL/3\nGOTO/1,2,3\nCUTTER/10.,5.\nCUTTER/12.\nLOADTL/4\nCUTTER/8.\nGOTO/2,2,3\nLOADTL/4\n\
                CUTTER/6.\n";
    let expected = [
        NotCalled,
        changed(3),
        changed(3),
        changed(3),
        UNKNOWN,
        changed(4),
        changed(4),
        changed(4),
        changed(4),
        changed(4),
    ];
    assert_eq!(tools(Dialect::Apt, text), expected);
}

#[test]
fn two_tools_that_are_not_told_are_not_one() {
    let mut spindle = Spindle { ready: Some(ToolKey::Number(5)), ..Spindle::START };
    spindle.pass_call();
    let first = spindle.tool();
    spindle.pass_call();
    assert_ne!(first, spindle.tool());
}

#[test]
fn a_call_may_have_put_in_what_was_made_ready() {
    let ready = |ready, holds| Spindle { ready, holds, ..Spindle::START };
    let five = Some(ToolKey::Number(5));
    for (mut spindle, expected) in [
        (ready(None, NotCalled), NotCalled),
        (ready(five, NotCalled), UNKNOWN),
        (ready(five, changed(5)), changed(5)),
        (ready(five, changed(4)), UNKNOWN),
        (ready(five, Selected(ToolKey::Number(5))), Selected(ToolKey::Number(5))),
    ] {
        spindle.pass_call();
        assert_eq!(told(spindle.tool()), expected);
    }
}
