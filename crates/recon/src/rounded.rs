//! The algorithm in narrower numbers: what would a display with fewer bits show?
//!
//! [`Rounded`] computes in `f64` and rounds where a fixed-point format would store: places, depths,
//! weights, light, filter widths, ages. So it tells what a format costs in error before anybody
//! writes it; it says nothing of time. With the bits of [`crate::Fixed`] (the defaults of
//! [`Bits`]) it errs like it: a test holds it to that.

use core::fmt::Debug;
use core::marker::PhantomData;

use crate::arith::{Arith, Moments, Panel, REACH, Sums, Texel};
use crate::config::TimeKernel;
use crate::float::FloatTransform;
use crate::lanes::LANES;
use crate::taps::{self, Taps};
use crate::tiles::TileMap;
use unframed_wire::{Pose, View};

/// A number format. All bits are fractional; a format rounds to the nearest, places down to the
/// step that they lie in.
pub trait Bits: Copy + Default + PartialEq + Debug + 'static {
    /// Of a place on the screen, pixels.
    const PLACE: u32 = 7;
    /// Of log2 of a depth.
    const DEPTH: u32 = 11;
    /// Of weights: declines, taps, their products.
    const WEIGHT: u32 = 15;
    /// Of light, 1 being white.
    const LIGHT: u32 = 16;
    /// Of log2 of a filter width.
    const WIDTH: u32 = 11;
    /// Of log2 of ages and lifetimes.
    const AGE: u32 = 11;
    /// Where taps are cut off, in σ.
    const CUT: f64 = 3.0;
}

/// The bits of [`crate::Fixed`] on panels of up to 496 pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deployed;

impl Bits for Deployed {}

/// Numbers of a format, emulated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounded<B: Bits>(PhantomData<B>);

/// One with so many fractional bits.
const fn one(bits: u32) -> f64 {
    (1u64 << bits) as f64
}

/// To the nearest multiple of 2^−bits.
fn round(v: f64, bits: u32) -> f64 {
    libm::round(v * one(bits)) / one(bits)
}

/// To the middle of the step of 2^−bits that it lies in.
fn middle(v: f64, bits: u32) -> f64 {
    (libm::floor(v * one(bits)) + 0.5) / one(bits)
}

/// Light of 16 bits with fewer.
fn light<B: Bits>(v: f64) -> f64 {
    round(v / 65535.0, B::LIGHT) * 65535.0
}

fn exact<B: Bits>(texel: Texel<Rounded<B>>) -> Texel<f64> {
    Texel {
        light: texel.light,
        confidence: texel.confidence,
    }
}

fn rounded<B: Bits>(texel: Texel<f64>) -> Texel<Rounded<B>> {
    Texel {
        light: texel.light.map(light::<B>),
        confidence: texel.confidence,
    }
}

impl<B: Bits> Arith for Rounded<B> {
    type Coord = f64;
    type Depth = f64;
    type Weight = f64;
    type Mass = f64;
    type Log = f64;
    type Sum = f64;
    type Features = <f64 as Arith>::Features;
    type Factor = f64;
    type Row = f64;
    type Along = [f64; LANES];
    type Light = f64;
    type Confidence = f64;
    type Transform = FloatTransform<f64>;
    type Sight = <f64 as Arith>::Sight;

    const FAR: f64 = f64::INFINITY;

    fn compose(view: &View, pose: &Pose) -> Self::Transform {
        f64::compose(view, pose)
    }

    fn sight(transform: &Self::Transform, panel: &Panel, place: [i16; 3]) -> (Self::Sight, bool) {
        f64::sight(transform, panel, place)
    }

    fn seen(panel: &Panel, sight: &Self::Sight) -> (f64, f64, f64) {
        let (x, y, depth) = f64::seen(panel, sight);
        let [x, y] = [x, y].map(|v| middle(v, B::PLACE));
        (x, y, libm::floor(depth * one(B::DEPTH)) / one(B::DEPTH))
    }

    fn from_sixteenths(panel: &Panel, v: u16) -> f64 {
        middle(f64::from_sixteenths(panel, v), B::PLACE)
    }

    fn to_sixteenths(panel: &Panel, v: f64) -> i32 {
        f64::to_sixteenths(panel, v)
    }

    fn pixel(panel: &Panel, v: f64) -> i32 {
        f64::pixel(panel, v)
    }

    fn centre(panel: &Panel, pixel: i32) -> f64 {
        f64::centre(panel, pixel)
    }

    fn behind(depth: f64, cell: u32) -> f64 {
        round(f64::behind(depth, cell), B::DEPTH)
    }

    fn nearer(depth: f64) -> f64 {
        round(f64::nearer(depth), B::DEPTH)
    }

    fn depth_of_log(q11: i32) -> f64 {
        round(f64::depth_of_log(q11), B::DEPTH)
    }

    fn lifetime(map: &TileMap<'_>, panel: &Panel, x: f64, y: f64) -> f64 {
        round(f64::lifetime(map, panel, x, y), B::AGE)
    }

    fn log(q8: i16) -> f64 {
        round(<f64 as Arith>::log(q8), B::AGE)
    }

    fn extents(map: &TileMap<'_>, panel: &Panel, x: f64, y: f64) -> (f64, f64, f64) {
        let (et, wx, wy) = f64::extents(map, panel, x, y);
        (round(et, B::AGE), round(wx, B::WIDTH), round(wy, B::WIDTH))
    }

    fn log_of_age(age: u32) -> f64 {
        round(f64::log_of_age(age), B::AGE)
    }

    fn decline(kernel: TimeKernel, cutoff: u16, age: f64, lifetime: f64) -> f64 {
        round(f64::decline(kernel, cutoff, age, lifetime), B::WEIGHT)
    }

    fn counts(weight: f64) -> bool {
        weight > 0.0
    }

    fn gather(mass: &mut f64, weight: f64) {
        f64::gather(mass, weight);
    }

    fn add_mass(a: f64, b: f64) -> f64 {
        f64::add_mass(a, b)
    }

    fn width_of(mass: f64) -> f64 {
        // Steps begin at the least width, as those of the table do.
        let least = f64::from(taps::LEAST) / 2048.0;
        least + round(f64::width_of(mass) - least, B::WIDTH)
    }

    fn width(q8: i32) -> f64 {
        round(f64::width(q8), B::WIDTH)
    }

    fn taps(panel: &Panel, width: f64, v: f64) -> Taps<f64> {
        let mut taps = if B::CUT == 3.0 {
            f64::taps(panel, width, v)
        } else {
            cut(width, v, B::CUT)
        };
        (taps.first, taps.last) = (REACH, -REACH);
        for (weight, pixel) in taps.weights[..taps::SPAN].iter_mut().zip(-REACH..) {
            *weight = round(*weight, B::WEIGHT);
            if *weight > 0.0 {
                taps.first = taps.first.min(pixel);
                taps.last = pixel;
            }
        }
        taps
    }

    fn times(a: f64, b: f64) -> f64 {
        round(a * b, B::WEIGHT)
    }

    fn light(v: u16) -> f64 {
        light::<B>(f64::from(v))
    }

    fn features(
        panel: &Panel,
        light: [f64; 3],
        at: (f64, f64),
        anchor: (i32, i32),
    ) -> Self::Features {
        f64::features(panel, light, at, anchor)
    }

    fn factor(weight: f64) -> f64 {
        weight
    }

    fn rows(weight: f64, down: &[f64; LANES]) -> [f64; LANES] {
        down.map(|tap| Self::times(weight, tap))
    }

    fn along(taps: &[f64; LANES]) -> [f64; LANES] {
        *taps
    }

    fn factors(row: f64, along: &[f64; LANES]) -> [f64; LANES] {
        along.map(|tap| Self::times(row, tap))
    }

    fn add(sums: &mut Sums<Self>, weight: f64, features: &Self::Features) {
        f64::add(sums, weight, features);
    }

    fn add_moments(moments: &mut Moments<Self>, weight: f64, features: &Self::Features) {
        f64::add_moments(moments, weight, features);
    }

    fn centred(sums: &Sums<Self>, moments: &Moments<Self>, pixel: (i32, i32)) -> Moments<Self> {
        f64::centred(sums, moments, pixel)
    }

    fn mean(sums: &Sums<Self>) -> Texel<Self> {
        rounded(f64::mean(sums))
    }

    fn plane(sums: &Sums<Self>, moments: &Moments<Self>) -> Texel<Self> {
        rounded(f64::plane(sums, moments))
    }

    fn pull(children: [Texel<Self>; 4]) -> Texel<Self> {
        rounded(f64::pull(children.map(exact)))
    }

    fn lacks(confidence: f64) -> bool {
        f64::lacks(confidence)
    }

    fn push(fine: Texel<Self>, coarse: [Texel<Self>; 4]) -> Texel<Self> {
        rounded(f64::push(exact(fine), coarse.map(exact)))
    }

    fn to_u16(light: f64) -> u16 {
        f64::to_u16(light)
    }
}

/// Taps cut off at `cut` σ, less what they are there.
fn cut(width: f64, v: f64, cut: f64) -> Taps<f64> {
    let from_middle = v - libm::floor(v) - 0.5;
    let sigma = libm::exp2(width);
    let foot = libm::exp(-0.5 * cut * cut);
    let mut weights = [0.0; taps::PADDED];
    for (weight, pixel) in weights[..taps::SPAN].iter_mut().zip(-REACH..) {
        let d = (from_middle - f64::from(pixel)).abs();
        if d < cut * sigma && d < f64::from(REACH) {
            *weight = libm::exp(-0.5 * (d / sigma) * (d / sigma)) - foot;
        }
    }
    Taps {
        weights,
        first: -REACH,
        last: REACH,
    }
}
