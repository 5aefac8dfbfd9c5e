//! Payloads of fixed layout: little endian, two's complement, no padding.

use crate::bytes::{Buffer, Cursor};
use crate::frame::MAX_PACKET;
use crate::repr::*;
use crate::{receiver::Damage, schema};

/// Poses in one packet: 5 + 40·50 bytes.
pub const MAX_POSES: usize = 40;

/// Entries in one Index packet: 150·13 bytes.
pub const MAX_INDEX_ENTRIES: usize = 150;

const POSE_BYTES: usize = 50;
const INDEX_BYTES: usize = 13;
const LAMP_BYTES: usize = 17;

/// Bytes of a Shape packet before its vertices, of a vertex and of a triangle.
const SHAPE_HEAD: usize = 5;
const VERTEX_BYTES: usize = 6;
const TRIANGLE_BYTES: usize = 3;

const FLAG_WORLD: u8 = 1;
const FLAG_OBJECTS: u8 = 2;

pub(crate) const FIELD_GRADIENTS: u8 = 1;
pub(crate) const FIELD_LIFETIME: u8 = 2;
pub(crate) const FIELD_DENSITY: u8 = 4;

/// Largest panel edge, pixels.
pub(crate) const MAX_EDGE: u16 = 4096;

pub(crate) fn put_fields(fields: TileFields) -> u8 {
    (if fields.gradients { FIELD_GRADIENTS } else { 0 })
        | (if fields.lifetime { FIELD_LIFETIME } else { 0 })
        | (if fields.density { FIELD_DENSITY } else { 0 })
}

pub(crate) fn get_fields(bits: u8) -> Option<TileFields> {
    (bits < 8).then_some(TileFields {
        gradients: bits & FIELD_GRADIENTS != 0,
        lifetime: bits & FIELD_LIFETIME != 0,
        density: bits & FIELD_DENSITY != 0,
    })
}

/// The bits of infinity in `f32`. Ranges are checked on bits: not even a comparison of floats is
/// left in the firmware.
const INFINITY: u32 = f32::INFINITY.to_bits();

/// Whether every field of `hello` is in the range that its documentation states.
pub(crate) fn hello_is_valid(hello: &Hello) -> bool {
    let world = &hello.world;
    (1..=MAX_EDGE).contains(&hello.width)
        && (1..=MAX_EDGE).contains(&hello.height)
        && hello.rate >= 1
        && hello.refresh_millihertz >= 1
        && world.origin.iter().all(|c| c.to_bits() & INFINITY < INFINITY)
        && (1..INFINITY).contains(&world.unit.to_bits())
        // Screen samples have no place for an object id.
        && !(hello.objects && hello.layout == Layout::Screen)
        // Nor for shares.
        && usize::from(hello.lamps) <= LAMPS
        && !(hello.lamps > 0 && hello.layout == Layout::Screen)
}

pub(crate) fn put_hello(b: &mut Buffer, hello: &Hello) {
    b.put(&schema::MAGIC);
    b.u8(schema::VERSION);
    b.u32(schema::HASH);
    b.u16(hello.width);
    b.u16(hello.height);
    let world = if hello.layout == Layout::World {
        FLAG_WORLD
    } else {
        0
    };
    b.u8(world | if hello.objects { FLAG_OBJECTS } else { 0 });
    b.u8(put_fields(hello.tile_fields));
    b.u8(match hello.encoding {
        ColourEncoding::Srgb8 => 0,
    });
    b.u32(hello.rate);
    b.u32(hello.refresh_millihertz);
    hello.world.origin.into_iter().for_each(|c| b.f32(c));
    b.f32(hello.world.unit);
    b.u8(hello.lamps);
}

pub(crate) fn get_hello(payload: &[u8]) -> Result<Hello, Damage> {
    let mut c = Cursor(payload);
    if c.take() != Some(schema::MAGIC) {
        return Err(Damage::Contents);
    }
    match c.u8() {
        Some(schema::VERSION) => {}
        Some(version) => return Err(Damage::Version(version)),
        None => return Err(Damage::Contents),
    }
    match c.u32() {
        Some(schema::HASH) => {}
        Some(hash) => return Err(Damage::Schema(hash)),
        None => return Err(Damage::Contents),
    }
    hello_body(c).ok_or(Damage::Contents)
}

fn hello_body(mut c: Cursor<'_>) -> Option<Hello> {
    let (width, height) = (c.u16()?, c.u16()?);
    let flags = c.u8()?;
    let tile_fields = get_fields(c.u8()?)?;
    let encoding = match c.u8()? {
        0 => ColourEncoding::Srgb8,
        _ => return None,
    };
    let (rate, refresh_millihertz) = (c.u32()?, c.u32()?);
    let world = WorldFrame {
        origin: [c.f32()?, c.f32()?, c.f32()?],
        unit: c.f32()?,
    };
    let lamps = c.u8()?;
    c.end()?;
    let hello = Hello {
        width,
        height,
        layout: if flags & FLAG_WORLD != 0 {
            Layout::World
        } else {
            Layout::Screen
        },
        objects: flags & FLAG_OBJECTS != 0,
        tile_fields,
        encoding,
        rate,
        refresh_millihertz,
        world,
        lamps,
    };
    (flags < 4 && hello_is_valid(&hello)).then_some(hello)
}

pub(crate) fn put_view(b: &mut Buffer, view: &View) {
    b.u32(view.time.0);
    b.i32x3(view.eye);
    view.rows.into_iter().for_each(|r| b.i32x3(r));
    b.u8(view.frac_bits);
}

pub(crate) fn get_view(payload: &[u8]) -> Option<View> {
    let mut c = Cursor(payload);
    let view = View {
        time: Tick(c.u32()?),
        eye: c.i32x3()?,
        rows: [c.i32x3()?, c.i32x3()?, c.i32x3()?],
        frac_bits: c.u8()?,
    };
    c.end()?;
    (view.frac_bits <= 30).then_some(view)
}

pub(crate) fn put_pose(b: &mut Buffer, pose: &Pose) {
    b.u8(pose.object);
    b.u8(pose.frac_bits);
    pose.matrix.into_iter().for_each(|r| b.i32x3(r));
    b.i32x3(pose.translation);
}

fn get_pose(c: &mut Cursor<'_>) -> Option<Pose> {
    let (object, frac_bits) = (c.u8()?, c.u8()?);
    let matrix = [c.i32x3()?, c.i32x3()?, c.i32x3()?];
    let pose = Pose {
        object,
        matrix,
        frac_bits,
        translation: c.i32x3()?,
    };
    (frac_bits <= 31).then_some(pose)
}

/// The transforms of some objects at one instant.
#[derive(Clone, Debug)]
pub struct Poses<'a> {
    time: Tick,
    body: Cursor<'a>,
}

impl<'a> Poses<'a> {
    pub(crate) fn parse(payload: &'a [u8]) -> Option<Self> {
        let mut body = Cursor(payload);
        let time = Tick(body.u32()?);
        let poses = Poses { time, body };
        let len = poses.body.0.len();
        let whole = len.is_multiple_of(POSE_BYTES) && (1..=MAX_POSES).contains(&poses.len());
        // With the ranges checked here the iterator yields exactly `len()` poses.
        (whole && poses.clone().count() == poses.len()).then_some(poses)
    }

    /// The instant at which these are the transforms.
    #[must_use]
    pub fn time(&self) -> Tick {
        self.time
    }

    /// Poses still to come, 1..=[`MAX_POSES`] at first.
    #[must_use]
    pub fn len(&self) -> usize {
        self.body.0.len() / POSE_BYTES
    }

    /// Whether none is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.body.0.is_empty()
    }
}

impl Iterator for Poses<'_> {
    type Item = Pose;

    fn next(&mut self) -> Option<Pose> {
        get_pose(&mut self.body)
    }
}

pub(crate) fn put_refresh(b: &mut Buffer, refresh: Refresh) {
    b.u32(refresh.time.0);
    b.u32(refresh.index);
}

pub(crate) fn get_refresh(payload: &[u8]) -> Option<Refresh> {
    let mut c = Cursor(payload);
    let refresh = Refresh {
        time: Tick(c.u32()?),
        index: c.u32()?,
    };
    c.end()?;
    Some(refresh)
}

pub(crate) fn get_cut(payload: &[u8]) -> Option<Tick> {
    let mut c = Cursor(payload);
    let time = Tick(c.u32()?);
    c.end()?;
    Some(time)
}

pub(crate) fn put_end(b: &mut Buffer, end: &End) {
    b.u32(end.time.0);
    b.u64(end.samples);
    b.u64(end.packets);
}

pub(crate) fn get_end(payload: &[u8]) -> Option<End> {
    let mut c = Cursor(payload);
    let end = End {
        time: Tick(c.u32()?),
        samples: c.u64()?,
        packets: c.u64()?,
    };
    c.end()?;
    Some(end)
}

pub(crate) fn put_status(b: &mut Buffer, status: &Status) {
    b.u32(status.refresh_time.0);
    b.u32(status.received);
    b.u32(status.lost);
    b.u32(status.damaged);
    b.u32(status.buffered);
}

pub(crate) fn get_status(payload: &[u8]) -> Option<Status> {
    let mut c = Cursor(payload);
    let status = Status {
        refresh_time: Tick(c.u32()?),
        received: c.u32()?,
        lost: c.u32()?,
        damaged: c.u32()?,
        buffered: c.u32()?,
    };
    c.end()?;
    Some(status)
}

/// What an index entry points at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexKind {
    /// A Hello: a player may start here. Its time is that of the packet before it that has one.
    Hello,
    /// A Refresh.
    Refresh,
    /// A Cut.
    Cut,
}

/// Where a packet lies in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexEntry {
    /// What lies there.
    pub kind: IndexKind,
    /// Its time.
    pub time: Tick,
    /// Bytes before the first byte of its frame.
    pub offset: u64,
}

pub(crate) fn put_index_entry(b: &mut Buffer, entry: &IndexEntry) {
    b.u8(match entry.kind {
        IndexKind::Hello => 0,
        IndexKind::Refresh => 1,
        IndexKind::Cut => 2,
    });
    b.u32(entry.time.0);
    b.u64(entry.offset);
}

fn get_index_entry(c: &mut Cursor<'_>) -> Option<IndexEntry> {
    let kind = match c.u8()? {
        0 => IndexKind::Hello,
        1 => IndexKind::Refresh,
        2 => IndexKind::Cut,
        _ => return None,
    };
    Some(IndexEntry {
        kind,
        time: Tick(c.u32()?),
        offset: c.u64()?,
    })
}

/// A piece of the index of a recording; a player may ignore it.
#[derive(Clone, Debug)]
pub struct IndexBlock<'a>(Cursor<'a>);

impl<'a> IndexBlock<'a> {
    pub(crate) fn parse(payload: &'a [u8]) -> Option<Self> {
        let block = IndexBlock(Cursor(payload));
        let count = payload.len() / INDEX_BYTES;
        let whole = payload.len().is_multiple_of(INDEX_BYTES) && count <= MAX_INDEX_ENTRIES;
        (whole && block.clone().count() == count).then_some(block)
    }
}

impl Iterator for IndexBlock<'_> {
    type Item = IndexEntry;

    fn next(&mut self) -> Option<IndexEntry> {
        get_index_entry(&mut self.0)
    }
}

/// The last frame of an indexed recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trailer {
    /// Bytes before the first Index frame (before this frame if there is none).
    pub offset: u64,
    /// Entries of all Index packets.
    pub entries: u32,
}

pub(crate) fn put_trailer(b: &mut Buffer, trailer: Trailer) {
    b.u64(trailer.offset);
    b.u32(trailer.entries);
}

pub(crate) fn get_trailer(payload: &[u8]) -> Option<Trailer> {
    let mut c = Cursor(payload);
    let trailer = Trailer {
        offset: c.u64()?,
        entries: c.u32()?,
    };
    c.end()?;
    Some(trailer)
}

pub(crate) fn put_lamp(b: &mut Buffer, lamp: &Lamp) {
    b.u8(match lamp.kind {
        LampKind::Point => 0,
        LampKind::Directional => 1,
    });
    b.i32x3(lamp.place);
    lamp.tint.into_iter().for_each(|t| b.u16(t));
}

fn get_lamp(c: &mut Cursor<'_>) -> Option<Lamp> {
    let lamp = Lamp {
        kind: match c.u8()? {
            0 => LampKind::Point,
            1 => LampKind::Directional,
            _ => return None,
        },
        place: c.i32x3()?,
        tint: [c.u16()?, c.u16()?],
    };
    lamp.is_valid().then_some(lamp)
}

/// The lamps of the stream at one instant, in the order of the samples' [`Shares`].
#[derive(Clone, Debug)]
pub struct Lamps<'a> {
    time: Tick,
    body: Cursor<'a>,
}

impl<'a> Lamps<'a> {
    /// `None` unless they are the `count` ≥ 1 lamps that the Hello announced.
    pub(crate) fn parse(payload: &'a [u8], count: u8) -> Option<Self> {
        let mut body = Cursor(payload);
        let time = Tick(body.u32()?);
        let count = usize::from(count);
        let lamps = Lamps { time, body };
        let whole = count > 0 && lamps.body.0.len() == count * LAMP_BYTES;
        (whole && lamps.clone().count() == count).then_some(lamps)
    }

    /// The instant at which the lamps are so.
    #[must_use]
    pub fn time(&self) -> Tick {
        self.time
    }

    /// Lamps still to come, 1..=[`LAMPS`] at first.
    #[must_use]
    pub fn len(&self) -> usize {
        self.body.0.len() / LAMP_BYTES
    }

    /// Whether none is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.body.0.is_empty()
    }
}

impl Iterator for Lamps<'_> {
    type Item = Lamp;

    fn next(&mut self) -> Option<Lamp> {
        get_lamp(&mut self.body)
    }
}

/// A part of the surface of an object that throws shadows; an iterator over its triangles, each
/// three places in the object's lattice.
///
/// A shape does not change within a stream. Its parts are repeated for displays that join: one
/// that has a part may ignore it.
#[derive(Clone, Debug)]
pub struct Shape<'a> {
    object: u8,
    part: u8,
    parts: u16,
    vertices: &'a [u8],
    triangles: Cursor<'a>,
}

impl<'a> Shape<'a> {
    pub(crate) fn parse(payload: &'a [u8]) -> Option<Self> {
        let mut c = Cursor(payload);
        let (object, part) = (c.u8()?, c.u8()?);
        let mut count = || c.u8().map(|less_one| u16::from(less_one) + 1);
        let (parts, vertices, triangles) = (count()?, count()?, count()?);
        let vertices = c.slice(usize::from(vertices) * VERTEX_BYTES)?;
        let corners = c.slice(usize::from(triangles) * TRIANGLE_BYTES)?;
        c.end()?;
        let named = shape_is_named(object, part, parts);
        let inside = |&at: &u8| usize::from(at) < vertices.len() / VERTEX_BYTES;
        (named && corners.iter().all(inside)).then_some(Shape {
            object,
            part,
            parts,
            vertices,
            triangles: Cursor(corners),
        })
    }

    /// Whether a part of so many vertices and triangles fits into a packet: 1..=256 of each, and
    /// 5 + 6·`vertices` + 3·`triangles` bytes at most 2041.
    #[must_use]
    pub const fn fits(vertices: usize, triangles: usize) -> bool {
        let counts = vertices >= 1 && vertices <= 256 && triangles >= 1 && triangles <= 256;
        counts
            && SHAPE_HEAD + vertices * VERTEX_BYTES + triangles * TRIANGLE_BYTES <= MAX_PACKET - 7
    }

    /// Whose shape it is, 1..=254.
    #[must_use]
    pub fn object(&self) -> u8 {
        self.object
    }

    /// Which part of the shape, below [`Shape::parts`].
    #[must_use]
    pub fn part(&self) -> u8 {
        self.part
    }

    /// How many parts the shape has, 1..=256.
    #[must_use]
    pub fn parts(&self) -> u16 {
        self.parts
    }

    /// Triangles still to come, 1..=256 at first.
    #[must_use]
    pub fn len(&self) -> usize {
        self.triangles.0.len() / TRIANGLE_BYTES
    }

    /// Whether none is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangles.0.is_empty()
    }

    fn vertex(&self, at: u8) -> Option<[i16; 3]> {
        let from = usize::from(at) * VERTEX_BYTES;
        Cursor(self.vertices.get(from..)?).i16x3()
    }
}

impl Iterator for Shape<'_> {
    type Item = [[i16; 3]; 3];

    fn next(&mut self) -> Option<[[i16; 3]; 3]> {
        let [a, b, c] = self.triangles.take()?;
        Some([self.vertex(a)?, self.vertex(b)?, self.vertex(c)?])
    }
}

/// Whether an object that moves is named, and a part that the shape has.
pub(crate) fn shape_is_named(object: u8, part: u8, parts: u16) -> bool {
    (1..SKY).contains(&object) && (1..=256).contains(&parts) && u16::from(part) < parts
}

/// Writes the payload of a part that [`Shape::fits`].
pub(crate) fn put_shape(
    b: &mut Buffer,
    [object, part]: [u8; 2],
    parts: u16,
    vertices: &[[i16; 3]],
    triangles: &[[u8; 3]],
) {
    b.put(&[object, part, parts.wrapping_sub(1) as u8]);
    b.put(&[vertices.len(), triangles.len()].map(|n| n.wrapping_sub(1) as u8));
    let coordinates = vertices.as_flattened().iter();
    coordinates.for_each(|q| b.put(&q.to_le_bytes()));
    b.put(triangles.as_flattened());
}
