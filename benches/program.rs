//! Reader, writer and interpreter, against plain `split` + `parse`, the reader of the crate `gcode`, and `format!` in
//! the same run.
//!
//! `cargo bench --bench program`. One thread; the best of several runs; ratios are what to compare.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on stops")]

#[path = "../tests/models/tables.rs"]
mod tables;

use std::hint::black_box;
use std::time::Instant;

use trunnion::machine::RotaryLetter;
use trunnion::motion::{Interpreter, InterpreterOptions};
use trunnion::program::{
    Address, Batch, Diagnostics, Dialect, NewWord, ReadLimits, Reader, print_changed, print_inserted,
};

use tables::tables;

const BLOCKS: usize = 400_000;
const RUNS: usize = 7;
/// What an upload arrives in.
const CHUNK: usize = 64 * 1024;

/// A five-axis program of repeatable numbers: `decimals` digits behind the point, or as many as a double has.
fn five_axis(blocks: usize, decimals: usize) -> Vec<u8> {
    use std::io::Write;
    let mut text = b"%\nO0001 (BENCH)\nG90 G21 G94 G43.4 H1\nG1 F1000\n".to_vec();
    for i in 0..blocks {
        let t = i as f64 * 1e-3;
        let (x, y, z) = (120.0 * t.cos(), 80.0 * t.sin(), 40.0 + 10.0 * (3.0 * t).sin());
        let (a, c) = (30.0 * (0.5 * t).sin(), -t * 57.0 % 360.0);
        writeln!(text, "X{x:.decimals$} Y{y:.decimals$} Z{z:.decimals$} A{a:.decimals$} C{c:.decimals$}")
            .unwrap();
    }
    text.extend_from_slice(b"M30\n%\n");
    text
}

fn best_seconds(mut work: impl FnMut()) -> f64 {
    let mut seconds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[0]
}

fn read_through(text: &[u8], mut each: impl FnMut(&Batch)) {
    let mut reader = Reader::new(Some(Dialect::Iso), ReadLimits::default());
    let mut batch = Batch::new();
    for chunk in text.chunks(CHUNK) {
        reader.feed(chunk);
        while reader.next_batch(&mut batch).unwrap() {
            each(&batch);
        }
    }
    reader.finish();
    while reader.next_batch(&mut batch).unwrap() {
        each(&batch);
    }
}

/// What a first version would do: lines, blanks, `str::parse`.
fn naive(text: &[u8]) -> f64 {
    let text = std::str::from_utf8(text).unwrap();
    let mut sum = 0.0;
    for line in text.lines() {
        for word in line.split_whitespace() {
            if let Ok(value) = word.get(1..).unwrap_or_default().parse::<f64>() {
                sum += value;
            }
        }
    }
    sum
}

/// Peak resident memory [kB] of this process, where the system tells.
fn peak_memory_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().split(' ').next()?.parse().ok())
}

#[expect(clippy::print_stdout, clippy::too_many_lines, reason = "figures are what a benchmark is for")]
fn main() {
    let typical = five_axis(BLOCKS, 4);
    let worst = five_axis(BLOCKS / 4, 14);
    let megabytes = typical.len() as f64 / 1e6;
    let plain = best_seconds(|| {
        black_box(naive(black_box(&typical)));
    });
    println!("split + parse        {:8.0} MB/s   1.0", megabytes / plain);
    let reading = best_seconds(|| {
        read_through(black_box(&typical), |batch| {
            black_box(batch.blocks().len());
        });
    });
    let other = best_seconds(|| {
        black_box(gcode::parse(black_box(std::str::from_utf8(&typical).unwrap())).is_ok());
    });
    println!("crate gcode          {:8.0} MB/s   {:.1}", megabytes / other, plain / other);
    println!(
        "reader, typical      {:8.0} MB/s   {:.1} times split + parse, {:.1} times crate gcode",
        megabytes / reading,
        plain / reading,
        other / reading
    );
    let worst_megabytes = worst.len() as f64 / 1e6;
    let worst_reading = best_seconds(|| {
        read_through(black_box(&worst), |batch| {
            black_box(batch.blocks().len());
        });
    });
    let worst_plain = best_seconds(|| {
        black_box(naive(black_box(&worst)));
    });
    println!(
        "reader, 14 decimals  {:8.0} MB/s   {:.1} times split + parse",
        worst_megabytes / worst_reading,
        worst_plain / worst_reading
    );

    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
    let mut batches = Vec::new();
    read_through(&typical, |batch| batches.push(batch.clone()));
    let interpreting = best_seconds(|| {
        let mut interpreter = Interpreter::new(&machine, InterpreterOptions::in_mm());
        for batch in &batches {
            motions.clear();
            interpreter.interpret(black_box(&mut batch.clone()), &mut motions, &mut diagnostics);
            black_box(&motions);
        }
    });
    let million_blocks = BLOCKS as f64 / 1e6;
    println!("interpreter          {:8.1} M blocks/s", million_blocks / interpreting);
    let both = best_seconds(|| {
        let mut interpreter = Interpreter::new(&machine, InterpreterOptions::in_mm());
        read_through(&typical, |batch| {
            motions.clear();
            interpreter.interpret(&mut batch.clone(), &mut motions, &mut diagnostics);
            black_box(&motions);
        });
    });
    println!("reader + interpreter {:8.1} M blocks/s", million_blocks / both);

    let mut out = Vec::new();
    let letters = [Address::X, Address::Y, Address::Z, Address::A, Address::C];
    let new_words = |batch: &Batch, index: usize| -> [NewWord; 5] {
        let words = batch.words(&batch.blocks()[index]);
        std::array::from_fn(|i| NewWord {
            address: letters[i],
            value: words.get(i).map_or(0.0, |word| word.value) + 0.001,
            decimals: 4,
        })
    };
    let mut write = |print: &mut dyn FnMut(&Batch, usize, &mut Vec<u8>)| {
        best_seconds(|| {
            for batch in &batches {
                out.clear();
                for index in 0..batch.blocks().len() {
                    print(batch, index, &mut out);
                }
                black_box(&out);
            }
        })
    };
    let formatted = write(&mut |batch, index, out| {
        use std::io::Write;
        for word in new_words(batch, index) {
            write!(out, "{}{:.4} ", word.address, word.value).unwrap();
        }
        out.push(b'\n');
    });
    println!("format!              {:8.1} M blocks/s   1.0", million_blocks / formatted);
    let changed = write(&mut |batch, index, out| {
        print_changed(batch, index, &new_words(batch, index), false, out).unwrap();
    });
    println!(
        "writer, changed      {:8.1} M blocks/s   {:.1} times format!",
        million_blocks / changed,
        formatted / changed
    );
    let inserted = write(&mut |batch, index, out| {
        print_inserted(batch, index, &new_words(batch, index), false, out).unwrap();
    });
    println!(
        "writer, inserted     {:8.1} M blocks/s   {:.1} times format!",
        million_blocks / inserted,
        formatted / inserted
    );
    if let Some(kilobytes) = peak_memory_kb() {
        println!("peak memory          {kilobytes:8} kB, {:.0} kB of it texts and kept batches", {
            let kept: usize =
                batches.iter().map(|batch| batch.text().len() + batch.blocks().len() * 160).sum();
            (typical.len() + worst.len() + kept) as f64 / 1e3
        });
    }
}
