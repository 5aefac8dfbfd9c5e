//! Integers against the oracle, `f64`: sample by sample, decision by decision, pixel by pixel.
//!
//! Pictures differ by a level where sums are rounded, and by more where rounding flips a yes-or-no
//! decision about a sample: whether it is in sight, which pixel it counts for, whether it is
//! hidden. Both arithmetics tell how they decided, so flips are known one by one, and so are the
//! pixels that a flipped sample reaches. Each flip must have been a comparison as close as the
//! errors stated in `docs/NUMERICS.md`, or follow from such a flip nearby: a sample on the border
//! of two pixels lends its depth and its weight to the one or to the other.
//!
//! The fuzz target `oracle` includes this file: it needs the reconstructor and the wire alone.

use crate::holes;
use unframed_recon::arith::{GUARD, REACH};
use unframed_recon::config::Extents;
use unframed_recon::decisions::Decision;
use unframed_recon::heap::HeapStorage;
use unframed_recon::tables::SRGB_TO_LINEAR;
use unframed_recon::{Arith, Config, Display, Fixed, Panel, Player};

/// Steps of a log2 in one octave, as the integers count them.
const STEPS: f64 = 2048.0;
/// How close two depths were if rounding flipped their comparison, in such steps: each is within
/// 1.25 steps of the truth, and [`Arith::behind`] and [`Arith::nearer`] add half a step each.
pub const CLOSE_DEPTHS: f64 = 3.0;
/// How close a sample lay to a border that rounding moved it across, in steps of its coordinate,
/// for the quotient alone.
pub const CLOSE_BORDER: f64 = 1.0 / 64.0;
/// How far the numerators of a place and its depth are from the truth, in units of their exponent:
/// half a unit for each entry of a matrix and lattice step, one for the offset.
pub const NUMERATOR: f64 = 1.5 * 32768.0 + 1.0;
/// How far two widths of a density may be apart without a flip nearby, in steps of their log2: 2.5
/// of their own and what the weights around are off.
pub const CLOSE_WIDTHS: f64 = 16.0;
/// How far two widths of gradients may be apart: four logs rounded to 8 steps each go into them, up
/// to 8 times in all.
pub const CLOSE_EXTENTS: f64 = 64.0;

/// How a stream is shown.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// What the display does.
    pub config: Config,
    /// The panel.
    pub size: (u16, u16),
    /// Samples remembered.
    pub samples: usize,
}

/// Decisions that flipped, by their reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flips {
    /// In sight or not, at the far border of the guard band.
    pub sight: usize,
    /// Weighing 2^−15 or nothing, at the end of its life.
    pub faded: usize,
    /// Which pixel, near a border.
    pub borders: usize,
    /// Hidden or not, by nearly equal depths.
    pub depths: usize,
    /// Hidden or not, or another width, because of a flip nearby.
    pub followed: usize,
    /// Not close and nothing nearby: must not be.
    pub unexplained: usize,
}

/// The largest differences: of what is known of a sample before anything is decided, and of light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Of a coordinate from the middle of its step, in steps, beyond what numerators lend.
    pub place: f64,
    /// Of log2 of depth, in 1/2048, beyond what numerators lend.
    pub depth: f64,
    /// Of the weight in time, in 2^−15.
    pub weight: f64,
    /// Of log2 of a filter width that no flip changed, in 1/2048.
    pub width: f64,
    /// Of linear light, 0..1, at pixels that no flip reaches and whose weights sum up to a whole
    /// sample's at least.
    pub light: f64,
}

/// What came of a comparison, over all its refreshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// Pixels that no flipped sample reaches, by the largest difference of their three colours.
    pub others: [usize; 256],
    /// Pixels that a flipped sample reaches, by itself or through the holes that are filled from
    /// where it does, the same way; or one whose place integers do not know to half a step: views
    /// that no camera has make those.
    pub reached: [usize; 256],
    /// Samples in sight, summed over refreshes: each was decided upon.
    pub decisions: usize,
    /// Those decisions that flipped.
    pub flips: Flips,
    /// How far samples were off.
    pub errors: Errors,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self {
            others: [0; 256],
            reached: [0; 256],
            decisions: 0,
            flips: Flips::default(),
            errors: Errors::default(),
        }
    }
}

impl Accuracy {
    /// The share of all pixels that differ by at most `level` or are reached by a flip.
    #[must_use]
    pub fn within(&self, level: usize) -> f64 {
        let beyond: usize = self.others[level + 1..].iter().sum();
        1.0 - beyond as f64 / self.pixels() as f64
    }

    /// The largest difference of a pixel that no flip reaches.
    #[must_use]
    pub fn worst(&self) -> usize {
        self.others.iter().rposition(|n| *n > 0).unwrap_or(0)
    }

    /// The share of all pixels that a flip reaches and that differ by more than `level`.
    #[must_use]
    pub fn flipped(&self, level: usize) -> f64 {
        let beyond: usize = self.reached[level + 1..].iter().sum();
        beyond as f64 / self.pixels() as f64
    }

    /// The share of all pixels that a flip reaches.
    #[must_use]
    pub fn reached(&self) -> f64 {
        self.reached.iter().sum::<usize>() as f64 / self.pixels() as f64
    }

    /// Pixels compared, at least 1.
    fn pixels(&self) -> usize {
        let pixels: usize = self.others.iter().chain(&self.reached).sum();
        pixels.max(1)
    }
}

/// Compares the arithmetics on a stream.
///
/// # Panics
/// When they do not agree on what the stream says, or the panel is out of range.
#[must_use]
pub fn compare(bytes: &[u8], setting: &Setting) -> Accuracy {
    let (width, height) = setting.size;
    let mut ours = HeapStorage::<Fixed>::new(width, height, setting.samples);
    let mut theirs = HeapStorage::<f64>::new(width, height, setting.samples);
    let fixed = Display::new(setting.config, width, height, ours.memory()).expect("it fits");
    let oracle = Display::new(setting.config, width, height, theirs.memory()).expect("it fits");
    let (mut fixed, mut oracle) = (Player::new(fixed), Player::new(oracle));
    let (mut a, mut b) = (bytes, bytes);
    let panel = Panel::new(width, height).expect("a sound panel");
    let mut accuracy = Accuracy::default();
    loop {
        let refresh = fixed.push(&mut a);
        assert_eq!(oracle.push(&mut b), refresh);
        assert_eq!(oracle.status(), fixed.status());
        let Some(refresh) = refresh else {
            return accuracy;
        };
        let decided = fixed.display().decisions(refresh.time);
        let pairs: Vec<_> = decided
            .zip(oracle.display().decisions(refresh.time))
            .collect();
        let mut flipped = Flipped::new(&panel, setting.config.extents, &mut accuracy);
        flipped.find(&pairs);
        let (mut reached, weights) = (flipped.reached, flipped.weights);
        if setting.config.fill {
            holes::reach(usize::from(width), &weights, &mut reached);
        }
        let ours = fixed.display().picture().iter();
        let pixels = ours.zip(oracle.display().picture());
        for (((ours, theirs), reached), weight) in pixels.zip(reached).zip(weights) {
            let level = (0..3).map(|c| ours[c].abs_diff(theirs[c])).max();
            let level = usize::from(level.unwrap_or(0));
            if reached {
                accuracy.reached[level] += 1;
            } else {
                accuracy.others[level] += 1;
                if weight >= 1.0 {
                    let light = |rgb: &[u8; 3], c: usize| {
                        f64::from(SRGB_TO_LINEAR[usize::from(rgb[c])]) / 65535.0
                    };
                    let apart = |c| (light(ours, c) - light(theirs, c)).abs();
                    let apart = (0..3).map(apart).fold(0.0, f64::max);
                    accuracy.errors.light = accuracy.errors.light.max(apart);
                }
            }
        }
    }
}

/// A sample as both decided about it.
type Pair = (Option<Decision<Fixed>>, Option<Decision<f64>>);

/// The flipped decisions of a refresh.
struct Flipped<'a> {
    panel: &'a Panel,
    /// How far two widths may be apart without a flip.
    close_widths: f64,
    accuracy: &'a mut Accuracy,
    /// The pixels that a sample entered or left.
    moved: Vec<bool>,
    /// The pixels that a flipped sample reaches.
    reached: Vec<bool>,
    /// The weights of each pixel's samples, summed.
    weights: Vec<f64>,
    /// Whether the depth of some sample counted for another pixel or not at all.
    strayed: bool,
    /// How far numerators moved a log2 of depth at most.
    blur: f64,
}

/// How far a sample's numerators are from the truth, in parts of its depth (a log2), given their
/// unit.
fn blur(unit: f64, depth: f64) -> f64 {
    let blur = NUMERATOR * unit / depth.exp2();
    if blur < 0.5 { blur } else { f64::INFINITY }
}

/// How far a coordinate is off by that, pixels: numerators are pixels times depth.
fn strays(blur: f64, at: [f64; 2]) -> f64 {
    2.0 * blur * (2.0 + at[0].max(at[1]))
}

impl<'a> Flipped<'a> {
    fn new(panel: &'a Panel, extents: Extents, accuracy: &'a mut Accuracy) -> Self {
        let close_widths = match extents {
            Extents::Gradient => CLOSE_EXTENTS,
            _ => CLOSE_WIDTHS,
        };
        Self {
            panel,
            close_widths,
            accuracy,
            moved: vec![false; panel.pixels()],
            reached: vec![false; panel.pixels()],
            weights: vec![0.0; panel.pixels()],
            strayed: false,
            blur: 0.0,
        }
    }

    fn find(&mut self, pairs: &[Pair]) {
        for pair in pairs {
            match pair {
                (Some(ours), Some(theirs)) => self.place(ours, theirs),
                (Some(ours), None) if ours.seen.weight > 1 => {
                    let at =
                        [ours.seen.x, ours.seen.y].map(|v| (f64::from(v) + 0.5) / self.steps());
                    let unit = f64::from(ours.transform.exponent).exp2();
                    let blur = blur(unit, f64::from(ours.seen.depth) / STEPS);
                    self.sight(ours.pixel, at, blur);
                }
                (None, Some(theirs)) if theirs.seen.weight * 32768.0 > 1.5 => {
                    let seen = &theirs.seen;
                    let blur = blur(theirs.transform.unit(), seen.depth);
                    self.sight(theirs.pixel, [seen.x, seen.y], blur);
                }
                (None, None) => {}
                // At the end of its life a sample weighs a unit or nothing. Its depth still counts.
                (Some(_), None) | (None, Some(_)) => {
                    self.accuracy.flips.faded += 1;
                    self.strayed = true;
                }
            }
            self.accuracy.decisions += usize::from(pair.0.is_some() || pair.1.is_some());
        }
        for pair in pairs {
            if let (Some(ours), Some(theirs)) = pair {
                self.hidden_and_width(ours, theirs);
            }
        }
    }

    /// A sample in sight of one alone.
    fn sight(&mut self, pixel: usize, at: [f64; 2], blur: f64) {
        let sizes = [self.panel.width, self.panel.height];
        let close = at.iter().zip(sizes).any(|(v, size)| {
            let end = f64::from(size) + 2.0 * f64::from(GUARD);
            // The middle of a step is half a step inside.
            let to_border = v.abs().min((v - end).abs()) - strays(blur, at);
            to_border * self.steps() <= 0.5 + CLOSE_BORDER
        });
        let flips = &mut self.accuracy.flips;
        *(if close {
            &mut flips.sight
        } else {
            &mut flips.unexplained
        }) += 1;
        self.moved[pixel] = true;
        self.strayed = true;
    }

    /// Steps of a coordinate in a pixel.
    fn steps(&self) -> f64 {
        f64::from(1 << self.panel.frac_bits)
    }

    /// Where a sample is, and for which pixel it counts.
    fn place(&mut self, ours: &Decision<Fixed>, theirs: &Decision<f64>) {
        let (a, b) = (&ours.seen, &theirs.seen);
        let blur = blur(theirs.transform.unit(), b.depth);
        let strays = strays(blur, [b.x, b.y]) * self.steps();
        let deeper = -(1.0 - blur).log2() * STEPS;
        self.blur = self.blur.max(deeper);
        if strays > 0.5 {
            self.reach(ours, theirs);
        }
        let (steps, errors) = (self.steps(), &mut self.accuracy.errors);
        for (v, exact) in [(a.x, b.x), (a.y, b.y)] {
            let error = (f64::from(v) + 0.5 - exact * steps).abs() - strays;
            errors.place = errors.place.max(error);
        }
        let depth = (f64::from(a.depth) / STEPS - told_apart(b.depth)).abs() * STEPS - deeper;
        errors.depth = errors.depth.max(depth);
        let weight = (f64::from(a.weight) - b.weight * 32768.0).abs();
        errors.weight = errors.weight.max(weight);

        let pixels = |x, y| [x, y];
        let ours_at = pixels(Fixed::pixel(self.panel, a.x), Fixed::pixel(self.panel, a.y));
        let theirs_at = pixels(f64::pixel(self.panel, b.x), f64::pixel(self.panel, b.y));
        if ours_at != theirs_at {
            let to_border = |v: f64| (v - v.round()).abs() * steps;
            let close = (0..2).all(|k| {
                ours_at[k] == theirs_at[k] || to_border([b.x, b.y][k]) <= CLOSE_BORDER + strays
            });
            let flips = &mut self.accuracy.flips;
            *(if close {
                &mut flips.borders
            } else {
                &mut flips.unexplained
            }) += 1;
            self.strayed = true;
        }
        if ours_at != theirs_at || ours.hidden != theirs.hidden {
            self.moved[ours.pixel] = true;
            self.moved[theirs.pixel] = true;
        }
    }

    /// Whether a sample takes part, and how wide its filter is.
    fn hidden_and_width(&mut self, ours: &Decision<Fixed>, theirs: &Decision<f64>) {
        if ours.hidden && theirs.hidden {
            return;
        }
        let tolerance = CLOSE_DEPTHS + 2.0 * self.blur;
        let close = |a, b| (told_apart(a) - told_apart(b)).abs() * STEPS <= tolerance;
        let widths = ours
            .widths
            .iter()
            .flatten()
            .zip(theirs.widths.iter().flatten());
        let apart = widths.map(|(a, b)| (f64::from(*a) - b * STEPS).abs());
        let apart = apart.fold(0.0, f64::max);
        let flips = &mut self.accuracy.flips;
        let reason = if ours.hidden != theirs.hidden {
            let seen = &theirs.seen;
            let elsewhere = ours.pixel != theirs.pixel
                || ours.near_mover != theirs.near_mover
                || !close(f64::from(ours.limit) / STEPS, theirs.limit);
            if close(seen.depth, theirs.limit)
                || close(seen.depth, f64::nearer(theirs.limit))
                || theirs.reach.iter().any(|reach| close(theirs.limit, *reach))
            {
                &mut flips.depths
            } else if elsewhere && self.strayed {
                &mut flips.followed
            } else {
                &mut flips.unexplained
            }
        } else if apart > self.close_widths {
            if ours.pixel != theirs.pixel || moved_near(self.panel, &self.moved, theirs.pixel) {
                &mut flips.followed
            } else {
                &mut flips.unexplained
            }
        } else if ours.widths.is_none() && ours.pixel != theirs.pixel {
            &mut flips.followed
        } else {
            self.accuracy.errors.width = self.accuracy.errors.width.max(apart);
            self.weigh(theirs);
            return;
        };
        *reason += 1;
        self.reach(ours, theirs);
    }

    /// Adds a sample's shares to the weights.
    fn weigh(&mut self, theirs: &Decision<f64>) {
        let panel = self.panel;
        let Some(widths) = theirs.widths else {
            self.weights[theirs.pixel] += theirs.seen.weight;
            return;
        };
        let axis = |k: usize, v| {
            let taps = f64::taps(panel, widths[k], v).weights;
            let first = f64::pixel(panel, v) - REACH;
            (first..).zip(taps).filter(|(_, tap)| *tap > 0.0)
        };
        for (y, down) in axis(1, theirs.seen.y) {
            for (x, across) in axis(0, theirs.seen.x) {
                if let Some(pixel) = panel.inside(x, y) {
                    self.weights[pixel] += theirs.seen.weight * down * across;
                }
            }
        }
    }

    /// Marks the pixels of a sample's footprint, in either arithmetic.
    fn reach(&mut self, ours: &Decision<Fixed>, theirs: &Decision<f64>) {
        let panel = self.panel;
        let (Some(our_widths), Some(their_widths)) = (ours.widths, theirs.widths) else {
            self.reached[ours.pixel] = true;
            self.reached[theirs.pixel] = true;
            return;
        };
        let range = |k: usize, v, exact| {
            let a = Fixed::taps(panel, our_widths[k], v);
            let b = f64::taps(panel, their_widths[k], exact);
            let (own, exact) = (Fixed::pixel(panel, v), f64::pixel(panel, exact));
            (own + a.first).min(exact + b.first)..=(own + a.last).max(exact + b.last)
        };
        for y in range(1, ours.seen.y, theirs.seen.y) {
            for x in range(0, ours.seen.x, theirs.seen.x) {
                if let Some(pixel) = panel.inside(x, y) {
                    self.reached[pixel] = true;
                }
            }
        }
    }
}

/// A log2 of depth within those that integers tell apart.
fn told_apart(depth: f64) -> f64 {
    depth.clamp(0.0, 65534.0 / STEPS)
}

/// Whether a sample entered or left one of the 3 × 3 pixels whose weights give a width.
fn moved_near(panel: &Panel, moved: &[bool], pixel: usize) -> bool {
    let width = usize::from(panel.width);
    let (x, y) = ((pixel % width) as i32, (pixel / width) as i32);
    let near = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
    near.filter_map(|(x, y)| panel.inside(x, y))
        .any(|pixel| moved[pixel])
}

#[cfg(test)]
mod tests {
    use super::*;
    use unframed_recon::arith::Projected;
    use unframed_recon::float::FloatTransform;
    use unframed_recon::transform::Transform;

    /// One sample at a place and depth as both see it, `moved` px apart, and whether it is hidden.
    fn pair(moved: f64, depth: u16, limit: u16, hidden: [bool; 2]) -> Pair {
        let x = 10.5;
        let ours = Decision {
            seen: Projected {
                x: ((x + moved) * 128.0) as u16,
                y: (x * 128.0) as u16,
                depth,
                weight: 1 << 15,
                ..Projected::<Fixed>::default()
            },
            reach: [0, 0],
            transform: Transform::default(),
            pixel: 0,
            limit,
            near_mover: false,
            hidden: hidden[0],
            widths: Some([0, 0]),
        };
        let theirs = Decision {
            seen: Projected {
                x,
                y: x,
                depth: f64::from(depth) / STEPS,
                weight: 1.0,
                ..Projected::<f64>::default()
            },
            reach: [0.0, 0.0],
            transform: FloatTransform::default(),
            pixel: 0,
            limit: f64::from(limit) / STEPS,
            near_mover: false,
            hidden: hidden[1],
            widths: Some([0.0, 0.0]),
        };
        (Some(ours), Some(theirs))
    }

    fn flips(pair: Pair) -> (Flips, usize) {
        let mut accuracy = Accuracy::default();
        let panel = Panel::new(16, 16).expect("a sound panel");
        let mut flipped = Flipped::new(&panel, Extents::Density, &mut accuracy);
        flipped.find(&[pair]);
        let reached = flipped.reached.iter().filter(|reached| **reached).count();
        (accuracy.flips, reached)
    }

    #[test]
    fn what_is_not_close_is_not_explained() {
        let explained = |depths, unexplained| Flips {
            depths,
            unexplained,
            ..Flips::default()
        };
        assert_eq!(flips(pair(0.0, 900, 500, [true; 2])), (explained(0, 0), 0));
        let (found, reached) = flips(pair(0.0, 502, 500, [true, false]));
        assert!(found == explained(1, 0) && reached > 9, "{found:?}");
        let (found, reached) = flips(pair(0.0, 900, 500, [true, false]));
        assert!(found == explained(0, 1) && reached > 9, "{found:?}");
        // A pixel away.
        assert_eq!(flips(pair(1.0, 900, 500, [false; 2])).0, explained(0, 1));
    }
}
