//! Fronts: which points are beaten by none.

/// What is to be small: everything that a point costs, its error first.
pub const AXES: [&str; 4] = ["RMSE", "display time", "bytes a second", "RAM"];

/// The axes of a point, in the order of [`AXES`].
pub type Costs = [f64; AXES.len()];

/// Display times closer than this, relatively, are alike: they are measured.
const TIME_NOISE: f64 = 0.10;

/// Whether `a` is at least as good as `b` in everything and better in something.
#[must_use]
pub fn beats(a: &Costs, b: &Costs) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

/// For each point, whether no other beats it.
#[must_use]
pub fn on_front(points: &[Costs]) -> Vec<bool> {
    points
        .iter()
        .map(|b| !points.iter().any(|a| beats(a, b)))
        .collect()
}

/// By how much the point is dominated: the greatest share by which another one that is no worse in
/// anything is better in error, bytes or RAM. 0 on the front. Times count as alike within their
/// noise, and a gain in time alone does not count.
#[must_use]
pub fn dominated_by(point: &Costs, others: &[Costs]) -> f64 {
    let no_worse = |a: &&Costs| {
        a[0] <= point[0]
            && a[1] <= point[1] * (1.0 + TIME_NOISE)
            && a[2] <= point[2]
            && a[3] <= point[3]
    };
    let gain = |a: &Costs| {
        [0, 2, 3]
            .map(|axis| 1.0 - a[axis] / point[axis].max(1e-12))
            .into_iter()
            .fold(0.0, f64::max)
    };
    others.iter().filter(no_worse).map(gain).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_beaten_is_not_on_the_front() {
        let points = [
            [5.0, 1.0, 10.0, 100.0],
            [4.0, 2.0, 10.0, 100.0],
            [5.0, 1.5, 10.0, 100.0],
            [5.0, 1.0, 10.0, 100.0],
        ];
        // Equals do not beat each other.
        assert_eq!(on_front(&points), [true, true, false, true]);
    }

    #[test]
    fn domination_is_a_share_and_time_alone_does_not_count() {
        let point = [10.0, 1.0, 10.0, 100.0];
        assert_eq!(dominated_by(&point, &[point]), 0.0);
        assert_eq!(dominated_by(&point, &[[10.0, 0.5, 10.0, 100.0]]), 0.0);
        let better = [9.5, 1.05, 10.0, 100.0];
        assert!((dominated_by(&point, &[better]) - 0.05).abs() < 1e-9);
        assert_eq!(dominated_by(&point, &[[5.0, 1.2, 10.0, 100.0]]), 0.0);
        assert_eq!(dominated_by(&point, &[[5.0, 1.0, 10.1, 100.0]]), 0.0);
        assert!((dominated_by(&point, &[[10.0, 1.0, 10.0, 50.0]]) - 0.5).abs() < 1e-9);
    }
}
