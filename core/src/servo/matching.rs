//! Proposals: gains that bring the contour error below a target, and the feed that the present gains allow.

use std::ops::ControlFlow;

use super::sweep::ServoPath;
use super::{AxisLetter, Detail, DriveSet, MAX_SETTLING_S, Run, ServoFault, Simulation, Stability, simulate};
use crate::units::Feedrate;

/// The bounds of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchingOptions {
    /// Smallest gain margin of proposed gains: Kpp stays below its limit by this factor.
    pub least_gain_margin: f64,
    /// Smallest phase margin of proposed gains \[rad\].
    pub least_phase_margin_rad: f64,
    /// Range of feeds in which the limit is searched \[mm/min\].
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

/// Proposed gains.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchedGains {
    /// Kpp of each axis of the path \[1/s\]; all of them reach the same Kv.
    pub position_gain_per_s: Vec<(AxisLetter, f64)>,
    /// The result on the path with these gains.
    pub simulation: Simulation,
    /// Whether the target is reached. If not, these are the best gains within the margins.
    pub reached: bool,
    /// The largest common Kpp within the margins \[1/s\].
    pub largest_per_s: f64,
}

/// The largest feed of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedLimit {
    /// Largest contour error allowed \[mm\].
    pub target_mm: f64,
    /// Largest feed that keeps the target together with all slower feeds tried. `None`: not even the slowest feed
    /// keeps it.
    pub feed: Option<Feedrate>,
    /// Whether the fastest feed tried still keeps it. The limit is then beyond the range.
    pub beyond_range: bool,
}

/// Both proposals.
#[derive(Debug, Clone, PartialEq)]
pub struct Matching {
    /// The simulation with present gains, at the feed of the run.
    pub before: Simulation,
    /// Gains for the first target at the feed of the run.
    pub gains: MatchedGains,
    /// Feed limits of the present gains, one for each target.
    pub limits_before: Vec<FeedLimit>,
    /// Feed limits of the matched gains, one for each target.
    pub limits_after: Vec<FeedLimit>,
}

/// Number of feeds tried before the limit is narrowed down, evenly on a logarithmic scale.
const FEEDS_TRIED: u32 = 16;
/// Halvings of the last interval: 2⁻¹² of half a decade is far below what a feed override can set.
const HALVINGS: u32 = 12;
/// Number of gains tried between the smallest and the largest.
const GAINS_TRIED: u32 = 24;
/// Smallest common gains tried \[1/s\]. The first that keeps the margins is used: lower gains only if 1 does not.
const SMALLEST_GAINS_PER_S: [f64; 4] = [1.0, 0.1, 0.01, 0.001];
/// Largest common gain tried \[1/s\].
const LARGEST_GAIN_PER_S: f64 = 1e4;
/// Most samples of one run. Matching makes dozens of runs.
pub const MAX_MATCHING_SAMPLES: usize = 400_000;
/// Halvings of that range on a logarithmic scale.
const GAIN_HALVINGS: u32 = 40;

/// Approximate upper bound on the samples of [`match_gains`], for estimates before the work starts.
#[must_use]
pub fn matching_samples(path: &ServoPath<'_>, run: &Run, targets: usize, options: &MatchingOptions) -> f64 {
    // The gains to be tried are not known yet: this is the slowest loop with a limited settling time.
    let settling = if path.is_open() { MAX_SETTLING_S / run.period_s } else { 0.0 };
    let extent = path.extent(run);
    let at_feed = run.samples(&extent) + settling;
    let [slowest, fastest] = options.feeds_mm_per_min;
    let at = |feed: f64| at_feed_of(run, feed).samples(&extent).min(MAX_MATCHING_SAMPLES as f64) + settling;
    let ratio = (fastest / slowest).max(1.0);
    let grid: f64 =
        (0..=FEEDS_TRIED).map(|k| at(slowest * ratio.powf(f64::from(k) / f64::from(FEEDS_TRIED)))).sum();
    // The last intervals are somewhere between.
    let closing_in = f64::from(HALVINGS) * targets as f64 * at((slowest * fastest).sqrt());
    let gains = f64::from(GAINS_TRIED + HALVINGS + 3) * at_feed;
    gains + 2.0 * (grid + closing_in)
}

/// Answers both questions of matching (P2 §5: unequal gains make the oval, and raising both cannot replace
/// matching). All axes get the same Kpp, so that the first-order error vanishes. It is the smallest Kpp that
/// reaches `targets_mm[0]`, and every axis keeps its margins.
///
/// # Errors
/// No gain keeps the margins; those of [`simulate`] for the present gains, whose run may have 400 000 samples.
/// Feeds that would need more samples are not tried.
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
    // With velocity feed-forward Kv = Kpp/(1 − kff); equal values of Kpp/(1 − kff) remove the first order. If no
    // error remains there is nothing to match, and the gain itself is common.
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
            // A gain that cannot be run is not a candidate.
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
        // No gain can be run: the fault of the largest gain says why.
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
    // Infinite if the path cannot be run at this feed.
    let error_mm = |feed_mm_per_min: f64| -> Result<f64, ServoFault> {
        let run = at_feed_of(run, feed_mm_per_min);
        match simulate(path, &run, drives, Detail::Summary, stop) {
            Ok(simulation) => Ok(simulation.contour.max_abs_mm),
            Err(ServoFault::Stopped) => Err(ServoFault::Stopped),
            Err(_) => Ok(f64::INFINITY),
        }
    };
    let [slowest, fastest] = options.feeds_mm_per_min;
    // At a slower feed a run would need more samples than allowed, even without a profile.
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
