//! Host and display together over bytes, against the ideal: one line of numbers.
//! `cargo run --release --example chain -- SCENE SAMPLER RATE SECONDS EVERY`
use std::time::Instant;
use glam::UVec2;
use unframed_host::drive::Host;
use unframed_host::sampler::{Sampler, adaptive::{Adaptive, Config as SamplerConfig}, uniform::{Place, Traditional, Uniform}};
use unframed_host::scene::builtin::builtin;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::{World, ideal};
use unframed_recon::{Config, Display, Fixed, Player, heap::HeapStorage, config::*};
use unframed_wire::{Layout, TileFields};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let arg = |i: usize, d: &str| args.get(i).cloned().unwrap_or(d.into());
    let scene = arg(0, "interactive");
    let rate: u32 = arg(2, "400000").parse().unwrap();
    let seconds: f64 = arg(3, "2").parse().unwrap();
    let every: u32 = arg(4, "4").parse().unwrap();
    let size = UVec2::new(256, 256);
    let open = || World::new(builtin(&scene).expect("builtin"), size.into()).unwrap();
    let mut reference = open();
    let mut truths = Vec::new();
    let a = Config::ADAPTIVE;
    let cases: Vec<(&str, &str, Config)> = vec![
        ("frameless", "traditional", Config::NEWEST),
        ("uniform", "uniform", Config::UNIFORM),
        ("uniform-same", "uniform", Config { lifetime: Lifetime::Constant(-256), ..a }),
        ("adaptive", "adaptive", a),
        ("ad life const", "adaptive", Config { lifetime: Lifetime::Constant(-256), ..a }),
        ("ad const fit", "adaptive", Config { fit: Fit::Constant, ..a }),
        ("ad encoded", "adaptive", Config { light: Light::Encoded, ..a }),
        ("ad nohidden", "adaptive", Config { hidden: false, ..a }),
        ("ad gaussian", "adaptive", Config { kernel: TimeKernel::Gaussian, ..a }),
    ];
    let filter = arg(1, "");
    for (name, sampler, config) in cases {
        if !name.contains(&filter) { continue; }
        let (sampler, layout): (Box<dyn Sampler>, _) = match sampler {
            "traditional" => (Box::new(Traditional::new(size, Place::Centre, 1)), Layout::Screen),
            "uniform" => (Box::new(Uniform::new(size, 1)), Layout::World),
            _ => (Box::new(Adaptive::new(size, SamplerConfig::default())), Layout::World),
        };
        let tile_fields = TileFields { gradients: false, lifetime: true, density: false };
        let mut host = Host::new(open(), sampler, Promise { layout, tile_fields, rate, refresh_millihertz: 60_000 });
        let mut storage = HeapStorage::<Fixed>::new(256, 256, 400_000);
        let display = Display::new(config, 256, 256, storage.memory()).unwrap();
        let mut player = Player::new(display);
        let (mut bytes, mut total, mut squares, mut n) = (Vec::new(), 0usize, 0.0, 0);
        let (mut host_time, mut display_time) = (0.0, 0.0);
        let mut samples = 0;
        for index in 0..(seconds * 60.0) as u32 {
            bytes.clear();
            let t = Instant::now();
            let progress = host.advance(&mut bytes).unwrap();
            host_time += t.elapsed().as_secs_f64();
            samples += progress.samples;
            total += bytes.len();
            let t = Instant::now();
            let mut input = &bytes[..];
            while player.push(&mut input).is_some() {}
            display_time += t.elapsed().as_secs_f64();
            if index % every == every - 1 {
                let k = (index / every) as usize;
                if truths.len() <= k { truths.push(ideal(&mut reference, progress.time, 4)); }
                let s: f64 = truths[k].iter().flatten().zip(player.display().picture().iter().flatten())
                    .map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
                squares += s / (65536.0 * 3.0);
                n += 1;
                if std::env::var("EACH").is_ok() { println!("  {:.3} {:.2}", progress.time, (s / (65536.0 * 3.0)).sqrt()); }
                if let Ok(dir) = std::env::var("OUT") {
                    let save = |what: &str, p: &[[u8; 3]]| {
                        let f = std::fs::File::create(format!("{dir}/{scene}-{}-{k}-{what}.png", name.replace(' ', "_"))).unwrap();
                        let mut e = png::Encoder::new(f, 256, 256);
                        e.set_color(png::ColorType::Rgb);
                        e.write_header().unwrap().write_image_data(p.as_flattened()).unwrap();
                    };
                    save("shown", player.display().picture());
                    save("ideal", &truths[k]);
                }
            }
        }
        if std::env::var("TAU").is_ok() {
            let mut taus: Vec<u8> = host.tiles().iter().filter_map(|n| if let unframed_wire::TileNode::Leaf(t) = n { Some(t.lifetime.0) } else { None }).collect();
            taus.sort();
            println!("  tiles {} lifetime codes {:?}", taus.len(), [0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0].map(|q| 2f64.powf((f64::from(taus[((taus.len() - 1) as f64 * q) as usize]) - 128.0) / 8.0)));
        }
        println!("{scene:12} {name:14} rmse {:6.2}  bytes/sample {:.2}  host {:.2} s  display {:.2} s", (squares / f64::from(n)).sqrt(), total as f64 / samples as f64, host_time, display_time);
    }
}
