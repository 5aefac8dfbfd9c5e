//! The shapes of what throws shadows.

use crate::deep::slot;

/// Objects that may throw shadows.
pub const CASTERS: usize = 16;
/// Parts that a shape may have.
pub const PARTS: u16 = u32::BITS as u16;

/// What became of a part of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// It was not known before.
    New,
    /// It was.
    Known,
    /// There is no room for it.
    NoRoom,
}

/// A triangle of an object: 20 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Facet {
    /// Its corners in the object's lattice.
    pub corners: [[i16; 3]; 3],
    /// The object's slot.
    pub slot: u8,
    /// The object's number among those that throw shadows.
    pub caster: u8,
}

impl Facet {
    /// Nothing.
    pub const EMPTY: Self = Self {
        corners: [[0; 3]; 3],
        slot: 0,
        caster: 0,
    };
}

/// An object that throws shadows, and which parts of it are known.
#[derive(Clone, Copy, Debug, Default)]
struct Caster {
    slot: u8,
    parts: u32,
}

/// All that throws shadows.
#[derive(Debug)]
pub struct Facets<'a> {
    facets: &'a mut [Facet],
    len: usize,
    casters: [Caster; CASTERS],
    count: usize,
}

impl<'a> Facets<'a> {
    /// Nothing yet.
    pub fn new(facets: &'a mut [Facet]) -> Self {
        Self {
            facets,
            len: 0,
            casters: [Caster::default(); CASTERS],
            count: 0,
        }
    }

    /// The same over other storage, which holds what this one's held.
    pub(super) fn over(self, facets: &mut [Facet]) -> Facets<'_> {
        Facets {
            facets,
            len: self.len,
            casters: self.casters,
            count: self.count,
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.len = 0;
        self.count = 0;
    }

    /// Whether nothing throws shadows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The triangles, those of a part together.
    #[must_use]
    pub fn all(&self) -> &[Facet] {
        self.facets.get(..self.len).unwrap_or(&[])
    }

    /// Whether the object of a slot throws shadows.
    #[must_use]
    pub fn knows(&self, slot: u8) -> bool {
        let casters = self.casters.iter().take(self.count);
        casters.into_iter().any(|caster| caster.slot == slot)
    }

    /// Takes a part of the shape of an object, of `len` triangles.
    pub fn take(
        &mut self,
        object: u8,
        part: u8,
        len: usize,
        triangles: impl Iterator<Item = [[i16; 3]; 3]>,
    ) -> Taken {
        let slot = slot(object);
        let known = self.casters.iter().take(self.count);
        let caster = known.clone().position(|caster| caster.slot == slot);
        let caster = caster.unwrap_or(self.count);
        let part = 1u32.checked_shl(part.into());
        let (Some(entry), Some(part)) = (self.casters.get_mut(caster), part) else {
            return Taken::NoRoom;
        };
        if caster == self.count {
            *entry = Caster { slot, parts: 0 };
        }
        if entry.parts & part != 0 {
            return Taken::Known;
        }
        let room = self.facets.get_mut(self.len..).unwrap_or(&mut []);
        let Some(room) = room.get_mut(..len) else {
            return Taken::NoRoom;
        };
        for (facet, corners) in room.iter_mut().zip(triangles) {
            *facet = Facet {
                corners,
                slot,
                caster: caster as u8,
            };
        }
        entry.parts |= part;
        self.len += room.len();
        self.count = self.count.max(caster + 1);
        Taken::New
    }
}
