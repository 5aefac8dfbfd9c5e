//! All points of all sweeps, measured on all cores, each on one, none twice.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use unframed_host::sampler::adaptive;
use unframed_host::trace::World;

use super::knobs::{Knobs, Planned};
use super::point::{Instant, Measured, measure};
use super::stream::Stream;
use crate::args::Size;
use crate::eval::Cache;
use crate::eval::store::{Key, write_whole};
use crate::measure::{IDEAL_GRID, REFRESH_HZ};

/// Raise this when what a point means changes: old files are not used any more.
const VERSION: u32 = 4;
/// Seconds before anything counts: the display fills.
pub const WARM_UP: f64 = 0.5;

/// What all points share.
pub struct Study {
    /// The scene's name.
    pub name: String,
    /// The scene at the panel's size.
    pub world: World,
    /// Panel size.
    pub size: Size,
    /// Refreshes, the warm-up's included.
    pub refreshes: u32,
    /// Seed of everything random.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Whether errors are split. That traces samples again with one ray for each effect, and so
    /// would count the noise of effects among others where a scene calls for them.
    pub split: bool,
    /// Where finished points are kept.
    pub dir: PathBuf,
}

impl Study {
    /// Pixels of the panel.
    #[must_use]
    pub fn pixels(&self) -> u32 {
        u32::from(self.size.width) * u32::from(self.size.height)
    }

    /// The first refresh that counts.
    fn first(&self) -> u32 {
        ((WARM_UP * f64::from(REFRESH_HZ)) as u32).min(self.refreshes.saturating_sub(10))
    }

    fn path(&self, knobs: &Knobs) -> PathBuf {
        let scene = Key::of_scene(self.world.scene());
        let key = scene.with(format_args!(
            "{VERSION} {knobs:?} {:?} {} {} {} {IDEAL_GRID} {:?}",
            self.size,
            self.refreshes,
            self.seed,
            self.split,
            adaptive::Config::default(),
        ));
        self.dir.join(format!("{key}.json"))
    }

    fn finished(&self, knobs: &Knobs) -> Option<Measured> {
        serde_json::from_slice(&std::fs::read(self.path(knobs)).ok()?).ok()
    }

    /// Measures all points; those that are finished already are not measured again unless `fresh`.
    /// The results are in the order of the points.
    ///
    /// # Errors
    /// A scene cannot be sent, a display not be set up, a file not be written.
    pub fn run(
        &self,
        points: &[Planned],
        ideals: &Path,
        fresh: bool,
        progress: &ProgressBar,
    ) -> Result<Vec<Measured>> {
        let mut todo: Vec<Knobs> = Vec::new();
        for point in points {
            if !todo.contains(&point.knobs) && (fresh || self.finished(&point.knobs).is_none()) {
                todo.push(point.knobs);
            }
        }
        if !todo.is_empty() {
            self.measure_all(&todo, ideals, progress)?;
        }
        points
            .iter()
            .map(|point| {
                self.finished(&point.knobs)
                    .with_context(|| format!("the point {:?} has vanished", point.knobs))
            })
            .collect()
    }

    fn measure_all(&self, todo: &[Knobs], ideals: &Path, progress: &ProgressBar) -> Result<()> {
        let first = self.first();
        // Displays of the same stream share it: whatever the display, the host does the same.
        let mut streams: Vec<Knobs> = Vec::new();
        let same = |a: &Knobs, b: &Knobs| {
            (a.method, a.density, a.sampling, a.detail)
                == (b.method, b.density, b.sampling, b.detail)
        };
        for knobs in todo {
            if !streams.iter().any(|other| same(knobs, other)) {
                streams.push(*knobs);
            }
        }
        progress
            .set_length(u64::from(self.refreshes - first) + (streams.len() + todo.len()) as u64);
        progress.set_message("ideal pictures");
        let cache = Cache::new(ideals, &self.name, &self.world, IDEAL_GRID)?;
        let mut world = self.world.clone();
        let instants: Vec<Instant> = (first..self.refreshes)
            .map(|index| {
                progress.inc(1);
                let reference = cache.reference(&mut world, index)?;
                Instant::new(index, reference, &self.world, self.split)
            })
            .collect::<Result<_>>()?;
        progress.set_message("streams");
        let recorded = parallel(self.threads, streams.len(), |i| {
            let knobs = &streams[i];
            let stream = Stream::record(
                knobs,
                self.size,
                self.seed,
                &self.world,
                self.refreshes,
                first,
            )?;
            progress.inc(1);
            Ok(stream)
        })?;
        progress.set_message("points");
        // The longest first, so that no thread waits long for the last.
        let mut order: Vec<&Knobs> = todo.iter().collect();
        order.sort_by_key(|knobs| std::cmp::Reverse(knobs.samples(self.pixels())));
        parallel(self.threads, order.len(), |i| {
            let knobs = order[i];
            let stream = streams.iter().position(|other| same(knobs, other));
            let stream = stream.and_then(|k| recorded.get(k)).context("no stream")?;
            let measured = measure(knobs, self.size, stream, &self.world, first, &instants)?;
            write_whole(&self.path(knobs), &serde_json::to_vec_pretty(&measured)?)?;
            progress.inc(1);
            if progress.is_hidden() {
                let line = knobs.described(self.pixels()).line();
                eprintln!(
                    "{}/{}: {line}: RMSE {:.2}",
                    i + 1,
                    order.len(),
                    measured.rmse
                );
            }
            Ok(())
        })?;
        Ok(())
    }
}

/// Does `count` pieces of work on so many threads; the results are in order. What a piece does in
/// parallel stays on its own thread, so that its time can be told.
///
/// # Errors
/// The first in the order of the pieces; others may not have been begun.
pub fn parallel<T: Send>(
    threads: usize,
    count: usize,
    work: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let next = AtomicUsize::new(0);
    let done: Mutex<BTreeMap<usize, Result<T>>> = Mutex::default();
    std::thread::scope(|scope| -> Result<()> {
        for _ in 0..threads.clamp(1, count.max(1)) {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .build()
                .context("cannot start a worker")?;
            let (next, done, work) = (&next, &done, &work);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        break;
                    }
                    let result = pool.install(|| work(index));
                    if result.is_err() {
                        next.store(count, Ordering::Relaxed);
                    }
                    let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                    done.insert(index, result);
                }
            });
        }
        Ok(())
    })?;
    let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    let results = done.into_values().collect::<Result<Vec<T>>>()?;
    anyhow::ensure!(results.len() == count, "a worker died");
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_done_once_in_order_and_errors_are_kept() {
        let squares = parallel(3, 50, |i| Ok(i * i)).unwrap();
        assert_eq!(squares, (0..50).map(|i| i * i).collect::<Vec<_>>());
        let failed = parallel(3, 50, |i| {
            anyhow::ensure!(i != 7, "seven");
            Ok(i)
        });
        assert_eq!(failed.unwrap_err().to_string(), "seven");
        assert!(parallel(2, 0, |_| Ok(())).unwrap().is_empty());
    }
}
