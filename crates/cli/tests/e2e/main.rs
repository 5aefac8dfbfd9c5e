//! The command as a user types it.

mod bad_input;
mod budget;
mod common;
mod cost;
mod eval;
mod main_job;
mod streams;
