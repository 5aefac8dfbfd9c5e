//! Samples straight to their pixels: what is left of a refresh where no sample asks about others.
//!
//! With [`Extents::Pixel`], means and no hidden-point test nothing has to be known of a sample's
//! neighbours before it is added. So nothing is kept in between: one pass over the ring places, weighs
//! and adds, and of a place only the pixel counts ([`crate::glance`]). This is what a microcontroller
//! has time for. The sums are those of [`crate::splat`], to the bit.

use crate::arith::{Arith, Sums};
use crate::config::{Config, Extents, Lifetime};
use crate::deep::{Placing, Stored};
use crate::project::{Instant, locate};
use crate::workers::take;

/// Whether a display of this configuration adds samples straight to their pixels.
#[must_use]
pub const fn applies(config: &Config) -> bool {
    matches!(config.extents, Extents::Pixel)
        && matches!(config.lifetime, Lifetime::Tiles)
        && !config.hidden
        && !config.planes()
}

/// The pixel of a sample that is placed in any way.
#[inline(never)]
fn pixel_of<A: Arith>(instant: &Instant<'_, A>, sample: &Stored) -> Option<usize> {
    let (x, y, _) = locate(&instant.panel, instant.slots, sample)?;
    A::within(&instant.panel, x, y)
}

/// Samples that are placed before any is weighed: each loop alone finds the registers that both
/// together would not.
const BLOCK: usize = 64;
/// The pixel of a sample that is on none.
const NONE: usize = usize::MAX;

/// The pixels of samples.
#[inline(never)]
fn place<A: Arith>(instant: &Instant<'_, A>, samples: &[Stored], pixels: &mut [usize]) {
    // A copy, which compilers see to be the same for all samples.
    let panel = instant.panel;
    // Samples beside each other are often of one object.
    let mut slot = 0;
    let mut transform = instant.transform(slot);
    for (sample, pixel) in samples.iter().zip(pixels) {
        if sample.slot != slot {
            slot = sample.slot;
            transform = instant.transform(slot);
        }
        let own = match transform {
            Some(transform) if sample.placing == Placing::Lattice => {
                A::falls(transform, &panel, sample.place)
            }
            _ => pixel_of(instant, sample),
        };
        *pixel = own.unwrap_or(NONE);
    }
}

/// Adds samples of an age to their pixels. `LIT`: some may lie in the shadow of something that moves.
#[inline(never)]
fn add_block<A: Arith, const LIT: bool>(
    instant: &Instant<'_, A>,
    age: A::Log,
    light: &[u16; 256],
    samples: &[Stored],
    pixels: &[usize],
    sums: &mut [Sums<A>],
) {
    let Config { kernel, cutoff, .. } = instant.config;
    let (panel, lifetimes) = (&instant.panel, instant.lifetimes);
    for (sample, own) in samples.iter().zip(pixels) {
        if let Some(lifetime) = lifetimes.get(*own)
            && let Some(sums) = sums.get_mut(*own)
        {
            let weight = A::decline(kernel, cutoff, age, *lifetime);
            let rgb = if LIT {
                instant.lights.relight(sample)
            } else {
                sample.rgb
            };
            let light = rgb.map(|code| A::light(light[usize::from(code)]));
            let features = A::features(panel, light, Default::default(), (0, 0));
            A::add(sums, A::factor(weight), &features);
        }
    }
}

/// Adds samples to the sums of their pixels. Those too old to be told from young ones are emptied.
#[inline(never)]
pub fn add<A: Arith>(
    instant: &Instant<'_, A>,
    light: &[u16; 256],
    samples: &mut [Stored],
    sums: &mut [Sums<A>],
) {
    let longest = instant.longest();
    let mut pixels = [NONE; BLOCK];
    let mut rest = samples;
    while let Some(&Stored { time, .. }) = rest.first() {
        // Samples of a packet share their time.
        let head = rest.get(..BLOCK).unwrap_or(rest);
        let others = head.iter().position(|sample| sample.time != time);
        let run = others.unwrap_or(head.len());
        let samples = take(&mut rest, run);
        match instant.age(time) {
            None => samples.iter_mut().for_each(|s| s.placing = Placing::Empty),
            Some(age) if A::counts(instant.decline(age.log, longest)) => {
                place(instant, samples, &mut pixels);
                let add = if instant.lights.shines() {
                    add_block::<A, true>
                } else {
                    add_block::<A, false>
                };
                add(instant, age.log, light, samples, &pixels, sums);
            }
            Some(_) => {}
        }
    }
}
