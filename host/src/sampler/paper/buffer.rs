//! The sampler's deep buffer: a short queue of crosshairs at each pixel (§4).

use super::crosshair::Crosshair;

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
    /// Pixel by pixel, `depth` ids each.
    queues: Vec<u32>,
    /// b: places in a pixel's queue.
    depth: usize,
}

impl DeepBuffer {
    /// Empty queues of `depth` places; 0 counts as 1.
    pub(super) fn new(pixels: usize, depth: u16) -> Self {
        let depth = usize::from(depth.max(1));
        Self {
            pool: Vec::new(),
            free: Vec::new(),
            queues: vec![NONE; depth * pixels],
            depth,
        }
    }

    /// The ids of a pixel's queue, from the front.
    fn ids(&self, pixel: u32) -> &[u32] {
        let first = pixel as usize * self.depth;
        &self.queues[first..first + self.depth]
    }

    fn ids_mut(&mut self, pixel: u32) -> &mut [u32] {
        let first = pixel as usize * self.depth;
        &mut self.queues[first..first + self.depth]
    }

    /// Crosshairs stored: |buffer|.
    pub(super) fn len(&self) -> usize {
        self.pool.len() - self.free.len()
    }

    /// The queue of a pixel, from the front.
    pub(super) fn queue(&self, pixel: u32) -> impl Iterator<Item = &Crosshair> {
        let ids = self.ids(pixel).iter();
        ids.take_while(|&&id| id != NONE)
            .map(|&id| &self.pool[id as usize])
    }

    /// The youngest crosshair of a pixel: at the front but for reprojected ones.
    pub(super) fn newest(&self, pixel: u32) -> Option<&Crosshair> {
        self.queue(pixel).max_by(|a, b| a.time.total_cmp(&b.time))
    }

    /// Takes out the crosshair at the front of a pixel's queue.
    pub(super) fn pop_front(&mut self, pixel: u32) -> Option<Crosshair> {
        let queue = self.ids_mut(pixel);
        let id = queue[0];
        if id == NONE {
            return None;
        }
        queue[0] = NONE;
        queue.rotate_left(1);
        self.free.push(id);
        Some(self.pool[id as usize])
    }

    /// Puts a crosshair at the front of its pixel's queue; hands back the one that fell out at the
    /// back.
    pub(super) fn push_front(&mut self, crosshair: Crosshair) -> Option<Crosshair> {
        let id = self.store(crosshair);
        let queue = self.ids_mut(crosshair.pixel);
        queue.rotate_right(1);
        let out = std::mem::replace(&mut queue[0], id);
        self.release(out)
    }

    /// Puts a reprojected crosshair at the back of its pixel's queue. If the queue is full, the
    /// older of it and the one at the back falls out.
    pub(super) fn push_back(&mut self, crosshair: Crosshair) -> Option<Crosshair> {
        let queue = self.ids(crosshair.pixel);
        let last = queue.len() - 1;
        let place = queue.iter().position(|&id| id == NONE);
        let back = queue[last];
        if place.is_none() && self.pool[back as usize].time > crosshair.time {
            return Some(crosshair);
        }
        let id = self.store(crosshair);
        let place = &mut self.ids_mut(crosshair.pixel)[place.unwrap_or(last)];
        let out = std::mem::replace(place, id);
        self.release(out)
    }

    /// Takes out the crosshair of a pixel that is of the same sample as `like`, if it is there.
    pub(super) fn remove(&mut self, like: &Crosshair) -> Option<Crosshair> {
        let place = self
            .queue(like.pixel)
            .position(|own| own.time == like.time && own.centre == like.centre)?;
        let queue = self.ids_mut(like.pixel);
        let id = std::mem::replace(&mut queue[place], NONE);
        queue[place..].rotate_left(1);
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
        let ids = self.queues.iter().filter(|&&id| id != NONE);
        ids.map(|&id| &self.pool[id as usize])
    }
}
