//! Products of narrow factors, several at a time.
//!
//! Compilers multiply 64 by 64 bits where sums are wide, one product at a time, since they do not
//! see that the factors are short. On x86-64 (SSE2 is always there) one instruction makes two such
//! products, or eight of 16 bits; elsewhere this is the plain loop. All are integers, so both give
//! the same bits.

pub use imp::{Factor, Pair, between, factors};

/// Whether code for each number of lanes in use is worth its size.
pub const UNROLLS: bool = cfg!(target_arch = "x86_64");
/// Narrow values that are worked on at a time.
pub const LANES: usize = 8;

#[cfg(target_arch = "x86_64")]
mod imp {
    use super::LANES;
    use safe_arch::{
        add_i16_m128i, add_i64_m128i, m128i, mul_i16_keep_low_m128i, mul_u16_keep_high_m128i,
        mul_widen_u32_odd_m128i, set_splat_i16_m128i, set_splat_i64_m128i, shl_imm_u16_m128i,
        shr_imm_u16_m128i, shuffle_ai_f32_all_m128i, sub_saturating_u16_m128i,
        unpack_high_i16_m128i, unpack_low_i16_m128i, zeroed_m128i,
    };

    /// A weight in both lanes.
    #[derive(Clone, Copy, Debug)]
    pub struct Factor(m128i);

    impl Factor {
        /// Of a weight.
        #[inline]
        #[must_use]
        pub fn new(weight: u16) -> Self {
            Self(set_splat_i64_m128i(weight.into()))
        }
    }

    /// The products of a weight, at most 1, and of taps below 1, with 15 fractional bits each,
    /// rounded.
    #[inline]
    #[must_use]
    pub fn factors(weight: u16, taps: &[u16; LANES]) -> [Factor; LANES] {
        let twice = shl_imm_u16_m128i::<1>(m128i::from(*taps));
        let weight = set_splat_i16_m128i(weight as i16);
        // Twice the product: its upper half, and the bit below, which rounds.
        let high = mul_u16_keep_high_m128i(twice, weight);
        let low = mul_i16_keep_low_m128i(twice, weight);
        let products = add_i16_m128i(high, shr_imm_u16_m128i::<15>(low));
        let first = unpack_low_i16_m128i(products, zeroed_m128i());
        let last = unpack_high_i16_m128i(products, zeroed_m128i());
        [
            Factor(shuffle_ai_f32_all_m128i::<0b00_00_00_00>(first)),
            Factor(shuffle_ai_f32_all_m128i::<0b01_01_01_01>(first)),
            Factor(shuffle_ai_f32_all_m128i::<0b10_10_10_10>(first)),
            Factor(shuffle_ai_f32_all_m128i::<0b11_11_11_11>(first)),
            Factor(shuffle_ai_f32_all_m128i::<0b00_00_00_00>(last)),
            Factor(shuffle_ai_f32_all_m128i::<0b01_01_01_01>(last)),
            Factor(shuffle_ai_f32_all_m128i::<0b10_10_10_10>(last)),
            Factor(shuffle_ai_f32_all_m128i::<0b11_11_11_11>(last)),
        ]
    }

    /// The values `part`/256 of the way from `a` to `b`, rounded down; `a` itself where `b` is less.
    #[inline]
    #[must_use]
    pub fn between(a: &[u16; LANES], b: &[u16; LANES], part: u16) -> [u16; LANES] {
        let (a, b, part) = (
            m128i::from(*a),
            m128i::from(*b),
            set_splat_i16_m128i((part << 8) as i16),
        );
        let rise = sub_saturating_u16_m128i(b, a);
        add_i16_m128i(a, mul_u16_keep_high_m128i(rise, part)).into()
    }

    /// Two values.
    #[derive(Clone, Copy, Debug)]
    pub struct Pair(m128i);

    impl Pair {
        /// Of two values.
        #[inline]
        #[must_use]
        pub fn new(a: u32, b: u32) -> Self {
            // Twice: an upper half that is known to be zero would let the compiler forget, across
            // a loop, that it is.
            Self(m128i::from([a, a, b, b]))
        }

        /// Adds both values, weighted, to two sums, modulo 2^64.
        #[inline]
        pub fn add_to(self, weight: Factor, sums: &mut [i64; 2]) {
            let products = mul_widen_u32_odd_m128i(self.0, weight.0);
            *sums = add_i64_m128i(m128i::from(*sums), products).into();
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod imp {
    use super::LANES;

    /// A weight.
    #[derive(Clone, Copy, Debug)]
    pub struct Factor(u16);

    impl Factor {
        /// Of a weight.
        #[inline]
        #[must_use]
        pub fn new(weight: u16) -> Self {
            Self(weight)
        }
    }

    /// The products of a weight, at most 1, and of taps below 1, with 15 fractional bits each,
    /// rounded.
    #[inline]
    #[must_use]
    pub fn factors(weight: u16, taps: &[u16; LANES]) -> [Factor; LANES] {
        taps.map(|tap| Factor(((u32::from(weight) * u32::from(tap) + (1 << 14)) >> 15) as u16))
    }

    /// The values `part`/256 of the way from `a` to `b`, rounded down; `a` itself where `b` is less.
    #[inline]
    #[must_use]
    pub fn between(a: &[u16; LANES], b: &[u16; LANES], part: u16) -> [u16; LANES] {
        core::array::from_fn(|i| {
            let rise = u32::from(b[i].saturating_sub(a[i])) * u32::from(part);
            a[i].wrapping_add((rise >> 8) as u16)
        })
    }

    /// Two values.
    #[derive(Clone, Copy, Debug)]
    pub struct Pair([u32; 2]);

    impl Pair {
        /// Of two values.
        #[inline]
        #[must_use]
        pub fn new(a: u32, b: u32) -> Self {
            Self([a, b])
        }

        /// Adds both values, weighted, to two sums, modulo 2^64.
        #[inline]
        pub fn add_to(self, weight: Factor, sums: &mut [i64; 2]) {
            for (sum, value) in sums.iter_mut().zip(self.0) {
                *sum = sum.wrapping_add((u64::from(weight.0) * u64::from(value)) as i64);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn factors_are_products_and_pairs_add_them(
            a: u32, b: u32, weight in 0u16..=1 << 15, taps in prop::array::uniform8(0u16..1 << 15),
            sums: [i64; 2],
        ) {
            for (factor, tap) in factors(weight, &taps).into_iter().zip(taps) {
                let mut got = sums;
                Pair::new(a, b).add_to(factor, &mut got);
                let weight = (u64::from(weight) * u64::from(tap) + (1 << 14)) >> 15;
                let product = |v: u32| (u64::from(v) * weight) as i64;
                prop_assert_eq!(got[0], sums[0].wrapping_add(product(a)));
                prop_assert_eq!(got[1], sums[1].wrapping_add(product(b)));
                let mut same = sums;
                Pair::new(a, b).add_to(Factor::new(weight as u16), &mut same);
                prop_assert_eq!(same, got);
            }
        }

        #[test]
        fn between_is_part_of_the_way(a: [u16; LANES], b: [u16; LANES], part in 0u16..256) {
            for ((got, a), b) in between(&a, &b, part).into_iter().zip(a).zip(b) {
                let rise = u32::from(b.saturating_sub(a)) * u32::from(part) / 256;
                prop_assert_eq!(u32::from(got), u32::from(a) + rise);
            }
        }
    }
}
