//! The display hardware, simulated: what stands between the reconstructor and the eye.
//!
//! | layer | module | what it does |
//! |---|---|---|
//! | device | [`gpu`] | finds an adapter, checks that it suffices, turns every error into a value |
//! | passes | [`pass`] | integer compute stages over buffers of words, each readable for comparison |
//! | twin | [`twin`] | the reconstructor in WGSL, equal to the one in Rust to the bit |
//! | boards | [`boards`] | the reconstructor on microcontrollers, under QEMU |
//! | glass | [`panel`] | what the panel does with the picture: dithering, response time |
//! | paint | [`paint`] | whole-number upscaling of a picture onto a surface, byte for byte |
//! | source | [`source`] | what gives the pictures: a trait, a channel |
//! | window | [`window`] | shows a source of pictures at the panel's refresh rate |
//!
//! Everything that decides a pixel is integer arithmetic, on the adapter as on the processor, so
//! the same bytes come out on every driver. WGSL has no 64-bit integers: `shaders/int64.wgsl`
//! supplies those that the reconstructor's twin needs.
//!
//! Nothing here knows the host: pictures come from the stream through `unframed-recon`.

pub mod boards;
pub mod gpu;
pub mod paint;
pub mod panel;
pub mod pass;
pub mod source;
pub mod twin;
pub mod window;

pub use gpu::{Gpu, GpuError};
pub use twin::GpuPlayer;

#[cfg(test)]
mod testing;
