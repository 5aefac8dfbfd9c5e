//! What deciding where to look costs beside looking: shares of the host's time, without a display.
//!
//! `RAYON_NUM_THREADS=1 cargo run --release -p unframed-host --example control -- [scenes=a,b]
//! [rate=400000] [seconds=2] [runs=5]`. All runs do the same: the least time that any of them took
//! counts, refresh by refresh, so that other programs on the machine disturb less.

use glam::UVec2;
use unframed_host::drive::{Host, Spent};
use unframed_host::sampler::adaptive::{Adaptive, Config};
use unframed_host::scene::builtin;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::World;
use unframed_wire::{Layout, TileFields};

const SIZE: UVec2 = UVec2::new(256, 256);

/// Scene, tracing, warp, control, stream: seconds.
type Times = [f64; 5];

fn times(spent: Spent) -> Times {
    [
        spent.scene,
        spent.tracing,
        spent.reprojection,
        spent.control,
        spent.stream,
    ]
}

/// Lowers the times of each refresh to those of another run.
fn run(world: &World, rate: u32, least: &mut [Times]) {
    let promise = Promise {
        layout: Layout::World,
        lamps: true,
        tile_fields: TileFields {
            gradients: false,
            lifetime: true,
            density: false,
        },
        rate,
        refresh_millihertz: 60_000,
    };
    let sampler = Box::new(Adaptive::new(SIZE, Config::default()));
    let mut host = Host::new(world.clone(), sampler, promise);
    let mut stream = Vec::new();
    for least in least {
        let before = times(host.spent());
        stream.clear();
        host.advance(&mut stream).expect("a stream");
        let after = times(host.spent());
        for (least, (before, after)) in least.iter_mut().zip(before.into_iter().zip(after)) {
            *least = least.min(after - before);
        }
    }
}

fn main() {
    let mut scenes = builtin::ANIMATIONS.join(",");
    let (mut rate, mut seconds, mut runs) = (400_000.0, 2.0, 5.0);
    for argument in std::env::args().skip(1) {
        let Some((key, value)) = argument.split_once('=') else {
            panic!("{argument}: not of the form key=value");
        };
        let number = || value.parse::<f64>().expect("a number");
        match key {
            "scenes" => scenes = value.to_owned(),
            "rate" => rate = number(),
            "seconds" => seconds = number(),
            "runs" => runs = number(),
            _ => panic!("{key}: no such setting"),
        }
    }
    println!("us a sample:   scene  tracing  warp  control  stream   warp and control, share");
    for scene in scenes.split(',') {
        let model = builtin::builtin(scene).unwrap_or_else(|| panic!("{scene}: no such scene"));
        let world = World::new(model, SIZE.to_array()).expect("a built-in scene is sound");
        let mut least = vec![[f64::INFINITY; 5]; (60.0 * seconds) as usize];
        for _ in 0..runs as u32 {
            run(&world, rate as u32, &mut least);
        }
        let sums: Times = std::array::from_fn(|k| least.iter().map(|times| times[k]).sum());
        let a_sample = |t: f64| 1e6 * t / (rate * seconds);
        let [view, tracing, warp, control, stream] = sums.map(a_sample);
        println!(
            "{scene:12} {view:8.2} {tracing:8.2} {warp:5.2} {control:8.2} {stream:7.2} {:10.1} %",
            100.0 * (warp + control) / (view + tracing + warp + control + stream)
        );
    }
}
