//! Disjoint low-discrepancy sets for the pixels of an interleaving pattern.

/// An additive recurrence in `D` dimensions: powers of the inverse of the root of x^(D+1) = x + 1
/// (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recurrence<const D: usize>([f64; D]);

impl<const D: usize> Recurrence<D> {
    pub(crate) fn new() -> Self {
        let mut root = 2.0f64;
        for _ in 0..32 {
            root = (1.0 + root).powf(1.0 / (D as f64 + 1.0));
        }
        Self(std::array::from_fn(|d| root.powi(-(d as i32) - 1)))
    }

    /// Numbers in 0..1.
    pub(crate) fn at(&self, index: u32) -> [f32; D] {
        self.0
            .map(|step| ((0.5 + step * f64::from(index)).fract() as f32).min(1.0 - f32::EPSILON))
    }
}

/// Samples for a pattern of `pixels` pixels, each with `sets` sets to go through: pixel p takes
/// point k·pixels + p in set k, so that the pixels of a pattern share a well spread set, and no
/// point is used twice.
#[derive(Clone, Debug)]
pub(crate) struct Sets {
    points: Vec<[f32; 2]>,
    pixels: u32,
}

impl Sets {
    pub(crate) fn new(pixels: u32, sets: u32) -> Self {
        let recurrence = Recurrence::new();
        Self {
            points: (0..pixels * sets).map(|i| recurrence.at(i)).collect(),
            pixels,
        }
    }

    /// The point of pixel `pixel` in set `set`.
    pub(crate) fn point(&self, pixel: u32, set: u32) -> [f32; 2] {
        self.points[(set * self.pixels + pixel) as usize % self.points.len()]
    }
}
