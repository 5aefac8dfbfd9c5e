//! ColorVideoVDP over a whole animation, in bounded memory.
//!
//! Mantiuk, Hanji, Ashraf, Asano and Chapiro, *ColorVideoVDP: A visual difference predictor for
//! image, video and display distortions*, SIGGRAPH 2024. Unlike the other metrics it sees time:
//! flicker, judder and lag count as a viewer would see them. The score is in JOD: 10 where no
//! difference can be seen, 1 less where 75 % of observers would prefer the other picture.
//!
//! The computation is the `colorvideovdp` crate's port. That crate wants all frames at once; here
//! they come one by one. Each frame's features depend on a quarter of a second of history only,
//! so frames are scored in windows that overlap by that history, and the features are pooled
//! over time at the end. The pooling (the paper's §3.7, `do_pooling_and_jods` of the reference
//! code) is restated here; a test holds it equal to the crate's own over the whole sequence.
//!
//! Display model: sRGB on a 200 cd/m² panel of contrast 1000:1 under 250 lux of office light
//! (ColorVideoVDP's `standard_4k` and `standard_fhd`), with the pixel pitch of [`Viewing`].

use colorvideovdp::{Color, Cvvdp, DisplayModel, Geometry, Image as Frame, Options};

use crate::{Image, MetricError, Viewing};

/// Whose photometry the panel has.
const PHOTOMETRY_OF: &str = "standard_4k";

/// Frames of one window take at most about this much memory, ideal and shown together.
const WINDOW_BYTES: usize = 256 << 20;

/// What a single prediction may take on top: enough for a 4K panel.
const PREDICTION_BYTES: usize = 8 << 30;

/// The smallest number of new frames in a window: two, because one alone counts as a still image.
const MIN_NEW_FRAMES: usize = 2;

/// A score of an animation so far, fed one refresh at a time.
///
/// Invariant: `ideal` and `shown` have equal lengths; their first `history` frames are scored
/// already and are there for the temporal filters alone.
#[derive(Debug)]
pub struct VideoMetric {
    metric: Cvvdp,
    refresh_rate: f32,
    width: usize,
    height: usize,
    /// Frames that a temporal filter reaches back.
    reach: usize,
    /// New frames to collect before a window is scored.
    new_frames: usize,
    ideal: Vec<Frame>,
    shown: Vec<Frame>,
    history: usize,
    /// One visible difference for each scored frame.
    differences: Vec<f32>,
}

/// What ColorVideoVDP says of an animation.
#[derive(Clone, Debug, PartialEq)]
pub struct VideoScore {
    /// Quality of the whole, JOD: 10 alike, lower worse; can be negative.
    pub jod: f64,
    /// For each refresh, the JOD of an animation that is as bad as this refresh throughout.
    ///
    /// Empty for an animation of one refresh, which is scored as a still picture.
    pub jod_each: Vec<f64>,
}

impl VideoMetric {
    /// A metric for pictures of `width` × `height` shown `refresh_rate` times a second.
    ///
    /// # Errors
    ///
    /// [`MetricError::Video`] for a side under 4 pixels, a rate outside (0, 16384] Hz or
    /// impossible viewing conditions.
    pub fn new(
        width: usize,
        height: usize,
        refresh_rate: f32,
        viewing: Viewing,
    ) -> Result<Self, MetricError> {
        let frame_bytes = width.saturating_mul(height).saturating_mul(2 * 3 * 4);
        let frames = WINDOW_BYTES / frame_bytes.max(1);
        let reach = reach(refresh_rate);
        Self::with_window(
            width,
            height,
            refresh_rate,
            viewing,
            // At least as many new frames as history, lest most of the work be done twice.
            frames.saturating_sub(reach).max(reach),
        )
    }

    fn with_window(
        width: usize,
        height: usize,
        refresh_rate: f32,
        viewing: Viewing,
        new_frames: usize,
    ) -> Result<Self, MetricError> {
        if width < 4 || height < 4 {
            return Err(MetricError::Video(colorvideovdp::Error::InvalidImage {
                width,
                height,
                channels: 3,
                len: width.saturating_mul(height).saturating_mul(3),
            }));
        }
        if !(refresh_rate > 0.0 && refresh_rate <= 16384.0) {
            return Err(MetricError::Video(colorvideovdp::Error::InvalidFrameRate(
                refresh_rate,
            )));
        }
        let ppd = f64::from(viewing.pixels_per_degree);
        let display = DisplayModel::new(
            "panel",
            DisplayModel::from_name(PHOTOMETRY_OF)?.photometry,
            Geometry::from_ppd([width, height], ppd)?,
            "sRGB",
        )?;
        let options = Options::default().with_memory_limit_bytes(PREDICTION_BYTES);
        Ok(Self {
            metric: Cvvdp::new(display, options)?,
            refresh_rate,
            width,
            height,
            reach: reach(refresh_rate),
            new_frames: new_frames.max(MIN_NEW_FRAMES),
            ideal: Vec::new(),
            shown: Vec::new(),
            history: 0,
            differences: Vec::new(),
        })
    }

    /// Adds the next refresh.
    ///
    /// # Errors
    ///
    /// [`MetricError::SizeMismatch`] if a picture has not the stated size; [`MetricError::Video`]
    /// if the crate refuses a window.
    pub fn push(&mut self, ideal: Image<'_>, shown: Image<'_>) -> Result<(), MetricError> {
        ideal.check_same_size(&shown)?;
        if (ideal.width(), ideal.height()) != (self.width, self.height) {
            return Err(MetricError::SizeMismatch {
                left_width: self.width,
                left_height: self.height,
                right_width: ideal.width(),
                right_height: ideal.height(),
            });
        }
        let (ideal, shown) = (frame(ideal)?, frame(shown)?);
        self.ideal.push(ideal);
        self.shown.push(shown);
        if self.ideal.len() - self.history >= self.new_frames {
            self.score_window()?;
        }
        Ok(())
    }

    /// The score of everything pushed.
    ///
    /// # Errors
    ///
    /// [`MetricError::NoRefreshes`] if nothing was; [`MetricError::Video`] if the crate refuses.
    pub fn finish(mut self) -> Result<VideoScore, MetricError> {
        if let ([ideal], [shown], true) = (
            &self.ideal[..],
            &self.shown[..],
            self.differences.is_empty(),
        ) {
            let still = self.metric.predict_image(shown, ideal, Color::Srgb)?;
            return Ok(VideoScore {
                jod: f64::from(still.jod),
                jod_each: Vec::new(),
            });
        }
        if self.ideal.len() > self.history {
            self.score_window()?;
        }
        if self.differences.is_empty() {
            return Err(MetricError::NoRefreshes);
        }
        let count = self.differences.len();
        let pooled = norm(
            self.differences.iter().copied(),
            pooling::BETA_FRAMES,
            count,
        );
        Ok(VideoScore {
            jod: f64::from(jod(pooled)),
            jod_each: self
                .differences
                .iter()
                .map(|&d| f64::from(jod(d)))
                .collect(),
        })
    }

    /// Scores the frames after the history and keeps the last ones as the next history.
    fn score_window(&mut self) -> Result<(), MetricError> {
        let prediction =
            self.metric
                .predict_video(&self.shown, &self.ideal, self.refresh_rate, Color::Srgb)?;
        let bands = prediction.band_frequencies.len();
        let frames = prediction.frames;
        for frame in self.history..frames {
            let channels = pooling::CHANNEL_WEIGHTS
                .iter()
                .enumerate()
                .map(|(c, weight)| {
                    let features = &prediction.quality_per_channel[(c * frames + frame) * bands..];
                    let features = features.iter().take(bands).enumerate().map(|(b, q)| {
                        // The last band is what remains of the pyramid: the local mean.
                        let last = b + 1 == bands;
                        q * weight * if last { pooling::BASE_WEIGHTS[c] } else { 1.0 }
                    });
                    norm(features, pooling::BETA_BANDS, 1)
                });
            self.differences
                .push(norm(channels, pooling::BETA_CHANNELS, 1));
        }
        let done = self.ideal.len().saturating_sub(self.reach);
        self.ideal.drain(..done);
        self.shown.drain(..done);
        self.history = self.ideal.len();
        Ok(())
    }
}

/// Frames before the newest that the temporal filters of 250 ms reach (`get_temporal_filters`).
fn reach(refresh_rate: f32) -> usize {
    // Saturates: the constructor refuses nonsense rates only after this.
    let half = (0.25 * f64::from(refresh_rate) / 2.0).ceil();
    (half as usize).saturating_mul(2)
}

fn frame(image: Image<'_>) -> Result<Frame, MetricError> {
    let data = image.pixels().as_flattened();
    let data = data.iter().map(|&c| f32::from(c) / 255.0).collect();
    Ok(Frame::new(image.width(), image.height(), 3, data)?)
}

/// The pooling constants of the calibrated base model v0.5.7 (`cvvdp_parameters.json`), which the
/// crate keeps to itself.
mod pooling {
    /// Exponent over spatial bands (`beta_sch`).
    pub(super) const BETA_BANDS: f32 = 4.0;
    /// Exponent over the visual channels (`beta_tch`).
    pub(super) const BETA_CHANNELS: f32 = 4.0;
    /// Exponent over frames (`beta_t`).
    pub(super) const BETA_FRAMES: f32 = 2.0;
    /// Achromatic, red-green, yellow-violet, transient (`ch_chrom_w`, `ch_trans_w`).
    pub(super) const CHANNEL_WEIGHTS: [f32; 4] = [1.0, 1.0, 1.0, 0.808_113_46];
    /// The same channels' weights of the lowest band (`baseband_weight`).
    pub(super) const BASE_WEIGHTS: [f32; 4] = [0.003_633_448_6, 1.662_772_4, 4.118_745_3, 25.2597];
    /// Scale of difference to JOD (`jod_a`).
    pub(super) const JOD_SCALE: f32 = 0.043_956_94;
    /// Exponent of difference to JOD (`jod_exp`).
    pub(super) const JOD_EXPONENT: f32 = 0.930_204_3;
}

/// Visible difference to JOD (`met2jod`), linear below 0.1 so that its slope stays finite at 0.
fn jod(difference: f32) -> f32 {
    let loss = if difference <= 0.1 {
        0.1_f32.powf(pooling::JOD_EXPONENT - 1.0) * difference
    } else {
        difference.powf(pooling::JOD_EXPONENT)
    };
    10.0 - pooling::JOD_SCALE * loss
}

/// The p-norm over `count` values (`lp_norm`), with the reference's guard against infinite slopes.
fn norm(values: impl Iterator<Item = f32>, p: f32, count: usize) -> f32 {
    let power = |x: f32, p: f32| (x + 1e-5).powf(p) - 1e-5_f32.powf(p);
    let sum: f64 = values.map(|x| f64::from(power(x, p))).sum();
    power((sum / count as f64) as f32, 1.0 / p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_pictures::{blocks, blurred, view};

    const SIDE: usize = 32;

    /// An ideal picture and the shown one.
    type Pair = (Vec<[u8; 3]>, Vec<[u8; 3]>);

    fn score(pairs: &[Pair], window: usize) -> VideoScore {
        let viewing = Viewing::default();
        let mut metric = VideoMetric::with_window(SIDE, SIDE, 60.0, viewing, window).unwrap();
        for (ideal, shown) in pairs {
            metric.push(view(ideal, SIDE), view(shown, SIDE)).unwrap();
        }
        metric.finish().unwrap()
    }

    /// A moving picture whose shown side is blurred by `radius` in every refresh.
    fn moving(refreshes: usize, radius: usize) -> Vec<Pair> {
        (0..refreshes)
            .map(|i| {
                let ideal = blocks(SIDE, SIDE, 2 * i);
                let shown = blurred(&ideal, SIDE, radius);
                (ideal, shown)
            })
            .collect()
    }

    #[test]
    fn windows_give_what_the_whole_gives() {
        let mut pairs = moving(45, 1);
        for (i, (_, shown)) in pairs.iter_mut().enumerate() {
            if i % 3 == 0 {
                *shown = blurred(shown, SIDE, 2);
            }
        }
        let frames = |shown: bool| -> Vec<Frame> {
            pairs
                .iter()
                .map(|(i, s)| frame(view(if shown { s } else { i }, SIDE)).unwrap())
                .collect()
        };
        let metric = VideoMetric::new(SIDE, SIDE, 60.0, Viewing::default()).unwrap();
        let whole = metric
            .metric
            .predict_video(&frames(true), &frames(false), 60.0, Color::Srgb)
            .unwrap();
        for window in [2, 16, 17, 45, 1000] {
            let ours = score(&pairs, window);
            assert!(
                (ours.jod - f64::from(whole.jod)).abs() < 1e-5,
                "window {window}: {} against {}",
                ours.jod,
                whole.jod
            );
            assert_eq!(ours.jod_each.len(), 45);
        }
    }

    #[test]
    fn equal_animations_have_ten_and_a_flash_of_one_pixel_has_less() {
        let mut pairs = moving(20, 0);
        assert_eq!(score(&pairs, 100).jod, 10.0);
        let pixel = &mut pairs[10].1[SIDE * 16 + 16];
        *pixel = pixel.map(|c| c ^ 0x80);
        let flash = score(&pairs, 100);
        assert!(flash.jod < 9.9999, "{}", flash.jod);
        assert_eq!(flash.jod_each[9], 10.0, "the past does not know");
        assert!(flash.jod_each[10] < 10.0);
    }

    #[test]
    fn more_blur_is_worse() {
        let scores: Vec<f64> = [0, 1, 2, 4]
            .iter()
            .map(|&r| score(&moving(18, r), 100).jod)
            .collect();
        assert!(scores.is_sorted_by(|a, b| a > b), "{scores:?}");
    }

    #[test]
    fn it_sees_time_flicker_is_worse_than_a_steady_offset() {
        let grey = |level: u8| vec![[level; 3]; SIDE * SIDE];
        let steady: Vec<_> = (0..30).map(|_| (grey(120), grey(124))).collect();
        let flicker: Vec<_> = (0..30)
            .map(|i| (grey(120), grey(if i / 3 % 2 == 0 { 124 } else { 116 })))
            .collect();
        // Each refresh has the same squared error in both.
        assert!(score(&flicker, 100).jod < score(&steady, 100).jod);
    }

    #[test]
    fn one_refresh_is_a_still_picture_and_none_is_an_error() {
        let still = score(&moving(1, 2), 100);
        assert!(still.jod < 10.0 && still.jod_each.is_empty());
        let none = VideoMetric::new(SIDE, SIDE, 60.0, Viewing::default()).unwrap();
        assert_eq!(none.finish(), Err(MetricError::NoRefreshes));
    }

    #[test]
    fn what_it_cannot_score_is_refused_at_once() {
        let viewing = Viewing::default();
        assert!(VideoMetric::new(3, 64, 60.0, viewing).is_err());
        for rate in [0.0, -60.0, f32::NAN, f32::INFINITY] {
            assert!(VideoMetric::new(64, 64, rate, viewing).is_err());
        }
        let mut metric = VideoMetric::new(SIDE, SIDE, 60.0, viewing).unwrap();
        let small = blocks(16, 16, 0);
        let pushed = metric.push(view(&small, 16), view(&small, 16));
        assert!(matches!(pushed, Err(MetricError::SizeMismatch { .. })));
    }
}
