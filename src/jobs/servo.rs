//! Servo simulations, sweeps and matchings, inside the pool.

use std::ops::ControlFlow;

use thiserror::Error;

use super::memory::Account;
use super::{Compute, ComputeFault, Cost, TooCostly};
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::servo::{
    AxisLetter, Detail, DriveSet, Matching, MatchingOptions, Run, ServoFault, ServoPath, Simulation,
    letters_of, match_gains, matching_samples, simulate, sweep_at_feed,
};
use crate::units::Feedrate;
use crate::wire::{CorePath, ServoTask, SweepColumns};

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ServoWorkFault {
    /// The path cannot be run.
    #[error(transparent)]
    Servo(#[from] ServoFault),
    /// The estimate is over the limit.
    #[error(transparent)]
    TooCostly(#[from] TooCostly),
    /// The pool has no place, or the computation panicked.
    #[error(transparent)]
    Compute(#[from] ComputeFault),
}

/// A task with the machine it is for, ready to be run.
#[derive(Debug, Clone)]
pub struct ServoWork {
    /// The task.
    pub task: ServoTask,
    /// The machine; `None` for the two circles.
    pub machine: Option<Machine>,
    /// Largest estimate \[s of one core\].
    pub max_cost_s: f64,
}

impl ServoWork {
    /// Runs `work` with the path, which borrows the machine.
    fn with_path<T>(&self, work: impl FnOnce(&ServoPath<'_>) -> T) -> Result<T, ServoFault> {
        match (&self.task.path, &self.machine) {
            (CorePath::Circle(circle), _) => Ok(work(&ServoPath::Circle(*circle))),
            (CorePath::Tool { path, plane_normal }, Some(machine)) => {
                let kinematics = Kinematics::new(machine, &self.task.setup);
                let plane_normal = *plane_normal;
                Ok(work(&ServoPath::Tool { machine, kinematics: &kinematics, path, plane_normal }))
            }
            // This was refused with the request: the path needs a machine.
            (CorePath::Tool { .. }, None) => Err(ServoFault::NoLength),
        }
    }

    /// The axes of the run, in the order of the trace.
    #[must_use]
    pub fn axes(&self) -> Vec<AxisLetter> {
        match (&self.task.path, &self.machine) {
            (CorePath::Circle(circle), _) => circle.axes().to_vec(),
            (CorePath::Tool { .. }, machine) => {
                machine.as_ref().map_or_else(Vec::new, |machine| letters_of(machine).to_vec())
            }
        }
    }

    fn check_cost(&self, samples: f64) -> Result<(), TooCostly> {
        Cost::of_servo(samples, matches!(self.task.path, CorePath::Tool { .. })).within(self.max_cost_s)
    }

    /// One path at one feed; `account` reserves the memory of its trace.
    ///
    /// # Errors
    /// The path cannot be run, or costs too much, or there is no memory for its trace.
    pub fn simulate(
        &self,
        account: Option<&Account>,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Simulation, ServoWorkFault> {
        /// Memory of a trace for each sample: measured as 30 for two million samples.
        const SAMPLE_BYTES: u64 = 32;
        /// More samples are refused before any is computed.
        const MAX_SAMPLES: f64 = 2e6;
        let ServoTask { drives, run, .. } = &self.task;
        self.with_path(|path| {
            let samples = run.samples(&path.extent(run)) + path.settling_samples(run, drives);
            self.check_cost(samples)?;
            if let Some(account) = account {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "between 0 and 2e6"
                )]
                let samples = samples.clamp(0.0, MAX_SAMPLES) as u64;
                account.keep(samples * SAMPLE_BYTES).map_err(ComputeFault::from)?;
            }
            Ok(simulate(path, run, drives, Detail::Trace, stop)?)
        })?
    }

    /// Gains and feed limits.
    ///
    /// # Errors
    /// The path cannot be run with the present gains, or costs too much.
    pub fn match_gains(
        &self,
        targets_mm: &[f64],
        options: &MatchingOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Matching, ServoWorkFault> {
        let ServoTask { drives, run, .. } = &self.task;
        self.with_path(|path| {
            self.check_cost(matching_samples(path, run, targets_mm.len(), options))?;
            Ok(match_gains(path, run, drives, targets_mm, options, stop)?)
        })?
    }

    fn columns(
        &self,
        feeds: &[f64],
        sets: &[DriveSet],
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<SweepColumns, ServoWorkFault> {
        self.with_path(|path| {
            let at = |feed: &f64| Run { feed: Feedrate::from_mm_per_min(*feed), ..self.task.run };
            feeds.iter().map(|feed| Ok(sweep_at_feed(path, &at(feed), sets, stop)?)).collect()
        })?
    }

    fn sweep_samples(&self, feeds: &[f64], sets: &[DriveSet]) -> Result<f64, ServoFault> {
        self.with_path(|path| {
            let at = |feed: &f64| Run { feed: Feedrate::from_mm_per_min(*feed), ..self.task.run };
            let settling: f64 = sets.iter().map(|set| path.settling_samples(&self.task.run, set)).sum();
            let extent = path.extent(&self.task.run);
            let moving: f64 = feeds.iter().map(|feed| at(feed).samples(&extent)).sum();
            moving * sets.len() as f64 + settling * feeds.len() as f64
        })
    }

    /// Every set of drives at every feed. The feeds are distributed to as many computations as run at the same time,
    /// and joined in their order: the answer does not depend on their number.
    ///
    /// # Errors
    /// The path cannot be sampled at one of the feeds, or the total cost is too large.
    /// A path that cannot be sampled at one of the feeds, or too much in all.
    pub async fn sweep(
        self,
        compute: &Compute,
        feeds: Vec<f64>,
        sets: Vec<DriveSet>,
    ) -> Result<SweepColumns, ServoWorkFault> {
        let (work, all_feeds, all_sets) = (self.clone(), feeds.clone(), sets.clone());
        // The poles of thousands of drives take a while.
        let samples = compute.run(move |_stop| work.sweep_samples(&all_feeds, &all_sets)).await??;
        self.check_cost(samples)?;
        let parts = compute.side_by_side().min(feeds.len()).max(1);
        // Slow feeds take more samples: each part gets every n-th feed.
        let work = (0..parts).map(|part| {
            let own: Vec<f64> = feeds.iter().skip(part).step_by(parts).copied().collect();
            let (work, sets) = (self.clone(), sets.clone());
            compute.run(move |stop| work.columns(&own, &sets, stop))
        });
        let mut parts_done = Vec::with_capacity(parts);
        for part in futures::future::join_all(work).await {
            parts_done.push(part??.into_iter());
        }
        let mut columns = Vec::with_capacity(feeds.len());
        for index in 0..feeds.len() {
            columns.extend(parts_done[index % parts].next());
        }
        Ok(columns)
    }
}
