//! Storage on the heap, for desktops (feature `heap`).

use crate::arith::{Arith, Moments, Projected, Sums, Texel};
use crate::deep::Stored;
use crate::light::facets::Facet;
use crate::light::map::{WINDOWS, Window};
use crate::light::{self, toward::Toward};
use crate::memory::{Memory, Needs, Slot};
use crate::rest::Mean;
use crate::tiles::Cell;
use crate::workers::MAX_PARTS;
use alloc::vec;
use alloc::vec::Vec;
use unframed_wire::LAMPS;

/// The storage of a display of any size.
#[derive(Debug)]
pub struct HeapStorage<A: Arith> {
    samples: Vec<Stored>,
    projected: Vec<Projected<A>>,
    sorted: Vec<Projected<A>>,
    starts: Vec<u32>,
    minima: Vec<A::Depth>,
    limits: Vec<A::Depth>,
    movers: Vec<u8>,
    mass: Vec<A::Mass>,
    logs: Vec<A::Log>,
    sums: Vec<Sums<A>>,
    moments: Vec<Moments<A>>,
    texels: Vec<Texel<A>>,
    pyramid: Vec<Texel<A>>,
    means: Vec<Mean>,
    cells: Vec<Cell>,
    slots: Vec<Slot<A>>,
    picture: Vec<[u8; 3]>,
    facets: Vec<Facet>,
    towards: Vec<[Toward; LAMPS]>,
    shadows: Vec<u16>,
    windows: Vec<Window>,
}

impl<A: Arith> HeapStorage<A> {
    /// Storage for a panel of this size, `samples` in the deep buffer, all 256 objects, planes.
    #[must_use]
    pub fn new(width: u16, height: u16, samples: usize) -> Self {
        let needs = Needs::of(width, height);
        Self {
            samples: vec![Stored::default(); samples],
            projected: vec![Projected::default(); samples],
            sorted: vec![Projected::default(); samples],
            starts: vec![0; MAX_PARTS * needs.starts],
            minima: vec![A::Depth::default(); needs.minima],
            limits: vec![A::Depth::default(); needs.pixels],
            movers: vec![0; needs.pixels],
            mass: vec![A::Mass::default(); needs.pixels],
            logs: vec![A::Log::default(); needs.pixels],
            sums: vec![Sums::<A>::default(); needs.pixels],
            moments: vec![Moments::<A>::default(); needs.pixels],
            texels: vec![Texel::default(); needs.pixels],
            pyramid: vec![Texel::default(); needs.pyramid],
            means: vec![Mean::default(); needs.pixels],
            cells: vec![Cell::default(); needs.cells],
            slots: vec![Slot::default(); 256],
            picture: vec![[0; 3]; needs.pixels],
            facets: vec![Facet::EMPTY; light::FACETS],
            towards: vec![[Toward::ZERO; LAMPS]; 256],
            shadows: vec![0; light::TEXELS],
            windows: vec![Window::EMPTY; WINDOWS],
        }
    }

    /// The storage as a display takes it.
    pub fn memory(&mut self) -> Memory<'_, A> {
        Memory {
            samples: &mut self.samples,
            projected: &mut self.projected,
            sorted: &mut self.sorted,
            starts: &mut self.starts,
            minima: &mut self.minima,
            limits: &mut self.limits,
            movers: &mut self.movers,
            mass: &mut self.mass,
            logs: &mut self.logs,
            sums: &mut self.sums,
            moments: &mut self.moments,
            texels: &mut self.texels,
            pyramid: &mut self.pyramid,
            means: &mut self.means,
            cells: &mut self.cells,
            slots: &mut self.slots,
            picture: &mut self.picture,
            light: light::Memory {
                facets: &mut self.facets,
                towards: &mut self.towards,
                texels: &mut self.shadows,
                windows: &mut self.windows,
            },
        }
    }
}
