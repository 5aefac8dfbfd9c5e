//! A binary heap over small ids that knows where each id stands, so that the key of any id can be
//! changed in O(log n) (Sedgewick & Wayne, *Algorithms*, §2.4, "index priority queue").

/// Stands for "not in the heap".
const ABSENT: u32 = u32::MAX;

/// The largest key on top.
///
/// Invariant: `at[heap[k]] == k` for all k, no key is larger than that of the entry above
/// (`(k − 1)/2`), ties are broken by the smaller id, so that the order does not depend on history.
#[derive(Clone, Debug)]
pub(super) struct Heap {
    heap: Vec<u32>,
    at: Vec<u32>,
    keys: Vec<f64>,
}

impl Heap {
    /// An empty heap for the ids `0..ids`.
    pub(super) fn new(ids: usize) -> Self {
        Self {
            heap: Vec::new(),
            at: vec![ABSENT; ids],
            keys: vec![0.0; ids],
        }
    }

    /// The id with the largest key, and the key.
    pub(super) fn top(&self) -> Option<(u32, f64)> {
        self.heap.first().map(|&id| (id, self.keys[id as usize]))
    }

    /// Inserts an id or changes its key.
    pub(super) fn set(&mut self, id: u32, key: f64) {
        self.keys[id as usize] = key;
        let mut k = self.at[id as usize];
        if k == ABSENT {
            k = self.heap.len() as u32;
            self.at[id as usize] = k;
            self.heap.push(id);
        }
        let k = self.up(k as usize);
        self.down(k);
    }

    /// Takes an id out, if it is in.
    pub(super) fn remove(&mut self, id: u32) {
        let k = self.at[id as usize];
        if k == ABSENT {
            return;
        }
        self.at[id as usize] = ABSENT;
        let last = self.heap.len() - 1;
        let moved = self.heap[last];
        self.heap.truncate(last);
        if moved != id {
            self.heap[k as usize] = moved;
            self.at[moved as usize] = k;
            let k = self.up(k as usize);
            self.down(k);
        }
    }

    /// Puts new keys on all ids that are in, in O(n) (Floyd 1964).
    pub(super) fn rekey(&mut self, key: impl Fn(u32) -> f64) {
        for &id in &self.heap {
            self.keys[id as usize] = key(id);
        }
        for k in (0..self.heap.len() / 2).rev() {
            self.down(k);
        }
    }

    fn before(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.heap[a], self.heap[b]);
        let (x, y) = (self.keys[a as usize], self.keys[b as usize]);
        x > y || (x == y && a < b)
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.heap.swap(a, b);
        self.at[self.heap[a] as usize] = a as u32;
        self.at[self.heap[b] as usize] = b as u32;
    }

    fn up(&mut self, mut k: usize) -> usize {
        while k > 0 && self.before(k, (k - 1) / 2) {
            self.swap(k, (k - 1) / 2);
            k = (k - 1) / 2;
        }
        k
    }

    fn down(&mut self, mut k: usize) {
        loop {
            let first = 2 * k + 1;
            let mut best = k;
            for child in [first, first + 1] {
                if child < self.heap.len() && self.before(child, best) {
                    best = child;
                }
            }
            if best == k {
                return;
            }
            self.swap(k, best);
            k = best;
        }
    }

    #[cfg(test)]
    pub(super) fn contains(&self, id: u32) -> bool {
        self.at[id as usize] != ABSENT
    }

    #[cfg(test)]
    pub(super) fn key(&self, id: u32) -> f64 {
        self.keys[id as usize]
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.heap.len()
    }

    /// Panics where the invariant does not hold.
    #[cfg(test)]
    pub(super) fn check(&self) {
        for (k, &id) in self.heap.iter().enumerate() {
            assert_eq!(self.at[id as usize], k as u32);
            assert!(k == 0 || !self.before(k, (k - 1) / 2), "entry {k}");
        }
        let inside = self.at.iter().filter(|&&k| k != ABSENT).count();
        assert_eq!(inside, self.heap.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::noise::Random;

    #[test]
    fn follows_a_sorted_list_under_random_operations() {
        const IDS: u32 = 50;
        let mut heap = Heap::new(IDS as usize);
        let mut list: Vec<Option<f64>> = vec![None; IDS as usize];
        let mut random = Random::new(3);
        for step in 0..100_000 {
            let id = random.below(IDS);
            match random.below(100) {
                0 => {
                    let key = |id: u32| f64::from((id * 7919 + step) % 13);
                    heap.rekey(key);
                    for (id, entry) in (0..).zip(&mut list) {
                        *entry = entry.map(|_| key(id));
                    }
                }
                1..40 => {
                    heap.remove(id);
                    list[id as usize] = None;
                }
                // Few keys, so that there are ties.
                _ => {
                    let key = f64::from(random.below(20));
                    heap.set(id, key);
                    list[id as usize] = Some(key);
                }
            }
            if step % 64 == 0 {
                heap.check();
            }
            let best = (0..IDS)
                .filter_map(|id| list[id as usize].map(|key| (id, key)))
                .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            assert_eq!(heap.top(), best);
        }
    }
}
