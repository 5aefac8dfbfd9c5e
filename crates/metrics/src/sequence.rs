//! All metrics over an animation, one refresh at a time.
//!
//! Every refresh counts. RMSE over the animation is the root of the mean of all squares, not the
//! mean of roots; ꟻLIP is the mean of the refreshes' means; ColorVideoVDP sees the whole.

use crate::perceptual::flip;
use crate::video::VideoMetric;
use crate::{Image, MetricError, SquaredError, Viewing};

/// Which metrics to compute, and for which viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequenceOptions {
    /// Compute ꟻLIP at every so many refreshes (15 ms for one of 256 × 256); 0 never.
    pub flip_every: usize,
    /// Compute ColorVideoVDP over the whole (about as long as ꟻLIP again, or twice).
    pub video: bool,
    /// Refreshes a second, for ColorVideoVDP; in (0, 16384] Hz.
    pub refresh_rate: f32,
    /// How the panel is looked at.
    pub viewing: Viewing,
}

impl Default for SequenceOptions {
    /// RMSE and PSNR alone, 60 Hz.
    fn default() -> Self {
        Self {
            flip_every: 0,
            video: false,
            refresh_rate: 60.0,
            viewing: Viewing::default(),
        }
    }
}

/// One refresh's numbers.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Refresh {
    /// When it was shown, s.
    pub time: f64,
    /// Root mean square over pixels and R, G, B of sRGB values, 0..=255.
    pub rmse: f64,
    /// Peak signal-to-noise ratio, dB; infinite where nothing differs (null in JSON).
    pub psnr: f64,
    /// Mean ꟻLIP error, 0..=1, if asked for at this refresh.
    pub flip: Option<f64>,
}

/// An animation's numbers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Totals {
    /// Refreshes pushed, at least 1.
    pub refreshes: usize,
    /// Root of the mean of squares over all refreshes, 0..=255.
    pub rmse: f64,
    /// PSNR of that, dB; infinite where nothing differs (null in JSON).
    pub psnr: f64,
    /// Mean over refreshes of mean ꟻLIP, 0..=1, of those at which it was asked for.
    pub flip: Option<f64>,
    /// ColorVideoVDP's quality of the whole, JOD, at most 10, if asked for.
    pub cvvdp: Option<f64>,
    /// The same at each refresh (see [`crate::video::VideoScore`]); empty if not asked for.
    pub cvvdp_each: Vec<f64>,
    /// The greatest RMSE of a refresh.
    pub worst_rmse: f64,
    /// When that was, s: the first of equals.
    pub worst_time: f64,
    /// The RMSE that 95 % of refreshes do not exceed (nearest rank).
    pub p95_rmse: f64,
    /// The ꟻLIP that 95 % of refreshes do not exceed, if asked for.
    pub p95_flip: Option<f64>,
}

/// Compares shown with ideal pictures as they come.
#[derive(Debug)]
pub struct Sequence {
    width: usize,
    height: usize,
    options: SequenceOptions,
    video: Option<VideoMetric>,
    error: SquaredError,
    refreshes: Vec<Refresh>,
}

impl Sequence {
    /// For pictures of `width` × `height`.
    ///
    /// # Errors
    ///
    /// [`MetricError::Empty`] for a side of 0; with `video`, [`MetricError::Video`] for a side
    /// under 4 pixels or a refresh rate out of range.
    pub fn new(width: usize, height: usize, options: SequenceOptions) -> Result<Self, MetricError> {
        if width == 0 || height == 0 {
            return Err(MetricError::Empty { width, height });
        }
        let video = if options.video {
            let rate = options.refresh_rate;
            Some(VideoMetric::new(width, height, rate, options.viewing)?)
        } else {
            None
        };
        Ok(Self {
            width,
            height,
            options,
            video,
            error: SquaredError::default(),
            refreshes: Vec::new(),
        })
    }

    /// Adds the refresh at `time` (s): sRGB bytes, rows from the top.
    ///
    /// # Errors
    ///
    /// [`MetricError::Length`] if a slice has not `width × height` pixels, and whatever ꟻLIP or
    /// ColorVideoVDP refuse. A refused refresh is in no total, save that ColorVideoVDP may have
    /// seen it: do not go on after an error.
    pub fn push(
        &mut self,
        ideal: &[[u8; 3]],
        shown: &[[u8; 3]],
        time: f64,
    ) -> Result<Refresh, MetricError> {
        let ideal = Image::new(ideal, self.width, self.height)?;
        let shown = Image::new(shown, self.width, self.height)?;
        let error = SquaredError::between(ideal, shown)?;
        let every = self.options.flip_every;
        let flip = if every > 0 && (self.refreshes.len() + 1).is_multiple_of(every) {
            Some(flip(ideal, shown, self.options.viewing)?)
        } else {
            None
        };
        if let Some(video) = &mut self.video {
            video.push(ideal, shown)?;
        }
        let refresh = Refresh {
            time,
            rmse: error.rmse(),
            psnr: error.psnr(),
            flip,
        };
        self.error = self.error.plus(error);
        self.refreshes.push(refresh);
        Ok(refresh)
    }

    /// The refreshes so far, in the order of pushing.
    pub fn refreshes(&self) -> &[Refresh] {
        &self.refreshes
    }

    /// RMSE of everything so far, 0..=255; 0 before the first refresh.
    pub fn rmse(&self) -> f64 {
        self.error.rmse()
    }

    /// The totals.
    ///
    /// # Errors
    ///
    /// [`MetricError::NoRefreshes`] if nothing was pushed, [`MetricError::Video`] if ColorVideoVDP
    /// refuses the end of the sequence.
    pub fn finish(self) -> Result<Totals, MetricError> {
        let mut worst = *self.refreshes.first().ok_or(MetricError::NoRefreshes)?;
        for refresh in &self.refreshes {
            if refresh.rmse > worst.rmse {
                worst = *refresh;
            }
        }
        let mut rmses: Vec<f64> = self.refreshes.iter().map(|r| r.rmse).collect();
        rmses.sort_unstable_by(f64::total_cmp);
        let mut flips: Vec<f64> = self.refreshes.iter().filter_map(|r| r.flip).collect();
        flips.sort_unstable_by(f64::total_cmp);
        let video = self.video.map(VideoMetric::finish).transpose()?;
        Ok(Totals {
            refreshes: self.refreshes.len(),
            rmse: self.error.rmse(),
            psnr: self.error.psnr(),
            flip: (!flips.is_empty()).then(|| flips.iter().sum::<f64>() / flips.len() as f64),
            cvvdp: video.as_ref().map(|v| v.jod),
            cvvdp_each: video.map(|v| v.jod_each).unwrap_or_default(),
            worst_rmse: worst.rmse,
            worst_time: worst.time,
            p95_rmse: nearest_rank(&rmses, 0.95).unwrap_or(worst.rmse),
            p95_flip: nearest_rank(&flips, 0.95),
        })
    }
}

/// The least of the sorted values that a share `q` (0..=1) of them does not exceed.
pub(crate) fn nearest_rank(sorted: &[f64], q: f64) -> Option<f64> {
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_pictures::{blocks, blurred};

    fn grey(level: u8) -> Vec<[u8; 3]> {
        vec![[level; 3]; 16]
    }

    #[test]
    fn totals_pool_squares_and_not_roots() {
        let mut sequence = Sequence::new(4, 4, SequenceOptions::default()).unwrap();
        for (i, offset) in [3u8, 4, 0, 5].into_iter().enumerate() {
            let refresh = sequence.push(&grey(100), &grey(100 + offset), i as f64 / 60.0);
            assert_eq!(refresh.unwrap().rmse, f64::from(offset));
        }
        assert_eq!(sequence.refreshes()[2].psnr, f64::INFINITY);
        let totals = sequence.finish().unwrap();
        assert_eq!(totals.rmse, (50.0f64 / 4.0).sqrt());
        assert_eq!((totals.worst_rmse, totals.worst_time), (5.0, 3.0 / 60.0));
        assert_eq!(totals.p95_rmse, 5.0);
        assert_eq!(
            (totals.flip, totals.cvvdp, totals.p95_flip),
            (None, None, None)
        );
    }

    #[test]
    fn the_95th_percentile_leaves_out_the_worst_twentieth() {
        let mut sequence = Sequence::new(4, 4, SequenceOptions::default()).unwrap();
        for offset in 1..=100u8 {
            let shown = grey(if offset > 95 { 200 } else { offset });
            sequence.push(&grey(0), &shown, 0.0).unwrap();
        }
        let totals = sequence.finish().unwrap();
        assert_eq!((totals.p95_rmse, totals.worst_rmse), (95.0, 200.0));
    }

    #[test]
    fn all_metrics_agree_that_blur_is_worse() {
        let options = SequenceOptions {
            flip_every: 1,
            video: true,
            ..Default::default()
        };
        let totals: Vec<Totals> = [0, 1, 3]
            .into_iter()
            .map(|radius| {
                let mut sequence = Sequence::new(32, 32, options).unwrap();
                for i in 0..18 {
                    let ideal = blocks(32, 32, i);
                    let shown = blurred(&ideal, 32, radius);
                    sequence.push(&ideal, &shown, i as f64 / 60.0).unwrap();
                }
                sequence.finish().unwrap()
            })
            .collect();
        assert_eq!(totals[0].rmse, 0.0);
        assert_eq!(totals[0].flip, Some(0.0));
        assert_eq!(totals[0].cvvdp, Some(10.0));
        for pair in totals.windows(2) {
            assert!(pair[0].rmse < pair[1].rmse);
            assert!(pair[0].psnr > pair[1].psnr);
            assert!(pair[0].flip < pair[1].flip);
            assert!(pair[0].cvvdp > pair[1].cvvdp);
            assert_eq!(pair[0].cvvdp_each.len(), 18);
        }
    }

    #[test]
    fn flip_is_measured_as_often_as_asked_for() {
        for (every, expected) in [(0, [0, 0]), (1, [1, 1]), (2, [0, 1])] {
            let options = SequenceOptions {
                flip_every: every,
                ..Default::default()
            };
            let mut sequence = Sequence::new(4, 4, options).unwrap();
            let found = expected.map(|_| sequence.push(&grey(0), &grey(90), 0.0).unwrap().flip);
            assert_eq!(found.map(|flip| usize::from(flip.is_some())), expected);
            // A refresh without a number does not count as one without error.
            let each = found.into_iter().flatten().next();
            assert_eq!(sequence.finish().unwrap().flip, each);
        }
    }

    #[test]
    fn wrong_input_is_an_error() {
        let sequence = Sequence::new(4, 4, SequenceOptions::default()).unwrap();
        assert_eq!(sequence.finish(), Err(MetricError::NoRefreshes));
        assert!(Sequence::new(0, 4, SequenceOptions::default()).is_err());
        let mut sequence = Sequence::new(4, 4, SequenceOptions::default()).unwrap();
        assert!(sequence.push(&grey(1)[1..], &grey(1), 0.0).is_err());
        assert!(sequence.refreshes().is_empty());
    }
}
