//! What a flipped decision reaches through holes: where few samples fell, the pull-push pyramid
//! shows what lies around, flipped or not.

/// Weight from which a pixel shows itself alone: 0.3, and what integers may round off.
const ENOUGH: f64 = 0.3 * 1.001;

/// A level of the pyramid: what is known of each texel, 0..=1, and whether a flip reaches it.
struct Level {
    width: usize,
    height: usize,
    known: Vec<f64>,
    reached: Vec<bool>,
}

impl Level {
    /// The next coarser level, as `unframed_recon::fill` pulls it.
    fn pull(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let children = |i: usize| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            let xs = move || x..(x + 2).min(self.width);
            (y..(y + 2).min(self.height)).flat_map(move |y| xs().map(move |x| y * self.width + x))
        };
        let known = |i| children(i).map(|child| self.known[child]).sum::<f64>();
        let reached = |i| children(i).any(|child| self.reached[child]);
        Self {
            width,
            height,
            known: (0..width * height).map(|i| known(i).min(1.0)).collect(),
            reached: (0..width * height).map(reached).collect(),
        }
    }

    /// Marks what is shown of a coarser level that is marked.
    fn push(&mut self, coarse: &Self) {
        // The coarse texel that holds a fine one and the one beside it on its side.
        let beside = |v: usize, len: usize| {
            let other = if v.is_multiple_of(2) {
                (v / 2).saturating_sub(1)
            } else {
                (v / 2 + 1).min(len - 1)
            };
            [v / 2, other]
        };
        for i in (0..self.known.len()).filter(|i| self.known[*i] < 1.0) {
            let (x, y) = (i % self.width, i / self.width);
            self.reached[i] |= beside(y, coarse.height).into_iter().any(|y| {
                let near = beside(x, coarse.width).into_iter();
                near.into_iter()
                    .any(|x| coarse.reached[y * coarse.width + x])
            });
        }
    }
}

/// Marks the pixels, of rows of `width`, that a marked one reaches by the filling of holes;
/// `weights` are the sums of the weights of each pixel's samples.
pub fn reach(width: usize, weights: &[f64], reached: &mut Vec<bool>) {
    let fine = Level {
        width,
        height: weights.len() / width.max(1),
        known: weights.iter().map(|w| (w / ENOUGH).min(1.0)).collect(),
        reached: std::mem::take(reached),
    };
    let mut levels = vec![fine];
    while let Some(last) = levels
        .last()
        .filter(|last| last.width > 1 || last.height > 1)
    {
        levels.push(last.pull());
    }
    for i in (1..levels.len()).rev() {
        let (fine, coarse) = levels.split_at_mut(i);
        fine[i - 1].push(&coarse[0]);
    }
    *reached = levels.swap_remove(0).reached;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pixels that one flip at (8, 8) of 16 × 16 reaches.
    fn reached_by_one(weight: impl Fn(usize, usize) -> f64) -> Vec<(usize, usize)> {
        let weights: Vec<f64> = (0..256).map(|i| weight(i % 16, i / 16)).collect();
        let mut reached = vec![false; 256];
        reached[8 * 16 + 8] = true;
        reach(16, &weights, &mut reached);
        let all = (0..256).filter(|i| reached[*i]);
        all.map(|i| (i % 16, i / 16)).collect()
    }

    #[test]
    fn nothing_is_reached_where_all_is_known() {
        assert_eq!(reached_by_one(|_, _| 1.0), [(8, 8)]);
    }

    #[test]
    fn a_hole_shows_what_lies_beside_it() {
        // A hole of one pixel beside the flip, and one far away.
        let hole = |x, y| matches!((x, y), (9, 9) | (2, 2));
        let reached = reached_by_one(|x, y| if hole(x, y) { 0.0 } else { 1.0 });
        assert_eq!(reached, [(8, 8), (9, 9)]);
        // Where nothing else is known, all shows the one pixel.
        let reached = reached_by_one(|x, y| if (x, y) == (8, 8) { 1.0 } else { 0.0 });
        assert_eq!(reached.len(), 256);
    }
}
