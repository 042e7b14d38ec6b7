//! A client that openapi-generator made, in use: a machine, kinematics, a program compensated, a posted job, a
//! problem, a key. `TRUNNION_URL` and `TRUNNION_KEY` (a key with every scope) say where; the argument is a program.

use std::path::PathBuf;
use std::time::Duration;

use trunnion_client::apis::configuration::Configuration;
use trunnion_client::apis::jobs_api::{CreateJobSuccess, GetJobSuccess, create_job, get_job, get_job_program};
use trunnion_client::apis::keys_api::{CreateApiKeySuccess, create_api_key};
use trunnion_client::apis::kinematics_api::{
    SolveForwardKinematicsSuccess, SolveInverseKinematicsSuccess, solve_forward_kinematics,
    solve_inverse_kinematics,
};
use trunnion_client::apis::machines_api::{PutMachineSuccess, put_machine};
use trunnion_client::apis::programs_api::compensate_cc_path;
use trunnion_client::apis::Error;
use trunnion_client::models::{
    ApiKeyRequest, CcCompensationJob, CcParameters, ForwardRequest, InverseRequest, Job, JobRequest, JobState, Kinematics,
    MachineProfile, Pose, Problem, RotaryAxis, Scope, Side,
};

const MACHINE: &str = "rust-client";

fn connect(key: &str) -> Configuration {
    Configuration {
        base_path: std::env::var("TRUNNION_URL").unwrap(),
        bearer_access_token: Some(key.to_owned()),
        ..Configuration::new()
    }
}

async fn posted(client: &Configuration, program: &PathBuf) -> Job {
    let parameters = CcParameters {
        tool_radius_mm: Some(5.0),
        work_offset_mm: Some(vec![12.0, -7.0, 35.0]),
        ..CcParameters::new()
    };
    let mut job = CcCompensationJob::new(MACHINE.to_owned(), Default::default(), parameters);
    job.external_id = Some("WO-4711/20".to_owned());
    let request = JobRequest::CcCompensation(Box::new(job));
    let answer = create_job(client, request, program.clone(), Some("WO-4711/20 rust"), None, None, None).await.unwrap();
    let Some(CreateJobSuccess::Status202(job)) = answer.entity else { panic!("{answer:?}") };
    job
}

#[tokio::main(flavor = "current_thread")]
async fn main() {
    let client = connect(&std::env::var("TRUNNION_KEY").unwrap());
    let program = PathBuf::from(std::env::args().nth(1).unwrap());

    let axis = |name: &str, direction: [f64; 3]| {
        RotaryAxis::new(direction.to_vec(), name.to_owned(), vec![0.0; 3], Side::Table)
    };
    let a = RotaryAxis { limits_deg: Some(Some(vec![-120.0, 120.0])), ..axis("A", [1.0, 0.0, 0.0]) };
    let kinematics = Kinematics::new(vec![a, axis("C", [0.0, 0.0, 1.0])]);
    let profile = MachineProfile::new(kinematics, "made by a Rust client".to_owned());
    let machine = put_machine(&client, MACHINE, profile.clone(), None, None).await.unwrap();
    let Some(PutMachineSuccess::Status201(machine) | PutMachineSuccess::Status200(machine)) = machine.entity else {
        panic!("{machine:?}")
    };
    assert_eq!(machine.revision, 1);

    let poses = InverseRequest::new(vec![Pose::new(0.3, -0.2, 0.93, 10.0, 20.0, 30.0)]);
    let solved = solve_inverse_kinematics(&client, MACHINE, poses, None, None, None, None, None, None, None).await.unwrap();
    let Some(SolveInverseKinematicsSuccess::Status200(solved)) = solved.entity else { panic!("{solved:?}") };
    let joints = ForwardRequest::new(solved.joints.flatten().unwrap());
    let back = solve_forward_kinematics(&client, MACHINE, joints, None, None, None).await.unwrap();
    let Some(SolveForwardKinematicsSuccess::Status200(back)) = back.entity else { panic!("{back:?}") };
    let pose = &back.poses[0];
    assert!((pose.x - 10.0).abs() + (pose.y - 20.0).abs() + (pose.z - 30.0).abs() < 1e-9, "{pose:?}");

    // Text in, text out: the program is what is answered unless something else is accepted.
    // The generator has no names for arguments: they are in the order of the description.
    let (radius, offset) = (Some(5.0), Some(vec![12.0, -7.0, 35.0]));
    let answered = compensate_cc_path(
        &client, MACHINE, program.clone(),
        None, None, None, None, None, None, None, None, None, None, None, None, None, None, None, None,
        None, None, None, None, None, None, None, None, None, None, None, None, None, None, None, None,
        radius, None, offset, None, None, None, None, None, None, None, None, None, None,
    );
    let answered = answered.await.unwrap().content;
    assert!(answered.lines().count() > std::fs::read_to_string(&program).unwrap().lines().count());

    let mut job = posted(&client, &program).await;
    assert_eq!(posted(&client, &program).await.id, job.id);
    for _ in 0..1200 {
        if !matches!(job.state, JobState::Queued | JobState::Running) {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
        let told = get_job(&client, &job.id.to_string(), None).await.unwrap();
        let Some(GetJobSuccess::Status200(told)) = told.entity else { panic!("{told:?}") };
        job = told;
    }
    assert_eq!(job.state, JobState::Succeeded);
    assert_eq!(get_job_program(&client, &job.id.to_string(), None, None, None).await.unwrap().content, answered);

    let poses = InverseRequest::new(vec![Pose::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)]);
    let refused = solve_inverse_kinematics(&client, MACHINE, poses, None, None, None, None, None, None, None).await;
    let Err(Error::ResponseError(refused)) = refused else { panic!("{refused:?}") };
    // Every refusal is a problem document; the generator's choice among the statuses looks at its form alone.
    let problem: Problem = serde_json::from_str(&refused.content).unwrap();
    assert_eq!((refused.status.as_u16(), problem.status, problem.r#type.as_str()), (422, 422, "/problems/invalid-request"));
    assert!(problem.errors.unwrap()[0].pointer.starts_with("/poses/0"));

    let request = ApiKeyRequest::new("reader".to_owned(), vec![Scope::Read]);
    let made = create_api_key(&client, request, None).await.unwrap();
    let Some(CreateApiKeySuccess::Status201(made)) = made.entity else { panic!("{made:?}") };
    let reader = connect(&made.key.flatten().unwrap());
    let refused = put_machine(&reader, MACHINE, profile, None, None).await;
    assert!(matches!(refused, Err(Error::ResponseError(refused)) if refused.status == 403));
    println!("the Rust client works");
}
