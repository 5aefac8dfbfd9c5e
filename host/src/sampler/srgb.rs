//! The displayed scale: sRGB-encoded colour in 0..255, on which errors are measured.

use std::sync::LazyLock;

use glam::Vec3;

/// Steps of the table; the curve's slope at black, 12.92, makes a step 0.8 of a displayed level.
const STEPS: usize = 4096;

/// IEC 61966-2-1 at the centres of the steps, in 0..255.
static TABLE: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let curve = |x: f64| {
        if x <= 0.003_130_8 {
            12.92 * x
        } else {
            1.055 * x.powf(1.0 / 2.4) - 0.055
        }
    };
    (0..=STEPS)
        .map(|i| (255.0 * curve(i as f64 / STEPS as f64)) as f32)
        .collect()
});

/// Linear light (0..=1, clamped) to the displayed scale 0..=255, not rounded; off by at most half
/// a level at black and less elsewhere.
#[must_use]
pub fn displayed(linear: Vec3) -> Vec3 {
    let table = &TABLE[..=STEPS];
    // The cast saturates, and NaN becomes 0. To i32: one instruction, to usize it is several.
    let level = |x: f32| table[((x * STEPS as f32 + 0.5) as i32).clamp(0, STEPS as i32) as usize];
    Vec3::new(level(linear.x), level(linear.y), level(linear.z))
}

/// Mean over the channels of the squared difference.
pub(super) fn squared_difference(a: Vec3, b: Vec3) -> f32 {
    (a - b).length_squared() * (1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_standard() {
        for i in 0..=10_000 {
            let x = i as f32 / 10_000.0;
            let exact = if x <= 0.003_130_8 {
                12.92 * x
            } else {
                1.055 * x.powf(1.0 / 2.4) - 0.055
            };
            assert!(
                (displayed(Vec3::splat(x)).y - 255.0 * exact).abs() < 0.5,
                "at {x}"
            );
        }
        assert_eq!(
            displayed(Vec3::new(-1.0, f32::NAN, 9.0)),
            Vec3::new(0.0, 0.0, 255.0)
        );
    }
}
