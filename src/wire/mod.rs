//! The one external form of all data: serde documents, for clients and for the disk.

mod api_key;
mod audit;
mod calibration;
mod calibration_answer;
mod calibration_history;
mod calibration_limits;
mod calibration_report;
mod calibration_run;
mod calibration_table;
mod calibration_words;
mod callback_url;
mod cc_compensation;
mod decimal;
mod drive;
mod fault;
mod interpretation;
mod job;
mod job_path;
mod kinematics;
mod machine;
mod machine_coordinates;
mod machine_programs;
mod nominal_surface;
mod numbers;
mod objects;
mod one_pass;
mod one_pass_answer;
mod path_segment;
mod pieces;
mod pose_columns;
mod posting;
mod presets;
mod printable;
mod program_words;
mod query;
mod radius_offsets;
mod reading;
mod report_parts;
mod residuals;
mod resolved;
mod rows;
mod servo;
mod servo_answer;
mod servo_path;
mod servo_program;
mod singularity;
mod solved_poses;
mod sphere_answer;
mod statements;
mod surface_mesh;
mod table_text;
mod tool_table;
mod verification;
mod wear_advice;
mod wear_history;
mod wear_numbers;
mod wear_outlook;
mod wear_program;
mod wear_report;
mod wear_scallop;
mod wear_scallop_curves;
mod wear_tool;
mod wear_trend;
mod webhook;
mod work_offsets;

pub use api_key::{ApiKeyDocument, ApiKeyRequest, NewApiKeyDocument, NoScope, Scope, is_slug};
pub use audit::{AuditAction, AuditEntry, AuditOrigin, audit_table};
pub use calibration::{
    BallBarTestDoc, BarDirectionDoc, CalibrationKind, CalibrationRequest, ReadingDoc, SetupErrorDoc,
    SphereAxisDoc, SphereCentreDoc, SpindleBar,
};
pub use calibration_answer::{
    BallBarAnswer, BlindDoc, CalibrationDocument, CalibrationHead, CovarianceDoc, EccentricitiesDoc,
    Estimate, Estimates, OutlierDoc, RunWarningDoc, SetupErrorAnswer, SetupErrorSource, TestAnswer,
};
pub use calibration_history::{
    AppliedProfile, ApplyRequest, CalibrationDifference, Difference, OtherAxes, Trend, TrendPoint,
    error_in_profile, trend_table, trend_unit,
};
pub use calibration_limits::CalibrationLimits;
pub use calibration_report::{CascadedError, ReportedError, Verdict, cascaded_errors, reported_errors};
pub use calibration_run::{fit_fault, sphere_fault};
pub use calibration_table::calibration_table;
pub use callback_url::{CallbackFault, CallbackUrl, Host};
pub use cc_compensation::{CcFindings, CcParameters, CcReport, Correction, Output};
pub use drive::{Drive, Drives, Feedback, Resonance, Transmission};
pub use fault::{Fault, FaultList};
pub use interpretation::{
    InterpretationAnswer, InterpretationEnd, InterpretationParameters, InterpretationTable,
    InterpretedMotionDoc, JointsInOrder, LeftAloneDoc, MotionKindDoc,
};
pub use job::{BatchedJob, JobBatch, JobDocument, JobOperation, JobRequest, JobState};
pub use job_path::{ErrorsByLine, JobPath, tools_of_report};
pub use kinematics::{
    ForwardRequest, InverseRequest, JointWords, KinematicsOptions, LocationErrors, Pose, PoseWarning,
    PoseWarningKind, RotaryWords, Selection,
};
pub use machine::{
    Kinematics, LinearLimits, LocationErrorDoc, MachineDocument, MachineProfile, RotaryAxisDoc, SideDoc,
    SquarenessDoc,
};
pub use machine_coordinates::MachineCoordinates;
pub use machine_programs::{PlaneRule, PlaneSolution, ProgramUnit};
pub use nominal_surface::{AnySurface, FormulaKind, NominalSurfaceDoc};
pub use numbers::Fixed;
pub use objects::Objects;
pub use one_pass::{CcStep, CompensationParameters, WearStep, looks_at};
pub use one_pass_answer::{
    BlockBudgetDoc, BlockChangeDoc, BlockErrorDoc, BudgetLineDoc, ChangeRow, ChangeSeriesDoc, ChangeTable,
    ChangesDoc, CompensationFindings, CompensationReport, ErrorBudgetDoc, LocationErrorFindings,
    NotModelledDoc,
};
pub use path_segment::path_segment;
pub use pieces::{LONGEST_NUMBER, write_as_made, write_in_pieces};
pub use pose_columns::PoseColumns;
pub use posting::{
    CutcomPoints, PostingBetweenPoints, PostingFindings, PostingParameters, PostingReadBack, PostingReport,
    ToolChange,
};
pub use presets::{DrivePresetDoc, Preset, drive_presets, example_machine, presets};
pub use program_words::{Contact, Dialect, Interpolation, StepName};
pub use query::{NoParameters, QueryFault, read_query};
pub use radius_offsets::RadiusOffsets;
pub use reading::{Unreadable, read_json};
pub use report_parts::{DeviationSeries, DeviationSummary, Provenance, Warning};
pub use residuals::{ResidualRow, fault_of_table};
pub use resolved::{
    ResolvedInputs, ResolvedOffset, ResolvedTool, ResolvedWear, StatedBy, TablePlace, two_statements,
};
pub use rows::{JointColumns, JointRows, PoseRows, RowFault};
pub use servo::{
    FeedProfileDoc, GainScales, MatchingRequest, ScaleLists, ServoDraft, ServoOptions, ServoTask,
    SimulationRequest, SweepRequest,
};
pub use servo_answer::{
    AxisResult, AxisResults, ContourErrorDoc, FeedLimitDoc, MatchedGain, MatchingAnswer, OvalDoc, PoleDoc,
    ServoSamples, SimulationAnswer, StabilityDoc, SweepAnswer, SweepColumns, SweepFault,
};
pub use servo_path::{CorePath, LinearLetter, Plane, PolylinePoint, RotarySweep, ServoPathDoc};
pub use servo_program::{LeftOutDoc, ServoProgramParameters, ServoReport};
pub use singularity::{
    RegionFiguresDoc, RegionsLeftDoc, SingularRegionDoc, SingularRegions, SingularityAction,
    SingularityFindings,
};
pub use solved_poses::{PathWords, Solutions, SolvedPoses, write_path_rows};
pub use sphere_answer::{SphereAxisAnswer, SphereCircle, SphereOutlier};
pub use statements::{MachineStatements, StampForm, StartWords, Statements};
pub use surface_mesh::{SurfaceMeshDoc, SurfaceReading};
pub use tool_table::{TableTool, ToolDocument, ToolKind, tool_name_key};
pub use verification::{VerificationParameters, VerificationReport, VerificationSources, verification_fault};
pub use wear_advice::{AdviceKind, OutlookDoc, WearAdviceAnswer, WearAdviceRequest};
pub use wear_history::{
    MAX_WEAR_EDGES, MAX_WEAR_ENTRIES, WearEntriesAnswer, WearEntriesRequest, WearEntry, WearEntryRequest,
    WearQuantity, Withdrawal, WithdrawalRequest, check_name, other_quantity,
};
pub use wear_numbers::{Answers, Numbers};
pub use wear_outlook::{EdgeBasis, OutlookBasis, PartsInterval, PartsOutlook, PartsOutlookKind, StageBasis};
pub use wear_program::{LengthInControl, Milling, WearFrom, WearParameters, WearSource, WearTableDoc};
pub use wear_report::{AssumptionDoc, WearFindings, WearReport};
pub use wear_scallop::{ScallopAnswer, ScallopRequest, SurfaceKind};
pub use wear_scallop_curves::ScallopAxis;
pub use wear_tool::ToolDoc;
pub use wear_trend::{
    FollowedWear, WearEdge, WearFit, WearTrend, WearTrendHead, WearTrendPoint, WearWarning, wear_trend_table,
};
pub use webhook::{
    Deliveries, DeliveryAttempt, DeliveryDocument, DeliveryOutcome, DeliveryState, PreviousSecret,
    WebhookSecret, WebhookSecretDocument, event_type, job_event, webhook_id,
};
pub use work_offsets::WorkOffsets;
