//! One stream being sent: quantised, packed, in order.

use std::fmt;

use unframed_wire::{
    ColourEncoding, EncodeError, End, Hello, Layout, Pose, Rect, Refresh, SKY, ScreenSample, Tick,
    TileFields, TileNode, WorldSample, Writer, ledger::Ledger,
};

use super::light::{self, LightSender};
use super::{Detail, Quantiser};
use crate::sampler::Shot;
use crate::trace::{World, srgb};

/// Samples a packet: enough for the coder to find neighbours, few enough to be on time.
const PACKET_SAMPLES: usize = 256;
/// The longest stretch of time whose samples share one time stamp, seconds.
const PACKET_SPAN: f64 = 1e-3;
/// Refreshes between repeats of Hello and of the poses of things at rest.
const HELLO_EVERY: u32 = 30;

/// Refreshes between repeated parts of shapes.
const SHAPE_EVERY: u32 = 4;

/// What could not be sent.
#[derive(Debug)]
pub struct StreamError(EncodeError);

impl fmt::Display for StreamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the stream cannot carry this scene: {}", self.0)
    }
}

impl std::error::Error for StreamError {}

impl From<EncodeError> for StreamError {
    fn from(error: EncodeError) -> Self {
        Self(error)
    }
}

/// Microseconds of an instant, as the stream counts them.
#[must_use]
pub fn tick(seconds: f64) -> Tick {
    Tick((seconds * 1e6).round() as u64 as u32)
}

/// Sends one stream.
#[derive(Debug)]
pub struct Sender {
    writer: Writer,
    hello: Hello,
    quantiser: Quantiser,
    light: LightSender,
    detail: Detail,
    world_samples: Vec<WorldSample>,
    screen_samples: Vec<ScreenSample>,
    refreshes: u32,
}

/// What a stream promises, besides what follows from the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// How places are coded.
    pub layout: Layout,
    /// Whether the display is to draw shadows of what moves, where a scene has such and samples have
    /// places in the world.
    pub lamps: bool,
    /// What tiles carry.
    pub tile_fields: TileFields,
    /// Samples a second.
    pub rate: u32,
    /// Refreshes in 1000 seconds.
    pub refresh_millihertz: u32,
}

impl Sender {
    /// Starts a stream of a scene, in all detail.
    #[must_use]
    pub fn new(world: &World, promise: Promise) -> Self {
        Self::with_detail(world, promise, Detail::default())
    }

    /// The same in less detail.
    #[must_use]
    pub fn with_detail(world: &World, promise: Promise, detail: Detail) -> Self {
        let [width, height] = world.size().map(|s| s as u16);
        let quantiser = Quantiser::new(world, detail);
        let lamps = if promise.lamps && detail.lamps && promise.layout == Layout::World {
            world.lamps_left()
        } else {
            0
        };
        let light = if lamps > 0 {
            LightSender::new(world, &quantiser)
        } else {
            LightSender::default()
        };
        let hello = Hello {
            width,
            height,
            layout: promise.layout,
            objects: promise.layout == Layout::World,
            tile_fields: promise.tile_fields,
            encoding: ColourEncoding::Srgb8,
            rate: promise.rate,
            refresh_millihertz: promise.refresh_millihertz,
            world: quantiser.frame(),
            lamps,
        };
        Self {
            writer: Writer::new(),
            hello,
            quantiser,
            light,
            detail,
            world_samples: Vec::new(),
            screen_samples: Vec::new(),
            refreshes: 0,
        }
    }

    /// Where the bytes went so far.
    #[must_use]
    pub fn ledger(&self) -> &Ledger {
        self.writer.ledger()
    }

    /// What the stream announces.
    #[must_use]
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Sends samples, which must stand in the order of time.
    ///
    /// # Errors
    /// Only when a sample contradicts the stream's promise.
    pub fn samples(&mut self, shots: &[Shot], out: &mut Vec<u8>) -> Result<(), StreamError> {
        self.announce(out)?;
        let mut rest = shots;
        while let Some(first) = rest.first() {
            let count = rest
                .iter()
                .take(PACKET_SAMPLES)
                .take_while(|shot| shot.as_of - first.as_of < PACKET_SPAN)
                .count();
            let (packet, tail) = rest.split_at(count.max(1));
            rest = tail;
            let last = packet.last().map_or(first.as_of, |shot| shot.as_of);
            self.packet(tick(0.5 * (first.as_of + last)), packet, out)?;
        }
        Ok(())
    }

    fn packet(&mut self, time: Tick, shots: &[Shot], out: &mut Vec<u8>) -> Result<(), StreamError> {
        let sink = &mut |bytes: &[u8]| out.extend_from_slice(bytes);
        match self.hello.layout {
            Layout::World => {
                let (quantiser, detail) = (&self.quantiser, &self.detail);
                self.world_samples.clear();
                self.world_samples
                    .extend(shots.iter().map(|shot| WorldSample {
                        place: quantiser.place(shot.hit.object, shot.hit.local),
                        rgb: detail.colour(srgb::encode8(shot.hit.colour)),
                        object: shot.hit.object,
                        shares: shot.hit.shares,
                    }));
                self.writer.world_samples(time, &self.world_samples, sink)?;
            }
            Layout::Screen => {
                let (width, height) = (self.hello.width, self.hello.height);
                let detail = &self.detail;
                self.screen_samples.clear();
                self.screen_samples.extend(shots.iter().map(|shot| {
                    let at = |v: f32, size: u16| ((v * 16.0) as u16).min(16 * size - 1);
                    ScreenSample {
                        x: at(shot.pixel.x, width),
                        y: at(shot.pixel.y, height),
                        rgb: detail.colour(srgb::encode8(shot.hit.colour)),
                    }
                }));
                self.writer
                    .screen_samples(time, &self.screen_samples, sink)?;
            }
        }
        Ok(())
    }

    /// Sends Hello before the first packet.
    fn announce(&mut self, out: &mut Vec<u8>) -> Result<(), StreamError> {
        if self.writer.ledger().total_packets() == 0 {
            self.writer
                .hello(&self.hello, &mut |bytes| out.extend_from_slice(bytes))?;
        }
        Ok(())
    }

    /// Whether the next refresh brings a tiling; if not, its tiles need not be made.
    #[must_use]
    pub fn wants_tiles(&self) -> bool {
        self.detail.tiles_at(self.refreshes)
    }

    /// Tells the display to forget everything from before `time` (seconds).
    ///
    /// # Errors
    /// None with a sound encoder.
    pub fn cut(&mut self, time: f64, out: &mut Vec<u8>) -> Result<(), StreamError> {
        self.announce(out)?;
        Ok(self
            .writer
            .cut(tick(time), &mut |bytes| out.extend_from_slice(bytes))?)
    }

    /// Asks for a picture of the instant `time` (seconds): sends tiles, the view and the poses of
    /// the instant, then the refresh.
    ///
    /// # Errors
    /// When the tiles are not a cut of the image.
    pub fn refresh(
        &mut self,
        world: &World,
        time: f64,
        tiles: &[TileNode],
        out: &mut Vec<u8>,
    ) -> Result<(), StreamError> {
        self.announce(out)?;
        let sink = &mut |bytes: &[u8]| out.extend_from_slice(bytes);
        let again = self.refreshes.is_multiple_of(HELLO_EVERY);
        if again && self.refreshes > 0 {
            self.writer.hello(&self.hello, sink)?;
        }
        if !tiles.is_empty() {
            let whole = Rect {
                x: 0,
                y: 0,
                w: self.hello.width,
                h: self.hello.height,
            };
            self.writer.tiles(tick(time), whole, tiles, sink)?;
        }
        if self.hello.layout == Layout::World {
            let camera = world.camera(time);
            let motion = world.moves();
            if motion.view || again {
                self.writer
                    .view(&self.quantiser.view(tick(time), &camera), sink)?;
            }
            let movers = 1..world.object_count() as u8;
            let resting = [0].into_iter().filter(|_| again);
            let sky = [SKY].into_iter().filter(|_| motion.view || again);
            let poses: Vec<Pose> = resting
                .chain(sky)
                .chain(movers.filter(|_| motion.objects || again))
                .map(|k| self.quantiser.pose(k, &world.pose(k, time), camera.eye))
                .collect();
            self.writer.poses(tick(time), &poses, sink)?;
            if self.hello.lamps > 0 {
                if again || world.lamps_left_move() {
                    let lamps = light::lamps(world, &self.quantiser, time);
                    self.writer.lamps(tick(time), &lamps, sink)?;
                }
                if self.refreshes == 0 {
                    self.light.all(&mut self.writer, sink)?;
                } else if self.refreshes.is_multiple_of(SHAPE_EVERY) {
                    self.light.again(&mut self.writer, sink)?;
                }
            }
        }
        self.writer.refresh(
            Refresh {
                time: tick(time),
                index: self.refreshes,
            },
            sink,
        )?;
        self.refreshes = self.refreshes.wrapping_add(1);
        Ok(())
    }

    /// Ends the stream at `time` (seconds).
    ///
    /// # Errors
    /// None with a sound encoder.
    pub fn end(&mut self, time: f64, out: &mut Vec<u8>) -> Result<End, StreamError> {
        self.announce(out)?;
        Ok(self
            .writer
            .end(tick(time), &mut |bytes| out.extend_from_slice(bytes))?)
    }
}
