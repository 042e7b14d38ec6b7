//! The service over HTTP: started as the binary starts it, on a port and in a directory of its own.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

mod audit;
mod backups;
mod calibrations;
mod command_line;
mod compensation;
mod documents;
mod examples;
mod forward;
mod http2;
mod inverse;
mod jobs;
mod keys;
mod keys_command;
mod limits;
mod limits_beyond;
mod lost_database;
mod machines;
mod mutations;
mod observation;
mod one_pass;
mod pages;
mod posting;
mod process;
mod queue;
mod queue_downloads;
mod queue_restart;
mod real_programs;
mod receiver;
mod recorded;
mod replays;
mod service;
mod servo;
mod support;
mod tls;
mod tools;
mod upgrade;
mod verification;
mod wear;
mod wear_history;
mod wear_program;
mod webhooks;
