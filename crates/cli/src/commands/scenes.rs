//! `unframed scenes`: what a scene calls for.

use anyhow::{Context, Result, bail};
use serde_json::json;
use unframed_host::scene::builtin::BUILTIN;
use unframed_host::scene::{Scene, calls, gltf, open};

use crate::args::ScenesArgs;

/// Tells the effects of a scene, or lists the built-in ones; exports.
///
/// # Errors
/// There is no such scene, or it cannot be written.
pub fn scenes(args: &ScenesArgs) -> Result<()> {
    let Some(name) = &args.scene else {
        if args.export.is_some() {
            bail!("say which scene to export: unframed scenes SCENE --export NAME.glb");
        }
        return list(args.json);
    };
    let opened = open::open(name, args.clip.as_deref())?;
    for warning in &opened.warnings {
        eprintln!("{name}: {warning}");
    }
    let scene = &opened.scene;
    if let Some(path) = &args.export {
        let bytes = gltf::export(scene)?;
        std::fs::write(path, &bytes).with_context(|| format!("cannot write {}", path.display()))?;
        eprintln!("{}: {} bytes", path.display(), bytes.len());
    }
    if args.json {
        println!("{}", as_json(scene));
    } else {
        tell(scene);
    }
    Ok(())
}

fn list(json: bool) -> Result<()> {
    let mut all = Vec::new();
    for name in BUILTIN {
        let scene = open::open(name, None)?.scene;
        if json {
            all.push(as_json(&scene));
        } else {
            tell(&scene);
            println!();
        }
    }
    if json {
        println!("{}", json!({ "scenes": all }));
    }
    Ok(())
}

fn triangles(scene: &Scene) -> usize {
    scene
        .meshes
        .iter()
        .flat_map(|mesh| &mesh.primitives)
        .map(|part| part.indices.len())
        .sum()
}

fn tell(scene: &Scene) {
    println!(
        "{}: {} triangles, loops every {} s",
        scene.name,
        triangles(scene),
        scene.duration
    );
    for effect in calls::effects(scene) {
        let mark = if effect.called_for { "yes" } else { " - " };
        println!("  {mark} {:18} {}", effect.name, effect.because);
    }
}

fn as_json(scene: &Scene) -> serde_json::Value {
    let effects: Vec<_> = calls::effects(scene)
        .into_iter()
        .map(|effect| {
            json!({
                "name": effect.name,
                "called_for": effect.called_for,
                "because": effect.because,
            })
        })
        .collect();
    json!({
        "scene": scene.name,
        "triangles": triangles(scene),
        "seconds": scene.duration,
        "effects": effects,
    })
}
