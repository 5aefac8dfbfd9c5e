//! A laboratory for samplers: variants of the knobs against the ideal picture, through the real
//! stream and the real integer display. For tuning; what counts is `unframed eval`.
//!
//! `cargo run --release -p unframed-host --example sampler_lab -- [scenes=a,b.glb] [rate=400000]
//! [seconds=3] [png=FOLDER] [VARIANT …]`, a variant being `name:knob=value,knob=value` with the
//! fields of [`Config`] as knobs, or `uniform=LIFETIME` (seconds) for uniform samples through the
//! same display, and `lamps=0` for samples with all shadows in them. A variant whose name begins with `paper` is the method of Dayal et al. 2005 with
//! its own display, and has the fields of [`paper::Config`] as knobs. Ideal pictures are kept in `target/` (or `LAB_CACHE`) between runs.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use glam::UVec2;
use unframed_host::drive::Host;
use unframed_host::sampler::adaptive::{Adaptive, Config};
use unframed_host::sampler::paper::{self, Paper};
use unframed_host::sampler::uniform::Uniform;
use unframed_host::sampler::{Eye, Sampler, Shot, Span};
use unframed_host::scene::{builtin, open};
use unframed_host::stream::sender::Promise;
use unframed_host::trace::{self, World};
use unframed_recon::config::{Extents, Fit, Lifetime};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Display, Fixed, Player};
use unframed_wire::{Layout, Status, TileFields, TileNode};

const SIZE: UVec2 = UVec2::new(256, 256);
const HERTZ: u32 = 60;
/// Refreshes that are compared: every eleventh, so that no phase of the animation is favoured.
const EVERY: u32 = 11;
/// Samples the display remembers, seconds' worth.
const REMEMBERED: f64 = 1.25;

type Picture = Vec<[u8; 3]>;

/// The ideal pictures of a scene and the refreshes they belong to.
fn ideals(name: &str, world: &World, seconds: f64) -> Vec<(u32, Picture)> {
    let folder = std::env::var("LAB_CACHE").unwrap_or_else(|_| "target".into());
    let mut world = world.clone();
    (EVERY..=(seconds * f64::from(HERTZ)) as u32)
        .step_by(EVERY as usize)
        .map(|refresh| {
            let file = PathBuf::from(&folder).join(format!("ideal8-{name}-{refresh}.rgb"));
            let stored = std::fs::read(&file).ok();
            let picture = stored.map_or_else(
                || {
                    let time = f64::from(refresh) / f64::from(HERTZ);
                    let picture = trace::ideal(&mut world, time, 4);
                    std::fs::write(&file, picture.as_flattened()).ok();
                    picture
                },
                |bytes| bytes.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
            );
            (refresh, picture)
        })
        .collect()
}

/// The sampler under test, kept in sight.
struct Watched<S>(Arc<Mutex<S>>);

impl<S> Clone for Watched<S> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<S> Watched<S> {
    fn with<R>(&self, work: impl FnOnce(&mut S) -> R) -> R {
        work(&mut self.0.lock().expect("one thread uses it"))
    }
}

impl<S: Sampler> Sampler for Watched<S> {
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>) {
        self.with(|s| s.epoch(span, eye, out));
    }

    fn preferred_span(&self) -> f64 {
        self.with(|s| s.preferred_span())
    }

    fn tiles(&mut self, fields: TileFields, out: &mut Vec<TileNode>) {
        self.with(|s| s.tiles(fields, out));
    }

    fn take_cut(&mut self) -> Option<f64> {
        self.with(|s| s.take_cut())
    }

    fn looks_ahead(&self) -> bool {
        self.with(|s| s.looks_ahead())
    }

    fn status(&mut self, status: &Status) {
        self.with(|s| s.status(status));
    }
}

/// Sets a knob by its name.
fn turn(config: &mut Config, key: &str, number: f32) {
    let on = number != 0.0;
    match key {
        "span" => config.span = f64::from(number),
        "slack" => config.slack = number,
        "batch" => config.batch = f64::from(number),
        "uniform_share" => config.uniform_share = number,
        "verify_share" => config.verify_share = number,
        "residuals" => config.residuals = on,
        "water_filling" => config.water_filling = on,
        "lifetimes" => config.lifetimes = on,
        "cuts" => config.cuts = on,
        "ahead" => config.ahead = on,
        "residual_memory" => config.residual_memory = number,
        "gradient_memory" => config.gradient_memory = number,
        "residual_prior" => config.residual_prior = number,
        "prior_weight" => config.prior_weight = number,
        "residual_floor" => config.residual_floor = number,
        "recovery" => config.recovery = number,
        "lifetime_max" => config.lifetime_max = number,
        "lifetime_min" => config.lifetime_min = number,
        "balanced" => config.balanced = on,
        "tolerance" => config.tolerance = number,
        "code_tolerance" => config.code_tolerance = number as u32,
        "pattern" => config.pattern = number as u16,
        "seed" => config.seed = number as u64,
        _ => panic!("{key}: no such knob"),
    }
}

/// The same for the paper's method.
fn turn_paper(config: &mut paper::Config, key: &str, number: f64) {
    let on = number != 0.0;
    match key {
        "arms" => config.arms = on,
        "adapt" => config.adapt = on,
        "decline" => config.decline = number,
        "depth" => config.depth = number as u16,
        "chunk" => config.chunk = number as u32,
        "moves" => config.moves = number as u32,
        "hysteresis" => config.hysteresis = number,
        "gain" => config.gain = on,
        "tiles" => config.tiles = number as u32,
        "least_tiles" => config.least_tiles = number as u32,
        "most_tiles" => config.most_tiles = number as u32,
        "importance" => config.importance = number,
        "finest" => config.finest = number as u16,
        "reprojections" => config.reprojections = number as u32,
        "occlusion" => config.occlusion = on,
        "occlusion_cost" => config.occlusion_cost = number,
        "kappa" => config.kappa = number,
        "lambda" => config.lambda = number,
        "undersampled" => config.undersampled = number,
        "least_interval" => config.least_interval = number,
        "seed" => config.seed = number as u64,
        _ => panic!("{key}: no such knob"),
    }
}

/// Sets a knob of the display: `sigma` pixels (0: each sample for its own pixel) and `lifetime` seconds everywhere, `hidden`, `fill`, `linear`.
fn turn_display(config: &mut unframed_recon::Config, key: &str, number: f32) {
    let log = (number.log2() * 256.0) as i16;
    match key {
        "sigma" if number == 0.0 => config.extents = Extents::Pixel,
        "sigma" => config.extents = Extents::Constant(log),
        "lifetime" => config.lifetime = Lifetime::Constant(log),
        "hidden" => config.hidden = number != 0.0,
        "fill" => config.fill = number != 0.0,
        "linear" if number == 0.0 => config.fit = Fit::Constant,
        "linear" => config.fit = Fit::Linear,
        _ => panic!("display_{key}: no such knob"),
    }
}

/// What a run showed.
struct Outcome {
    each: Vec<f64>,
    bytes_per_sample: f64,
    note: String,
}

fn run(
    world: &World,
    truth: &[(u32, Picture)],
    rate: u32,
    variant: &str,
    save: impl Fn(u32, &[[u8; 3]]),
) -> Outcome {
    let (name, knobs) = variant.split_once(':').unwrap_or((variant, ""));
    let mut config = Config::default();
    let mut published = name.starts_with("paper").then(paper::Config::default);
    let mut uniform = None;
    let mut lamps = true;
    let mut recon = unframed_recon::Config::ADAPTIVE;
    for knob in knobs.split(',').filter(|k| !k.is_empty()) {
        let (key, value) = knob.split_once('=').unwrap_or((knob, "1"));
        let number: f32 = value
            .parse()
            .unwrap_or_else(|_| panic!("{knob}: not a number"));
        if let Some(config) = &mut published {
            turn_paper(config, key, number.into());
        } else if key == "lamps" {
            lamps = number != 0.0;
        } else if key == "uniform" {
            uniform = Some(number);
        } else if let Some(key) = key.strip_prefix("display_") {
            turn_display(&mut recon, key, number);
        } else {
            turn(&mut config, key, number);
        }
    }
    let watched = Watched(Arc::new(Mutex::new(Adaptive::new(SIZE, config))));
    let published = published.map(|c| Watched(Arc::new(Mutex::new(Paper::new(SIZE, c)))));
    let sampler: Box<dyn Sampler> = match (uniform, &published) {
        (_, Some(published)) => {
            recon = unframed_recon::Config::PAPER;
            Box::new(published.clone())
        }
        (Some(lifetime), _) => {
            recon.lifetime = Lifetime::Constant((lifetime.log2() * 256.0) as i16);
            Box::new(Uniform::new(SIZE, 1))
        }
        (None, None) => Box::new(watched.clone()),
    };
    let promise = Promise {
        layout: Layout::World,
        lamps: lamps && published.is_none(),
        tile_fields: TileFields {
            gradients: published.is_some(),
            lifetime: uniform.is_none() && published.is_none(),
            density: published.is_some(),
        },
        rate,
        refresh_millihertz: HERTZ * 1000,
    };
    let mut host = Host::new(world.clone(), sampler, promise);
    let (width, height) = (SIZE.x as u16, SIZE.y as u16);
    let remembered = (f64::from(rate) * REMEMBERED) as usize;
    let mut storage = HeapStorage::<Fixed>::new(width, height, remembered);
    let display = Display::new(recon, width, height, storage.memory()).expect("a display");
    let mut player = Player::new(display);
    let mut each = Vec::new();
    let (mut bytes, mut samples) = (0, 0);
    let mut stream = Vec::new();
    for (refresh, picture) in truth {
        loop {
            stream.clear();
            let progress = host.advance(&mut stream).expect("a stream");
            bytes += stream.len();
            samples += progress.samples;
            let mut input = stream.as_slice();
            while player.push(&mut input).is_some() {}
            if progress.index + 1 == *refresh {
                break;
            }
        }
        let shown = player.display().picture();
        each.push(rms(shown, picture));
        save(*refresh, shown);
    }
    let note = match (uniform, &published) {
        (_, Some(published)) => published.with(|s| note_of_paper(s)),
        (Some(_), _) => String::new(),
        (None, None) => watched.with(|s| note(s)),
    };
    Outcome {
        each,
        bytes_per_sample: bytes as f64 / samples as f64,
        note,
    }
}

fn note(sampler: &Adaptive) -> String {
    let s = sampler.stats();
    let [warp, plan, trace, learn] = s.seconds.map(|t| t * 1e6 / s.shots as f64);
    format!(
        "us/shot warp {warp:.2} plan {plan:.2} learn {learn:.2} trace {trace:.2}; failed {:.0} % \
         warps {} cells {} k cover {:.2} cuts {}",
        100.0 * s.failed as f64 / s.verifications.max(1) as f64,
        s.warps,
        s.cells / 1000,
        s.coverage,
        s.cuts
    )
}

fn note_of_paper(sampler: &Paper) -> String {
    let s = sampler.stats();
    let [plan, trace, learn, adjust] = s.seconds.map(|t| t * 1e6 / s.samples as f64);
    format!(
        "us/sample plan {plan:.2} learn {learn:.2} adjust {adjust:.2} trace {trace:.2}; occluded \
         {:.1} % of {} k tests, {} tiles, {} k stored, moves {:?}",
        100.0 * s.occluded as f64 / s.tests.max(1) as f64,
        s.tests / 1000,
        s.tiles,
        s.stored / 1000,
        s.moves
    )
}

fn rms(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    let square = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b)).powi(2);
    let sum: f64 = a
        .as_flattened()
        .iter()
        .zip(b.as_flattened())
        .map(square)
        .sum();
    (sum / (3 * a.len()) as f64).sqrt()
}

fn write_png(path: &Path, picture: &[[u8; 3]]) {
    let file = std::fs::File::create(path).expect("the folder exists");
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), SIZE.x, SIZE.y);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer
        .write_image_data(picture.as_flattened())
        .expect("an image");
}

fn main() {
    let mut scenes = builtin::ANIMATIONS.join(",");
    let (mut rate, mut seconds, mut folder) = (400_000.0, 3.0, None);
    let mut variants = Vec::new();
    for argument in std::env::args().skip(1) {
        match argument.split_once('=') {
            Some(("scenes", list)) => scenes = list.to_owned(),
            Some(("rate", number)) => rate = number.parse().expect("a rate"),
            Some(("seconds", number)) => seconds = number.parse().expect("seconds"),
            Some(("png", path)) => folder = Some(PathBuf::from(path)),
            _ => variants.push(argument),
        }
    }
    if variants.is_empty() {
        variants = vec!["uniform:uniform=0.5".into(), "adaptive".into()];
    }
    for scene in scenes.split(',') {
        let opened = open::open(scene, None).unwrap_or_else(|error| panic!("{error}"));
        let world = World::new(opened.scene, SIZE.to_array()).expect("a scene that loads is sound");
        let scene = Path::new(scene).file_stem().and_then(|s| s.to_str());
        let scene = scene.expect("a name");
        let truth = ideals(scene, &world, seconds);
        for variant in &variants {
            let name = variant.split(':').next().unwrap_or("x");
            let outcome = run(&world, &truth, rate as u32, variant, |refresh, picture| {
                if let Some(folder) = &folder {
                    write_png(
                        &folder.join(format!("{scene}-{name}-{refresh}.png")),
                        picture,
                    );
                }
            });
            if let Some(folder) = &folder {
                for (refresh, picture) in &truth {
                    write_png(
                        &folder.join(format!("{scene}-ideal-{refresh}.png")),
                        picture,
                    );
                }
            }
            let each = &outcome.each;
            let mut sorted = each.clone();
            sorted.sort_by(f64::total_cmp);
            let mean = each.iter().map(|e| e * e).sum::<f64>() / each.len() as f64;
            println!(
                "{scene:12} {variant:32} rms {:6.2} median {:6.2} B/sample {:.2} {}",
                mean.sqrt(),
                sorted[sorted.len() / 2],
                outcome.bytes_per_sample,
                outcome.note
            );
            if std::env::var("LAB_EACH").is_ok() {
                println!("    {each:.1?}");
            }
        }
    }
}
