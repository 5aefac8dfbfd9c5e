//! Screen layout: the gaps between the sorted Morton numbers of the places.
//!
//! Scattered points leave geometrically distributed gaps, for which Rice codes are near optimal:
//! 18.4 bits a place at 128 samples a packet on 256×256 pixels, where shared prefixes take 20.2.

use super::MAX_SAMPLES;
use super::colour::{self, FAR, Histogram, Parameters};
use crate::bits::{BitReader, BitWriter, rice_len};
use crate::bytes::{Buffer, Cursor};
use crate::ledger::SampleBits;
use crate::repr::*;

/// Samples of one instant with screen places; an iterator over them.
#[derive(Clone, Debug)]
pub struct ScreenSamples<'a> {
    time: Tick,
    left: u16,
    first: bool,
    /// First x and y beyond the panel, 1/16 pixel.
    edge: [u32; 2],
    k: u32,
    colours: Parameters,
    key: u32,
    rgb: [u8; 3],
    bits: BitReader<'a>,
    malformed: bool,
}

impl<'a> ScreenSamples<'a> {
    pub(crate) fn parse(payload: &'a [u8], width: u16, height: u16) -> Option<Self> {
        let mut c = Cursor(payload);
        let time = Tick(c.u32()?);
        let left = u16::from(c.u8()?) + 1;
        let mut bits = BitReader::new(c.0);
        let k = bits.bits(5)?;
        let colours = Parameters::get(&mut bits, 0)?;
        let edge = [u32::from(width) * 16, u32::from(height) * 16];
        Some(ScreenSamples {
            time,
            left,
            first: true,
            edge,
            k,
            colours,
            key: 0,
            rgb: [0; 3],
            bits,
            malformed: false,
        })
    }

    /// The instant of all samples of the packet.
    #[must_use]
    pub fn time(&self) -> Tick {
        self.time
    }

    /// Samples still to come, 1..=[`MAX_SAMPLES`] at first.
    #[must_use]
    pub fn len(&self) -> usize {
        usize::from(self.left)
    }

    /// Whether none is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.left == 0
    }

    /// Whether the bits ended before the samples did, or a place was outside the panel: the
    /// sender is wrong, not the link.
    #[must_use]
    pub fn malformed(&self) -> bool {
        self.malformed
    }

    fn sample(&mut self) -> Option<ScreenSample> {
        let gap = self.bits.rice(self.k, 32)?;
        self.key = self.key.checked_add(gap)?;
        let (x, y) = (gather(self.key), gather(self.key >> 1));
        let [right, bottom] = self.edge;
        if u32::from(x) >= right || u32::from(y) >= bottom {
            return None;
        }
        if self.first {
            self.first = false;
            self.rgb =
                [self.bits.bits(8)?, self.bits.bits(8)?, self.bits.bits(8)?].map(|c| c as u8);
        } else {
            self.rgb = self
                .colours
                .decode(&mut self.bits, distance(gap), self.rgb)?;
        }
        Some(ScreenSample {
            x,
            y,
            rgb: self.rgb,
        })
    }
}

impl Iterator for ScreenSamples<'_> {
    type Item = ScreenSample;

    fn next(&mut self) -> Option<ScreenSample> {
        let left = self.left.checked_sub(1)?;
        let sample = self.sample();
        self.malformed |= sample.is_none();
        self.left = if sample.is_some() { left } else { 0 };
        sample
    }
}

/// Length of a gap in bits.
fn distance(gap: u32) -> u32 {
    32 - gap.leading_zeros()
}

/// The even bits of a Morton number.
fn gather(key: u32) -> u16 {
    let v = key & 0x5555_5555;
    let v = (v | v >> 1) & 0x3333_3333;
    let v = (v | v >> 2) & 0x0f0f_0f0f;
    let v = (v | v >> 4) & 0x00ff_00ff;
    (v | v >> 8) as u16
}

fn spread(v: u16) -> u32 {
    let v = u32::from(v);
    let v = (v | v << 8) & 0x00ff_00ff;
    let v = (v | v << 4) & 0x0f0f_0f0f;
    let v = (v | v << 2) & 0x3333_3333;
    (v | v << 1) & 0x5555_5555
}

/// Writes the payload of up to [`MAX_SAMPLES`] samples; the buffer says whether they fitted.
pub(crate) fn put(b: &mut Buffer, time: Tick, samples: &[ScreenSample]) -> SampleBits {
    let mut keys = [u64::MAX; MAX_SAMPLES];
    for ((i, key), s) in (0..).zip(keys.iter_mut()).zip(samples) {
        *key = u64::from(spread(s.x) | spread(s.y) << 1) << 8 | i;
    }
    let keys = keys.get_mut(..samples.len()).unwrap_or_default();
    keys.sort_unstable();

    let mut steps = [(0u32, [0u8; 3]); MAX_SAMPLES];
    let mut histogram = Histogram::new();
    let mut last: Option<[u8; 3]> = None;
    let mut key = 0u32;
    for (step, &sorted) in steps.iter_mut().zip(keys.iter()) {
        let s = samples
            .get((sorted & 0xff) as usize)
            .copied()
            .unwrap_or_default();
        let now = (sorted >> 8) as u32;
        let gap = now.wrapping_sub(key);
        *step = match last {
            None => (gap, s.rgb),
            Some(last) => (gap, colour::residual(last, s.rgb)),
        };
        if last.is_some() {
            histogram.add(distance(gap).min(FAR), step.1);
        }
        (key, last) = (now, Some(s.rgb));
    }
    let steps = steps.get(..samples.len()).unwrap_or_default();
    let cost = |k: u32| -> u32 { steps.iter().map(|&(gap, _)| rice_len(gap, k, 32)).sum() };
    let k = (0..32).min_by_key(|&k| cost(k)).unwrap_or(0);
    let colours = histogram.best();

    b.u32(time.0);
    b.u8(samples.len().saturating_sub(1) as u8);
    let mut spent = SampleBits::default();
    let mut w = BitWriter::new(b);
    w.bits(k, 5);
    colours.put(&mut w, 0);
    spent.parameters += u64::from(w.total());
    for (i, &(gap, residual)) in steps.iter().enumerate() {
        let before = w.total();
        w.rice(gap, k, 32);
        spent.place += u64::from(w.total() - before);
        let before = w.total();
        if i == 0 {
            residual.into_iter().for_each(|c| w.bits(u32::from(c), 8));
        } else {
            colours.encode(&mut w, distance(gap), residual);
        }
        spent.colour += u64::from(w.total() - before);
    }
    w.finish();
    spent
}
