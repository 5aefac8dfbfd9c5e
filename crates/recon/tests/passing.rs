//! A thing that passes close before a wall: the wall must not show through it, however little lies between.

use unframed_recon::heap::HeapStorage;
use unframed_recon::tiles::RESTS;
use unframed_recon::{Arith, Config, Display, Fixed};
use unframed_wire::{
    ColourEncoding, Hello, Layout, Pose, Rect, Refresh, Shares, Tick, Tile, TileFields, View,
    WorldFrame, WorldSample,
};

const SIZE: u16 = 32;
const REFRESH: u32 = 16_667;
/// Depth of the wall, world units.
const WALL: i32 = 40_000;

/// From (0, 0, −20000) along +z, 60° across.
fn view() -> View {
    let focal = f64::from(SIZE) / 2.0 / 30f64.to_radians().tan();
    let q = |v: f64| (v * f64::from(1 << 22)).round() as i32;
    let centre = q(f64::from(SIZE) / 2.0);
    View {
        time: Tick(0),
        eye: [0, 0, -20_000],
        rows: [[q(focal), 0, centre], [0, q(focal), centre], [0, 0, q(1.0)]],
        frac_bits: 22,
    }
}

fn pose(object: u8, translation: [i32; 3]) -> Pose {
    let one = 1 << 28;
    Pose {
        object,
        matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
        frac_bits: 28,
        translation,
    }
}

/// A square grid of samples of an object in its plane z = 0, `half` to each side of its middle.
fn sheet(object: u8, rgb: [u8; 3], half: i32, z: i32) -> impl Iterator<Item = WorldSample> {
    let at = move |i: i32| (half * (2 * i - 95) / 95) as i16;
    (0..96 * 96).map(move |i| WorldSample {
        place: [at(i % 96), at(i / 96), z as i16],
        rgb,
        object,
        shares: Shares::default(),
    })
}

/// Red in the middle of the picture, after a green sheet has come in front of a red wall, `ahead` of the
/// wall's depth before it.
fn red<A: Arith>(ahead: f64) -> u8 {
    let mut storage = HeapStorage::<A>::new(SIZE, SIZE, 1 << 15);
    let mut display =
        Display::new(Config::ADAPTIVE, SIZE, SIZE, storage.memory()).expect("it fits");
    display.hello(&Hello {
        width: SIZE,
        height: SIZE,
        layout: Layout::World,
        objects: true,
        tile_fields: TileFields {
            lifetime: true,
            ..TileFields::default()
        },
        encoding: ColourEncoding::Srgb8,
        rate: 400_000,
        refresh_millihertz: 60_000,
        world: WorldFrame {
            origin: [0.0; 3],
            unit: 0.001,
        },
        lamps: 0,
    });
    display.view(&view());
    display.tile(&Tile {
        rect: Rect {
            x: 0,
            y: 0,
            w: SIZE,
            h: SIZE,
        },
        lifetime: RESTS,
        ..Tile::default()
    });
    let show = |index: u32, x: i32, display: &mut Display<'_, A>| {
        let z = WALL - (f64::from(WALL) * ahead) as i32 - 20_000;
        display.pose(&pose(0, [0; 3]));
        display.pose(&pose(1, [x, 0, z]));
        let time = Tick(index * REFRESH);
        display.refresh(&Refresh { time, index });
    };
    for sample in sheet(0, [200, 0, 0], 30_000, WALL - 20_000) {
        display.world_sample(Tick(0), &sample);
    }
    show(1, -30_000, &mut display);
    for sample in sheet(1, [0, 200, 0], 8_000, 0) {
        display.world_sample(Tick(10 * REFRESH), &sample);
    }
    show(11, 0, &mut display);
    let middle = usize::from(SIZE / 2) * usize::from(SIZE) + usize::from(SIZE / 2);
    display.picture()[middle][0]
}

#[test]
fn a_wall_does_not_show_through_what_passes_before_it() {
    for ahead in [0.5, 0.1, 0.04, 0.025] {
        assert_eq!(red::<Fixed>(ahead), 0, "{ahead} of its depth before it");
        assert_eq!(
            red::<f64>(ahead),
            0,
            "{ahead} of its depth before it, in f64"
        );
    }
}

/// What slopes within the tolerance is not told from a thing before it.
#[test]
fn what_lies_on_a_wall_is_no_occluder() {
    assert!(red::<Fixed>(0.005) > 50);
}
