//! How much of an error is age: the same display, the same samples at the same places, but each
//! looked at again at the instant of the refresh. What error is left is due to anything else: to
//! few samples, to the filter, to places not sampled.

use std::collections::{BTreeMap, VecDeque};

use anyhow::{Context, Result};
use glam::DVec3;
use rayon::prelude::*;
use unframed_host::trace::{World, srgb};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Display, Fixed};
use unframed_wire::{
    Hello, Packet, Pose, Receiver, Refresh, SKY, Tick, Tile, View, WorldFrame, WorldSample,
};

use crate::panel::Order;

/// Depths that differ less than this, relatively, are of the same place.
const SAME_DEPTH: f32 = 0.02;

/// All that a display knows, ready to be shown again with other colours.
pub struct Oracle {
    order: Order,
    receiver: Receiver,
    hello: Option<Hello>,
    view: Option<View>,
    poses: BTreeMap<u8, Pose>,
    tiles: Vec<Tile>,
    refresh: Option<Refresh>,
    /// As received; the newest last, as many as a display remembers. A packet's samples stand in
    /// the order of their places, not of their shots: each says itself where it belongs.
    samples: VecDeque<(Tick, WorldSample)>,
}

impl Oracle {
    /// Of a display.
    #[must_use]
    pub fn new(order: Order) -> Self {
        Self {
            order,
            receiver: Receiver::new(),
            hello: None,
            view: None,
            poses: BTreeMap::new(),
            tiles: Vec::new(),
            refresh: None,
            samples: VecDeque::new(),
        }
    }

    /// Takes the bytes up to a refresh.
    pub fn receive(&mut self, mut bytes: &[u8]) {
        let mut fresh_tiles: Vec<Tile> = Vec::new();
        while let Some(packet) = self.receiver.push(&mut bytes) {
            match packet {
                Packet::Hello(hello) => self.hello = Some(hello),
                Packet::View(view) => self.view = Some(view),
                Packet::Poses(poses) => poses.for_each(|pose| {
                    self.poses.insert(pose.object, pose);
                }),
                Packet::Tiles(tiles) => fresh_tiles.extend(tiles),
                Packet::World(samples) => {
                    let time = samples.time();
                    self.samples.extend(samples.map(|sample| (time, sample)));
                }
                Packet::Cut(_) => self.samples.clear(),
                Packet::Refresh(refresh) => self.refresh = Some(refresh),
                _ => {}
            }
        }
        if !fresh_tiles.is_empty() {
            self.tiles = fresh_tiles;
        }
        let surplus = self
            .samples
            .len()
            .saturating_sub(self.order.samples as usize);
        self.samples.drain(..surplus);
    }

    /// What the display would show if all samples were of the instant `time` (seconds) of the
    /// last refresh. A place that cannot be seen any more keeps its colour.
    ///
    /// # Errors
    /// No refresh came yet, or the display cannot be set up.
    pub fn picture(&self, world: &World, time: f64) -> Result<Vec<[u8; 3]>> {
        let mut world = world.clone();
        world.prepare(time, time);
        let moment = world.moment(time);
        let camera = *moment.camera();
        let frame = self.hello.context("no Hello has come yet")?.world;
        let again = |(index, (_, sample)): (usize, &(Tick, WorldSample))| {
            let place = metres(self.poses.get(&sample.object)?, sample.place, &frame);
            let offset = (place - camera.eye.as_dvec3()).as_vec3();
            let (_, depth) = camera.project_direction(offset)?;
            let now = moment.look_along(offset / depth, index as u32);
            let there = sample.object == SKY || (now.depth - depth).abs() <= SAME_DEPTH * depth;
            (there && now.object == sample.object).then(|| srgb::encode8(now.colour))
        };
        let samples: Vec<(Tick, WorldSample)> = self.samples.iter().copied().collect();
        let colours: Vec<Option<[u8; 3]>> = samples.par_iter().enumerate().map(again).collect();

        let Order {
            config,
            width,
            height,
            samples,
            ..
        } = self.order;
        let mut storage = HeapStorage::<Fixed>::new(width, height, samples as usize);
        let mut display = Display::new(config, width, height, storage.memory())
            .context("cannot set up the display")?;
        let refresh = self.refresh.context("no refresh has come yet")?;
        if let Some(hello) = &self.hello {
            display.hello(hello);
        }
        if let Some(view) = &self.view {
            display.view(view);
        }
        self.poses.values().for_each(|pose| display.pose(pose));
        self.tiles.iter().for_each(|tile| display.tile(tile));
        for ((time, sample), colour) in self.samples.iter().zip(colours) {
            let rgb = colour.unwrap_or(sample.rgb);
            display.world_sample(*time, &WorldSample { rgb, ..*sample });
        }
        display.refresh(&refresh);
        Ok(display.picture().to_vec())
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
