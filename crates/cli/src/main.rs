//! The `unframed` command.
fn main() {}
