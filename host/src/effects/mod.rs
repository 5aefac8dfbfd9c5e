//! Effects that a scene may call for, each a component of its own (Dubla, Debattista and Chalmers
//! 2009): what is not called for costs no ray.
//!
//! - [`area`]: soft shadows, points on emissive meshes, from near by over their solid angle
//!   ([`spherical`]);
//! - [`medium`]: single scattering in a homogeneous medium;
//! - [`vpl`]: indirect diffuse light by virtual point lights, and what these leave out ([`near`]);
//! - [`framed`]: all three by adaptive interleaved sampling of whole frames ([`deferred`] data,
//!   [`components`] with their guidance, disjoint [`sets`]);
//! - [`care`]: how many rays a frameless sample gives to each, and with which points;
//! - [`reference`]: the path tracer that says how well.

pub(crate) mod area;
pub mod care;
pub(crate) mod components;
pub(crate) mod deferred;
pub mod framed;
mod interleave;
mod light;
pub(crate) mod medium;
mod near;
pub mod reference;
pub(crate) mod sets;
mod spherical;
#[cfg(test)]
mod tests;
pub(crate) mod vpl;

/// Whether soft shadows, indirect light and media are compiled in (feature `effects`). Without
/// them a scene that calls for one is refused, and what is left is the baseline against which
/// the cost of not using them is measured.
pub const BUILT_IN: bool = cfg!(feature = "effects");
