//! Synthetic streams: a checkered wall, spheres that move before it, a sky, a turning camera.

use unframed_wire::tiles::split;
use unframed_wire::{
    Axis, ColourEncoding, Hello, LAMPS, Lamp, LampKind, Layout, LogCode, Pose, Rect, Refresh, SKY,
    ScreenSample, Shares, Tick, Tile, TileFields, TileNode, View, WorldFrame, WorldSample, Writer,
};

/// The splitmix64 generator: seeded test data.
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..n.
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Triangles of a part of a shape: few enough for a packet, few enough for several.
const PART: usize = 5;

/// Moving spheres.
const MOVERS: u8 = 3;

/// A stream under construction.
pub(crate) struct Stream {
    pub(crate) bytes: Vec<u8>,
    writer: Writer,
    rng: Rng,
    size: (u16, u16),
    layout: Layout,
    /// Lamps of which the Hello of a world tells.
    lamps: u8,
}

impl Stream {
    pub(crate) fn new(size: (u16, u16), layout: Layout, seed: u64) -> Stream {
        Stream::lit(size, layout, seed, LAMPS as u8)
    }

    /// Of so many lamps, where there is a world.
    pub(crate) fn lit(size: (u16, u16), layout: Layout, seed: u64, lamps: u8) -> Stream {
        let mut stream = Stream {
            bytes: Vec::new(),
            writer: Writer::new(),
            rng: Rng(seed),
            size,
            layout,
            lamps,
        };
        stream.hello(400_000);
        stream
    }

    pub(crate) fn hello(&mut self, rate: u32) {
        let hello = Hello {
            width: self.size.0,
            height: self.size.1,
            layout: self.layout,
            objects: self.layout == Layout::World,
            tile_fields: TileFields {
                gradients: true,
                lifetime: true,
                density: true,
            },
            encoding: ColourEncoding::Srgb8,
            rate,
            refresh_millihertz: 60_000,
            world: WorldFrame {
                origin: [0.0; 3],
                unit: 0.001,
            },
            lamps: match self.layout {
                Layout::World => self.lamps,
                Layout::Screen => 0,
            },
        };
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        self.writer.hello(&hello, sink).expect("a sound hello");
    }

    /// A stream for a panel of another size, in the middle of this one.
    pub(crate) fn foreign_hello(&mut self) {
        let size = self.size;
        self.size = (size.0 % 4000 + 1, size.1);
        self.hello(1);
        self.size = size;
        self.hello(400_000);
    }

    pub(crate) fn layout(&mut self, layout: Layout) {
        self.layout = layout;
        self.hello(400_000);
    }

    /// A camera 20 units before the origin, turned by `turn` radians and as many times 9 units to
    /// the side: 60 degrees over the panel.
    pub(crate) fn view(&mut self, time: u32, turn: f64) {
        let [w, h] = [self.size.0, self.size.1].map(f64::from);
        let f = w.max(h) / 2.0 / 30f64.to_radians().tan();
        let (s, k) = turn.sin_cos();
        let (right, down, forward) = ([k, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, k]);
        let q = |v: f64| (v * f64::from(1 << 18)).round() as i32;
        let row =
            |axis: [f64; 3], c: f64| std::array::from_fn(|j| q(f * axis[j] + c / 2.0 * forward[j]));
        let view = View {
            time: Tick(time),
            eye: [(turn * 9000.0) as i32, 0, -20_000],
            rows: [row(right, w), row(down, h), forward.map(q)],
            frac_bits: 18,
        };
        self.any_view(&view);
    }

    pub(crate) fn any_view(&mut self, view: &View) {
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        self.writer.view(view, sink).expect("a sound view");
    }

    /// Poses of the world, the sky and the movers, `phase` along their ways.
    pub(crate) fn poses(&mut self, time: u32, phase: f64) {
        let mut poses = vec![pose(0, 1.0, [0; 3]), pose(SKY, 40.0, [0, 0, -20_000])];
        for object in 1..=MOVERS {
            let angle = phase + f64::from(object) * 2.0;
            let at = [8000.0 * angle.cos(), 5000.0 * angle.sin(), -4000.0].map(|v| v as i32);
            poses.push(pose(object, 0.8, at));
        }
        self.any_poses(time, &poses);
        if self.layout == Layout::World && self.lamps > 0 {
            self.light(time, phase);
        }
    }

    /// A lamp before the movers and light from above; all movers but the last throw shadows.
    fn light(&mut self, time: u32, phase: f64) {
        let near = Lamp {
            kind: LampKind::Point,
            place: [(9000.0 * phase.sin()) as i32, -3000, -12_000],
            tint: [200, 300],
        };
        let far = Lamp {
            kind: LampKind::Directional,
            place: [200_000_000, -900_000_000, (phase * -1e8) as i32],
            tint: [300, 150],
        };
        self.lamps(time, &[near, far]);
        for object in 1..MOVERS {
            self.shape(object, &octahedron(5000));
        }
    }

    /// A random k-d cut of the panel, down to leaves of about `leaf` pixels.
    pub(crate) fn tiles(&mut self, time: u32, leaf: u32) {
        self.tiles_but(time, leaf, |_| {});
    }

    /// The same with tiles changed.
    pub(crate) fn tiles_but(&mut self, time: u32, leaf: u32, mut change: impl FnMut(&mut Tile)) {
        let region = Rect {
            x: 0,
            y: 0,
            w: self.size.0,
            h: self.size.1,
        };
        let mut nodes = Vec::new();
        grow(&mut self.rng, region, leaf, &mut nodes);
        for node in &mut nodes {
            if let TileNode::Leaf(tile) = node {
                change(tile);
            }
        }
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        let tiles = self.writer.tiles(Tick(time), region, &nodes, sink);
        tiles.expect("a sound tree");
    }

    /// `count` samples, in groups, at times that spread over `from..from + span`.
    pub(crate) fn samples(&mut self, count: usize, from: u32, span: u32) {
        const GROUP: usize = 50;
        let groups = count.div_ceil(GROUP).max(1) as u64;
        for group in 0..groups {
            let after = u64::from(span) * group / groups;
            let time = Tick(from.wrapping_add(after as u32));
            let left = count - group as usize * GROUP;
            let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
            let rng = &mut self.rng;
            let sent = match self.layout {
                Layout::World => {
                    let all: Vec<_> = (0..left.min(GROUP)).map(|_| world(rng)).collect();
                    self.writer.world_samples(time, &all, sink)
                }
                Layout::Screen => {
                    let all: Vec<_> = (0..left.min(GROUP))
                        .map(|_| screen(rng, self.size))
                        .collect();
                    self.writer.screen_samples(time, &all, sink)
                }
            };
            sent.expect("sound samples");
        }
    }

    /// Samples that are all alike.
    pub(crate) fn same_sample(&mut self, count: usize, time: u32, sample: WorldSample) {
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        let sent = self
            .writer
            .world_samples(Tick(time), &vec![sample; count], sink);
        sent.expect("sound samples");
    }

    /// Any samples of a world that share an instant.
    pub(crate) fn world_samples(&mut self, time: u32, samples: &[WorldSample]) {
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        let sent = self.writer.world_samples(Tick(time), samples, sink);
        sent.expect("sound samples");
    }

    pub(crate) fn any_poses(&mut self, time: u32, poses: &[Pose]) {
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        let poses = self.writer.poses(Tick(time), poses, sink);
        poses.expect("sound poses");
    }

    pub(crate) fn lamps(&mut self, time: u32, lamps: &[Lamp]) {
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        let lamps = self.writer.lamps(Tick(time), lamps, sink);
        lamps.expect("sound lamps");
    }

    /// The shape of an object in as many parts as it takes.
    pub(crate) fn shape(&mut self, object: u8, triangles: &[[[i16; 3]; 3]]) {
        let parts = triangles.chunks(PART);
        let count = parts.len() as u16;
        for (part, triangles) in (0..).zip(parts) {
            let vertices = triangles.as_flattened();
            let corners = |i: usize| [0, 1, 2].map(|k| (3 * i + k) as u8);
            let indices: Vec<_> = (0..triangles.len()).map(corners).collect();
            let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
            let shape = self
                .writer
                .shape(object, part, count, vertices, &indices, sink);
            shape.expect("a sound shape");
        }
    }

    pub(crate) fn cut(&mut self, time: u32) {
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        self.writer.cut(Tick(time), sink).expect("a cut");
    }

    pub(crate) fn refresh(&mut self, time: u32, index: u32) {
        let refresh = Refresh {
            time: Tick(time),
            index,
        };
        let sink = &mut |frame: &[u8]| self.bytes.extend_from_slice(frame);
        self.writer.refresh(refresh, sink).expect("a refresh");
    }
}

fn pose(object: u8, scale: f64, translation: [i32; 3]) -> Pose {
    let one = (scale * f64::from(1 << 24)) as i32;
    Pose {
        object,
        matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
        frac_bits: 24,
        translation,
    }
}

fn grow(rng: &mut Rng, rect: Rect, leaf: u32, nodes: &mut Vec<TileNode>) {
    let area = u32::from(rect.w) * u32::from(rect.h);
    let axis = if rect.w > rect.h { Axis::X } else { Axis::Y };
    match split(rect, axis) {
        Some((first, second)) if area > leaf => {
            nodes.push(TileNode::Split(axis));
            grow(rng, first, leaf, nodes);
            grow(rng, second, leaf, nodes);
        }
        _ => {
            let mut code = |from: u64, to: u64| LogCode((from + rng.below(to - from)) as u8);
            nodes.push(TileNode::Leaf(Tile {
                rect,
                gx: code(40, 150),
                gy: code(40, 150),
                gt: code(40, 150),
                lifetime: code(70, 140),
                density: code(110, 180),
            }));
        }
    }
}

/// A wall at z = 20000 with a checker, spheres before it, a little sky.
fn world(rng: &mut Rng) -> WorldSample {
    let kind = rng.below(100);
    let (place, object, bright) = if kind < 5 {
        let place = [rng.next() as i16, rng.next() as i16, 30_000];
        (place, SKY, kind < 2)
    } else if kind < 40 {
        let (u, v) = (rng.unit() * std::f64::consts::TAU, rng.unit() * 2.0 - 1.0);
        let r = 4000.0 * (1.0 - v * v).sqrt();
        let place = [r * u.cos(), 4000.0 * v, r * u.sin()].map(|v| v as i16);
        let object = 1 + rng.below(u64::from(MOVERS)) as u8;
        (place, object, (8.0 * v).sin() > 0.0)
    } else {
        let at = [0, 1].map(|_| (rng.unit() - 0.5) * 60_000.0);
        let checker = (at[0] / 3000.0).floor() + (at[1] / 3000.0).floor();
        let place = [at[0] as i16, at[1] as i16, 20_000];
        (place, 0, checker as i64 % 2 == 0)
    };
    let level = if bright { 240 } else { 3 } + rng.below(13) as u8;
    WorldSample {
        place,
        rgb: [level, level / 2 + 20 * (object % 4), 255 - level],
        object,
        shares: Shares::new([rng.below(16) as u8, rng.below(16) as u8]),
    }
}

/// An octahedron of this radius, lattice steps.
pub(crate) fn octahedron(r: i16) -> Vec<[[i16; 3]; 3]> {
    let signs = [[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]];
    let all = signs.iter().flat_map(|s| [*s, s.map(|v: i16| -v)]);
    all.map(|[x, y, z]| [[x * r, 0, 0], [0, y * r, 0], [0, 0, z * r]])
        .collect()
}

fn screen(rng: &mut Rng, size: (u16, u16)) -> ScreenSample {
    let mut along = |pixels: u16| rng.below(u64::from(pixels) * 16) as u16;
    let (x, y) = (along(size.0), along(size.1));
    let bright = (x / 200 + y / 100) % 2 == 0;
    let level = if bright { 230 } else { 10 } + rng.below(20) as u8;
    ScreenSample {
        x,
        y,
        rgb: [level, 255 - level, (x % 256) as u8],
    }
}
