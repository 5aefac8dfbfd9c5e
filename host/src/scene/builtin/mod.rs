//! Scenes made in code, after the test animations of Dayal et al. 2005 (§7).

mod atelier;
mod effects;
mod interactive;
mod shapes;
mod stage;
mod toycar;
mod walkthrough;

use crate::scene::model::Scene;

/// Names of the built-in scenes.
pub const BUILTIN: [&str; 11] = [
    "interactive",
    "walkthrough",
    "toycar",
    "atelier",
    "stress",
    "cornell",
    "office",
    "forest",
    "slats",
    "cornell-mist",
    "forest-mist",
];

/// Scenes that call for soft shadows and media.
pub const EFFECTS: [&str; 6] = [
    "cornell",
    "office",
    "forest",
    "slats",
    "cornell-mist",
    "forest-mist",
];

/// The animations that methods are compared on.
pub const ANIMATIONS: [&str; 3] = ["interactive", "walkthrough", "toycar"];

/// A built-in scene by name.
#[must_use]
pub fn builtin(name: &str) -> Option<Scene> {
    match name {
        "interactive" => Some(interactive::scene()),
        "walkthrough" => Some(walkthrough::scene()),
        "toycar" => Some(toycar::scene()),
        "atelier" => Some(atelier::scene()),
        "stress" => Some(interactive::stress()),
        "cornell" => Some(effects::cornell("cornell", false)),
        "cornell-mist" => Some(effects::cornell("cornell-mist", true)),
        "office" => Some(effects::office()),
        "forest" => Some(effects::forest("forest", false)),
        "forest-mist" => Some(effects::forest("forest-mist", true)),
        "slats" => Some(effects::slats()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::World;
    use glam::{Vec2, Vec3};

    const STEP: f64 = 1.0 / 60.0;

    #[test]
    fn cameras_keep_clear_of_surfaces_and_loop_without_a_jump() {
        for name in [&ANIMATIONS[..], &["atelier", "stress"]].concat() {
            let mut world = World::new(builtin(name).unwrap(), [64, 64]).unwrap();
            let duration = world.scene().duration;
            let mut nearest = f32::INFINITY;
            for i in 0..(duration / STEP).round() as u32 {
                let t = f64::from(i) * STEP;
                let (now, next) = (world.camera(t), world.camera(t + STEP));
                assert!(now.eye.distance(next.eye) < 0.25, "{name} jumps at {t}");
                assert!(now.forward.dot(next.forward) > 0.9, "{name} jerks at {t}");
                world.prepare(t, t);
                let moment = world.moment(t);
                // A sphere of directions (golden spiral).
                for k in 0..64 {
                    let y = 1.0 - (k as f32 + 0.5) / 32.0;
                    let (sin, cos) = (k as f32 * 2.399_963).sin_cos();
                    let r = (1.0 - y * y).sqrt();
                    let struck = moment.closest(now.eye, Vec3::new(r * cos, y, r * sin));
                    nearest = nearest.min(struck.map_or(f32::INFINITY, |s| s.t));
                }
            }
            assert!(
                nearest > 0.12,
                "{name} comes within {nearest} m of something"
            );
        }
    }

    #[test]
    fn each_scene_has_what_it_promises() {
        for (name, view) in [
            ("interactive", true),
            ("walkthrough", true),
            ("toycar", false),
            ("atelier", true),
            ("stress", true),
        ] {
            let mut world = World::new(builtin(name).unwrap(), [64, 64]).unwrap();
            assert_eq!(world.moves().view, view, "{name}");
            assert!(world.moves().objects, "{name}");
            assert!((1_000..20_000).contains(&world.triangle_count()), "{name}");
            // Dark and bright pixels, lit ones and shadowed, reflections: contrast everywhere.
            let image = crate::trace::ideal(&mut world, 1.7, 1);
            let bright = image.iter().filter(|p| p[1] > 150).count();
            let dark = image.iter().filter(|p| p[1] < 70).count();
            assert!(bright > 100 && dark > 100, "{name}: {bright} {dark}");
            world.prepare(1.7, 1.7);
            let bounces: u32 = (0..4096)
                .map(|i| Vec2::new((i % 64) as f32, (i / 64) as f32) + 0.5)
                .map(|p| world.moment(1.7).look(p, 0).rays.bounce)
                .sum();
            assert!(bounces > 0, "{name} shows no mirror");
        }
        assert!(builtin("no such scene").is_none());
    }

    #[test]
    fn the_interactive_camera_rests_and_dashes_within_every_two_seconds() {
        let world = World::new(builtin("interactive").unwrap(), [64, 64]).unwrap();
        let change = |t: f64| {
            let (a, b) = (world.camera(t), world.camera(t + STEP));
            a.eye.distance(b.eye) + a.forward.distance(b.forward)
        };
        let steps: Vec<f32> = (0..480).map(|i| change(f64::from(i) * STEP)).collect();
        for (i, window) in steps.windows(120).enumerate() {
            assert!(window.iter().any(|&c| c < 1e-5), "no rest from frame {i}");
            assert!(
                window.iter().any(|&c| c > 0.04),
                "nothing fast from frame {i}"
            );
        }
    }
}
