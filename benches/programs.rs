//! The programs of the benchmarks: a finishing pass in every dialect, one block in fifty over tolerance.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use trunnion::motion::AxisWords;

/// One block in fifty turns further.
const LONG_EVERY: u32 = 50;

/// The words of the next block. `state` holds the rotary words \[deg\].
pub(crate) fn words(state: &mut [f64; 2], index: u32) -> AxisWords {
    let long = index.is_multiple_of(LONG_EVERY);
    let sense = if (index / 700).is_multiple_of(2) { 1.0 } else { -1.0 };
    state[1] += sense * if long { 2.6 } else { 0.31 };
    let phase = f64::from(index) / 400.0;
    state[0] = 35.0 + 12.0 * phase.sin();
    let x = 80.0 + 15.0 * (phase * 0.7).cos();
    let y = -20.0 + 11.0 * (phase * 0.9).sin();
    AxisWords { linear_mm: [x, y, 40.0 + 5.0 * phase.cos()], rotary_deg: *state }
}

/// The form of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// ISO.
    Iso,
    /// ISO with the contact point in U V W.
    ContactWords,
    Siemens,
    Heidenhain,
    Okuma,
    /// A table (CSV).
    Table,
    /// Cutter locations (APT).
    CutterLocations,
}

impl Form {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Iso => "ISO",
            Self::ContactWords => "ISO, U V W",
            Self::Siemens => "Sinumerik",
            Self::Heidenhain => "Heidenhain",
            Self::Okuma => "Okuma",
            Self::Table => "table (CSV)",
            Self::CutterLocations => "APT",
        }
    }
}

/// Writes a program with so many blocks. Returns its length \[bytes\].
pub(crate) fn write_program(path: &Path, form: Form, blocks: u32) -> io::Result<u64> {
    let mut out = BufWriter::new(File::create(path)?);
    match form {
        Form::Iso | Form::ContactWords => writeln!(out, "%\nG21 G90 G94 G54\nG1 F3000")?,
        Form::Siemens => writeln!(out, "; a program\nN1 G71 G90 G94 G54\nN2 G1 F3000")?,
        Form::Heidenhain => writeln!(out, "0 BEGIN PGM P MM\n1 L X+80 Y-20 Z+40 A+35 C+0 R0 F3000 M3")?,
        Form::Okuma => writeln!(out, "$P.MIN%\nG15 H1\nG21 G90 G94\nG1 F3000")?,
        Form::Table => writeln!(out, "X,Y,Z,A,C,F")?,
        Form::CutterLocations => writeln!(out, "PARTNO/P\nUNITS/MM\nMULTAX/ON\nFEDRAT/3000.,MMPM")?,
    }
    let mut state = [35.0, 0.0];
    for index in 0..blocks {
        let AxisWords { linear_mm: [x, y, z], rotary_deg: [a, c] } = words(&mut state, index);
        match form {
            Form::Iso | Form::Okuma => writeln!(out, "X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4}")?,
            Form::ContactWords => {
                let [u, v, w] = [x + 1.4, y - 2.2, z + 0.7];
                writeln!(out, "X{x:.4} Y{y:.4} Z{z:.4} A{a:.4} C{c:.4} U{u:.4} V{v:.4} W{w:.4}")?;
            }
            Form::Siemens => writeln!(out, "N{} X{x:.4} Y{y:.4} Z{z:.4} A={a:.4} C={c:.4}", index + 3)?,
            Form::Heidenhain => {
                writeln!(out, "{} L X{x:+.4} Y{y:+.4} Z{z:+.4} A{a:+.4} C{c:+.4}", index + 2)?;
            }
            Form::Table => writeln!(out, "{x:.4},{y:.4},{z:.4},{a:.4},{c:.4},3000")?,
            Form::CutterLocations => {
                let ((sa, ca), (sc, cc)) = (a.to_radians().sin_cos(), c.to_radians().sin_cos());
                writeln!(out, "GOTO/{x:.4},{y:.4},{z:.4},{:.7},{:.7},{ca:.7}", sa * sc, -sa * cc)?;
            }
        }
    }
    match form {
        Form::Iso | Form::ContactWords => writeln!(out, "M30\n%")?,
        Form::Siemens | Form::Okuma => writeln!(out, "M30")?,
        Form::Heidenhain => writeln!(out, "{} END PGM P MM", blocks + 2)?,
        Form::Table => {}
        Form::CutterLocations => writeln!(out, "FINI")?,
    }
    out.flush()?;
    Ok(std::fs::metadata(path)?.len())
}
