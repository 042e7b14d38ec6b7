//! One axis stepped through its command, eight samples at a time.
//!
//! The loop is bound by the loads of its coefficients, and a state waits for the one before. So a block's states are
//! taken along with the next block's commands, column by column: the processor works on one while the other waits.
//! Positions go through a small array, because a growing vector in the loop would push all sums out of the registers.
//! Every sum keeps its order, commands first and then states; `tests::plain` is the same without these means.
//!
//! Instructions of 512 bits take the same loads and gain nothing, so the widest ones used are AVX2.

use multiversion::multiversion;
use nalgebra::{DVector, SMatrix, SVector};

use super::{Drive, StateSpace, Step, TooStiff};
use crate::kinematics::InstructionSet;

/// Samples in a block.
const BLOCK: usize = 8;
/// Number of commands on which a block depends: those of its samples and the one before.
const COMMANDS: usize = BLOCK + 1;
/// The samples of a block on which its second half of commands has no effect, because they come before it.
const EARLY: usize = BLOCK / 2;
/// Blocks whose positions are collected before they leave: 2 KiB. With more, the array and the commands displace one
/// another in the cache.
const BATCH: usize = 32;
/// Lanes of a rigid axis: eight positions and four states. With a resonance: eight and six, and two are empty.
const RIGID: usize = 12;
const RESONANT: usize = 16;

/// A moving axis: `y[8] = O z + T r`, `z⁺ = Φ⁸ z + G r`, one column for each state and each command, so that
/// every instruction works on many lanes. The numbers are the same with every instruction set.
#[derive(Debug, Clone)]
pub struct AxisServo {
    lanes: Lanes,
    /// The command at the present time.
    command: f64,
    instructions: InstructionSet,
}

#[derive(Debug, Clone)]
enum Lanes {
    Rigid(Box<Block<4, RIGID>>),
    Resonant(Box<Block<6, RESONANT>>),
}

/// Aligned, so that no load of four lanes touches two lines of the cache.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct Block<const STATES: usize, const LANES: usize> {
    of_commands: [[f64; LANES]; COMMANDS],
    of_states: [[f64; LANES]; STATES],
    /// The lanes of the last block. The states come after its positions.
    last: [f64; LANES],
    single: Single<STATES>,
}

/// Lanes that no load of four splits.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Aligned<T>(T);

/// One step, by columns.
#[derive(Debug, Clone)]
struct Single<const STATES: usize> {
    transition: [[f64; STATES]; STATES],
    from_old: [f64; STATES],
    from_new: [f64; STATES],
    output: usize,
}

impl AxisServo {
    /// The axis at rest at `start` (mm, or rad), to be sampled every `period_s`.
    ///
    /// # Errors
    /// The loops are too stiff for this period.
    pub fn new(drive: &Drive, period_s: f64, start: f64) -> Result<Self, TooStiff> {
        let system = StateSpace::of(drive);
        let step = Step::new(&system, period_s)?;
        let state = system.at_rest(start);
        let lanes = if system.states() == 4 {
            Lanes::Rigid(Box::new(Block::new(&step, &state)))
        } else {
            Lanes::Resonant(Box::new(Block::new(&step, &state)))
        };
        Ok(Self { lanes, command: start, instructions: InstructionSet::Fastest })
    }

    /// The same axis, without instructions wider than these.
    #[must_use]
    pub fn with_instructions(self, instructions: InstructionSet) -> Self {
        Self { instructions, ..self }
    }

    /// Follows the next samples of the command and writes the positions at the same times. A run may be split
    /// into calls anywhere, but it gives the same bits only if split at multiples of eight.
    pub fn follow(&mut self, commands: &[f64], positions: &mut Vec<f64>) {
        positions.clear();
        positions.reserve(commands.len() + BLOCK);
        let set = self.instructions;
        match &mut self.lanes {
            Lanes::Rigid(block) => block.follow(set, &mut self.command, commands, positions),
            Lanes::Resonant(block) => block.follow(set, &mut self.command, commands, positions),
        }
    }
}

impl<const STATES: usize, const LANES: usize> Block<STATES, LANES> {
    fn new(step: &Step, state: &DVector<f64>) -> Self {
        let mut of_commands = [[0.0; LANES]; COMMANDS];
        let mut of_states = [[0.0; LANES]; STATES];
        // The effect of each state and each command after one step, two, … eight. The size is fixed, so that no
        // product depends on the processor.
        let transition =
            SMatrix::<f64, STATES, STATES>::from_fn(|row, column| step.transition[(row, column)]);
        let from_old = SVector::<f64, STATES>::from_fn(|row, _| step.from_old[row]);
        let from_new = SVector::<f64, STATES>::from_fn(|row, _| step.from_new[row]);
        let mut from_states = SMatrix::<f64, STATES, STATES>::identity();
        let mut from_commands = SMatrix::<f64, STATES, COMMANDS>::zeros();
        for k in 0..BLOCK {
            from_states = transition * from_states;
            from_commands = transition * from_commands;
            from_commands.column_mut(k).axpy(1.0, &from_old, 1.0);
            from_commands.column_mut(k + 1).axpy(1.0, &from_new, 1.0);
            for (column, lanes) in of_states.iter_mut().enumerate() {
                lanes[k] = from_states[(step.output, column)];
            }
            for (column, lanes) in of_commands.iter_mut().enumerate() {
                lanes[k] = from_commands[(step.output, column)];
            }
        }
        for row in 0..STATES {
            for (column, lanes) in of_states.iter_mut().enumerate() {
                lanes[BLOCK + row] = from_states[(row, column)];
            }
            for (column, lanes) in of_commands.iter_mut().enumerate() {
                lanes[BLOCK + row] = from_commands[(row, column)];
            }
        }
        let single = Single {
            transition: std::array::from_fn(|column| {
                std::array::from_fn(|row| step.transition[(row, column)])
            }),
            from_old: std::array::from_fn(|row| step.from_old[row]),
            from_new: std::array::from_fn(|row| step.from_new[row]),
            output: step.output,
        };
        let mut last = [0.0; LANES];
        last[BLOCK..BLOCK + STATES].copy_from_slice(state.as_slice());
        Self { of_commands, of_states, last, single }
    }

    fn follow(&mut self, set: InstructionSet, before: &mut f64, commands: &[f64], positions: &mut Vec<f64>) {
        let (blocks, rest) = commands.as_chunks::<BLOCK>();
        match set {
            InstructionSet::Baseline => step_loop(self, before, blocks, positions),
            InstructionSet::Avx2 | InstructionSet::Avx512 | InstructionSet::Fastest => {
                step_avx2(self, before, blocks, positions);
            }
        }
        self.step_rest(before, rest, positions);
    }

    /// Processes fewer samples than a block, one step each.
    fn step_rest(&mut self, before: &mut f64, rest: &[f64], positions: &mut Vec<f64>) {
        for &command in rest {
            let mut after = [0.0; STATES];
            for (row, value) in after.iter_mut().enumerate() {
                *value = self.single.from_old[row] * *before + self.single.from_new[row] * command;
                for column in 0..STATES {
                    *value += self.single.transition[column][row] * self.last[BLOCK + column];
                }
            }
            self.last[BLOCK..BLOCK + STATES].copy_from_slice(&after);
            *before = command;
            positions.push(after[self.single.output]);
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn step_avx2<const STATES: usize, const LANES: usize>(
    block: &mut Block<STATES, LANES>,
    before: &mut f64,
    commands: &[[f64; BLOCK]],
    positions: &mut Vec<f64>,
) {
    step_loop(block, before, commands, positions);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn step_loop<const STATES: usize, const LANES: usize>(
    block: &mut Block<STATES, LANES>,
    before: &mut f64,
    commands: &[[f64; BLOCK]],
    positions: &mut Vec<f64>,
) {
    let [Some(first), Some(end)] = [commands.first(), commands.last()] else { return };
    let mut batch_positions = Aligned([[0.0; BLOCK]; BATCH]);
    let mut last = block.last;
    let mut share = block.of_commands[0].map(|share| share * *before);
    for k in 0..BLOCK {
        add_command(&mut share, &block.of_commands[k + 1], first, k);
    }
    let mut from_commands = Aligned(share);
    let mut following = 0;
    for batch in commands.chunks(BATCH) {
        for (now, out) in batch.iter().zip(&mut batch_positions.0) {
            following += 1;
            // After the last block any commands will do: their share is not used.
            let next = commands.get(following).unwrap_or(first);
            let mut sum = from_commands.0;
            let mut share = block.of_commands[0].map(|share| share * now[BLOCK - 1]);
            for k in 0..BLOCK {
                if k < STATES {
                    add_scaled(&mut sum, &block.of_states[k], last[BLOCK + k]);
                }
                add_command(&mut share, &block.of_commands[k + 1], next, k);
            }
            from_commands = Aligned(share);
            out.copy_from_slice(&sum[..BLOCK]);
            last = sum;
        }
        positions.extend_from_slice(batch_positions.0[..batch.len()].as_flattened());
    }
    block.last = last;
    *before = end[BLOCK - 1];
}

/// Adds the share of the block's command `k`. Of the first samples a late command would add zero.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn add_command<const LANES: usize>(
    sum: &mut [f64; LANES],
    column: &[f64; LANES],
    commands: &[f64; BLOCK],
    k: usize,
) {
    if k < EARLY {
        add_scaled(sum, column, commands[k]);
    } else {
        // Iterators with a start of their own are not turned into instructions on lanes.
        for lane in EARLY..LANES {
            sum[lane] += column[lane] * commands[k];
        }
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn add_scaled<const LANES: usize>(sum: &mut [f64; LANES], column: &[f64; LANES], factor: f64) {
    for (sum, share) in sum.iter_mut().zip(column) {
        *sum += share * factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::{DrivePreset, Resonance};

    /// The same sums one after the other: commands, then states.
    fn plain<const STATES: usize, const LANES: usize>(
        block: &mut Block<STATES, LANES>,
        before: &mut f64,
        commands: &[[f64; BLOCK]],
        positions: &mut Vec<f64>,
    ) {
        for chunk in commands {
            let mut sum = block.of_commands[0].map(|share| share * *before);
            for (column, command) in block.of_commands[1..].iter().zip(chunk) {
                add_scaled(&mut sum, column, *command);
            }
            for (column, state) in block.of_states.iter().zip(&block.last[BLOCK..]) {
                add_scaled(&mut sum, column, *state);
            }
            positions.extend_from_slice(&sum[..BLOCK]);
            block.last = sum;
            *before = chunk[BLOCK - 1];
        }
    }

    fn positions(
        drive: &Drive,
        commands: &[[f64; BLOCK]],
        follow: impl Fn(&mut Lanes, &mut f64, &mut Vec<f64>),
    ) -> Vec<u64> {
        let AxisServo { mut lanes, mut command, .. } = AxisServo::new(drive, 1e-3, commands[0][0]).unwrap();
        let mut positions = Vec::new();
        follow(&mut lanes, &mut command, &mut positions);
        assert_eq!(command.to_bits(), commands[commands.len() - 1][BLOCK - 1].to_bits());
        positions.iter().map(|position| position.to_bits()).collect()
    }

    #[test]
    fn every_loop_gives_the_bits_of_the_plain_sums() {
        let rigid = DrivePreset::by_id("reference-linear").unwrap().drive;
        let resonance = Some(Resonance { frequency_hz: 60.0, damping_ratio: 0.1 });
        for drive in [rigid, Drive { resonance, ..rigid }] {
            for blocks in [1, 2, BATCH - 1, BATCH, BATCH + 1, 3 * BATCH + 5] {
                for size in [0.0, -0.0, 1e-3, 250.0] {
                    let at = |k: usize| size * (0.37 * k as f64).sin() * f64::from(k % 50 > 20);
                    let commands: Vec<[f64; BLOCK]> =
                        (0..blocks).map(|block| std::array::from_fn(|k| at(block * BLOCK + k))).collect();
                    let expected = positions(&drive, &commands, |lanes, before, out| match lanes {
                        Lanes::Rigid(block) => plain(block, before, &commands, out),
                        Lanes::Resonant(block) => plain(block, before, &commands, out),
                    });
                    for set in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Fastest] {
                        let found = positions(&drive, &commands, |lanes, before, out| {
                            let flat = commands.as_flattened();
                            match lanes {
                                Lanes::Rigid(block) => block.follow(set, before, flat, out),
                                Lanes::Resonant(block) => block.follow(set, before, flat, out),
                            }
                        });
                        assert_eq!(found, expected, "{blocks} blocks of {size} with {set:?}");
                    }
                }
            }
        }
    }
}
