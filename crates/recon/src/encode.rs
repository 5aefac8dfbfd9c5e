//! Last step of a refresh: light, filtered or averaged, to the panel's codes.

use crate::arith::{Arith, Texel};
use crate::config::Light;
use crate::display::Display;
use crate::rest::{self, Mean};
use crate::tables::{SRGB_TO_LINEAR, even_to_code, linear_to_srgb};
use crate::workers::{Parts, Workers};
use unframed_wire::Tick;

/// 8-bit codes as they are, spread over 16 bits.
pub static ENCODED: [u16; 256] = {
    let mut table = [0; 256];
    let mut c = 0;
    while c < 256 {
        table[c] = c as u16 * 257;
        c += 1;
    }
    table
};

impl Light {
    /// The quantity of each code of a colour.
    #[must_use]
    pub const fn table(self) -> &'static [u16; 256] {
        match self {
            Self::Linear => &SRGB_TO_LINEAR,
            Self::Encoded => &ENCODED,
        }
    }

    /// The code of a quantity.
    #[must_use]
    pub fn code(self, light: u16) -> u8 {
        match self {
            Self::Linear => linear_to_srgb(light),
            Self::Encoded => even_to_code(light),
        }
    }
}

/// Shows what filter and mean know of a pixel; where both know nothing it keeps what it shows.
#[inline(always)]
fn show<A: Arith>(light: Light, texel: &Texel<A>, mean: &Mean, pixel: &mut [u8; 3]) {
    let known = texel.confidence != A::Confidence::default();
    if known || mean.count > 0 {
        for ((shown, own), sum) in pixel.iter_mut().zip(texel.light).zip(mean.sum) {
            let prior = known.then(|| A::to_u16(own));
            *shown = light.code(rest::blend(prior, sum, mean.count));
        }
    }
}

impl<A: Arith, W: Workers> Display<'_, A, W> {
    /// Adds the new samples to the means of the pixels that they fall into, but for tiles that do
    /// not rest; `quiet` says that all do. With `shows` these pixels show it.
    pub(crate) fn average(&mut self, now: Tick, quiet: bool, shows: bool) {
        let light = self.config.light.table();
        for sample in self.deep.take_fresh(rest::MOST).into_iter().flatten() {
            let place = rest::place(&self.panel, self.slots, sample, now);
            if let Some((x, y)) = place
                && (quiet || self.tiles.rests_at(x, y))
                && let Some(pixel) = self.panel.inside(x, y)
                && let Some(mean) = self.means.get_mut(pixel)
            {
                let rgb = self.lights.relight(sample);
                mean.add(rgb.map(|code| light[usize::from(code)]));
                if shows
                    && let Some(texel) = self.texels.get(pixel)
                    && let Some(shown) = self.picture.get_mut(pixel)
                {
                    show(self.config.light, texel, mean, shown);
                }
            }
        }
    }

    /// Shows every pixel.
    pub(crate) fn encode(&mut self) {
        let light = self.config.light;
        let averaged = self.averaged;
        let share = self.texels.len().div_ceil(self.workers.parts()).max(1);
        let mut means = &*self.means;
        let work = self
            .texels
            .chunks(share)
            .zip(self.picture.chunks_mut(share))
            .map(|(texels, picture)| {
                let (own, rest) = means.split_at_checked(share).unwrap_or((means, &[]));
                means = rest;
                (texels, picture, own)
            });
        Parts::new(work).each(&self.workers, |(texels, picture, means)| {
            let pixels = texels.iter().zip(&mut **picture);
            if averaged {
                for ((texel, pixel), mean) in pixels.zip(*means) {
                    show(light, texel, mean, pixel);
                }
            } else {
                for (texel, pixel) in pixels {
                    show(light, texel, &Mean::EMPTY, pixel);
                }
            }
        });
    }
}
