//! Shadow maps: how near to a lamp something stands, texel by texel.
//!
//! Each object has a window of its own on each face of a lamp that sees it, so that its own samples
//! pass it by. Texels of a lamp are all of one size, the least for which all windows have room.
//!
//! Triangles are drawn in homogeneous coordinates (Olano & Greer 1997, *Triangle scan conversion using
//! 2D homogeneous coordinates*): with corners A, B, C seen from the lamp a direction D meets the
//! triangle where D·(B×C), D·(C×A) and D·(A×B) have the sign of A·(B×C). Nothing is clipped, and triangles
//! that reach behind the lamp need no other way.

use super::facets::{CASTERS, Facet};
use super::toward::{Aim, FACE, FACE_BITS, FACES, NOTHING, PLANE, Toward, depth_of, facing};
use unframed_wire::{LAMPS, LampKind};

/// Windows of all lamps.
pub const WINDOWS: usize = 64;
/// How much deeper than what stands before it something must be.
pub const BEHIND: u16 = 1;
/// Bits of a corner's coordinates while it is drawn.
const CORNER_BITS: u32 = 15;

/// Where one object is drawn on one face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Window {
    /// The object.
    pub slot: u8,
    /// Its number among those that throw shadows.
    caster: u8,
    /// Its lower corner on the face.
    pub corner: [i32; 2],
    /// Texels across and up.
    pub size: [u16; 2],
    /// log2 of a texel's side.
    pub shift: u32,
    /// Its first texel.
    pub first: u32,
}

impl Window {
    /// Nothing.
    pub const EMPTY: Self = Self {
        slot: 0,
        caster: 0,
        corner: [0; 2],
        size: [0; 2],
        shift: 0,
        first: 0,
    };
}

/// A box on a face: from, to.
type Extent = [[i32; 2]; 2];
const NOWHERE: Extent = [[i32::MAX; 2], [i32::MIN; 2]];

/// The maps of all lamps.
#[derive(Debug)]
pub struct Maps<'a> {
    texels: &'a mut [u16],
    windows: &'a mut [Window],
    count: usize,
    /// Where the windows of each face of each lamp begin.
    faces: [u8; LAMPS * FACES + 1],
    drawings: u32,
}

impl<'a> Maps<'a> {
    /// Over storage for texels and for windows, of which [`WINDOWS`] are used at most.
    pub fn new(texels: &'a mut [u16], windows: &'a mut [Window]) -> Self {
        Self {
            texels,
            windows,
            count: 0,
            faces: [0; LAMPS * FACES + 1],
            drawings: 0,
        }
    }

    /// The same over other storage, which holds what this one's held.
    pub(super) fn over<'b>(self, texels: &'b mut [u16], windows: &'b mut [Window]) -> Maps<'b> {
        Maps {
            texels,
            windows,
            count: self.count,
            faces: self.faces,
            drawings: self.drawings,
        }
    }

    /// Nothing stands anywhere.
    pub fn clear(&mut self) {
        self.count = 0;
        self.faces = [0; LAMPS * FACES + 1];
    }

    /// Whether something stands anywhere.
    #[inline]
    #[must_use]
    pub fn any(&self) -> bool {
        self.count > 0
    }

    /// The windows.
    #[must_use]
    pub fn windows(&self) -> &[Window] {
        self.windows.get(..self.count).unwrap_or(&[])
    }

    /// Where the windows of each face of each lamp begin, and the last end.
    #[must_use]
    pub fn faces(&self) -> &[u8] {
        &self.faces
    }

    /// The texels of all windows.
    #[must_use]
    pub fn texels(&self) -> &[u16] {
        let used = self.windows().last().map_or(0, |last| {
            last.first as usize + usize::from(last.size[0]) * usize::from(last.size[1])
        });
        self.texels.get(..used).unwrap_or(&[])
    }

    /// How often they were drawn, modulo 2^32.
    #[must_use]
    pub fn drawings(&self) -> u32 {
        self.drawings
    }

    /// The windows of a face.
    #[inline]
    fn on(&self, lamp: usize, face: usize) -> &[Window] {
        let entry = lamp * FACES + face;
        let at = |i: usize| self.faces.get(i).map_or(0, |&v| usize::from(v));
        self.windows.get(at(entry)..at(entry + 1)).unwrap_or(&[])
    }

    /// Whether something other than the object of `slot` stands before what a lamp sees.
    #[inline]
    #[must_use]
    pub fn blocked(&self, lamp: usize, aim: &Aim, slot: u8) -> bool {
        self.on(lamp, aim.face).iter().any(|window| {
            let [x, y] = window.texel(aim.at);
            let inside = x < u32::from(window.size[0]) && y < u32::from(window.size[1]);
            if !inside || window.slot == slot {
                return false;
            }
            let texel = window.first + y * u32::from(window.size[0]) + x;
            let nearest = self.texels.get(texel as usize).copied();
            nearest.is_some_and(|nearest| aim.depth > nearest.saturating_add(BEHIND))
        })
    }

    /// Draws everything anew.
    pub fn draw(
        &mut self,
        kinds: [Option<LampKind>; LAMPS],
        facets: &[Facet],
        towards: &[[Toward; LAMPS]],
    ) {
        self.clear();
        self.drawings = self.drawings.wrapping_add(1);
        let lamps = kinds.iter().flatten().count().max(1);
        let budget = (self.texels.len() / lamps).min(u32::MAX as usize);
        let mut first = 0;
        for (lamp, kind) in kinds.iter().enumerate() {
            if let Some(kind) = kind {
                let mut extents = [[NOWHERE; CASTERS]; FACES];
                each(lamp, *kind, facets, towards, |face, facet, corners| {
                    let extent = extents
                        .get_mut(face)
                        .and_then(|e| e.get_mut(usize::from(facet.caster)));
                    if let Some(extent) = extent {
                        widen(*kind, extent, corners);
                    }
                });
                first = self.open(lamp, &extents, facets, first, budget);
            }
            for face in self.faces.iter_mut().skip((lamp + 1) * FACES) {
                *face = self.count as u8;
            }
        }
        let texels = self.texels.get_mut(..first).unwrap_or(&mut []);
        texels.fill(NOTHING);
        for (lamp, kind) in kinds.iter().enumerate() {
            let Some(kind) = kind else { continue };
            each(lamp, *kind, facets, towards, |face, facet, corners| {
                let windows = self.on(lamp, face).iter();
                if let Some(window) = windows.copied().find(|w| w.caster == facet.caster) {
                    let texels = self.texels.get_mut(window.first as usize..);
                    let len = usize::from(window.size[0]) * usize::from(window.size[1]);
                    let texels = texels.and_then(|texels| texels.get_mut(..len));
                    triangle(*kind, &window, corners, texels.unwrap_or(&mut []));
                }
            });
        }
    }

    /// Makes room for the windows of a lamp, from texel `first` on; returns where they end.
    fn open(
        &mut self,
        lamp: usize,
        extents: &[[Extent; CASTERS]; FACES],
        facets: &[Facet],
        first: usize,
        budget: usize,
    ) -> usize {
        let side = |extent: &Extent, k: usize, shift: u32| -> usize {
            let [from, to] = extent;
            match (from.get(k), to.get(k)) {
                (Some(from), Some(to)) if from <= to => ((to - from) >> shift) as usize + 1,
                _ => 0,
            }
        };
        let area = |extent: &Extent, shift| side(extent, 0, shift) * side(extent, 1, shift);
        let all = |shift| -> usize {
            let extents = extents.as_flattened().iter();
            let areas = extents.map(|extent| area(extent, shift));
            // Each is below 2^31: their sum may be more than an address of 32 bits.
            areas.fold(0, usize::saturating_add)
        };
        // A face has no more than 2^18 texels along a side; sides are 16 bits.
        let Some(shift) = (3..20).find(|shift| all(*shift) <= budget) else {
            return first;
        };
        let mut end = first;
        for (face, casters) in extents.iter().enumerate() {
            if let Some(start) = self.faces.get_mut(lamp * FACES + face) {
                *start = self.count as u8;
            }
            for (caster, extent) in casters.iter().enumerate() {
                let size = [side(extent, 0, shift), side(extent, 1, shift)];
                let texels = area(extent, shift);
                let facet = facets.iter().find(|f| usize::from(f.caster) == caster);
                if texels > 0
                    && self.count < WINDOWS
                    && let Some(facet) = facet
                    && let Some(window) = self.windows.get_mut(self.count)
                {
                    *window = Window {
                        slot: facet.slot,
                        caster: caster as u8,
                        corner: extent[0],
                        size: size.map(|v| v as u16),
                        shift,
                        first: end as u32,
                    };
                    self.count += 1;
                    end += texels;
                }
            }
        }
        end
    }
}

impl Window {
    /// For the twin, its words: slot, corner, size in texels, shift, first texel.
    #[must_use]
    pub fn words(&self) -> [u32; 8] {
        [
            u32::from(self.slot),
            self.corner[0] as u32,
            self.corner[1] as u32,
            u32::from(self.size[0]),
            u32::from(self.size[1]),
            self.shift,
            self.first,
            0,
        ]
    }

    /// The texel at a place of the face; beyond [`Window::size`] outside.
    #[inline]
    fn texel(&self, at: [i32; 2]) -> [u32; 2] {
        let [x, y] = self.corner;
        let [s, t] = at;
        [(s - x) >> self.shift, (t - y) >> self.shift].map(|v| v as u32)
    }
}

/// Hands over the corners of every triangle as seen by every face that may see it.
fn each(
    lamp: usize,
    kind: LampKind,
    facets: &[Facet],
    towards: &[[Toward; LAMPS]],
    mut draw: impl FnMut(usize, &Facet, &[[i32; 3]; 3]),
) {
    let faces = match kind {
        LampKind::Point => FACES,
        LampKind::Directional => 1,
    };
    for facet in facets {
        let toward = towards
            .get(usize::from(facet.slot))
            .and_then(|t| t.get(lamp));
        let Some(toward) = toward else { continue };
        let places = facet.corners.map(|corner| toward.place(corner));
        for face in 0..faces {
            let corners = places.map(|place| facing(kind, face, place));
            if kind == LampKind::Directional || may_see(&corners) {
                draw(face, facet, &corners);
            }
        }
    }
}

/// Whether a face of a cube may see a triangle: not if all of it is on the far side of one of the
/// planes through the lamp that bound the face.
fn may_see(corners: &[[i32; 3]; 3]) -> bool {
    let beyond = |outside: fn(&[i32; 3]) -> bool| corners.iter().all(outside);
    !(beyond(|[_, _, ahead]| *ahead <= 0)
        || beyond(|[x, _, ahead]| x > ahead)
        || beyond(|[x, _, ahead]| -x > *ahead)
        || beyond(|[_, y, ahead]| y > ahead)
        || beyond(|[_, y, ahead]| -y > *ahead))
}

/// Where a corner is seen on its face; `None` beside or behind the lamp.
fn seen(kind: LampKind, [x, y, ahead]: [i32; 3]) -> Option<[i32; 2]> {
    if kind == LampKind::Directional {
        return Some([x, y]);
    }
    if ahead <= 0 {
        return None;
    }
    let on = |v: i32| {
        let quotient = (i64::from(v) << FACE_BITS).checked_div(i64::from(ahead));
        quotient.map(|q| q.clamp(-(1 << 30), 1 << 30) as i32)
    };
    Some([on(x)?, on(y)?])
}

/// Half the side of a lamp's faces.
const fn half(kind: LampKind) -> i32 {
    match kind {
        LampKind::Point => FACE,
        LampKind::Directional => PLANE,
    }
}

/// Widens a window by what a triangle may cover of the face.
fn widen(kind: LampKind, extent: &mut Extent, corners: &[[i32; 3]; 3]) {
    let half = half(kind);
    let mut own = NOWHERE;
    for corner in corners {
        let Some(at) = seen(kind, *corner) else {
            // It reaches beside the lamp: anywhere.
            own = [[-half; 2], [half; 2]];
            break;
        };
        let [from, to] = &mut own;
        for ((from, to), at) in from.iter_mut().zip(to).zip(at) {
            *from = (*from).min(at);
            *to = (*to).max(at);
        }
    }
    let [from, to] = own;
    let outside = from.iter().any(|v| *v > half) || to.iter().any(|v| *v < -half);
    if outside {
        return;
    }
    let [low, high] = extent;
    for (low, from) in low.iter_mut().zip(from) {
        *low = (*low).min(from.max(-half));
    }
    for (high, to) in high.iter_mut().zip(to) {
        *high = (*high).max(to.min(half));
    }
}

/// Draws a triangle into a window.
fn triangle(kind: LampKind, window: &Window, corners: &[[i32; 3]; 3], texels: &mut [u16]) {
    let depths = corners.map(|[_, _, ahead]| i64::from(ahead));
    let rows = rows(kind, window, corners);
    // A directional lamp sees as from far ahead.
    let corners = corners.map(|[x, y, ahead]| match kind {
        LampKind::Point => [x, y, ahead],
        LampKind::Directional => [x, y, FACE],
    });
    // To so many bits that products of three fit.
    let largest = corners
        .as_flattened()
        .iter()
        .fold(1, |most, v| v.unsigned_abs().max(most));
    let down = (32 - CORNER_BITS).saturating_sub(largest.leading_zeros());
    let [a, b, c] = corners.map(|corner| corner.map(|v| i64::from(v >> down)));
    let mut edges = [cross(b, c), cross(c, a), cross(a, b)];
    let volume = dot(a, edges[0]);
    if volume == 0 {
        return;
    }
    if volume < 0 {
        edges = edges.map(|edge| edge.map(|v| -v));
    }
    let (nearest, farthest) = (
        depths.iter().fold(i64::MAX, |v, d| v.min(*d)),
        depths.iter().fold(i64::MIN, |v, d| v.max(*d)),
    );
    let flat = depth_of(kind, nearest as i32) == depth_of(kind, farthest as i32);
    let width = usize::from(window.size[0]);
    let step = 1i64 << window.shift;
    let [left, low] = window.corner.map(|v| i64::from(v) + (step >> 1));
    for row in rows {
        let t = low + i64::from(row) * step;
        // Each edge as along·column + from ≥ 0.
        let lines =
            edges.map(|[ex, ey, ez]| (ex * step, ex * left + ey * t + ez * i64::from(FACE)));
        let (mut start, mut end) = (0, width as i64);
        for (along, from) in lines {
            if along > 0 {
                start = start.max(-from.checked_div_euclid(along).unwrap_or(0));
            } else if along < 0 {
                end = end.min(from.checked_div_euclid(-along).unwrap_or(0) + 1);
            } else if from < 0 {
                end = 0;
            }
        }
        if start >= end {
            continue;
        }
        let line = texels.get_mut(row as usize * width..).unwrap_or(&mut []);
        let line = line
            .get_mut(start as usize..end as usize)
            .unwrap_or(&mut []);
        for (column, texel) in (start..).zip(line) {
            let depth = if flat {
                nearest
            } else {
                let weights = lines.map(|(along, from)| along * column + from);
                between(weights, depths).clamp(nearest, farthest)
            };
            *texel = (*texel).min(depth_of(kind, depth as i32));
        }
    }
}

/// The mean of depths, weighted by what is not negative and below 2^52.
fn between(weights: [i64; 3], depths: [i64; 3]) -> i64 {
    let sum: i64 = weights.iter().sum();
    let down = (33u32).saturating_sub(sum.leading_zeros());
    let (mut total, mut mean) = (0, 0);
    for (weight, depth) in weights.iter().zip(depths) {
        // 31 and 24 bits.
        total += weight >> down;
        mean += (weight >> down) * depth;
    }
    mean.checked_div(total).unwrap_or(depths[0])
}

/// The rows of a window that a triangle may cover.
fn rows(kind: LampKind, window: &Window, corners: &[[i32; 3]; 3]) -> core::ops::Range<u32> {
    let all = 0..u32::from(window.size[1]);
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for corner in corners {
        let Some([_, y]) = seen(kind, *corner) else {
            return all;
        };
        let row = (y - window.corner[1]) >> window.shift;
        low = low.min(row);
        high = high.max(row);
    }
    // A row to spare: corners are drawn with fewer bits.
    let clamp = |row: i32| row.clamp(0, i32::from(window.size[1])) as u32;
    clamp(low.saturating_sub(1))..clamp(high.saturating_add(2))
}

fn cross([ax, ay, az]: [i64; 3], [bx, by, bz]: [i64; 3]) -> [i64; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

fn dot(a: [i64; 3], b: [i64; 3]) -> i64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
