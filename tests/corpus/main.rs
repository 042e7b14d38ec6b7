//! Laws and oracles over real programs. They run where `TRUNNION_SHARED` names the folder that holds them.

mod compensation;
mod conversational;
#[path = "../models/displaced.rs"]
mod displaced;
mod idempotence;
mod interpretation;
mod kinematics;
mod linuxcnc;
mod one_pass;
mod posting;
mod program;
mod reach;
mod rotary_sphere;
#[path = "../models/set_ups.rs"]
#[expect(dead_code, unreachable_pub, reason = "each binary uses its own part")]
mod set_ups;
mod siemens;
mod singularity;
#[path = "../models/tables.rs"]
mod tables;
mod wear;
#[path = "../models/wear_back_test.rs"]
mod wear_back_test_model;
mod wear_history;

use std::path::{Path, PathBuf};

#[expect(clippy::print_stdout, reason = "what is skipped is said aloud")]
/// The file of this name below the shared folder; `None`, said aloud, where there is no such folder.
fn shared_file(name: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("TRUNNION_SHARED") else {
        println!("skipped: TRUNNION_SHARED is not set, {name} not read");
        return None;
    };
    Some(PathBuf::from(folder).join(name))
}

/// Every file below a folder, in the order of the paths.
fn every_file(folder: &Path) -> Vec<PathBuf> {
    let mut folders = vec![folder.to_owned()];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
