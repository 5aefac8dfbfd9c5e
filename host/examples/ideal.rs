//! Writes ideal images: `cargo run --release -p unframed-host --example ideal -- SCENE OUT.png
//! [SECONDS] [SIZE] [SAMPLES]`.

use std::error::Error;
use std::path::Path;

use unframed_host::scene::builtin::{BUILTIN, builtin};
use unframed_host::scene::gltf::load;
use unframed_host::trace::{World, ideal};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [name, out, rest @ ..] = args.as_slice() else {
        return Err(format!(
            "usage: ideal SCENE OUT.png [SECONDS] [SIZE] [SAMPLES]; built in: {BUILTIN:?}"
        )
        .into());
    };
    let number = |i: usize, default: f64| rest.get(i).map_or(Ok(default), |s| s.parse::<f64>());
    let (t, size, n) = (
        number(0, 0.0)?,
        number(1, 512.0)? as u32,
        number(2, 3.0)? as u32,
    );
    let scene = match builtin(name) {
        Some(scene) => scene,
        None => load(Path::new(name), None)?.scene,
    };
    let mut world = World::new(scene, [size, size])?;
    let image = ideal(&mut world, t, n);
    let mut encoder = png::Encoder::new(std::fs::File::create(out)?, size, size);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder
        .write_header()?
        .write_image_data(image.as_flattened())?;
    Ok(())
}
