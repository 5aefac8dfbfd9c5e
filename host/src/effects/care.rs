//! How much care a frameless sample takes over each effect, with which points, and what it tells
//! about the need of more.
//!
//! Adaptive interleaved sampling (Dubla et al. 2009) gives the pixels of a pattern disjoint
//! low-discrepancy sets. A frameless sampler has no pattern of pixels, but it has an order: samples
//! of a tile that follow each other have seeds that do, and take the points of one sequence. So
//! any run of samples of a tile is a well spread set, and a place that is looked at again with the
//! seed of before sees the same points: what differs then is change, not noise.

/// Rays from surfaces towards each area light, in [`Care::rays`].
pub const SOFT: usize = 0;
/// Rays from surfaces towards virtual point lights.
pub const INDIRECT: usize = 1;
/// Places in the medium along a ray, for each lamp.
pub const MEDIUM: usize = 2;
/// Most rays of an effect where a path meets a surface or the medium.
pub const MOST: usize = 16;

/// The care of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Care {
    /// Rays by effect ([`SOFT`], [`INDIRECT`], [`MEDIUM`]); what is not in 1..=[`MOST`] counts
    /// as the nearest of it. An effect that is not called for takes none.
    pub rays: [u8; 3],
    /// Seeds that follow each other take the points of one sequence; else points are random.
    pub pattern: bool,
    /// Whether the sample tells what it would be without the shadows that a display draws itself,
    /// and the shares of the lamps ([`crate::trace::Hit::shares`]).
    pub open: bool,
}

impl Default for Care {
    fn default() -> Self {
        Self {
            rays: [1; 3],
            pattern: false,
            open: false,
        }
    }
}

impl Care {
    /// Rays of an effect.
    pub(crate) fn of(&self, effect: usize) -> usize {
        usize::from(self.rays[effect]).clamp(1, MOST)
    }
}

/// What the rays of each effect brought: number, sum and sum of squares of the luminance that a
/// ray alone would have shown (linear light, 1 is white).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told(pub [[f32; 3]; 3]);

impl Told {
    /// Takes in what rays of an effect brought.
    pub(crate) fn add(&mut self, effect: usize, brought: &[f32]) {
        let [count, sum, squares] = &mut self.0[effect];
        for light in brought {
            *count += 1.0;
            *sum += light;
            *squares += light * light;
        }
    }
}

/// Where the points of a sample come from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points {
    seed: u32,
    pattern: bool,
}

/// The golden ratio.
const GOLDEN: u32 = 0x9e37_79b9;

/// What points are for: each effect has its own sequence.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// A place on this lamp, seen from a surface.
    Lamp(usize),
    /// The choice of a virtual point light.
    Light,
    /// A place in the medium, for this lamp.
    Place(usize),
    /// A place on this lamp, seen from there.
    Glow(usize),
}

impl Points {
    pub(crate) fn new(seed: u32, pattern: bool) -> Self {
        Self { seed, pattern }
    }

    /// Point `i` of a sample's points for a purpose, in the unit square.
    pub(crate) fn next(&mut self, purpose: Purpose, i: usize) -> [f32; 2] {
        if !self.pattern {
            self.seed = self.seed.wrapping_add(GOLDEN);
            return crate::trace::moment::unit_square(self.seed);
        }
        let salt = match purpose {
            Purpose::Lamp(lamp) => 4 * lamp as u32,
            Purpose::Light => 1,
            Purpose::Place(lamp) => 4 * lamp as u32 + 2,
            Purpose::Glow(lamp) => 4 * lamp as u32 + 3,
        };
        spread(self.seed.wrapping_add(i as u32), salt)
    }
}

/// Point `index` of the sequence that `salt` chooses, in the unit square. 4096 in a row that begin at a
/// multiple of it are well spread.
pub(crate) fn spread(index: u32, salt: u32) -> [f32; 2] {
    sobol(index, salt).map(|bits| (bits >> 8) as f32 / 16_777_216.0)
}

/// Bits of a seed that count along a sequence; the others say which.
const ALONG: u32 = 12;

/// The first seed of a sequence of its own, by number: 4096 points, of which a sample takes
/// one for each ray of an effect.
pub(crate) fn set(number: u32) -> u32 {
    mixed(number) << ALONG
}

/// Bits of the seeds of [`few`] sequences.
pub(crate) const FEW: u32 = ALONG + 8;

/// Seed `along` a sequence by number, of 256 different ones, in [`FEW`] bits; goes round after 4096.
pub(crate) fn few(number: u32, along: u16) -> u32 {
    (set(number) & ((1 << FEW) - 1)) | (u32::from(along) & ((1 << ALONG) - 1))
}

/// A point of Sobol's first two dimensions, a (0,2)-sequence, as fractions of 2^32. The low bits
/// of `seed` are the index, the others and `salt` choose a shuffle of indices and of digits that
/// keeps the strata (Owen 1995; by hashing: Burley 2020, "Practical hash-based Owen scrambling").
fn sobol(seed: u32, salt: u32) -> [u32; 2] {
    let chance = mixed((seed >> ALONG) ^ salt.wrapping_mul(GOLDEN));
    let digits = |v: u32, chance: u32| shuffled(v.reverse_bits(), chance).reverse_bits();
    let index = digits(seed & ((1 << ALONG) - 1), chance);
    let x = index.reverse_bits();
    // The second dimension: Pascal's triangle modulo 2.
    let mut y = 0;
    let (mut column, mut rest) = (1u32 << 31, index);
    while rest != 0 {
        if rest & 1 == 1 {
            y ^= column;
        }
        column ^= column >> 1; // v_{k+1} = v_k ^ (v_k >> 1)
        rest >>= 1;
    }
    [digits(x, mixed(chance ^ 1)), digits(y, mixed(chance ^ 2))]
}

/// Flips each bit by a hash of the bits below it (Laine and Karras 2011, constants of Burley).
fn shuffled(mut x: u32, chance: u32) -> u32 {
    x = x.wrapping_add(chance);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^ x.wrapping_mul(0x8d22_f6e6)
}

/// A hash of 32 bits ("lowbias32", found by C. Wellons' search, 2018).
fn mixed(mut x: u32) -> u32 {
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variance of the counts in an 8×8 grid of 640 points; 10 for random ones.
    fn unevenness(mut points: Points) -> f32 {
        let mut boxes = [0.0f32; 64];
        for i in 0..640 {
            let [x, y] = points.next(Purpose::Lamp(2), i);
            boxes[(y * 8.0) as usize * 8 + (x * 8.0) as usize] += 1.0;
        }
        boxes.iter().map(|n| (n - 10.0).powi(2)).sum::<f32>() / 64.0
    }

    #[test]
    fn a_sequence_is_spread_better_than_random_points() {
        assert!(unevenness(Points::new(77, false)) > 5.0);
        for number in 0..8 {
            // From anywhere on, not from a power of two alone.
            let even = unevenness(Points::new(set(number) + 77 * number, true));
            assert!(even < 1.0, "set {number}: {even}");
        }
    }

    #[test]
    fn sixteen_points_from_the_beginning_fill_all_strata() {
        for number in 0..8 {
            let mut points = Points::new(set(number), true);
            for (columns, rows) in [(16, 1), (4, 4), (1, 16)] {
                let mut seen = [false; 16];
                for i in 0..16 {
                    let [x, y] = points.next(Purpose::Place(0), i);
                    let (x, y) = (x * columns as f32, y * rows as f32);
                    seen[y as usize * columns + x as usize] = true;
                }
                assert_eq!(seen, [true; 16], "{columns} by {rows} of set {number}");
            }
        }
    }

    #[test]
    fn a_place_in_a_tile_is_not_tied_to_a_place_on_a_lamp() {
        // Places in a tile follow an additive recurrence. In each quarter of a tile all
        // quarters of a lamp are seen.
        let mut counts = [[0; 4]; 4];
        let quarter = |[x, y]: [f32; 2]| (x * 2.0) as usize * 2 + (y * 2.0) as usize;
        for k in 0..256u32 {
            let place = [3_242_174_889u32, 2_447_445_413]
                .map(|step| k.wrapping_mul(step) as f32 / 4_294_967_296.0);
            let lamp = Points::new(set(5) + k, true).next(Purpose::Lamp(0), 0);
            counts[quarter(place)][quarter(lamp)] += 1;
        }
        for n in counts.as_flattened() {
            assert!((8..=24).contains(n), "{counts:?}");
        }
    }
}
