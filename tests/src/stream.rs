//! Streams made by hand: every packet as a test wants it.
//!
//! The camera of [`flat`] makes places on the screen exact: it looks along +z at a plane
//! [`DEPTH`] world units away, where 8 units are one pixel, so that lattice point (8·x, 8·y, 0)
//! seen by an object at rest falls on the corner of pixel (x, y) counted from the panel's centre.

use unframed_wire::{
    Axis, ColourEncoding, Hello, LAMPS, Lamp, Layout, LogCode, Pose, Rect, Refresh, SKY,
    ScreenSample, Shares, Tick, Tile, TileFields, TileNode, View, WorldFrame, WorldSample, Writer,
};

/// Distance of the plane from the eye of [`flat`], world units.
pub const DEPTH: i32 = 1 << 14;
/// World units in a pixel at that distance.
pub const PIXEL: i16 = 8;

/// The splitmix64 generator: seeded test data.
#[derive(Clone, Debug)]
pub struct Rng(pub u64);

impl Rng {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `low..high`.
    pub fn range(&mut self, low: i64, high: i64) -> i64 {
        low + (self.bits() % (high - low) as u64) as i64
    }

    /// Uniform in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A view along +z from `eye`: `focal` pixels of focal length, the panel's centre in the middle.
#[must_use]
pub fn view(time: u32, (width, height): (u16, u16), eye: [i32; 3], focal: f64) -> View {
    let q = |v: f64| (v * f64::from(1 << 18)).round() as i32;
    let centre = |size: u16| q(f64::from(size) / 2.0);
    View {
        time: Tick(time),
        eye,
        rows: [
            [q(focal), 0, centre(width)],
            [0, q(focal), centre(height)],
            [0, 0, q(1.0)],
        ],
        frac_bits: 18,
    }
}

/// The view at the plane: see the module.
#[must_use]
pub fn flat(time: u32, size: (u16, u16)) -> View {
    let focal = f64::from(DEPTH) / f64::from(PIXEL);
    view(time, size, [0, 0, -DEPTH], focal)
}

/// A pose that scales by 2^−`bits` of `one` and moves.
#[must_use]
pub fn pose(object: u8, scale: f64, translation: [i32; 3]) -> Pose {
    let one = (scale * f64::from(1 << 24)).round() as i32;
    Pose {
        object,
        matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
        frac_bits: 24,
        translation,
    }
}

/// A sample of the static world.
#[must_use]
pub fn sample(place: [i16; 3], rgb: [u8; 3]) -> WorldSample {
    WorldSample {
        place,
        rgb,
        object: 0,
        shares: Shares::default(),
    }
}

/// A stream under construction.
#[derive(Debug)]
pub struct Stream {
    /// The bytes so far.
    pub bytes: Vec<u8>,
    writer: Writer,
    size: (u16, u16),
    index: u32,
}

impl Stream {
    /// A stream that has said Hello for a panel of `size` pixels and `rate` samples a second.
    #[must_use]
    pub fn new(size: (u16, u16), layout: Layout, rate: u32) -> Self {
        Self::lit(size, layout, rate, 0)
    }

    fn lit(size: (u16, u16), layout: Layout, rate: u32, lamps: u8) -> Self {
        let mut stream = Self {
            bytes: Vec::new(),
            writer: Writer::new(),
            size,
            index: 0,
        };
        let hello = Hello {
            width: size.0,
            height: size.1,
            layout,
            objects: layout == Layout::World,
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
            lamps,
        };
        stream.send(|writer, mut sink| writer.hello(&hello, &mut sink));
        stream
    }

    /// A stream of reprojected samples seen by [`flat`], view and poses sent.
    #[must_use]
    pub fn of_the_plane(size: (u16, u16)) -> Self {
        Self::of_the_plane_lit(size, 0)
    }

    /// The same with so many lamps announced.
    #[must_use]
    pub fn of_the_plane_lit(size: (u16, u16), lamps: u8) -> Self {
        let mut stream = Self::lit(size, Layout::World, 400_000, lamps);
        stream.look(&flat(0, size));
        stream.poses(0, &[pose(0, 1.0, [0; 3]), pose(SKY, 1.0, [0, 0, -DEPTH])]);
        stream
    }

    fn send(
        &mut self,
        what: impl FnOnce(&mut Writer, &mut dyn FnMut(&[u8])) -> Result<(), unframed_wire::EncodeError>,
    ) {
        let bytes = &mut self.bytes;
        let mut sink = |frame: &[u8]| bytes.extend_from_slice(frame);
        what(&mut self.writer, &mut sink).expect("a packet within its ranges");
    }

    /// Sends a view.
    pub fn look(&mut self, view: &View) {
        self.send(|writer, mut sink| writer.view(view, &mut sink));
    }

    /// Sends poses.
    pub fn poses(&mut self, time: u32, poses: &[Pose]) {
        self.send(|writer, mut sink| writer.poses(Tick(time), poses, &mut sink));
    }

    /// Sends the lamps.
    pub fn lamps(&mut self, time: u32, lamps: &[Lamp; LAMPS]) {
        self.send(|writer, mut sink| writer.lamps(Tick(time), lamps, &mut sink));
    }

    /// Sends a part of an object's shape: triangles whose corners are three vertices each.
    pub fn shape(&mut self, object: u8, part: u8, vertices: &[[i16; 3]]) {
        let triangles: Vec<_> = (0..vertices.len() as u8 / 3)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        self.send(|writer, mut sink| {
            writer.shape(object, part, 256, vertices, &triangles, &mut sink)
        });
    }

    /// Sends reprojected samples of one instant.
    pub fn world(&mut self, time: u32, samples: &[WorldSample]) {
        self.send(|writer, mut sink| writer.world_samples(Tick(time), samples, &mut sink));
    }

    /// Sends samples on the screen of one instant.
    pub fn screen(&mut self, time: u32, samples: &[ScreenSample]) {
        self.send(|writer, mut sink| writer.screen_samples(Tick(time), samples, &mut sink));
    }

    /// Sends a k-d cut down to leaves of at most `leaf` pixels, each as `tile` says.
    pub fn tiles(&mut self, time: u32, leaf: u32, mut tile: impl FnMut(Rect) -> Tile) {
        let region = Rect {
            x: 0,
            y: 0,
            w: self.size.0,
            h: self.size.1,
        };
        let mut nodes = Vec::new();
        grow(region, leaf, &mut tile, &mut nodes);
        self.send(|writer, mut sink| writer.tiles(Tick(time), region, &nodes, &mut sink));
    }

    /// Announces a cut.
    pub fn cut(&mut self, time: u32) {
        self.send(|writer, mut sink| writer.cut(Tick(time), &mut sink));
    }

    /// Asks for a picture.
    pub fn refresh(&mut self, time: u32) {
        let refresh = Refresh {
            time: Tick(time),
            index: self.index,
        };
        self.index += 1;
        self.send(|writer, mut sink| writer.refresh(refresh, &mut sink));
    }
}

/// A tile with these log codes for both spatial gradients, the temporal one and the lifetime.
#[must_use]
pub fn tile(rect: Rect, [gx, gy, gt, lifetime]: [u8; 4]) -> Tile {
    Tile {
        rect,
        gx: LogCode(gx),
        gy: LogCode(gy),
        gt: LogCode(gt),
        lifetime: LogCode(lifetime),
        density: LogCode(144),
    }
}

fn grow(rect: Rect, leaf: u32, tile: &mut impl FnMut(Rect) -> Tile, nodes: &mut Vec<TileNode>) {
    let area = u32::from(rect.w) * u32::from(rect.h);
    let axis = if rect.w > rect.h { Axis::X } else { Axis::Y };
    match unframed_wire::tiles::split(rect, axis) {
        Some((first, second)) if area > leaf => {
            nodes.push(TileNode::Split(axis));
            grow(first, leaf, tile, nodes);
            grow(second, leaf, tile, nodes);
        }
        _ => nodes.push(TileNode::Leaf(tile(rect))),
    }
}
