//! What benches and the rate example work on.

pub(crate) mod plain;
pub(crate) mod scene;
