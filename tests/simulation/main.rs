//! The real service on a disk that breaks: a run of many requests is recorded write by write, and after every write
//! the power may have been cut. What is left is opened again and compared with what was answered.
//!
//! # What is real and what is not
//!
//! Real are the router with its guard, the queue and its pool, the courier, retention, the migrations, every
//! statement, the `SQLite` that is linked in, and the files beside it. Not real are:
//!
//! - **the disk.** `interpose` takes the calls of the C library that change files; the standard library and `SQLite` come through
//!   them alike, so that there is one honest order of everything. `recorder` logs them and lets faults meet them. `disk` makes of
//!   a log what POSIX promises after a power cut, and no more. A test plays each log again and compares it with the files.
//! - **the clocks.** The wall clock (`Sources::clock`) goes and jumps as the scheduler says. The clock that never goes back stands
//!   still, so that a timer ends when the scheduler lets time pass.
//! - **the scheduler.** One client asks at a time; the next one asks when the service rests. A computation that says so waits at
//!   a gate until the seed lets it go, so that requests come before, beside and after it.
//! - **the network.** Requests go into the router without a socket. One answer in eight is lost, and the request is sent again
//!   under its key. The receiver of webhooks loses or doubles its answers.
//! - **the computation,** which writes a program in capitals: what is computed is proven elsewhere.
//!
//! # What a seed decides
//!
//! Requests, ids, times, random bytes (those of `SQLite` too), faults, and with them the log, to the byte but for the
//! names of drafts; a test compares logs of the same seeds. Threads of the pool and of the database's connections are
//! the system's, but one thing goes on at a time. Where a fault meets the disk, the service tries again after a
//! second of a clock that passes when nothing else goes on: on a machine that is busy enough it may pass once more,
//! and the log then differs by what was tried again. A point is made of the log alone. Its look runs on real time.
//!
//! # Points
//!
//! A point is a seed, a place in its log and a kind of crash (`disk::Crash`); two points are never the same. A third
//! of the seeds that begin on a folder with data has a fault of the disk while they run (`recorder::Illness`), and
//! every fifth seed begins on an empty folder, so that the first start is cut off as well.
//!
//! `TRUNNION_SIMULATION_POINTS` sets how many points are looked at, `TRUNNION_SIMULATION_SEED` the first seed, and
//! `TRUNNION_SIMULATION_POINT` beside it one point, as a finding names it.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

mod chance;
mod disk;
mod interpose;
mod ledger;
mod plants;
mod points;
mod receiver;
mod recorder;
mod rot;
mod run;
mod verify;
mod workload;
mod world;
