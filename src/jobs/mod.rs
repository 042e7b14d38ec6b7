//! Work that takes time: its cost, the one bounded pool that does it, the files that it reads and writes.

mod acceptance;
mod api_keys;
mod archive;
mod archive_of_files;
mod asking;
mod calibration;
mod cc_compensation;
mod cc_compensator;
mod clock;
mod compensator;
mod compute;
mod compute_threads;
mod cpu_time;
mod estimate;
mod flattening;
mod interpretation;
mod job_fault;
mod job_path;
mod kinematics;
pub mod memory;
mod one_pass;
mod open_fault;
mod opening;
mod part_surface;
mod pose_file;
mod pose_table;
mod posting;
mod program_figure;
mod program_file;
mod program_files;
mod program_job;
mod progress;
mod queue;
mod refusals;
mod scrub;
mod servo;
mod servo_program;
mod spool;
mod stamping;
mod step_files;
mod surface_fault;
mod tool_shelf;
mod turns;
mod verification;
mod wear;
mod wear_program;
mod webhooks;
mod work;
mod workplace;

pub use acceptance::{Accepted, already_done, steps_done, with_wear};
pub use api_keys::{HeldKey, IssueFault, IssuedKey, KeyRefusal, KeyRing, issue_key, key_id_of};
pub use archive::{ArchiveFault, Unpacked, unpack};
pub use asking::{asked_by, asker};
pub use calibration::{
    CalibrationReading, due_at, evaluate, evaluate_ballbar, evaluate_budget, measured_at, period, time_bound,
};
pub use cc_compensator::CutterContactCompensator;
pub use clock::{Clock, IdSource, Sources, TlsTime, system_time, timestamp};
pub use compensator::{Compensated, Compensator};
pub use compute::{Compute, ComputeFault, Threads};
pub use estimate::{Cost, TooCostly};
pub use interpretation::{InterpretationForm, interpret};
pub use job_fault::JobFault;
pub use job_path::job_path;
pub use kinematics::{InverseAnswer, InverseTask, KinematicsFault, Limits, forward};
pub use one_pass::one_pass_figure;
pub use open_fault::{OpenFault, TrustFault};
pub use opening::{open_data_directory, profile_sha256};
pub use pose_table::{POSES_IN_MEMORY, PoseTable, ReceivedPoses, WaitingPoses};
pub use program_file::InputFile;
pub use program_files::{ArrivingFiles, ProgramFilesFault, SentFile, joined, looks_joined};
pub use program_job::{ProgramJob, run_program_job};
pub use progress::Progress;
pub use queue::{Besides, Describe, DrawnUp, JobOrder, Queue, QueueLimits, QueueReading};
pub use refusals::{CompensatorFault, Refusal, RefusalClass};
pub use scrub::{Keeper, ScrubLimits};
pub use servo::{ServoWork, ServoWorkFault};
pub use spool::{Spool, SpoolFault, Upload};
pub use surface_fault::PartSurfaceFault;
pub use tool_shelf::{KeptShelf, KeptWear, ToolShelf, UnfitEntries, WhyUnfit};
pub use verification::{ResidualFault, verification_figure};
pub use wear::{WearFault, scallop_heights};
pub use wear_program::wear_figure;
pub use webhooks::{
    Courier, DeliveriesReading, NotAllowed, Receivers, SECRET_OVERLAP_S, new_webhook_secret, signing_now,
    trusted_certificates,
};
pub use work::{
    ByOperation, MachineUsed, Means, Prepared, ProgramParameters, ProgramWork, Sizes, by_operation,
};
pub use workplace::{Finished, Workplace};
