//! Laws and oracles over real programs. They run where `TRUNNION_SHARED` names the folder that holds them.

mod compensation;
mod kinematics;
mod program;
mod rotary_sphere;
#[path = "../models/tables.rs"]
mod tables;
mod wear;

use std::path::PathBuf;

#[expect(clippy::print_stdout, reason = "what is skipped is said aloud")]
/// The file of this name below the shared folder; `None`, said aloud, where there is no such folder.
fn shared_file(name: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("TRUNNION_SHARED") else {
        println!("skipped: TRUNNION_SHARED is not set, {name} not read");
        return None;
    };
    Some(PathBuf::from(folder).join(name))
}
