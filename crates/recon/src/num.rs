//! Integer kernels: reciprocal, logarithm, narrow products. Each has a stated error and a test
//! against `f64`; each is a handful of 32-bit operations, so that WGSL and a Cortex-M run the
//! same steps.

use crate::tables::{EXP2_Q15, LOG2_Q11};

/// The high 32 bits of a 32 × 32-bit product.
#[inline(always)]
#[must_use]
pub const fn mul_hi(a: u32, b: u32) -> u32 {
    ((a as u64 * b as u64) >> 32) as u32
}

/// Reciprocal of a normalised divisor: for `d` in 2^31..2^32 the result is `2^63/d` within 8
/// units in the last place (relative error below 2^−28).
///
/// A 32-bit division seeds 16 good bits and one Newton step `r ← r(2 − d·r)` doubles them.
/// For any other `d` the result is meaningless but defined.
#[inline(always)]
#[must_use]
pub const fn reciprocal(d: u32) -> u32 {
    // The bit is set where `d` is normalised; now the compiler knows, too, that it is not 0.
    let seed = (u32::MAX / (d >> 16 | 1 << 15)) << 15;
    let error = mul_hi(d, seed).wrapping_neg();
    let (hi, lo) = {
        let product = seed as u64 * error as u64;
        ((product >> 32) as u32, product as u32)
    };
    // Doubling moves the product from Q62 to Q31; at d = 2^31 the quotient is 2^32: saturate.
    if hi >> 31 != 0 {
        u32::MAX
    } else {
        (hi << 1) | (lo >> 31)
    }
}

/// `floor(log2(v))` for a positive `v`.
#[inline]
#[must_use]
pub const fn exponent(v: u64) -> i32 {
    63 - v.leading_zeros() as i32
}

/// Shifts left for positive `by`, arithmetically right for negative; beyond 63 the right shift
/// keeps the sign and the left shift gives 0.
#[inline]
#[must_use]
pub const fn shift(v: i64, by: i32) -> i64 {
    if by >= 64 {
        0
    } else if by >= 0 {
        v << by
    } else if by > -64 {
        v >> -by
    } else {
        v >> 63
    }
}

/// The top 32 bits of a positive value, its leading one moved to bit 31.
#[inline(always)]
#[must_use]
pub const fn normalise(v: u64) -> u32 {
    let (high, low) = ((v >> 32) as u32, v as u32);
    if cfg!(target_pointer_width = "64") {
        ((v << (v.leading_zeros() & 63)) >> 32) as u32
    } else if high == 0 {
        low << (low.leading_zeros() & 31)
    } else {
        let up = high.leading_zeros() & 31;
        high << up | low >> 1 >> (31 - up)
    }
}

/// Bits 32 to 63 of `v · 2^up`, `up` below 64.
#[inline(always)]
#[must_use]
pub const fn upper(v: u64, up: u32) -> u32 {
    if cfg!(target_pointer_width = "64") {
        ((v << (up & 63)) >> 32) as u32
    } else if up & 32 == 0 {
        // Halves are shifted one by one where registers are that wide; which of the two it is
        // hardly changes from one sample to the next.
        let up = up & 31;
        ((v >> 32) as u32) << up | v as u32 >> 1 >> (31 - up)
    } else {
        (v as u32) << (up & 31)
    }
}

/// log2 with 11 fractional bits, from a table of 64 chords; within 1.25 units of the true
/// value.
/// Monotone. `log2_q11(0)` is that of 1.
#[inline]
#[must_use]
pub const fn log2_q11(v: u64) -> i32 {
    if v == 0 {
        return 0;
    }
    let mantissa = normalise(v) << 1; // without the leading one: a fraction of 2^32
    let chord = (mantissa >> 26) as usize;
    let along = (mantissa >> 16) & 0x3ff;
    let (a, b) = (LOG2_Q11[chord] as u32, LOG2_Q11[chord + 1] as u32);
    exponent(v) * 2048 + (a + (((b - a) * along + 512) >> 10)) as i32
}

/// 2^(−v) with 15 fractional bits, for `v` ≥ 0 with 12 fractional bits: a table of 256 chords and
/// a shift; within 1 unit of the true value.
#[inline]
#[must_use]
pub const fn exp2_negative(v: u32) -> u32 {
    let whole = v >> 12;
    if whole > 15 {
        return 0;
    }
    let chord = (v >> 4 & 0xff) as usize;
    let (a, b) = (EXP2_Q15[chord] as u32, EXP2_Q15[chord + 1] as u32);
    let mantissa = (a << 4) - (a - b) * (v & 15);
    (mantissa + (8 << whole)) >> (4 + whole)
}

/// 2^v with `bits` fractional bits (at most 16), for `v` with 11 fractional bits and
/// `v/2048 + bits` below 31; relative error below 2^−14, absolute below 1 unit.
#[inline]
#[must_use]
pub const fn exp2(v: i32, bits: i32) -> u32 {
    // v = up − rest with a whole `up` and 0 ≤ rest < 1.
    let up = (v + 2047) >> 11;
    let rest = ((up << 11) - v) as u32;
    let by = up + bits - 15;
    let mantissa = exp2_negative(rest << 1);
    if by >= 0 {
        mantissa << if by > 15 { 15 } else { by }
    } else if by > -31 {
        mantissa >> -by
    } else {
        0
    }
}

/// Division by one positive value, several times: a shift, a product.
#[derive(Clone, Copy, Debug)]
pub struct Divider {
    reciprocal: u32,
    /// Leading zeros of the divisor.
    zeros: i32,
}

impl Divider {
    /// Prepares division by `divisor`; a divisor of 0 acts as 1.
    #[inline]
    #[must_use]
    pub const fn new(divisor: u64) -> Self {
        let divisor = if divisor == 0 { 1 } else { divisor };
        Self {
            reciprocal: reciprocal(normalise(divisor)),
            zeros: divisor.leading_zeros() as i32,
        }
    }

    /// `v / divisor` with `31 − bits` fractional bits, given |v| ≤ divisor·2^bits.
    /// Relative error below 2^−28 and absolute error below 2 units in the last place; a quotient
    /// beyond 2^bits saturates.
    #[inline]
    #[must_use]
    pub const fn ratio(self, v: i64, bits: i32) -> i32 {
        let magnitude = v.unsigned_abs();
        // The upper half of the magnitude shifted as the divisor is, less `bits`; seldom right.
        let up = self.zeros - bits;
        let narrow = if up < 0 {
            if up > -32 { magnitude >> (32 - up) } else { 0 }
        } else {
            let beyond = if up < 64 {
                magnitude >> 1 >> (63 - up)
            } else {
                magnitude
            };
            if beyond == 0 {
                (magnitude << (up & 63)) >> 32
            } else {
                u32::MAX as u64
            }
        };
        let narrow = narrow as u32;
        let quotient = mul_hi(narrow, self.reciprocal);
        let quotient = if quotient > i32::MAX as u32 {
            i32::MAX
        } else {
            quotient as i32
        };
        if v < 0 { -quotient } else { quotient }
    }

    /// [`Divider::ratio`] where more is known: `v` is from 0 to `divisor`·2^`bits`, and the divisor
    /// has `bits` leading zeros.
    #[inline]
    #[must_use]
    pub const fn part(self, v: u64, bits: u32) -> u32 {
        let up = (self.zeros as u32).wrapping_sub(bits);
        mul_hi(upper(v, up), self.reciprocal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn reciprocal_is_close(d in 0x8000_0000u32..=u32::MAX) {
            let exact = (1u64 << 63) / u64::from(d);
            let got = u64::from(reciprocal(d));
            prop_assert!(got.abs_diff(exact) <= 8, "{d}: {got} against {exact}");
        }

        #[test]
        fn log2_is_close(v in 1u64..=u64::MAX, by in 0u32..63) {
            let v = (v >> by).max(1);
            let exact = (v as f64).log2() * 2048.0;
            prop_assert!((f64::from(log2_q11(v)) - exact).abs() <= 1.25, "{v}");
        }

        #[test]
        fn log2_is_monotone(v in 1u64..u64::MAX, by in 0u32..63) {
            let v = (v >> by).max(1);
            prop_assert!(log2_q11(v) <= log2_q11(v + 1));
        }

        #[test]
        fn exp2_negative_is_close(v in 0u32..20 << 12) {
            let exact = 32768.0 * (-f64::from(v) / 4096.0).exp2();
            prop_assert!((f64::from(exp2_negative(v)) - exact).abs() <= 1.0, "{v}");
        }

        #[test]
        fn exp2_is_close(v in -10 * 2048i32..14 * 2048, bits in 0i32..=16) {
            let exact = (f64::from(v) / 2048.0 + f64::from(bits)).exp2();
            let bound = 1.0 + exact * (-14f64).exp2();
            prop_assert!((f64::from(exp2(v, bits)) - exact).abs() <= bound, "{v} {bits}");
        }

        #[test]
        fn ratio_is_close(divisor in 1u64..1 << 50, by in 0u32..49, part in -1.0f64..1.0, bits in 0i32..30) {
            let divisor = (divisor >> by).max(1);
            let v = (part * divisor as f64 * f64::from(bits).exp2()) as i64;
            let exact = v as f64 / divisor as f64 * f64::from(31 - bits).exp2();
            let got = f64::from(Divider::new(divisor).ratio(v, bits));
            let bound = 2.0 + exact.abs() * (-28f64).exp2();
            prop_assert!((got - exact).abs() <= bound, "{v}/{divisor}: {got} against {exact}");
        }

        #[test]
        fn part_is_ratio(divisor in 1u64..1 << 48, by in 0u32..47, part in 0.0f64..=1.0, bits in 0u32..=16) {
            let divisor = (divisor >> by).max(1);
            let whole = divisor << bits;
            let v = ((part * whole as f64) as u64).min(whole);
            let divider = Divider::new(divisor);
            // One that is beyond 31 bits saturates there.
            let got = divider.part(v, bits).min(i32::MAX as u32);
            prop_assert_eq!(got as i32, divider.ratio(v as i64, bits as i32));
        }
    }
}
