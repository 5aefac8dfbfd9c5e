//! The display: takes packets in, shows pictures.
//!
//! It never asks for anything and trusts nothing: what it cannot place or does not understand is
//! counted and left out.

use crate::arith::{Arith, Panel, Projected};
use crate::config::{Config, Extents, Fit, Lifetime, Light, Mode};
use crate::deep::{DeepBuffer, Placing, Stored, age, slot};
use crate::memory::{Memory, SetupError, Slot};
use crate::motion::{Motion, Reach};
use crate::splat::{self, Target};
use crate::tables::{SRGB_TO_LINEAR, linear_to_srgb};
use crate::tiles::TileMap;
use crate::transform::{pose_is_sound, view_is_sound};
use crate::{fill, hidden, solve};
use unframed_wire::{
    Hello, Layout, Packet, Pose, Refresh, ScreenSample, Tick, Tile, View, WorldSample,
};

/// 8-bit codes as they are, spread over 16 bits.
pub static ENCODED: [u16; 256] = {
    let mut table = [0; 256];
    let mut c = 0;
    while c < 256 {
        table[c] = c as u16 * 257;
        c += 1;
    }
    table
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

/// A display with its storage.
#[derive(Debug)]
pub struct Display<'a, A: Arith> {
    config: Config,
    panel: Panel,
    deep: DeepBuffer<'a>,
    tiles: TileMap<'a>,
    projected: &'a mut [Projected<A>],
    minima: &'a mut [A::Depth],
    limits: &'a mut [A::Depth],
    movers: &'a mut [u8],
    mass: &'a mut [A::Mass],
    widths: &'a mut [A::Width],
    target: Target<'a, A>,
    texels: &'a mut [crate::arith::Texel<A>],
    pyramid: &'a mut [crate::arith::Texel<A>],
    slots: &'a mut [Slot<A>],
    picture: &'a mut [[u8; 3]],
    hello: Option<Hello>,
    view: Option<View>,
    composed: bool,
    motion: Motion,
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
        let panel = Panel::new(width, height).ok_or(SetupError::Panel)?;
        let planes = config.fit == Fit::Linear;
        memory.check(width, height, planes)?;
        let pixels = panel.pixels();
        let cells = memory.cells.len();
        let tiles = TileMap::new(memory.cells, width, height).ok_or(SetupError::Short {
            slice: "cells",
            needs: crate::memory::Needs::of(width, height).cells,
            has: cells,
        })?;
        memory.slots.fill(Slot::default());
        memory.picture.fill([0; 3]);
        let moments = if planes { pixels } else { 0 };
        Ok(Self {
            config,
            panel,
            deep: DeepBuffer::new(memory.samples),
            tiles,
            projected: memory.projected,
            minima: &mut memory.minima[..hidden::minima_len(width, height)],
            limits: &mut memory.limits[..pixels],
            movers: &mut memory.movers[..pixels],
            mass: &mut memory.mass[..pixels],
            widths: &mut memory.widths[..pixels],
            target: Target {
                sums: &mut memory.sums[..pixels],
                moments: &mut memory.moments[..moments],
            },
            texels: &mut memory.texels[..pixels],
            pyramid: memory.pyramid,
            slots: memory.slots,
            picture: &mut memory.picture[..pixels],
            hello: None,
            view: None,
            composed: false,
            motion: Motion::new(),
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

    /// Takes a tile.
    pub fn tile(&mut self, tile: &Tile) {
        self.tiles.set(tile);
    }

    /// The scene changed wholly: nothing stored is true any more.
    pub fn cut(&mut self) {
        self.deep.clear();
        self.motion.clear();
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
        let reach = self.reach(refresh.time);
        self.project(refresh.time, &reach);
        let len = self.deep.len();
        if self.config.hidden {
            let panel = &self.panel;
            let projected = self.projected.get_mut(..len).unwrap_or_default();
            hidden::nearest(panel, projected, self.minima);
            hidden::limits::<A>(panel, self.minima, self.limits);
            hidden::mark_movers(panel, self.deep.samples(), projected, self.movers);
            hidden::drop(panel, self.limits, self.movers, projected);
        }
        self.set_widths();
        let light = match self.config.light {
            Light::Linear => &SRGB_TO_LINEAR,
            Light::Encoded => &ENCODED,
        };
        let projected = self.projected.get(..len).unwrap_or_default();
        splat::scatter(
            &self.panel,
            self.deep.samples(),
            projected,
            light,
            &mut self.target,
        );
        if self.config.fit == Fit::Linear {
            solve::planes::<A>(self.target.sums, self.target.moments, self.texels);
        } else {
            solve::means::<A>(self.target.sums, self.texels);
        }
        if self.config.fill {
            let (width, height) = (self.panel.width.into(), self.panel.height.into());
            fill::fill(width, height, self.texels, self.pyramid);
        }
        self.encode();
    }

    /// How far occlusion can reach at this refresh.
    fn reach(&mut self, now: Tick) -> Reach<A> {
        match &self.view {
            Some(view) => {
                self.motion.refresh(now, view, self.slots);
                self.motion.reach(view)
            }
            None => self.motion.reach(&NO_VIEW),
        }
    }

    /// Moves every stored sample to the refresh instant and weighs it by its age.
    fn project(&mut self, now: Tick, reach: &Reach<A>) {
        let (config, panel) = (&self.config, &self.panel);
        for (sample, projected) in self.deep.samples_mut().iter_mut().zip(&mut *self.projected) {
            *projected = Projected::default();
            let Some(age) = age(sample.time, now) else {
                sample.placing = Placing::Empty;
                continue;
            };
            let place = match sample.placing {
                Placing::Empty => None,
                Placing::Screen => {
                    let [x, y, _] = sample.place.map(|v| A::from_sixteenths(panel, v as u16));
                    Some((x, y, A::Depth::default()))
                }
                Placing::Lattice => self
                    .slots
                    .get(usize::from(sample.slot))
                    .and_then(|slot| slot.transform.as_ref())
                    .and_then(|transform| A::project(transform, panel, sample.place)),
            };
            let Some((x, y, depth)) = place else { continue };
            let (mut lifetime, mut widths) = (A::Log::default(), [A::Width::default(); 2]);
            if config.extents == Extents::Gradient || config.lifetime == Lifetime::Gradient {
                let (et, wx, wy) = A::extents(&self.tiles, panel, x, y);
                (lifetime, widths) = (et, [wx, wy]);
            }
            match config.lifetime {
                Lifetime::Constant(log) => lifetime = A::log(log),
                Lifetime::Tiles => lifetime = A::lifetime(&self.tiles, panel, x, y),
                Lifetime::Gradient => {}
            }
            if let Extents::Constant(log) = config.extents {
                widths = [A::width(log.into()); 2];
            }
            let weight = A::decline(config.kernel, age, lifetime);
            // A sample of a moving object may itself have moved behind something.
            let moves = sample.slot > slot(0);
            let reach = [reach.of(age, moves), reach.of(age, true)];
            *projected = Projected {
                x,
                y,
                depth,
                weight,
                widths,
                reach,
            };
        }
    }

    fn set_widths(&mut self) {
        if self.config.extents != Extents::Density {
            return;
        }
        let panel = &self.panel;
        let projected = self.projected.get_mut(..self.deep.len());
        let projected = projected.unwrap_or_default();
        splat::masses(panel, projected, self.mass);
        splat::widths::<A>(panel, self.mass, self.widths);
        for sample in projected {
            let pixel = panel.nearest(A::pixel(panel, sample.x), A::pixel(panel, sample.y));
            sample.widths = [self.widths.get(pixel).copied().unwrap_or_default(); 2];
        }
    }

    /// Light to the panel's codes. Pixels of which nothing is known keep what they show.
    fn encode(&mut self) {
        for (texel, pixel) in self.texels.iter().zip(&mut *self.picture) {
            if texel.confidence == A::Confidence::default() {
                continue;
            }
            *pixel = texel.light.map(|light| {
                let light = A::to_u16(light);
                match self.config.light {
                    Light::Linear => linear_to_srgb(light),
                    Light::Encoded => ((u32::from(light) + 128) / 257) as u8,
                }
            });
        }
    }
}
