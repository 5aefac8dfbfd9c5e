//! What should have been seen at each refresh, and what is hard about each pixel; computed once
//! and kept on disk.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use glam::{Affine3A, Vec2};
use rayon::prelude::*;
use unframed_host::trace::{Hit, World, ideal};
use unframed_metrics::PixelClass;
use unframed_wire::SKY;

use super::store::{Key, slug, write_whole};
use crate::measure::REFRESH_HZ;
use crate::report::picture::png_bytes;

/// Raise this when the classes change: old files are not used any more. What the tracer makes of
/// the scene is in the key ([`probe`]).
const VERSION: u32 = 3;
/// Side of the picture that stands for the tracer in the key, pixels.
const PROBE: u32 = 32;
/// Its instants, seconds.
const PROBED: [f64; 2] = [0.0, 0.7];
/// "A moment ago", for pixel classes, seconds.
const MOMENT_AGO: f64 = 0.1;
/// The colours around (3 × 3 pixels) of a textured pixel span this many levels of 255.
const TEXTURE_SPAN: u8 = 16;
/// A place whose colour differs this much a moment ago, levels of 255, depends on the view.
const VIEW_CHANGE: f32 = 12.0;
/// Bend of inverse depth over three pixels, relative to it, from which on there is an edge.
const EDGE_BEND: f32 = 0.02;

/// What should have been seen at a refresh.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The instant, seconds.
    pub time: f64,
    /// The ideal image, sRGB codes.
    pub image: Vec<[u8; 3]>,
    /// What is hard about each pixel.
    pub classes: Vec<PixelClass>,
}

/// A directory with the references of one scene at one size.
#[derive(Clone, Debug)]
pub struct Cache {
    dir: PathBuf,
    key: Key,
    width: u32,
    height: u32,
    grid: u32,
}

/// The instant of a refresh, seconds.
#[must_use]
pub fn instant(index: u32) -> f64 {
    (f64::from(index) + 1.0) / f64::from(REFRESH_HZ)
}

impl Cache {
    /// Under `root`, for the scene of `world` (called `name`) at its size, with `grid` × `grid`
    /// samples a pixel. Makes the directory.
    ///
    /// # Errors
    /// Names the directory, or says what is wrong with the scene.
    pub fn new(root: &Path, name: &str, world: &World, grid: u32) -> Result<Self> {
        let [width, height] = world.size();
        let key = Key::of_scene(world.scene()).with(format_args!(
            "{width} {height} {REFRESH_HZ} {grid} {MOMENT_AGO} {VERSION} {}",
            probe(world, grid)?
        ));
        let dir = root.join(format!("{}-{key}", slug(name)));
        std::fs::create_dir_all(&dir)
            .with_context(|| format!("cannot make the directory {}", dir.display()))?;
        Ok(Self {
            dir,
            key,
            width,
            height,
            grid,
        })
    }

    /// Of all that the references depend on.
    #[must_use]
    pub fn key(&self) -> Key {
        self.key
    }

    /// Where its files are.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// What is stored of a refresh, if it is whole.
    #[must_use]
    pub fn stored(&self, index: u32) -> Option<Reference> {
        let image = read_png(&self.image_path(index), self.width, self.height)?;
        let codes = std::fs::read(self.class_path(index)).ok()?;
        let class = |code: &u8| PixelClass::ALL.get(usize::from(*code)).copied();
        let classes: Vec<PixelClass> = codes.iter().map(class).collect::<Option<_>>()?;
        let whole = classes.len() == image.len();
        whole.then(|| Reference {
            time: instant(index),
            image,
            classes,
        })
    }

    /// The reference of a refresh: the stored one, else computed on all threads and stored.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn reference(&self, world: &mut World, index: u32) -> Result<Reference> {
        if let Some(stored) = self.stored(index) {
            return Ok(stored);
        }
        let time = instant(index);
        let image = ideal(world, time, self.grid);
        let classes = classify(world, time, &image);
        let codes: Vec<u8> = classes.iter().map(|class| *class as u8).collect();
        write_whole(&self.class_path(index), &codes)?;
        let png = png_bytes(self.width as usize, self.height as usize, &image)?;
        write_whole(&self.image_path(index), &png)?;
        Ok(Reference {
            time,
            image,
            classes,
        })
    }

    fn image_path(&self, index: u32) -> PathBuf {
        self.dir.join(format!("ideal-{index:05}.png"))
    }

    fn class_path(&self, index: u32) -> PathBuf {
        self.dir.join(format!("classes-{index:05}.bin"))
    }
}

/// A key of what the tracer makes of the scene: of small ideal images. A change to what is traced
/// that moves light by a thousandth shows in hundreds of their 6144 codes.
fn probe(world: &World, grid: u32) -> Result<Key> {
    let mut world = World::new(world.scene().clone(), [PROBE; 2])?;
    let codes = PROBED.map(|t| ideal(&mut world, t, grid));
    Ok(Key::of_bytes(codes.concat().as_flattened()))
}

/// An RGB picture of this size, else nothing.
pub(crate) fn read_png(path: &Path, width: u32, height: u32) -> Option<Vec<[u8; 3]>> {
    let file = std::io::BufReader::new(std::fs::File::open(path).ok()?);
    let mut reader = png::Decoder::new(file).read_info().ok()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut bytes).ok()?;
    let fits =
        (info.width, info.height) == (width, height) && info.color_type == png::ColorType::Rgb;
    let (pixels, rest) = bytes[..info.buffer_size()].as_chunks::<3>();
    (fits && rest.is_empty()).then(|| pixels.to_vec())
}

/// The class of each pixel of the image seen at `time`, by what its centre hits there and how
/// the same place looked a moment ago. Leaves the world prepared for a moment ago.
pub fn classify(world: &mut World, time: f64, image: &[[u8; 3]]) -> Vec<PixelClass> {
    let [width, height] = world.size();
    let (w, h) = (width as usize, height as usize);
    let centre = |i: usize| Vec2::new((i % w) as f32, (i / w) as f32) + 0.5;
    world.prepare(time, time);
    let moment = world.moment(time);
    let hits: Vec<Hit> = (0..w * h)
        .into_par_iter()
        .map(|i| moment.look(centre(i), i as u32))
        .collect();
    let past = (time - MOMENT_AGO).max(0.0);
    world.prepare(past, past);
    let world = &*world;
    let objects = world.object_count() as u8;
    let then: Vec<Affine3A> = (0..objects).map(|k| world.pose(k, past)).collect();
    let moved: Vec<bool> = (0..objects)
        .map(|k| then[usize::from(k)] != world.pose(k, time))
        .collect();
    let motion = world.moves();
    let only_view_moves = !motion.objects && !motion.lights;
    let camera = world.camera(past);
    let moment = world.moment(past);
    let size = Vec2::new(width as f32, height as f32);
    let class = |i: usize| {
        let hit = &hits[i];
        let offset = match then.get(usize::from(hit.object)) {
            Some(pose) if hit.object != SKY => pose.transform_point3(hit.local) - camera.eye,
            _ => hit.local,
        };
        let seen = camera
            .project_direction(offset)
            .filter(|(at, _)| at.cmpge(Vec2::ZERO).all() && at.cmplt(size).all())
            .and_then(|(_, depth)| {
                let before = moment.look_along(offset / depth, i as u32);
                let near = hit.object == SKY || (before.depth - depth).abs() <= 0.01 * depth;
                (before.object == hit.object && near).then_some(before)
            });
        let Some(before) = seen else {
            return PixelClass::Disocclusion;
        };
        if moved
            .get(usize::from(hit.object))
            .is_some_and(|moved| *moved)
        {
            return PixelClass::Moving;
        }
        let change = levels(hit)
            .into_iter()
            .zip(levels(&before))
            .map(|(a, b)| (a - b).abs());
        let change = change.fold(0.0, f32::max);
        if hit.rays.bounce + hit.rays.refraction > 0 || (only_view_moves && change >= VIEW_CHANGE) {
            PixelClass::ViewDependent
        } else if is_edge(&hits, w, i) {
            PixelClass::Edge
        } else if span(image, w, i) >= TEXTURE_SPAN {
            PixelClass::Texture
        } else {
            PixelClass::Flat
        }
    };
    (0..w * h).into_par_iter().map(class).collect()
}

fn levels(hit: &Hit) -> [f32; 3] {
    hit.colour
        .to_array()
        .map(|c| 255.0 * unframed_host::trace::srgb::encode(c))
}

/// Whether the object changes from a pixel to one beside it, or its surface bends away. (The
/// inverse depth of a plane is linear on the screen.)
fn is_edge(hits: &[Hit], width: usize, i: usize) -> bool {
    let (x, y) = (i % width, i / width);
    let height = hits.len() / width;
    let inverse = |hit: &Hit| {
        if hit.object == SKY {
            0.0
        } else {
            1.0 / hit.depth
        }
    };
    let bends = |before: usize, after: usize| {
        let (a, b, c) = (&hits[before], &hits[i], &hits[after]);
        let bend = inverse(a) - 2.0 * inverse(b) + inverse(c);
        a.object != b.object || c.object != b.object || bend.abs() > EDGE_BEND * inverse(b)
    };
    (x > 0 && x + 1 < width && bends(i - 1, i + 1))
        || (y > 0 && y + 1 < height && bends(i - width, i + width))
}

/// By how many levels a channel varies over the 3 × 3 pixels around.
fn span(image: &[[u8; 3]], width: usize, i: usize) -> u8 {
    let (x, y) = (i % width, i / width);
    let height = image.len() / width;
    let (mut low, mut high) = ([255u8; 3], [0u8; 3]);
    for y in y.saturating_sub(1)..(y + 2).min(height) {
        for x in x.saturating_sub(1)..(x + 2).min(width) {
            for (c, value) in image[y * width + x].into_iter().enumerate() {
                low[c] = low[c].min(value);
                high[c] = high[c].max(value);
            }
        }
    }
    (0..3).map(|c| high[c] - low[c]).max().unwrap_or(0)
}
