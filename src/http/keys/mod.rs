//! API keys: create, list, revoke.

mod create_key;
mod get_key;
mod list_keys;
mod revoke_key;

use super::described::resource;
use super::problem::{Problem, ProblemType};

resource! {
    create_key::create_api_key,
    list_keys::list_api_keys,
    get_key::get_api_key,
    revoke_key::revoke_api_key,
}

fn key_not_found(id: &str) -> Problem {
    Problem::new(ProblemType::KeyNotFound, format!("there is no key {id:?}"))
}
