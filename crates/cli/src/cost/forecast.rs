//! What a setting will cost on another panel: its host and its display are run here, on that
//! panel, and their work is counted; a [`Law`] tells what the work costs on a core.

use anyhow::{Context, Result, ensure};
use unframed_host::scene::Scene;
use unframed_host::trace::World;
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Config, Display, Fixed, Player};

use super::effort::{Arrivals, Effort, Law, Work};
use super::knobs::Knobs;
use super::stream::Stream;
use crate::args::Size;
use crate::measure::REFRESH_HZ;
use crate::work::Stopwatch;

/// A stream as the deployed display shows it.
#[derive(Debug)]
pub struct Played {
    /// The picture of every refresh.
    pub pictures: Vec<Vec<[u8; 3]>>,
    /// What every refresh had to do.
    pub work: Vec<Work>,
    /// Core seconds of every refresh here.
    pub seconds: Vec<f64>,
}

impl Played {
    /// Plays a stream here.
    ///
    /// # Errors
    /// The display cannot be set up; the stream was damaged.
    pub fn new(config: Config, size: Size, samples: usize, stream: &Stream) -> Result<Self> {
        let Size { width, height } = size;
        let mut storage = HeapStorage::<Fixed>::new(width, height, samples);
        let display = Display::new(config, width, height, storage.memory())
            .context("cannot set up the display")?;
        let mut player = Player::new(display);
        let mut played = Self {
            pictures: Vec::new(),
            work: Vec::new(),
            seconds: Vec::new(),
        };
        let mut arrivals = Arrivals::default();
        for bytes in &stream.refreshes {
            let mut input = &bytes[..];
            let watch = Stopwatch::start();
            let refresh = player
                .push(&mut input)
                .context("a stream without a refresh")?;
            played.seconds.push(watch.seconds());
            let display = player.display();
            let work = Work::of(display, refresh.time, arrivals.read(bytes));
            played.work.push(work);
            played.pictures.push(display.picture().to_vec());
        }
        let link = player.receiver().counters();
        ensure!(
            link.lost == 0 && link.damaged == 0,
            "the display lost packets of a recorded stream"
        );
        Ok(played)
    }
}

/// Panels beyond this many pixels are not run: they cost by the pixel what this many do.
const MOST: u32 = 160 * 160;

/// A setting on a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// Bytes a second of the stream.
    pub bytes_per_second: f64,
    /// Core seconds of the display for a second here.
    pub display_seconds: f64,
    /// What each refresh has to do, the warm-up left out.
    work: Vec<Work>,
    /// Pixels of the panel over those of the panel that was run.
    scale: f64,
}

impl Forecast {
    /// Runs a setting on a panel for `refreshes`, of which those from `first` on count.
    ///
    /// # Errors
    /// The scene cannot be sent, a display not be set up.
    pub fn new(
        knobs: &Knobs,
        scene: &Scene,
        size: Size,
        seed: u64,
        refreshes: u32,
        first: u32,
    ) -> Result<Self> {
        let run = smaller(size);
        let pixels = |size: Size| u32::from(size.width) * u32::from(size.height);
        let world = World::new(scene.clone(), [run.width, run.height].map(u32::from))?;
        let stream = Stream::record(knobs, run, seed, &world, refreshes, first)?;
        let samples = knobs.samples(pixels(run)) as usize;
        let played = Played::new(knobs.display, run, samples, &stream)?;
        let counted = first as usize..;
        let mut seconds = played
            .seconds
            .get(counted.clone())
            .unwrap_or_default()
            .to_vec();
        seconds.sort_unstable_by(f64::total_cmp);
        let median = seconds.get(seconds.len() / 2).copied().unwrap_or(0.0);
        let scale = f64::from(pixels(size)) / f64::from(pixels(run));
        Ok(Self {
            bytes_per_second: scale * stream.bytes_per_second,
            display_seconds: scale * median * f64::from(REFRESH_HZ),
            work: played.work.get(counted).unwrap_or_default().to_vec(),
            scale,
        })
    }

    /// What it costs on a core: the mean refresh and the dearest.
    #[must_use]
    pub fn efforts(&self, law: &Law) -> (Effort, Effort) {
        let scaled = |effort: Effort| Effort {
            receive: self.scale * effort.receive,
            picture: self.scale * effort.picture,
        };
        let mean = law.predict(&Work::mean(&self.work));
        let all = self.work.iter().map(|work| law.predict(work));
        let worst = all.fold(mean, |a, b| if b.total() > a.total() { b } else { a });
        (scaled(mean), scaled(worst))
    }
}

/// The panel, or a smaller one of the same shape.
fn smaller(size: Size) -> Size {
    let pixels = f64::from(size.width) * f64::from(size.height);
    let shrink = (f64::from(MOST) / pixels).sqrt();
    if shrink >= 1.0 {
        return size;
    }
    let side = |side: u16| (f64::from(side) * shrink).round().max(1.0) as u16;
    Size {
        width: side(size.width),
        height: side(size.height),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_panels_are_run_small_and_in_shape() {
        let size = |width, height| Size { width, height };
        assert_eq!(smaller(size(128, 96)), size(128, 96));
        assert_eq!(smaller(size(1920, 1080)), size(213, 120));
        assert_eq!(smaller(size(4080, 1)), size(4080, 1));
        assert_eq!(smaller(size(1, 4080)), size(1, 4080));
    }
}
