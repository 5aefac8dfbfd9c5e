//! A glance before a look: in which pixel a lattice point is seen, in 32 bits where those are sure.
//!
//! To name the pixel of a sample takes fewer digits than to place it within the pixel. So the
//! numerators are first formed in 32 bits, one instruction a product on a Cortex-M, with a bound on
//! what that leaves out; only where a border of pixels lies within the bound (on a panel of 64 × 64
//! pixels one sample in 25), or where the eye is so close that digits are lacking, the exact
//! product decides (a filtered predicate, as in Shewchuk 1997, *Adaptive precision floating-point
//! arithmetic and fast robust geometric predicates*). The answer is the exact one in every case, which
//! `tests` holds it to.
//!
//! **The bound.** In units in which no numerator is beyond 2^28, what is left of `M·q` is
//! `⌊M'q/2^16⌋`, where `M` loses less than half a unit for any `|q| ≤ 2^15`; with the product's rounding, three
//! times, and the offset's, a numerator is off by less than 5.5 units. The distance `w` has a unit of its own, 2^k
//! times finer than that of x and y. One pixel is added to these, to keep what matters positive, which
//! leaves them off by less than 12; so a coordinate below 2^e is off by less than
//! `(12·2^k + 5.5·2^e)/w`, and `w ≥ 2^(12 + max(k, e))` is asked for: 0.0043 px. The reciprocal is off by a part
//! of 2^−15 of the coordinate, `2^(e − 15)` px; 12 fractional bits are off by 2^−12 px, and the exact path by less
//! than 2^−15 px.

use crate::arith::Panel;
use crate::num::{exponent, mul_hi, shift};

/// Fractional bits of a coordinate.
const FRAC_BITS: u32 = 12;
/// What is off in a numerator, rounded up.
const OFF: i32 = 6;
/// What of the bound does not grow with the panel: 0.0043, 2^−12 and 2^−15 px, rounded up.
const MARGIN: u32 = 19;

/// A [`Transform`](crate::transform::Transform) with fewer digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Glance {
    /// Of x, y and the distance: numerators a lattice step, times 2^16, and that of the origin.
    rows: [[i32; 4]; 3],
    /// log2 of the unit of x and y in those of the distance.
    finer: u32,
    /// The distance from which on x and y are sure.
    least: i32,
}

/// How sure a glance is on a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sure {
    /// The distance from which on it is.
    least: i32,
    /// log2 of coordinates that no panel reaches.
    beyond: u32,
    /// How far from a border of pixels it is, pixels with 12 fractional bits.
    margin: u32,
}

impl Sure {
    /// On a panel and its guard of less than 2^`extent` pixels.
    #[must_use]
    pub const fn of(extent: u32) -> Self {
        Self {
            least: 1 << (12 + extent),
            beyond: extent + 1,
            margin: MARGIN + (1 << extent >> (15 - FRAC_BITS)),
        }
    }
}

/// What a glance tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// In this column and row of the panel.
    At(u32, u32),
    /// Not on the panel.
    Outside,
    /// Look closely.
    Unsure,
}

impl Glance {
    /// Of a transform.
    #[must_use]
    pub fn new(matrix: &[[i32; 3]; 3], offset: &[i64; 3]) -> Self {
        // The unit in which no numerator of a row, all below 2^50, is beyond 2^28.
        let unit = |row: &[i32; 3], offset: i64| {
            let steps: u64 = row.iter().map(|m| u64::from(m.unsigned_abs())).sum();
            let most = offset.unsigned_abs() + (steps << 15);
            (exponent(most | 1) - 27).max(0)
        };
        let narrow = |row: [i32; 3], offset: i64, unit: i32| {
            let [a, b, c] = row.map(|m| shift(m.into(), 16 - unit) as i32);
            [a, b, c, shift(offset, -unit) as i32]
        };
        let ([x, y, w], [ox, oy, ow]) = (*matrix, *offset);
        let fine = unit(&w, ow);
        let coarse = unit(&x, ox).max(unit(&y, oy)).max(fine);
        let finer = (coarse - fine) as u32;
        Self {
            rows: [
                narrow(x, ox, coarse),
                narrow(y, oy, coarse),
                narrow(w, ow, fine),
            ],
            finer,
            // From 2^28 on nothing is.
            least: 1 << (finer.min(18) + 12),
        }
    }

    /// A numerator, in its unit, of a place times 2^16.
    #[inline(always)]
    fn numerator([a, b, c, origin]: &[i32; 4], place: [i32; 3]) -> i32 {
        let times = |m: &i32, q: i32| ((i64::from(*m) * i64::from(q)) >> 32) as i32;
        origin + times(a, place[0]) + times(b, place[1]) + times(c, place[2])
    }

    /// Where a lattice point is seen.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, panel: &Panel, place: [i16; 3]) -> Seen {
        let place = place.map(|q| i32::from(q) << 16);
        let [x, y, w] = &self.rows;
        let w = Self::numerator(w, place);
        let sure = &panel.sure;
        if w < self.least || w < sure.least {
            return if w < -OFF {
                Seen::Outside
            } else {
                Seen::Unsure
            };
        }
        let pixel = w >> (self.finer & 31);
        let x = Self::numerator(x, place) + pixel;
        let y = Self::numerator(y, place) + pixel;
        // A pixel and more before the first, or beyond any: no glance is off by that much.
        let either = x | y;
        if either < 0 || either >> (sure.beyond & 31) >= pixel {
            return Seen::Outside;
        }
        // 2^(48 − zeros)/w, where 4 ≤ zeros and zeros + finer ≤ 19.
        let zeros = (w as u32).leading_zeros();
        let inverse = u32::MAX / ((w as u32) << (zeros & 31) >> 16 | 1 << 15);
        let up = zeros + self.finer - (16 - FRAC_BITS);
        let scale = inverse << (up & 31);
        let (x, y) = (mul_hi(x as u32, scale), mul_hi(y as u32, scale));
        let within = (1 << FRAC_BITS) - 1;
        let close = |v: u32| (v + sure.margin) & within < 2 * sure.margin;
        if close(x) || close(y) {
            return Seen::Unsure;
        }
        let pixel = |v: u32| (v >> FRAC_BITS).wrapping_sub(1);
        let (column, row) = (pixel(x), pixel(y));
        if column < u32::from(panel.width) && row < u32::from(panel.height) {
            Seen::At(column, row)
        } else {
            Seen::Outside
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arith::Arith;
    use crate::fixed::Fixed;
    use crate::transform::{MATRIX_LIMIT, PLACE_LIMIT, Transform};
    use proptest::prelude::*;
    use unframed_wire::{Pose, Tick, View};

    /// The answer that a glance must not contradict.
    fn exact(transform: &Transform, panel: &Panel, place: [i16; 3]) -> Option<usize> {
        let (x, y, _) = Fixed::project(transform, panel, place)?;
        Fixed::within(panel, x, y)
    }

    /// Whether a glance is sure; that it says the same as the exact product if it is.
    fn agrees(transform: &Transform, panel: &Panel, place: [i16; 3]) -> bool {
        let exact = exact(transform, panel, place);
        assert_eq!(Fixed::falls(transform, panel, place), exact, "{place:?}");
        match transform.glance.at(panel, place) {
            Seen::At(column, row) => {
                let own = panel.inside(column as i32, row as i32);
                assert_eq!(own, exact, "{place:?}");
                assert!(own.is_some());
            }
            Seen::Outside => assert_eq!(exact, None, "{place:?}"),
            Seen::Unsure => return false,
        }
        true
    }

    fn panel() -> impl Strategy<Value = Panel> {
        let side = || prop_oneof![1u16..=112, 1u16..=Panel::LIMIT];
        (side(), side()).prop_map(|(w, h)| Panel::new(w, h).expect("of a panel's size"))
    }

    prop_compose! {
        fn entries(limit: i32)(e in prop::array::uniform9(-limit..=limit), by in 0u32..24) -> [[i32; 3]; 3] {
            [[e[0] >> by, e[1] >> by, e[2] >> by], [e[3] >> by, e[4] >> by, e[5] >> by], [e[6] >> by, e[7] >> by, e[8] >> by]]
        }
    }

    /// A transform that looks along z at what lies `depth` units away, with 2^`bits` lattice steps a
    /// unit; a unit is a pixel at a distance of `focal`.
    fn looking(focal: i32, depth: i32, centre: [i32; 2], bits: u8) -> Transform {
        let one = 1 << 14;
        let view = View {
            time: Tick(0),
            eye: [0; 3],
            rows: [
                [focal << 14, 0, centre[0] << 14],
                [0, focal << 14, centre[1] << 14],
                [0, 0, one],
            ],
            frac_bits: 14,
        };
        let pose = Pose {
            object: 0,
            matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
            frac_bits: 14 + bits,
            translation: [0, 0, depth],
        };
        Transform::compose(&view, &pose)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn no_transform_is_seen_amiss(
            rows in entries(MATRIX_LIMIT), matrix in entries(MATRIX_LIMIT),
            eye in prop::array::uniform3(-PLACE_LIMIT..=PLACE_LIMIT),
            translation in prop::array::uniform3(-PLACE_LIMIT..=PLACE_LIMIT),
            near in 0u32..29, view_bits in 0u8..=30, pose_bits in 0u8..=31,
            places in prop::collection::vec(prop::array::uniform3(any::<i16>()), 20),
            panel in panel(),
        ) {
            let view = View { time: Tick(0), eye: eye.map(|v| v >> near), rows, frac_bits: view_bits };
            let pose = Pose { object: 0, matrix, frac_bits: pose_bits, translation: translation.map(|v| v >> near) };
            let transform = Transform::compose(&view, &pose);
            for place in places {
                agrees(&transform, &panel, place);
            }
        }

        /// Places on, and one lattice step to both sides of, borders of pixels.
        #[test]
        fn borders_are_looked_at_closely(
            side in 1u16..=512, focal in 1i32..4000, depth in 1i32..1 << 16, bits in 0u8..=14,
            pixels in prop::collection::vec((-2i32..520, -2i32..520, -1i32..=1, -1i32..=1), 40),
        ) {
            let panel = Panel::new(side, side).expect("of a panel's size");
            let half = i32::from(side) / 2;
            let transform = looking(focal, depth, [half; 2], bits);
            for (x, y, right, below) in pixels {
                let on = |pixel: i32, by: i32| {
                    let step = i64::from(pixel - half) * (i64::from(depth) << bits) / i64::from(focal);
                    i16::try_from(step + i64::from(by)).ok()
                };
                if let (Some(x), Some(y)) = (on(x, right), on(y, below)) {
                    agrees(&transform, &panel, [x, y, 0]);
                }
            }
        }
    }

    /// What it is for: of places all over a panel and beyond fewer than one in 20 is looked at twice.
    #[test]
    fn most_glances_are_sure() {
        let panel = Panel::new(64, 64).expect("of a panel's size");
        let transform = looking(64, 64, [32; 2], 9);
        let mut unsure = 0;
        for y in -150i16..150 {
            for x in -150i16..150 {
                unsure += usize::from(!agrees(&transform, &panel, [x * 127, y * 127, 0]));
            }
        }
        assert!(unsure > 0 && unsure < 90_000 / 20, "{unsure}");
    }
}
