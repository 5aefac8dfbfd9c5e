//! A display's lights, and what is put before them.

use unframed_recon::Fixed;
use unframed_recon::deep::{Placing, Stored, slot};
use unframed_recon::light::facets::Facet;
use unframed_recon::light::map::{WINDOWS, Window};
use unframed_recon::light::toward::Toward;
use unframed_recon::light::{Lights, Memory};
use unframed_recon::memory::Slot;
use unframed_wire::{
    ColourEncoding, Hello, LAMPS, Lamp, LampKind, Layout, Packet, Pose, Receiver, Shape, Shares,
    TileFields, WorldFrame, Writer,
};

pub(crate) type Point = [f64; 3];
pub(crate) type Triangle = [[i16; 3]; 3];

/// World units in a unit of places.
pub(crate) const UNIT: i32 = 256;
/// Units in a step of the depths of maps.
pub(crate) const DEPTH: f64 = 4.0;
/// Half the side of a face of a cube, as maps count it.
pub(crate) const FACE: f64 = 16384.0;

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

    /// Uniform in 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform within ±edge.
    pub(crate) fn within(&mut self, edge: f64) -> f64 {
        (2.0 * self.unit() - 1.0) * edge
    }
}

/// Shapes come after one.
pub(crate) const HELLO: Hello = Hello {
    width: 8,
    height: 8,
    layout: Layout::World,
    objects: true,
    tile_fields: TileFields {
        gradients: false,
        lifetime: false,
        density: false,
    },
    encoding: ColourEncoding::Srgb8,
    rate: 1000,
    refresh_millihertz: 60_000,
    world: WorldFrame {
        origin: [0.0; 3],
        unit: 0.001,
    },
    lamps: LAMPS as u8,
};

/// Storage for lights.
pub(crate) struct Room {
    facets: Vec<Facet>,
    towards: Vec<[Toward; LAMPS]>,
    texels: Vec<u16>,
    windows: Vec<Window>,
}

impl Room {
    pub(crate) fn new(facets: usize, texels: usize) -> Room {
        Room {
            facets: vec![Facet::EMPTY; facets],
            towards: vec![[Toward::ZERO; LAMPS]; 256],
            texels: vec![0; texels],
            windows: vec![Window::EMPTY; WINDOWS],
        }
    }

    pub(crate) fn lights(&mut self) -> Lights<'_> {
        Lights::new(Memory {
            facets: &mut self.facets,
            towards: &mut self.towards,
            texels: &mut self.texels,
            windows: &mut self.windows,
        })
    }
}

/// Hands over a part of a shape as it comes out of a stream.
pub(crate) fn with_shape<R>(
    (object, part): (u8, u8),
    triangles: &[Triangle],
    take: impl FnOnce(&Shape<'_>) -> R,
) -> R {
    let mut bytes = Vec::new();
    let sink = &mut |frame: &[u8]| bytes.extend_from_slice(frame);
    let corners = |i: usize| [0, 1, 2].map(|k| (3 * i + k) as u8);
    let indices: Vec<_> = (0..triangles.len()).map(corners).collect();
    let mut writer = Writer::new();
    writer.hello(&HELLO, sink).expect("a sound hello");
    writer
        .shape(object, part, 256, triangles.as_flattened(), &indices, sink)
        .expect("a sound shape");
    let (mut receiver, mut input) = (Receiver::new(), &bytes[..]);
    loop {
        match receiver.push(&mut input) {
            Some(Packet::Shape(shape)) => return take(&shape),
            Some(_) => {}
            None => panic!("no shape"),
        }
    }
}

/// Lattice steps are units of places, and so are the numbers of `at`: lamps see them exactly.
pub(crate) fn exact(object: u8, at: [i32; 3]) -> Pose {
    Pose {
        object,
        matrix: [[UNIT, 0, 0], [0, UNIT, 0], [0, 0, UNIT]],
        frac_bits: 0,
        translation: at.map(|v| UNIT * v),
    }
}

/// Slots with these poses.
pub(crate) fn slots(poses: &[Pose]) -> Vec<Slot<Fixed>> {
    let mut slots = vec![Slot::default(); 256];
    for pose in poses {
        slots[usize::from(slot(pose.object))].pose = Some(*pose);
    }
    slots
}

pub(crate) fn lamp(kind: LampKind, place: [i32; 3]) -> Lamp {
    Lamp {
        kind,
        place,
        tint: [256; 2],
    }
}

/// A white sample all of whose light comes from one lamp: black in its shadow.
pub(crate) fn sample(object: u8, place: [i16; 3], lamp: usize) -> Stored {
    let mut codes = [0; LAMPS];
    codes[lamp] = 15;
    Stored {
        time: 0,
        place,
        rgb: [255; 3],
        slot: slot(object),
        placing: Placing::Lattice,
        shares: Shares::new(codes),
    }
}

pub(crate) fn dark(lights: &Lights<'_>, sample: &Stored) -> bool {
    lights.relight(sample) == [0; 3]
}
