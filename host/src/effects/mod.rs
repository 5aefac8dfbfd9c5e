//! Effects that a scene may call for, each a component of its own (Dubla, Debattista and Chalmers
//! 2009): what is not called for costs no ray.
//!
//! - [`area`]: soft shadows, points on emissive meshes;
//! - [`medium`]: single scattering in a homogeneous medium;
//! - [`vpl`]: indirect diffuse light by virtual point lights;
//! - [`framed`]: all three by adaptive interleaved sampling of whole frames ([`deferred`] data,
//!   [`components`] with their guidance, disjoint [`sets`]);
//! - [`reference`]: the path tracer that says how well.

pub(crate) mod area;
pub(crate) mod components;
pub(crate) mod deferred;
pub mod framed;
mod light;
pub(crate) mod medium;
pub mod reference;
pub(crate) mod sets;
#[cfg(test)]
mod tests;
pub(crate) mod vpl;
