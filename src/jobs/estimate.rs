//! The cost of work, before it starts.

use thiserror::Error;

use crate::process::Budget;

/// Work whose estimated cost is over the limit.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the estimated cost of {estimated_s:.3} s of computation is over the limit of {limit_s} s; split the request, or raise max_cost_s"
)]
pub struct TooCostly {
    /// Estimated \[s of one core\].
    pub estimated_s: f64,
    /// Limit \[s of one core\].
    pub limit_s: f64,
}

/// An upper estimate of the time that one core needs. The rate for poses is three times the value measured over HTTP.
/// The rates for candidates and compensated programs are cautious and were not measured. The rates for servo samples
/// are two to five times the values measured on a core of 2.0 GHz, which are stated at the constants.
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

/// One evaluation of the deviation \[s\]; 0.1 to 0.25 µs were measured. Blocks that are costly at any tolerance are
/// found only during the work: their evaluations are counted, and refused over the limit, also within a block.
const EVALUATION_S: f64 = 1.2e-7;
/// One block written, read back and verified \[s\]; below 1 µs if it is copied, some µs if it is new.
const BLOCK_OUT_S: f64 = 6e-6;

/// One byte of a program read and followed, twice \[s\]. It was not measured as such: from the times of reader and
/// interpreter alone (`docs/performance.md`) it would be 7 ns.
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
/// One step of the search for a contact on a surface: a check of a box, a facet or a place on a facet \[s\]. Facets
/// that make one search check all of them are found only during the work: their steps are counted.
const SURFACE_STEP_S: f64 = 6e-8;
/// Smallest number of bytes in a block.
const BLOCK_BYTES: f64 = 20.0;
/// One straight piece of a motion, made and sorted among the samples \[s\]; 20 µs were measured on a busy machine, with
/// all its pairs.
const PIECE_S: f64 = 2e-5;
/// One sample or group of samples compared with a piece \[s\]; measured in the same way.
const PAIR_S: f64 = 5e-8;
/// One sample made, sorted and printed \[s\]; a cautious value.
const SAMPLE_S: f64 = 1e-5;

/// One scallop height with its inverses, read and printed \[s\].
const SCALLOP_S: f64 = 3e-6;

/// Work so short that it is done on the thread of the request \[s\]: ten poses on an ordinary machine.
const TRIFLE_S: f64 = 2e-4;

impl Cost {
    /// The cost of this many scallop heights.
    #[must_use]
    pub fn of_scallops(count: usize) -> Self {
        Self { seconds: count as f64 * SCALLOP_S }
    }

    /// The cost of this many samples through the drives, of the whole machine or of two axes.
    #[must_use]
    pub fn of_servo(samples: f64, whole_machine: bool) -> Self {
        Self { seconds: samples * if whole_machine { TOOL_SAMPLE_S } else { CIRCLE_SAMPLE_S } }
    }

    /// The cost of poses turned into joints, each with up to `candidates` answers.
    #[must_use]
    pub fn of_poses(poses: usize, candidates: usize) -> Self {
        Self { seconds: poses as f64 * (POSE_S + CANDIDATE_S * candidates as f64) }
    }

    /// The cost of compensating a program of this length. A tolerance far below a control's resolution multiplies the
    /// number of written blocks by the square root of its ratio to 10 µm.
    #[must_use]
    pub fn of_program(length: u64, tolerance_um: f64) -> Self {
        let finer = (10.0 / tolerance_um.max(1e-3)).sqrt().max(1.0);
        Self { seconds: length as f64 * PROGRAM_BYTE_S * finer }
    }

    /// The cost of moving the ends of motions in a program of this length: the same as for a CC compensation at 10
    /// µm.
    #[must_use]
    pub fn of_moving_ends(length: u64) -> Self {
        Self { seconds: length as f64 * PROGRAM_BYTE_S }
    }

    /// The cost of reading a program of this length twice.
    #[must_use]
    pub fn of_program_reading(length: u64) -> Self {
        Self { seconds: length as f64 * READ_BYTE_S }
    }

    /// The cost of posting cutter location data of this length: read, choose the rotary solutions, write, read back.
    /// 11 µs per point were measured on a busy machine without full optimisation.
    #[must_use]
    pub fn of_posting(length: u64) -> Self {
        let points = length as f64 / BLOCK_BYTES;
        Self { seconds: Self::of_program_reading(length).seconds + points * (POSE_S + BLOCK_OUT_S) }
    }

    /// No cost.
    pub const NOTHING: Self = Self { seconds: 0.0 };

    /// The cost of a surface with this many facets, with a contact on it for every block of a program of this length.
    #[must_use]
    pub fn of_part(facets: u64, length: u64) -> Self {
        Self { seconds: facets as f64 * FACET_S + length as f64 / BLOCK_BYTES * CONTACT_S }
    }

    /// The cost of reading a program of this length for virtual cutting, and of this many samples. The cost of its
    /// cuts is counted during the work.
    #[must_use]
    pub fn of_verification(length: u64, samples: usize) -> Self {
        let reading = Self::of_program_reading(length).seconds;
        Self { seconds: reading + samples as f64 * SAMPLE_S }
    }

    /// How many straight pieces of motion, and how many pairs of piece and sample, fit into the limit.
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

    /// How many evaluations of the deviation, steps of searches on a surface, and written blocks fit into the limit.
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

    /// How many samples of a whole machine fit into the limit.
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

    /// Whether it is cheaper than handing the work to another thread and back.
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
