//! Singular regions first, then the contact's path between the ends that are written.

use std::io::{BufWriter, Write};

use super::parameters::{SingularityAction, SingularityParameters};
use super::report::SingularityReport;
use super::treat::treat_from;
use crate::machine::Machine;
use crate::process::contact_path::{CcParameters, CcReport, CompensatedPath, PathStep, compensate_from};
use crate::process::fault::Fault;
use crate::process::pipeline::Upstream;
use crate::process::text::{LineCursor, Place, ProgramSource, Resting, Spool, Stop};
use crate::wear::SideBySide;

/// Treats the singular regions of a program, then compensates the cutter-contact path of what was written; between both
/// the program rests in `spool`. Regions that are only to be reported are found in the reading of the compensation, refuse
/// nothing, and are `None` where they cannot be listed. Lines in both reports are the upload's.
///
/// # Errors
/// Why the program is refused; `output` then holds text that must not be run and has to be thrown away.
#[expect(clippy::too_many_arguments, reason = "those of both steps")]
pub fn treat_and_compensate(
    machine: &Machine,
    cc: &CcParameters,
    singularity: &SingularityParameters,
    source: &dyn ProgramSource,
    spool: &dyn Spool,
    output: &mut dyn Write,
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<(Option<SingularityReport>, CcReport), Fault> {
    let upload = Upstream::upload(source);
    let note = &mut |_: &_| Ok(());
    if singularity.action == SingularityAction::Report {
        let step = PathStep { parameters: cc, regions: Some(singularity) };
        let CompensatedPath { cc, regions, .. } =
            compensate_from(machine, &step, upload, output, note, parts, stop)?;
        return Ok((regions, cc));
    }
    let mut text = BufWriter::new(spool.create(Place::Treated)?);
    let (treated, lines) = treat_from(machine, cc, singularity, upload, &mut text, parts, stop)?;
    text.flush()?;
    drop(text);
    let resting = Resting { spool, place: Place::Treated };
    let written = Upstream { source: &resting, lines: vec![LineCursor::new(&lines)] };
    let step = PathStep { parameters: cc, regions: None };
    let compensated = compensate_from(machine, &step, written, output, note, parts, stop)?;
    let compensated = CcReport { blocks_in: treated.blocks_in, ..compensated.cc };
    Ok((Some(treated), compensated))
}
