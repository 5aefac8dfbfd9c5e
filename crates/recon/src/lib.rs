//! The reconstructor. Under construction.
#![no_std]
