//! Effects that a scene may call for, each a component of its own (Dubla, Debattista and Chalmers
//! 2009): what is not called for costs no ray.
//!
//! - [`area`]: soft shadows, points on emissive meshes;
//! - [`medium`]: single scattering in a homogeneous medium.

pub(crate) mod area;
pub(crate) mod medium;
#[cfg(test)]
mod tests;
