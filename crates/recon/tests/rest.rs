//! What stands still: the mean of every pixel, old light forgotten, the same whoever does the work.

#[path = "../benches/load/scene.rs"]
mod scene;

use scene::{REFRESH, Show, hello};
use unframed_recon::heap::HeapStorage;
use unframed_recon::tiles::RESTS;
use unframed_recon::{Config, Display, Fixed, Threads, frame_hash};
use unframed_wire::{
    Layout, LogCode, Rect, Refresh, ScreenSample, Shares, Tick, Tile, WorldFrame, WorldSample,
};

const SIZE: u16 = 24;
/// Samples between two refreshes: one a pixel.
const SAMPLES: u32 = (SIZE as u32).pow(2);

/// A picture of vertical stripes two thirds of a pixel wide: no filter of a pixel's width or more
/// finds the mean of a pixel, which repeats every four.
fn stripe(x: u32) -> u8 {
    // x in 1/16 pixel; stripes of 32/3.
    if (3 * x / 32).is_multiple_of(2) {
        230
    } else {
        20
    }
}

/// The mean light of each column, of 65535.
fn columns() -> Vec<f64> {
    let light = unframed_recon::config::Light::Linear.table();
    (0..u32::from(SIZE))
        .map(|x| {
            let sum: f64 = (16 * x..16 * (x + 1))
                .map(|at| f64::from(light[usize::from(stripe(at))]))
                .sum();
            sum / 16.0
        })
        .collect()
}

fn tiles(lifetime: LogCode) -> Tile {
    Tile {
        rect: Rect {
            x: 0,
            y: 0,
            w: SIZE,
            h: SIZE,
        },
        lifetime,
        ..Tile::default()
    }
}

/// A display of stripes (lit, or dark) on which nothing moves.
struct Striped<'a> {
    display: Display<'a, Fixed>,
    time: u32,
    seed: u64,
    light: bool,
}

impl<'a> Striped<'a> {
    fn new(storage: &'a mut HeapStorage<Fixed>, rest: bool) -> Self {
        let config = Config {
            rest,
            ..Config::ADAPTIVE
        };
        let mut display = Display::new(config, SIZE, SIZE, storage.memory()).expect("it fits");
        display.hello(&unframed_wire::Hello {
            layout: Layout::Screen,
            objects: false,
            world: WorldFrame {
                origin: [0.0; 3],
                unit: 0.001,
            },
            ..hello(SIZE)
        });
        display.view(&scene::view(SIZE, 0.0));
        display.tile(&tiles(RESTS));
        Self {
            display,
            time: 0,
            seed: 1,
            light: true,
        }
    }

    fn refreshes(&mut self, count: u32) {
        for _ in 0..count {
            for _ in 0..SAMPLES {
                // Steele, Lea, Flood 2014, splitmix: any generator without a pattern in space.
                self.seed = self.seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
                let mixed = (self.seed ^ (self.seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                let along = |v: u64| (v % (16 * u64::from(SIZE))) as u16;
                let (x, y) = (along(mixed >> 40), along(mixed >> 20));
                let level = if self.light { stripe(u32::from(x)) } else { 0 };
                let rgb = [level; 3];
                self.display
                    .screen_sample(Tick(self.time), &ScreenSample { x, y, rgb });
            }
            self.time += REFRESH;
            let time = Tick(self.time);
            self.display.refresh(&Refresh { time, index: 0 });
        }
    }

    /// The root of the mean squared difference from the columns' means, sRGB codes.
    fn error(&self) -> f64 {
        let exact: Vec<f64> = columns()
            .iter()
            .map(|light| {
                f64::from(unframed_recon::config::Light::Linear.code(light.round() as u16))
            })
            .collect();
        let rows = self.display.picture().chunks(SIZE.into());
        let squares = rows.flat_map(|row| {
            row.iter()
                .zip(&exact)
                .map(|(pixel, exact)| (f64::from(pixel[1]) - exact).powi(2))
        });
        (squares.sum::<f64>() / f64::from(SAMPLES)).sqrt()
    }
}

#[test]
fn a_still_picture_converges_to_the_mean_of_each_pixel() {
    let mut storage = HeapStorage::new(SIZE, SIZE, 60 * SAMPLES as usize);
    let mut striped = Striped::new(&mut storage, true);
    let mut errors = Vec::new();
    for seconds in [1, 1, 2, 4, 8] {
        striped.refreshes(60 * seconds);
        errors.push(striped.error());
    }
    // With random places the error falls with the root of their number: by 0.71 for twice as many.
    assert!(
        errors.windows(2).all(|pair| pair[1] < 0.8 * pair[0]),
        "{errors:?}"
    );
    assert!(errors[4] < 2.7, "{errors:?}");
    let mut storage = HeapStorage::new(SIZE, SIZE, 60 * SAMPLES as usize);
    let mut filtered = Striped::new(&mut storage, false);
    filtered.refreshes(120);
    assert!(
        filtered.error() > 3.0 * errors[4],
        "filtering alone: {}",
        filtered.error()
    );
}

#[test]
fn light_that_goes_out_is_forgotten_where_the_tile_says_so() {
    let mut storage = HeapStorage::new(SIZE, SIZE, 60 * SAMPLES as usize);
    let mut striped = Striped::new(&mut storage, true);
    striped.refreshes(90);
    striped.light = false;
    // Nobody told: the means still speak.
    striped.refreshes(3);
    let lit = |striped: &Striped<'_>| {
        striped
            .display
            .picture()
            .iter()
            .filter(|p| p[0] > 20)
            .count()
    };
    assert!(lit(&striped) > 300);
    striped.display.tile(&tiles(LogCode(75)));
    striped.refreshes(12);
    assert_eq!(lit(&striped), 0);
    striped.display.tile(&tiles(RESTS));
    striped.refreshes(90);
    assert_eq!(lit(&striped), 0, "nothing of the old comes back");
}

#[test]
fn a_cut_is_a_new_beginning() {
    let mut storage = HeapStorage::new(SIZE, SIZE, 60 * SAMPLES as usize);
    let mut striped = Striped::new(&mut storage, true);
    striped.refreshes(90);
    striped.light = false;
    striped.display.cut();
    striped.refreshes(1);
    assert!(striped.display.picture().iter().all(|p| *p == [0; 3]));
}

/// Once settled, only the pixels that new samples fall into change.
#[test]
fn at_rest_a_sample_touches_its_pixel_alone() {
    let size = 64;
    let mut storage = HeapStorage::<Fixed>::new(size, size, 16_000);
    let mut display =
        Display::new(Config::ADAPTIVE, size, size, storage.memory()).expect("it fits");
    let mut show = Show::begin(&mut display, 16_000, false);
    let before = display.picture().to_vec();
    show.next(&mut display, false);
    display.refresh(&show.refresh());
    let changed = |display: &Display<'_, Fixed>, before: &[[u8; 3]]| {
        let pairs = display.picture().iter().zip(before);
        pairs.filter(|(a, b)| a != b).count()
    };
    let after = changed(&display, &before);
    assert!((1..=16_000 / 60).contains(&after), "{after} pixels changed");
    // Nothing new, nothing changed; an object that moves wakes all.
    let before = display.picture().to_vec();
    let mut refresh = show.refresh();
    refresh.time = refresh.time.after(REFRESH);
    display.refresh(&refresh);
    assert_eq!(changed(&display, &before), 0);
    for pose in scene::poses(0.1) {
        display.pose(&pose);
    }
    refresh.time = refresh.time.after(REFRESH);
    display.refresh(&refresh);
    assert!(changed(&display, &before) > 500);
}

#[test]
fn threads_do_not_change_what_rests() {
    let hashes = [1, 3].map(|threads| {
        let mut storage = HeapStorage::<Fixed>::new(70, 70, 9000);
        let workers = Threads::new(threads).expect("threads");
        let mut display =
            Display::with_workers(workers, Config::ADAPTIVE, 70, 70, storage.memory())
                .expect("it fits");
        let mut show = Show::begin(&mut display, 9000, false);
        let mut hashes = vec![frame_hash(display.picture())];
        show.next(&mut display, false);
        display.world_sample(
            Tick(0),
            &WorldSample {
                place: [0; 3],
                rgb: [1, 2, 3],
                object: 0,
                shares: Shares::default(),
            },
        );
        display.refresh(&show.refresh());
        hashes.push(frame_hash(display.picture()));
        hashes
    });
    assert_eq!(hashes[0], hashes[1]);
    assert_ne!(hashes[0][0], hashes[0][1]);
}
