//! Shaded samples a second on one thread: `cargo run --release -p unframed-host --example
//! trace_rate -- [SCENE…]`. Each sample has its own pixel and its own instant, as in the sampler:
//! 400 a millisecond. All rays are counted, so that builds with and without `--no-default-features`
//! can be compared.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use glam::Vec2;
use unframed_host::scene::builtin::{BUILTIN, builtin};
use unframed_host::scene::gltf::load;
use unframed_host::trace::{Rays, World};

fn main() -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names = BUILTIN.map(String::from).to_vec();
    }
    println!(
        "scene            triangles objects  Msamples/s  rays/sample (shadow, bounce)  prepare µs"
    );
    for name in names {
        let scene = match builtin(&name) {
            Some(scene) => scene,
            None => load(Path::new(&name), None)?.scene,
        };
        let mut world = World::new(scene, [256, 256])?;
        let (epochs, each) = (1000, 400);
        let duration = world.scene().duration.max(1.0);
        let (mut rays, mut preparing) = (Rays::default(), 0.0);
        let mut state = 1u32;
        let start = Instant::now();
        for epoch in 0..epochs {
            let t0 = duration * f64::from(epoch) / f64::from(epochs);
            let before = Instant::now();
            world.prepare(t0, t0 + 1e-3);
            preparing += before.elapsed().as_secs_f64();
            for i in 0..each {
                let mut next = || {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 8) as f32 / 65_536.0
                };
                let pixel = Vec2::new(next(), next());
                let moment = world.moment(t0 + 1e-3 * f64::from(i) / f64::from(each));
                let hit = moment.look(pixel, state);
                rays += hit.rays;
            }
        }
        let seconds = start.elapsed().as_secs_f64() - preparing;
        let n = f64::from(rays.primary);
        println!(
            "{:16} {:9} {:7} {:11.3}  {:.2} ({:.2}, {:.2}) {:25.1} {:10} rays",
            world.scene().name,
            world.triangle_count(),
            world.object_count(),
            n / seconds * 1e-6,
            f64::from(rays.total()) / n,
            f64::from(rays.shadow + rays.soft) / n,
            f64::from(rays.bounce + rays.refraction) / n,
            preparing / f64::from(epochs) * 1e6,
            rays.total(),
        );
    }
    Ok(())
}
