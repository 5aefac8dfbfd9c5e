//! Products of narrow factors, several at a time.
//!
//! Compilers multiply 64 by 64 bits where sums are wide, one product at a time, since they do not
//! see that the factors are short. On x86-64 (SSE2 is always there) one instruction makes two such
//! products, or eight of 16 bits; elsewhere this is the plain loop. All are integers, so both give
//! the same bits.

pub use imp::{Along, Factor, Pair, Pixel, Row, between, rows};

/// Whether code for each number of lanes in use is worth its size.
pub const UNROLLS: bool = cfg!(target_arch = "x86_64");
/// Narrow values that are worked on at a time.
pub const LANES: usize = 8;

#[cfg(target_arch = "x86_64")]
mod imp {
    use super::LANES;
    use safe_arch::{
        add_i16_m128i, add_i64_m128i, get_i32_from_m128i_s, m128i, min_i16_m128i,
        mul_i16_horizontal_add_m128i, mul_i16_keep_low_m128i, mul_u16_keep_high_m128i,
        mul_widen_u32_odd_m128i, set_i32_m128i_s, set_i64_m128i_s, set_splat_i16_m128i,
        set_splat_i32_m128i, set_splat_i64_m128i, shl_imm_u16_m128i, shr_all_u16_m128i,
        shr_imm_u16_m128i, shr_imm_u64_m128i, shuffle_ai_f32_all_m128i, sub_saturating_u16_m128i,
        unpack_high_i16_m128i, unpack_low_i16_m128i,
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

    /// What a row's tap leaves of a weight, beside the half that rounds what it is multiplied by.
    #[derive(Clone, Copy, Debug)]
    pub struct Row(u32);

    /// The products of a weight, at most 1, and of taps below 1, with 15 fractional bits each,
    /// rounded.
    #[inline]
    #[must_use]
    pub fn rows(weight: u16, taps: &[u16; LANES]) -> [Row; LANES] {
        let twice = shl_imm_u16_m128i::<1>(m128i::from(*taps));
        let weight = set_splat_i16_m128i(weight as i16);
        // Twice the product: its upper half, and the bit below, which rounds.
        let high = mul_u16_keep_high_m128i(twice, weight);
        let low = mul_i16_keep_low_m128i(twice, weight);
        let products = add_i16_m128i(high, shr_imm_u16_m128i::<15>(low));
        let half = set_splat_i16_m128i(1 << 14);
        let [a, b, c, d]: [u32; 4] = unpack_low_i16_m128i(products, half).into();
        let [e, f, g, h]: [u32; 4] = unpack_high_i16_m128i(products, half).into();
        [a, b, c, d, e, f, g, h].map(Row)
    }

    /// Taps along a row, each beside a one.
    #[derive(Clone, Copy, Debug)]
    pub struct Along([m128i; 2]);

    impl Along {
        /// Of taps below 1, 15 fractional bits.
        #[inline]
        #[must_use]
        pub fn new(taps: &[u16; LANES]) -> Self {
            let (taps, one) = (m128i::from(*taps), set_splat_i16_m128i(1));
            Self([
                unpack_low_i16_m128i(taps, one),
                unpack_high_i16_m128i(taps, one),
            ])
        }

        /// The products of what a row's tap left and of the taps, rounded.
        #[inline]
        #[must_use]
        pub fn factors(&self, row: Row) -> [Factor; LANES] {
            let row = set_splat_i32_m128i(row.0 as i32);
            // The tap times the weight, and once the half.
            let [first, last] = self.0.map(|taps| mul_i16_horizontal_add_m128i(taps, row));
            // Shifted so that zeros come in above, which the compiler sees.
            let factor = |product| Factor(shr_imm_u64_m128i::<47>(product));
            [
                factor(shuffle_ai_f32_all_m128i::<0b00_00_00_00>(first)),
                factor(shuffle_ai_f32_all_m128i::<0b01_01_01_01>(first)),
                factor(shuffle_ai_f32_all_m128i::<0b10_10_10_10>(first)),
                factor(shuffle_ai_f32_all_m128i::<0b11_11_11_11>(first)),
                factor(shuffle_ai_f32_all_m128i::<0b00_00_00_00>(last)),
                factor(shuffle_ai_f32_all_m128i::<0b01_01_01_01>(last)),
                factor(shuffle_ai_f32_all_m128i::<0b10_10_10_10>(last)),
                factor(shuffle_ai_f32_all_m128i::<0b11_11_11_11>(last)),
            ]
        }
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

    /// Column and row of a pixel.
    #[derive(Clone, Copy, Debug)]
    pub struct Pixel(m128i);

    impl Pixel {
        /// Of a column and a row, below 2^15.
        #[inline]
        #[must_use]
        pub fn new([column, row]: [u16; 2]) -> Self {
            let both = u32::from(column) | u32::from(row) << 16;
            Self(set_i32_m128i_s(both as i32))
        }

        /// The one in which coordinates of `bits` fractional bits lie; at least one fractional bit.
        #[inline]
        #[must_use]
        pub fn of(at: [u16; 2], bits: u32) -> Self {
            Self::new(at).coarser(bits)
        }

        /// The one that is so many further to the left and up, at least the first, and not beyond
        /// the last.
        #[inline]
        #[must_use]
        pub fn less(self, by: u16, last: [u16; 2]) -> Self {
            let less = sub_saturating_u16_m128i(self.0, set_splat_i16_m128i(by as i16));
            Self(min_i16_m128i(less, Self::new(last).0))
        }

        /// The square of 2^`bits` pixels around it.
        #[inline]
        #[must_use]
        pub fn coarser(self, bits: u32) -> Self {
            Self(shr_all_u16_m128i(self.0, set_i64_m128i_s(bits.into())))
        }

        /// Where it lies in rows of `width`, which is below 2^15.
        #[inline]
        #[must_use]
        pub fn index(self, width: u16) -> usize {
            let index = mul_i16_horizontal_add_m128i(self.0, Self::new([1, width]).0);
            get_i32_from_m128i_s(index) as usize
        }

        /// Column and row.
        #[inline]
        #[must_use]
        pub fn place(self) -> [u16; 2] {
            let both = get_i32_from_m128i_s(self.0) as u32;
            [both as u16, (both >> 16) as u16]
        }
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

    /// The product of two weights, rounded.
    const fn times(a: u16, b: u16) -> u16 {
        ((a as u32 * b as u32 + (1 << 14)) >> 15) as u16
    }

    /// What a row's tap leaves of a weight.
    #[derive(Clone, Copy, Debug)]
    pub struct Row(u16);

    /// The products of a weight, at most 1, and of taps below 1, with 15 fractional bits each,
    /// rounded.
    #[inline]
    #[must_use]
    pub fn rows(weight: u16, taps: &[u16; LANES]) -> [Row; LANES] {
        taps.map(|tap| Row(times(weight, tap)))
    }

    /// Taps along a row.
    #[derive(Clone, Copy, Debug)]
    pub struct Along([u16; LANES]);

    impl Along {
        /// Of taps below 1, 15 fractional bits.
        #[inline]
        #[must_use]
        pub fn new(taps: &[u16; LANES]) -> Self {
            Self(*taps)
        }

        /// The products of what a row's tap left and of the taps, rounded.
        #[inline]
        #[must_use]
        pub fn factors(&self, row: Row) -> [Factor; LANES] {
            self.0.map(|tap| Factor(times(row.0, tap)))
        }
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

    /// Column and row of a pixel.
    #[derive(Clone, Copy, Debug)]
    pub struct Pixel([u16; 2]);

    impl Pixel {
        /// Of a column and a row, below 2^15.
        #[inline]
        #[must_use]
        pub fn new(place: [u16; 2]) -> Self {
            Self(place)
        }

        /// The one in which coordinates of `bits` fractional bits lie; at least one fractional bit.
        #[inline]
        #[must_use]
        pub fn of(at: [u16; 2], bits: u32) -> Self {
            Self(at).coarser(bits)
        }

        /// The one that is so many further to the left and up, at least the first, and not beyond
        /// the last.
        #[inline]
        #[must_use]
        pub fn less(self, by: u16, last: [u16; 2]) -> Self {
            let [x, y] = self.0.map(|v| v.saturating_sub(by));
            Self([x.min(last[0]), y.min(last[1])])
        }

        /// The square of 2^`bits` pixels around it.
        #[inline]
        #[must_use]
        pub fn coarser(self, bits: u32) -> Self {
            Self(self.0.map(|v| (u32::from(v) >> bits) as u16))
        }

        /// Where it lies in rows of `width`, which is below 2^15.
        #[inline]
        #[must_use]
        pub fn index(self, width: u16) -> usize {
            let [x, y] = self.0.map(usize::from);
            y * usize::from(width) + x
        }

        /// Column and row.
        #[inline]
        #[must_use]
        pub fn place(self) -> [u16; 2] {
            self.0
        }
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
            a: u32, b: u32, weight in 0u16..=1 << 15, down in prop::array::uniform8(0u16..1 << 15),
            across in prop::array::uniform8(0u16..1 << 15), sums: [i64; 2],
        ) {
            let times = |a: u64, b: u16| (u64::from(b) * a + (1 << 14)) >> 15;
            for (row, tap) in rows(weight, &down).into_iter().zip(down) {
                let weight = times(weight.into(), tap);
                for (factor, tap) in Along::new(&across).factors(row).into_iter().zip(across) {
                    let mut got = sums;
                    Pair::new(a, b).add_to(factor, &mut got);
                    let weight = times(weight, tap);
                    let product = |v: u32| (u64::from(v) * weight) as i64;
                    prop_assert_eq!(got[0], sums[0].wrapping_add(product(a)));
                    prop_assert_eq!(got[1], sums[1].wrapping_add(product(b)));
                    let mut same = sums;
                    Pair::new(a, b).add_to(Factor::new(weight as u16), &mut same);
                    prop_assert_eq!(same, got);
                }
            }
        }

        #[test]
        fn pixels_are_columns_and_rows(
            at: [u16; 2], bits in 1u32..=8, by in 0u16..100, last in prop::array::uniform2(0u16..5000),
            coarse in 0u32..=16, width in 0u16..5000,
        ) {
            let pixel = Pixel::of(at, bits).less(by, last);
            let place: [u16; 2] =
                core::array::from_fn(|i| (at[i] >> bits).saturating_sub(by).min(last[i]));
            prop_assert_eq!(pixel.place(), place);
            let [x, y] = place.map(|v| usize::from(v) >> coarse);
            prop_assert_eq!(pixel.coarser(coarse).index(width), y * usize::from(width) + x);
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
