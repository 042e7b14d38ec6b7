//! Published cutter location data, posted: every point is reached, or every line that is not posted is named.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::machine::{Machine, RotaryLetter};
use trunnion::process::{Fault, PostForm, PostParameters, PostReport, ProgramSetup, Tools, post};

use crate::set_ups::at_zero;
use crate::shared_file;
use crate::tables::tables;

fn run(machine: &Machine, parameters: &PostParameters, text: &[u8]) -> Result<(String, PostReport), Fault> {
    let mut output = Vec::new();
    let report = post(machine, parameters, &text.to_vec(), &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).unwrap(), report))
}

/// Rounding of three words with four decimals [mm].
const ROUNDING_MM: f64 = 0.000_05 * 1.732_051 + 1e-6;

/// The tips of GOTO statements up to a line.
fn tips(text: &str) -> Vec<[f64; 3]> {
    let rows = text.lines().filter_map(|line| line.trim().strip_prefix("GOTO/"));
    rows.map(|row| {
        let mut numbers = row.split(',').map(|number| number.trim().parse().unwrap());
        std::array::from_fn(|_| numbers.next().unwrap())
    })
    .collect()
}

/// X Y Z at every point of a posted program.
fn written(program: &str) -> Vec<[f64; 3]> {
    let word = |line: &str, letter: char| -> Option<f64> {
        let rest = line.split_once(letter)?.1;
        let end = rest.find(|c: char| c.is_ascii_uppercase()).unwrap_or(rest.len());
        Some(rest[..end].trim().parse().unwrap())
    };
    let mut now = [None; 3];
    let motions = program.lines().filter(|line| !line.starts_with('(') && line.contains(['X', 'Y', 'Z']));
    motions
        .filter_map(|line| {
            for (at, letter) in now.iter_mut().zip(['X', 'Y', 'Z']) {
                *at = word(line, letter).or(*at);
            }
            // The first approach takes more than one block.
            let [Some(x), Some(y), Some(z)] = now else { return None };
            Some([x, y, z])
        })
        .collect()
}

#[test]
fn published_cutter_location_data_is_posted_up_to_the_first_line_that_is_refused() {
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    // Radius compensation, another cutter, turned coordinates: each begins at this line.
    for (name, first, refused) in [
        ("aamorim_boss.apt", 3737, 942),
        ("aamorim_tilt_support.apt", 309, 4),
        ("aamorim_interface_glue.clt", 10, 2036),
    ] {
        let Some(path) = shared_file(&format!("programs/cl/{name}")) else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let Err(Fault::Lines(faults)) = run(&machine, &PostParameters::new(at_zero()), text.as_bytes())
        else {
            panic!("{name} is not refused by line");
        };
        assert_eq!((faults.kept[0].line, faults.total), (first as u64, refused), "{name}");
        let sound: String = text.split_inclusive('\n').take(first - 1).collect();
        let wanted = tips(&sound);
        if wanted.is_empty() {
            continue;
        }
        for form in [PostForm::Tcp, PostForm::Machine] {
            let parameters = PostParameters { form, ..PostParameters::new(at_zero()) };
            let (program, report) = run(&machine, &parameters, sound.as_bytes()).unwrap();
            println!("{name} {form:?}: {report:?}");
            assert!(report.largest_tip_error_mm <= ROUNDING_MM && report.rewinds == 0);
            if form == PostForm::Tcp {
                let reached = written(&program);
                let near = |[a, b]: [&[f64; 3]; 2]| (0..3).all(|k| (a[k] - b[k]).abs() <= ROUNDING_MM);
                // Arcs have chords in between; every point of the source is there, in its order.
                let mut at = reached.iter();
                assert!(wanted.iter().all(|tip| at.any(|point| near([point, tip]))), "{name}");
                assert_eq!(reached.len() as u64, report.points);
            }
        }
    }
}

/// The lowest places of the tool: the points, and under a cycle the bottoms of the holes.
fn places(text: &str) -> Vec<[f64; 3]> {
    let mut depth = 0.0;
    let mut places = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some((_, rest)) = line.split_once("FEDTO,") {
            depth = rest.split(',').next().unwrap().parse().unwrap();
        } else if line.starts_with("CYCLE/OFF") {
            depth = 0.0;
        } else if let Some(row) = line.strip_prefix("GOTO/") {
            let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
            let axis = if numbers.len() == 6 { &numbers[3..] } else { &[0.0, 0.0, 1.0] };
            places.push(std::array::from_fn(|k| numbers[k] - depth * axis[k]));
        }
    }
    places
}

#[test]
fn published_cutter_location_data_is_posted_whole_with_its_tools_cycles_and_set_ups() {
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    for (name, tools, cutcoms) in [("aamorim_boss.apt", 4, 81), ("aamorim_tilt_support.apt", 3, 0)] {
        let Some(path) = shared_file(&format!("programs/cl/{name}")) else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let program = ProgramSetup { cutcom_at_centre: true, tools: Tools::default(), ..at_zero() };
        for form in [PostForm::Tcp, PostForm::Machine] {
            let parameters =
                PostParameters { form, changes_tools: true, ..PostParameters::new(program.clone()) };
            let (program, report) = run(&machine, &parameters, text.as_bytes()).unwrap();
            assert_eq!((report.tool_changes, report.cutcoms), (tools, cutcoms), "{name}");
            assert!(report.largest_tip_error_mm <= ROUNDING_MM && report.cutting_rewind_line.is_none());
            if form == PostForm::Tcp {
                let reached = written(&program);
                let near = |[a, b]: [&[f64; 3]; 2]| (0..3).all(|k| (a[k] - b[k]).abs() <= ROUNDING_MM);
                let mut at = reached.iter();
                assert!(places(&text).iter().all(|place| at.any(|point| near([point, place]))), "{name}");
            }
        }
    }
}

/// Three decimals in each word, of two programs that round for themselves [mm].
const THREE_DECIMALS_MM: f64 = 0.001;

/// Ends of the straight cuts of a conversational program that another post-processor wrote.
fn conversational_ends(text: &str) -> Vec<[f64; 3]> {
    let mut now = [None; 3];
    let mut ends = Vec::new();
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace().skip(1);
        let is_line = words.next() == Some("L");
        let is_arc = line.split_ascii_whitespace().nth(1) == Some("C");
        if line.contains("M91") || !(is_line || is_arc) {
            continue;
        }
        let mut moves = false;
        for word in words {
            let axis = ["X", "Y", "Z"].iter().position(|letter| word.starts_with(letter));
            if let Some((axis, value)) = axis.zip(word[1..].parse().ok()) {
                now[axis] = Some(value);
                moves = true;
            }
        }
        if let ([Some(x), Some(y), Some(z)], true) = (now, moves && is_line && !line.contains("FMAX")) {
            ends.push([x, y, z]);
        }
    }
    ends
}

/// The same data as another post-processor wrote them, for two set-ups: the second one with its table tilted by 90°.
#[test]
fn the_points_are_those_of_another_post_processor() {
    let Some(path) = shared_file("programs/cl/aamorim_boss.apt") else { return };
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    let text = std::fs::read_to_string(path).unwrap();
    let program = ProgramSetup { cutcom_at_centre: true, tools: Tools::default(), ..at_zero() };
    let parameters = PostParameters { changes_tools: true, ..PostParameters::new(program) };
    let (program, _) = run(&machine, &parameters, text.as_bytes()).unwrap();
    let reached = written(&program);
    for (name, to_world) in [
        ("aamorim_boss_posted_11.h", (|at| at) as fn([f64; 3]) -> [f64; 3]),
        ("aamorim_boss_posted_12.h", |[x, y, z]| [z, y, -x]),
    ] {
        let theirs = std::fs::read_to_string(shared_file(&format!("programs/cl/{name}")).unwrap()).unwrap();
        let ends = conversational_ends(&theirs);
        let near = |end: [f64; 3]| {
            move |point: &&[f64; 3]| (0..3).all(|k| (point[k] - end[k]).abs() <= THREE_DECIMALS_MM)
        };
        let mut at = reached.iter();
        let first = ends.iter().map(|end| to_world(*end)).find(|end| at.find(near(*end)).is_none());
        assert!(ends.len() > 3000 && first.is_none(), "{name}: {first:?} of {}", ends.len());
    }
}
