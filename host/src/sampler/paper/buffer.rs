//! The sampler's deep buffer: a short queue of crosshairs at each pixel (§4).

use super::crosshair::Crosshair;

/// b: places in a pixel's queue.
pub(super) const DEPTH: usize = 4;
/// No crosshair.
const NONE: u32 = u32::MAX;

/// The queues. Crosshairs have ids, so that moving one between queues moves four bytes.
///
/// Invariant: each id is in exactly one queue or in `free`; a queue's ids come before its
/// [`NONE`]s; a crosshair's `pixel` is that of its queue.
#[derive(Clone, Debug)]
pub(super) struct DeepBuffer {
    pool: Vec<Crosshair>,
    free: Vec<u32>,
    queues: Vec<[u32; DEPTH]>,
}

impl DeepBuffer {
    pub(super) fn new(pixels: usize) -> Self {
        Self {
            pool: Vec::new(),
            free: Vec::new(),
            queues: vec![[NONE; DEPTH]; pixels],
        }
    }

    /// Crosshairs stored: |buffer|.
    pub(super) fn len(&self) -> usize {
        self.pool.len() - self.free.len()
    }

    /// The queue of a pixel, from the front.
    pub(super) fn queue(&self, pixel: u32) -> impl Iterator<Item = &Crosshair> {
        let ids = self.queues[pixel as usize].iter();
        ids.take_while(|&&id| id != NONE)
            .map(|&id| &self.pool[id as usize])
    }

    /// The youngest crosshair of a pixel: at the front but for reprojected ones.
    pub(super) fn newest(&self, pixel: u32) -> Option<&Crosshair> {
        self.queue(pixel).max_by(|a, b| a.time.total_cmp(&b.time))
    }

    /// Takes out the crosshair at the front of a pixel's queue.
    pub(super) fn pop_front(&mut self, pixel: u32) -> Option<Crosshair> {
        let queue = &mut self.queues[pixel as usize];
        let id = queue[0];
        if id == NONE {
            return None;
        }
        queue.rotate_left(1);
        queue[DEPTH - 1] = NONE;
        self.free.push(id);
        Some(self.pool[id as usize])
    }

    /// Puts a crosshair at the front of its pixel's queue; hands back the one that fell out at the
    /// back.
    pub(super) fn push_front(&mut self, crosshair: Crosshair) -> Option<Crosshair> {
        let id = self.store(crosshair);
        let queue = &mut self.queues[crosshair.pixel as usize];
        queue.rotate_right(1);
        let out = std::mem::replace(&mut queue[0], id);
        self.release(out)
    }

    /// Puts a reprojected crosshair at the back of its pixel's queue. If the queue is full, the
    /// older of it and the one at the back falls out.
    pub(super) fn push_back(&mut self, crosshair: Crosshair) -> Option<Crosshair> {
        let queue = self.queues[crosshair.pixel as usize];
        let place = queue.iter().position(|&id| id == NONE);
        let back = queue[DEPTH - 1];
        if place.is_none() && self.pool[back as usize].time > crosshair.time {
            return Some(crosshair);
        }
        let id = self.store(crosshair);
        let place = place.unwrap_or(DEPTH - 1);
        let out = std::mem::replace(&mut self.queues[crosshair.pixel as usize][place], id);
        self.release(out)
    }

    /// Takes out the crosshair of a pixel that is of the same sample as `like`, if it is there.
    pub(super) fn remove(&mut self, like: &Crosshair) -> Option<Crosshair> {
        let pool = &self.pool;
        let queue = &mut self.queues[like.pixel as usize];
        let place = queue.iter().position(|&id| {
            id != NONE
                && pool[id as usize].time == like.time
                && pool[id as usize].centre == like.centre
        })?;
        let id = queue[place];
        queue[place..].rotate_left(1);
        queue[DEPTH - 1] = NONE;
        self.release(id)
    }

    fn store(&mut self, crosshair: Crosshair) -> u32 {
        match self.free.pop() {
            Some(id) => {
                self.pool[id as usize] = crosshair;
                id
            }
            None => {
                self.pool.push(crosshair);
                self.pool.len() as u32 - 1
            }
        }
    }

    fn release(&mut self, id: u32) -> Option<Crosshair> {
        (id != NONE).then(|| {
            self.free.push(id);
            self.pool[id as usize]
        })
    }

    /// All crosshairs, queue by queue.
    #[cfg(test)]
    pub(super) fn iter(&self) -> impl Iterator<Item = &Crosshair> {
        let ids = self.queues.iter().flatten().filter(|&&id| id != NONE);
        ids.map(|&id| &self.pool[id as usize])
    }
}
