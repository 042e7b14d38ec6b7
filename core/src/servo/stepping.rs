//! One axis stepped through its command, eight samples at a time.

use multiversion::multiversion;
use nalgebra::{DVector, SMatrix, SVector};

use super::{Drive, StateSpace, Step, TooStiff};
use crate::kinematics::InstructionSet;

/// Samples in a block.
const BLOCK: usize = 8;
/// Number of commands on which a block depends: those of its samples and the one before.
const COMMANDS: usize = BLOCK + 1;
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

#[derive(Debug, Clone)]
struct Block<const STATES: usize, const LANES: usize> {
    of_commands: [[f64; LANES]; COMMANDS],
    of_states: [[f64; LANES]; STATES],
    state: [f64; STATES],
    single: Single<STATES>,
}

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
        Self { of_commands, of_states, state: std::array::from_fn(|row| state[row]), single }
    }

    fn follow(&mut self, set: InstructionSet, before: &mut f64, commands: &[f64], positions: &mut Vec<f64>) {
        let (blocks, rest) = commands.as_chunks::<BLOCK>();
        match set {
            InstructionSet::Baseline => step_loop(self, before, blocks, positions),
            InstructionSet::Avx2 => step_avx2(self, before, blocks, positions),
            InstructionSet::Avx512 | InstructionSet::Fastest => {
                step_avx512(self, before, blocks, positions);
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
                    *value += self.single.transition[column][row] * self.state[column];
                }
            }
            self.state = after;
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

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn step_avx512<const STATES: usize, const LANES: usize>(
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
    let mut state = block.state;
    let mut old = *before;
    for chunk in commands {
        // The commands come first: they do not wait for the state.
        let mut sum = block.of_commands[0].map(|share| share * old);
        for (column, &command) in block.of_commands[1..].iter().zip(chunk) {
            add_scaled(&mut sum, column, command);
        }
        for (column, &value) in block.of_states.iter().zip(&state) {
            add_scaled(&mut sum, column, value);
        }
        positions.extend_from_slice(&sum[..BLOCK]);
        for (row, value) in state.iter_mut().enumerate() {
            *value = sum[BLOCK + row];
        }
        old = chunk[BLOCK - 1];
    }
    block.state = state;
    *before = old;
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn add_scaled<const LANES: usize>(sum: &mut [f64; LANES], column: &[f64; LANES], factor: f64) {
    for (sum, share) in sum.iter_mut().zip(column) {
        *sum += share * factor;
    }
}
