//! From sums to light: the weighted mean, or the ridge-regularised plane at the pixel's centre.
//!
//! With weighted means E[·] over the samples around a pixel at offsets (x, y), the plane that
//! minimises Σw(c − a − g·(x, y))² + Σw·ρ|g|² has
//!
//! `a = E[c] − cov(x, c)·h_x − cov(y, c)·h_y`, `h = (C + ρI)^−1 (E[x], E[y])`,
//!
//! so a pixel needs one 2 × 2 solve for all three colours. The ridge ρ = ρ₀ + |E|²/8, E being the
//! samples' mean offset, keeps it defined for any samples. Where they lie around the pixel there is little to
//! hold back, and a plane is worth most at edges; where they lie to one side it would extrapolate, and is pulled
//! towards their mean.

use crate::arith::{ANCHOR_BITS, Arith, Moments, Sums, Texel};

/// ρ₀, px² with 20 fractional bits: 0.02. With what the offset adds, |h| ≤ |E|/ρ ≤ 1/√(4·ρ₀/8) = 10 a pixel
/// bounds what rounded coordinates are enlarged by.
pub const RIDGE_Q20: i64 = 20972;
/// log2 of what of |E|² goes into the ridge: an eighth.
pub const LEAN_BITS: u32 = 3;

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
