//! The display: takes packets in, shows pictures.
//!
//! It never asks for anything and trusts nothing: what it cannot place or does not understand is
//! counted and left out.

use crate::arith::{Arith, Moments, Panel, Projected, Sums};
use crate::config::{Config, Mode};
use crate::deep::{DeepBuffer, Placing, Stored, slot};
use crate::fill;
use crate::light::Lights;
use crate::memory::{Calls, Memory, Needs, SetupError, Slot};
use crate::motion::{Motion, Reach};
use crate::rest::{self, Mean, Rest, Step};
use crate::tiles::TileMap;
use crate::transform::{pose_is_sound, view_is_sound};
use crate::workers::{Alone, Workers};
use unframed_wire::{
    Hello, Lamp, Layout, Packet, Pose, Refresh, ScreenSample, Shape, Shares, Tick, Tile, View,
    WorldSample,
};

/// Stands in before the first View: nothing can be placed then.
const NO_VIEW: View = View {
    time: Tick(0),
    eye: [0; 3],
    rows: [[0; 3]; 3],
    frac_bits: 0,
};

/// What a display has received, and what became of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples stored or shown.
    pub samples: u64,
    /// Samples that could not be placed: no Hello, view or pose for them, or outside the panel.
    pub unplaced: u64,
    /// Packets whose contents are out of range or do not fit this panel.
    pub refused: u64,
    /// Pictures made.
    pub refreshes: u64,
}

/// The first `len` entries of a slice that was found to be long enough: no path that panics, even
/// where a compiler does not see that.
fn first<T>(slice: &mut [T], len: usize) -> &mut [T] {
    slice.get_mut(..len).unwrap_or(&mut [])
}

/// A display with its storage.
#[derive(Debug)]
pub struct Display<'a, A: Arith, W: Workers = Alone> {
    pub(crate) config: Config,
    pub(crate) workers: W,
    pub(crate) panel: Panel,
    pub(crate) deep: DeepBuffer<'a>,
    pub(crate) tiles: TileMap<'a>,
    pub(crate) projected: &'a mut [Projected<A>],
    pub(crate) sorted: &'a mut [Projected<A>],
    pub(crate) starts: &'a mut [u32],
    pub(crate) minima: &'a mut [A::Depth],
    pub(crate) limits: &'a mut [A::Depth],
    pub(crate) movers: &'a mut [u8],
    pub(crate) mass: &'a mut [A::Mass],
    pub(crate) logs: &'a mut [A::Log],
    pub(crate) sums: &'a mut [Sums<A>],
    pub(crate) moments: &'a mut [Moments<A>],
    pub(crate) texels: &'a mut [crate::arith::Texel<A>],
    pyramid: &'a mut [crate::arith::Texel<A>],
    pub(crate) means: &'a mut [Mean],
    pub(crate) slots: &'a mut [Slot<A>],
    pub(crate) picture: &'a mut [[u8; 3]],
    pub(crate) lights: Lights<'a>,
    hello: Option<Hello>,
    view: Option<View>,
    composed: bool,
    motion: Motion,
    rest: Rest,
    /// Whether a mean may hold something.
    pub(crate) averaged: bool,
    counts: Counts,
}

impl<'a, A: Arith> Display<'a, A> {
    /// A display of `width` × `height` pixels over `memory`; the picture starts black.
    ///
    /// # Errors
    /// When the size is out of range or a slice is too short.
    pub fn new(
        config: Config,
        width: u16,
        height: u16,
        memory: Memory<'a, A>,
    ) -> Result<Self, SetupError> {
        Self::with_workers(Alone, config, width, height, memory)
    }
}

impl<'a, A: Arith, W: Workers> Display<'a, A, W> {
    /// The same with threads of one's own: equal bits for any number.
    ///
    /// # Errors
    /// When the size is out of range or a slice is too short.
    pub fn with_workers(
        workers: W,
        config: Config,
        width: u16,
        height: u16,
        memory: Memory<'a, A>,
    ) -> Result<Self, SetupError> {
        let panel = Panel::new(width, height).ok_or(SetupError::Panel)?;
        memory.check(width, height, &config)?;
        let needs = Needs::of(width, height);
        let calls = Calls::of(&config, &needs, memory.samples.len());
        let pixels = needs.pixels;
        let cells = memory.cells.len();
        let tiles = TileMap::new(memory.cells, width, height).ok_or(SetupError::Short {
            slice: "cells",
            needs: needs.cells,
            has: cells,
        })?;
        memory.slots.fill(Slot::default());
        memory.picture.fill([0; 3]);
        memory.means.fill(Mean::EMPTY);
        Ok(Self {
            config,
            workers,
            panel,
            deep: DeepBuffer::new(memory.samples),
            tiles,
            projected: memory.projected,
            sorted: memory.sorted,
            starts: memory.starts,
            minima: first(memory.minima, calls.minima),
            limits: first(memory.limits, calls.hidden),
            movers: first(memory.movers, calls.hidden),
            mass: first(memory.mass, calls.mass),
            logs: first(memory.logs, pixels),
            sums: first(memory.sums, pixels),
            moments: first(memory.moments, calls.moments),
            texels: first(memory.texels, pixels),
            pyramid: memory.pyramid,
            means: first(memory.means, calls.means),
            slots: memory.slots,
            picture: first(memory.picture, pixels),
            lights: Lights::new(memory.light),
            hello: None,
            view: None,
            composed: false,
            motion: Motion::new(),
            rest: Rest::new(),
            averaged: false,
            counts: Counts::default(),
        })
    }

    /// The picture shown, row by row from the top, in the stream's encoding.
    #[must_use]
    pub fn picture(&self) -> &[[u8; 3]] {
        self.picture
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> (u16, u16) {
        (self.panel.width, self.panel.height)
    }

    /// What was received so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Samples in the deep buffer.
    #[must_use]
    pub fn buffered(&self) -> usize {
        self.deep.len()
    }

    /// The tile map as received.
    #[must_use]
    pub fn tiles(&self) -> &TileMap<'a> {
        &self.tiles
    }

    /// Takes a packet; a Refresh makes the picture and is handed back.
    pub fn receive(&mut self, packet: Packet<'_>) -> Option<Refresh> {
        match packet {
            Packet::Hello(hello) => self.hello(&hello),
            Packet::View(view) => self.view(&view),
            Packet::Poses(poses) => poses.for_each(|pose| self.pose(&pose)),
            Packet::Tiles(tiles) => tiles.for_each(|tile| self.tile(&tile)),
            Packet::World(samples) => {
                let time = samples.time();
                samples.for_each(|sample| self.world_sample(time, &sample));
            }
            Packet::Screen(samples) => {
                let time = samples.time();
                samples.for_each(|sample| self.screen_sample(time, &sample));
            }
            Packet::Lamps(lamps) => {
                for (index, lamp) in lamps.enumerate() {
                    self.lamp(index, &lamp);
                }
            }
            Packet::Shape(shape) => self.shape(&shape),
            Packet::Cut(_) => self.cut(),
            Packet::Refresh(refresh) => {
                self.refresh(&refresh);
                return Some(refresh);
            }
            Packet::End(_) | Packet::Status(_) | Packet::Index(_) | Packet::Trailer(_) => {}
        }
        None
    }

    /// Takes a Hello. A stream for another panel is refused; a new description starts anew.
    pub fn hello(&mut self, hello: &Hello) {
        if (hello.width, hello.height) != self.size() {
            self.counts.refused += 1;
            return;
        }
        if self.hello.is_some_and(|known| known != *hello) {
            self.cut();
            self.tiles.clear();
            self.slots.fill(Slot::default());
            self.lights.clear();
            self.view = None;
        }
        self.hello = Some(*hello);
    }

    /// Takes the view. The newest received is the one that a refresh shows.
    pub fn view(&mut self, view: &View) {
        if view_is_sound(view) {
            self.view = Some(*view);
            self.composed = false;
        } else {
            self.counts.refused += 1;
        }
    }

    /// Takes the pose of an object.
    pub fn pose(&mut self, pose: &Pose) {
        match self.slots.get_mut(usize::from(slot(pose.object))) {
            Some(slot) if pose_is_sound(pose) => {
                slot.pose = Some(*pose);
                slot.transform = match &self.view {
                    Some(view) if self.composed => Some(A::compose(view, pose)),
                    _ => None,
                };
            }
            _ => self.counts.refused += 1,
        }
    }

    /// Takes a lamp, the one of that number of the stream's.
    pub fn lamp(&mut self, index: usize, lamp: &Lamp) {
        self.counts.refused += u64::from(!self.lights.lamp(index, lamp));
    }

    /// Takes a part of the shape of an object that throws shadows.
    pub fn shape(&mut self, shape: &Shape<'_>) {
        self.counts.refused += u64::from(!self.lights.shape(shape));
    }

    /// The same of triangles: corners in the object's lattice.
    pub fn triangles(&mut self, object: u8, part: u8, triangles: &[[[i16; 3]; 3]]) {
        self.counts.refused += u64::from(!self.lights.triangles(object, part, triangles));
    }

    /// Takes a tile.
    pub fn tile(&mut self, tile: &Tile) {
        self.tiles.set(tile);
    }

    /// The scene changed wholly: nothing stored is true any more.
    pub fn cut(&mut self) {
        self.deep.clear();
        self.motion.clear();
        self.rest = Rest::new();
    }

    /// Takes a sample that can be reprojected, taken at `time`.
    pub fn world_sample(&mut self, time: Tick, sample: &WorldSample) {
        if self.hello.is_none_or(|hello| hello.layout != Layout::World) {
            self.counts.unplaced += 1;
            return;
        }
        let stored = Stored {
            time: time.0,
            place: sample.place,
            rgb: sample.rgb,
            slot: slot(sample.object),
            placing: Placing::Lattice,
            shares: sample.shares,
        };
        if self.config.mode == Mode::SpaceTime && self.config.reproject {
            if usize::from(stored.slot) < self.slots.len() {
                self.counts.samples += 1;
                self.deep.push(stored);
            } else {
                self.counts.unplaced += 1;
            }
            return;
        }
        // Where does it fall now? There it stays.
        self.compose();
        let place = self
            .slots
            .get(usize::from(stored.slot))
            .and_then(|slot| slot.transform.as_ref())
            .and_then(|transform| A::project(transform, &self.panel, sample.place))
            .map(|(x, y, _)| [x, y].map(|v| A::to_sixteenths(&self.panel, v)));
        match place {
            Some([x, y]) if x >= 0 && y >= 0 => {
                self.screen(
                    time,
                    &ScreenSample {
                        x: x as u16,
                        y: y as u16,
                        rgb: sample.rgb,
                    },
                );
            }
            _ => self.counts.unplaced += 1,
        }
    }

    /// Takes a sample on the screen, taken at `time`.
    pub fn screen_sample(&mut self, time: Tick, sample: &ScreenSample) {
        if self
            .hello
            .is_none_or(|hello| hello.layout != Layout::Screen)
        {
            self.counts.unplaced += 1;
        } else {
            self.screen(time, sample);
        }
    }

    fn screen(&mut self, time: Tick, sample: &ScreenSample) {
        let (x, y) = (sample.x >> 4, sample.y >> 4);
        if x >= self.panel.width || y >= self.panel.height {
            self.counts.unplaced += 1;
            return;
        }
        self.counts.samples += 1;
        if self.config.mode == Mode::Newest {
            let pixel = usize::from(y) * usize::from(self.panel.width) + usize::from(x);
            if let Some(pixel) = self.picture.get_mut(pixel) {
                *pixel = sample.rgb;
            }
            return;
        }
        self.deep.push(Stored {
            time: time.0,
            place: [sample.x as i16, sample.y as i16, 0],
            rgb: sample.rgb,
            slot: 0,
            placing: Placing::Screen,
            shares: Shares::default(),
        });
    }

    /// Composes view and poses where they changed.
    fn compose(&mut self) {
        if self.composed {
            return;
        }
        for slot in self.slots.iter_mut() {
            slot.transform = match (&self.view, &slot.pose) {
                (Some(view), Some(pose)) => Some(A::compose(view, pose)),
                _ => None,
            };
        }
        self.composed = true;
    }

    /// Makes the picture of an instant.
    pub fn refresh(&mut self, refresh: &Refresh) {
        self.counts.refreshes += 1;
        if self.config.mode == Mode::Newest {
            return;
        }
        self.compose();
        if self.lights.prepare(self.slots) {
            // What was averaged so far lay in another light.
            self.rest = Rest::new();
        }
        let step = self.step(refresh.time);
        if let Some(view) = &self.view {
            self.motion.refresh(refresh.time, view, self.slots);
        }
        if step != Step::Average {
            let workers = self.workers.clone();
            workers.together(|| self.show(refresh.time));
        }
    }

    /// From what is stored to the picture.
    fn show(&mut self, now: Tick) {
        let reach = self.reach();
        self.filter(now, &reach);
        if self.config.fill {
            let (width, height) = (self.panel.width.into(), self.panel.height.into());
            fill::fill(width, height, self.texels, self.pyramid, &self.workers);
        }
        self.encode();
    }

    /// What is to be done, and the means brought up to date.
    fn step(&mut self, now: Tick) -> Step {
        let (Some(view), false) = (&self.view, self.means.is_empty()) else {
            return Step::Filter;
        };
        let quiet = self.tiles.rests();
        let step = self.rest.step(now, view, self.slots, quiet);
        if step == Step::Filter {
            if self.averaged {
                self.means.fill(Mean::EMPTY);
                self.averaged = false;
            }
            self.deep.take_fresh(0);
            return step;
        }
        self.averaged = true;
        rest::prepare(&self.panel, &self.tiles, quiet, self.means);
        self.average(now, quiet, step == Step::Average);
        step
    }

    /// How far occlusion could reach at the last refresh.
    pub(crate) fn reach(&self) -> Reach<A> {
        self.motion.reach(self.view.as_ref().unwrap_or(&NO_VIEW))
    }
}
