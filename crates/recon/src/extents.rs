//! Gradient-shaped filter extents in the log2 domain (Dayal et al. 2005 §5.1).
//!
//! `e_x = ∛(V·G_y·G_t/G_x²)` and so on, with the volume of a sample V = 1/density, become sums
//! and a division by three: zero and huge gradients are ordinary numbers. Extents are clamped, t
//! first, each clamp giving the rest of the volume to the others.
//!
//! Everything here is in log2 with 8 fractional bits and common to all arithmetics.

/// Gradients are at least 0.004 a pixel …
const LEAST_SPATIAL: i32 = -2039;
/// … and 0.02 a second: below lies noise.
const LEAST_TEMPORAL: i32 = -1445;
/// Temporal extents from 10 ms …
const SHORTEST: i32 = -1701;
/// … to 1 s.
pub const LONGEST: i16 = 0;
/// Spatial extents from 0.35 px …
const NARROWEST: i32 = -388;
/// … to 3 px.
const WIDEST: i32 = 406;
/// log2 of 0.65: σ against extent.
const SIGMA_OF_EXTENT: i32 = -159;

/// Extents in x, y (pixels) and t (seconds) from log2 of G_x, G_y, G_t and the density.
#[must_use]
pub fn extents(gx: i32, gy: i32, gt: i32, density: i32) -> (i32, i32, i32) {
    let gx = gx.max(LEAST_SPATIAL);
    let gy = gy.max(LEAST_SPATIAL);
    let gt = gt.max(LEAST_TEMPORAL);
    let volume = -density;
    let et = ((volume + gx + gy - 2 * gt) / 3).clamp(SHORTEST, LONGEST.into());
    // The rest, V/e_t, is an area with e_x·G_x = e_y·G_y.
    let area = volume - et;
    let ex = ((area + gy - gx) / 2).clamp(NARROWEST, WIDEST);
    let ey = (area - ex).clamp(NARROWEST, WIDEST);
    let ex = (area - ey).clamp(NARROWEST, WIDEST);
    (ex, ey, et)
}

/// log2 σ of an extent: σ = 0.65·e.
#[must_use]
pub fn sigma_of_extent(extent: i32) -> i32 {
    extent + SIGMA_OF_EXTENT
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn extents_keep_volume_and_equal_change_when_nothing_is_clamped(
            gx in -1500i32..0, gy in -1500i32..0, gt in -1400i32..1500, density in -500i32..1500,
        ) {
            let (ex, ey, et) = extents(gx, gy, gt, density);
            let inside = |v: i32, a: i32, b: i32| v > a && v < b;
            if inside(ex, NARROWEST, WIDEST) && inside(ey, NARROWEST, WIDEST) && inside(et, SHORTEST, LONGEST.into()) {
                prop_assert!((ex + ey + et + density).abs() <= 3);
                prop_assert!((ex + gx - ey - gy).abs() <= 3);
                prop_assert!((et + gt - ex - gx).abs() <= 4);
            }
        }

        #[test]
        fn any_gradients_give_bounded_extents(gx: i16, gy: i16, gt: i16, density: i16) {
            let (ex, ey, et) = extents(gx.into(), gy.into(), gt.into(), density.into());
            prop_assert!((NARROWEST..=WIDEST).contains(&ex));
            prop_assert!((NARROWEST..=WIDEST).contains(&ey));
            prop_assert!((SHORTEST..=LONGEST.into()).contains(&et));
        }
    }

    #[test]
    fn closed_form() {
        // The paper's cube roots in f64, away from the clamps.
        let (gx, gy, gt, rate) = (0.05f64, 0.08f64, 0.6f64, 20.0f64);
        let v = 1.0 / rate;
        let q8 = |x: f64| (x.log2() * 256.0).round() as i32;
        let (ex, ey, et) = extents(q8(gx), q8(gy), q8(gt), q8(rate));
        assert!((ex - q8((v * gy * gt / (gx * gx)).cbrt())).abs() <= 3);
        assert!((ey - q8((v * gx * gt / (gy * gy)).cbrt())).abs() <= 3);
        assert!((et - q8((v * gx * gy / (gt * gt)).cbrt())).abs() <= 3);
    }
}
