//! The deep buffer: the newest N samples in a ring.

use unframed_wire::{Shares, Tick};

/// How [`Stored::place`] is to be read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Placing {
    /// Nothing is stored here.
    #[default]
    Empty,
    /// A lattice point of an object.
    Lattice,
    /// Screen coordinates in 1/16 pixel (as `u16` bits) and depth 0.
    Screen,
}

/// One stored sample: 16 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Stored {
    /// When it was taken.
    pub time: u32,
    /// Where, see [`Placing`].
    pub place: [i16; 3],
    /// Red, green, blue, as received.
    pub rgb: [u8; 3],
    /// Index of the pose, see [`slot`].
    pub slot: u8,
    /// How `place` is to be read.
    pub placing: Placing,
    /// What lamps bring of its light, see [`crate::light`].
    pub shares: Shares,
}

const _: () = assert!(core::mem::size_of::<Stored>() == 16);

impl Stored {
    /// Nothing stored.
    pub const EMPTY: Self = Self {
        time: 0,
        place: [0; 3],
        rgb: [0; 3],
        slot: 0,
        placing: Placing::Empty,
        shares: Shares(0),
    };
}

/// The pose slot of an object: the sky first, then objects from 0.
#[must_use]
pub const fn slot(object: u8) -> u8 {
    object.wrapping_add(1)
}

/// The ring over the caller's storage.
#[derive(Debug)]
pub struct DeepBuffer<'a> {
    samples: &'a mut [Stored],
    next: usize,
    len: usize,
    fresh: usize,
}

impl<'a> DeepBuffer<'a> {
    /// An empty ring that holds as many samples as `storage`.
    pub fn new(storage: &'a mut [Stored]) -> Self {
        Self {
            samples: storage,
            next: 0,
            len: 0,
            fresh: 0,
        }
    }

    /// Samples stored.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether nothing is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Stores a sample in the place of the oldest.
    #[inline]
    pub fn push(&mut self, sample: Stored) {
        if let Some(place) = self.samples.get_mut(self.next) {
            *place = sample;
            self.next += 1;
            self.fresh = self.samples.len().min(self.fresh + 1);
            self.len = self.len.max(self.next);
            if self.next == self.samples.len() {
                self.next = 0;
            }
        }
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.next = 0;
        self.len = 0;
        self.fresh = 0;
    }

    /// The newest samples, `most` at most, that were stored since this was last asked; in two
    /// parts, as the ring has an end.
    pub fn take_fresh(&mut self, most: usize) -> [&[Stored]; 2] {
        let count = core::mem::take(&mut self.fresh).min(most);
        let early = count.saturating_sub(self.next);
        let (before, end) = (self.next + early - count, self.samples.len());
        [
            self.samples.get(end - early..).unwrap_or(&[]),
            self.samples.get(before..self.next).unwrap_or(&[]),
        ]
    }

    /// The stored samples, in no order.
    #[must_use]
    pub fn samples(&self) -> &[Stored] {
        self.samples.get(..self.len).unwrap_or(&[])
    }

    /// The same, to be changed in place.
    pub fn samples_mut(&mut self) -> &mut [Stored] {
        self.samples.get_mut(..self.len).unwrap_or(&mut [])
    }
}

/// Age in microseconds at `now`: 0 for samples from the future, `None` when so old (or so far
/// ahead: 2^30 µs, 17.9 minutes) that the clock's wrap would soon make it young again.
#[inline]
#[must_use]
pub const fn age(sample: u32, now: Tick) -> Option<u32> {
    let age = now.since(Tick(sample));
    if age >= 1 << 30 || age <= -(1 << 30) {
        None
    } else if age < 0 {
        Some(0)
    } else {
        Some(age as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ring_keeps_the_newest() {
        let mut storage = [Stored::default(); 3];
        let mut ring = DeepBuffer::new(&mut storage);
        for time in 0..5 {
            ring.push(Stored {
                time,
                ..Stored::default()
            });
        }
        let mut times: std::vec::Vec<_> = ring.samples().iter().map(|s| s.time).collect();
        times.sort_unstable();
        assert_eq!(times, [2, 3, 4]);
    }

    #[test]
    fn fresh_samples_are_those_since_the_last_look() {
        for (stored, most) in [
            (0, 9),
            (1, 9),
            (2, 9),
            (3, 9),
            (4, 9),
            (7, 9),
            (7, 2),
            (7, 0),
        ] {
            for offset in 0..4u32 {
                let mut storage = [Stored::default(); 4];
                let mut ring = DeepBuffer::new(&mut storage);
                let sample = |time| Stored {
                    time,
                    ..Stored::EMPTY
                };
                (0..offset).for_each(|_| ring.push(sample(99)));
                let _ = ring.take_fresh(9);
                (0..stored).for_each(|time| ring.push(sample(time)));
                let times: std::vec::Vec<_> = ring
                    .take_fresh(most)
                    .iter()
                    .flat_map(|part| part.iter().map(|sample| sample.time))
                    .collect();
                let expected: std::vec::Vec<_> =
                    (stored - stored.min(4).min(most as u32)..stored).collect();
                assert_eq!(times, expected, "{stored} {most} {offset}");
                assert!(ring.take_fresh(9).iter().all(|part| part.is_empty()));
            }
        }
    }

    #[test]
    fn a_ring_without_storage_takes_nothing() {
        let mut ring = DeepBuffer::new(&mut []);
        ring.push(Stored::default());
        assert!(ring.is_empty());
    }

    #[test]
    fn age_survives_the_wrap() {
        assert_eq!(age(u32::MAX - 9, Tick(10)), Some(20));
        assert_eq!(age(10, Tick(u32::MAX - 9)), Some(0));
        assert_eq!(age(0, Tick(1 << 30)), None);
        assert_eq!(age(0, Tick(1 << 31)), None);
    }
}
