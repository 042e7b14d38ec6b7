//! What to do about a worn cutter: let it run, compensate it, go closer, or change it.

use super::{CutterPass, CutterWear, PassFault, Surface};
use crate::geometry::trig;
use crate::units::{Angle, Length};

/// A worn cutter in a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearQuestion {
    /// The nominal and the worn cutter.
    pub wear: CutterWear,
    /// Lead angle in the feed direction; no matter where both are balls.
    pub lead: Angle,
    /// The surface across the feed.
    pub surface: Surface,
    /// The program's step-over D.
    pub stepover: Length,
    /// The height that may be left above the surface.
    pub allowed: Length,
    /// A step-over below this is not worth running: a new tool is.
    pub least_stepover: Length,
    /// Least and largest angle between surface normal and tool axis in the program, within 0 and 90°.
    pub contact_angles: [Angle; 2],
}

/// What to do, the cheapest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Advice {
    /// The program may run as it is.
    Keep,
    /// The tip has to be shifted for the worn cutter; then the program may run.
    Compensate,
    /// Compensated, and with passes closer together.
    ReduceStepover,
    /// No pass worth running keeps the height: the cutter has to be changed.
    ChangeTool,
}

/// What one cutter leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlook {
    /// Scallop at the program's step-over; none where neighbouring passes do not meet.
    pub scallop: Option<Length>,
    /// Largest step-over that keeps the height allowed.
    pub largest_stepover: Length,
}

/// Advice with the numbers it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearAdvice {
    /// What to do.
    pub advice: Advice,
    /// The step-over to run the worn cutter with; none where it has to be changed.
    pub stepover: Option<Length>,
    /// The nominal cutter.
    pub nominal: Outlook,
    /// The worn cutter; none where it gouges this surface (an effective radius above that of a hollow).
    pub actual: Option<Outlook>,
    /// Least and largest offset along the normal that the worn cutter leaves uncompensated, + excess, − gouge.
    pub offset: [Length; 2],
    /// Largest residual of the program as it is, scallop included; none where the worn cutter cannot cut it.
    pub before: Option<Length>,
    /// Largest residual after the advice was taken; after a change that of the nominal cutter.
    pub after: Option<Length>,
    /// The smallest cutter radius, corner radius as worn, that keeps the height at the program's step-over: the wear
    /// limit. None where no cutter does.
    pub smallest_cutter: Option<Length>,
}

/// A gouge below this is rounding.
const NO_GOUGE: Length = Length::from_mm(1e-6);
/// A height counts as kept where rounding alone lies between (relative).
const ROUNDING: f64 = 1e-12;

/// Advice for a worn cutter (§4; P3 §4.2–4.4). Uncompensated it leaves an offset along the normal and its scallop;
/// compensation takes the offset away, but not the growth of the scallop, because the cutting band is narrower
/// (`h′/h = (1/r′ + k/Rs)/(1/r + k/Rs)`): for that the passes have to come closer.
///
/// # Errors
/// What [`CutterPass`] refuses of the nominal cutter (a gouge, passes that do not meet): such a program was never good;
/// a lead angle that does not fit.
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
    // What is refused of the worn cutter from here on is that it does not fit this cut.
    let actual = actual
        .largest_stepover(allowed)
        .ok()
        .map(|largest_stepover| Outlook { scallop: actual.height(stepover).ok(), largest_stepover });
    let offset = offsets(&wear, question.contact_angles);
    let scallop = actual.and_then(|outlook| outlook.scallop);
    let before = scallop.map(|scallop| {
        // between the lowest valley and the highest cusp
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

/// Least and largest of `(r − r′)(1 − cos ψ) + ((R − r) − (R′ − r′))·sin ψ + ΔL·cos ψ` over the contact angles ψ: at
/// their ends, or where the sine wave turns.
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
