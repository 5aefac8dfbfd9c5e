//! The evaluation: every method against the ideal renderer, every refresh counted, after
//! Dayal et al. 2005 §7.
//!
//! A *cell* is one method on one scene at one rate with one seed. Data flows one way:
//! [`ideals`] (what should be seen, cached) → [`cell`] (what a method showed, [`methods`] and
//! [`unmoved`] being the ways to show something) → [`store`] (a file a finished cell, so that
//! nothing is computed twice) → [`table`] (means over seeds, ratios, CSV, JSON) → [`page`].
//! [`plan`] says which cells there are ([`parts`] of `adaptive` left out, [`probes`] that ask one
//! question), [`checks`] what of the promises holds. [`schedule`] runs the cells on all cores;
//! each cell has one, so that its seconds mean something and its result cannot depend on the
//! others. [`crate::replica`] says how much of an error is age.

pub mod cell;
pub mod checks;
pub mod ideals;
pub mod methods;
pub mod page;
pub mod parts;
pub mod plan;
pub mod probes;
pub mod rays;
pub mod schedule;
pub mod store;
pub mod table;
#[cfg(test)]
mod tests;
pub mod unmoved;

pub use cell::{Cell, Job, Settings};
pub use ideals::{Cache, Reference};
pub use methods::EvalMethod;
