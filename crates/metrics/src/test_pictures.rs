//! Pictures for the tests: seeded, and blurred by a known amount.

use crate::Image;

/// A view of `pixels` with rows of `width`.
pub(crate) fn view(pixels: &[[u8; 3]], width: usize) -> Image<'_> {
    Image::new(pixels, width, pixels.len() / width).unwrap()
}

/// The next of a 64-bit LCG's outputs (Knuth's MMIX constants), its high 32 bits.
pub(crate) fn next(state: &mut u64) -> u32 {
    *state = state
        .wrapping_mul(6364136223846793005)
        .wrapping_add(1442695040888963407);
    (*state >> 32) as u32
}

/// Independent uniform bytes.
pub(crate) fn noise(width: usize, height: usize, seed: u64) -> Vec<[u8; 3]> {
    let mut state = seed;
    (0..width * height)
        .map(|_| [0; 3].map(|_: u8| (next(&mut state) >> 24) as u8))
        .collect()
}

/// Coloured blocks of 8 × 8 pixels that travel `shift` pixels to the right.
pub(crate) fn blocks(width: usize, height: usize, shift: usize) -> Vec<[u8; 3]> {
    let mut out = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let (bx, by) = ((x + 1000 * 8 - shift) / 8 % 16, y / 8);
            let mut state = (bx * 31 + by) as u64;
            next(&mut state);
            out.push([0; 3].map(|_: u8| (next(&mut state) >> 24) as u8));
        }
    }
    out
}

/// A box blur of radius `r` pixels, clamped at the border.
pub(crate) fn blurred(pixels: &[[u8; 3]], width: usize, r: usize) -> Vec<[u8; 3]> {
    let height = pixels.len() / width;
    let mut out = Vec::with_capacity(pixels.len());
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut n) = ([0u32; 3], 0);
            for v in y.saturating_sub(r)..(y + r + 1).min(height) {
                for u in x.saturating_sub(r)..(x + r + 1).min(width) {
                    for (s, c) in sum.iter_mut().zip(pixels[v * width + u]) {
                        *s += u32::from(c);
                    }
                    n += 1;
                }
            }
            out.push(sum.map(|s| ((s + n / 2) / n) as u8));
        }
    }
    out
}
