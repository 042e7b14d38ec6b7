//! Bodies of requests: read, checked, and where that is cheap computed. Whatever the bytes are, nothing panics, no
//! number that is none goes in or comes out, what is stored reads back as what it was, and nothing takes long.

use std::fmt::Debug;
use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

use serde::Serialize;
use serde::de::{DeserializeOwned, IgnoredAny};

use crate::calibration::identify;
use crate::calibration::rotary_sphere::identify_spheres;
use crate::kinematics::{Kinematics, PathOptions, PoseLanes};
use crate::machine::{Machine, Tool};
use crate::process::{ListedTool, ToolTable};
use crate::servo::{Detail, ServoPath, simulate};
use crate::units::Length;
use crate::wire::{
    ApiKeyRequest, ApplyRequest, CalibrationDocument, CalibrationHead, CalibrationKind, CalibrationRequest, CcParameters,
    CompensationParameters, CorePath, Drives, FaultList, ForwardRequest, InverseRequest, JobOperation,
    JobRequest, JointColumns, JointRows, JointWords, KinematicsOptions, MachineProfile, MachineStatements, MatchingRequest, Pose, PoseRows,
    PostingParameters, ScallopRequest, ServoOptions, ServoProgramParameters, SimulationAnswer, SimulationRequest,
    SolvedPoses, Statements, SweepRequest, TableTool, VerificationParameters, WearAdviceRequest, WearEntriesRequest,
    WearParameters, WithdrawalRequest, example_machine, read_json, read_query,
};

/// Most of anything that is computed; more is only read and checked.
const MOST: usize = 40;
/// Most samples of a simulation.
const MOST_SAMPLES: f64 = 20_000.0;

fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The machine that an empty store gets, with its drives.
fn example() -> &'static (MachineProfile, Machine) {
    static EXAMPLE: OnceLock<(MachineProfile, Machine)> = OnceLock::new();
    EXAMPLE.get_or_init(|| example_machine().expect("a preset").1.into_machine().expect("a machine"))
}

/// No number that is none. JSON would hide it behind `null`; the text of the debugger does not.
fn finite<T: Debug>(what: &str, answer: &T) {
    let text = format!("{answer:?}");
    for word in text.split(|letter: char| !letter.is_ascii_alphanumeric()) {
        assert!(word != "NaN" && word != "inf", "{what}: {text}");
    }
}

/// Reads a document. One that is kept (with a job, a machine, a key of idempotency) is written and read again as what
/// it was.
fn read<T: DeserializeOwned + Debug>(text: &[u8]) -> Option<T> {
    let document = read_json::<T>(text).ok()?;
    // A text of its own may say anything; numbers may not.
    if !text.windows(3).any(|three| three == b"NaN" || three == b"inf") {
        finite("read", &document);
    }
    Some(document)
}

fn kept<T: DeserializeOwned + Serialize + Debug>(text: &[u8]) -> Option<T> {
    let document: T = read(text)?;
    let written = serde_json::to_string(&document).expect("a document that was read is written");
    let again: T = match read_json(written.as_bytes()) {
        Ok(again) => again,
        Err(fault) => panic!("what is kept is not read again: {fault:?}\n{written}"),
    };
    assert_eq!(serde_json::to_string(&again).expect("as before"), written, "what is kept changes");
    Some(document)
}

/// A JSON body; the first byte says of which request.
pub fn json(data: &[u8]) {
    let Some((&kind, text)) = data.split_first() else { return };
    match kind % 18 {
        0 => profile(text),
        1 => inverse(text),
        2 => forward(text),
        3 => simulation(text),
        4 => sweep(text),
        5 => matching(text),
        6 => scallops(text),
        7 => {
            if let Some(Ok(answer)) = read::<WearAdviceRequest>(text).map(|request| request.solve()) {
                finite("advice", &answer);
            }
        }
        8 => calibration(text),
        9 => {
            if let Some(entries) = read::<WearEntriesRequest>(text) {
                let mut faults = FaultList::default();
                entries.check(&mut faults);
            }
        }
        10 => job(text),
        11 => {
            read::<ApiKeyRequest>(text);
            read::<ApplyRequest>(text);
            if let Some(withdrawal) = read::<WithdrawalRequest>(text) {
                withdrawal.check(&mut FaultList::default());
            }
            tool(text);
        }
        12 => cc(text),
        13 => wear(text),
        14 => one_pass(text),
        15 => verification(text),
        16 => posting(text),
        _ => servo_program(text),
    }
}

fn tool(text: &[u8]) {
    let Some(posted) = kept::<TableTool>(text) else { return };
    let mut faults = FaultList::default();
    let tool = posted.normalised(&mut faults);
    if !faults.is_empty() {
        return;
    }
    // What is stored is the same tool again, and the cutter that it states is one.
    let again = tool.clone().normalised(&mut faults);
    assert!(faults.is_empty() && again == tool, "a stored tool changes: {tool:?}");
    assert_eq!(tool.cutter().is_some(), tool.corner_radius_mm.is_some(), "{tool:?}");
}

fn profile(text: &[u8]) {
    let Some(profile) = kept::<MachineProfile>(text) else { return };
    let Ok((normalised, machine)) = profile.into_machine() else { return };
    finite("profile", &normalised);
    // What is stored is the same machine again, bit by bit.
    let stored = serde_json::to_string(&normalised).expect("a checked profile prints");
    let again: MachineProfile = read_json(stored.as_bytes()).expect("a stored profile reads");
    let (again, _) = again.into_machine().expect("a stored profile is a machine");
    assert_eq!(serde_json::to_string(&again).expect("prints"), stored, "a stored profile changes");
    let words = br#"{"poses": [{"x": 10, "y": 20, "z": 30, "i": 0.3, "j": -0.2, "k": 0.93}]}"#;
    let request: InverseRequest = read_json(words).expect("a request");
    solve(&machine, &request);
}

fn solve(machine: &Machine, request: &InverseRequest) {
    let Ok((setup, start_words_deg)) = request.options().to_setup(machine) else { return };
    let kinematics = Kinematics::new(machine, &setup);
    let (mut faults, mut lanes) = (FaultList::default(), PoseLanes::with_capacity(MOST));
    for (index, pose) in request.poses.iter().enumerate() {
        if let Some(pose) = pose.to_core(index, &mut faults) {
            lanes.push(pose);
        }
    }
    if faults.into_result().is_err() || lanes.len() > MOST || kinematics.path_states() > 1000 {
        return;
    }
    let options = PathOptions { start_words_deg, ..PathOptions::default() };
    let Ok(solved) = kinematics.path_lanes(&lanes, &options, &go_on) else { return };
    let mut joints = Vec::new();
    for (pose, conditioning) in solved.conditioning.iter().enumerate() {
        let found = solved.get(pose).expect("a solution for every pose");
        joints.push(JointWords::from_core(machine, &found, Some(*conditioning)));
    }
    finite("joints", &joints);
    SolvedPoses::new(1, joints, None, Vec::new()).write_json(&mut Vec::new()).expect("an answer prints");
}

fn inverse(text: &[u8]) {
    if let Some(request) = read::<InverseRequest>(text) {
        solve(&example().1, &request);
    }
}

fn forward(text: &[u8]) {
    let Some(request) = read::<ForwardRequest>(text) else { return };
    let machine = &example().1;
    let Ok((setup, _)) = request.options().to_setup(machine) else { return };
    let (kinematics, mut faults) = (Kinematics::new(machine, &setup), FaultList::default());
    for (index, words) in request.joints.iter().enumerate().take(MOST) {
        if let Some(joints) = words.to_core(machine, index, &mut faults) {
            finite("pose", &Pose::from(kinematics.forward(&joints)));
        }
    }
}

/// The machine that a servo request names, if it names the one there is.
fn on<'a>(options: &ServoOptions<'_>) -> Option<(&'a Machine, Option<&'a Drives>)> {
    let (profile, machine) = example();
    (options.machine_id == Some("example-ac-table")).then_some((machine, profile.drives.as_ref()))
}

fn simulation(text: &[u8]) {
    let Some(request) = kept::<SimulationRequest>(text) else { return };
    let (options, mut faults) = (request.options(), FaultList::default());
    let on = on(&options);
    let mut draft = options.to_core(on, &mut faults);
    request.apply(&mut draft, &mut faults);
    if faults.into_result().is_err() {
        return;
    }
    let task = draft.into_task().expect("a request without faults has path and drives");
    let run_on = |path: &ServoPath<'_>, axes: &[crate::servo::AxisLetter]| {
        let samples = task.run.samples(&path.extent(&task.run)) + path.settling_samples(&task.run, &task.drives);
        assert!(samples >= 0.0 || samples.is_infinite(), "{samples} samples");
        if samples < MOST_SAMPLES
            && let Ok(found) = simulate(path, &task.run, &task.drives, Detail::Trace, &go_on)
        {
            finite("simulation", &SimulationAnswer::of(None, &found, &task.drives, axes));
        }
    };
    match (&task.path, on) {
        (CorePath::Circle(circle), _) => run_on(&ServoPath::Circle(*circle), &circle.axes()),
        (CorePath::Tool { path, plane_normal }, Some((machine, _))) => {
            let kinematics = Kinematics::new(machine, &task.setup);
            let plane_normal = *plane_normal;
            let axes = crate::servo::letters_of(machine);
            run_on(&ServoPath::Tool { machine, kinematics: &kinematics, path, plane_normal }, &axes);
        }
        (CorePath::Tool { .. }, None) => {}
    }
}

fn sweep(text: &[u8]) {
    let Some(request) = kept::<SweepRequest>(text) else { return };
    let (options, mut faults) = (request.options(), FaultList::default());
    let draft = options.to_core(on(&options), &mut faults);
    request.rows(&draft, &mut faults);
    if faults.into_result().is_ok() {
        finite("labels", &request.labels());
    }
}

fn matching(text: &[u8]) {
    let Some(request) = kept::<MatchingRequest>(text) else { return };
    let (options, mut faults) = (request.options(), FaultList::default());
    let mut draft = options.to_core(on(&options), &mut faults);
    finite("targets", &request.apply(&mut draft, &mut faults));
}

fn scallops(text: &[u8]) {
    let Some(request) = read::<ScallopRequest>(text) else { return };
    if request.count() <= MOST
        && let Ok(Some(answer)) = request.solve(&go_on)
    {
        finite("scallops", &answer);
        serde_json::to_vec(&answer).expect("an answer prints");
    }
}

fn calibration(text: &[u8]) {
    let Some(request) = kept::<CalibrationRequest>(text) else { return };
    let machine = &example().1;
    let mut faults = FaultList::default();
    request.check(&mut faults);
    let head = CalibrationHead {
        id: String::new(),
        machine_id: "example-ac-table",
        machine_revision: 1,
        measured_at: String::new(),
        created_at: String::new(),
        run_sha256: String::new(),
    };
    let document = match request.kind {
        CalibrationKind::RtcpBallbar => {
            let run = request.to_ballbar(machine, &mut faults);
            let found = run.filter(|_| faults.into_result().is_ok()).and_then(|run| identify(machine, &run).ok());
            found.map(|found| CalibrationDocument::of_ballbar(head, &request, machine, &found))
        }
        CalibrationKind::RotarySphere => {
            let run = request.to_spheres(machine, &mut faults);
            let found = run.filter(|_| faults.into_result().is_ok()).and_then(|run| identify_spheres(machine, &run).ok());
            found.map(|found| CalibrationDocument::of_spheres(head, &request, machine, &found))
        }
    };
    if let Some(document) = document {
        finite("calibration", &document);
        let profile = document.apply_to(&example().0, &example().0);
        finite("applied", &profile);
    }
}

fn job(text: &[u8]) {
    let Ok(request) = read_json::<JobRequest<IgnoredAny>>(text) else { return };
    request.check(&mut FaultList::default());
    match request.operation {
        JobOperation::CcCompensation => drop(kept::<JobRequest<CcParameters>>(text)),
        JobOperation::WearCompensation => drop(kept::<JobRequest<WearParameters>>(text)),
        JobOperation::Compensation => drop(kept::<JobRequest<CompensationParameters>>(text)),
        JobOperation::Verification => drop(kept::<JobRequest<VerificationParameters>>(text)),
        JobOperation::ServoSimulation => drop(kept::<JobRequest<ServoProgramParameters>>(text)),
        JobOperation::Posting => drop(kept::<JobRequest<PostingParameters>>(text)),
    }
}

/// What a request that was checked states of a program, on the machine there is, with a table of one tool.
fn stated(statements: &Statements<'_>) {
    let (profile, machine) = example();
    let mut faults = FaultList::default();
    statements.check(&mut faults);
    if faults.into_result().is_err() {
        return;
    }
    let cutter = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).ok();
    let listed = ListedTool { number: Some(1), name: None, cutter, length: None, worn: None };
    let (table, mut faults) = (Arc::new(ToolTable::new(vec![listed])), FaultList::default());
    let of_machine = MachineStatements::of(profile);
    finite("stated", &statements.to_core(machine, &of_machine, &table, true, &mut faults));
}

fn cc(text: &[u8]) {
    let Some(parameters) = kept::<CcParameters>(text) else { return };
    for has_part in [false, true] {
        if let Ok(tool) = parameters.check(has_part) {
            finite("tool", &tool);
            stated(&parameters.statements());
        }
    }
}

fn wear(text: &[u8]) {
    let Some(parameters) = kept::<WearParameters>(text) else { return };
    for has_part in [false, true] {
        if let Ok(core) = parameters.to_core(has_part) {
            finite("wear", &core);
            stated(&parameters.statements());
        }
    }
}

fn one_pass(text: &[u8]) {
    let Some(parameters) = kept::<CompensationParameters>(text) else { return };
    for has_part in [false, true] {
        if parameters.check(has_part).is_ok() {
            finite("set-up", &(parameters.tolerance_um(), parameters.tool()));
            stated(&parameters.statements());
            finite("wear", &parameters.wear_alone());
            finite("cc", &parameters.cc_alone());
        }
    }
}

fn verification(text: &[u8]) {
    let Some(parameters) = kept::<VerificationParameters>(text) else { return };
    for is_uploaded in [false, true] {
        if let Ok((core, _)) = parameters.to_core(is_uploaded) {
            finite("verification", &core);
        }
    }
}

fn posting(text: &[u8]) {
    let Some(parameters) = kept::<PostingParameters>(text) else { return };
    if let Ok(core) = parameters.to_core(&example().1) {
        finite("posting", &core);
    }
}

fn servo_program(text: &[u8]) {
    let Some(parameters) = kept::<ServoProgramParameters>(text) else { return };
    let mut faults = FaultList::default();
    finite("servo", &parameters.to_core(example().0.drives.as_ref(), &mut faults));
}

/// Rows of a table in chunks of this size; none where they are refused.
macro_rules! table {
    ($reader:ty, $text:expr, $chunk:expr) => {{
        let mut reader = <$reader>::new(100);
        let fed = $text.chunks($chunk).try_for_each(|chunk| reader.feed(chunk));
        fed.and_then(|()| reader.finish())
    }};
}

/// A body of CSV, or a query; the first byte says which, and how the table is cut.
pub fn rows(data: &[u8]) {
    let Some((&choice, text)) = data.split_first() else { return };
    let chunk = 1 + usize::from(choice >> 3);
    let machine = &example().1;
    match choice & 7 {
        0..=2 => {
            let whole = table!(PoseRows, text, text.len().max(1));
            let cut = table!(PoseRows, text, chunk);
            assert_eq!(format!("{whole:?}"), format!("{cut:?}"), "rows depend on how the table was cut");
            let Ok(poses) = whole else { return };
            finite("poses", &poses);
            let mut again = b"x,y,z,i,j,k\n".to_vec();
            poses.iter().for_each(|pose| pose.write_row(&mut again));
            let again = PoseRows::new(100).feed_all(&again);
            assert_eq!(format!("{again:?}"), format!("{poses:?}"), "rows do not read back");
        }
        3..=5 => {
            let whole = table!(JointRows, text, text.len().max(1));
            let cut = table!(JointRows, text, chunk);
            assert_eq!(format!("{whole:?}"), format!("{cut:?}"), "rows depend on how the table was cut");
            let Ok(joints) = whole else { return };
            finite("joints", &joints);
            let kinematics = Kinematics::new(machine, &crate::kinematics::Setup::default());
            let columns = JointColumns::new(machine, false);
            let (mut faults, mut out) = (FaultList::default(), Vec::new());
            for (index, words) in joints.iter().enumerate() {
                if let Some(joints) = words.to_core(machine, index, &mut faults) {
                    finite("pose", &kinematics.forward(&joints));
                    columns.write_row(&mut out, index, words);
                }
            }
        }
        _ => {
            let Ok(query) = std::str::from_utf8(text) else { return };
            if let Ok(options) = read_query::<KinematicsOptions>(query)
                && let Ok(setup) = options.to_setup(machine)
            {
                finite("set-up", &setup);
            }
            if let Ok(parameters) = read_query::<CompensationParameters>(query) {
                finite("query", &parameters);
            }
            if let Ok(parameters) = read_query::<WearParameters>(query)
                && let Ok(core) = parameters.to_core(false)
            {
                finite("wear", &core);
            }
            if let Ok(parameters) = read_query::<VerificationParameters>(query)
                && let Ok((core, _)) = parameters.to_core(false)
            {
                finite("verification", &core);
            }
            if let Ok(parameters) = read_query::<CcParameters>(query)
                && let Ok(tool) = parameters.check(false)
            {
                finite("tool", &tool);
            }
        }
    }
}

/// A whole table at once.
trait FeedAll {
    fn feed_all(self, text: &[u8]) -> Vec<Pose>;
}

impl FeedAll for PoseRows {
    fn feed_all(mut self, text: &[u8]) -> Vec<Pose> {
        self.feed(text).expect("our own rows");
        self.finish().expect("our own rows")
    }
}
