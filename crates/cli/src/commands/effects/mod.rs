//! `unframed effects`: the tables of Dubla et al. 2009 in shape, on scenes of ours.
//!
//! Columns are methods: `adaptive` (guidance by the noise that the filter leaves), `listings`
//! (guidance of the paper, its AIS), `all` (A-MAX: every pattern refined as far as it goes) and
//! `plain` (interleaved sampling with the same number of samples everywhere, as near as whole
//! numbers come to what `adaptive` took).

mod convergence;
mod strips;

use std::time::Instant;

use anyhow::{Context, Result};
use serde_json::{Value, json};
use unframed_host::effects::framed::{Frame, MOST, Refinement, render_with};
use unframed_host::effects::reference::reference;
use unframed_host::scene::open;
use unframed_host::trace::{World, srgb};
use unframed_metrics::{Image, Viewing, flip, rmse};

use super::{bar, make_out};
use crate::args::EffectsArgs;
use crate::report::Picture;

/// The components, in the order of [`Refinement::Plain`].
const COMPONENTS: [&str; 3] = ["soft_shadows", "indirect_diffuse", "medium"];

/// A method's frame of a scene.
struct Found {
    name: &'static str,
    frame: Frame,
    /// The quickest frame, seconds.
    seconds: f64,
}

/// Renders, compares, writes `report.json` and pictures, prints the tables.
///
/// # Errors
/// A scene cannot be opened, a file not be written.
pub fn effects(args: &EffectsArgs) -> Result<()> {
    make_out(&args.out)?;
    let mut rows = Vec::new();
    let progress = bar(args.scenes.len() as u64, "effects");
    println!(
        "adaptive / listings / all / plain:\n\
         | scene | ms | speed-up | Mray | fewer rays | RMSE | FLIP | FLIP over all |\n\
         |---|---|---|---|---|---|---|---|"
    );
    for name in &args.scenes {
        rows.push(scene(args, name)?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let number = |row: &Value, at: &str| row.pointer(at).and_then(Value::as_f64);
    let mean = |of: &dyn Fn(&Value) -> Option<f64>| {
        let all: Vec<f64> = rows.iter().filter_map(of).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    let against_all = |method: &str, what: &str| {
        let of = |r: &Value, m: &str| number(r, &format!("/methods/{m}/{what}"));
        mean(&|r| Some(of(r, method)? / of(r, "all")?))
    };
    let mut means = serde_json::Map::new();
    for method in ["adaptive", "listings", "plain"] {
        let inverse = |what: &str| {
            let of = |r: &Value, m: &str| number(r, &format!("/methods/{m}/{what}"));
            mean(&|r| Some(of(r, "all")? / of(r, method)?))
        };
        let (speed_up, rays) = (inverse("seconds"), inverse("rays"));
        let (rmse, flip) = (against_all(method, "rmse"), against_all(method, "flip"));
        println!(
            "mean of {method} against all: speed-up {speed_up:.2}, rays {rays:.2} times fewer, \
             RMSE x {rmse:.3}, FLIP x {flip:.3}"
        );
        means.insert(
            method.into(),
            json!({ "speed_up": speed_up, "fewer_rays": rays, "rmse": rmse, "flip": flip }),
        );
    }
    let slopes = if args.pictures {
        strips::strips(&args.out)?;
        convergence::convergence(&args.out)?
    } else {
        Value::Null
    };
    let report = json!({
        "size": [args.size.width, args.size.height],
        "reference_paths": args.reference,
        "pattern": args.pattern,
        "scenes": rows,
        "against_all": means,
        "convergence": slopes,
    });
    let path = args.out.join("report.json");
    std::fs::write(&path, serde_json::to_vec_pretty(&report)?)
        .with_context(|| format!("cannot write {}", path.display()))
}

/// A scene's row.
fn scene(args: &EffectsArgs, name: &str) -> Result<Value> {
    let scene = open::open(name, None)?.scene;
    let size = [args.size.width, args.size.height].map(u32::from);
    let mut world = World::new(scene, size)?;
    let slug = world.scene().name.clone();
    let truth = reference(&mut world, args.at, args.reference);
    let ideal = Picture::new(size[0] as usize, size[1] as usize, codes(&truth))?;
    ideal.write_png(&args.out.join(format!("{slug}-reference.png")))?;

    let adaptive = timed(args, &mut world, "adaptive", Refinement::Adaptive);
    let like = COMPONENTS.map(|component| {
        let layer = adaptive.frame.layers.iter().find(|l| l.name == component);
        layer.map_or(1, |l| l.mean().round() as u32)
    });
    let all = timed(args, &mut world, "all", Refinement::All);
    let listings = timed(args, &mut world, "listings", Refinement::Listings);
    let plain = timed(args, &mut world, "plain", Refinement::Plain(like));
    let methods_in_order = [&adaptive, &listings, &all, &plain];
    let mut methods = serde_json::Map::new();
    let mut errors = Vec::new();
    for found in methods_in_order {
        let shown = Picture::new(
            size[0] as usize,
            size[1] as usize,
            codes(&found.frame.light),
        )?;
        shown.write_png(&args.out.join(format!("{slug}-{}.png", found.name)))?;
        let (a, b) = (view(&ideal)?, view(&shown)?);
        let (rmse, flip) = (rmse(a, b)?, flip(a, b, Viewing::default())?);
        errors.push((rmse, flip));
        let layers: serde_json::Map<_, _> = found
            .frame
            .layers
            .iter()
            .map(|l| (l.name.to_owned(), json!(l.mean())))
            .collect();
        let by_effect: serde_json::Map<_, _> = found
            .frame
            .rays
            .by_effect()
            .into_iter()
            .map(|(effect, rays)| (effect.to_owned(), json!(rays)))
            .collect();
        methods.insert(
            found.name.to_owned(),
            json!({
                "seconds": found.seconds, "rays": found.frame.rays.total(), "by_effect": by_effect,
                "samples_per_pixel": layers, "rmse": rmse, "flip": flip,
            }),
        );
    }
    for layer in &adaptive.frame.layers {
        let map: Vec<[u8; 3]> = layer.samples.iter().map(|&n| heat(n)).collect();
        let width = layer.width as usize;
        let picture = Picture::new(width, map.len() / width, map)?;
        picture.write_png(&args.out.join(format!("{slug}-{}.png", layer.name)))?;
    }
    let list = |of: &dyn Fn(usize) -> String| (0..4).map(of).collect::<Vec<_>>().join(" / ");
    let seconds = methods_in_order.map(|f| f.seconds);
    let rays = methods_in_order.map(|f| f64::from(f.frame.rays.total()));
    println!(
        "| {slug} | {} | {:.2} | {} | {:.2} | {} | {} | {:.2} |",
        list(&|i| format!("{:.1}", seconds[i] * 1e3)),
        seconds[2] / seconds[0],
        list(&|i| format!("{:.2}", rays[i] * 1e-6)),
        rays[2] / rays[0],
        list(&|i| format!("{:.2}", errors[i].0)),
        list(&|i| format!("{:.4}", errors[i].1)),
        errors[0].1 / errors[2].1,
    );
    Ok(json!({ "scene": slug, "methods": methods }))
}

fn view(picture: &Picture) -> Result<Image<'_>> {
    Ok(Image::new(
        picture.pixels(),
        picture.width(),
        picture.height(),
    )?)
}

/// Blue where one sample sufficed, red where it did not, the brighter the more (the paper's
/// Figs 3 to 5).
fn heat(samples: u8) -> [u8; 3] {
    let more = u32::from(samples.saturating_sub(1));
    if more == 0 {
        return [20, 30, 130];
    }
    [(75 + 180 * more / (MOST - 1)).min(255) as u8, 20, 20]
}

fn codes(light: &[glam::Vec3]) -> Vec<[u8; 3]> {
    light.iter().map(|&l| srgb::encode8(l)).collect()
}

fn timed(
    args: &EffectsArgs,
    world: &mut World,
    name: &'static str,
    refinement: Refinement,
) -> Found {
    let mut frame = render_with(world, args.at, refinement, args.pattern);
    let mut seconds = f64::INFINITY;
    for _ in 0..args.frames.max(1) {
        let clock = Instant::now();
        frame = render_with(world, args.at, refinement, args.pattern);
        seconds = seconds.min(clock.elapsed().as_secs_f64());
    }
    Found {
        name,
        frame,
        seconds,
    }
}
