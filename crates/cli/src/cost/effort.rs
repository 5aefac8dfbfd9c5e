//! What a refresh has to do, counted on any machine, and what that costs on a small core.
//!
//! [`Work`] is counted while a display runs on the desktop: a refresh looks at every sample that is
//! stored, finds some in sight, adds those that are not hidden to rows and pixels of their
//! footprints, and solves every pixel; before it, packets were received. These are all the loops
//! there are, so a [`Law`] that gives each of them a number of instructions, found from refreshes
//! that an emulator counted, predicts the refreshes of other scenes, panels and rates.

use serde::{Deserialize, Serialize};
use unframed_recon::arith::REACH;
use unframed_recon::{Arith, Display, Fixed};
use unframed_wire::{Packet, Receiver, Tick};

/// What one refresh has to do, receiving included; or the mean of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Work {
    /// Pixels of the panel.
    pub pixels: f64,
    /// Samples stored.
    pub stored: f64,
    /// Of these, in sight and of any weight.
    pub seen: f64,
    /// Of these, not hidden.
    pub kept: f64,
    /// Rows of their footprints.
    pub rows: f64,
    /// Pixels of their footprints.
    pub taps: f64,
    /// Samples received since the refresh before.
    pub samples: f64,
    /// Tiles received since.
    pub tiles: f64,
    /// Bytes received since.
    pub bytes: f64,
}

/// Reads a stream beside a display, to know what arrives between two refreshes.
#[derive(Debug, Default)]
pub struct Arrivals(Receiver);

impl Arrivals {
    /// What the bytes up to a refresh bring: work without a picture.
    pub fn read(&mut self, mut bytes: &[u8]) -> Work {
        let mut work = Work {
            bytes: bytes.len() as f64,
            ..Work::default()
        };
        while let Some(packet) = self.0.push(&mut bytes) {
            match packet {
                Packet::World(samples) => work.samples += samples.count() as f64,
                Packet::Screen(samples) => work.samples += samples.count() as f64,
                Packet::Tiles(tiles) => work.tiles += tiles.count() as f64,
                _ => {}
            }
        }
        work
    }
}

/// Quantities that the picture's cost grows with, and those of receiving.
const PICTURE: usize = 6;
const RECEIVE: usize = 5;

impl Work {
    /// Of the refresh that `display` made last, at `now`, before which this arrived.
    #[must_use]
    pub fn of(display: &Display<'_, Fixed>, now: Tick, arrived: Self) -> Self {
        let (width, height) = display.size();
        let (width, height) = (i32::from(width), i32::from(height));
        let Some(panel) = unframed_recon::Panel::new(width as u16, height as u16) else {
            return Self::default();
        };
        let mut work = Self {
            pixels: f64::from(width * height),
            stored: display.buffered() as f64,
            ..arrived
        };
        // How many of the taps around a coordinate lie on the panel.
        let across = |place, tap, size: i32| {
            let taps = <Fixed as Arith>::taps(&panel, tap, place);
            debug_assert!(taps.first >= -REACH && taps.last <= REACH);
            let pixel = <Fixed as Arith>::pixel(&panel, place);
            let (first, last) = (pixel + taps.first, pixel + taps.last);
            f64::from((last.min(size - 1) - first.max(0) + 1).max(0))
        };
        for decision in display.decisions(now).flatten() {
            work.seen += 1.0;
            if decision.hidden {
                continue;
            }
            work.kept += 1.0;
            // One that counts for its pixel alone has no footprint.
            let Some([wide, high]) = decision.widths else {
                continue;
            };
            let columns = across(decision.seen.x, wide, width);
            let rows = across(decision.seen.y, high, height);
            if columns > 0.0 {
                work.rows += rows;
                work.taps += rows * columns;
            }
        }
        work
    }

    /// The mean.
    #[must_use]
    pub fn mean<'a>(all: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut sum = Self::default();
        let mut count = 0.0;
        for work in all {
            sum = sum.with(work, |a, b| a + b);
            count += 1.0;
        }
        sum.with(&Self::default(), |a, _| a / f64::max(count, 1.0))
    }

    fn with(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            pixels: f(self.pixels, other.pixels),
            stored: f(self.stored, other.stored),
            seen: f(self.seen, other.seen),
            kept: f(self.kept, other.kept),
            rows: f(self.rows, other.rows),
            taps: f(self.taps, other.taps),
            samples: f(self.samples, other.samples),
            tiles: f(self.tiles, other.tiles),
            bytes: f(self.bytes, other.bytes),
        }
    }

    fn picture(&self) -> [f64; PICTURE] {
        [
            self.pixels,
            self.stored,
            self.seen,
            self.kept,
            self.rows,
            self.taps,
        ]
    }

    fn receive(&self) -> [f64; RECEIVE] {
        [1.0, self.pixels, self.samples, self.tiles, self.bytes]
    }
}

/// Instructions of a refresh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Receiving what comes between two refreshes.
    pub receive: f64,
    /// Making the picture.
    pub picture: f64,
}

impl Effort {
    /// Both.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.receive + self.picture
    }
}

/// What each unit of [`Work`] costs on a core, by one configuration of the display.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Law {
    /// Instructions for each pixel, sample stored, in sight, kept, row and pixel of a footprint.
    picture: [f64; PICTURE],
    /// Instructions for each refresh, pixel that tiles cover, sample, tile and byte received.
    receive: [f64; RECEIVE],
    /// The refreshes that it was found from: RMS of what it is off there, as a share.
    pub residual: f64,
}

impl Law {
    /// The law that is off least, relatively, over refreshes that were counted; `None` where they
    /// are too few.
    #[must_use]
    pub fn fit(counted: &[(Work, Effort)]) -> Option<Self> {
        let picture = counted
            .iter()
            .map(|(work, effort)| (work.picture(), effort.picture));
        let receive = counted
            .iter()
            .map(|(work, effort)| (work.receive(), effort.receive));
        let mut law = Self {
            picture: least_squares(picture)?,
            receive: least_squares(receive)?,
            residual: 0.0,
        };
        let off = |(work, effort): &(Work, Effort)| {
            (law.predict(work).total() / effort.total().max(1.0) - 1.0).powi(2)
        };
        let sum: f64 = counted.iter().map(off).sum();
        law.residual = (sum / counted.len().max(1) as f64).sqrt();
        Some(law)
    }

    /// What a refresh will cost while something moves. At rest it costs less.
    #[must_use]
    pub fn predict(&self, work: &Work) -> Effort {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum();
        Effort {
            receive: dot(&self.receive, &work.receive()),
            picture: dot(&self.picture, &work.picture()),
        }
    }
}

/// Of coefficients that are not negative (no loop gives time back), those for which the sum of
/// squared relative errors is least: normal equations, with quantities left out as long as one has
/// a negative coefficient, the most negative first.
fn least_squares<const N: usize>(rows: impl Iterator<Item = ([f64; N], f64)>) -> Option<[f64; N]> {
    let (mut square, mut right, mut count) = ([[0.0; N]; N], [0.0; N], 0);
    for (row, value) in rows.filter(|(_, value)| *value > 0.0) {
        let row = row.map(|v| v / value);
        for i in 0..N {
            right[i] += row[i];
            for j in 0..N {
                square[i][j] += row[i] * row[j];
            }
        }
        count += 1;
    }
    if count < 2 * N {
        return None;
    }
    let mut used: Vec<usize> = (0..N).filter(|i| square[*i][*i] > 0.0).collect();
    loop {
        let matrix = used
            .iter()
            .map(|i| used.iter().map(|j| square[*i][*j]).collect());
        let found = solve(matrix.collect(), used.iter().map(|i| right[*i]).collect())?;
        // In units of what a quantity adds to the whole.
        let share = |k: &usize| found[*k] * square[used[*k]][used[*k]].sqrt();
        let worst = (0..used.len()).min_by(|a, b| share(a).total_cmp(&share(b)))?;
        if found[worst] >= 0.0 {
            let mut all = [0.0; N];
            for (i, value) in used.iter().zip(found) {
                all[*i] = value;
            }
            return Some(all);
        }
        used.remove(worst);
    }
}

/// Gaussian elimination of a symmetric, positive system; a millionth of ridge keeps quantities that
/// grow together from being told apart by their noise.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = right.len();
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] *= 1.0 + 1e-6;
    }
    for k in 0..n {
        let pivot = matrix[k].clone();
        if pivot[k] <= 0.0 {
            return None;
        }
        for i in k + 1..n {
            let factor = matrix[i][k] / pivot[k];
            for (value, pivot) in matrix[i].iter_mut().zip(&pivot) {
                *value -= factor * pivot;
            }
            right[i] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work(k: u32) -> Work {
        let wave = |a: f64| 1.0 + 0.5 * (f64::from(k) * a).sin();
        Work {
            pixels: 1000.0 * wave(0.7),
            stored: 5000.0 * wave(1.3),
            seen: 3000.0 * wave(2.1),
            kept: 2500.0 * wave(0.9),
            rows: 9000.0 * wave(1.7),
            taps: 40_000.0 * wave(2.9),
            samples: 100.0 * wave(0.3),
            tiles: 300.0 * wave(1.1),
            bytes: 700.0 * wave(0.5),
        }
    }

    #[test]
    fn a_law_is_found_and_predicts_other_work() {
        let law = |w: &Work| Effort {
            receive: 5000.0 + 300.0 * w.samples + 90.0 * w.tiles + 60.0 * w.bytes,
            picture: 700.0 * w.pixels + 200.0 * w.stored + 90.0 * w.kept + 30.0 * w.taps,
        };
        let counted: Vec<_> = (0..40).map(|k| (work(k), law(&work(k)))).collect();
        let found = Law::fit(&counted).unwrap();
        assert!(found.residual < 1e-3, "{}", found.residual);
        let other = work(99).with(&Work::default(), |a, _| 7.0 * a);
        let (exact, predicted) = (law(&other).total(), found.predict(&other).total());
        assert!(
            (predicted / exact - 1.0).abs() < 5e-3,
            "{predicted} {exact}"
        );
        assert_eq!(Law::fit(&counted[..5]), None);
    }

    /// A quantity that lowers the cost is left out, and the rest still fits best.
    #[test]
    fn no_loop_gives_time_back() {
        let counted: Vec<_> = (0..40)
            .map(|k| {
                let w = work(k);
                let effort = Effort {
                    receive: 10.0 * w.bytes,
                    picture: 100.0 * w.stored - 20.0 * w.seen,
                };
                (w, effort)
            })
            .collect();
        let law = Law::fit(&counted).unwrap();
        assert!(
            law.picture.iter().chain(&law.receive).all(|c| *c >= 0.0),
            "{law:?}"
        );
        assert!(
            law.residual > 1e-3 && law.residual < 0.2,
            "{}",
            law.residual
        );
    }
}
