//! Light of the instant. Lamps and shapes are [`unframed_recon::light`]'s own, and it draws the
//! shadow maps too: that is the work of a display's controller, like composing view and poses. What maps
//! say of each sample is found in shaders.

use crate::gpu::{Gpu, GpuError};
use crate::pass::Words;
use bytemuck::{Pod, Zeroable};
use unframed_recon::Fixed;
use unframed_recon::light::facets::Facet;
use unframed_recon::light::map::{WINDOWS, Window};
use unframed_recon::light::toward::{FACES, Toward};
use unframed_recon::light::{CODES, FACETS, Lights, Memory, TEXELS};
use unframed_recon::memory::Slot;
use unframed_wire::{LAMPS, Shape};

/// Slots of poses: the sky's and all objects'.
const SLOTS: usize = 256;
/// Words of [`Lamps`].
pub(super) const WORDS: usize = size_of::<Lamps>() / 4;

/// What precedes the texels in the buffer of lights, twin of `Lamps` in `light.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Lamps {
    /// Windows of all maps; where there are none nothing is in a shadow.
    pub(super) windows_len: u32,
    /// A bit a lamp: whether it is directional.
    pub(super) directional: u32,
    /// Where the windows of each face of each lamp begin, and the last end.
    pub(super) faces: [u32; LAMPS * FACES + 1],
    /// See `Window::words`.
    pub(super) windows: [[u32; 8]; WINDOWS],
    /// By what each lamp dims red, green and blue, for each code of a share.
    pub(super) parts: [u32; 3 * CODES * LAMPS],
    /// A matrix and an offset for each slot and lamp.
    pub(super) towards: [[i32; 12]; SLOTS * LAMPS],
}

impl Lamps {
    fn of(lights: &Lights<'_>) -> Lamps {
        let maps = lights.maps();
        let mut lamps = Lamps::zeroed();
        lamps.windows_len = maps.windows().len() as u32;
        for (lamp, directional) in lights.directional().into_iter().enumerate() {
            lamps.directional |= u32::from(directional) << lamp;
        }
        for (to, from) in lamps.faces.iter_mut().zip(maps.faces()) {
            *to = u32::from(*from);
        }
        for (to, from) in lamps.windows.iter_mut().zip(maps.windows()) {
            *to = from.words();
        }
        let parts = lights.parts().as_flattened().as_flattened();
        for (to, from) in lamps.parts.iter_mut().zip(parts) {
            *to = u32::from(*from);
        }
        let towards = lights.towards().as_flattened();
        for (to, Toward { matrix, offset }) in lamps.towards.iter_mut().zip(towards) {
            let from = matrix.as_flattened().iter().chain(offset);
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
        }
        lamps
    }
}

/// Lights over storage of their own, and what the adapter knows of them.
pub(super) struct OwnLights {
    /// Over no storage while nobody uses it.
    lights: Lights<'static>,
    facets: Vec<Facet>,
    towards: Vec<[Toward; LAMPS]>,
    texels: Vec<u16>,
    windows: Vec<Window>,
    /// What the adapter has.
    told: Box<Lamps>,
    /// [`unframed_recon::light::map::Maps::drawings`] of the texels that the adapter has.
    drawings: u32,
}

impl OwnLights {
    /// No lamps yet; room as `unframed_recon::heap` has it.
    pub(super) fn new() -> OwnLights {
        OwnLights {
            lights: Lights::new(Memory::default()),
            facets: vec![Facet::EMPTY; FACETS],
            towards: vec![[Toward::ZERO; LAMPS]; SLOTS],
            texels: vec![0; TEXELS],
            windows: vec![Window::EMPTY; WINDOWS],
            told: Box::new(Lamps::zeroed()),
            drawings: 0,
        }
    }

    /// Lends the storage for as long as `used` runs.
    fn with<R>(&mut self, used: impl FnOnce(&mut Lights<'_>) -> R) -> R {
        let none = Lights::new(Memory::default());
        let mut lights = std::mem::replace(&mut self.lights, none).over(Memory {
            facets: &mut self.facets,
            towards: &mut self.towards,
            texels: &mut self.texels,
            windows: &mut self.windows,
        });
        let result = used(&mut lights);
        self.lights = lights.over(Memory::default());
        result
    }

    /// Forgets lamps and shapes.
    pub(super) fn clear(&mut self) {
        self.with(|lights| lights.clear());
    }

    /// Takes all lamps; returns how many are refused.
    pub(super) fn lamps(&mut self, lamps: unframed_wire::Lamps<'_>) -> u64 {
        self.with(|lights| {
            let taken = |(index, lamp)| lights.lamp(index, &lamp);
            lamps.enumerate().map(taken).filter(|taken| !taken).count() as u64
        })
    }

    /// Takes a part of a shape; returns how many are refused.
    pub(super) fn shape(&mut self, shape: &Shape<'_>) -> u64 {
        self.with(|lights| u64::from(!lights.shape(shape)))
    }

    /// Draws the maps of an instant and tells the adapter what changed, in a buffer of lights:
    /// nothing as long as nothing throws shadows. Returns whether shadows changed.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        slots: &[Slot<Fixed>],
        buffer: &Words,
    ) -> Result<bool, GpuError> {
        let (told, drawings) = (self.told.windows_len, self.drawings);
        let (changed, shines, drawn) = self.with(|lights| {
            let changed = lights.prepare(slots);
            (changed, lights.shines(), lights.maps().drawings())
        });
        if !shines && told == 0 {
            return Ok(changed);
        }
        let (lamps, texels) = self.with(|lights| {
            let pair = |pair: &[u16]| {
                let [low, high] = [0, 1].map(|i| pair.get(i).map_or(0, |v| u32::from(*v)));
                low | high << 16
            };
            let texels = (drawn != drawings).then(|| lights.maps().texels());
            let texels = texels.map(|texels| texels.chunks(2).map(pair).collect::<Vec<u32>>());
            (Box::new(Lamps::of(lights)), texels)
        });
        if lamps != self.told {
            let words = bytemuck::cast_slice(std::slice::from_ref(&*lamps));
            buffer.write(gpu, 0, words)?;
            self.told = lamps;
        }
        if let Some(texels) = texels {
            buffer.write(gpu, WORDS, &texels)?;
            self.drawings = drawn;
        }
        Ok(changed)
    }
}

#[cfg(test)]
#[path = "light_tests.rs"]
mod tests;
