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
use crate::side_by_side::OneAfterAnother;
use crate::units::Length;
use crate::wire::{
    ApiKeyRequest, ApplyRequest, CalibrationDocument, CalibrationHead, CalibrationKind, CalibrationRequest, CcParameters,
    CompensationParameters, CorePath, Drives, FaultList, ForwardRequest, InverseRequest, JobOperation,
    JobRequest, JointColumns, JointRows, PathWords, PoseColumns, Solutions, KinematicsOptions, MachineProfile, MachineStatements, MatchingRequest, Pose, PoseRows,
    PostingParameters, ScallopRequest, ServoOptions, ServoProgramParameters, SimulationAnswer, SimulationRequest,
    SolvedPoses, Statements, SweepRequest, TableTool, VerificationParameters, WearAdviceRequest, WearEntriesRequest,
    WearParameters, WithdrawalRequest, example_machine, read_json, read_query,
};

/// Most of anything that is computed; more is only read and checked.
const MOST: usize = 40;
/// The faster way of reading poses is taken above this length \[bytes\].
const MOST_OF_A_SMALL_BODY: usize = 4096;
/// Unit axes that were made unit axes once more may differ by a rounding of each component.
const UNIT_ONCE_MORE: f64 = 4.0 * f64::EPSILON;
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
    solve(&machine, request);
}

fn solve(machine: &Machine, request: InverseRequest) {
    let Ok((setup, start_words_deg)) = request.options().to_setup(machine) else { return };
    let kinematics = Kinematics::new(machine, &setup);
    let Ok(lanes) = request.poses.into_core() else { return };
    if lanes.len() > MOST || kinematics.path_states() > 1000 {
        return;
    }
    let options = PathOptions { start_words_deg, ..PathOptions::default() };
    let Ok(solved) = kinematics.path_lanes(&lanes, &options, &go_on) else { return };
    assert_eq!(solved.conditioning.len(), lanes.len(), "a solution for every pose");
    finite("joints", &solved);
    let document = SolvedPoses::new(1, Solutions::Path(PathWords::new(machine, solved)), Vec::new());
    let mut printed = Vec::new();
    document.write_json(&OneAfterAnother, &mut printed).expect("an answer prints");
    assert_eq!(printed, serde_json::to_vec(&document).expect("an answer prints"), "not as serde prints it");
}

fn inverse(text: &[u8]) {
    // The faster way, which is for long texts, reads what serde reads.
    let long = [text, &b" ".repeat(MOST_OF_A_SMALL_BODY)].concat();
    let fast = format!("{:?}", InverseRequest::read(&long));
    assert_eq!(fast, format!("{:?}", read_json::<InverseRequest>(&long)), "the faster way reads something else");
    if let Some(request) = read::<InverseRequest>(text) {
        solve(&example().1, request);
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
            let Ok(Ok(poses)) = whole.map(PoseColumns::into_core) else { return };
            finite("poses", &poses);
            let mut again = Pose::CSV_HEADER.as_bytes().to_vec();
            for at in 0..poses.len() {
                let PoseLanes { x_mm, y_mm, z_mm, i, j, k } = &poses;
                Pose { x: x_mm[at], y: y_mm[at], z: z_mm[at], i: i[at], j: j[at], k: k[at] }.write_row(&mut again);
            }
            let again = table!(PoseRows, again, chunk).expect("our own rows").into_core().expect("poses");
            assert_eq!([&again.x_mm, &again.y_mm, &again.z_mm], [&poses.x_mm, &poses.y_mm, &poses.z_mm]);
            for (again, before) in [(&again.i, &poses.i), (&again.j, &poses.j), (&again.k, &poses.k)] {
                let differ = again.iter().zip(before).map(|(again, before)| (again - before).abs());
                assert!(differ.fold(0.0, f64::max) <= UNIT_ONCE_MORE, "axes do not read back: {before:?}, {again:?}");
            }
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
