//! From sums to light: the weighted mean, or the ridge-regularised plane at the pixel's centre.
//!
//! With weighted means E[·] over the samples around a pixel at offsets (x, y), the plane that
//! minimises Σw(c − a − g·(x, y))² + Σw·ρ|g|² has
//!
//! `a = E[c] − cov(x, c)·h_x − cov(y, c)·h_y`, `h = (C + ρI)^−1 (E[x], E[y])`,
//!
//! so a pixel needs one 2 × 2 solve for all three colours. The ridge ρ keeps it defined for any
//! samples and pulls towards the mean where they lie in one place.

use crate::arith::{ANCHOR_BITS, Arith, Moments, Sums, Texel};

/// The ridge ρ, px² with 20 fractional bits: 0.1. It bounds |h| by |(E\[x\], E\[y\])|/ρ,
/// which is what rounded coordinates are enlarged by: 0.04 px² doubles that and errs no less.
pub const RIDGE_Q20: i64 = 104858;

/// Solves pixels by their means.
pub fn means<A: Arith>(sums: &[Sums<A>], texels: &mut [Texel<A>]) {
    for (sums, texel) in sums.iter().zip(texels) {
        *texel = A::mean(sums);
    }
}

/// Solves the pixels of rows of `width` from row `top` on by their planes, from moments about
/// their squares' anchors.
pub fn planes<A: Arith>(
    width: usize,
    top: usize,
    sums: &[Sums<A>],
    moments: &[Moments<A>],
    texels: &mut [Texel<A>],
) {
    let width = width.max(1);
    let within = |v: usize| (v & ((1 << ANCHOR_BITS) - 1)) as i32;
    let lines = sums.chunks_exact(width).zip(moments.chunks_exact(width));
    for (y, ((sums, moments), texels)) in lines.zip(texels.chunks_exact_mut(width)).enumerate() {
        for (x, ((sums, moments), texel)) in sums.iter().zip(moments).zip(texels).enumerate() {
            let moments = A::centred(sums, moments, (within(x), within(top + y)));
            *texel = A::plane(sums, &moments);
        }
    }
}
