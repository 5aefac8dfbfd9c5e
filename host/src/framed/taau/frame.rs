//! A frame of few samples, and how it is added to the history.

use glam::{IVec2, UVec2, Vec2, Vec3};

use super::Tuning;
use super::history::{SAME_DEPTH, Surface, Texel, inverse_depth, recall};
use super::motion::Motion;
use crate::trace::Hit;

/// Relative difference of depth from a sample to the next from which on they are not of a surface.
const STEEPEST: f32 = 0.2;
/// The weight of a sample far away, for pixels that have none nearby.
const FAR_WEIGHT: f32 = 1e-3;

/// What a new frame is added to.
pub(super) struct Past<'a> {
    /// From the new view to the history's.
    pub(super) back: Motion,
    /// The history's surfaces in the new view.
    pub(super) moved: Vec<Option<Surface>>,
    pub(super) history: &'a [Texel],
}

/// A frame's samples.
pub(super) struct Low {
    /// The panel's pixels.
    pub(super) size: UVec2,
    /// The frame's.
    pub(super) resolution: UVec2,
    /// Where in its pixel each sample lies, 0..1.
    pub(super) jitter: Vec2,
    pub(super) hits: Vec<Hit>,
    /// Change of inverse depth per pixel of the panel at each hit.
    pub(super) slopes: Vec<Vec2>,
}

impl Low {
    /// Pixels of the panel from one sample to the next.
    fn step(&self) -> Vec2 {
        self.size.as_vec2() / self.resolution.as_vec2()
    }

    fn index(&self, x: i32, y: i32) -> usize {
        let last = self.resolution.as_ivec2() - 1;
        (y.clamp(0, last.y) * self.resolution.x as i32 + x.clamp(0, last.x)) as usize
    }

    /// Where a sample lies on the panel.
    fn place(&self, index: usize) -> Vec2 {
        let i = index as u32;
        let pixel = UVec2::new(i % self.resolution.x, i / self.resolution.x).as_vec2();
        (pixel + self.jitter) * self.step()
    }

    /// The inverse depth of a plane is linear on the screen; of the differences to both sides the
    /// smaller one is on the surface.
    pub(super) fn measure_slopes(&mut self) {
        let step = self.step();
        let difference = |a: usize, b: usize| {
            let (from, to) = (&self.hits[a], &self.hits[b]);
            let change = inverse_depth(to) - inverse_depth(from);
            let steep = change.abs() > STEEPEST * inverse_depth(from).max(inverse_depth(to));
            (a != b && from.object == to.object && !steep).then_some(change)
        };
        let smaller = |a: Option<f32>, b: Option<f32>| match (a, b) {
            (Some(a), Some(b)) => {
                if a.abs() < b.abs() {
                    a
                } else {
                    b
                }
            }
            (a, b) => a.or(b).unwrap_or(0.0),
        };
        self.slopes = (0..self.hits.len())
            .map(|i| {
                let (x, y) = (
                    (i as u32 % self.resolution.x) as i32,
                    (i as u32 / self.resolution.x) as i32,
                );
                let along = |dx: i32, dy: i32| {
                    smaller(
                        difference(self.index(x - dx, y - dy), i),
                        difference(i, self.index(x + dx, y + dy)),
                    )
                };
                Vec2::new(along(1, 0), along(0, 1)) / step
            })
            .collect();
    }

    /// The surface of a sample, continued to a place of the panel nearby.
    fn surface(&self, sample: usize, at: Vec2) -> Surface {
        let here = inverse_depth(&self.hits[sample]);
        let there = here + self.slopes[sample].dot(at - self.place(sample));
        Surface {
            object: self.hits[sample].object,
            // Not beyond what the neighbours can show: slopes at corners are wrong.
            inverse_depth: there.clamp(0.5 * here, 2.0 * here),
        }
    }

    /// The new texel of a pixel.
    pub(super) fn blend(&self, pixel: UVec2, past: Option<&Past<'_>>, tuning: &Tuning) -> Texel {
        let centre = pixel.as_vec2() + Vec2::splat(0.5);
        let step = self.step();
        let nearest = (centre / step - self.jitter).round().as_ivec2();
        let (mut sum, mut weight, mut close) = (Vec3::ZERO, 0.0f32, 0.0f32);
        let (mut mean, mut square) = (Vec3::ZERO, Vec3::ZERO);
        let own = self.index(nearest.x, nearest.y);
        let (mut front, mut behind) = (own, own);
        // At the border the window moves inwards, so that no sample counts twice.
        let last = self.resolution.as_ivec2() - 1;
        let middle = nearest.max(IVec2::ONE).min(last - 1).max(IVec2::ZERO);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let i = self.index(middle.x + dx, middle.y + dy);
                let hit = &self.hits[i];
                let off = (self.place(i) - centre).length_squared();
                let near = (-0.5 * off / (tuning.sigma * tuning.sigma)).exp();
                let far = (-2.0 * off / step.length_squared()).exp();
                let w = near + FAR_WEIGHT * far + 1e-9;
                sum += hit.colour * w;
                weight += w;
                close += near;
                mean += hit.colour / 9.0;
                square += hit.colour * hit.colour / 9.0;
                if inverse_depth(hit) > inverse_depth(&self.hits[front]) {
                    front = i;
                }
                if inverse_depth(hit) < inverse_depth(&self.hits[behind]) {
                    behind = i;
                }
            }
        }
        let new = sum / weight;
        let own_surface = self.surface(own, centre);
        let fresh = Texel {
            colour: new,
            count: (close + FAR_WEIGHT).min(1.0),
            surface: own_surface,
        };
        let Some(past) = past else { return fresh };
        // What is behind all that is seen around has come to be hidden. What is in front of it all
        // is too thin for these samples, but nothing contradicts it.
        let farthest = inverse_depth(&self.hits[behind]) * (1.0 - SAME_DEPTH);
        let nearest = inverse_depth(&self.hits[front]) * (1.0 + SAME_DEPTH);
        let moved = past.moved[(pixel.y * self.size.x + pixel.x) as usize]
            .filter(|surface| surface.inverse_depth >= farthest);
        let falls_here = (self.place(own) - centre).abs().max_element() < 0.5;
        let around = [own, front, behind].map(|sample| Some(self.surface(sample, centre)));
        let [own, front, behind] = around;
        let candidates = if falls_here {
            [own, moved, front, behind]
        } else {
            [moved, own, front, behind]
        };
        let found = candidates.into_iter().flatten().find_map(|surface| {
            let (at, inverse_depth) = past.back.carry(centre, surface)?;
            let then = Surface {
                inverse_depth,
                ..surface
            };
            Some((surface, recall(past.history, self.size, at, then)?))
        });
        let Some((surface, (old, count))) = found else {
            return fresh;
        };
        let deviation = (square - mean * mean).max(Vec3::ZERO).map(f32::sqrt) * tuning.clip;
        let old = if surface.inverse_depth > nearest {
            old
        } else {
            // The new colour itself is always allowed.
            old.clamp((mean - deviation).min(new), (mean + deviation).max(new))
        };
        let count = count.min(tuning.history);
        let total = count + fresh.count;
        Texel {
            colour: (old * count + new * fresh.count) / total,
            count: total.min(tuning.history),
            surface,
        }
    }
}
