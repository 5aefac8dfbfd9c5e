//! Sums of products two at a time: 32 × 32-bit factors into 64-bit sums.
//!
//! Compilers multiply 64 by 64 bits here, one product at a time, since they do not see that the
//! factors are short. On x86-64 (SSE2 is always there) one instruction makes two such products;
//! elsewhere this is the plain loop. The sums are integers, so both give the same bits.

pub use imp::{Pair, Weight};

#[cfg(target_arch = "x86_64")]
mod imp {
    use safe_arch::{add_i64_m128i, m128i, mul_widen_u32_odd_m128i, set_splat_i64_m128i};

    /// A factor for both lanes.
    #[derive(Clone, Copy, Debug)]
    pub struct Weight(m128i);

    impl Weight {
        /// A weight.
        #[inline]
        #[must_use]
        pub fn new(weight: u16) -> Self {
            Self(set_splat_i64_m128i(weight.into()))
        }
    }

    /// Two factors.
    #[derive(Clone, Copy, Debug)]
    pub struct Pair(m128i);

    impl Pair {
        /// Of two values.
        #[inline]
        #[must_use]
        pub fn new(a: u32, b: u32) -> Self {
            Self(m128i::from([i64::from(a), i64::from(b)]))
        }

        /// Adds both values, weighted, to two sums, modulo 2^64.
        #[inline]
        pub fn add_to(self, weight: Weight, sums: &mut [i64; 2]) {
            let products = mul_widen_u32_odd_m128i(self.0, weight.0);
            *sums = add_i64_m128i(m128i::from(*sums), products).into();
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod imp {
    /// A factor for both lanes.
    #[derive(Clone, Copy, Debug)]
    pub struct Weight(u16);

    impl Weight {
        /// A weight.
        #[inline]
        #[must_use]
        pub fn new(weight: u16) -> Self {
            Self(weight)
        }
    }

    /// Two factors.
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
        pub fn add_to(self, weight: Weight, sums: &mut [i64; 2]) {
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
        fn pairs_are_products(a: u32, b: u32, weight: u16, sums: [i64; 2]) {
            let mut got = sums;
            Pair::new(a, b).add_to(Weight::new(weight), &mut got);
            let product = |v: u32| (u64::from(v) * u64::from(weight)) as i64;
            prop_assert_eq!(got[0], sums[0].wrapping_add(product(a)));
            prop_assert_eq!(got[1], sums[1].wrapping_add(product(b)));
        }
    }
}
