//! The glass: what a panel does with the picture that it is given.
//!
//! Two imperfections, each present only when the profile calls for it: a controller that drives
//! fewer bits than 8 a channel dithers in a pattern (Bayer 1973), and a pixel takes time to reach
//! its level, here a first-order lag. Both act on display-referred levels (the sRGB bytes), in
//! integers: the same on every machine. The controller comes first, the glass after it.

/// The 8×8 ordered-dither matrix (Bayer 1973): each of 0..64 once.
const BAYER: [[u8; 8]; 8] = {
    let mut matrix = [[0; 8]; 8];
    let mut y = 0;
    while y < 8 {
        let mut x = 0;
        while x < 8 {
            // Bits of x^y and y interleaved, the lowest bit of the place weighing most.
            let (a, b) = (x ^ y, y);
            let mut value = 0;
            let mut bit = 0;
            while bit < 3 {
                value |= ((a >> bit) & 1) << (5 - 2 * bit);
                value |= ((b >> bit) & 1) << (4 - 2 * bit);
                bit += 1;
            }
            matrix[y][x] = value as u8;
            x += 1;
        }
        y += 1;
    }
    matrix
};

/// `2^(-2^-k)` for k = 1..=16, with 32 fractional bits: the factors of any `2^-f`, 0 ≤ f < 1.
const EXP2: [u32; 16] = {
    let mut table = [0; 16];
    // 2^-(1/2^k) is the square root of its predecessor; the first is √½.
    let mut square: u128 = 1 << 63; // ½ with 64 fractional bits
    let mut k = 0;
    while k < 16 {
        // √ of a Q64 number is a Q32 number; with 62 more bits below it is Q63.
        let root = (square << 62).isqrt();
        table[k] = ((root + (1 << 30)) >> 31) as u32;
        square = root << 1;
        k += 1;
    }
    table
};

/// log2 e with 32 fractional bits.
const LOG2_E_Q32: u128 = 6_196_328_019;

/// What a panel does with a picture. The default does nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Profile {
    /// Bits a channel that the controller drives, red, green, blue, 1..=8 each; 8 is exact.
    pub dither: Option<[u8; 3]>,
    /// Time constant of a pixel's response in microseconds, 1 or more: after it 63 % of a step
    /// is done, after 2.3 of it 90 %.
    pub response: Option<u32>,
}

/// Why a panel cannot be made or driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PanelError {
    /// A channel with a depth that does not exist.
    #[error("panel: {0} bits a channel; a channel has 1 to 8")]
    Bits(u8),
    /// A time constant of zero.
    #[error("panel: a response time of 0 µs; leave it out for a panel without lag")]
    Response,
    /// A picture of another size.
    #[error("panel: a picture of {got} bytes; this panel takes {expected} (3 a pixel)")]
    Size {
        /// Bytes given.
        got: usize,
        /// Bytes of the panel.
        expected: usize,
    },
}

/// A panel in operation.
///
/// Invariant: `levels` is empty unless the profile has a response time, else it has one level
/// for each byte of the picture, at most 255 · 2^16.
#[derive(Clone, Debug)]
pub struct Panel {
    width: usize,
    height: usize,
    profile: Profile,
    /// What the glass shows, 16 fractional bits.
    levels: Vec<u32>,
}

impl Panel {
    /// A dark panel of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`PanelError::Bits`] and [`PanelError::Response`] for a profile out of range.
    pub fn new(width: u16, height: u16, profile: Profile) -> Result<Panel, PanelError> {
        if let Some(bits) = profile
            .dither
            .iter()
            .flatten()
            .find(|b| !(1..=8).contains(*b))
        {
            return Err(PanelError::Bits(*bits));
        }
        if profile.response == Some(0) {
            return Err(PanelError::Response);
        }
        let (width, height) = (usize::from(width), usize::from(height));
        let cells = if profile.response.is_some() {
            width * height * 3
        } else {
            0
        };
        Ok(Panel {
            width,
            height,
            profile,
            levels: vec![0; cells],
        })
    }

    /// Bytes of state: none without a response time.
    #[must_use]
    pub fn ram_bytes(&self) -> usize {
        self.levels.len() * size_of::<u32>()
    }

    /// Turns the picture `rgb` (3 bytes a pixel, rows from the top) into what is seen when it has
    /// been driven for `micros` microseconds after the picture before it.
    ///
    /// # Errors
    /// [`PanelError::Size`] for a picture of another size, which is left as it is.
    pub fn show(&mut self, rgb: &mut [u8], micros: u32) -> Result<(), PanelError> {
        let expected = self.width * self.height * 3;
        if rgb.len() != expected {
            return Err(PanelError::Size {
                got: rgb.len(),
                expected,
            });
        }
        if let Some(bits) = self.profile.dither {
            self.dither(rgb, bits);
        }
        if let Some(constant) = self.profile.response {
            let keep = exp_neg_q32(micros, constant);
            for (level, value) in self.levels.iter_mut().zip(rgb) {
                *level = lag(*level, *value, keep);
                // Never above 255: a level stays between the values it was driven to.
                *value = ((*level + (1 << 15)) >> 16) as u8;
            }
        }
        Ok(())
    }

    fn dither(&self, rgb: &mut [u8], bits: [u8; 3]) {
        let steps = bits.map(|b| (1 << b) - 1);
        // A panel without columns has no rows to walk either.
        for (y, row) in rgb.chunks_exact_mut((self.width * 3).max(1)).enumerate() {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let threshold = BAYER[y % 8][x % 8];
                for (value, steps) in pixel.iter_mut().zip(steps) {
                    *value = expand(quantise(*value, steps, threshold), steps);
                }
            }
        }
    }
}

/// The step of 0..=`steps` for `value`: ⌊value·steps/255 + (threshold + ½)/64⌋. Over the 64
/// thresholds they add up to ⌊64·value·steps/255 + ½⌋ (Hermite's identity): the mean is kept.
fn quantise(value: u8, steps: u32, threshold: u8) -> u32 {
    (u32::from(value) * steps * 128 + (2 * u32::from(threshold) + 1) * 255) / (255 * 128)
}

/// The byte of a step, rounded to nearest.
fn expand(step: u32, steps: u32) -> u8 {
    // step ≤ steps, so at most 255.
    ((step * 510 + steps) / (2 * steps)) as u8
}

/// One step of the lag: target + keep·(level − target), the difference truncated towards zero, so
/// that it shrinks at every step with keep < 1 and the level arrives.
fn lag(level: u32, value: u8, keep_q32: u64) -> u32 {
    let target = u32::from(value) << 16;
    let rest = (u64::from(level.abs_diff(target)) * keep_q32) >> 32;
    if level < target {
        target - rest as u32
    } else {
        target + rest as u32
    }
}

/// `e^(−micros/constant)` with 32 fractional bits, within 2^-15 of relative error: the exponent to
/// base 2 has 16 fractional bits, and each of its bits is one factor.
fn exp_neg_q32(micros: u32, constant: u32) -> u64 {
    let exponent = ((u128::from(micros) * LOG2_E_Q32 / u128::from(constant)) + (1 << 15)) >> 16;
    let whole = exponent >> 16;
    if whole >= 32 {
        return 0;
    }
    let mut power: u64 = 1 << 32;
    for (k, factor) in EXP2.iter().enumerate() {
        if (exponent >> (15 - k)) & 1 == 1 {
            power = (power * u64::from(*factor) + (1 << 31)) >> 32;
        }
    }
    power >> whole
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(profile: Profile) -> Panel {
        Panel::new(16, 8, profile).expect("a valid profile")
    }

    #[test]
    fn without_a_profile_nothing_happens_and_nothing_is_stored() {
        let mut panel = panel(Profile::default());
        let picture: Vec<u8> = (0..16 * 8 * 3).map(|i| i as u8).collect();
        let mut shown = picture.clone();
        panel.show(&mut shown, 16_667).expect("the size fits");
        assert_eq!(shown, picture);
        assert_eq!(panel.ram_bytes(), 0);
        assert_eq!(
            self::panel(Profile {
                response: Some(1),
                dither: None
            })
            .ram_bytes(),
            1536
        );
    }

    #[test]
    fn profiles_and_pictures_out_of_range_are_refused() {
        let with = |dither, response| Panel::new(1, 1, Profile { dither, response }).err();
        assert_eq!(with(Some([8, 0, 8]), None), Some(PanelError::Bits(0)));
        assert_eq!(with(Some([8, 8, 9]), None), Some(PanelError::Bits(9)));
        assert_eq!(with(None, Some(0)), Some(PanelError::Response));
        let error = panel(Profile::default()).show(&mut [0; 3], 1);
        assert_eq!(
            error,
            Err(PanelError::Size {
                got: 3,
                expected: 384
            })
        );
        let mut empty = Panel::new(
            0,
            5,
            Profile {
                dither: Some([1; 3]),
                response: Some(9),
            },
        )
        .expect("a panel without pixels is legal");
        assert_eq!(empty.show(&mut [], 1), Ok(()));
    }

    /// The matrix by its recursion M(2n) = [4M, 4M+2; 4M+3, 4M+1].
    #[test]
    fn the_matrix_is_bayers() {
        let mut matrix = vec![vec![0]];
        for _ in 0..3 {
            let n = matrix.len();
            let cell =
                |y: usize, x: usize| 4 * matrix[y % n][x % n] + [[0, 2], [3, 1]][y / n][x / n];
            matrix = (0..2 * n)
                .map(|y| (0..2 * n).map(|x| cell(y, x)).collect())
                .collect();
        }
        for (row, expected) in BAYER.iter().zip(&matrix) {
            assert_eq!(row.as_slice(), expected.as_slice());
        }
    }

    /// Hermite's identity: the steps over one matrix add up to ⌊64·v·s/255 + ½⌋ exactly.
    #[test]
    fn dithering_keeps_the_mean_of_every_value_at_every_depth() {
        for bits in 1..=8u32 {
            let steps = (1 << bits) - 1;
            for value in 0..=255u8 {
                let sum: u32 = BAYER
                    .iter()
                    .flatten()
                    .map(|t| quantise(value, steps, *t))
                    .sum();
                assert_eq!(
                    sum,
                    (128 * u32::from(value) * steps + 255) / 510,
                    "{value} {bits}"
                );
            }
        }
    }

    #[test]
    fn a_dithered_picture_has_the_levels_of_the_panel_and_eight_bits_are_exact() {
        let mut panel = panel(Profile {
            dither: Some([1, 2, 8]),
            response: None,
        });
        let picture: Vec<u8> = (0..16 * 8 * 3).map(|i| (i * 7) as u8).collect();
        let mut shown = picture.clone();
        panel.show(&mut shown, 1).expect("the size fits");
        assert_eq!(panel.ram_bytes(), 0);
        for (new, old) in shown.chunks(3).zip(picture.chunks(3)) {
            assert!([0, 255].contains(&new[0]));
            assert!([0, 85, 170, 255].contains(&new[1]));
            assert_eq!(new[2], old[2]);
        }
    }

    #[test]
    fn the_exponential_is_within_its_bound() {
        for (micros, constant) in [
            (0, 1),
            (1, 1),
            (16_667, 5_000),
            (16_667, 8_000),
            (1, 1_000_000),
            (999, 1000),
            (22, 1),
        ] {
            let exact = (-f64::from(micros) / f64::from(constant)).exp();
            let got = exp_neg_q32(micros, constant) as f64 / 2f64.powi(32);
            // The relative bound, and the truncation of the final shift.
            let bound = exact * 2f64.powi(-15) + 2f64.powi(-31);
            assert!(
                (got - exact).abs() <= bound,
                "{micros}/{constant}: {got} {exact}"
            );
        }
        assert_eq!(exp_neg_q32(u32::MAX, 1), 0);
        assert_eq!(exp_neg_q32(0, u32::MAX), 1 << 32);
    }

    /// A step from black: v·(1 − e^(−n·dt/τ)) after n refreshes, up and down again.
    #[test]
    fn the_response_is_the_closed_form_of_a_first_order_lag() {
        let (constant, micros, high) = (8_000, 4_000, 250u8);
        let mut panel = panel(Profile {
            dither: None,
            response: Some(constant),
        });
        let decay = |n: i32| (-f64::from(n) * f64::from(micros) / f64::from(constant)).exp();
        for n in 1..=20 {
            let mut picture = vec![high; 384];
            panel.show(&mut picture, micros).expect("the size fits");
            let exact = f64::from(high) * (1.0 - decay(n));
            assert!(
                (f64::from(picture[0]) - exact).abs() <= 0.51,
                "{n}: {} {exact}",
                picture[0]
            );
            assert!(picture.iter().all(|v| *v == picture[0]));
        }
        let top = f64::from(high) * (1.0 - decay(20));
        for n in 1..=60 {
            let mut picture = vec![0; 384];
            panel.show(&mut picture, micros).expect("the size fits");
            assert!(
                (f64::from(picture[0]) - top * decay(n)).abs() <= 0.51,
                "{n}"
            );
        }
        assert!(
            panel.levels.iter().all(|level| *level == 0),
            "the level arrives"
        );
    }

    #[test]
    fn time_may_be_cut_into_pieces() {
        let profile = Profile {
            dither: None,
            response: Some(10_000),
        };
        let (mut one, mut many) = (panel(profile), panel(profile));
        let mut last = vec![200; 384];
        one.show(&mut last, 10_000).expect("the size fits");
        let mut piece = vec![];
        for _ in 0..10 {
            piece = vec![200; 384];
            many.show(&mut piece, 1_000).expect("the size fits");
        }
        assert_eq!(last, piece);
        assert_eq!(last[0], 126); // 200·(1 − 1/e) = 126.4
    }
}
