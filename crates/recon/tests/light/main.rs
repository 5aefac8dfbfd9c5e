//! Light of the instant against `f64`: places, maps, what shares take away; and what no host sends.

#![cfg(feature = "light")]

mod rays;
mod room;
mod wide;
