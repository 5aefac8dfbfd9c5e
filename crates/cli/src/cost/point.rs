//! What one setting costs and how far off it is.
//!
//! **Error, split.** With *I* the ideal picture, the mean squared error is taken along a chain of
//! renderings of the same stream at the same instant, each with one cause of error less:
//!
//! | picture | what is left out | its error less the next one's is called |
//! |---|---|---|
//! | as shown | nothing | arithmetic |
//! | in `f64` | rounding | delay |
//! | and each sample traced again at the instant | age | sampling |
//! | of 16 fresh samples a pixel on a grid | shortage of samples | filtering (what is left) |
//!
//! So the parts add up to the whole by construction. A part can be negative: a lag may hide noise.
//! What filters blur because samples are few counts as sampling; filtering is what plenty of
//! samples would not cure.

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use unframed_host::trace::World;
use unframed_metrics::{Image, SquaredError};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Arith, Display, Fixed, Player};
use unframed_wire::Tick;

use super::effort::{Arrivals, Work};
use super::formats::In;
use super::knobs::{Format, Knobs};
use super::ram;
use super::stream::{self, Stream};
use crate::args::Size;
use crate::eval::Reference;
use crate::measure::REFRESH_HZ;
use crate::replica::{Replica, picture_of};
use crate::work::Stopwatch;

/// Mean squared error in displayed levels (0..255) squared, and its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorParts {
    /// Too few samples: noise, holes, and the blur that hides them.
    pub sampling: f64,
    /// The filter's own: what is left with plenty of samples.
    pub filtering: f64,
    /// Rounding: against the same in `f64`.
    pub arithmetic: f64,
    /// Samples that are not of the instant shown.
    pub delay: f64,
    /// All of it.
    pub total: f64,
}

impl ErrorParts {
    fn mean(all: &[Self]) -> Self {
        let count = all.len().max(1) as f64;
        let mean = |f: fn(&Self) -> f64| all.iter().map(f).sum::<f64>() / count;
        Self {
            sampling: mean(|e| e.sampling),
            filtering: mean(|e| e.filtering),
            arithmetic: mean(|e| e.arithmetic),
            delay: mean(|e| e.delay),
            total: mean(|e| e.total),
        }
    }
}

/// A setting, measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Split, at every tenth refresh; none where it was not to be.
    pub error: Option<ErrorParts>,
    /// Over every refresh counted: root of the mean of squares, levels.
    pub rmse: f64,
    /// RMSE against the same in `f64` at every tenth refresh, levels; none where it was not split.
    pub rmse_to_oracle: Option<f64>,
    /// Core seconds of the host for a second of animation.
    pub host_seconds: f64,
    /// Core seconds of the display for a second of animation: median refresh × refresh rate.
    pub display_seconds: f64,
    /// Stream bytes a second, all packets counted.
    pub bytes_per_second: f64,
    /// Rays of the host for a second of animation, of all kinds.
    pub rays_per_second: f64,
    /// RAM of the display, bytes.
    pub ram_bytes: u64,
    /// What a refresh has to do, the mean of every tenth; of a display in integers alone.
    pub work: Option<Work>,
}

impl Measured {
    /// One setting on several scenes: errors as root of the mean of squares, RAM for the scene with
    /// most objects, the rest as means.
    #[must_use]
    pub fn mean(all: &[&Self]) -> Self {
        let count = all.len().max(1) as f64;
        let mean = |f: fn(&Self) -> f64| all.iter().map(|m| f(m)).sum::<f64>() / count;
        let works: Vec<&Work> = all.iter().filter_map(|m| m.work.as_ref()).collect();
        let parts: Option<Vec<ErrorParts>> = all.iter().map(|m| m.error).collect();
        let to_oracle: Option<Vec<f64>> = all.iter().map(|m| m.rmse_to_oracle).collect();
        let squares = |rmse: Vec<f64>| rmse.iter().map(|r| r * r).sum::<f64>() / count;
        Self {
            error: parts.map(|parts| ErrorParts::mean(&parts)),
            rmse: mean(|m| m.rmse.powi(2)).sqrt(),
            rmse_to_oracle: to_oracle.map(|rmse| squares(rmse).sqrt()),
            host_seconds: mean(|m| m.host_seconds),
            display_seconds: mean(|m| m.display_seconds),
            bytes_per_second: mean(|m| m.bytes_per_second),
            rays_per_second: mean(|m| m.rays_per_second),
            ram_bytes: all.iter().map(|m| m.ram_bytes).max().unwrap_or(0),
            work: (works.len() == all.len()).then(|| Work::mean(works)),
        }
    }
}

/// Every so many refreshes the error is split.
const SPLIT_EVERY: u32 = 10;

/// What should be seen at a refresh, and what a display would make of plenty of samples.
#[derive(Debug)]
pub struct Instant {
    /// The ideal picture.
    pub reference: Reference,
    /// A stream of plenty of samples and their number, where the error is split.
    plenty: Option<(Vec<u8>, usize)>,
}

impl Instant {
    /// Of refresh `index`; without `split` the error is not split there.
    ///
    /// # Errors
    /// The scene cannot be sent.
    pub fn new(index: u32, reference: Reference, world: &World, split: bool) -> Result<Self> {
        let splits = split && (index + 1).is_multiple_of(SPLIT_EVERY);
        let plenty = splits.then(|| stream::dense(world, reference.time));
        Ok(Self {
            plenty: plenty.transpose()?,
            reference,
        })
    }
}

/// Measures a setting on its stream. `instants[k]` belongs to refresh `first + k`.
///
/// # Errors
/// A display cannot be set up; the stream was damaged.
pub fn measure(
    knobs: &Knobs,
    size: Size,
    stream: &Stream,
    world: &World,
    first: u32,
    instants: &[Instant],
) -> Result<Measured> {
    let job = Job {
        knobs,
        size,
        stream,
        world,
        first,
        instants,
    };
    match knobs.format {
        Format::Fixed => {
            job.run::<Fixed>(|display, now, arrived| Some(Work::of(display, now, arrived)))
        }
        Format::F32 => job.run::<f32>(|_, _, _| None),
        Format::F64 => job.run::<f64>(|_, _, _| None),
        Format::Narrow(narrow) => narrow.run(&job),
    }
}

impl In for &Job<'_> {
    type Output = Result<Measured>;

    fn numbers<A: Arith>(self) -> Self::Output {
        self.run::<A>(|_, _, _| None)
    }
}

struct Job<'a> {
    knobs: &'a Knobs,
    size: Size,
    stream: &'a Stream,
    world: &'a World,
    first: u32,
    instants: &'a [Instant],
}

impl Job<'_> {
    fn run<A: Arith>(
        &self,
        work_of: impl Fn(&Display<'_, A>, Tick, Work) -> Option<Work>,
    ) -> Result<Measured> {
        let Size { width, height } = self.size;
        let pixels = u32::from(width) * u32::from(height);
        let samples = self.knobs.samples(pixels) as usize;
        let mut storage = HeapStorage::<A>::new(width, height, samples);
        let display = Display::new(self.knobs.display, width, height, storage.memory())
            .context("cannot set up the display")?;
        let mut player = Player::new(display);
        let mut replica = Replica::new(width, height, samples);
        let mut error = SquaredError::default();
        // As shown, exact, fresh, of plenty; and shown against exact.
        let mut chain = [SquaredError::default(); 5];
        let mut times = Vec::new();
        let mut works = Vec::new();
        let mut arrivals = Arrivals::default();
        for (index, bytes) in self.stream.refreshes.iter().enumerate() {
            let mut input = &bytes[..];
            let watch = Stopwatch::start();
            let refresh = player
                .push(&mut input)
                .context("a stream without a refresh")?;
            let seconds = watch.seconds();
            replica.receive(bytes);
            let arrived = arrivals.read(bytes);
            let counted = (index as u32).checked_sub(self.first);
            let Some(instant) = counted.and_then(|k| self.instants.get(k as usize)) else {
                continue;
            };
            let reference = &instant.reference;
            times.push(seconds);
            let shown = player.display().picture();
            error = error.plus(self.error(&reference.image, shown)?);
            if let Some(plenty) = &instant.plenty {
                works.extend(work_of(player.display(), refresh.time, arrived));
                let links = self.split(&replica, reference, plenty, shown)?;
                for (sum, link) in chain.iter_mut().zip(links) {
                    *sum = sum.plus(link);
                }
            }
        }
        let link = player.receiver().counters();
        ensure!(
            link.lost == 0 && link.damaged == 0,
            "the display lost packets of a recorded stream"
        );
        times.sort_unstable_by(f64::total_cmp);
        let median = times.get(times.len() / 2).copied().unwrap_or(0.0);
        let split = self.instants.iter().any(|instant| instant.plenty.is_some());
        let [shown, exact, fresh, plenty, rounding] = chain.map(SquaredError::mean);
        Ok(Measured {
            error: split.then_some(ErrorParts {
                arithmetic: shown - exact,
                delay: exact - fresh,
                sampling: fresh - plenty,
                filtering: plenty,
                total: shown,
            }),
            rmse: error.rmse(),
            rmse_to_oracle: split.then(|| rounding.sqrt()),
            host_seconds: self.stream.host_seconds,
            display_seconds: median * f64::from(REFRESH_HZ),
            bytes_per_second: self.stream.bytes_per_second,
            rays_per_second: self.stream.rays_per_second,
            ram_bytes: ram::bytes::<A>(
                width,
                height,
                samples,
                &self.knobs.display,
                self.world.object_count() + 1,
            ),
            work: (!works.is_empty()).then(|| Work::mean(&works)),
        })
    }

    fn split(
        &self,
        replica: &Replica,
        reference: &Reference,
        (stream, samples): &(Vec<u8>, usize),
        shown: &[[u8; 3]],
    ) -> Result<[SquaredError; 5]> {
        let display = self.knobs.display;
        let exact = replica.picture::<f64>(display, &replica.colours())?;
        let fresh = replica.fresh_colours(self.world, reference.time)?;
        let fresh = replica.picture::<f64>(display, &fresh)?;
        let plenty = picture_of(stream, *samples, replica, display)?;
        Ok([
            self.error(&reference.image, shown)?,
            self.error(&reference.image, &exact)?,
            self.error(&reference.image, &fresh)?,
            self.error(&reference.image, &plenty)?,
            self.error(&exact, shown)?,
        ])
    }

    fn error(&self, a: &[[u8; 3]], b: &[[u8; 3]]) -> Result<SquaredError> {
        let (width, height) = (usize::from(self.size.width), usize::from(self.size.height));
        let image = |pixels| Image::new(pixels, width, height);
        Ok(SquaredError::between(image(a)?, image(b)?)?)
    }
}
