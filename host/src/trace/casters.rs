//! What throws shadows that a display can draw itself, and from which lamps.
//!
//! A display that knows the shapes of what moves finds its shadows at the instant of a refresh
//! ([`unframed_wire::Lamp`]), if the host sends samples as they are without them. That goes for hard
//! shadows of what is rigid: movers whose surface stops all light, before lamps without an area. All
//! others stay in the samples.

use glam::Vec3A;
use unframed_wire::LAMPS;

use super::geometry::Geometry;
use super::light::Lamp;
use crate::scene::model::Material;

/// Triangles of all shapes together.
const TRIANGLES: usize = 1 << 13;
/// Triangles of one shape: 32 parts, of which each has at least 97 triangles, or is the last.
const EACH: usize = 3000;
/// Shapes.
const CASTERS: usize = 16;

/// The shadows that are left to the display.
#[derive(Clone, Debug, Default)]
pub(crate) struct Casters {
    /// Indices of the lamps, at most [`LAMPS`].
    pub(crate) lamps: Vec<usize>,
    /// Of each mover: its shape is known to the display. Empty where none is.
    pub(crate) movers: Vec<bool>,
}

impl Casters {
    /// Chooses: the largest shapes for which there is room, and the lamps that bring most at `centre`.
    pub(crate) fn choose(
        movers: &[Geometry],
        is_object: impl Fn(usize) -> bool,
        materials: &[Material],
        glowing: &[bool],
        lamps: &[Lamp],
        strength: impl Fn(&Lamp) -> f32,
    ) -> Self {
        let (mut room, mut count) = (TRIANGLES, 0);
        let mut casts = vec![false; movers.len()];
        for (mover, casts) in casts.iter_mut().enumerate() {
            let len = shape(&movers[mover], materials, glowing).map_or(0, |shape| shape.len());
            if is_object(mover) && (1..=EACH.min(room)).contains(&len) && count < CASTERS {
                *casts = true;
                room -= len;
                count += 1;
            }
        }
        let mut ranked: Vec<usize> = (0..lamps.len()).filter(|&l| !lamps[l].is_area()).collect();
        ranked.sort_by(|&a, &b| strength(&lamps[b]).total_cmp(&strength(&lamps[a])));
        ranked.truncate(LAMPS);
        ranked.sort_unstable();
        if count == 0 || ranked.is_empty() {
            return Self::default();
        }
        Self {
            lamps: ranked,
            movers: casts,
        }
    }

    /// A lamp's number among those of the display.
    pub(crate) fn position(&self, lamp: usize) -> Option<usize> {
        self.lamps.iter().position(|&own| own == lamp)
    }

    /// Whether a mover's shadows are left to the display.
    pub(crate) fn contains(&self, mover: usize) -> bool {
        self.movers.get(mover).copied().unwrap_or(false)
    }
}

/// The triangles of a mover that stop light; `None` if some let a part of it through.
pub(crate) fn shape(
    mover: &Geometry,
    materials: &[Material],
    glowing: &[bool],
) -> Option<Vec<[Vec3A; 3]>> {
    let mut triangles = Vec::new();
    for (corners, attributes) in mover.triangles() {
        let index = attributes.material as usize;
        let material = &materials[index];
        if material.transmission >= 0.5 || glowing[index] {
            continue;
        }
        if material.alpha_cutoff.is_some() {
            return None;
        }
        triangles.push(corners);
    }
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};
    use unframed_wire::Shares;

    use crate::effects::care::Care;
    use crate::scene::builtin::builtin;
    use crate::trace::World;

    /// Colours with all shadows in them against colours without those of what moves, from which the
    /// light is taken of the lamps that a mover hides.
    #[test]
    fn shares_say_what_a_shadow_takes() {
        for (name, shaded_at_least) in [("interactive", 60), ("walkthrough", 60), ("toycar", 20)] {
            let scene = builtin(name).expect("a built-in scene");
            let mut world = World::new(scene, [96, 96]).expect("a sound scene");
            assert_eq!(world.lamps_left(), 2, "{name}");
            let (mut shaded, mut off, mut count) = (0, 0.0f32, 0);
            for time in [0.2, 0.9, 1.6] {
                world.prepare(time, time);
                let moment = world.moment(time);
                for i in 0..96 * 96 {
                    let pixel = Vec2::new((i % 96) as f32, (i / 96) as f32) + 0.5;
                    let (closed, _) = moment.look_with(pixel, i, Care::default());
                    let open = Care {
                        open: true,
                        ..Care::default()
                    };
                    let (open, _) = moment.look_with(pixel, i, open);
                    assert_eq!(closed.shares, Shares::default());
                    assert_eq!((open.object, open.local), (closed.object, closed.local));
                    if open.colour == closed.colour {
                        continue;
                    }
                    shaded += 1;
                    // Which lamps are hidden follows from the nearest of the three possibilities.
                    let part = |lamp| {
                        let left = f32::from(15 - open.shares.code(lamp)) / 15.0;
                        1.0 - left * left
                    };
                    let possible = [part(0), part(1), (part(0) + part(1)).min(1.0)];
                    let error = |taken: f32| {
                        let shown = |light: f32| light.max(0.0).powf(1.0 / 2.2);
                        let green = open.colour.y * (1.0 - taken);
                        (shown(green) - shown(closed.colour.y)).abs()
                    };
                    off += possible.into_iter().map(error).fold(f32::MAX, f32::min);
                    count += 1;
                    assert!(closed.colour.cmple(open.colour + Vec3::splat(1e-5)).all());
                }
            }
            assert!(
                shaded >= shaded_at_least,
                "{name}: {shaded} in shadows of movers"
            );
            let mean = off / count as f32;
            assert!(mean < 0.03, "{name}: shadows are {mean} off");
        }
    }

    #[test]
    fn where_nothing_moves_nothing_is_left_to_the_display() {
        let mut scene = builtin("interactive").expect("a built-in scene");
        scene.channels.clear();
        scene.duration = 0.0;
        let world = World::new(scene, [16, 16]).expect("a sound scene");
        assert_eq!(world.lamps_left(), 0);
    }
}
