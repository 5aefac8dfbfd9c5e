//! How much of an error is age: the same display, the same samples at the same places, but each
//! looked at again at the instant of the refresh. What error is left is due to anything else: to
//! few samples, to the filter, to places not sampled.

use std::collections::{BTreeMap, VecDeque};

use anyhow::{Context, Result};
use rayon::prelude::*;
use unframed_host::sampler::Shot;
use unframed_host::trace::{Hit, World, srgb};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Display, Fixed};
use unframed_wire::{Hello, Packet, Pose, Receiver, Refresh, SKY, Tick, Tile, View, WorldSample};

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
    /// As received, with the hit that was sent; the newest last, as many as a display remembers.
    samples: VecDeque<(Tick, WorldSample, Hit)>,
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

    /// Takes the bytes up to a refresh and the shots that went into them.
    pub fn receive(&mut self, mut bytes: &[u8], shots: &[Shot]) {
        let mut arrived: Vec<(Tick, WorldSample)> = Vec::new();
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
                    arrived.extend(samples.map(|sample| (time, sample)));
                }
                Packet::Cut(_) => {
                    self.samples.clear();
                    arrived.clear();
                }
                Packet::Refresh(refresh) => self.refresh = Some(refresh),
                _ => {}
            }
        }
        if !fresh_tiles.is_empty() {
            self.tiles = fresh_tiles;
        }
        // What was seen before a cut was not sent: the last ones were.
        let sent = &shots[shots.len().saturating_sub(arrived.len())..];
        let joined = arrived.into_iter().zip(sent);
        self.samples
            .extend(joined.map(|((time, sample), shot)| (time, sample, shot.hit)));
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
        let poses: Vec<_> = (0..world.object_count())
            .map(|k| world.pose(k as u8, time))
            .collect();
        let again = |(index, hit): (usize, &Hit)| {
            let offset = match poses.get(usize::from(hit.object)) {
                Some(pose) if hit.object != SKY => pose.transform_point3(hit.local) - camera.eye,
                _ => hit.local,
            };
            let (_, depth) = camera.project_direction(offset)?;
            let now = moment.look_along(offset / depth, index as u32);
            let there = hit.object == SKY || (now.depth - depth).abs() <= SAME_DEPTH * depth;
            (there && now.object == hit.object).then(|| srgb::encode8(now.colour))
        };
        let hits: Vec<Hit> = self.samples.iter().map(|sample| sample.2).collect();
        let colours: Vec<Option<[u8; 3]>> = hits.par_iter().enumerate().map(again).collect();

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
        for ((time, sample, _), colour) in self.samples.iter().zip(colours) {
            let rgb = colour.unwrap_or(sample.rgb);
            display.world_sample(*time, &WorldSample { rgb, ..*sample });
        }
        display.refresh(&refresh);
        Ok(display.picture().to_vec())
    }
}
