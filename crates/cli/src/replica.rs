//! All that a display knows, so that its picture can be made again with other colours or in other
//! arithmetic: what would it show if no sample were old, if there were plenty, if numbers were exact?

use std::collections::{BTreeMap, VecDeque};

use anyhow::{Context, Result};
use glam::DVec3;
use rayon::prelude::*;
use unframed_host::effects::care::Care;
use unframed_host::trace::{World, srgb};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Arith, Config, Display};
use unframed_wire::{
    Hello, Lamp, Packet, Pose, Receiver, Refresh, SKY, Tick, Tile, View, WorldFrame, WorldSample,
};

/// Depths that differ less than this, relatively, are of the same place.
const SAME_DEPTH: f32 = 0.02;
/// Refreshes whose views and poses are remembered: as many as a display looks back on
/// (`unframed_recon::motion`), and some.
const HISTORY: usize = 40;

/// Views and poses that came with one refresh.
#[derive(Clone, Debug, Default)]
struct Latch {
    view: Option<View>,
    poses: BTreeMap<u8, Pose>,
    lamps: Vec<Lamp>,
    refresh: Option<Refresh>,
}

/// The knowledge of a display of one size that remembers a number of samples.
#[derive(Debug)]
pub struct Replica {
    width: u16,
    height: u16,
    capacity: usize,
    receiver: Receiver,
    hello: Option<Hello>,
    now: Latch,
    /// The newest last.
    history: VecDeque<Latch>,
    tiles: Vec<Tile>,
    /// Object, part and triangles of what throws shadows.
    shapes: BTreeMap<(u8, u8), Vec<[[i16; 3]; 3]>>,
    /// As received; the newest last. A packet's samples stand in the order of their places, not
    /// of their shots: each says itself where it belongs.
    samples: VecDeque<(Tick, WorldSample)>,
}

impl Replica {
    /// Of a display of `width` × `height` pixels that remembers `capacity` samples.
    #[must_use]
    pub fn new(width: u16, height: u16, capacity: usize) -> Self {
        Self {
            width,
            height,
            capacity,
            receiver: Receiver::new(),
            hello: None,
            now: Latch::default(),
            history: VecDeque::new(),
            tiles: Vec::new(),
            shapes: BTreeMap::new(),
            samples: VecDeque::new(),
        }
    }

    /// Takes the bytes up to a refresh.
    pub fn receive(&mut self, mut bytes: &[u8]) {
        let mut fresh_tiles: Vec<Tile> = Vec::new();
        while let Some(packet) = self.receiver.push(&mut bytes) {
            match packet {
                Packet::Hello(hello) => self.hello = Some(hello),
                Packet::View(view) => self.now.view = Some(view),
                Packet::Poses(poses) => poses.for_each(|pose| {
                    self.now.poses.insert(pose.object, pose);
                }),
                Packet::Lamps(lamps) => self.now.lamps = lamps.collect(),
                Packet::Shape(shape) => {
                    let name = (shape.object(), shape.part());
                    self.shapes.insert(name, shape.collect());
                }
                Packet::Tiles(tiles) => fresh_tiles.extend(tiles),
                Packet::World(samples) => {
                    let time = samples.time();
                    self.samples.extend(samples.map(|sample| (time, sample)));
                }
                Packet::Cut(_) => {
                    self.samples.clear();
                    self.history.clear();
                }
                Packet::Refresh(refresh) => {
                    self.now.refresh = Some(refresh);
                    self.history.push_back(self.now.clone());
                    if self.history.len() > HISTORY {
                        self.history.pop_front();
                    }
                }
                _ => {}
            }
        }
        if !fresh_tiles.is_empty() {
            self.tiles = fresh_tiles;
        }
        let surplus = self.samples.len().saturating_sub(self.capacity);
        self.samples.drain(..surplus);
    }

    /// The samples' colours, oldest first.
    #[must_use]
    pub fn colours(&self) -> Vec<[u8; 3]> {
        self.samples.iter().map(|sample| sample.1.rgb).collect()
    }

    /// The colours that the samples would have if each had been taken at `time` (seconds), the
    /// instant of the last refresh. What cannot be seen any more keeps its colour.
    ///
    /// # Errors
    /// Nothing was received yet.
    pub fn fresh_colours(&self, world: &World, time: f64) -> Result<Vec<[u8; 3]>> {
        let mut world = world.clone();
        world.prepare(time, time);
        let moment = world.moment(time);
        let camera = *moment.camera();
        let hello = self.hello.context("no Hello has come yet")?;
        let frame = hello.world;
        // As the samples were taken: without the shadows that the display draws.
        let care = Care {
            open: hello.lamps > 0,
            ..Care::default()
        };
        let again = |(index, (_, sample)): (usize, &(Tick, WorldSample))| {
            let pose = self.now.poses.get(&sample.object)?;
            let place = metres(pose, sample.place, &frame);
            let offset = (place - camera.eye.as_dvec3()).as_vec3();
            let (_, depth) = camera.project_direction(offset)?;
            let (now, _) = moment.look_along_with(offset / depth, index as u32, care);
            let there = sample.object == SKY || (now.depth - depth).abs() <= SAME_DEPTH * depth;
            (there && now.object == sample.object).then(|| srgb::encode8(now.colour))
        };
        let samples: Vec<(Tick, WorldSample)> = self.samples.iter().copied().collect();
        Ok(samples
            .par_iter()
            .enumerate()
            .map(|sample| again(sample).unwrap_or(sample.1.1.rgb))
            .collect())
    }

    /// The picture of the last refresh by `config` in the arithmetic `A`, the samples in
    /// `colours`. Pixels of which nothing is known are black.
    ///
    /// # Errors
    /// No refresh came yet, or the display cannot be set up.
    pub fn picture<A: Arith>(&self, config: Config, colours: &[[u8; 3]]) -> Result<Vec<[u8; 3]>> {
        let mut storage = HeapStorage::<A>::new(self.width, self.height, self.capacity);
        let mut display = Display::new(config, self.width, self.height, storage.memory())
            .context("cannot set up the display")?;
        let hello = self.hello.context("no Hello has come yet")?;
        display.hello(&hello);
        let last = self.history.back().context("no refresh has come yet")?;
        for ((object, part), triangles) in &self.shapes {
            display.triangles(*object, *part, triangles);
        }
        for latch in self.history.range(..self.history.len() - 1) {
            latch.show(&mut display);
        }
        self.tiles.iter().for_each(|tile| display.tile(tile));
        for ((time, sample), rgb) in self.samples.iter().zip(colours) {
            display.world_sample(
                *time,
                &WorldSample {
                    rgb: *rgb,
                    ..*sample
                },
            );
        }
        last.show(&mut display);
        Ok(display.picture().to_vec())
    }
}

/// The picture that `config` makes in `f64` of a stream of one refresh, with the tiles that
/// `replica` knows: see [`crate::cost::stream::dense`].
///
/// # Errors
/// The display cannot be set up.
pub fn picture_of(
    stream: &[u8],
    samples: usize,
    replica: &Replica,
    config: Config,
) -> Result<Vec<[u8; 3]>> {
    let mut storage = HeapStorage::<f64>::new(replica.width, replica.height, samples);
    let mut display = Display::new(config, replica.width, replica.height, storage.memory())
        .context("cannot set up the display")?;
    let mut receiver = Receiver::new();
    let mut input = stream;
    while let Some(packet) = receiver.push(&mut input) {
        if matches!(packet, Packet::Refresh(_)) {
            replica.tiles.iter().for_each(|tile| display.tile(tile));
        }
        display.receive(packet);
    }
    Ok(display.picture().to_vec())
}

impl Latch {
    fn show<A: Arith>(&self, display: &mut Display<'_, A>) {
        if let Some(view) = &self.view {
            display.view(view);
        }
        self.poses.values().for_each(|pose| display.pose(pose));
        for (index, lamp) in self.lamps.iter().enumerate() {
            display.lamp(index, lamp);
        }
        if let Some(refresh) = &self.refresh {
            display.refresh(refresh);
        }
    }
}

/// Where a lattice point of an object is, metres in the author's coordinates.
fn metres(pose: &Pose, place: [i16; 3], frame: &WorldFrame) -> DVec3 {
    let one = f64::from(pose.frac_bits).exp2();
    let units: [f64; 3] = std::array::from_fn(|k| {
        let row = pose.matrix[k].iter().zip(place);
        let sum: f64 = row.map(|(m, q)| f64::from(*m) * f64::from(q)).sum();
        f64::from(pose.translation[k]) + sum / one
    });
    let origin = DVec3::from(frame.origin.map(f64::from));
    origin + DVec3::from(units) * f64::from(frame.unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Size, Source};
    use crate::eval::probes;
    use crate::measure::host;
    use crate::method::Method;
    use unframed_host::scene::builtin::builtin;
    use unframed_recon::{Fixed, Player};

    const SIDE: u16 = 48;
    const SAMPLES: usize = 4000;

    /// A stream's replica after `refreshes`, with the world and what a display showed.
    fn played(still: bool, refreshes: u32) -> (Replica, World, Vec<[u8; 3]>, f64) {
        let scene = builtin("interactive").unwrap();
        let scene = if still {
            probes::still(&scene, 0.0)
        } else {
            scene
        };
        let world = World::new(scene, [u32::from(SIDE); 2]).unwrap();
        let source = Source {
            scene: String::new(),
            clip: None,
            rate: 12_000,
            seconds: 1.0,
            size: Size {
                width: SIDE,
                height: SIDE,
            },
            seed: 1,
            method: Method::Adaptive,
            no_lamps: false,
        };
        let mut host = host(&source, Method::Adaptive, world.clone());
        let mut storage = HeapStorage::<Fixed>::new(SIDE, SIDE, SAMPLES);
        let display = Display::new(Config::ADAPTIVE, SIDE, SIDE, storage.memory()).unwrap();
        let mut player = Player::new(display);
        let mut replica = Replica::new(SIDE, SIDE, SAMPLES);
        let mut time = 0.0;
        for _ in 0..refreshes {
            let mut bytes = Vec::new();
            time = host.advance(&mut bytes).unwrap().time;
            replica.receive(&bytes);
            let mut input = &bytes[..];
            while player.push(&mut input).is_some() {}
        }
        (replica, world, player.display().picture().to_vec(), time)
    }

    fn mean_square(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
        let (a, b) = (a.as_flattened(), b.as_flattened());
        let square = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b)).powi(2);
        a.iter().zip(b).map(square).sum::<f64>() / a.len() as f64
    }

    #[test]
    fn a_replica_shows_what_the_display_shows() {
        // Long enough for the ring to wrap and for the view to move.
        let (replica, _, shown, _) = played(false, 50);
        let again = replica.picture::<Fixed>(Config::ADAPTIVE, &replica.colours());
        assert!(again.unwrap() == shown);
        let exact = replica
            .picture::<f64>(Config::ADAPTIVE, &replica.colours())
            .unwrap();
        let off = mean_square(&exact, &shown);
        assert!(off > 0.0 && off < 4.0, "{off}");
    }

    #[test]
    fn in_a_still_scene_nothing_is_old() {
        let (replica, world, _, time) = played(true, 30);
        let (sent, fresh) = (
            replica.colours(),
            replica.fresh_colours(&world, time).unwrap(),
        );
        let changed = |fresh: &[[u8; 3]], sent: &[[u8; 3]]| {
            let far = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|c| a[c].abs_diff(b[c]) > 8);
            fresh.iter().zip(sent).filter(|(a, b)| far((a, b))).count() as f64 / sent.len() as f64
        };
        // A lattice point may lie just beside what was hit.
        assert!(changed(&fresh, &sent) < 0.03, "{}", changed(&fresh, &sent));
        let (replica, world, _, time) = played(false, 50);
        let (sent, fresh) = (
            replica.colours(),
            replica.fresh_colours(&world, time).unwrap(),
        );
        assert!(changed(&fresh, &sent) > 0.03, "{}", changed(&fresh, &sent));
    }

    #[test]
    fn plenty_of_samples_show_nearly_the_ideal() {
        let (replica, world, shown, time) = played(false, 50);
        let ideal = unframed_host::trace::ideal(&mut world.clone(), time, 4);
        let (stream, samples) = crate::cost::stream::dense(&world, time).unwrap();
        let plenty = picture_of(&stream, samples, &replica, Config::ADAPTIVE).unwrap();
        let (plenty, few) = (mean_square(&plenty, &ideal), mean_square(&shown, &ideal));
        assert!(plenty < 0.5 * few, "{plenty} {few}");
    }
}
