//! How far one sample a pixel, taken at its middle and at the right instant, is from the ideal
//! image: what aliasing alone costs. `cargo run --release -p unframed-host --example one_sample
//! -- [SCENE…]`.

use std::error::Error;
use std::path::Path;

use unframed_host::scene::builtin::{BUILTIN, builtin};
use unframed_host::scene::gltf::load;
use unframed_host::trace::{World, ideal};

/// Instants over the loop.
const INSTANTS: u32 = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names = BUILTIN.map(String::from).to_vec();
    }
    for name in names {
        let scene = match builtin(&name) {
            Some(scene) => scene,
            None => load(Path::new(&name), None)?.scene,
        };
        let mut world = World::new(scene, [256, 256])?;
        let mut each = Vec::new();
        for i in 0..INSTANTS {
            let t = world.scene().duration * (f64::from(i) + 0.5) / f64::from(INSTANTS);
            let (one, many) = (ideal(&mut world, t, 1), ideal(&mut world, t, 4));
            let pairs = one.as_flattened().iter().zip(many.as_flattened());
            let sum: f64 = pairs.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
            each.push(sum / (3 * one.len()) as f64);
        }
        let mean = each.iter().sum::<f64>() / each.len() as f64;
        let roots: Vec<_> = each.iter().map(|e| format!("{:.1}", e.sqrt())).collect();
        println!("{name:16} RMSE {:6.2}   {}", mean.sqrt(), roots.join(" "));
    }
    Ok(())
}
