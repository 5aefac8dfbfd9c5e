//! The shapes of what throws shadows.

use super::slot_of;
use unframed_wire::Shape;

/// Objects that may throw shadows.
pub const CASTERS: usize = 16;
/// Parts of a shape.
pub const PARTS: u8 = 32;

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

    /// Takes a part of a shape. False where it is known, or there is no room for all of it.
    pub fn take(&mut self, shape: &Shape<'_>) -> bool {
        let slot = slot_of(shape);
        if shape.part() >= PARTS {
            return false;
        }
        let known = self.casters.iter().take(self.count);
        let caster = match known.clone().position(|caster| caster.slot == slot) {
            Some(caster) => caster,
            None => self.count,
        };
        let Some(entry) = self.casters.get_mut(caster) else {
            return false;
        };
        let part = 1 << shape.part();
        let mut entry_now = if caster == self.count {
            Caster { slot, parts: 0 }
        } else {
            *entry
        };
        let room = self.facets.get_mut(self.len..).unwrap_or(&mut []);
        let mut len = 0;
        for corners in shape.triangles() {
            let Some(facet) = room.get_mut(len) else {
                return false;
            };
            *facet = Facet {
                corners,
                slot,
                caster: caster as u8,
            };
            len += 1;
        }
        if entry_now.parts & part != 0 {
            return false;
        }
        entry_now.parts |= part;
        *entry = entry_now;
        self.count = self.count.max(caster + 1);
        self.len += len;
        true
    }
}
