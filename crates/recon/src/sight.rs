//! From a lattice point to its place on the screen: the numerators of [`Transform`] and their division
//! by the distance, in integers.

use crate::arith::{GUARD, Panel};
use crate::num::{log2_q11, mul_hi, normalise, reciprocal, upper};
use crate::transform::Transform;

/// log2 of the nearest depth that is told apart, world units: 1, so that the farthest is 2^32,
/// beyond the sky.
pub const DEPTH_FIRST: i32 = 0;

/// A direction from the guard band's corner: x and y in pixels are x/w and y/w, the depth is w in
/// units of 2^`exponent`. None is beyond 2^62.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sight {
    x: u64,
    y: u64,
    w: u64,
    exponent: i32,
}

impl Sight {
    /// In which direction a lattice point is seen, and whether that is before the eye and within
    /// the guard.
    #[inline(always)]
    #[must_use]
    pub fn of(transform: &Transform, panel: &Panel, place: [i16; 3]) -> (Self, bool) {
        let [nx, ny, w] = transform.numerators(place);
        // |n| < 2^50, so the products with at most 2^12 cannot overflow.
        let guard = w * i64::from(GUARD);
        let (x, y) = (nx + guard, ny + guard);
        // Neither below zero nor beyond the guard: one comparison.
        let within = |v: i64, size: u16| {
            let limit = w * (i64::from(size) + 2 * i64::from(GUARD));
            (v as u64) < limit as u64
        };
        let inside = (w > 0) & within(x, panel.width) & within(y, panel.height);
        let sight = Self {
            x: x as u64,
            y: y as u64,
            w: w as u64,
            exponent: transform.exponent,
        };
        (sight, inside)
    }

    /// The place of what is in sight: x, y and depth.
    #[inline(always)]
    #[must_use]
    pub fn place(&self, panel: &Panel) -> (u16, u16, u16) {
        let inverse = reciprocal(normalise(self.w));
        let extent = u32::from(panel.extent_bits);
        let drop = 31 - extent - u32::from(panel.frac_bits);
        // w < 2^50, so that it has more leading zeros than `extent`; x and y are below w·2^extent.
        let up = self.w.leading_zeros().wrapping_sub(extent);
        let quotient = |v: u64| (mul_hi(upper(v, up), inverse) >> drop) as u16;
        let depth = log2_q11(self.w) + (self.exponent - DEPTH_FIRST) * 2048;
        let depth = depth.clamp(0, 65534) as u16;
        (quotient(self.x), quotient(self.y), depth)
    }
}
