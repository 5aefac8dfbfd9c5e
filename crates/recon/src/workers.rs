//! Who does the work of a refresh: one thread, or several (feature `threads`).
//!
//! A stage splits its output into parts that nobody else writes; parts are done in any order and
//! each is the same whoever does it, so the number of threads cannot change the picture.

/// The most parts a stage is split into.
pub const MAX_PARTS: usize = 8;

/// Does independent pieces of work.
pub trait Workers: Clone + Send + Sync + core::fmt::Debug {
    /// Pieces worth making: 1 to [`MAX_PARTS`].
    fn parts(&self) -> usize;

    /// Does `work` on every part, and returns when all are done.
    fn each<T: Send>(&self, parts: &mut [T], work: impl Fn(&mut T) + Sync);

    /// Does `work`, which calls [`Workers::each`] often: workers may wait for it in one place
    /// rather than meet anew each time.
    fn together<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        work()
    }
}

/// The thread that asks does all itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Workers for Alone {
    fn parts(&self) -> usize {
        1
    }

    fn each<T: Send>(&self, parts: &mut [T], work: impl Fn(&mut T) + Sync) {
        parts.iter_mut().for_each(work);
    }
}

/// A pool of threads.
#[cfg(feature = "threads")]
#[derive(Clone, Debug)]
pub struct Threads {
    pool: alloc::sync::Arc<rayon::ThreadPool>,
    parts: usize,
}

#[cfg(feature = "threads")]
impl Threads {
    /// A pool of `threads` threads, 1 to [`MAX_PARTS`]; more or fewer are cut to that.
    ///
    /// # Errors
    /// When the system grants no threads.
    pub fn new(threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let parts = threads.clamp(1, MAX_PARTS);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(parts).build()?;
        Ok(Self {
            pool: alloc::sync::Arc::new(pool),
            parts,
        })
    }
}

#[cfg(feature = "threads")]
impl Workers for Threads {
    fn parts(&self) -> usize {
        self.parts
    }

    fn each<T: Send>(&self, parts: &mut [T], work: impl Fn(&mut T) + Sync) {
        use rayon::iter::{IntoParallelRefMutIterator, ParallelIterator};
        if let [part] = parts {
            work(part);
        } else {
            self.pool.install(|| parts.par_iter_mut().for_each(&work));
        }
    }

    fn together<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        if self.parts == 1 {
            work()
        } else {
            self.pool.install(work)
        }
    }
}

/// Up to [`MAX_PARTS`] pieces of a stage's work, kept without a heap.
#[derive(Debug)]
pub struct Parts<T> {
    parts: [Option<T>; MAX_PARTS],
    len: usize,
}

impl<T: Send> Parts<T> {
    /// The first [`MAX_PARTS`] pieces.
    pub fn new(pieces: impl IntoIterator<Item = T>) -> Self {
        let mut pieces = pieces.into_iter();
        let parts = core::array::from_fn(|_| pieces.next());
        let len = parts.iter().flatten().count();
        Self { parts, len }
    }

    /// Does `work` on every piece.
    pub fn each(mut self, workers: &impl Workers, work: impl Fn(&mut T) + Sync) {
        let parts = self.parts.get_mut(..self.len).unwrap_or(&mut []);
        workers.each(parts, |part| {
            if let Some(part) = part {
                work(part);
            }
        });
    }
}

/// Splits off the first `len` entries of `rest`, or what there is.
pub fn take<'a, T>(rest: &mut &'a mut [T], len: usize) -> &'a mut [T] {
    let all = core::mem::take(rest);
    let len = len.min(all.len());
    let (head, tail) = all.split_at_mut_checked(len).unwrap_or_default();
    *rest = tail;
    head
}
