//! What work will cost, before it starts.

use thiserror::Error;

use crate::process::Budget;

/// Work whose estimated cost is over the limit.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("the estimated cost of {estimated_s:.3} s of computation is over the limit of {limit_s} s")]
pub struct TooCostly {
    /// Estimated \[s of one core\].
    pub estimated_s: f64,
    /// Limit \[s of one core\].
    pub limit_s: f64,
}

/// An upper estimate of the time one core needs. The rate for poses is three times what was measured over HTTP;
/// those for candidates and compensated programs are set with caution and not yet measured. Those for servo samples
/// are two to five times what was measured on a core of 2.0 GHz, and stated where they stand.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Cost {
    seconds: f64,
}

impl std::ops::Add for Cost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { seconds: self.seconds + other.seconds }
    }
}

/// One pose turned into axis words and printed \[s\].
const POSE_S: f64 = 5e-6;
/// One pose with every candidate printed, for each turn that fits into the travel \[s\].
const CANDIDATE_S: f64 = 3e-6;
/// One byte of a program read, checked, corrected, written and verified \[s\].
const PROGRAM_BYTE_S: f64 = 2e-7;

/// One evaluation of the deviation \[s\]; 0.1 to 0.25 µs were measured. Blocks that are dear whatever the tolerance show only
/// on the way: their evaluations are counted as they are made, and refused over the limit, within a block as well.
const EVALUATION_S: f64 = 1.2e-7;
/// One block written, read back and verified \[s\]; below 1 µs where it is copied, some µs where it is new.
const BLOCK_OUT_S: f64 = 6e-6;

/// One byte of a program read and followed, twice \[s\]. Not measured as such: reader and interpreter alone
/// (`docs/performance.md`) make it 7 ns by calculation.
const READ_BYTE_S: f64 = 2e-8;
/// One sample of a circle of two axes, simulated \[s\]; about 22 ns were measured.
const CIRCLE_SAMPLE_S: f64 = 1e-7;
/// One sample of a path of the tool: inverse, five drives, forward, foot on the path \[s\]; 1.1 to 2 µs were
/// measured.
const TOOL_SAMPLE_S: f64 = 4e-6;

/// One facet of a surface read, welded, smoothed and put into boxes \[s\]; 1.6 µs were measured on a busy machine.
const FACET_S: f64 = 3e-6;
/// One contact found on a surface \[s\]; on one of ten million facets, at random places, 0.2 to 0.4 ms were measured,
/// but neighbouring points of a program are found faster.
const CONTACT_S: f64 = 1e-4;
/// One step of the search for a contact on a surface: a look at a box, a facet or a place on a facet \[s\]. Facets that make one
/// search look at all of them show only on the way: their steps are counted as they are made.
const SURFACE_STEP_S: f64 = 6e-8;
/// Bytes of a block, at least.
const BLOCK_BYTES: f64 = 20.0;
/// One straight piece of a motion, made and sorted among the samples \[s\]; 20 µs were measured on a busy machine, with
/// all its pairs.
const PIECE_S: f64 = 2e-5;
/// One sample or clump of samples compared with a piece \[s\]; likewise.
const PAIR_S: f64 = 5e-8;
/// One sample made, sorted, printed \[s\]; set with caution.
const SAMPLE_S: f64 = 1e-5;

/// One scallop height with its inverses, read and printed \[s\].
const SCALLOP_S: f64 = 3e-6;

/// Work so short that it is done where it arrives \[s\]: ten poses on an ordinary machine.
const TRIFLE_S: f64 = 2e-4;

impl Cost {
    /// Of so many scallop heights.
    #[must_use]
    pub fn of_scallops(count: usize) -> Self {
        Self { seconds: count as f64 * SCALLOP_S }
    }

    /// Of so many samples through the drives, of the whole machine or of two axes.
    #[must_use]
    pub fn of_servo(samples: f64, whole_machine: bool) -> Self {
        Self { seconds: samples * if whole_machine { TOOL_SAMPLE_S } else { CIRCLE_SAMPLE_S } }
    }

    /// Of poses turned into joints, each with up to `candidates` answers.
    #[must_use]
    pub fn of_poses(poses: usize, candidates: usize) -> Self {
        Self { seconds: poses as f64 * (POSE_S + CANDIDATE_S * candidates as f64) }
    }

    /// Of a program of this length, compensated. A tolerance far below a control's resolution multiplies the
    /// blocks to be written by the square root of its ratio to 10 µm.
    #[must_use]
    pub fn of_program(length: u64, tolerance_um: f64) -> Self {
        let finer = (10.0 / tolerance_um.max(1e-3)).sqrt().max(1.0);
        Self { seconds: length as f64 * PROGRAM_BYTE_S * finer }
    }

    /// Of a program of this length whose ends of motions are moved: as much as one whose path is compensated at 10 µm.
    #[must_use]
    pub fn of_moving_ends(length: u64) -> Self {
        Self { seconds: length as f64 * PROGRAM_BYTE_S }
    }

    /// Of a program of this length, read twice.
    #[must_use]
    pub fn of_program_reading(length: u64) -> Self {
        Self { seconds: length as f64 * READ_BYTE_S }
    }

    /// Of cutter location data of this length: read, a way chosen through its points, written, read back. 11 µs a
    /// point were measured on a busy machine without full optimisation.
    #[must_use]
    pub fn of_posting(length: u64) -> Self {
        let points = length as f64 / BLOCK_BYTES;
        Self { seconds: Self::of_program_reading(length).seconds + points * (POSE_S + BLOCK_OUT_S) }
    }

    /// Of nothing.
    pub const NOTHING: Self = Self { seconds: 0.0 };

    /// Of a surface of so many facets, with a contact on it for every block of a program of this length.
    #[must_use]
    pub fn of_part(facets: u64, length: u64) -> Self {
        Self { seconds: facets as f64 * FACET_S + length as f64 / BLOCK_BYTES * CONTACT_S }
    }

    /// Of reading a program of this length for virtual cutting, and of so many samples. What it cuts shows on the way.
    #[must_use]
    pub fn of_verification(length: u64, samples: usize) -> Self {
        let reading = Self::of_program_reading(length).seconds;
        Self { seconds: reading + samples as f64 * SAMPLE_S }
    }

    /// How many straight pieces of motion, and how many pairs of piece and sample, the limit pays for.
    #[must_use]
    pub fn pieces_and_pairs_within(limit_s: f64) -> [u64; 2] {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, saturating"
        )]
        let count = |each_s: f64| (limit_s / each_s).max(0.0) as u64;
        [count(PIECE_S), count(PAIR_S)]
    }

    /// How many evaluations of the deviation, steps of searches on a surface and blocks written the limit pays for.
    #[must_use]
    pub fn budget_within(limit_s: f64) -> Budget {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, saturating"
        )]
        let count = |each_s: f64| (limit_s / each_s).max(0.0) as u64;
        Budget {
            max_evaluations: count(EVALUATION_S),
            max_blocks_out: count(BLOCK_OUT_S),
            max_surface_steps: count(SURFACE_STEP_S),
        }
    }

    /// How many samples of a whole machine the limit pays for.
    #[must_use]
    pub fn servo_samples_within(limit_s: f64) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, saturating"
        )]
        let samples = (limit_s / TOOL_SAMPLE_S).max(0.0) as u64;
        samples
    }

    /// Whether it is less than handing the work to another thread and back is worth.
    #[must_use]
    pub fn is_trifling(self) -> bool {
        self.seconds <= TRIFLE_S
    }

    /// Refuses work over the limit.
    ///
    /// # Errors
    /// The estimate is over `limit_s`.
    pub fn within(self, limit_s: f64) -> Result<(), TooCostly> {
        if self.seconds <= limit_s { Ok(()) } else { Err(TooCostly { estimated_s: self.seconds, limit_s }) }
    }
}
