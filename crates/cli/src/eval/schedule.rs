//! Runs cells on all cores, each on one, and none twice.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use unframed_host::trace::World;

use super::cell::{self, Cell, Job};
use super::ideals::Reference;
use super::store::write_whole;

/// The file of a finished cell.
#[must_use]
pub fn cell_path(dir: &Path, job: &Job) -> PathBuf {
    dir.join(job.file_stem() + ".json")
}

/// A cell that was finished before, if its file is whole.
#[must_use]
pub fn finished(dir: &Path, job: &Job) -> Option<Cell> {
    serde_json::from_slice(&std::fs::read(cell_path(dir, job)).ok()?).ok()
}

/// What the workers share.
pub struct Workshop<'a> {
    /// Where cells are kept.
    pub dir: &'a Path,
    /// Number of workers, at least 1.
    pub threads: usize,
    /// Which program this is.
    pub build: &'a str,
    /// Counts refreshes.
    pub progress: &'a ProgressBar,
    /// When all began, for the estimate.
    pub begin: Instant,
}

/// A job and what it needs.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// What to do.
    pub job: &'a Job,
    /// The scene.
    pub world: &'a World,
    /// What should be seen, from the first refresh that counts on.
    pub references: &'a [Reference],
}

impl Task<'_> {
    /// About how long it takes, in no unit.
    fn weight(&self) -> f64 {
        let settings = self.job.method.settings().len();
        // A refresh costs the display about as much as half a million samples cost a host in a
        // second.
        f64::from(self.job.settings.refreshes) * (f64::from(self.job.rate) + 5e5) * settings as f64
    }
}

impl Workshop<'_> {
    /// Runs tasks, the longest first, so that no worker waits long for the last; the results are
    /// in the order of the tasks, whatever the number of workers. Each is on disk as soon as it
    /// is done.
    ///
    /// # Errors
    /// One of those that failed; others may not have run.
    pub fn run(&self, tasks: &[Task<'_>]) -> Result<Vec<Cell>> {
        let mut order: Vec<usize> = (0..tasks.len()).collect();
        order.sort_by(|a, b| tasks[*b].weight().total_cmp(&tasks[*a].weight()));
        let next = AtomicUsize::new(0);
        let done: Vec<Mutex<Option<Result<Cell>>>> =
            tasks.iter().map(|_| Mutex::default()).collect();
        std::thread::scope(|scope| -> Result<()> {
            for _ in 0..self.threads.clamp(1, tasks.len().max(1)) {
                // One thread, so that no task waits inside another one's work.
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(1)
                    .build()
                    .context("cannot start a worker")?;
                let (next, done, order) = (&next, &done, &order);
                scope.spawn(move || {
                    loop {
                        let turn = next.fetch_add(1, Ordering::Relaxed);
                        let Some(&index) = order.get(turn) else { break };
                        let result = pool.install(|| self.one(&tasks[index]));
                        if result.is_err() {
                            next.store(tasks.len(), Ordering::Relaxed);
                        }
                        let slot = &done[index];
                        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
                    }
                });
            }
            Ok(())
        })?;
        let results = done
            .into_iter()
            .filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner));
        let cells = results.collect::<Result<Vec<Cell>>>()?;
        anyhow::ensure!(cells.len() == tasks.len(), "a worker died");
        Ok(cells)
    }

    fn one(&self, task: &Task<'_>) -> Result<Cell> {
        let Task {
            job,
            world,
            references,
        } = *task;
        let tick = || self.progress.inc(1);
        let stem = self.dir.join(job.file_stem());
        let cell = cell::run(job, world, references, &stem, self.build, &tick)
            .with_context(|| format!("{} on {}", job.method, job.scene))?;
        write_whole(
            &cell_path(self.dir, job),
            &serde_json::to_vec_pretty(&cell)?,
        )?;
        if self.progress.is_hidden() {
            eprintln!("{}", self.line(&cell));
        }
        Ok(cell)
    }

    /// A line for those who have no progress bar.
    fn line(&self, cell: &Cell) -> String {
        let (done, all) = (
            self.progress.position(),
            self.progress.length().unwrap_or(0),
        );
        let spent = self.begin.elapsed().as_secs_f64();
        let left = spent * all.saturating_sub(done) as f64 / done.max(1) as f64;
        format!(
            "{:3.0} %, about {:.0} s left: {} {} at {} samples/s, seed {}: RMSE {:.2}",
            100.0 * done as f64 / all.max(1) as f64,
            left,
            cell.scene,
            cell.method,
            cell.rate,
            cell.seed,
            cell.rmse,
        )
    }
}
