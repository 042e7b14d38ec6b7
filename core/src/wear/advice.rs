//! Advice for a worn cutter: keep it running, compensate it, reduce the step-over, or change it.

use super::{CutterPass, CutterWear, PassFault, Surface};
use crate::geometry::trig;
use crate::units::{Angle, Length};

/// A worn cutter in a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearQuestion {
    /// The nominal and the worn cutter.
    pub wear: CutterWear,
    /// Lead angle in the feed direction; ignored if both are balls.
    pub lead: Angle,
    /// The surface across the feed.
    pub surface: Surface,
    /// The program's step-over D.
    pub stepover: Length,
    /// The height allowed above the surface.
    pub allowed: Length,
    /// Smallest step-over worth running. Below it a new tool is better.
    pub least_stepover: Length,
    /// Smallest and largest angle between surface normal and tool axis in the program, within 0 and 90°.
    pub contact_angles: [Angle; 2],
}

/// The advice, the cheapest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Advice {
    /// The program may run unchanged.
    Keep,
    /// The tip has to be shifted for the worn cutter. The program may then run.
    Compensate,
    /// The program has to be compensated, and its passes have to be closer together.
    ReduceStepover,
    /// No pass worth running keeps the height. The cutter has to be changed.
    ChangeTool,
}

/// The result of one cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlook {
    /// Scallop at the program's step-over; `None` if neighbouring passes do not meet.
    pub scallop: Option<Length>,
    /// Largest step-over that keeps the allowed height.
    pub largest_stepover: Length,
}

/// Advice with its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearAdvice {
    /// The advice.
    pub advice: Advice,
    /// Step-over for the worn cutter; `None` if the cutter has to be changed.
    pub stepover: Option<Length>,
    /// The nominal cutter.
    pub nominal: Outlook,
    /// The worn cutter; `None` if it gouges this surface (an effective radius above that of a hollow).
    pub actual: Option<Outlook>,
    /// Smallest and largest offset along the normal without compensation, + excess, − gouge.
    pub offset: [Length; 2],
    /// Largest residual of the unchanged program, with the scallop; `None` if the worn cutter cannot cut it.
    pub before: Option<Length>,
    /// Largest residual after the advice was followed; after a change, that of the nominal cutter.
    pub after: Option<Length>,
    /// The wear limit: the smallest cutter radius, with the worn corner radius, that keeps the height at the
    /// program's step-over. `None` if no cutter keeps it.
    pub smallest_cutter: Option<Length>,
}

/// A gouge below this is rounding.
const NO_GOUGE: Length = Length::from_mm(1e-6);
/// A height exceeded by no more than rounding counts as kept (relative).
const ROUNDING: f64 = 1e-12;

/// Advice for a worn cutter (§4; P3 §4.2–4.4). Without compensation it leaves an offset along the normal and its
/// scallop. Compensation removes the offset, but not the growth of the scallop, because the cutting band is
/// narrower (`h′/h = (1/r′ + k/Rs)/(1/r + k/Rs)`). Against the growth, the passes have to be closer together.
///
/// # Errors
/// The faults of [`CutterPass`] for the nominal cutter (a gouge, passes that do not meet): such a program was never
/// valid; a lead angle out of range.
pub fn advise(question: &WearQuestion) -> Result<WearAdvice, PassFault> {
    let WearQuestion { wear, lead, surface, stepover, allowed, .. } = *question;
    let (nominal, actual) =
        (CutterPass { tool: wear.nominal, lead, surface }, CutterPass { tool: wear.actual, lead, surface });
    actual.effective_radius()?;
    let nominal = Outlook {
        scallop: Some(nominal.height(stepover)?),
        largest_stepover: nominal.largest_stepover(allowed)?,
    };
    let smallest_cutter = actual.smallest_cutter(allowed, stepover)?;
    // From here on, a fault of the worn cutter means that it does not fit this cut.
    let actual = actual
        .largest_stepover(allowed)
        .ok()
        .map(|largest_stepover| Outlook { scallop: actual.height(stepover).ok(), largest_stepover });
    let offset = offsets(&wear, question.contact_angles);
    let scallop = actual.and_then(|outlook| outlook.scallop);
    let before = scallop.map(|scallop| {
        // Between the lowest valley and the highest cusp.
        let [least, most] = offset;
        Length::from_mm(least.abs().mm().max((most + scallop).abs().mm()))
    });
    let keeps = |residual: Option<Length>| {
        residual.is_some_and(|residual| residual.mm() <= allowed.mm() * (1.0 + ROUNDING))
    };
    let closer = actual
        .map(|outlook| outlook.largest_stepover)
        .filter(|largest| *largest >= question.least_stepover && *largest > Length::ZERO);
    let (advice, stepover, after) = if keeps(before) && offset[0] >= -NO_GOUGE {
        (Advice::Keep, Some(stepover), before)
    } else if keeps(scallop) {
        (Advice::Compensate, Some(stepover), scallop)
    } else if let Some(closer) = closer {
        let pass = CutterPass { tool: wear.actual, lead, surface };
        (Advice::ReduceStepover, Some(closer), Some(pass.height(closer)?))
    } else {
        (Advice::ChangeTool, None, nominal.scallop)
    };
    Ok(WearAdvice { advice, stepover, nominal, actual, offset, before, after, smallest_cutter })
}

/// Smallest and largest value of `(r − r′)(1 − cos ψ) + ((R − r) − (R′ − r′))·sin ψ + ΔL·cos ψ` over the contact
/// angles ψ: at their ends, or at the extreme of the sine wave.
fn offsets(wear: &CutterWear, contact_angles: [Angle; 2]) -> [Length; 2] {
    let (corner, core) = (-wear.corner_change_mm(), -wear.core_change_mm());
    let along = wear.shorter_by.mm() - corner;
    let at = |angle_rad: f64| {
        let (sine, cosine) = trig::sin_cos(angle_rad);
        corner + along * cosine + core * sine
    };
    let [from, to] = contact_angles.map(Angle::rad);
    let crest = trig::atan2(core, along);
    let turns = [crest, crest + std::f64::consts::PI, crest - std::f64::consts::PI];
    let places = [from, to].into_iter().chain(turns.into_iter().filter(|turn| (from..=to).contains(turn)));
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for offset in places.map(at) {
        least = least.min(offset);
        most = most.max(offset);
    }
    [least, most].map(Length::from_mm)
}
