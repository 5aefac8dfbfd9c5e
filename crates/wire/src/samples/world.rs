//! World layout: runs of objects; within a run, places in Z-order by shared prefix.
//!
//! The place of a sample, `u = q XOR 0x8000` in each axis, is the 48-bit Morton number
//! `Σ_i Σ_c bit_i(u_c) 2^(3i+c)`. Sorted, a sample shares a prefix with the one before, then has a
//! one where that had a zero, then `suffix − 1` bits of its own. Those are sent axis by axis, so a
//! decoder never interleaves anything. Where samples lie in a plane of the lattice (walls, floors)
//! the bits of that axis repeat; a mode leaves them out.

use super::colour::{self, FAR, Histogram, Parameters, SHARE_WIDTH};
use super::{MAX_SAMPLES, SURE_SAMPLES};
use crate::bits::{BitReader, BitWriter, fold, rice_len, unfold};
use crate::bytes::{Buffer, Cursor};
use crate::ledger::SampleBits;
use crate::repr::*;

/// Bits of a Morton number.
const TOP: u32 = 48;

/// Width of an escaped suffix code: |centre − suffix| ≤ 63, folded.
const SUFFIX_WIDTH: u32 = 7;

/// The mode in which every axis is sent; 0, 1, 2 leave out x, y, z.
const ALL: u32 = 3;

/// Bits of axis `c` among the lowest `n` bits of a Morton number.
const fn axis_bits(n: u32, c: u32) -> u32 {
    (n + 2 - c) / 3
}

/// Samples of one instant with lattice places; an iterator over them.
#[derive(Clone, Debug)]
pub struct WorldSamples<'a> {
    time: Tick,
    left: u16,
    runs: Cursor<'a>,
    run_left: u16,
    first: bool,
    flat: bool,
    centre: u32,
    k: u32,
    colours: Parameters,
    mode: u32,
    lamps: u8,
    /// Offset-binary place, colour, shares and object of the sample before.
    place: [u16; 3],
    rgb: [u8; 3],
    shares: Shares,
    object: u8,
    bits: BitReader<'a>,
    malformed: bool,
}

impl<'a> WorldSamples<'a> {
    /// `None` if the runs do not add up to 1..=[`MAX_SAMPLES`], or if they name objects where the
    /// stream has none. Of `lamps` lamps samples tell the shares.
    pub(crate) fn parse(payload: &'a [u8], objects: bool, lamps: u8) -> Option<Self> {
        let mut c = Cursor(payload);
        let time = Tick(c.u32()?);
        let count = usize::from(c.u8()?) + 1;
        let runs = c.slice(2 * count)?;
        let mut left = 0u16;
        for run in runs.chunks_exact(2) {
            let &[object, length] = run else { return None };
            left = left.saturating_add(u16::from(length) + 1);
            if !objects && object != 0 {
                return None;
            }
        }
        if usize::from(left) > MAX_SAMPLES {
            return None;
        }
        let mut bits = BitReader::new(c.0);
        let flat = bits.flag()?;
        let centre = bits.bits(6)?;
        let k = bits.bits(3)?;
        let colours = Parameters::get(&mut bits, lamps)?;
        Some(WorldSamples {
            time,
            left,
            runs: Cursor(runs),
            run_left: 0,
            first: true,
            flat,
            centre,
            k,
            colours,
            mode: ALL,
            lamps,
            place: [0; 3],
            rgb: [0; 3],
            shares: Shares::default(),
            object: 0,
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

    /// Whether the bits ended before the samples did: the sender is wrong, not the link.
    #[must_use]
    pub fn malformed(&self) -> bool {
        self.malformed
    }

    fn start_run(&mut self) -> Option<()> {
        self.object = self.runs.u8()?;
        self.run_left = u16::from(self.runs.u8()?) + 1;
        self.mode = ALL;
        for u in &mut self.place {
            *u = self.bits.bits(16)? as u16;
        }
        Some(())
    }

    /// Moves the place on; the distance in bits to the one before.
    fn step(&mut self) -> Option<u32> {
        let d = unfold(self.bits.rice(self.k, SUFFIX_WIDTH)?);
        let suffix = u32::try_from(self.centre as i32 - d)
            .ok()
            .filter(|&s| s <= TOP)?;
        let Some(low) = suffix.checked_sub(1) else {
            return Some(0);
        };
        if self.flat && !self.bits.flag()? {
            self.mode = self.bits.bits(2)?;
        }
        for (c, u) in (0..).zip(&mut self.place) {
            let n = axis_bits(low, c);
            if c != self.mode {
                let own = self.bits.bits(n)?;
                *u = ((u32::from(*u) >> n << n) | own) as u16;
            }
            if low % 3 == c {
                *u |= 1 << (low / 3);
            }
        }
        Some(suffix)
    }

    fn sample(&mut self) -> Option<WorldSample> {
        let distance = if self.run_left == 0 {
            self.start_run()?;
            FAR
        } else {
            self.step()?
        };
        if self.first {
            self.first = false;
            self.rgb =
                [self.bits.bits(8)?, self.bits.bits(8)?, self.bits.bits(8)?].map(|c| c as u8);
            let mut codes = [0; LAMPS];
            for code in codes.iter_mut().take(usize::from(self.lamps)) {
                *code = self.bits.bits(SHARE_WIDTH)? as u8;
            }
            self.shares = Shares::new(codes);
        } else {
            let bits = &mut self.bits;
            self.rgb = self.colours.decode(bits, distance, self.rgb)?;
            if self.lamps > 0 {
                let (lamps, last) = (self.lamps, self.shares);
                self.shares = self.colours.decode_shares(bits, distance, lamps, last)?;
            }
        }
        self.run_left -= 1;
        let place = self.place.map(|u| (u ^ 0x8000) as i16);
        Some(WorldSample {
            place,
            rgb: self.rgb,
            object: self.object,
            shares: self.shares,
        })
    }
}

impl Iterator for WorldSamples<'_> {
    type Item = WorldSample;

    fn next(&mut self) -> Option<WorldSample> {
        let left = self.left.checked_sub(1)?;
        let sample = self.sample();
        self.malformed |= sample.is_none();
        self.left = if sample.is_some() { left } else { 0 };
        sample
    }
}

fn spread(v: u16) -> u64 {
    // Each line halves the groups of neighbouring bits.
    let v = u64::from(v);
    let v = (v | v << 16) & 0x0000_ff00_00ff;
    let v = (v | v << 8) & 0x00f0_0f00_f00f;
    let v = (v | v << 4) & 0x0c30_c30c_30c3;
    (v | v << 2) & 0x2492_4924_9249
}

fn morton(place: [i16; 3]) -> u64 {
    let [x, y, z] = place.map(|q| spread(q as u16 ^ 0x8000));
    x | y << 1 | z << 2
}

/// What one sample needs, gathered before the parameters are chosen.
#[derive(Clone, Copy, Default)]
struct Step {
    place: [u16; 3],
    suffix: u32,
    residual: [u8; 3],
    shares: [u8; LAMPS],
    object: u8,
    starts: bool,
    /// Axes whose low bits are those of the sample before.
    still: [bool; 3],
}

impl Step {
    /// Differences of the codes of the lamps that the stream has; the codes themselves of the
    /// first sample.
    fn shares(&self, lamps: u8) -> &[u8] {
        self.shares.get(..usize::from(lamps)).unwrap_or_default()
    }
}

/// The mode for a step after `mode`: keeps it while it holds, else leaves out the longest axis
/// that does not move, if that saves more than naming it costs.
fn next_mode(mode: u32, step: &Step) -> u32 {
    let low = step.suffix.saturating_sub(1);
    let mut best = (if mode == ALL { 2 } else { 0 }, ALL);
    for (c, still) in (0..).zip(step.still) {
        if still && c == mode {
            return mode;
        }
        let saved = axis_bits(low, c);
        if still && saved > best.0 {
            best = (saved, c);
        }
    }
    best.1
}

/// Bits of the modes and places of `steps`, with modes or without.
fn place_bits(steps: &[Step], flat: bool) -> u32 {
    let mut mode = ALL;
    let mut bits = 0;
    for step in steps {
        if step.starts {
            mode = ALL;
        } else if let Some(low) = step.suffix.checked_sub(1) {
            bits += low;
            if flat {
                let next = next_mode(mode, step);
                bits += if next == mode { 1 } else { 3 };
                bits -= if next == ALL { 0 } else { axis_bits(low, next) };
                mode = next;
            }
        }
    }
    bits
}

/// Centre and Rice parameter that code the suffixes shortest.
fn suffix_parameters(steps: &[Step]) -> (u32, u32) {
    let mut counts = [0u32; TOP as usize + 1];
    for step in steps.iter().filter(|s| !s.starts) {
        if let Some(count) = counts.get_mut(step.suffix as usize) {
            *count += 1;
        }
    }
    let cost = |centre: u32, k: u32| -> u32 {
        let of = |s: u32| rice_len(fold(centre as i32 - s as i32), k, SUFFIX_WIDTH);
        (0..)
            .zip(counts)
            .filter(|&(_, n)| n > 0)
            .map(|(s, n)| n * of(s))
            .sum()
    };
    let all = (0..=TOP).flat_map(|centre| (0..6).map(move |k| (centre, k)));
    all.min_by_key(|&(centre, k)| cost(centre, k))
        .unwrap_or_default()
}

/// Writes the payload of up to [`MAX_SAMPLES`] samples; the buffer says whether they fitted, and
/// [`SURE_SAMPLES`] do. Of `lamps` lamps they tell the shares.
pub(crate) fn put(b: &mut Buffer, time: Tick, samples: &[WorldSample], lamps: u8) -> SampleBits {
    debug_assert!(SURE_SAMPLES <= MAX_SAMPLES && samples.len() <= MAX_SAMPLES);
    // Object, Morton number, index: sorting the keys sorts the samples, ties in their order.
    let mut keys = [u64::MAX; MAX_SAMPLES];
    for ((i, key), s) in (0..).zip(keys.iter_mut()).zip(samples) {
        *key = u64::from(s.object) << 56 | morton(s.place) << 8 | i;
    }
    let keys = keys.get_mut(..samples.len()).unwrap_or_default();
    keys.sort_unstable();

    let mut steps = [Step::default(); MAX_SAMPLES];
    let mut histogram = Histogram::new();
    let mut last: Option<(u64, WorldSample)> = None;
    let mut runs = 0usize;
    for (step, &key) in steps.iter_mut().zip(keys.iter()) {
        let s = samples
            .get((key & 0xff) as usize)
            .copied()
            .unwrap_or_default();
        step.place = s.place.map(|q| q as u16 ^ 0x8000);
        step.object = s.object;
        let before = last.filter(|(_, l)| l.object == s.object);
        step.starts = before.is_none();
        let mut distance = FAR;
        if let Some((last_key, l)) = before {
            step.suffix = 64 - ((key ^ last_key) >> 8).leading_zeros();
            distance = step.suffix;
            let low = step.suffix.saturating_sub(1);
            for c in 0..3 {
                let differs = (s.place[c] ^ l.place[c]) as u16;
                let n = axis_bits(low, c as u32);
                step.still[c] = u32::from(differs) & ((1 << n) - 1) == 0;
            }
        } else {
            runs += 1;
        }
        if let Some((_, l)) = last {
            step.residual = colour::residual(l.rgb, s.rgb);
            histogram.add(distance, step.residual);
            step.shares = colour::share_residual(l.shares, s.shares);
            histogram.add_shares(distance, step.shares(lamps));
        } else {
            step.residual = s.rgb;
            step.shares = core::array::from_fn(|lamp| s.shares.code(lamp));
        }
        last = Some((key, s));
    }
    let steps = steps.get(..samples.len()).unwrap_or_default();

    b.u32(time.0);
    b.u8(runs.saturating_sub(1) as u8);
    for run in steps.chunk_by(|a, b| a.object == b.object) {
        b.u8(run.first().map_or(0, |s| s.object));
        b.u8((run.len() - 1) as u8);
    }
    write(b, steps, histogram.best(), runs, lamps)
}

fn write(
    b: &mut Buffer,
    steps: &[Step],
    colours: Parameters,
    runs: usize,
    lamps: u8,
) -> SampleBits {
    let flat = place_bits(steps, true) < place_bits(steps, false);
    let (centre, k) = suffix_parameters(steps);
    let mut spent = SampleBits {
        object: 8 + 16 * runs as u64,
        ..SampleBits::default()
    };
    let mut w = BitWriter::new(b);
    w.bits(u32::from(flat), 1);
    w.bits(centre, 6);
    w.bits(k, 3);
    colours.put(&mut w, lamps);
    spent.parameters += u64::from(w.total());
    let mut mode = ALL;
    for (i, step) in steps.iter().enumerate() {
        let before = w.total();
        let distance = if step.starts {
            mode = ALL;
            step.place
                .into_iter()
                .for_each(|u| w.bits(u32::from(u), 16));
            FAR
        } else {
            w.rice(fold(centre as i32 - step.suffix as i32), k, SUFFIX_WIDTH);
            if let Some(low) = step.suffix.checked_sub(1) {
                if flat {
                    let next = next_mode(mode, step);
                    w.bits(u32::from(next == mode), 1);
                    if next != mode {
                        w.bits(next, 2);
                    }
                    mode = next;
                }
                for (c, u) in (0..).zip(step.place).filter(|&(c, _)| c != mode) {
                    w.bits(u32::from(u), axis_bits(low, c));
                }
            }
            step.suffix
        };
        spent.place += u64::from(w.total() - before);
        let before = w.total();
        if i == 0 {
            step.residual
                .into_iter()
                .for_each(|c| w.bits(u32::from(c), 8));
        } else {
            colours.encode(&mut w, distance, step.residual);
        }
        spent.colour += u64::from(w.total() - before);
        let before = w.total();
        let shares = step.shares(lamps);
        if i == 0 {
            shares
                .iter()
                .for_each(|&c| w.bits(u32::from(c), SHARE_WIDTH));
        } else {
            colours.encode_shares(&mut w, distance, shares);
        }
        spent.shares += u64::from(w.total() - before);
    }
    w.finish();
    spent
}
