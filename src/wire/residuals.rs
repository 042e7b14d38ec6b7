//! The table of a verification: every sample of the surface with the residual that the program leaves there.

use std::io::{Read, Write};

use serde::{Deserialize, Serialize};

use crate::plot::ResidualSample;

/// One sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualRow {
    /// X of the sample on the nominal surface, in W.
    pub x_mm: f64,
    /// Y of the sample.
    pub y_mm: f64,
    /// Z of the sample.
    pub z_mm: f64,
    /// X component of the unit normal out of the part.
    pub nx: f64,
    /// Y component of the normal.
    pub ny: f64,
    /// Z component of the normal.
    pub nz: f64,
    /// Material above the surface along the normal, negative below it; empty if no tool came here.
    pub residual_um: Option<f64>,
    /// Line of the program that left it; empty if no tool came here.
    pub line: Option<u64>,
}

impl From<ResidualRow> for ResidualSample {
    fn from(row: ResidualRow) -> Self {
        Self {
            point_mm: [row.x_mm, row.y_mm, row.z_mm].into(),
            normal: [row.nx, row.ny, row.nz].into(),
            residual_um: row.residual_um,
        }
    }
}

/// The I/O fault inside a table's fault, if there is one: its kind gives the cause.
#[must_use]
pub fn fault_of_table(fault: csv::Error) -> std::io::Error {
    match fault.into_kind() {
        csv::ErrorKind::Io(fault) => fault,
        other => std::io::Error::other(format!("{other:?}")),
    }
}

impl ResidualRow {
    /// Writes rows after their header.
    ///
    /// # Errors
    /// The rows cannot be written to the output.
    pub fn write_all(rows: impl Iterator<Item = Self>, output: impl Write) -> Result<(), csv::Error> {
        let mut writer = csv::Writer::from_writer(output);
        for row in rows {
            writer.serialize(row)?;
        }
        Ok(writer.flush()?)
    }

    /// Reads a table that [`Self::write_all`] wrote.
    ///
    /// # Errors
    /// The input is not such a table.
    pub fn read_all(input: impl Read) -> Result<Vec<Self>, csv::Error> {
        csv::Reader::from_reader(input).into_deserialize().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_comes_back_to_the_last_bit() {
        let cut = ResidualRow {
            x_mm: 0.1 + 0.2,
            y_mm: -1e-17,
            z_mm: 123.456,
            nx: 1.0 / 3.0,
            ny: 0.0,
            nz: 1.0,
            residual_um: Some(-12.25),
            line: Some(17),
        };
        let rows = [cut, ResidualRow { residual_um: None, line: None, ..cut }];
        let mut text = Vec::new();
        ResidualRow::write_all(rows.into_iter(), &mut text).expect("a table");
        assert!(text.starts_with(b"x_mm,y_mm,z_mm,nx,ny,nz,residual_um,line\n"));
        assert_eq!(ResidualRow::read_all(&text[..]).expect("its rows"), rows);
    }
}
