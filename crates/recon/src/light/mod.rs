//! Light of the instant: shadows of what moves.
//!
//! A stream may carry samples *as if no other thing that moves stood before the lamps*, each with
//! the share of its light that comes from each lamp ([`Shares`]). Such samples stay true while
//! shadows sweep over them. The display knows where the lamps are ([`Lamp`]), the shapes of what moves ([`Shape`]) and,
//! as ever, the poses of the instant. So at each refresh it draws what moves as each lamp sees it, into
//! shadow maps ([`map`]; Williams 1978, *Casting curved shadows on curved surfaces*), and takes from
//! each sample what does not reach it now.
//!
//! All of this is integers of 32 bits where samples are concerned, whatever the arithmetic of the
//! display: lamps, like colours, are discrete by design.

pub mod facets;
pub mod map;
pub mod toward;

use crate::Arith;
use crate::deep::Stored;
use crate::memory::Slot;
use crate::tables::{SRGB_TO_LINEAR, linear_to_srgb};
use facets::{Facet, Facets, Taken};
use map::{Maps, Window};
use toward::{Aim, Toward};
use unframed_wire::{LAMPS, Lamp, LampKind, Shape};

/// Everything of a light, 15 fractional bits.
pub const WHOLE: u32 = 1 << 15;
/// Codes of a share.
pub const CODES: usize = 16;
/// By what each lamp's absence dims red, green and blue, for each code of a share; parts of
/// [`WHOLE`].
pub type Parts = [[[u16; 3]; CODES]; LAMPS];

/// Triangles for which a desktop has room.
pub const FACETS: usize = 1 << 13;
/// Texels for which a desktop has room.
pub const TEXELS: usize = 1 << 19;

/// What a display keeps for lamps, over storage that the caller owns. Empty slices are storage
/// for none: such a display shows samples as they come.
#[derive(Debug, Default)]
pub struct Memory<'a> {
    /// Triangles of all that throws shadows.
    pub facets: &'a mut [Facet],
    /// One entry for each of [`crate::memory::Memory::slots`].
    pub towards: &'a mut [[Toward; LAMPS]],
    /// Texels of the shadow maps: the more, the finer are the shadows' edges.
    pub texels: &'a mut [u16],
    /// Where in the maps objects are drawn: [`map::WINDOWS`] at most.
    pub windows: &'a mut [Window],
}

/// Storage of fixed capacity: `F` triangles, `O` objects with the sky, `T` texels.
#[derive(Debug)]
pub struct Storage<const F: usize, const O: usize, const T: usize> {
    facets: [Facet; F],
    towards: [[Toward; LAMPS]; O],
    texels: [u16; T],
    windows: [Window; map::WINDOWS],
}

impl<const F: usize, const O: usize, const T: usize> Storage<F, O, T> {
    /// Empty storage; its bytes are all zero.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            facets: [Facet::EMPTY; F],
            towards: [[Toward::ZERO; LAMPS]; O],
            texels: [0; T],
            windows: [Window::EMPTY; map::WINDOWS],
        }
    }

    /// The storage as a display takes it.
    pub fn memory(&mut self) -> Memory<'_> {
        Memory {
            facets: &mut self.facets,
            towards: &mut self.towards,
            texels: &mut self.texels,
            windows: &mut self.windows,
        }
    }
}

impl<const F: usize, const O: usize, const T: usize> Default for Storage<F, O, T> {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether this display draws shadows at all (feature `light`); without, nothing of it is linked.
const DRAWS: bool = cfg!(feature = "light");

/// Lamps, and what stands before them.
#[derive(Debug)]
pub struct Lights<'a> {
    lamps: [Option<Lamp>; LAMPS],
    parts: Parts,
    facets: Facets<'a>,
    towards: &'a mut [[Toward; LAMPS]],
    maps: Maps<'a>,
    /// Whether anything changed since the maps were drawn.
    stale: bool,
}

impl<'a> Lights<'a> {
    /// No lamps yet.
    #[must_use]
    pub fn new(memory: Memory<'a>) -> Self {
        Self {
            lamps: [None; LAMPS],
            parts: [[[0; 3]; CODES]; LAMPS],
            facets: Facets::new(memory.facets),
            towards: memory.towards,
            maps: Maps::new(memory.texels, memory.windows),
            stale: false,
        }
    }

    /// The same over other storage, which holds what this one's held: for an owner of storage that
    /// lends it only while lights are used, and keeps them over none.
    #[must_use]
    pub fn over(self, memory: Memory<'_>) -> Lights<'_> {
        Lights {
            lamps: self.lamps,
            parts: self.parts,
            facets: self.facets.over(memory.facets),
            towards: memory.towards,
            maps: self.maps.over(memory.texels, memory.windows),
            stale: self.stale,
        }
    }

    /// Forgets lamps and shapes.
    pub fn clear(&mut self) {
        self.lamps = [None; LAMPS];
        self.facets.clear();
        self.maps.clear();
        self.stale = false;
    }

    /// Takes a lamp. False where it is out of range.
    pub fn lamp(&mut self, index: usize, lamp: &Lamp) -> bool {
        let (Some(known), Some(parts), true) = (
            self.lamps.get_mut(index),
            self.parts.get_mut(index),
            DRAWS && lamp.is_valid(),
        ) else {
            return false;
        };
        if *known != Some(*lamp) {
            *known = Some(*lamp);
            *parts = parts_of(lamp.tint);
            self.stale = true;
        }
        true
    }

    /// Takes a part of the shape of an object; one that is known changes nothing. False where
    /// there is no room for it.
    pub fn shape(&mut self, shape: &Shape<'_>) -> bool {
        self.take(shape.object(), shape.part(), shape.len(), shape.clone())
    }

    /// The same of triangles.
    pub fn triangles(&mut self, object: u8, part: u8, triangles: &[[[i16; 3]; 3]]) -> bool {
        self.take(object, part, triangles.len(), triangles.iter().copied())
    }

    fn take(
        &mut self,
        object: u8,
        part: u8,
        len: usize,
        triangles: impl Iterator<Item = [[i16; 3]; 3]>,
    ) -> bool {
        if !DRAWS {
            return false;
        }
        let taken = self.facets.take(object, part, len, triangles);
        self.stale |= taken == Taken::New;
        taken != Taken::NoRoom
    }

    /// Whether any sample may lie in a shadow.
    #[must_use]
    pub fn shines(&self) -> bool {
        DRAWS && self.maps.any()
    }

    /// Draws the maps of an instant, of which `slots` has the poses; what did not change is not
    /// drawn again. Returns whether anything was: then shadows are others than they were.
    pub fn prepare<A: Arith>(&mut self, slots: &[Slot<A>]) -> bool {
        if !DRAWS || self.facets.is_empty() || self.lamps.iter().all(Option::is_none) {
            return false;
        }
        let mut stale = core::mem::take(&mut self.stale);
        for (index, (towards, slot)) in self.towards.iter_mut().zip(slots).enumerate() {
            let throws = self.facets.knows(index as u8);
            for (toward, lamp) in towards.iter_mut().zip(&self.lamps) {
                let now = match (lamp, &slot.pose) {
                    (Some(lamp), Some(pose)) => Toward::new(lamp, pose),
                    _ => Toward::ZERO,
                };
                stale |= throws && *toward != now;
                *toward = now;
            }
        }
        if stale {
            let kinds = self.lamps.map(|lamp| lamp.map(|lamp| lamp.kind));
            self.maps.draw(kinds, self.facets.all(), self.towards);
        }
        stale
    }

    /// A sample's colour in the light of the instant, as received where nothing stands before the
    /// lamps.
    #[inline]
    #[must_use]
    pub fn relight(&self, sample: &Stored) -> [u8; 3] {
        if !DRAWS || sample.shares.0 == 0 || !self.maps.any() {
            return sample.rgb;
        }
        self.shaded(sample)
    }

    #[inline(never)]
    fn shaded(&self, sample: &Stored) -> [u8; 3] {
        let Some(towards) = self.towards.get(usize::from(sample.slot)) else {
            return sample.rgb;
        };
        let mut left = [WHOLE; 3];
        for (lamp, toward) in towards.iter().enumerate() {
            let code = usize::from(sample.shares.code(lamp));
            let parts = self.parts.get(lamp).and_then(|parts| parts.get(code));
            if code == 0 || !self.blocked(lamp, toward, sample) {
                continue;
            }
            for (left, part) in left.iter_mut().zip(parts.unwrap_or(&[0; 3])) {
                *left = left.saturating_sub(u32::from(*part));
            }
        }
        dimmed(sample.rgb, left)
    }

    /// Whether something stands between a sample and a lamp now.
    #[inline]
    fn blocked(&self, lamp: usize, toward: &Toward, sample: &Stored) -> bool {
        let Some(Some(Lamp { kind, .. })) = self.lamps.get(lamp) else {
            return false;
        };
        Aim::of(*kind, toward.place(sample.place))
            .is_some_and(|aim| self.maps.blocked(lamp, &aim, sample.slot))
    }

    /// For the twin: by what each lamp's absence dims.
    #[must_use]
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// For the twin: which lamps are directional.
    #[must_use]
    pub fn directional(&self) -> [bool; LAMPS] {
        self.lamps
            .map(|lamp| lamp.is_some_and(|lamp| lamp.kind == LampKind::Directional))
    }

    /// For the twin: the ways to the lamps, a slot each.
    #[must_use]
    pub fn towards(&self) -> &[[Toward; LAMPS]] {
        self.towards
    }

    /// For the twin: the maps.
    #[must_use]
    pub fn maps(&self) -> &Maps<'a> {
        &self.maps
    }
}

/// A colour of which `left` (of [`WHOLE`]) is left in each channel.
#[inline]
fn dimmed(rgb: [u8; 3], left: [u32; 3]) -> [u8; 3] {
    let mut dimmed = rgb;
    for (code, left) in dimmed.iter_mut().zip(left) {
        if left < WHOLE {
            let light = u32::from(SRGB_TO_LINEAR[usize::from(*code)]);
            // Below 2^31.
            *code = linear_to_srgb(((light * left + (WHOLE >> 1)) >> 15) as u16);
        }
    }
    dimmed
}

/// By what the absence of a lamp of this tint dims, for each code.
///
/// A code says what is left of green, r = ((15 − c)/15)². Of light that is ρ times as strong in red,
/// against the rest, as in green, ρ(1 − r)/(r + ρ(1 − r)) is missing in red then.
fn parts_of(tint: [u16; 2]) -> [[u16; 3]; CODES] {
    core::array::from_fn(|code| {
        let last = CODES as u64 - 1;
        let left = (last - code as u64).pow(2);
        let lost = last * last - left;
        let part = |tint: u64| {
            let of = 256 * left + tint * lost;
            ((tint * lost * u64::from(WHOLE))
                .checked_div(of)
                .unwrap_or(0)) as u16
        };
        let [red, blue] = tint.map(u64::from);
        [part(red), part(256), part(blue)]
    })
}
