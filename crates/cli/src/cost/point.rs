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
//! | and each sample the mean of its pixel in *I* | noise of single samples | filtering (what is left) |
//!
//! So the parts add up to the whole by construction. A part can be negative: a lag may hide noise.
//! Holes that no sample reached count as filtering: filling is what answers for them.

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use unframed_host::trace::World;
use unframed_metrics::{Image, SquaredError};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Arith, Display, Fixed, Player};

use super::knobs::{Format, Knobs};
use super::ram;
use super::stream::Stream;
use crate::args::Size;
use crate::eval::Reference;
use crate::measure::REFRESH_HZ;
use crate::replica::Replica;
use crate::work::Stopwatch;

/// Mean squared error in displayed levels (0..255) squared, and its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorParts {
    /// Too few samples: the noise of each being one ray.
    pub sampling: f64,
    /// The filter's own: blur, and holes filled.
    pub filtering: f64,
    /// Rounding: against the same in `f64`.
    pub arithmetic: f64,
    /// Samples that are not of the instant shown.
    pub delay: f64,
    /// All of it.
    pub total: f64,
}

/// A setting, measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Split, at every tenth refresh.
    pub error: ErrorParts,
    /// Over every refresh counted: root of the mean of squares, levels.
    pub rmse: f64,
    /// RMSE against the same in `f64` at every tenth refresh, levels.
    pub rmse_to_oracle: f64,
    /// Core seconds of the host for a second of animation.
    pub host_seconds: f64,
    /// Core seconds of the display for a second of animation: median refresh × refresh rate.
    pub display_seconds: f64,
    /// Stream bytes a second, all packets counted.
    pub bytes_per_second: f64,
    /// RAM of the display, bytes.
    pub ram_bytes: u64,
}

/// Every so many refreshes the error is split.
const SPLIT_EVERY: u32 = 10;

/// Measures a setting on its stream. `references[k]` belongs to refresh `first + k`.
///
/// # Errors
/// A display cannot be set up; the stream was damaged.
pub fn measure(
    knobs: &Knobs,
    size: Size,
    stream: &Stream,
    world: &World,
    first: u32,
    references: &[Reference],
) -> Result<Measured> {
    let job = Job {
        knobs,
        size,
        stream,
        world,
        first,
        references,
    };
    match knobs.format {
        Format::Fixed => job.run::<Fixed>(),
        Format::F32 => job.run::<f32>(),
        Format::F64 => job.run::<f64>(),
    }
}

struct Job<'a> {
    knobs: &'a Knobs,
    size: Size,
    stream: &'a Stream,
    world: &'a World,
    first: u32,
    references: &'a [Reference],
}

impl Job<'_> {
    fn run<A: Arith>(&self) -> Result<Measured> {
        let Size { width, height } = self.size;
        let pixels = u32::from(width) * u32::from(height);
        let samples = self.knobs.samples(pixels) as usize;
        let mut storage = HeapStorage::<A>::new(width, height, samples);
        let display = Display::new(self.knobs.display, width, height, storage.memory())
            .context("cannot set up the display")?;
        let mut player = Player::new(display);
        let mut replica = Replica::new(width, height, samples);
        let mut error = SquaredError::default();
        // As shown, exact, fresh, without noise; and shown against exact.
        let mut chain = [SquaredError::default(); 5];
        let mut times = Vec::new();
        for (index, bytes) in self.stream.refreshes.iter().enumerate() {
            let mut input = &bytes[..];
            let watch = Stopwatch::start();
            while player.push(&mut input).is_some() {}
            let seconds = watch.seconds();
            replica.receive(bytes);
            let counted = (index as u32).checked_sub(self.first);
            let Some(reference) = counted.and_then(|k| self.references.get(k as usize)) else {
                continue;
            };
            times.push(seconds);
            let shown = player.display().picture();
            error = error.plus(self.error(&reference.image, shown)?);
            if (index as u32 + 1).is_multiple_of(SPLIT_EVERY) {
                let links = self.split(&replica, reference, shown)?;
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
        let [shown, exact, fresh, smooth, rounding] = chain.map(SquaredError::mean);
        Ok(Measured {
            error: ErrorParts {
                arithmetic: shown - exact,
                delay: exact - fresh,
                sampling: fresh - smooth,
                filtering: smooth,
                total: shown,
            },
            rmse: error.rmse(),
            rmse_to_oracle: rounding.sqrt(),
            host_seconds: self.stream.host_seconds,
            display_seconds: median * f64::from(REFRESH_HZ),
            bytes_per_second: self.stream.bytes_per_second,
            ram_bytes: ram::bytes::<A>(
                width,
                height,
                samples,
                self.knobs.display.fit,
                self.world.object_count() + 1,
            ),
        })
    }

    fn split(
        &self,
        replica: &Replica,
        reference: &Reference,
        shown: &[[u8; 3]],
    ) -> Result<[SquaredError; 5]> {
        let display = self.knobs.display;
        let exact = replica.picture::<f64>(display, &replica.colours())?;
        let fresh = replica.fresh_colours(self.world, reference.time)?;
        let fresh = replica.picture::<f64>(display, &fresh)?;
        let smooth = replica.ideal_colours(&reference.image);
        let smooth = replica.picture::<f64>(display, &smooth)?;
        Ok([
            self.error(&reference.image, shown)?,
            self.error(&reference.image, &exact)?,
            self.error(&reference.image, &fresh)?,
            self.error(&reference.image, &smooth)?,
            self.error(&exact, shown)?,
        ])
    }

    fn error(&self, a: &[[u8; 3]], b: &[[u8; 3]]) -> Result<SquaredError> {
        let (width, height) = (usize::from(self.size.width), usize::from(self.size.height));
        let image = |pixels| Image::new(pixels, width, height);
        Ok(SquaredError::between(image(a)?, image(b)?)?)
    }
}
