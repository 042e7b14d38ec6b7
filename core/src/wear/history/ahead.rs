//! Possible courses of an edge's wear after its last reading.

use super::WearCourse;
use super::course::Component;
use super::normal::{self, Draws};

/// Number of simulated courses: 50 of them are beyond each end of the 95 % interval.
pub(super) const DRAWN: usize = 2000;
/// Number of positions along each course at which its wear is kept, closer together at the beginning.
const PLACES: u32 = 40;
/// Largest length of a course, in spans of the readings.
const FARTHEST: f64 = 30.0;
/// Steps of an even sequence over a square, from the plastic number (1.3247…). It leaves no gaps.
const EVEN: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// Mean number of new stages of wear that begin within a span of the readings.
///
/// Wear starts fast, continues steadily and ends fast, and a stage may begin at any time: readings of a steady
/// stage do not tell when it ends. The values of this and the next constants were chosen so that the ends hold on
/// simulated cutters that enter a rapid stage without warning, and on a real cutter whose wear stood still twice.
pub const STAGES_PER_SPAN: f64 = 3.0;
/// Share of the new stages in which the wear almost stands still.
pub const STANDSTILLS: f64 = 0.5;
/// Mean length of these stages, relative to the parts since the cutter was new. On the real cutters examined, flank
/// wear stood still for 0.6 and 0.7 of their age, and once, just after running in, for 1.5.
pub const STANDSTILL_OF_AGE: f64 = 0.6;
/// Largest rate of a standstill, relative to the reference.
const STILL: f64 = 0.03;
/// Rates of any other new stage, relative to the reference, with a uniform logarithmic distribution between these.
/// The end of a life has two to six times the rate of its middle, and its beginning may hide in the last readings.
pub const STAGE_RATES: [f64; 2] = [0.5, 8.0];

/// Courses of one edge, with new stages of wear and without.
#[derive(Debug, Clone)]
pub(super) struct Ahead {
    /// Parts at each position kept.
    parts: Vec<f64>,
    /// Wear at these positions \[mm\], course after course.
    same_mm: Vec<f64>,
    staged_mm: Vec<f64>,
}

/// Whether new stages of wear begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stages {
    /// The rate continues to vary as before.
    Same,
    /// New stages begin.
    New,
}

/// Wear \[mm\] and rate \[mm per span\] along a course, with the values that set a new stage.
struct Going {
    wear: f64,
    rate: f64,
    /// Start of the next stage \[spans\]; infinite in the last stage.
    next: f64,
    is_still: bool,
    reference: f64,
    /// Spans since the cutter was new.
    age: f64,
}

impl Going {
    /// Continues from `from` to `to`, while the rate varies by `strays`. At zero the rate is reflected, because
    /// wear does not decrease.
    fn go(&mut self, mut from: f64, to: f64, strays: f64, draws: &mut Draws) {
        while self.next < to {
            self.wear += (self.next - from) * self.rate;
            from = self.next;
            self.turn(draws);
        }
        let rate = if self.is_still { self.rate } else { (self.rate + strays).abs() };
        self.wear += (to - from) * 0.5 * (self.rate + rate);
        self.rate = rate;
    }

    /// Begins a new stage.
    fn turn(&mut self, draws: &mut Draws) {
        self.is_still = !self.is_still && draws.uniform() < STANDSTILLS;
        let chance = draws.uniform();
        if self.is_still {
            self.rate = STILL * self.reference * chance;
            self.next += draws.waiting() * STANDSTILL_OF_AGE * self.age;
        } else {
            let [least, most] = STAGE_RATES;
            self.rate = self.reference * least * (chance * (most / least).ln()).exp();
            self.next += draws.waiting() / STAGES_PER_SPAN;
        }
    }
}

impl Ahead {
    /// Courses up to `until_parts`, or up to the largest length. The same readings give the same courses: the
    /// random numbers are a fixed sequence.
    pub(super) fn of(course: &WearCourse, until_parts: f64) -> Self {
        let span = course.span();
        let last = f64::from(course.last_parts());
        let horizon = ((until_parts - last) / span).clamp(0.0, FARTHEST);
        let places: Vec<f64> =
            (0..=PLACES).map(|k| horizon * (f64::from(k) / f64::from(PLACES)).powi(2)).collect();
        let mut same_mm = Vec::with_capacity(DRAWN * places.len());
        let mut staged_mm = Vec::with_capacity(DRAWN * places.len());
        let mut straying = Draws::new(DRAWN as u64);
        let mut strays = vec![0.0; PLACES as usize + 1];
        let mut components = Even::of(course.components());
        for index in 0..DRAWN {
            // Every other course varies in the opposite direction, so that the middle stays in the middle.
            if index % 2 == 0 {
                for pair in strays.chunks_mut(2) {
                    pair.iter_mut().zip(straying.normals()).for_each(|(stray, drawn)| *stray = drawn);
                }
            } else {
                for stray in &mut strays {
                    *stray = -*stray;
                }
            }
            // Each course has its own random numbers, so that readings that hardly differ give results that hardly
            // differ.
            let mut draws = Draws::new(index as u64);
            let Some(component) = components.at((index as f64 + 0.5) / DRAWN as f64) else { break };
            let [wear, rate] = beginning(component, index);
            let reference = component.reference.max(rate);
            let age = last / span;
            let start = |next| Going { wear, rate, next, is_still: false, reference, age };
            let (mut same, mut staged) = (start(f64::INFINITY), start(draws.waiting() / STAGES_PER_SPAN));
            same_mm.push(same.wear);
            staged_mm.push(staged.wear);
            for (pair, stray) in places.windows(2).zip(&strays) {
                let [from, to] = pair else { continue };
                let stray = component.drift * component.reference * (to - from).sqrt() * stray;
                same.go(*from, *to, stray, &mut draws);
                staged.go(*from, *to, stray, &mut draws);
                same_mm.push(same.wear);
                staged_mm.push(staged.wear);
            }
        }
        let parts = places.into_iter().map(|place| last + place * span).collect();
        Self { parts, same_mm, staged_mm }
    }

    fn courses(&self, stages: Stages) -> impl Iterator<Item = &[f64]> {
        let wear_mm = match stages {
            Stages::Same => &self.same_mm,
            Stages::New => &self.staged_mm,
        };
        wear_mm.chunks_exact(self.parts.len())
    }

    /// The parts at which each course reaches `limit_mm`, in order; infinite if it does not reach it within its
    /// length.
    pub(super) fn reached(&self, stages: Stages, limit_mm: f64) -> Vec<f64> {
        let mut reached: Vec<f64> = self
            .courses(stages)
            .map(|wear_mm| {
                // Wear does not decrease, so the positions are in order.
                let after = wear_mm.partition_point(|wear| *wear < limit_mm);
                let Some(high) = self.parts.get(after) else { return f64::INFINITY };
                let Some(before) = after.checked_sub(1) else { return *high };
                match (self.parts.get(before), wear_mm.get(before), wear_mm.get(after)) {
                    (Some(low), Some(from), Some(to)) => low + (high - low) * (limit_mm - from) / (to - from),
                    _ => *high,
                }
            })
            .collect();
        reached.sort_by(f64::total_cmp);
        reached
    }

    /// The wear of each course after `parts` parts \[mm\], in order. Beyond the last position, the wear there.
    pub(super) fn wear_mm(&self, stages: Stages, parts: f64) -> Vec<f64> {
        let after =
            self.parts.partition_point(|place| *place < parts).min(self.parts.len().saturating_sub(1));
        let before = after.saturating_sub(1);
        let (low, high) = (self.parts.get(before), self.parts.get(after));
        let share = match (low, high) {
            (Some(low), Some(high)) if high > low => ((parts - low) / (high - low)).clamp(0.0, 1.0),
            _ => 1.0,
        };
        let mut wear_mm: Vec<f64> = self
            .courses(stages)
            .filter_map(|wear_mm| {
                let (from, to) = (wear_mm.get(before)?, wear_mm.get(after)?);
                Some(from + share * (to - from))
            })
            .collect();
        wear_mm.sort_by(f64::total_cmp);
        wear_mm
    }
}

/// The predicted wear of an edge \[mm\]: the values exceeded with 97.5 % and with 2.5 %, and the median if no new
/// stage begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearAhead {
    /// Parts cut since the cutter was new.
    pub parts: f64,
    /// Exceeded with 97.5 % and with 2.5 %, whatever stage of wear comes next.
    pub ends_mm: [f64; 2],
    /// The same if no new stage begins.
    pub same_stage_mm: [f64; 2],
    /// Median if no new stage begins.
    pub middle_mm: f64,
}

/// The predicted wear of an edge after each of these numbers of parts.
#[must_use]
pub fn wear_ahead(course: &WearCourse, parts: &[f64]) -> Vec<WearAhead> {
    let until = parts.iter().copied().fold(f64::from(course.last_parts()), f64::max);
    let ahead = Ahead::of(course, until);
    let ends = |stages, parts| {
        let wear_mm = ahead.wear_mm(stages, parts);
        Some([*wear_mm.get(DRAWN / 40)?, *wear_mm.get(DRAWN - 1 - DRAWN / 40)?])
    };
    parts
        .iter()
        .filter_map(|parts| {
            let same_stage_mm = ends(Stages::Same, *parts)?;
            Some(WearAhead {
                parts: *parts,
                ends_mm: ends(Stages::New, *parts)?,
                same_stage_mm,
                middle_mm: course.middle_mm(*parts, same_stage_mm),
            })
        })
        .collect()
}

/// Initial wear \[mm\] and rate \[mm per span\] of a course. They come from the distribution of one component, with
/// a rate above zero, spread evenly over the courses.
fn beginning(component: &Component, index: usize) -> [f64; 2] {
    let even = |step: f64| ((index as f64 + 0.5) * step).fract();
    let [of_rate, of_wear] = EVEN.map(even);
    let covariance = &component.covariance;
    let deviation = covariance.m22.max(f64::MIN_POSITIVE).sqrt();
    let falling = normal::below(-component.end.y / deviation);
    let turned = normal::quantile(falling + (1.0 - falling) * of_rate);
    let rate = (component.end.y + deviation * turned).max(0.0);
    let common = covariance.m12 / deviation;
    let left = (covariance.m11 - common * common).max(0.0).sqrt();
    let wear =
        component.end.x + common * (rate - component.end.y) / deviation + left * normal::quantile(of_wear);
    [wear, rate]
}

/// Components chosen in proportion to their shares.
struct Even<'a> {
    components: &'a [Component],
    index: usize,
    sum: f64,
}

impl<'a> Even<'a> {
    fn of(components: &'a [Component]) -> Self {
        Self { components, index: 0, sum: 0.0 }
    }

    /// The component at this point of the sum of shares. Points must be requested in order.
    fn at(&mut self, part: f64) -> Option<&'a Component> {
        while let Some(component) = self.components.get(self.index) {
            if part < self.sum + component.share || self.index + 1 == self.components.len() {
                return Some(component);
            }
            self.sum += component.share;
            self.index += 1;
        }
        None
    }
}
