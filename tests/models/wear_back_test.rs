//! Back-tests of the parts left: what is told from the readings up to some part, against when the wear reached the
//! limit.

use trunnion::wear::{CutterLife, LifeEnds, WearCourse, WearReading, cutter_life};

/// mm per µm.
pub(crate) const UM: f64 = 1e-3;
/// What an interval of 95 % may miss on either side.
const TAIL: f64 = 0.025;
/// Standard deviations that luck may add: one test in seven hundred fails by chance.
const LUCK: f64 = 3.0;

/// The largest share of `tries` that an end may miss by luck (binomial).
pub(crate) fn allowed(tries: u32) -> f64 {
    TAIL + LUCK * (TAIL * (1.0 - TAIL) / f64::from(tries.max(1))).sqrt()
}

/// Random numbers that are the same everywhere: xorshift, and normal ones by Box and Muller.
#[derive(Debug, Clone)]
pub(crate) struct Draws(pub(crate) u64);

impl Draws {
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let (length, turn) = (self.uniform(), self.uniform());
        (-2.0 * length.ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
    }

    pub(crate) fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.uniform()
    }

    /// As likely in any equal ratio.
    pub(crate) fn ratio(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }
}

/// How readings are taken: nobody tells the model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Microscope {
    /// Standard deviation of a reading [µm].
    pub(crate) scatter_um: f64,
    /// Correlation of the errors of neighbouring readings.
    pub(crate) correlation: f64,
    /// Error of the next reading, over the standard deviation.
    error: f64,
}

impl Microscope {
    pub(crate) fn new(scatter_um: f64, correlation: f64, draws: &mut Draws) -> Self {
        Self { scatter_um, correlation, error: draws.normal() }
    }

    /// A reading of this wear.
    pub(crate) fn read(&mut self, parts_cut: usize, wear_um: f64, draws: &mut Draws) -> WearReading {
        let read_um = (wear_um + self.scatter_um * self.error).max(0.0);
        let fresh = (1.0 - self.correlation * self.correlation).sqrt();
        self.error = self.correlation * self.error + fresh * draws.normal();
        WearReading {
            parts_cut: u32::try_from(parts_cut).expect("parts of a curve"),
            wear_mm: read_um * UM,
            standard_uncertainty_mm: None,
        }
    }
}

/// One prediction and what became of it.
#[derive(Debug, Clone)]
pub(crate) struct Trial {
    pub(crate) readings: Vec<WearReading>,
    pub(crate) limit_um: f64,
    /// Parts at which the wear reaches the limit.
    pub(crate) truth: f64,
}

/// How often an interval was wrong, and how wide it was.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    pub(crate) tries: u32,
    /// The limit reached before the early end.
    pub(crate) early: u32,
    /// The limit reached after the late end.
    pub(crate) late: u32,
    /// Late ends that were told.
    pub(crate) told: u32,
    /// Parts from now to the early end, over those to the truth.
    to_early: Vec<f64>,
    /// Parts from the early to the late end, over those to the truth, where both were told.
    widths: Vec<f64>,
}

impl Tally {
    fn add(&mut self, ends: &LifeEnds, reach: f64, now: f64, truth: f64) {
        // Where there is no early end, nothing below the reach was said to be safe but all of it was.
        let earliest = ends.earliest.unwrap_or(reach);
        self.tries += 1;
        self.early += u32::from(earliest > truth);
        self.told += u32::from(ends.latest.is_some());
        self.late += u32::from(ends.latest.is_some_and(|latest| latest < truth));
        self.to_early.push((earliest - now) / (truth - now));
        self.widths.extend(ends.latest.map(|latest| (latest - earliest) / (truth - now)));
    }

    pub(crate) fn join(&mut self, other: &Self) {
        self.tries += other.tries;
        self.early += other.early;
        self.late += other.late;
        self.told += other.told;
        self.to_early.extend(&other.to_early);
        self.widths.extend(&other.widths);
    }

    pub(crate) fn early_share(&self) -> f64 {
        f64::from(self.early) / f64::from(self.tries.max(1))
    }

    /// Of the late ends that were told: what is not told cannot be wrong.
    pub(crate) fn late_share(&self) -> f64 {
        f64::from(self.late) / f64::from(self.told.max(1))
    }

    pub(crate) fn told_share(&self) -> f64 {
        f64::from(self.told) / f64::from(self.tries.max(1))
    }

    pub(crate) fn middle_to_early(&self) -> f64 {
        middle(&self.to_early)
    }

    pub(crate) fn middle_width(&self) -> f64 {
        middle(&self.widths)
    }

    /// Both ends hold, to the luck of so many tries.
    pub(crate) fn holds(&self) -> bool {
        self.early_share() <= allowed(self.tries) && self.late_share() <= allowed(self.told)
    }

    /// A row of a table.
    pub(crate) fn row(&self) -> String {
        let per_cent = |share: f64| format!("{:.1} %", 100.0 * share);
        format!(
            "{} | {} of {} ({}) | {} of {} ({}) | {:.2} | {:.1}",
            per_cent(1.0 - f64::from(self.early + self.late) / f64::from(self.tries.max(1))),
            self.early,
            self.tries,
            per_cent(self.early_share()),
            self.late,
            self.told,
            per_cent(self.late_share()),
            self.middle_to_early(),
            self.middle_width()
        )
    }
}

fn middle(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The whole interval, and the one that holds as long as no new stage of wear begins.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tallies {
    pub(crate) whole: Tally,
    pub(crate) same_stage: Tally,
}

impl Tallies {
    /// What is told from the readings of a trial, against what became of it.
    pub(crate) fn add(&mut self, trial: &Trial) -> CutterLife {
        let course = WearCourse::of(&trial.readings).expect("a course");
        let now = course.last_parts();
        let life = cutter_life(&[&course], trial.limit_um * UM, now);
        self.whole.add(&life.ends, life.reach, f64::from(now), trial.truth);
        self.same_stage.add(&life.same_stage, life.reach, f64::from(now), trial.truth);
        life
    }

    pub(crate) fn join(&mut self, other: &Self) {
        self.whole.join(&other.whole);
        self.same_stage.join(&other.same_stage);
    }
}
