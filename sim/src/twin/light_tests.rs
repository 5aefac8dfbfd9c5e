//! Samples of all ranges under lamps of all ranges, in sight or not: relit alike.

use super::{OwnLights, WORDS};
use crate::gpu::Gpu;
use crate::pass::Access::{Read, Uniform, Write};
use crate::pass::{Batch, Stage, Words, linear_grid};
use crate::testing::{Random, adapter_or_skip};
use crate::twin::Tables;
use crate::twin::params::{self, Params};
use crate::twin::stages::{GROUP, PRELUDE};
use unframed_recon::deep::{Placing, Stored, slot};
use unframed_recon::light::TEXELS;
use unframed_recon::memory::Slot;
use unframed_recon::{Config, Fixed, Panel};
use unframed_wire::{
    ColourEncoding, Hello, LAMPS, Lamp, LampKind, Layout, Packet, Pose, Receiver, Shares,
    TileFields, WorldFrame, Writer,
};

const MAIN: &str = "
    @group(0) @binding(2) var<storage, read> samples: array<Stored>;
    @group(0) @binding(3) var<storage, read_write> relit: array<u32>;
    @group(0) @binding(4) var<storage, read> light: Light;

    @compute @workgroup_size(64)
    fn main(
        @builtin(workgroup_id) group: vec3<u32>,
        @builtin(num_workgroups) groups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = linear(group, groups, local);
        if i >= arrayLength(&samples) { return; }
        let code = relight(samples[i]);
        relit[i] = code.x | (code.y << 8u) | (code.z << 16u);
    }";

const SAMPLES: usize = 4000;
const ROUNDS: usize = 120;

/// The adapter's part of the display, as much as lights need of it.
struct Bench<'g> {
    gpu: &'g Gpu,
    stage: Stage,
    params: Words,
    tables: Words,
    light: Words,
}

impl<'g> Bench<'g> {
    fn new(gpu: &'g Gpu) -> Bench<'g> {
        let config = Config::ADAPTIVE;
        let panel = Panel::new(8, 8).expect("a sound size");
        let params = [Params::new(&config, &panel, 1)];
        let tables = [Tables::new(&config)];
        let mut source = PRELUDE.to_vec();
        source.extend([
            include_str!("shaders/srgb.wgsl"),
            include_str!("shaders/light.wgsl"),
            MAIN,
        ]);
        let bindings = [Uniform, Read, Read, Write, Read];
        let upload = |name, words: &[u32]| Words::upload(gpu, name, words).expect("room");
        Bench {
            gpu,
            stage: Stage::new(gpu, "relit", &source, &bindings).expect("a sound shader"),
            params: upload("params", bytemuck::cast_slice(&params)),
            tables: upload("tables", bytemuck::cast_slice(&tables)),
            light: Words::zeroed(gpu, "light", WORDS + TEXELS / 2).expect("room"),
        }
    }

    fn relit(&self, samples: &[Stored]) -> Vec<[u8; 3]> {
        let words: Vec<_> = samples.iter().flat_map(params::stored).collect();
        let samples = Words::upload(self.gpu, "samples", &words).expect("room");
        let relit = Words::zeroed(self.gpu, "relit", words.len() / 4).expect("room");
        let mut batch = Batch::new(self.gpu);
        let buffers = [&self.params, &self.tables, &samples, &relit, &self.light];
        let items = linear_grid(relit.len(), GROUP);
        batch.run(&self.stage, &buffers, items).expect("it runs");
        batch.submit().expect("it runs");
        let words = relit.read(self.gpu).expect("the device answers");
        let code = |word: u32| {
            let [r, g, b, _] = word.to_le_bytes();
            [r, g, b]
        };
        words.into_iter().map(code).collect()
    }
}

/// Within ±2^`most`, small as often as large.
fn int(random: &mut Random, most: u32) -> i32 {
    let bits = random.next() % u64::from(most + 1);
    let edge = 1i64 << bits;
    (random.next() % (2 * edge as u64 + 1)) as i32 - edge as i32
}

fn corner(random: &mut Random, by: u32) -> [i16; 3] {
    [(); 3].map(|()| (random.next() as i16) >> by)
}

/// A part of a shape as it comes out of a stream.
fn shape(lights: &mut OwnLights, object: u8, vertices: &[[i16; 3]]) {
    let hello = Hello {
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
    let mut bytes = Vec::new();
    let sink = &mut |frame: &[u8]| bytes.extend_from_slice(frame);
    let triangles: Vec<_> = (0..vertices.len() as u8 / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let mut writer = Writer::new();
    writer.hello(&hello, sink).expect("a sound hello");
    writer
        .shape(object, 0, 1, vertices, &triangles, sink)
        .expect("a sound shape");
    let (mut receiver, mut input) = (Receiver::new(), &bytes[..]);
    while let Some(packet) = receiver.push(&mut input) {
        if let Packet::Shape(shape) = packet {
            assert_eq!(lights.shape(&shape), 0);
        }
    }
}

/// What a round is about.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scene {
    /// Lamps among objects that they see exactly: coordinates are often equal.
    Near,
    /// Lamps far away.
    Far,
    /// Lamps and poses of all ranges.
    Any,
}

fn pose(random: &mut Random, object: u8, scene: Scene) -> Pose {
    if scene != Scene::Any {
        let one = if scene == Scene::Near { 256 } else { 512 };
        return Pose {
            object,
            matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
            frac_bits: 0,
            translation: [(); 3].map(|()| one * int(random, 9)),
        };
    }
    let frac_bits = (random.next() % 32) as u8;
    let most = (u32::from(frac_bits) + 9).min(30);
    Pose {
        object,
        matrix: [(); 3].map(|()| [(); 3].map(|()| int(random, most))),
        frac_bits,
        translation: [(); 3].map(|()| int(random, 29)),
    }
}

#[test]
fn samples_are_relit_alike_under_any_lamp() {
    let Some(gpu) = adapter_or_skip("equality of light of all ranges") else {
        return;
    };
    let bench = Bench::new(&gpu);
    let mut random = Random(77);
    let (mut lights, mut dimmed) = (OwnLights::new(), 0);
    for round in 0..ROUNDS {
        let scene = [Scene::Near, Scene::Any, Scene::Near, Scene::Far][round % 4];
        if round % 3 == 0 {
            lights.clear();
        }
        for index in 0..LAMPS {
            let directional = random.next().is_multiple_of(3);
            let (kind, most) = match (directional, scene) {
                (true, _) => (LampKind::Directional, 30),
                (false, Scene::Near) => (LampKind::Point, 17),
                (false, _) => (LampKind::Point, 29),
            };
            let mut place = [(); 3].map(|()| int(&mut random, most) | 1);
            if scene == Scene::Far {
                place[round % 3] = 1 << 26;
            }
            let lamp = Lamp {
                kind,
                place: place.map(|v| v.clamp(-(1 << most), 1 << most)),
                tint: [(); 2].map(|()| 1 + random.next() as u16 % 1000),
            };
            assert!(lights.with(|lights| lights.lamp(index, &lamp)));
        }
        let mut slots = vec![Slot::<Fixed>::default(); 256];
        let by = match scene {
            Scene::Near => 5 + random.next() as u32 % 3,
            _ => 0,
        };
        for object in 0..4 {
            slots[usize::from(slot(object))].pose = Some(pose(&mut random, object, scene));
            if object > 0 {
                let corners: Vec<_> = (0..18).map(|_| corner(&mut random, by)).collect();
                shape(&mut lights, object, &corners);
            }
        }
        lights
            .prepare(&gpu, &slots, &bench.light)
            .expect("the device answers");
        let samples: Vec<Stored> = (0..SAMPLES)
            .map(|_| {
                let bits = random.next().to_le_bytes();
                Stored {
                    time: 0,
                    place: corner(&mut random, by),
                    rgb: [bits[0], bits[1], bits[2]],
                    slot: slot(bits[3] % 4),
                    placing: Placing::Lattice,
                    shares: Shares(bits[4]),
                }
            })
            .collect();
        let expected: Vec<_> =
            lights.with(|lights| samples.iter().map(|s| lights.relight(s)).collect());
        let relit = bench.relit(&samples);
        let changed = samples.iter().zip(&expected).filter(|(s, e)| s.rgb != **e);
        dimmed += changed.count();
        let wrong = relit.iter().zip(&expected).position(|(a, b)| a != b);
        if let Some(at) = wrong {
            let (sample, ours, theirs) = (&samples[at], relit[at], expected[at]);
            panic!("round {round}: {sample:?} is {ours:?}, not {theirs:?}");
        }
    }
    println!("{dimmed} of {} dimmed", ROUNDS * SAMPLES);
    assert!(dimmed > ROUNDS * SAMPLES / 20, "{dimmed}");
}
