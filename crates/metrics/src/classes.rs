//! Where the squared error comes from: shares of it by class of pixel.
//!
//! Whoever has the scene decides the class of each pixel (the host's ideal renderer knows which
//! surfaces were hidden a moment ago); this module only adds up.

use crate::difference::{SquaredError, pixel_squared_error};
use crate::{Image, MetricError};

/// What is hard about a pixel. Where several apply, the first in this order is the class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PixelClass {
    /// Shows a surface that was hidden or off screen a moment ago.
    Disocclusion,
    /// Shows an object that moves in the world.
    Moving,
    /// Its colour changes with the view: mirrors, glass, highlights.
    ViewDependent,
    /// Depth or object differs from a neighbour's.
    Edge,
    /// The surface's colour varies within a few pixels.
    Texture,
    /// None of these.
    Flat,
}

impl PixelClass {
    /// All classes, in order of precedence.
    pub const ALL: [Self; 6] = [
        Self::Disocclusion,
        Self::Moving,
        Self::ViewDependent,
        Self::Edge,
        Self::Texture,
        Self::Flat,
    ];

    /// Its name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Disocclusion => "disocclusion",
            Self::Moving => "moving",
            Self::ViewDependent => "view-dependent",
            Self::Edge => "edge",
            Self::Texture => "texture",
            Self::Flat => "flat",
        }
    }
}

/// Squared error of an animation, divided among the classes of [`PixelClass`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ErrorShares {
    /// Indexed by `PixelClass as usize`.
    errors: [SquaredError; PixelClass::ALL.len()],
}

impl ErrorShares {
    /// Adds one refresh, with a class for each pixel.
    ///
    /// # Errors
    ///
    /// [`MetricError::SizeMismatch`] if the pictures differ in size, [`MetricError::MapLength`] if
    /// `classes` has not one entry a pixel. Nothing is added then.
    pub fn push(
        &mut self,
        ideal: Image<'_>,
        shown: Image<'_>,
        classes: &[PixelClass],
    ) -> Result<(), MetricError> {
        ideal.check_same_size(&shown)?;
        ideal.check_map("class", classes.len())?;
        let pixels = ideal.pixels().iter().zip(shown.pixels());
        for ((a, b), class) in pixels.zip(classes) {
            let slot = &mut self.errors[*class as usize];
            slot.sum += u64::from(pixel_squared_error(*a, *b));
            slot.count += 3;
        }
        Ok(())
    }

    /// The squared error of one class.
    pub fn of(&self, class: PixelClass) -> SquaredError {
        self.errors[class as usize]
    }

    /// The squared error of all classes: that of [`SquaredError::between`] over what was pushed.
    pub fn total(&self) -> SquaredError {
        self.errors
            .iter()
            .fold(SquaredError::default(), |a, b| a.plus(*b))
    }

    /// The class's share of all squared error, 0..=1; 0 where there is none at all.
    pub fn share(&self, class: PixelClass) -> f64 {
        ratio(self.of(class).sum, self.total().sum)
    }

    /// The class's share of all pixels, 0..=1; 0 before the first push.
    pub fn area(&self, class: PixelClass) -> f64 {
        ratio(self.of(class).count, self.total().count)
    }
}

fn ratio(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        0.0
    } else {
        part as f64 / whole as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_pictures::{next, noise, view};

    #[test]
    fn the_order_of_the_classes_is_their_index() {
        for (i, class) in PixelClass::ALL.into_iter().enumerate() {
            assert_eq!(class as usize, i, "{}", class.name());
        }
    }

    #[test]
    fn error_goes_to_the_class_of_its_pixel() {
        let ideal = vec![[0u8; 3]; 4];
        let shown = vec![[0, 0, 0], [3, 0, 0], [0, 1, 0], [0, 0, 0]];
        let classes = [
            PixelClass::Flat,
            PixelClass::Edge,
            PixelClass::Moving,
            PixelClass::Flat,
        ];
        let mut shares = ErrorShares::default();
        shares
            .push(view(&ideal, 2), view(&shown, 2), &classes)
            .unwrap();
        assert_eq!(shares.share(PixelClass::Edge), 0.9);
        assert_eq!(shares.share(PixelClass::Moving), 0.1);
        assert_eq!(shares.share(PixelClass::Flat), 0.0);
        assert_eq!(shares.area(PixelClass::Flat), 0.5);
        assert_eq!(shares.of(PixelClass::Edge).rmse(), 3.0f64.sqrt());
    }

    #[test]
    fn the_parts_make_the_whole() {
        let mut shares = ErrorShares::default();
        let mut whole = SquaredError::default();
        let mut state = 9;
        for seed in 0..5 {
            let (a, b) = (noise(16, 8, seed), noise(16, 8, seed + 100));
            let classes: Vec<_> = (0..128)
                .map(|_| PixelClass::ALL[next(&mut state) as usize % 6])
                .collect();
            let (a, b) = (view(&a, 16), view(&b, 16));
            shares.push(a, b, &classes).unwrap();
            whole = whole.plus(SquaredError::between(a, b).unwrap());
        }
        assert_eq!(shares.total(), whole);
        let sum: f64 = PixelClass::ALL.iter().map(|c| shares.share(*c)).sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_added_when_the_map_is_short() {
        let a = noise(4, 4, 1);
        let mut shares = ErrorShares::default();
        let error = shares.push(view(&a, 4), view(&a, 4), &[PixelClass::Flat; 15]);
        assert!(matches!(
            error,
            Err(MetricError::MapLength { entries: 15, .. })
        ));
        assert_eq!(shares, ErrorShares::default());
    }
}
