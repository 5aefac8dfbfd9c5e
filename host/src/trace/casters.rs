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
