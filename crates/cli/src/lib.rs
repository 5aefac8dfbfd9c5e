//! What the `unframed` command is made of.

pub mod report;
