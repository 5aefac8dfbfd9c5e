//! From lattice points to how a lamp sees them.
//!
//! Places seen from a lamp are in units of 2^8 world units: a 32,768th of the world's longest side.
//! Around a point lamp stand the six faces of a cube; a place is seen on the face of its
//! longest coordinate, at the other two over that one. A directional lamp has one face, the plane of the two
//! axes that it shines along least: places are shifted along the light into it.

use unframed_wire::{Lamp, LampKind, Pose};

/// log2 of the unit, world units.
pub const UNIT: i32 = 8;
/// Fractional bits of matrices.
pub const BITS: i32 = 14;
/// Entries of matrices stay within. Places of 16 bits then wrap around where a lattice is coarser
/// than the unit; coarser lattices have places of fewer bits.
const ENTRY: i64 = 1 << (BITS + 6);
/// log2 of a face's half side.
pub const FACE_BITS: u32 = 14;
/// Half the side of a face of a cube.
pub const FACE: i32 = 1 << FACE_BITS;
/// Half the side of the face of a directional lamp: four times the world's longest side.
pub const PLANE: i32 = 1 << 17;
/// Faces of a lamp.
pub const FACES: usize = 6;
/// log2 of the unit in which maps keep depths, in those of places.
pub const DEPTH: u32 = 2;
/// No depth: nothing is there.
pub const NOTHING: u16 = u16::MAX;

/// From an object's lattice to a lamp's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Toward {
    /// A lattice step along each axis, with 14 fractional bits; row by row.
    pub matrix: [[i32; 3]; 3],
    /// The lattice's origin.
    pub offset: [i32; 3],
}

impl Toward {
    /// All at the lamp.
    pub const ZERO: Self = Self {
        matrix: [[0; 3]; 3],
        offset: [0; 3],
    };

    /// Of a sound lamp and a sound pose.
    #[must_use]
    pub fn new(lamp: &Lamp, pose: &Pose) -> Self {
        let (rows, origin) = match lamp.kind {
            LampKind::Point => {
                let one = 1 << BITS;
                ([[one, 0, 0], [0, one, 0], [0, 0, one]], lamp.place)
            }
            LampKind::Directional => (along(lamp.place), [0; 3]),
        };
        // 15 and 31 bits, three of them: below 2^48.
        let dot =
            |row: &[i64; 3], v: [i64; 3]| -> i64 { row.iter().zip(v).map(|(r, v)| r * v).sum() };
        let by = i32::from(pose.frac_bits) + UNIT;
        let half = 1 << (by - 1);
        let matrix = rows.map(|row| {
            core::array::from_fn(|i| {
                let column = pose
                    .matrix
                    .map(|line| i64::from(line.get(i).copied().unwrap_or(0)));
                ((dot(&row, column) + half) >> by).clamp(-ENTRY, ENTRY) as i32
            })
        });
        let mut away = [0; 3];
        for ((away, t), o) in away.iter_mut().zip(pose.translation).zip(origin) {
            *away = i64::from(t) - i64::from(o);
        }
        let offset = rows.map(|row| (dot(&row, away) >> (BITS + UNIT)) as i32);
        Self { matrix, offset }
    }

    /// Where the lamp sees a lattice point; below 2^24 in each coordinate.
    #[inline]
    #[must_use]
    pub fn place(&self, place: [i16; 3]) -> [i32; 3] {
        let mut seen = self.offset;
        for (seen, row) in seen.iter_mut().zip(&self.matrix) {
            let products = row
                .iter()
                .zip(place)
                .map(|(m, q)| m.wrapping_mul(i32::from(q)));
            let sum = products.fold(1 << (BITS - 1), i32::wrapping_add);
            *seen += sum >> BITS;
        }
        seen
    }
}

/// The rows that shift places along a direction into the plane of the two axes that it goes along
/// least, and give the depth along the third.
fn along(towards: [i32; 3]) -> [[i64; 3]; 3] {
    let size = towards.map(i32::unsigned_abs);
    let axis = longest(size);
    let at = |i: usize| i64::from(towards.get(i).copied().unwrap_or(0));
    let (b, c) = others(axis);
    let one = 1i64 << BITS;
    let mut rows = [[0; 3]; 3];
    let ratio = |i: usize| (at(i) << BITS).checked_div(at(axis)).unwrap_or(0);
    let unit = |i: usize, shift: i64| -> [i64; 3] {
        core::array::from_fn(|k| {
            if k == i {
                one
            } else if k == axis {
                -shift
            } else {
                0
            }
        })
    };
    // Depth grows away from the light.
    let sign = if at(axis) < 0 { one } else { -one };
    let depth = core::array::from_fn(|k| if k == axis { sign } else { 0 });
    for (row, value) in rows
        .iter_mut()
        .zip([unit(b, ratio(b)), unit(c, ratio(c)), depth])
    {
        *row = value;
    }
    rows
}

/// The axis of the largest number.
#[inline]
fn longest([x, y, z]: [u32; 3]) -> usize {
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// The two axes after one.
#[inline]
const fn others(axis: usize) -> (usize, usize) {
    ((axis + 1) % 3, (axis + 2) % 3)
}

/// A place as a face sees it: across, up, and ahead; seen at the first two over the third.
#[inline]
#[must_use]
pub fn facing(kind: LampKind, face: usize, place: [i32; 3]) -> [i32; 3] {
    if kind == LampKind::Directional {
        return place;
    }
    let at = |i: usize| place.get(i).copied().unwrap_or(0);
    let axis = face / 2;
    let (b, c) = others(axis);
    let ahead = if face.is_multiple_of(2) {
        at(axis)
    } else {
        -at(axis)
    };
    [at(b), at(c), ahead]
}

/// Where on which face a lamp sees something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Aim {
    /// The face.
    pub face: usize,
    /// Across and up, −[`FACE`]..=[`FACE`] or within ±[`PLANE`].
    pub at: [i32; 2],
    /// Ahead.
    pub depth: u16,
}

impl Aim {
    /// Of what a lamp sees at `place`; `None` at the lamp itself or beyond its face.
    #[inline]
    #[must_use]
    pub fn of(kind: LampKind, place: [i32; 3]) -> Option<Self> {
        if kind == LampKind::Directional {
            let [x, y, ahead] = place;
            let inside = x.unsigned_abs() < PLANE as u32 && y.unsigned_abs() < PLANE as u32;
            return inside.then(|| Self {
                face: 0,
                at: [x, y],
                depth: depth_of(kind, ahead),
            });
        }
        let size = place.map(i32::unsigned_abs);
        let axis = longest(size);
        let at = |i: usize| place.get(i).copied().unwrap_or(0);
        let face = 2 * axis + usize::from(at(axis) < 0);
        let [x, y, ahead] = facing(kind, face, place);
        // To 16 bits, so that with 14 more they are 30.
        let down = 16u32.saturating_sub(ahead.leading_zeros());
        let by = ahead >> down;
        let quotient = |v: i32| ((v >> down) << FACE_BITS).checked_div(by);
        Some(Self {
            face,
            at: [quotient(x)?, quotient(y)?],
            depth: depth_of(kind, ahead),
        })
    }
}

/// A depth as maps keep it.
#[inline]
#[must_use]
pub fn depth_of(kind: LampKind, ahead: i32) -> u16 {
    let from = if kind == LampKind::Directional {
        1 << 15
    } else {
        0
    };
    ((ahead >> DEPTH) + from).clamp(0, i32::from(NOTHING) - 1) as u16
}
