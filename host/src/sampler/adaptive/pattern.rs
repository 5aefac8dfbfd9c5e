//! Which points of lamps and media samples look at: the interleaving pattern of Dubla et al. 2009
//! without frames.
//!
//! There the pixels of a square of n × n share a well spread set of points. Here the image is laid
//! out in such squares too, but a square's points are a sequence ([`crate::effects::care`]) that
//! has no end: whichever of its pixels is looked at next takes the next ones. A small square has all its
//! points where they are filtered together, but few of them at any time; in a large one what falls
//! under a filter is no run of the sequence any more, and little better than random.

use glam::{UVec2, Vec2};

use crate::effects::care::{self, Care};

/// How far each square's sequence was taken.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// Side of a square, pixels of the image.
    side: u32,
    /// Squares in a row.
    columns: u32,
    /// Points taken of each square's sequence, row by row; goes round.
    taken: Vec<u16>,
}

impl Pattern {
    /// Of an image of `size` pixels; a side of 0 counts as 1.
    pub(super) fn new(size: UVec2, side: u16) -> Self {
        let side = u32::from(side).max(1);
        let squares = UVec2::new(size.x.div_ceil(side), size.y.div_ceil(side));
        Self {
            side,
            columns: squares.x,
            taken: vec![0; squares.element_product() as usize],
        }
    }

    /// The seed of a new sample at `place` (pixels, within the image) that takes `care`.
    pub(super) fn seed(&mut self, place: Vec2, care: Care) -> u32 {
        let at = place.as_uvec2() / self.side;
        let square = at.y * self.columns + at.x;
        let taken = &mut self.taken[square as usize];
        let seed = care::few(square, *taken);
        let most = care.rays.into_iter().max().unwrap_or(1);
        *taken = taken.wrapping_add(u16::from(most));
        seed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: UVec2 = UVec2::new(22, 13);

    fn taking(rays: u8) -> Care {
        Care {
            rays: [1, rays, 1],
            pattern: true,
            ..Care::default()
        }
    }

    #[test]
    fn a_square_takes_its_points_one_after_the_other() {
        let mut pattern = Pattern::new(SIZE, 4);
        // Anywhere in the same square.
        let first = pattern.seed(Vec2::new(4.0, 0.5), taking(5));
        assert_eq!(pattern.seed(Vec2::new(7.9, 3.9), taking(3)), first + 5);
        assert_eq!(pattern.seed(Vec2::new(5.5, 1.5), taking(1)), first + 8);
        // Another square begins its own.
        assert_ne!(pattern.seed(Vec2::new(8.0, 0.5), taking(5)), first + 9);
        assert_eq!(pattern.seed(Vec2::new(4.5, 3.0), taking(1)), first + 9);
    }

    #[test]
    fn squares_cover_any_image_whatever_their_side() {
        for side in [0, 1, 2, 3, 4, 8, 64] {
            let mut pattern = Pattern::new(SIZE, side);
            for y in 0..SIZE.y {
                for x in 0..SIZE.x {
                    pattern.seed(Vec2::new(x as f32, y as f32) + 0.99, taking(1));
                }
            }
            let side = u32::from(side).max(1);
            let pixels = |square: u32| {
                let corner = UVec2::new(square % pattern.columns, square / pattern.columns) * side;
                (SIZE - corner).min(UVec2::splat(side)).element_product()
            };
            for (square, taken) in (0..).zip(&pattern.taken) {
                assert_eq!(u32::from(*taken), pixels(square), "{side}");
            }
        }
    }
}
