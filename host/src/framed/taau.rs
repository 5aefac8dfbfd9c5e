//! Temporal antialiasing and upscaling, the renderer to beat: after Karis 2014 ("High-quality
//! temporal supersampling"), Salvi 2016 (variance clipping) and Yang, Liu & Salvi 2020 ("A survey
//! of temporal antialiasing techniques").
//!
//! At each refresh a frame of rate/60 samples is traced, its samples jittered together. Each pixel
//! of the panel finds its surface in a sample that fell into it, else in the history's own
//! surfaces, moved along, else in the samples around; follows it back to where the history has it,
//! exactly, by hit and pose; takes the history by Catmull-Rom interpolation, clips it to what the
//! new samples around allow, and adds the new samples by their distance. The frame is traced with the view one refresh interval
//! before it is shown, as [`super`] says, and is warped to the view and the poses of the refresh
//! at the last moment.

use glam::{Affine3A, IVec2, UVec2, Vec2, Vec3, Vec3A};
use rayon::prelude::*;
use unframed_wire::SKY;

use super::{Framed, REFRESH_HZ, render, resolution};
use crate::trace::camera::Camera;
use crate::trace::{Hit, World, srgb};

/// Settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Most samples that the history of a pixel counts for, above 0: long histories are sharp and
    /// free of noise, short ones follow changes. At a tenth of a sample a pixel and frame, 1 is
    /// about ten frames.
    pub history: f32,
    /// Standard deviation of a new sample's weight, pixels of the panel.
    pub sigma: f32,
    /// How many standard deviations of the new samples around the history may be off their mean.
    pub clip: f32,
}

impl Tuning {
    /// Follows changes: the better one where mirrors and highlights move. Tuned on the built-in
    /// scenes, as is [`Tuning::SHARP`]: of 20 settings these two together did best.
    pub const QUICK: Self = Self {
        history: 1.0,
        sigma: 0.6,
        clip: 2.0,
    };
    /// Keeps what it knows and hardly clips: the better one where surfaces keep their colours.
    pub const SHARP: Self = Self {
        history: 6.0,
        sigma: 0.45,
        clip: 100.0,
    };
}

/// A pixel of the history.
#[derive(Clone, Copy, Debug)]
struct Texel {
    /// Linear light.
    colour: Vec3,
    /// How many samples it counts for.
    count: f32,
    surface: Surface,
}

/// What a pixel shows, at its centre.
#[derive(Clone, Copy, Debug)]
struct Surface {
    object: u8,
    /// 1/metres along the axis; 0 is the sky.
    inverse_depth: f32,
}

const NOTHING: Texel = Texel {
    colour: Vec3::ZERO,
    count: 0.0,
    surface: Surface {
        object: SKY,
        inverse_depth: 0.0,
    },
};

/// Relative difference of depth within which two places are the same surface.
const SAME_DEPTH: f32 = 0.05;
/// Relative difference of depth from a sample to the next from which on they are not of a surface.
const STEEPEST: f32 = 0.2;
/// The weight of a sample far away, for pixels that have none nearby.
const FAR_WEIGHT: f32 = 1e-3;

/// The renderer.
pub struct Taau {
    world: World,
    size: UVec2,
    tuning: Tuning,
    frame: Low,
    /// Of the last frame, at the view of its instant.
    history: Vec<Texel>,
    /// The camera and the instant of the history.
    last: Option<(Camera, f64)>,
    picture: Vec<[u8; 3]>,
    samples: u64,
    count: u32,
}

impl Taau {
    /// With a budget of `rate` samples a second; `seed` decides where the jitter begins.
    #[must_use]
    pub fn new(world: World, rate: u32, tuning: Tuning, seed: u64) -> Self {
        let size = UVec2::from(world.size());
        let resolution = resolution(size, f64::from(rate) / REFRESH_HZ).min(size);
        let pixels = (size.x * size.y) as usize;
        Self {
            frame: Low {
                size,
                resolution,
                jitter: Vec2::ZERO,
                hits: Vec::new(),
                slopes: Vec::new(),
            },
            history: vec![NOTHING; pixels],
            picture: vec![[0; 3]; pixels],
            last: None,
            samples: 0,
            count: (seed % 64) as u32 * 97,
            world,
            size,
            tuning,
        }
    }

    /// Traces a frame of the instant `time` and adds it to the history.
    fn accumulate(&mut self, time: f64) {
        self.count += 1;
        self.frame.jitter = Vec2::new(halton(self.count, 2), halton(self.count, 3));
        let frame = &mut self.frame;
        render(
            &mut self.world,
            time,
            frame.resolution,
            frame.jitter,
            &mut frame.hits,
        );
        frame.measure_slopes();
        self.samples += frame.hits.len() as u64;
        let camera = self.world.camera(time);
        let past = self.last.map(|(past, then)| Past {
            back: Motion::new(&self.world, (&camera, time), (&past, then)),
            moved: self.move_surfaces(&Motion::new(&self.world, (&past, then), (&camera, time))),
            history: &self.history,
        });
        let (frame, tuning, size) = (&self.frame, &self.tuning, self.size);
        let blend = |i: usize| {
            let pixel = UVec2::new(i as u32 % size.x, i as u32 / size.x);
            frame.blend(pixel, past.as_ref(), tuning)
        };
        let next = (0..self.history.len())
            .into_par_iter()
            .with_min_len(256)
            .map(blend)
            .collect();
        self.history = next;
        self.last = Some((camera, time));
    }

    /// The history's surfaces in another view, where one of them falls into a pixel; the nearest
    /// counts.
    fn move_surfaces(&self, motion: &Motion) -> Vec<Option<Surface>> {
        let mut moved: Vec<Option<Surface>> = vec![None; self.history.len()];
        for (i, texel) in self.history.iter().enumerate() {
            let Some((at, inverse_depth)) = motion.carry(self.centre(i), texel.surface) else {
                continue;
            };
            if at.cmplt(Vec2::ZERO).any() || at.cmpge(self.size.as_vec2()).any() {
                continue;
            }
            let slot = &mut moved[(at.y as u32 * self.size.x + at.x as u32) as usize];
            if slot.is_none_or(|known| known.inverse_depth < inverse_depth) {
                *slot = Some(Surface {
                    inverse_depth,
                    ..texel.surface
                });
            }
        }
        moved
    }

    /// The centre of a pixel of the panel.
    fn centre(&self, i: usize) -> Vec2 {
        let i = i as u32;
        UVec2::new(i % self.size.x, i / self.size.x).as_vec2() + 0.5
    }

    /// Shows the history as seen at `time`.
    fn warp(&mut self, time: f64) {
        let Some((camera, then)) = self.last else {
            return;
        };
        let view = self.world.camera(time);
        let motion = Motion::new(&self.world, (&camera, then), (&view, time));
        let (size, history) = (self.size, &self.history);
        let centre = |i: usize| self.centre(i);
        let moved: Vec<Option<(Vec2, f32)>> = (0..history.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|i| motion.carry(centre(i), history[i].surface))
            .collect();
        let picture = (0..history.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|i| {
                let source = find_source(centre(i), &moved, size);
                srgb::encode8(catmull_rom(history, size, source).max(Vec3::ZERO))
            })
            .collect();
        self.picture = picture;
    }
}

impl Framed for Taau {
    fn show(&mut self, time: f64) -> f64 {
        let content = (time - 1.0 / REFRESH_HZ).max(0.0);
        self.accumulate(content);
        self.warp(time);
        content
    }

    fn picture(&self) -> &[[u8; 3]] {
        &self.picture
    }

    fn samples(&self) -> u64 {
        self.samples
    }
}

/// What a new frame is added to.
struct Past<'a> {
    /// From the new view to the history's.
    back: Motion,
    /// The history's surfaces in the new view.
    moved: Vec<Option<Surface>>,
    history: &'a [Texel],
}

/// A frame's samples.
struct Low {
    /// The panel's pixels.
    size: UVec2,
    /// The frame's.
    resolution: UVec2,
    /// Where in its pixel each sample lies, 0..1.
    jitter: Vec2,
    hits: Vec<Hit>,
    /// Change of inverse depth per pixel of the panel at each hit.
    slopes: Vec<Vec2>,
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
    fn measure_slopes(&mut self) {
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
    fn blend(&self, pixel: UVec2, past: Option<&Past<'_>>, tuning: &Tuning) -> Texel {
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

fn inverse_depth(hit: &Hit) -> f32 {
    if hit.object == SKY {
        0.0
    } else {
        1.0 / hit.depth.max(1e-6)
    }
}

/// Colour and count of a surface in the history at a place of its view, if the history has it.
fn recall(history: &[Texel], size: UVec2, at: Vec2, surface: Surface) -> Option<(Vec3, f32)> {
    if at.cmplt(Vec2::ZERO).any() || at.cmpge(size.as_vec2()).any() {
        return None;
    }
    let corner = at - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let (mut colour, mut count, mut weight, mut same) = (Vec3::ZERO, 0.0, 0.0, 0);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let texel = texel(history, size, base.x as i32 + dx, base.y as i32 + dy);
        if texel.count <= 0.0 || !is_same(texel.surface, surface) {
            continue;
        }
        let w = (if dx == 0 { 1.0 - f.x } else { f.x }) * (if dy == 0 { 1.0 - f.y } else { f.y });
        colour += texel.colour * w;
        count += texel.count * w;
        weight += w;
        same += 1;
    }
    if weight < 1e-3 {
        return None;
    }
    // Beyond an edge lies another surface: only what is of this one may be mixed.
    if same == 4 {
        colour = catmull_rom(history, size, at);
    } else {
        colour /= weight;
    }
    Some((colour, count / weight))
}

fn is_same(a: Surface, b: Surface) -> bool {
    a.object == b.object
        && (a.inverse_depth - b.inverse_depth).abs()
            <= SAME_DEPTH * a.inverse_depth.max(b.inverse_depth)
}

fn texel(history: &[Texel], size: UVec2, x: i32, y: i32) -> &Texel {
    let last = size.as_ivec2() - 1;
    &history[(y.clamp(0, last.y) * size.x as i32 + x.clamp(0, last.x)) as usize]
}

/// The history's colour at a place, interpolated over 4 × 4 texels.
fn catmull_rom(history: &[Texel], size: UVec2, at: Vec2) -> Vec3 {
    let corner = at - 0.5;
    let base = corner.floor();
    let weights = |f: f32| {
        [
            f * (-0.5 + f * (1.0 - 0.5 * f)),
            1.0 + f * f * (-2.5 + 1.5 * f),
            f * (0.5 + f * (2.0 - 1.5 * f)),
            f * f * (-0.5 + 0.5 * f),
        ]
    };
    let (wx, wy) = (weights(corner.x - base.x), weights(corner.y - base.y));
    let mut sum = Vec3::ZERO;
    for (dy, wy) in (-1..).zip(wy) {
        for (dx, wx) in (-1..).zip(wx) {
            let texel = texel(history, size, base.x as i32 + dx, base.y as i32 + dy);
            sum += texel.colour * (wx * wy);
        }
    }
    sum
}

/// Where in the history the surface lies that is seen at a place now: a fixed point of the
/// motion, from several starts, for near surfaces move over far ones.
fn find_source(at: Vec2, moved: &[Option<(Vec2, f32)>], size: UVec2) -> Vec2 {
    let last = size.as_vec2() - 1.0;
    let look = |q: Vec2| {
        let pixel = (q - 0.5).round().clamp(Vec2::ZERO, last);
        let target = moved[pixel.y as usize * size.x as usize + pixel.x as usize];
        target.map(|(to, inverse_depth)| (to - pixel - 0.5, inverse_depth))
    };
    const STARTS: [Vec2; 5] = [
        Vec2::ZERO,
        Vec2::new(3.0, 0.0),
        Vec2::new(-3.0, 0.0),
        Vec2::new(0.0, 3.0),
        Vec2::new(0.0, -3.0),
    ];
    let mut best = (f32::INFINITY, 0.0, at);
    for start in STARTS {
        let mut q = at + start;
        for _ in 0..3 {
            if let Some((motion, _)) = look(q) {
                q = at - motion;
            }
        }
        let Some((motion, inverse_depth)) = look(q) else {
            continue;
        };
        let off = (q + motion - at).length();
        // Among surfaces that do arrive here the nearest one is seen.
        let arrives = off < 0.75;
        let best_arrives = best.0 < 0.75;
        let better = match (arrives, best_arrives) {
            (true, true) => inverse_depth > best.1 * (1.0 + SAME_DEPTH),
            (false, false) => off < best.0,
            (arrives, _) => arrives,
        };
        if better {
            best = (off, inverse_depth, q);
        }
    }
    best.2
}

/// How surfaces move over the image from one instant to another.
struct Motion {
    /// For each object, its coordinates' movement through the world.
    objects: Vec<Affine3A>,
    from: Camera,
    to: Camera,
}

impl Motion {
    fn new(world: &World, from: (&Camera, f64), to: (&Camera, f64)) -> Self {
        let objects = (0..world.object_count())
            .map(|object| {
                let (now, then) = (
                    world.pose(object as u8, from.1),
                    world.pose(object as u8, to.1),
                );
                if object == 0 || !now.matrix3.determinant().is_normal() {
                    Affine3A::IDENTITY
                } else {
                    then * now.inverse()
                }
            })
            .collect();
        Self {
            objects,
            from: *from.0,
            to: *to.0,
        }
    }

    /// Where a surface seen at a place of the one view is in the other, and its inverse depth.
    fn carry(&self, at: Vec2, surface: Surface) -> Option<(Vec2, f32)> {
        let direction = Vec3A::from(self.from.direction(at));
        // The place is eye + direction/w; times w, so that the sky needs no case of its own.
        let w = surface.inverse_depth;
        let offset = match self.objects.get(usize::from(surface.object)) {
            Some(moved) => {
                let eye = moved.transform_point3a(self.from.eye.into());
                moved.matrix3 * direction + (eye - Vec3A::from(self.to.eye)) * w
            }
            None => direction,
        };
        let (pixel, depth) = self.to.project_direction(offset.into())?;
        Some((pixel, w / depth))
    }
}

/// The radical inverse of `index` (Halton 1964), 0..1.
fn halton(mut index: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0f64, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value as f32
}

/// Where a hit seen at a place at `now` is at `then`.
#[cfg(test)]
pub(super) fn carry_for_tests(
    world: &World,
    now: f64,
    then: f64,
    at: Vec2,
    hit: &Hit,
) -> Option<(Vec2, f32)> {
    let (from, to) = (world.camera(now), world.camera(then));
    let surface = Surface {
        object: hit.object,
        inverse_depth: inverse_depth(hit),
    };
    Motion::new(world, (&from, now), (&to, then)).carry(at, surface)
}
