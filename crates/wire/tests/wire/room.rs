//! A ray-cast room with textured walls, spheres and boxes: realistic places and colours for
//! measuring the codec. Analytic, so that it needs no scene files.

use unframed_wire::{ScreenSample, Shares, WorldSample};

/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
#[derive(Clone, Debug)]
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn along(o: V, d: V, t: f64) -> V {
    [0, 1, 2].map(|i| o[i] + t * d[i])
}

fn minus(a: V, b: V) -> V {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn hash(p: [i64; 3], seed: u64) -> f64 {
    let mix = (p[0] as u64).wrapping_mul(0x8DA6_B343_0001)
        ^ (p[1] as u64).wrapping_mul(0xD816_3841_0000_0003)
        ^ (p[2] as u64).wrapping_mul(0x00CB_1AB3_1F00_0005);
    Rng(seed ^ mix).unit()
}

fn noise(p: V, seed: u64) -> f64 {
    let cell = p.map(|c| c.floor());
    let t = [0, 1, 2]
        .map(|i| p[i] - cell[i])
        .map(|t| t * t * (3.0 - 2.0 * t));
    let corner = |c: usize| {
        let o = [c & 1, c >> 1 & 1, c >> 2];
        let w = [0, 1, 2].map(|i| if o[i] == 1 { t[i] } else { 1.0 - t[i] });
        w[0] * w[1] * w[2] * hash([0, 1, 2].map(|i| cell[i] as i64 + o[i] as i64), seed)
    };
    (0..8).map(corner).sum()
}

/// Seven octaves: detail down to a pixel, as photographs of plaster or wood have.
fn texture(p: V, seed: u64) -> f64 {
    let octave =
        |i: i32| 0.5 * 0.55f64.powi(i) * noise(p.map(|c| c * 2f64.powi(i)), seed + i as u64);
    (0..7).map(octave).sum()
}

struct Hit {
    t: f64,
    normal: V,
    material: u64,
    object: u8,
}

fn trace(o: V, d: V) -> Hit {
    let mut best = Hit {
        t: f64::INFINITY,
        normal: [0.0; 3],
        material: 0,
        object: 0,
    };
    let mut offer = |t: f64, normal: V, material: u64, object: u8| {
        if t > 1e-6 && t < best.t {
            best = Hit {
                t,
                normal,
                material,
                object,
            };
        }
    };
    let room = [8.0, 3.0, 6.0];
    for i in 0..3 {
        let wall = if d[i] > 0.0 { room[i] } else { 0.0 };
        let mut normal = [0.0; 3];
        normal[i] = -d[i].signum();
        offer(
            (wall - o[i]) / d[i],
            normal,
            2 * i as u64 + u64::from(d[i] > 0.0),
            0,
        );
    }
    for k in 0..5u8 {
        let f = f64::from(k);
        let centre = [2.0 + f * 0.9, 0.4 + 0.25 * f, 3.0 + (f * 1.7).sin()];
        let (oc, r) = (minus(o, centre), 0.4);
        let b = dot(oc, d);
        let q = b * b - dot(oc, oc) + r * r;
        if q > 0.0 {
            let t = -b - q.sqrt();
            let normal = minus(along(o, d, t), centre).map(|c| c / r);
            // Two spheres move: they are objects of their own.
            offer(t, normal, 10 + u64::from(k), if k < 2 { k + 1 } else { 0 });
        }
    }
    for k in 0..4u8 {
        let f = f64::from(k);
        let (s, c) = (0.5 * f).sin_cos();
        let turn = |v: V| [c * v[0] - s * v[2], v[1], s * v[0] + c * v[2]];
        let centre = [1.0 + 1.8 * f, 0.6, 4.2 - 0.3 * f];
        let (oo, dd, half) = (turn(minus(o, centre)), turn(d), [0.35, 0.6, 0.25]);
        let (mut enter, mut leave, mut axis) = (0.0, f64::INFINITY, 0);
        for i in 0..3 {
            let (a, b) = ((-half[i] - oo[i]) / dd[i], (half[i] - oo[i]) / dd[i]);
            if a.min(b) > enter {
                (enter, axis) = (a.min(b), i);
            }
            leave = leave.min(a.max(b));
        }
        if enter < leave {
            let mut n = [0.0; 3];
            n[axis] = -dd[axis].signum();
            offer(
                enter,
                [c * n[0] + s * n[2], n[1], -s * n[0] + c * n[2]],
                20 + u64::from(k),
                0,
            );
        }
    }
    best
}

fn shade(p: V, hit: &Hit) -> [u8; 3] {
    let m = hit.material;
    let pattern = texture(p.map(|c| 2.0 * c), m);
    let fine = texture(p.map(|c| 7.0 * c + 3.0), m + 50);
    let odd = p
        .iter()
        .map(|c| (2.0 * c + 0.01).floor() as i64)
        .sum::<i64>()
        & 1
        == 1;
    let check = if odd && m.is_multiple_of(3) {
        0.25
    } else {
        1.0
    };
    let to_light = minus([5.0, 2.8, 2.0], p);
    let r2 = dot(to_light, to_light);
    let lambert = (dot(to_light, hit.normal) / r2.sqrt()).max(0.0);
    let light = lambert * 6.0 / (1.0 + r2) + 0.15;
    [0, 1, 2].map(|i| {
        let paint = 0.7 * hash([m as i64, i as i64 + 1, 0], 7) + 0.3;
        let grain = 0.15 * (fine - 0.5) * [1.0, 0.6, 0.2][i];
        let linear = ((paint * (0.2 + 1.1 * pattern) * check + grain) * light).clamp(0.0, 1.0);
        let srgb = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        (srgb * 255.0 + 0.5) as u8
    })
}

/// The sample of pixel coordinates `x`, `y` (0..256) at `time` seconds. `tilt` turns the lattice
/// (radians), so that no wall is aligned with it; the lattice spans the room: 0.12 to 0.17 mm.
pub(crate) fn shoot(x: f64, y: f64, time: f64, tilt: f64) -> (WorldSample, ScreenSample) {
    let (s, c) = (0.3 + 0.2 * time).sin_cos();
    let (dx, dy) = ((x - 128.0) / 128.0 * 0.7, -(y - 128.0) / 128.0 * 0.7);
    let d = [c * dx + s, dy - 0.15, -s * dx + c];
    let length = dot(d, d).sqrt();
    let d = d.map(|v| v / length);
    let o = [3.0 + 0.3 * time, 1.6, 1.0];
    let hit = trace(o, d);
    let p = along(o, d, hit.t);
    let rgb = shade(p, &hit);
    let (s, c) = tilt.sin_cos();
    let [x0, y0, z0] = minus(p, [4.0, 1.5, 3.0]);
    let (x1, y1) = (c * x0 - s * y0, s * x0 + c * y0);
    let (y2, z2) = (c * y1 - s * z0, s * y1 + c * z0);
    let (x3, z3) = (c * x1 - s * z2, s * x1 + c * z2);
    let scale = 32767.0 / if tilt == 0.0 { 4.0 } else { 5.5 };
    let place = [x3, y2, z3].map(|v| (v * scale).round() as i16);
    let world = WorldSample {
        place,
        rgb,
        object: hit.object,
        shares: Shares::default(),
    };
    (
        world,
        ScreenSample {
            x: (x * 16.0) as u16,
            y: (y * 16.0) as u16,
            rgb,
        },
    )
}

/// `n` samples around `time`: scattered, or as crosshairs of five, a pixel apart.
pub(crate) fn samples(
    rng: &mut Rng,
    n: usize,
    time: f64,
    tilt: f64,
    crosshairs: bool,
) -> (Vec<WorldSample>, Vec<ScreenSample>) {
    let arms: &[(f64, f64)] = match crosshairs {
        true => &[(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)],
        false => &[(0.0, 0.0)],
    };
    let mut out = (Vec::new(), Vec::new());
    while out.0.len() < n {
        let centre = (1.0 + 254.0 * rng.unit(), 1.0 + 254.0 * rng.unit());
        for arm in arms.iter().take(n - out.0.len()) {
            let (world, screen) = shoot(centre.0 + arm.0, centre.1 + arm.1, time, tilt);
            out.0.push(world);
            out.1.push(screen);
        }
    }
    out
}
