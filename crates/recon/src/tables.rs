//! Tables, computed at compile time in `f64` by series (no library function is `const`).
//!
//! Their entries decide the picture: WGSL uploads these very arrays.

/// Natural logarithm of `x` in 1/2..2, by the series of 2·atanh((x−1)/(x+1)).
const fn ln_near_one(x: f64) -> f64 {
    let y = (x - 1.0) / (x + 1.0);
    let square = y * y;
    let mut power = y;
    let mut sum = 0.0;
    let mut k = 1;
    while k < 60 {
        sum += power / k as f64;
        power *= square;
        k += 2;
    }
    2.0 * sum
}

const LN_2: f64 = core::f64::consts::LN_2;

/// Natural logarithm of a positive `x`.
const fn ln(mut x: f64) -> f64 {
    let mut octaves = 0.0;
    while x > 1.5 {
        x *= 0.5;
        octaves += 1.0;
    }
    while x < 0.75 {
        x *= 2.0;
        octaves -= 1.0;
    }
    ln_near_one(x) + octaves * LN_2
}

/// e^x, by halving the argument until the series converges and squaring back.
const fn exp(x: f64) -> f64 {
    let mut halvings = 0;
    let mut y = x;
    while y > 0.01 || y < -0.01 {
        y *= 0.5;
        halvings += 1;
    }
    let mut term = 1.0;
    let mut sum = 1.0;
    let mut k = 1;
    while k < 12 {
        term *= y / k as f64;
        sum += term;
        k += 1;
    }
    while halvings > 0 {
        sum *= sum;
        halvings -= 1;
    }
    sum
}

/// log2(1 + i/64) with 11 fractional bits.
pub static LOG2_Q11: [u16; 65] = {
    let mut table = [0; 65];
    let mut i = 0;
    while i < 65 {
        table[i] = (ln(1.0 + i as f64 / 64.0) / LN_2 * 2048.0 + 0.5) as u16;
        i += 1;
    }
    table
};

/// Kinds of decline with age.
pub const TIME_KERNELS: usize = 3;
/// Entries a kernel in [`TIME`].
pub const TIME_LEN: usize = 12 * 256;
/// log2(age/lifetime) of the first entry of [`TIME`], with 8 fractional bits.
pub const TIME_FIRST: i32 = -8 * 256;

/// Weight with 15 fractional bits against log2 of u = age/lifetime with 8 fractional bits, from
/// 2^−8 to 2^4: the rational tail 1/(1+u²+u⁴), the Gaussian e^(−u²/2), the exponential e^(−u).
pub static TIME: [[u16; TIME_LEN]; TIME_KERNELS] = {
    let mut table = [[0; TIME_LEN]; TIME_KERNELS];
    let step = exp(LN_2 / 256.0);
    // One octave by repeated products, the others by doubling: exact enough and cheap to build.
    let mut octave = [0.0; 256];
    let mut u = 1.0 / 256.0;
    let mut i = 0;
    while i < 256 {
        octave[i] = u;
        u *= step;
        i += 1;
    }
    let mut i = 0;
    while i < TIME_LEN {
        let u = octave[i % 256] * (1u32 << (i / 256)) as f64;
        let square = u * u;
        table[0][i] = (32768.0 / (1.0 + square + square * square) + 0.5) as u16;
        table[1][i] = (32768.0 * exp(-0.5 * square) + 0.5) as u16;
        table[2][i] = (32768.0 * exp(-u) + 0.5) as u16;
        i += 1;
    }
    table
};

/// 2^(−i/256) with 15 fractional bits.
pub static EXP2_Q15: [u16; 257] = {
    let mut table = [0; 257];
    let mut i = 0;
    while i < 257 {
        table[i] = (32768.0 * exp(-(i as f64) / 256.0 * LN_2) + 0.5) as u16;
        i += 1;
    }
    table
};

/// Linear light with 16 bits (0..=65535) of each 8-bit sRGB code (IEC 61966-2-1).
pub static SRGB_TO_LINEAR: [u16; 256] = {
    let mut table = [0; 256];
    let mut c = 0;
    while c < 256 {
        let v = c as f64 / 255.0;
        let light = if v <= 0.04045 {
            v / 12.92
        } else {
            exp(2.4 * ln((v + 0.055) / 1.055))
        };
        table[c] = (light * 65535.0 + 0.5) as u16;
        c += 1;
    }
    table
};

/// The least linear light that rounds to each sRGB code, by the code's lower half step; entry 0
/// is 0.
pub static SRGB_FROM: [u16; 256] = {
    let mut table = [0; 256];
    let mut c = 1;
    while c < 256 {
        let v = (c as f64 - 0.5) / 255.0;
        let light = if v <= 0.04045 {
            v / 12.92
        } else {
            exp(2.4 * ln((v + 0.055) / 1.055))
        };
        let exact = light * 65535.0;
        let floor = exact as u16;
        table[c] = if exact > floor as f64 {
            floor + 1
        } else {
            floor
        };
        c += 1;
    }
    table
};

/// The greatest linear light that rounds to each sRGB code.
static SRGB_UP_TO: [u16; 256] = {
    let mut table = [u16::MAX; 256];
    let mut c = 0;
    while c < 255 {
        table[c] = SRGB_FROM[c + 1] - 1;
        c += 1;
    }
    table
};

/// A lower bound of the sRGB code of each top 12 bits of linear light.
pub static SRGB_GUESS: [u8; 4096] = {
    let mut table = [0; 4096];
    let mut code = 0;
    let mut i = 0;
    while i < 4096 {
        while code < 255 && SRGB_FROM[code + 1] as usize <= i << 4 {
            code += 1;
        }
        table[i] = code as u8;
        i += 1;
    }
    table
};

/// The sRGB code nearest to a linear light of 16 bits.
#[inline]
#[must_use]
pub fn linear_to_srgb(light: u16) -> u8 {
    let code = SRGB_GUESS[usize::from(light >> 4)];
    // One step of 2^-12 spans at most one code boundary (the steepest slope is 12.92·255/4096):
    // which, no processor foresees, so it is added rather than branched on.
    code + u8::from(light > SRGB_UP_TO[usize::from(code)])
}

/// The 8-bit code nearest to a light of 16 bits that is spread evenly over the codes.
#[inline]
#[must_use]
pub const fn even_to_code(light: u16) -> u8 {
    ((light as u32 + 128) / 257) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_match_the_formulas() {
        for (i, &v) in LOG2_Q11.iter().enumerate() {
            assert!((f64::from(v) - (1.0 + i as f64 / 64.0).log2() * 2048.0).abs() <= 0.501);
        }
        for i in 0..TIME_LEN {
            let u = (f64::from(TIME_FIRST + i as i32) / 256.0).exp2();
            let exact = [
                1.0 / (1.0 + u * u + u.powi(4)),
                (-0.5 * u * u).exp(),
                (-u).exp(),
            ];
            for (row, exact) in TIME.iter().zip(exact) {
                assert!((f64::from(row[i]) - exact * 32768.0).abs() <= 0.51, "{i}");
            }
        }
        for (i, &v) in EXP2_Q15.iter().enumerate() {
            assert!((f64::from(v) - 32768.0 * (-(i as f64) / 256.0).exp2()).abs() <= 0.501);
        }
    }

    #[test]
    fn srgb_is_exact_and_round_trips() {
        for light in 0..=u16::MAX {
            let v = f64::from(light) / 65535.0;
            let code = if v <= 0.0031308 {
                12.92 * v
            } else {
                1.055 * v.powf(1.0 / 2.4) - 0.055
            } * 255.0;
            let got = f64::from(linear_to_srgb(light));
            assert!((got - code).abs() <= 0.5001, "{light}: {got} for {code}");
        }
        for code in 0..=255u8 {
            assert_eq!(linear_to_srgb(SRGB_TO_LINEAR[usize::from(code)]), code);
        }
    }

    #[test]
    fn even_codes_are_exact_and_round_trip() {
        for light in 0..=u16::MAX {
            let exact = f64::from(light) / 257.0;
            assert!(
                (f64::from(even_to_code(light)) - exact).abs() <= 0.5,
                "{light}"
            );
        }
        for code in 0..=255u8 {
            assert_eq!(even_to_code(u16::from(code) * 257), code);
        }
    }
}
