//! What to set instead: gains that bring the contour error under a target, and the feed that present gains allow.

use std::ops::ControlFlow;

use super::sweep::ServoPath;
use super::{AxisLetter, Detail, DriveSet, MAX_SETTLING_S, Run, ServoFault, Simulation, Stability, simulate};
use crate::units::Feedrate;

/// What is searched for, and within which bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchingOptions {
    /// Smallest gain margin that proposed gains keep: Kpp stays below its limit by this factor.
    pub least_gain_margin: f64,
    /// Smallest phase margin that proposed gains keep \[rad\].
    pub least_phase_margin_rad: f64,
    /// Feeds between which the limit is searched \[mm/min\].
    pub feeds_mm_per_min: [f64; 2],
}

impl Default for MatchingOptions {
    fn default() -> Self {
        Self {
            least_gain_margin: 2.0,
            least_phase_margin_rad: std::f64::consts::FRAC_PI_4,
            feeds_mm_per_min: [10.0, 20_000.0],
        }
    }
}

/// Gains to set.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchedGains {
    /// Kpp of each axis of the path \[1/s\]; all of them reach the same Kv.
    pub position_gain_per_s: Vec<(AxisLetter, f64)>,
    /// What the path gets with them.
    pub simulation: Simulation,
    /// Whether the target is reached; otherwise these are the best gains within the margins.
    pub reached: bool,
    /// The largest common Kpp within the margins \[1/s\].
    pub largest_per_s: f64,
}

/// How fast the path may be run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedLimit {
    /// Largest contour error allowed \[mm\].
    pub target_mm: f64,
    /// Largest feed that keeps it, and all slower ones tried do; `None`: not even the slowest tried.
    pub feed: Option<Feedrate>,
    /// Whether the fastest feed tried keeps it still: then the limit lies beyond.
    pub beyond_range: bool,
}

/// Both answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Matching {
    /// Present gains, at the feed of the run.
    pub before: Simulation,
    /// Gains for the first target at the feed of the run.
    pub gains: MatchedGains,
    /// Feed limits of the present gains, one for each target.
    pub limits_before: Vec<FeedLimit>,
    /// Feed limits of the matched gains, one for each target.
    pub limits_after: Vec<FeedLimit>,
}

/// Feeds tried before the limit is closed in on, evenly on a logarithmic scale.
const FEEDS_TRIED: u32 = 16;
/// Halvings of the last interval: 2⁻¹² of half a decade is far below what a feed override can set.
const HALVINGS: u32 = 12;
/// Gains tried between the smallest and the largest.
const GAINS_TRIED: u32 = 24;
/// Smallest common gains tried \[1/s\], the first that keeps the margins: lower ones only where 1 does not.
const SMALLEST_GAINS_PER_S: [f64; 4] = [1.0, 0.1, 0.01, 0.001];
/// Largest common gain tried \[1/s\].
const LARGEST_GAIN_PER_S: f64 = 1e4;
/// Most samples of one run: matching makes dozens.
pub const MAX_MATCHING_SAMPLES: usize = 400_000;
/// Halvings of that range on a logarithmic scale.
const GAIN_HALVINGS: u32 = 40;

/// How many samples [`match_gains`] takes at most, roughly: for estimates before the work starts.
#[must_use]
pub fn matching_samples(path: &ServoPath<'_>, run: &Run, targets: usize, options: &MatchingOptions) -> f64 {
    // The gains to be tried are not known yet: the slowest loop that is waited for.
    let settling = if path.is_open() { MAX_SETTLING_S / run.period_s } else { 0.0 };
    let extent = path.extent(run);
    let at_feed = run.samples(&extent) + settling;
    let [slowest, fastest] = options.feeds_mm_per_min;
    let at = |feed: f64| at_feed_of(run, feed).samples(&extent).min(MAX_MATCHING_SAMPLES as f64) + settling;
    let ratio = (fastest / slowest).max(1.0);
    let grid: f64 =
        (0..=FEEDS_TRIED).map(|k| at(slowest * ratio.powf(f64::from(k) / f64::from(FEEDS_TRIED)))).sum();
    // The last intervals lie somewhere between.
    let closing_in = f64::from(HALVINGS) * targets as f64 * at((slowest * fastest).sqrt());
    let gains = f64::from(GAINS_TRIED + HALVINGS + 3) * at_feed;
    gains + 2.0 * (grid + closing_in)
}

/// Answers both questions of matching (P2 §5: unequal gains make the oval, and raising both cannot replace
/// matching). The proposed Kpp is one for all axes, so that the first-order error vanishes, and the smallest that
/// reaches `targets_mm[0]`; margins of every axis are kept.
///
/// # Errors
/// No gain keeps the margins; those of [`simulate`] for the present gains, whose run may have 400 000 samples. Feeds at which a run would have
/// more are not tried.
pub fn match_gains(
    path: &ServoPath<'_>,
    run: &Run,
    drives: &DriveSet,
    targets_mm: &[f64],
    options: &MatchingOptions,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Matching, ServoFault> {
    let samples = run.samples(&path.extent(run));
    if samples.is_nan() || samples > MAX_MATCHING_SAMPLES as f64 {
        return Err(ServoFault::TooManySamples { samples, max: MAX_MATCHING_SAMPLES });
    }
    let before = simulate(path, run, drives, Detail::Summary, stop)?;
    let axes: Vec<AxisLetter> = before.axes.iter().map(|outcome| outcome.axis).collect();
    let gains =
        common_gain(path, run, drives, &axes, targets_mm.first().copied().unwrap_or(0.0), options, stop)?;
    let mut matched = *drives;
    for (axis, gain_per_s) in &gains.position_gain_per_s {
        if let Some(drive) = drives.get(*axis) {
            matched.set(*axis, drive.with_position_gain(*gain_per_s));
        }
    }
    let limits_before = feed_limits(path, run, drives, targets_mm, options, stop)?;
    let limits_after = feed_limits(path, run, &matched, targets_mm, options, stop)?;
    Ok(Matching { before, gains, limits_before, limits_after })
}

/// Kpp of an axis whose Kv is `kv_per_s`.
fn gain_for(drives: &DriveSet, axis: AxisLetter, kv_per_s: f64) -> f64 {
    // With velocity feed-forward Kv = Kpp/(1 − kff); matched Kpp/(1 − kff) is what removes the first order. Where
    // no error is left at all there is nothing to match, and the gain itself is common.
    let left = drives.get(axis).map_or(1.0, |drive| 1.0 - drive.velocity_feedforward);
    if left > 0.0 { kv_per_s * left } else { kv_per_s }
}

fn with_common_kv(drives: &DriveSet, axes: &[AxisLetter], kv_per_s: f64) -> DriveSet {
    let mut set = *drives;
    for axis in axes {
        if let Some(drive) = drives.get(*axis) {
            set.set(*axis, drive.with_position_gain(gain_for(drives, *axis, kv_per_s)));
        }
    }
    set
}

/// Whether every axis keeps the margins.
fn keeps_margins(drives: &DriveSet, axes: &[AxisLetter], options: &MatchingOptions) -> bool {
    axes.iter().filter_map(|axis| drives.get(*axis)).all(|drive| {
        Stability::of(drive).is_ok_and(|stability| {
            stability.gain_margin.is_none_or(|margin| margin >= options.least_gain_margin)
                && stability.phase_margin_rad.is_none_or(|margin| margin >= options.least_phase_margin_rad)
        })
    })
}

/// The smallest common Kv tried and the largest within the margins \[1/s\].
fn common_kv_range(
    drives: &DriveSet,
    axes: &[AxisLetter],
    options: &MatchingOptions,
) -> Result<[f64; 2], ServoFault> {
    let keeps = |kv_per_s: f64| keeps_margins(&with_common_kv(drives, axes, kv_per_s), axes, options);
    let Some(smallest) = SMALLEST_GAINS_PER_S.into_iter().find(|kv_per_s| keeps(*kv_per_s)) else {
        let [.., smallest_per_s] = SMALLEST_GAINS_PER_S;
        return Err(ServoFault::NoGainWithinMargins { smallest_per_s });
    };
    let (mut kept, mut lost) = (smallest, LARGEST_GAIN_PER_S);
    if keeps(lost) {
        return Ok([smallest, lost]);
    }
    for _ in 0..GAIN_HALVINGS {
        let middle = (kept * lost).sqrt();
        if keeps(middle) {
            kept = middle;
        } else {
            lost = middle;
        }
    }
    Ok([smallest, kept])
}

fn common_gain(
    path: &ServoPath<'_>,
    run: &Run,
    drives: &DriveSet,
    axes: &[AxisLetter],
    target_mm: f64,
    options: &MatchingOptions,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<MatchedGains, ServoFault> {
    let [smallest_per_s, largest_per_s] = common_kv_range(drives, axes, options)?;
    let sampled = path.sample(run, stop)?;
    let with =
        |kv_per_s: f64| sampled.simulate(&with_common_kv(drives, axes, kv_per_s), Detail::Summary, stop);
    let ratio = (largest_per_s / smallest_per_s).max(1.0);
    let mut best: Option<(f64, Simulation)> = None;
    let mut too_low = None;
    let mut found = None;
    for k in 0..=GAINS_TRIED {
        let share = f64::from(k) / f64::from(GAINS_TRIED);
        let kv_per_s = smallest_per_s * ratio.powf(share);
        let simulation = match with(kv_per_s) {
            Ok(simulation) => simulation,
            Err(ServoFault::Stopped) => return Err(ServoFault::Stopped),
            // A gain that cannot be run is no candidate.
            Err(_) => continue,
        };
        if simulation.contour.max_abs_mm <= target_mm {
            found = Some((kv_per_s, simulation));
            break;
        }
        too_low = Some(kv_per_s);
        if best.as_ref().is_none_or(|(_, least)| simulation.contour.max_abs_mm < least.contour.max_abs_mm) {
            best = Some((kv_per_s, simulation));
        }
    }
    let reached = found.is_some();
    if let (Some((enough, simulation)), Some(mut low)) = (found.as_mut(), too_low) {
        for _ in 0..HALVINGS {
            let middle = (low * *enough).sqrt();
            let tried = with(middle)?;
            if tried.contour.max_abs_mm <= target_mm {
                (*enough, *simulation) = (middle, tried);
            } else {
                low = middle;
            }
        }
    }
    let (kv_per_s, simulation) = match found.or(best) {
        Some(gains) => gains,
        // Not one gain can be run: the fault of the largest says why.
        None => (largest_per_s, with(largest_per_s)?),
    };
    let gain = |axis: &AxisLetter| (*axis, gain_for(drives, *axis, kv_per_s));
    let position_gain_per_s = axes.iter().map(gain).collect();
    Ok(MatchedGains { position_gain_per_s, simulation, reached, largest_per_s })
}

fn at_feed_of(run: &Run, feed_mm_per_min: f64) -> Run {
    Run { feed: Feedrate::from_mm_per_min(feed_mm_per_min), ..*run }
}

fn feed_limits(
    path: &ServoPath<'_>,
    run: &Run,
    drives: &DriveSet,
    targets_mm: &[f64],
    options: &MatchingOptions,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Vec<FeedLimit>, ServoFault> {
    let extent = path.extent(run);
    let is_short = |feed: f64| at_feed_of(run, feed).samples(&extent) <= MAX_MATCHING_SAMPLES as f64;
    // Infinite where the path cannot be run at this feed.
    let error_mm = |feed_mm_per_min: f64| -> Result<f64, ServoFault> {
        let run = at_feed_of(run, feed_mm_per_min);
        match simulate(path, &run, drives, Detail::Summary, stop) {
            Ok(simulation) => Ok(simulation.contour.max_abs_mm),
            Err(ServoFault::Stopped) => Err(ServoFault::Stopped),
            Err(_) => Ok(f64::INFINITY),
        }
    };
    let [slowest, fastest] = options.feeds_mm_per_min;
    // At a slower feed a run would take more samples than one may have, whatever a profile adds.
    let plain = Run { profile: None, ..*run };
    let slowest = slowest
        .max(run.feed.mm_per_min() * plain.samples(&extent) / MAX_MATCHING_SAMPLES as f64)
        .min(fastest);
    let ratio = (fastest / slowest).max(1.0);
    let mut tried: Vec<(f64, f64)> = Vec::new();
    for k in 0..=FEEDS_TRIED {
        let feed = slowest * ratio.powf(f64::from(k) / f64::from(FEEDS_TRIED));
        if is_short(feed) {
            tried.push((feed, error_mm(feed)?));
        }
    }
    targets_mm
        .iter()
        .map(|&target_mm| {
            let over = tried.iter().position(|(_, error)| *error > target_mm);
            let Some(over) = over else {
                let feed = tried.last().map(|(feed, _)| Feedrate::from_mm_per_min(*feed));
                return Ok(FeedLimit { target_mm, feed, beyond_range: feed.is_some() });
            };
            let Some(under) = over.checked_sub(1) else {
                return Ok(FeedLimit { target_mm, feed: None, beyond_range: false });
            };
            let (mut kept, mut lost) = (tried[under].0, tried[over].0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (kept + lost);
                if error_mm(middle)? <= target_mm {
                    kept = middle;
                } else {
                    lost = middle;
                }
            }
            Ok(FeedLimit { target_mm, feed: Some(Feedrate::from_mm_per_min(kept)), beyond_range: false })
        })
        .collect()
}
