//! What there is to see: meshes on animated nodes, materials, lights, a camera. Plain data.
//!
//! Units: metres, seconds, radians, linear Rec. 709 radiance. Right-handed, y up, a camera looks
//! down its −z (glTF 2.0 §3.4). Time is continuous: everything is a function of seconds.

pub mod animate;
pub mod builtin;
pub mod calls;
mod foresee;
pub mod gltf;
pub mod model;
pub mod open;
pub use model::*;
