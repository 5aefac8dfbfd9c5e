//! Streams and samples for tests: collected packets, random meanings, a ray-cast room.

use unframed_wire::*;

/// A packet without its borrow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Owned {
    Hello(Hello),
    View(View),
    Poses(Tick, Vec<Pose>),
    Tiles(Tick, Rect, Vec<Tile>),
    World(Tick, Vec<WorldSample>),
    Screen(Tick, Vec<ScreenSample>),
    Refresh(Refresh),
    Cut(Tick),
    End(End),
    Status(Status),
    Index(Vec<IndexEntry>),
    Trailer(Trailer),
    Lamps(Tick, Vec<Lamp>),
    /// Object, part, parts, triangles.
    Shape(u8, u8, u16, Vec<[[i16; 3]; 3]>),
}

impl From<Packet<'_>> for Owned {
    fn from(packet: Packet<'_>) -> Self {
        match packet {
            Packet::Hello(p) => Owned::Hello(p),
            Packet::View(p) => Owned::View(p),
            Packet::Poses(p) => Owned::Poses(p.time(), p.collect()),
            Packet::Tiles(p) => Owned::Tiles(p.time(), p.region(), p.collect()),
            Packet::World(p) => Owned::World(p.time(), p.collect()),
            Packet::Screen(p) => Owned::Screen(p.time(), p.collect()),
            Packet::Refresh(p) => Owned::Refresh(p),
            Packet::Cut(p) => Owned::Cut(p),
            Packet::End(p) => Owned::End(p),
            Packet::Status(p) => Owned::Status(p),
            Packet::Index(p) => Owned::Index(p.collect()),
            Packet::Trailer(p) => Owned::Trailer(p),
            Packet::Lamps(p) => Owned::Lamps(p.time(), p.collect()),
            Packet::Shape(p) => Owned::Shape(p.object(), p.part(), p.parts(), p.collect()),
        }
    }
}

/// All packets in `bytes`, pushed in pieces of `step` bytes.
pub(crate) fn receive(bytes: &[u8], step: usize) -> (Vec<Owned>, Counters) {
    let mut receiver = Receiver::new();
    let mut out = Vec::new();
    for piece in bytes.chunks(step.max(1)) {
        let mut input = piece;
        while let Some(packet) = receiver.push(&mut input) {
            out.push(Owned::from(packet));
        }
    }
    (out, *receiver.counters())
}

pub(crate) fn hello(layout: Layout, objects: bool) -> Hello {
    Hello {
        width: 256,
        height: 256,
        layout,
        objects,
        tile_fields: TileFields {
            gradients: true,
            lifetime: true,
            density: true,
        },
        encoding: ColourEncoding::Srgb8,
        rate: 400_000,
        refresh_millihertz: 60_000,
        world: WorldFrame {
            origin: [0.5, -1.0, 2.0],
            unit: 1.0 / 65536.0,
        },
        lamps: 0,
    }
}

/// The Hello of a world with objects whose samples tell the shares of `lamps` lamps.
pub(crate) fn lit(lamps: u8) -> Hello {
    Hello {
        lamps,
        ..hello(Layout::World, true)
    }
}

/// A lamp in range.
pub(crate) const LAMP: Lamp = Lamp {
    kind: LampKind::Point,
    place: [1000, -2000, Lamp::MAX_PLACE],
    tint: [256, 1],
};

/// Shares that change smoothly over an object.
pub(crate) fn smooth(place: [i16; 3], lamps: u8) -> Shares {
    let [x, y, z] = place.map(|q| i32::from(q) + 32_768);
    let codes = [x + z / 2, y + z].map(|far| 15 - (far >> 13) as u8);
    Shares::new(match lamps {
        0 => [0; 2],
        1 => [codes[0], 0],
        _ => codes,
    })
}

/// What a [`Writer`] sends while `f` uses it.
pub(crate) fn written(f: impl FnOnce(&mut Writer, &mut dyn FnMut(&[u8]))) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = Writer::new();
    f(&mut writer, &mut |frame| bytes.extend_from_slice(frame));
    bytes
}
