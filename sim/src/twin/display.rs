//! The display: packets in, pictures out. Twin of [`unframed_recon::Display`], method by method;
//! what it does to single samples and pixels runs in shaders.

use super::light::OwnLights;
use super::memory::{Memory, PENDING, STORED};
use super::params::{self, Params, Transform};
use super::refresh::{self, prefix_sum};
use super::stages::{GROUP, LOOK, Stages};
use super::tables::Tables;
use crate::gpu::{Gpu, GpuError};
use crate::pass::{Batch, linear_grid};
use unframed_recon::config::{Config, Mode};
use unframed_recon::deep::{Placing, Stored, slot};
use unframed_recon::display::Counts;
use unframed_recon::memory::Slot;
use unframed_recon::motion::{Motion, Reach};
use unframed_recon::rest::{Rest, Step};
use unframed_recon::tiles::{Cell, TileMap};
use unframed_recon::transform::{pose_is_sound, view_is_sound};
use unframed_recon::{Arith, Fixed, Panel};
use unframed_wire::{Hello, Layout, MAX_SAMPLES, Packet, Pose, Refresh, Shares, Tick, View};

/// Slots of poses: the sky's and all objects'.
const SLOTS: usize = 256;

/// A display whose samples live on the adapter.
///
/// Invariant: `pending` holds what `samples` still lacks, at most [`PENDING`] samples, all under
/// the view and poses of now.
pub(super) struct GpuDisplay<'g> {
    pub(super) gpu: &'g Gpu,
    pub(super) config: Config,
    pub(super) panel: Panel,
    pub(super) params: Params,
    pub(super) stages: Stages,
    pub(super) memory: Memory,
    pub(super) cells: Vec<Cell>,
    cells_changed: bool,
    pub(super) slots: Vec<Slot<Fixed>>,
    lights: OwnLights,
    pub(super) motion: Motion,
    pub(super) rest: Rest,
    pub(super) averaged: bool,
    transforms_changed: bool,
    pending: Vec<[u32; 4]>,
    /// Next and length of the ring as the processor knows them: exact where samples are
    /// reprojected, an upper bound of the length where the adapter places them.
    pub(super) next: usize,
    len: usize,
    /// Samples stored since the last refresh, the newest in the ring.
    pub(super) fresh: usize,
    /// Samples placed by the adapter since its counts were read.
    uncounted: usize,
    picture: Vec<[u8; 3]>,
    hello: Option<Hello>,
    pub(super) view: Option<View>,
    counts: Counts,
}

impl<'g> GpuDisplay<'g> {
    pub(super) fn new(
        gpu: &'g Gpu,
        config: Config,
        (width, height): (u16, u16),
        samples: usize,
        tables: &Tables,
    ) -> Result<Self, GpuError> {
        let place = "the display's twin";
        let panel = Panel::new(width, height).ok_or_else(|| {
            let limit = Panel::LIMIT;
            let reason = format!("a panel of {width} x {height}; both must be 1 to {limit} pixels");
            GpuError::failed(place, reason)
        })?;
        // So that every place in the ring plus a batch stays in 32 bits.
        let capacity = u32::try_from(samples)
            .ok()
            .filter(|n| *n <= 1 << 30)
            .ok_or_else(|| GpuError::failed(place, format!("{samples} samples; at most 2^30")))?;
        // Without space-time filtering nothing is remembered but the picture.
        let capacity = if config.mode == Mode::Newest {
            0
        } else {
            capacity
        };
        let params = Params::new(&config, &panel, capacity);
        let memory = Memory::new(gpu, &config, &panel, &params, tables)?;
        Ok(Self {
            gpu,
            config,
            panel,
            params,
            stages: Stages::new(gpu, &config)?,
            memory,
            cells: vec![Cell::default(); (params.columns * params.rows) as usize],
            cells_changed: true,
            slots: vec![Slot::default(); SLOTS],
            lights: OwnLights::new(),
            motion: Motion::new(),
            rest: Rest::new(),
            averaged: false,
            transforms_changed: true,
            pending: Vec::new(),
            next: 0,
            len: 0,
            fresh: 0,
            uncounted: 0,
            picture: vec![[0; 3]; panel.pixels()],
            hello: None,
            view: None,
            counts: Counts::default(),
        })
    }

    pub(super) fn gpu(&self) -> &'g Gpu {
        self.gpu
    }

    pub(super) fn picture(&self) -> &[[u8; 3]] {
        &self.picture
    }

    pub(super) fn size(&self) -> (u16, u16) {
        (self.panel.width, self.panel.height)
    }

    pub(super) fn counts(&self) -> Counts {
        self.counts
    }

    pub(super) fn buffered(&self) -> usize {
        if self.places() {
            return self.len;
        }
        (self.len + self.pending.len()).min(self.params.capacity as usize)
    }

    /// Whether the adapter places samples on arrival, and so decides which enter the ring.
    fn places(&self) -> bool {
        self.stages.arrival.is_some()
    }

    pub(super) fn receive(&mut self, packet: Packet<'_>) -> Result<Option<Refresh>, GpuError> {
        match packet {
            Packet::Hello(hello) => self.hello(&hello)?,
            Packet::View(view) => self.view(&view)?,
            Packet::Poses(poses) => {
                self.settle()?;
                poses.for_each(|pose| self.pose(&pose));
            }
            Packet::Tiles(tiles) => {
                let (width, height) = self.size();
                if let Some(mut map) = TileMap::resume(&mut self.cells, width, height) {
                    tiles.for_each(|tile| map.set(&tile));
                    self.cells_changed = true;
                }
            }
            Packet::World(samples) => {
                self.make_room()?;
                let time = samples.time();
                samples.for_each(|sample| {
                    let stored = Stored {
                        time: time.0,
                        place: sample.place,
                        rgb: sample.rgb,
                        slot: slot(sample.object),
                        placing: Placing::Lattice,
                        shares: sample.shares,
                    };
                    self.sample(Layout::World, &stored);
                });
            }
            Packet::Screen(samples) => {
                self.make_room()?;
                let time = samples.time();
                samples.for_each(|sample| {
                    let stored = Stored {
                        time: time.0,
                        place: [sample.x as i16, sample.y as i16, 0],
                        rgb: sample.rgb,
                        slot: 0,
                        placing: Placing::Screen,
                        shares: Shares::default(),
                    };
                    self.sample(Layout::Screen, &stored);
                });
            }
            Packet::Lamps(lamps) => {
                self.counts.refused += self.lights.lamps(lamps);
            }
            Packet::Shape(shape) => self.counts.refused += self.lights.shape(&shape),
            Packet::Cut(_) => self.cut()?,
            Packet::Refresh(refresh) => {
                self.refresh(&refresh)?;
                return Ok(Some(refresh));
            }
            Packet::End(_) | Packet::Status(_) | Packet::Index(_) | Packet::Trailer(_) => {}
        }
        Ok(None)
    }

    fn hello(&mut self, hello: &Hello) -> Result<(), GpuError> {
        if (hello.width, hello.height) != self.size() {
            self.counts.refused += 1;
            return Ok(());
        }
        if self.hello.is_some_and(|known| known != *hello) {
            self.cut()?;
            self.cells.fill(Cell::default());
            self.cells_changed = true;
            self.slots.fill(Slot::default());
            self.lights.clear();
            self.view = None;
            self.transforms_changed = true;
        }
        self.hello = Some(*hello);
        Ok(())
    }

    fn view(&mut self, view: &View) -> Result<(), GpuError> {
        if view_is_sound(view) {
            self.settle()?;
            self.view = Some(*view);
            self.transforms_changed = true;
        } else {
            self.counts.refused += 1;
        }
        Ok(())
    }

    fn pose(&mut self, pose: &Pose) {
        match self.slots.get_mut(usize::from(slot(pose.object))) {
            Some(slot) if pose_is_sound(pose) => {
                slot.pose = Some(*pose);
                self.transforms_changed = true;
            }
            _ => self.counts.refused += 1,
        }
    }

    /// The scene changed wholly: nothing stored is true any more.
    fn cut(&mut self) -> Result<(), GpuError> {
        self.settle()?;
        self.pending.clear();
        (self.next, self.len, self.fresh) = (0, 0, 0);
        self.motion.clear();
        self.rest = Rest::new();
        self.memory.ring.write(self.gpu, 0, &[0, 0])
    }

    /// Takes a sample; [`GpuDisplay::make_room`] comes before.
    fn sample(&mut self, layout: Layout, sample: &Stored) {
        if self.hello.is_none_or(|hello| hello.layout != layout) {
            self.counts.unplaced += 1;
            return;
        }
        if sample.placing == Placing::Screen {
            let [x, y, _] = sample.place.map(|v| v as u16 >> 4);
            if x >= self.panel.width || y >= self.panel.height {
                self.counts.unplaced += 1;
                return;
            }
        }
        if !self.places() {
            self.counts.samples += 1;
        }
        self.pending.push(params::stored(sample));
    }

    /// Makes room for the samples of one packet.
    fn make_room(&mut self) -> Result<(), GpuError> {
        if self.pending.len() + MAX_SAMPLES > PENDING {
            self.flush()?;
        }
        Ok(())
    }

    /// Before view or poses change: what arrived under them is placed under them.
    fn settle(&mut self) -> Result<(), GpuError> {
        if self.places() { self.flush() } else { Ok(()) }
    }

    /// Moves the pending samples to the adapter.
    fn flush(&mut self) -> Result<(), GpuError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        if self.places() {
            self.place()?;
        } else {
            self.store()?;
        }
        self.pending.clear();
        Ok(())
    }

    /// Writes the pending samples into the ring, twin of `DeepBuffer::push`.
    fn store(&mut self) -> Result<(), GpuError> {
        let capacity = self.params.capacity as usize;
        if capacity == 0 {
            return Ok(());
        }
        let excess = self.pending.len().saturating_sub(capacity);
        let kept = &self.pending[excess..];
        let first = (self.next + excess) % capacity;
        let (to_end, rest) = kept.split_at(kept.len().min(capacity - first));
        let samples = &self.memory.samples;
        samples.write(self.gpu, first * STORED, bytemuck::cast_slice(to_end))?;
        samples.write(self.gpu, 0, bytemuck::cast_slice(rest))?;
        self.next = (first + kept.len()) % capacity;
        self.len = (self.len + self.pending.len()).min(capacity);
        self.fresh = (self.fresh + self.pending.len()).min(capacity);
        let ring = [self.next as u32, self.len as u32];
        self.memory.ring.write(self.gpu, 0, &ring)?;
        // Written data waits in memory until something is submitted.
        Batch::new(self.gpu).submit()
    }

    /// Places the pending samples under the view and poses of now and stores or shows them.
    fn place(&mut self) -> Result<(), GpuError> {
        self.compose()?;
        let (gpu, memory) = (self.gpu, &self.memory);
        let Some(arrival) = &self.stages.arrival else {
            return Ok(());
        };
        let len = self.pending.len();
        memory.arrived.write(gpu, 0, &[len as u32])?;
        let pending = bytemuck::cast_slice(&self.pending);
        memory.pending.write(gpu, 0, pending)?;
        let (params, tables) = (&memory.params, &memory.tables);
        let Memory {
            arrived,
            pending,
            transforms,
            placed,
            ranks,
            ring,
            samples,
            claims,
            picture,
            blocks,
            ..
        } = memory;
        let items = linear_grid(len, GROUP);
        let mut batch = Batch::new(gpu);
        batch.run(
            &arrival.place,
            &[params, tables, arrived, pending, transforms, placed],
            items,
        )?;
        let scan = &self.stages.scan;
        let sum = [params, tables, arrived, placed, ranks, blocks];
        prefix_sum(&mut batch, scan, sum, len)?;
        if let Some(store) = &arrival.store {
            let buffers = [
                params, tables, arrived, ring, pending, placed, ranks, samples,
            ];
            batch.run(store, &buffers, items)?;
        }
        if let Some((claim, show)) = &arrival.newest {
            batch.clear(claims);
            let buffers = [params, tables, arrived, pending, placed, claims];
            batch.run(claim, &buffers, items)?;
            let pixels = linear_grid(self.panel.pixels(), GROUP);
            let buffers = [params, tables, pending, claims, picture];
            batch.run(show, &buffers, pixels)?;
        }
        let buffers = [params, tables, arrived, ranks, ring];
        batch.run(&arrival.advance, &buffers, [1, 1, 1])?;
        batch.submit()?;
        self.len = (self.len + len).min(self.params.capacity as usize);
        self.uncounted += len;
        // The adapter counts with 32 bits.
        if self.uncounted > 1 << 30 {
            self.count()?;
        }
        Ok(())
    }

    /// Fetches what the adapter counted.
    fn count(&mut self) -> Result<(), GpuError> {
        let ring = self.memory.ring.read(self.gpu)?;
        if let [_, len, placed, unplaced] = ring[..] {
            self.len = len as usize;
            self.counts.samples += u64::from(placed);
            self.counts.unplaced += u64::from(unplaced);
        }
        self.uncounted = 0;
        self.memory.ring.write(self.gpu, 2, &[0, 0])
    }

    /// Composes view and poses and hands them to the adapter where they changed.
    fn compose(&mut self) -> Result<(), GpuError> {
        if !self.transforms_changed {
            return Ok(());
        }
        let compose = |slot: &Slot<Fixed>| match (&self.view, &slot.pose) {
            (Some(view), Some(pose)) => Fixed::compose(view, pose).into(),
            _ => Transform::default(),
        };
        let transforms: Vec<Transform> = self.slots.iter().map(compose).collect();
        let words = bytemuck::cast_slice(&transforms);
        self.memory.transforms.write(self.gpu, 0, words)?;
        self.transforms_changed = false;
        Ok(())
    }

    fn refresh(&mut self, refresh: &Refresh) -> Result<(), GpuError> {
        self.counts.refreshes += 1;
        self.flush()?;
        if self.uncounted > 0 {
            self.count()?;
        }
        if self.config.mode == Mode::SpaceTime {
            self.compose()?;
            let light = &self.memory.light;
            if self.lights.prepare(self.gpu, &self.slots, light)? {
                self.rest = Rest::new();
            }
            self.tell(refresh.time)?;
            let step = self.step(refresh.time)?;
            self.reach(refresh.time)?;
            if step == Step::Average {
                self.show()?;
            } else {
                self.filter()?;
            }
        }
        let words = self.memory.picture.read(self.gpu)?;
        for (pixel, word) in self.picture.iter_mut().zip(words) {
            let [r, g, b, _] = word.to_le_bytes();
            *pixel = [r, g, b];
        }
        Ok(())
    }

    /// Tells the adapter how far occlusion can reach at this refresh.
    fn reach(&mut self, now: Tick) -> Result<(), GpuError> {
        let reach: Reach<Fixed> = match &self.view {
            Some(view) => {
                self.motion.refresh(now, view, &mut self.slots);
                self.motion.reach(view)
            }
            // Nothing can be placed.
            None => return Ok(()),
        };
        let pairs = reach.resting.iter().zip(&reach.moving);
        let words: Vec<u32> = pairs
            .flat_map(|(resting, moving)| [u32::from(*resting), u32::from(*moving)])
            .collect();
        self.memory.reach.write(self.gpu, 0, &words)
    }

    /// Tells the adapter the instant and the tiles.
    fn tell(&mut self, now: Tick) -> Result<(), GpuError> {
        let (gpu, memory) = (self.gpu, &self.memory);
        self.params.now = now.0;
        let words = bytemuck::cast_slice(std::slice::from_ref(&self.params));
        memory.params.write(gpu, 0, words)?;
        if self.cells_changed {
            let words: Vec<[u32; 2]> = self.cells.iter().map(params::cell).collect();
            memory.cells.write(gpu, 0, bytemuck::cast_slice(&words))?;
            self.cells_changed = false;
        }
        Ok(())
    }

    /// Makes the picture from the deep buffer.
    fn filter(&mut self) -> Result<(), GpuError> {
        let (gpu, memory) = (self.gpu, &self.memory);
        let Some(stages) = &self.stages.refreshing else {
            return Ok(());
        };
        let mut batch = Batch::new(gpu);
        memory.round.write(gpu, 0, &[0])?;
        refresh::arrange(&mut batch, stages, &self.stages.scan, memory, self.len)?;
        refresh::gather(&mut batch, stages, memory)?;
        refresh::show(&mut batch, stages, memory)?;
        batch.submit()?;
        let longest = memory.longest.read(gpu)?.first().copied().unwrap_or(0);
        if longest <= LOOK {
            return Ok(());
        }
        // Thousands of samples on one place: one round did not see them all.
        for round in 1..longest.div_ceil(LOOK) {
            memory.round.write(gpu, 0, &[round])?;
            let mut batch = Batch::new(gpu);
            refresh::gather(&mut batch, stages, memory)?;
            batch.submit()?;
        }
        let mut batch = Batch::new(gpu);
        refresh::show(&mut batch, stages, memory)?;
        batch.submit()
    }
}
