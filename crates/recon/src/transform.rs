//! View and pose composed: lattice points straight to pixels, in integers.
//!
//! With the view's rows `r`, the pose's matrix `m` and translation `t`, and the eye `e`
//! ([`unframed_wire::View`], [`unframed_wire::Pose`]),
//!
//! `n_k = Σ_j r_kj·(t_j − e_j) + Σ_i (Σ_j r_kj·m_ji)·q_i`, pixel = (n_0/n_2, n_1/n_2), depth n_2.

use crate::glance::Glance;
use crate::num::{exponent, shift};
use unframed_wire::{Pose, View};

/// Matrix entries of views and poses must stay within ±`MATRIX_LIMIT`.
pub const MATRIX_LIMIT: i32 = 1 << 30;
/// Eyes and translations must stay within ±`PLACE_LIMIT` world units.
pub const PLACE_LIMIT: i32 = 1 << 29;

fn within(values: &[i32], limit: i32) -> bool {
    values.iter().all(|v| (-limit..=limit).contains(v))
}

/// Whether a view keeps the ranges that the arithmetic is proven for.
#[must_use]
pub fn view_is_sound(view: &View) -> bool {
    view.frac_bits <= 30
        && within(&view.eye, PLACE_LIMIT)
        && view.rows.iter().all(|row| within(row, MATRIX_LIMIT))
}

/// Whether a pose keeps the ranges that the arithmetic is proven for.
#[must_use]
pub fn pose_is_sound(pose: &Pose) -> bool {
    pose.frac_bits <= 31
        && within(&pose.translation, PLACE_LIMIT)
        && pose.matrix.iter().all(|row| within(row, MATRIX_LIMIT))
}

/// A view and a pose composed.
///
/// `n_k = offset_k + Σ_i matrix_ki·q_i` in units of 2^`exponent` world units (for depth).
/// |matrix| < 2^31, |offset| < 2^49, so for any q of 16 bits |n| < 2^50.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transform {
    /// Numerators a lattice step.
    pub matrix: [[i32; 3]; 3],
    /// Numerators of the lattice's origin.
    pub offset: [i64; 3],
    /// log2 of the unit of the numerators.
    pub exponent: i32,
    /// The same with fewer digits.
    pub glance: Glance,
}

impl Transform {
    /// Composes a sound view and pose. Exact but for one rounding of each entry: to 2^−31 of the
    /// largest entry, or to 2^−49 of the largest offset where that is coarser.
    #[must_use]
    pub fn compose(view: &View, pose: &Pose) -> Self {
        // Three products of at most 2^60 each.
        let wide: [[i64; 3]; 3] = view.rows.map(|row| {
            core::array::from_fn(|i| {
                row.iter()
                    .zip(&pose.matrix)
                    .map(|(r, m)| i64::from(*r) * i64::from(m[i]))
                    .sum()
            })
        });
        // Three products of at most 2^30 · 2^30.
        let offset: [i64; 3] = view.rows.map(|row| {
            let away = pose
                .translation
                .iter()
                .zip(view.eye)
                .map(|(t, e)| i64::from(*t) - i64::from(e));
            row.iter().zip(away).map(|(r, d)| i64::from(*r) * d).sum()
        });
        let bound = |values: &[i64]| values.iter().fold(1, |most, v| v.unsigned_abs().max(most));
        let (largest, farthest) = (bound(wide.as_flattened()), bound(&offset));
        let frac = i32::from(pose.frac_bits);
        let narrow = (exponent(largest) - 29)
            .max(exponent(farthest) + frac - 48)
            .max(0);
        let matrix = wide.map(|row| row.map(|v| rounded(v, narrow) as i32));
        let offset = offset.map(|v| shift(v, frac - narrow));
        Self {
            matrix,
            offset,
            glance: Glance::new(&matrix, &offset),
            exponent: narrow - frac - i32::from(view.frac_bits),
        }
    }

    /// The numerators of a lattice point.
    #[inline]
    #[must_use]
    pub fn numerators(&self, place: [i16; 3]) -> [i64; 3] {
        let mut n = self.offset;
        for (n, row) in n.iter_mut().zip(&self.matrix) {
            for (m, q) in row.iter().zip(place) {
                *n += i64::from(*m) * i64::from(q);
            }
        }
        n
    }
}

/// `v / 2^by`, rounded to nearest.
fn rounded(v: i64, by: i32) -> i64 {
    if by == 0 {
        v
    } else {
        (shift(v, 1 - by) + 1) >> 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use unframed_wire::Tick;

    prop_compose! {
        fn entries(limit: i32)(e in prop::array::uniform9(-limit..=limit), by in 0u32..20) -> [[i32; 3]; 3] {
            [[e[0] >> by, e[1] >> by, e[2] >> by], [e[3] >> by, e[4] >> by, e[5] >> by], [e[6] >> by, e[7] >> by, e[8] >> by]]
        }
    }

    proptest! {
        #[test]
        fn compose_is_close_to_f64(
            rows in entries(MATRIX_LIMIT), matrix in entries(MATRIX_LIMIT),
            eye in prop::array::uniform3(-PLACE_LIMIT..=PLACE_LIMIT),
            translation in prop::array::uniform3(-PLACE_LIMIT..=PLACE_LIMIT),
            near in 0u32..29, view_bits in 0u8..=30, pose_bits in 0u8..=31,
            place in prop::array::uniform3(any::<i16>()),
        ) {
            let view = View { time: Tick(0), eye: eye.map(|v| v >> near), rows, frac_bits: view_bits };
            let pose = Pose { object: 0, matrix, frac_bits: pose_bits, translation: translation.map(|v| v >> near) };
            let t = Transform::compose(&view, &pose);
            let n = t.numerators(place);
            let d: [f64; 3] = core::array::from_fn(|j| {
                let step: f64 = (0..3).map(|i| f64::from(matrix[j][i]) * f64::from(place[i])).sum();
                f64::from(pose.translation[j]) - f64::from(view.eye[j]) + step / f64::from(pose_bits).exp2()
            });
            for k in 0..3 {
                let exact: f64 = (0..3).map(|j| f64::from(rows[k][j]) * d[j]).sum::<f64>() / f64::from(view_bits).exp2();
                let got = n[k] as f64 * f64::from(t.exponent).exp2();
                // Half a unit an entry and coordinate, one for the offset.
                let unit = f64::from(t.exponent).exp2();
                let bound = unit * (1.0 + 1.5 * 32768.0) + exact.abs() * 1e-12;
                prop_assert!((got - exact).abs() <= bound, "{got} against {exact}");
                prop_assert!(n[k].unsigned_abs() < 1 << 50);
            }
        }
    }
}
