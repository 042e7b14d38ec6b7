//! Published cutter location data, posted: every point is reached, or every line that is not posted is named.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::machine::{Machine, RotaryLetter};
use trunnion::process::{Fault, PostForm, PostParameters, PostReport, post};

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
    // Radius compensation, another tool, turned coordinates: each begins at this line.
    for (name, first, refused) in [
        ("aamorim_boss.apt", 3737, 6285),
        ("aamorim_tilt_support.apt", 309, 8),
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
