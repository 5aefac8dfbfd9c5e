//! The deployed arithmetic against `f64`, kernel by kernel, on the same inputs: the bounds of
//! `docs/NUMERICS.md`. (Kernels of `num`, `transform`, `taps` and `tables` are tested beside them.)

use proptest::prelude::*;
use std::sync::Mutex;
use unframed_recon::arith::{Moments, Sums, Texel};
use unframed_recon::config::TimeKernel;
use unframed_recon::tiles::{Cell, TileMap, cells_along};
use unframed_recon::transform::Transform;
use unframed_recon::{Arith, Fixed, Panel};
use unframed_wire::{LogCode, Pose, Rect, Tick, Tile, View};

/// The worst of all cases of a test so far, told whenever it grows.
struct Worst(Mutex<f64>);

impl Worst {
    const fn new() -> Self {
        Self(Mutex::new(0.0))
    }

    fn see(&self, name: &str, error: f64) {
        let mut worst = self.0.lock().expect("no case panicked");
        if error > *worst {
            *worst = error;
            println!("{name}: {error}");
        }
    }
}

fn panel() -> Panel {
    Panel::new(200, 100).expect("a sound panel")
}

const ONE: f64 = 32768.0;

/// A sample on the screen: place in 1/128 px within 4 px of a pixel's centre, weight, light.
type Share = ([u16; 2], u16, [u16; 3]);

/// The pixel whose sums are made.
const PIXEL: (i32, i32) = (70, 20);

fn shares() -> impl Strategy<Value = Vec<Share>> {
    // 78 is the pixel from the guard band's edge.
    let place = [
        (78u16 - 3) * 128..(78 + 4) * 128,
        (28u16 - 3) * 128..(28 + 4) * 128,
    ];
    prop::collection::vec((place, 1u16..=32768, any::<[u16; 3]>()), 1..12)
}

/// Sums and centred moments of shares.
fn summed<A: Arith>(
    shares: &[Share],
    coordinate: impl Fn(u16) -> A::Coord,
    weight: impl Fn(u16) -> A::Weight,
) -> (Sums<A>, Moments<A>) {
    let (mut sums, mut moments) = (Sums::<A>::default(), Moments::<A>::default());
    let square = (PIXEL.0 >> 6, PIXEL.1 >> 6);
    for (at, share, light) in shares {
        let at = (coordinate(at[0]), coordinate(at[1]));
        let features = A::features(&panel(), light.map(A::light), at, square);
        let factor = A::factor(weight(*share));
        A::add(&mut sums, factor, &features);
        A::add_moments(&mut moments, factor, &features);
    }
    let moments = A::centred(&sums, &moments, (PIXEL.0 & 63, PIXEL.1 & 63));
    (sums, moments)
}

fn in_integers(shares: &[Share]) -> (Sums<Fixed>, Moments<Fixed>) {
    summed::<Fixed>(shares, |v| v, |w| w)
}

/// A step stands for its middle.
fn in_f64(shares: &[Share]) -> (Sums<f64>, Moments<f64>) {
    summed::<f64>(
        shares,
        |v| (f64::from(v) + 0.5) / 128.0,
        |w| f64::from(w) / ONE,
    )
}

/// The largest difference of light (of 65,535) and of confidence (in 2^−15).
fn apart(ours: Texel<Fixed>, theirs: Texel<f64>) -> (f64, f64) {
    let light = (0..3).map(|c| (f64::from(ours.light[c]) - theirs.light[c]).abs());
    let confidence = f64::from(ours.confidence) - theirs.confidence * ONE;
    (light.fold(0.0, f64::max), confidence.abs())
}

fn texel() -> impl Strategy<Value = (Texel<Fixed>, Texel<f64>)> {
    (any::<[u16; 3]>(), 0u16..=32768).prop_map(|(light, confidence)| {
        let exact = Texel {
            light: light.map(f64::from),
            confidence: f64::from(confidence) / ONE,
        };
        (Texel { light, confidence }, exact)
    })
}

/// A map of random tiles a cell each, for both arithmetics.
fn cells(codes: &[[u8; 5]]) -> Vec<Cell> {
    let (columns, rows) = (cells_along(200), cells_along(100));
    let mut cells = vec![Cell::default(); columns * rows];
    let mut map = TileMap::new(&mut cells, 200, 100).expect("enough cells");
    for (i, code) in codes.iter().cycle().take(columns * rows).enumerate() {
        let (x, y) = ((4 * (i % columns)) as u16, (4 * (i / columns)) as u16);
        let [gx, gy, gt, lifetime, density] = code.map(LogCode);
        map.set(&Tile {
            rect: Rect { x, y, w: 4, h: 4 },
            gx,
            gy,
            gt,
            lifetime,
            density,
        });
    }
    cells
}

static PLACE: Worst = Worst::new();
static DEPTH: Worst = Worst::new();
static LIFETIME: Worst = Worst::new();
static EXTENT: Worst = Worst::new();
static TIME: Worst = Worst::new();
static WIDTH: Worst = Worst::new();
static MEAN: Worst = Worst::new();
static PLANE: Worst = Worst::new();
static PULL: Worst = Worst::new();
static PUSH: Worst = Worst::new();

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Half a step and 1/64 of the quotient's, and what the numerators are off by: 1.5·2^15 + 1
    /// units in depth and in pixels times depth.
    #[test]
    fn perspective(
        focal in 1.0f64..2000.0, turn in -3.2f64..3.2, eye in prop::array::uniform3(-100_000i32..100_000),
        scale in -8.0f64..4.0, place in any::<[i16; 3]>(), size in prop::sample::select(vec![1u16, 64, 200, 496, 497, 1920, 4080]),
    ) {
        let panel = Panel::new(size, size).expect("a sound panel");
        let (sin, cos) = turn.sin_cos();
        let q = |v: f64| (v * f64::from(1 << 16)).round() as i32;
        let middle = f64::from(size) / 2.0;
        let view = View {
            time: Tick(0),
            eye,
            rows: [
                [q(focal * cos + middle * sin), 0, q(middle * cos - focal * sin)],
                [q(middle * sin), q(focal), q(middle * cos)],
                [q(sin), 0, q(cos)],
            ],
            frac_bits: 16,
        };
        let one = (scale.exp2() * f64::from(1 << 24)) as i32;
        let matrix = [[one, 0, 0], [0, one, 0], [0, 0, one]];
        let pose = Pose { object: 0, matrix, frac_bits: 24, translation: [0; 3] };
        let transform = Transform::compose(&view, &pose);
        let ours = Fixed::project(&transform, &panel, place);
        let theirs = f64::project(&f64::compose(&view, &pose), &panel, place);
        if let (Some((x, y, depth)), Some((ex, ey, exact))) = (ours, theirs) {
            let blur = (1.5 * ONE + 1.0) * (f64::from(transform.exponent) - exact).exp2();
            prop_assume!(blur < 0.01);
            let steps = f64::from(1 << panel.frac_bits);
            let strays = 1.02 * blur * (1.0 + ex.max(ey)) * steps;
            for (v, exact) in [(x, ex), (y, ey)] {
                let error = (f64::from(v) + 0.5 - exact * steps).abs() - strays;
                PLACE.see("place, steps", error);
                prop_assert!(error <= 0.5 + 1.0 / 64.0, "{v} for {exact}");
            }
            let deeper = -(1.0 - blur).log2() * 2048.0;
            let error = (f64::from(depth) - (exact * 2048.0).clamp(0.0, 65534.0)).abs() - deeper;
            DEPTH.see("depth, 1/2048 octave", error);
            prop_assert!(error <= 1.25);
        }
    }

    /// Bilinear lookups: at the lower end of a coordinate's step, within half of 1/2048 octave.
    #[test]
    fn lifetime(codes in prop::collection::vec(any::<[u8; 5]>(), 7..40), x in 0u16..216 * 128, y in 0u16..116 * 128) {
        let (mut cells, panel) = (cells(&codes), panel());
        let map = TileMap::resume(&mut cells, 200, 100).expect("enough cells");
        let exact = f64::lifetime(&map, &panel, f64::from(x) / 128.0, f64::from(y) / 128.0);
        let error = (f64::from(Fixed::lifetime(&map, &panel, x, y)) - exact * 2048.0).abs();
        LIFETIME.see("lifetime, 1/2048 octave", error);
        prop_assert!(error <= 0.501);
    }

    /// A row at once is pixel by pixel.
    #[test]
    fn lifetimes(codes in prop::collection::vec(any::<[u8; 5]>(), 7..40), width in 1u16..70, height in 1u16..40) {
        let (mut cells, panel) = (cells(&codes), Panel::new(width, height).expect("a panel"));
        let map = TileMap::resume(&mut cells, width, height).expect("enough cells");
        let mut row = vec![0; width.into()];
        for y in 0..height {
            Fixed::lifetimes(&map, &panel, y.into(), &mut row);
            let at = |pixel: u16| Fixed::centre(&panel, pixel.into());
            let single: Vec<_> = (0..width).map(|x| Fixed::lifetime(&map, &panel, at(x), at(y))).collect();
            prop_assert_eq!(&row, &single);
        }
    }

    /// Extents from gradients (Dayal et al. 2005 §5.1) by the cube roots: 8 roundings to 1/256
    /// octave.
    #[test]
    fn extents(codes in prop::collection::vec(any::<[u8; 5]>(), 7..40), x in 0u16..216 * 128, y in 0u16..116 * 128) {
        let (mut cells, panel) = (cells(&codes), panel());
        let map = TileMap::resume(&mut cells, 200, 100).expect("enough cells");
        let (et, wx, wy) = Fixed::extents(&map, &panel, x, y);
        // Each quantity's own lookup, by way of the lifetime's; that ends at a second, so in halves:
        // (c − 128)/8 = (a − 128)/8 + (c − a − 128)/8 + 16.
        let at = (f64::from(x) / 128.0, f64::from(y) / 128.0);
        let half = |of: &dyn Fn([u8; 5]) -> u8| {
            let codes: Vec<_> = codes.iter().map(|c| [0, 0, 0, of(*c), 0]).collect();
            let mut cells = crate::cells(&codes);
            let map = TileMap::resume(&mut cells, 200, 100).expect("enough cells");
            f64::lifetime(&map, &panel, at.0, at.1)
        };
        let log = |of: fn([u8; 5]) -> u8| {
            half(&|c| of(c) / 2) + half(&|c| of(c) - of(c) / 2) + 16.0
        };
        let floor = |v: f64, least: f64| v.max(least.log2());
        let (gx, gy) = (floor(log(|c| c[0]), 0.004), floor(log(|c| c[1]), 0.004));
        let (gt, volume) = (floor(log(|c| c[2]), 0.02), -log(|c| c[4]));
        let exact_t = ((volume + gx + gy - 2.0 * gt) / 3.0).clamp(0.01f64.log2(), 0.0);
        let side = |e: f64| e.clamp(0.35f64.log2(), 3f64.log2());
        let area = volume - exact_t;
        let ey = side(area - side((area + gy - gx) / 2.0));
        let ex = side(area - ey);
        let sigma = |e: f64| ((e + 0.65f64.log2()) * 2048.0).max(-4096.0);
        for (got, exact) in [(et, exact_t * 2048.0), (wx, sigma(ex)), (wy, sigma(ey))] {
            let error = (f64::from(got) - exact).abs();
            EXTENT.see("extents, 1/2048 octave", error);
            prop_assert!(error <= 32.0, "{got} for {exact}");
        }
    }

    /// Weights in time: the table's rounding, that between its entries, and the chord.
    #[test]
    fn decline(log in -10 * 2048i32..6 * 2048, lifetime in -12_000i16..20_000, cutoff in 0u16..=32_768) {
        for kernel in [TimeKernel::Rational, TimeKernel::Gaussian, TimeKernel::Exponential] {
            let age = lifetime + log as i16;
            let exact = f64::decline(kernel, cutoff, f64::from(age) / 2048.0, f64::from(lifetime) / 2048.0);
            let error = (f64::from(Fixed::decline(kernel, cutoff, age, lifetime)) - exact * ONE).abs();
            // Younger than 2^-8 lifetimes all are as if they were that old.
            let young = matches!(kernel, TimeKernel::Exponential) && log < -8 * 2048;
            if !young { TIME.see("weight, 2^-15", error); }
            prop_assert!(error <= if young { 128.0 } else { 1.25 }, "{kernel:?} {log}: {error}");
        }
    }

    /// Filter widths of a mass: half of log2's error and three roundings.
    #[test]
    fn width(mass in 1u32..9 * (64 << 15)) {
        let exact = f64::width_of(f64::from(mass) / ONE) * 2048.0;
        let error = (f64::from(Fixed::width_of(mass)) - exact).abs();
        WIDTH.see("width, 1/2048 octave", error);
        prop_assert!(error <= 2.5);
    }

    /// Moments about a pixel's centre: exact, whatever the anchor.
    #[test]
    fn moments_are_exact(shares in shares()) {
        let (sums, moments) = in_integers(&shares);
        let mut direct = [0i64; 15];
        for (at, weight, light) in &shares {
            // In 1/256 px from the pixel's centre.
            let [x, y] = [0, 1].map(|k| {
                let centre = 2 * 128 * ([PIXEL.0, PIXEL.1][k] + 8) + 128;
                i64::from(2 * i32::from(at[k]) + 1 - centre)
            });
            let [r, g, b] = light.map(i64::from);
            let terms = [1, r, g, b, x, y, x * x, x * y, y * y, x * r, x * g, x * b, y * r, y * g, y * b];
            for (sum, term) in direct.iter_mut().zip(terms) {
                *sum += i64::from(*weight) * term;
            }
        }
        prop_assert_eq!(&sums.0[..], &direct[..4]);
        prop_assert_eq!(&moments.0[..11], &direct[4..]);
    }

    /// Weighted means: a rounding.
    #[test]
    fn mean(shares in shares()) {
        let (light, confidence) = apart(Fixed::mean(&in_integers(&shares).0), f64::mean(&in_f64(&shares).0));
        MEAN.see("mean, light", light);
        prop_assert!(light <= 1.0 && confidence <= 2.0, "{light} {confidence}");
    }

    /// Planes: see `fixed::plane` for the formats of the steps between.
    #[test]
    fn plane(shares in shares()) {
        let (ours, theirs) = (in_integers(&shares), in_f64(&shares));
        let (light, confidence) = apart(Fixed::plane(&ours.0, &ours.1), f64::plane(&theirs.0, &theirs.1));
        PLANE.see("plane, light", light);
        prop_assert!(light <= 48.0 && confidence <= 2.0, "{light} {confidence}");
    }

    /// Four texels as one: a rounding.
    #[test]
    fn pull(children in prop::array::uniform4(texel())) {
        let (light, confidence) = apart(Fixed::pull(children.map(|c| c.0)), f64::pull(children.map(|c| c.1)));
        PULL.see("pull, light", light);
        prop_assert!(light <= 1.0 && confidence <= 1e-6, "{light} {confidence}");
    }

    /// One texel from four: two roundings.
    #[test]
    fn push(fine in texel(), coarse in prop::array::uniform4(texel())) {
        let ours = Fixed::push(fine.0, coarse.map(|c| c.0));
        let (light, confidence) = apart(ours, f64::push(fine.1, coarse.map(|c| c.1)));
        PUSH.see("push, light", light);
        prop_assert!(light <= 1.0 && confidence <= 1e-6, "{light} {confidence}");
    }
}

/// Two samples on a line through the pixel's centre, against the formula of `solve` by hand: the ridge is
/// 0.02 px² and an eighth of the square of the mean offset, so what lies to one side is not extrapolated.
#[test]
fn a_plane_leans_less_on_what_lies_to_one_side() {
    let centre = [78 * 128 + 64, 28 * 128 + 64].map(f64::from);
    let mut leaning = Vec::new();
    for (offset, half) in [
        (0.0f64, 0.5f64),
        (0.25, 0.5),
        (1.0, 0.5),
        (2.5, 0.5),
        (0.5, 0.125),
    ] {
        let x = [offset - half, offset + half].map(|x| (centre[0] + 128.0 * x) as u16);
        let shares = [(x[0], 20_000u16), (x[1], 40_000)]
            .map(|(x, light)| ([x, centre[1] as u16], 1u16 << 15, [light; 3]));
        // A coordinate stands for the middle of its step.
        let (e, rest) = (offset + 0.5 / 128.0, 0.5 / 128.0);
        let ridge = 0.02 + (e * e + rest * rest) / 8.0;
        let slope = 10_000.0 * half / (half * half + ridge);
        let expected = 30_000.0 - slope * e;
        let (sums, moments) = in_f64(&shares);
        let exact = f64::plane(&sums, &moments).light[0];
        assert!(
            (exact - expected.clamp(0.0, 65_535.0)).abs() < 1.0,
            "{offset}: {exact} for {expected}"
        );
        let (sums, moments) = in_integers(&shares);
        let ours = f64::from(Fixed::plane(&sums, &moments).light[0]);
        assert!((ours - exact).abs() < 48.0, "{offset}: {ours} for {exact}");
        leaning.push(slope);
    }
    assert!(leaning[0] > 1.5 * leaning[3], "{leaning:?}");
}
