//! The arithmetic that the reconstructor is generic over.
//!
//! [`Fixed`](crate::fixed::Fixed) is what is deployed: integers alone, equal bits everywhere.
//! `f32` and `f64` (feature `float`) run the same algorithm; `f64` is the oracle. What is discrete
//! by design (tile codes, 8-bit colour) is discrete in all.

use crate::config::TimeKernel;
use crate::glance::Sure;
use crate::lanes::{LANES, Pixel};
use crate::motion::Past;
use crate::taps::Taps;
use crate::tiles::TileMap;
use unframed_wire::{Pose, View};

/// Pixels around the panel in which a sample still reaches the picture.
pub const GUARD: i32 = 8;
/// How far from its centre a footprint can reach, pixels.
pub const REACH: i32 = 4;

/// The panel's size and what follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Panel {
    /// Pixels a row, 1..=[`Panel::LIMIT`].
    pub width: u16,
    /// Rows, 1..=[`Panel::LIMIT`].
    pub height: u16,
    /// log2 of the first power of two not below width or height plus both guards.
    pub extent_bits: u8,
    /// Fractional bits of a fixed-point coordinate: 16 − `extent_bits`, at most 7.
    pub frac_bits: u8,
    /// How sure a glance is, see [`crate::glance`].
    pub sure: Sure,
}

impl Panel {
    /// The largest width or height.
    pub const LIMIT: u16 = 4080;

    /// A panel of this size, `None` when it is empty or beyond the limit.
    #[must_use]
    pub const fn new(width: u16, height: u16) -> Option<Self> {
        if width == 0 || height == 0 || width > Self::LIMIT || height > Self::LIMIT {
            return None;
        }
        let larger = if width > height { width } else { height } as u32 + 2 * GUARD as u32;
        let extent_bits = larger.next_power_of_two().trailing_zeros() as u8;
        let frac_bits = if extent_bits < 9 { 7 } else { 16 - extent_bits };
        Some(Self {
            width,
            height,
            extent_bits,
            frac_bits,
            sure: Sure::of(extent_bits as u32),
        })
    }

    /// Number of pixels.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Index of a pixel of the panel.
    #[inline]
    #[must_use]
    pub fn inside(&self, x: i32, y: i32) -> Option<usize> {
        let inside = (x as u32) < u32::from(self.width) && (y as u32) < u32::from(self.height);
        inside.then(|| y as usize * usize::from(self.width) + x as usize)
    }

    /// Column and row of the pixel nearest to `(x, y)`, which may lie in the guard band.
    #[inline]
    #[must_use]
    pub fn clamped(&self, x: i32, y: i32) -> [u16; 2] {
        // `clamp` would be a panic path for a panel without pixels.
        let x = x.min(i32::from(self.width) - 1).max(0);
        let y = y.min(i32::from(self.height) - 1).max(0);
        [x as u16, y as u16]
    }

    /// Its index.
    #[inline]
    #[must_use]
    pub fn nearest(&self, x: i32, y: i32) -> usize {
        let [x, y] = self.clamped(x, y);
        usize::from(y) * usize::from(self.width) + usize::from(x)
    }
}

/// A sample moved to the refresh instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Projected<A: Arith> {
    /// x, from the left edge of the guard band.
    pub x: A::Coord,
    /// y, from the top edge of the guard band.
    pub y: A::Coord,
    /// Logarithmic depth.
    pub depth: A::Depth,
    /// What it counts for: its decline with age; zero when it is out of sight.
    pub weight: A::Weight,
    /// Its colour as received.
    pub rgb: [u8; 3],
    /// What may have hidden it since it was taken.
    pub past: Past,
}

/// A colour and how much is known of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel<A: Arith> {
    /// Red, green, blue: light from 0 to [`Arith::light`] of 65535.
    pub light: [A::Light; 3],
    /// 0 nothing … 1 enough.
    pub confidence: A::Confidence,
}

/// An array that begins where processors that add pairs of sums load them best.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(target_arch = "x86_64", repr(align(16)))]
pub struct Aligned<T>(pub T);

/// One pixel's sums for a mean: Σw, Σw·r, Σw·g, Σw·b.
pub type Sums<A> = Aligned<[<A as Arith>::Sum; 4]>;
/// One pixel's further sums for a plane: Σw·x, Σw·y, Σw·x², Σw·xy, Σw·y², then Σw·x·c and Σw·y·c
/// of each colour, then nothing: twelve go in pairs.
pub type Moments<A> = Aligned<[<A as Arith>::Sum; 12]>;

/// log2 of the side, pixels, of the squares that share an anchor: moments are summed from it, so
/// that one set of features serves all pixels of a footprint.
pub const ANCHOR_BITS: u32 = 6;
/// Numbers and the steps whose rounding depends on them.
pub trait Arith: Copy + Default + PartialEq + core::fmt::Debug + 'static {
    /// A screen coordinate, pixels from the guard band's edge.
    type Coord: Copy + Default + Send + Sync + core::fmt::Debug;
    /// log2 of depth: any unit, monotone.
    type Depth: Copy + Default + PartialOrd + Send + Sync + core::fmt::Debug;
    /// A weight in 0..=1.
    type Weight: Copy + Default + PartialOrd + Send + Sync + core::fmt::Debug;
    /// A sum of weights around a pixel.
    type Mass: Copy + Default + Send + Sync + core::fmt::Debug;
    /// log2 of an age or lifetime in seconds, or of a filter width: σ in pixels.
    type Log: Copy + Default + Send + Sync + core::fmt::Debug;
    /// A sum of products, one of the pixel's.
    type Sum: Copy + Default + Send + Sync + core::fmt::Debug;
    /// What a sample adds to a pixel's sums and moments, but for its weight there.
    type Features: Copy + core::fmt::Debug;
    /// A weight as features are multiplied by it.
    type Factor: Copy + core::fmt::Debug;
    /// What a row's tap leaves of a weight.
    type Row: Copy + core::fmt::Debug;
    /// The taps along a row.
    type Along: core::fmt::Debug;
    /// A light value.
    type Light: Copy + Default + PartialEq + Send + Sync + core::fmt::Debug;
    /// A confidence in 0..=1.
    type Confidence: Copy + Default + PartialEq + Send + Sync + core::fmt::Debug;
    /// View and pose composed.
    type Transform: Copy + Default + Send + Sync + core::fmt::Debug;
    /// A direction before it is divided by its distance.
    type Sight: Copy + Default + core::fmt::Debug;

    /// Deeper than anything.
    const FAR: Self::Depth;

    /// Composes a sound view with a sound pose.
    fn compose(view: &View, pose: &Pose) -> Self::Transform;

    /// In which direction a lattice point is seen, and whether that is before the eye and within
    /// the guard.
    fn sight(transform: &Self::Transform, panel: &Panel, place: [i16; 3]) -> (Self::Sight, bool);

    /// Where something in sight is seen: x, y and depth.
    fn seen(panel: &Panel, sight: &Self::Sight) -> (Self::Coord, Self::Coord, Self::Depth);

    /// Where a lattice point is seen: x, y and depth; `None` behind the eye or beyond the guard.
    #[inline(always)]
    fn project(
        transform: &Self::Transform,
        panel: &Panel,
        place: [i16; 3],
    ) -> Option<(Self::Coord, Self::Coord, Self::Depth)> {
        let (sight, inside) = Self::sight(transform, panel, place);
        inside.then(|| Self::seen(panel, &sight))
    }

    /// The pixel of the panel in which a lattice point is seen, the one that [`Arith::project`] and
    /// [`Arith::pixel`] name.
    fn falls(transform: &Self::Transform, panel: &Panel, place: [i16; 3]) -> Option<usize> {
        Self::project(transform, panel, place).and_then(|(x, y, _)| Self::within(panel, x, y))
    }

    /// The pixel of the panel at coordinates.
    #[inline]
    fn within(panel: &Panel, x: Self::Coord, y: Self::Coord) -> Option<usize> {
        panel.inside(Self::pixel(panel, x), Self::pixel(panel, y))
    }

    /// The coordinate of 1/16 pixels from the panel's edge.
    fn from_sixteenths(panel: &Panel, v: u16) -> Self::Coord;

    /// 1/16 pixels from the panel's edge, rounded down.
    fn to_sixteenths(panel: &Panel, v: Self::Coord) -> i32;

    /// The pixel of a coordinate, −[`GUARD`] and up.
    fn pixel(panel: &Panel, v: Self::Coord) -> i32;

    /// The pixel of the panel that is nearest to a place.
    #[inline]
    fn nearest(panel: &Panel, x: Self::Coord, y: Self::Coord) -> Pixel {
        Pixel::new(panel.clamped(Self::pixel(panel, x), Self::pixel(panel, y)))
    }

    /// The coordinate of the middle of a pixel of the panel.
    fn centre(panel: &Panel, pixel: i32) -> Self::Coord;

    /// Depth made farther by the tolerance of the hidden-point test at cells of `cell` pixels
    /// (1, 2 or 4): a factor of 1.05, 1.1 or 2.6.
    fn behind(depth: Self::Depth, cell: u32) -> Self::Depth;

    /// A depth of that test where something that moves passes before what does not: a factor of 1/1.03.
    fn nearer(depth: Self::Depth) -> Self::Depth;

    /// The depth whose log2 in world units is `q11`, 11 fractional bits; clamped to what is told
    /// apart.
    fn depth_of_log(q11: i32) -> Self::Depth;

    /// log2 of the lifetime at a place, seconds, bilinear between tiles, none longer than
    /// [`crate::tiles::LONGEST`].
    fn lifetime(map: &TileMap<'_>, panel: &Panel, x: Self::Coord, y: Self::Coord) -> Self::Log;

    /// The lifetimes in the middles of a row's pixels, from the first on.
    fn lifetimes(map: &TileMap<'_>, panel: &Panel, row: usize, out: &mut [Self::Log]) {
        let y = Self::centre(panel, row as i32);
        for (x, out) in (0..).zip(out) {
            *out = Self::lifetime(map, panel, Self::centre(panel, x), y);
        }
    }

    /// A log quantity given with 8 fractional bits.
    fn log(q8: i16) -> Self::Log;

    /// Gradient-shaped extents (Dayal et al. 2005 §5.1) at a place: log2 of e_t in seconds, and
    /// the widths of σ = 0.65·e in x and y, see [`crate::extents`].
    fn extents(
        map: &TileMap<'_>,
        panel: &Panel,
        x: Self::Coord,
        y: Self::Coord,
    ) -> (Self::Log, Self::Log, Self::Log);

    /// log2 of an age given in microseconds, in seconds; those below 2^−16 s are as if they were
    /// that old.
    fn log_of_age(age: u32) -> Self::Log;

    /// Weight of a sample of an age, less `cutoff` (15 fractional bits), and never below 0.
    fn decline(
        kernel: TimeKernel,
        cutoff: u16,
        age: Self::Log,
        lifetime: Self::Log,
    ) -> Self::Weight;

    /// Whether a weight counts at all.
    fn counts(weight: Self::Weight) -> bool;

    /// Adds a weight to a mass.
    fn gather(mass: &mut Self::Mass, weight: Self::Weight);

    /// Adds masses.
    fn add_mass(a: Self::Mass, b: Self::Mass) -> Self::Mass;

    /// The filter width for a mass in 3 × 3 pixels: σ = 0.5·3/√mass, from
    /// [`crate::taps::LEAST`] to [`crate::taps::MOST`].
    fn width_of(mass: Self::Mass) -> Self::Log;

    /// A filter width given as log2 of σ in pixels with 8 fractional bits.
    fn width(q8: i32) -> Self::Log;

    /// Filter taps of a width along an axis for a sample at coordinate `v`: e^(−d²/2σ²) − e^(−4.5)
    /// at the distances from the pixels' centres, zero beyond 3 σ and beyond [`REACH`].
    fn taps(panel: &Panel, width: Self::Log, v: Self::Coord) -> Taps<Self::Weight>;

    /// Product of weights.
    fn times(a: Self::Weight, b: Self::Weight) -> Self::Weight;

    /// A light of 16 bits.
    fn light(v: u16) -> Self::Light;

    /// What a sample adds to sums: 1, its light, and with (x, y) its place from the anchor of
    /// square `anchor` (column and row in squares of 2^[`ANCHOR_BITS`] pixels): x, y, x², xy, y²,
    /// x·light, y·light.
    fn features(
        panel: &Panel,
        light: [Self::Light; 3],
        at: (Self::Coord, Self::Coord),
        anchor: (i32, i32),
    ) -> Self::Features;

    /// A weight as a factor.
    fn factor(weight: Self::Weight) -> Self::Factor;

    /// The products of a weight and of the taps of rows.
    fn rows(weight: Self::Weight, down: &[Self::Weight; LANES]) -> [Self::Row; LANES];

    /// Taps along a row, as [`Arith::factors`] takes them.
    fn along(taps: &[Self::Weight; LANES]) -> Self::Along;

    /// The products of a row's and of the taps along it.
    fn factors(row: Self::Row, along: &Self::Along) -> [Self::Factor; LANES];

    /// Adds weighted features to sums.
    fn add(sums: &mut Sums<Self>, weight: Self::Factor, features: &Self::Features);

    /// Adds weighted features to moments.
    fn add_moments(moments: &mut Moments<Self>, weight: Self::Factor, features: &Self::Features);

    /// Moments about a pixel's centre from those about its square's anchor; `pixel` as column and
    /// row within the square.
    fn centred(sums: &Sums<Self>, moments: &Moments<Self>, pixel: (i32, i32)) -> Moments<Self>;

    /// The weighted mean; nothing known where nothing was added.
    fn mean(sums: &Sums<Self>) -> Texel<Self>;

    /// The plane at the pixel's centre.
    fn plane(sums: &Sums<Self>, moments: &Moments<Self>) -> Texel<Self>;

    /// Four texels (or fewer, at an odd border: then with confidence zero) as one of the next
    /// coarser level: confidence-weighted mean, confidences added up to 1.
    fn pull(children: [Texel<Self>; 4]) -> Texel<Self>;

    /// Whether there is more to be known.
    fn lacks(confidence: Self::Confidence) -> bool;

    /// A texel, what it lacks in confidence made up from coarser ones (weights 9, 3, 3, 1 of 16).
    fn push(fine: Texel<Self>, coarse: [Texel<Self>; 4]) -> Texel<Self>;

    /// A light as 16 bits, rounded.
    fn to_u16(light: Self::Light) -> u16;
}
