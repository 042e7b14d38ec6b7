//! The service over HTTP: started as the binary starts it, on a port and in a directory of its own.

mod compensation;
mod forward;
mod inverse;
mod jobs;
mod limits;
mod machines;
mod pages;
mod real_programs;
mod service;
mod support;
