//! Colours and shares of lamps against the sample before: green, then red and blue less green's
//! change, then what each lamp brings.
//!
//! The differences are modulo 256, so the transform is reversible in bytes. Measured on textured
//! rooms it costs 19.3 bits a sample, plain RGB differences 21.9, YCoCg-R 19.2: not worth its
//! shifts. Each packet carries Rice parameters for two cases, because neighbours in the sorted
//! order are either members of one cluster (a crosshair) or strangers: samples whose place is less
//! than `threshold` bits from the one before are near. That saves 3 bits a sample with crosshairs.

use crate::bits::{BitReader, BitWriter, fold, rice_len, unfold};
use crate::repr::{LAMPS, Shares};

/// Largest Rice parameter, in 3 bits.
const MAX_K: u32 = 7;

/// Distances are below this; it is also the distance of a sample that has no neighbour.
pub(super) const FAR: u32 = 63;

/// Bits of a code in [`Shares`]: of a plain one, and of an escaped difference.
pub(super) const SHARE_WIDTH: u32 = 4;

/// What has a Rice parameter of its own: green, red, blue, and the shares of all lamps.
const CHANNELS: usize = 4;

/// Rice parameters of a packet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parameters {
    /// Distances below this are near, 0..=63.
    threshold: u32,
    near: [u32; CHANNELS],
    far: [u32; CHANNELS],
}

impl Parameters {
    /// Those of shares are there if the stream has `lamps`.
    pub(super) fn get(bits: &mut BitReader<'_>, lamps: u8) -> Option<Self> {
        let threshold = bits.bits(6)?;
        let mut near = [bits.bits(3)?, bits.bits(3)?, bits.bits(3)?, 0];
        let mut far = [bits.bits(3)?, bits.bits(3)?, bits.bits(3)?, 0];
        if lamps > 0 {
            (near[3], far[3]) = (bits.bits(3)?, bits.bits(3)?);
        }
        Some(Parameters {
            threshold,
            near,
            far,
        })
    }

    pub(super) fn put(&self, w: &mut BitWriter<'_>, lamps: u8) {
        w.bits(self.threshold, 6);
        let ([near @ .., near_share], [far @ .., far_share]) = (self.near, self.far);
        near.into_iter().chain(far).for_each(|k| w.bits(k, 3));
        if lamps > 0 {
            w.bits(near_share, 3);
            w.bits(far_share, 3);
        }
    }

    fn of(&self, distance: u32) -> [u32; CHANNELS] {
        if distance < self.threshold {
            self.near
        } else {
            self.far
        }
    }

    /// The colour after `last`, at `distance` bits from it.
    pub(super) fn decode(
        &self,
        bits: &mut BitReader<'_>,
        distance: u32,
        last: [u8; 3],
    ) -> Option<[u8; 3]> {
        let [kg, kr, kb, _] = self.of(distance);
        let g = unfold(bits.rice(kg, 8)?) as u8;
        let r = unfold(bits.rice(kr, 8)?) as u8;
        let b = unfold(bits.rice(kb, 8)?) as u8;
        let [last_r, last_g, last_b] = last;
        Some([
            last_r.wrapping_add(g).wrapping_add(r),
            last_g.wrapping_add(g),
            last_b.wrapping_add(g).wrapping_add(b),
        ])
    }

    pub(super) fn encode(&self, w: &mut BitWriter<'_>, distance: u32, residual: [u8; 3]) {
        for (k, u) in self.of(distance).into_iter().zip(residual) {
            w.rice(u32::from(u), k, 8);
        }
    }

    /// The shares of `lamps` lamps after `last`, at `distance` bits from it.
    pub(super) fn decode_shares(
        &self,
        bits: &mut BitReader<'_>,
        distance: u32,
        lamps: u8,
        last: Shares,
    ) -> Option<Shares> {
        let [.., k] = self.of(distance);
        let mut codes = [0; LAMPS];
        for (lamp, code) in codes.iter_mut().enumerate().take(usize::from(lamps)) {
            let d = unfold(bits.rice(k, SHARE_WIDTH)?) as u8;
            // `Shares::new` takes it modulo 16.
            *code = last.code(lamp).wrapping_add(d);
        }
        Some(Shares::new(codes))
    }

    pub(super) fn encode_shares(&self, w: &mut BitWriter<'_>, distance: u32, residual: &[u8]) {
        let [.., k] = self.of(distance);
        residual
            .iter()
            .for_each(|&u| w.rice(u32::from(u), k, SHARE_WIDTH));
    }
}

/// Folded differences of green, red and blue.
pub(super) fn residual(last: [u8; 3], now: [u8; 3]) -> [u8; 3] {
    let [r, g, b] = [0, 1, 2].map(|c: usize| now[c].wrapping_sub(last[c]));
    [g, r.wrapping_sub(g), b.wrapping_sub(g)].map(|d| fold(i32::from(d as i8)) as u8)
}

/// Folded differences of the codes of all lamps, modulo 16.
pub(super) fn share_residual(last: Shares, now: Shares) -> [u8; LAMPS] {
    core::array::from_fn(|lamp| {
        let d = now.code(lamp).wrapping_sub(last.code(lamp));
        // The low 4 bits with their sign.
        fold(i32::from((d << 4) as i8 >> 4)) as u8
    })
}

type Costs = [[u32; MAX_K as usize + 1]; CHANNELS];

/// What each parameter would cost, by distance.
pub(super) struct Histogram([Costs; FAR as usize + 1]);

impl Histogram {
    pub(super) fn new() -> Self {
        Histogram([[[0; MAX_K as usize + 1]; CHANNELS]; FAR as usize + 1])
    }

    pub(super) fn add(&mut self, distance: u32, residual: [u8; 3]) {
        let Some(costs) = self.0.get_mut(distance as usize) else {
            return;
        };
        for (costs, u) in costs.iter_mut().zip(residual) {
            for (k, cost) in (0..).zip(costs.iter_mut()) {
                *cost += rice_len(u32::from(u), k, 8);
            }
        }
    }

    /// Counts the shares of the lamps that the stream has.
    pub(super) fn add_shares(&mut self, distance: u32, residual: &[u8]) {
        let Some([.., costs]) = self.0.get_mut(distance as usize) else {
            return;
        };
        for (k, cost) in (0..).zip(costs.iter_mut()) {
            let of = |&u: &u8| rice_len(u32::from(u), k, SHARE_WIDTH);
            *cost += residual.iter().map(of).sum::<u32>();
        }
    }

    /// The threshold and the parameters that make the packet shortest.
    pub(super) fn best(&self) -> Parameters {
        let mut far = [[0; MAX_K as usize + 1]; CHANNELS];
        self.0
            .iter()
            .for_each(|costs| accumulate(&mut far, costs, u32::wrapping_add));
        let mut near = [[0; MAX_K as usize + 1]; CHANNELS];
        let mut best = (u32::MAX, Parameters::default());
        for (threshold, costs) in (0..).zip(&self.0) {
            let (near_k, near_bits) = cheapest(&near);
            let (far_k, far_bits) = cheapest(&far);
            if near_bits + far_bits < best.0 {
                best = (
                    near_bits + far_bits,
                    Parameters {
                        threshold,
                        near: near_k,
                        far: far_k,
                    },
                );
            }
            accumulate(&mut near, costs, u32::wrapping_add);
            accumulate(&mut far, costs, u32::wrapping_sub);
        }
        best.1
    }
}

fn accumulate(sum: &mut Costs, costs: &Costs, op: fn(u32, u32) -> u32) {
    for (sum, cost) in sum.as_flattened_mut().iter_mut().zip(costs.as_flattened()) {
        *sum = op(*sum, *cost);
    }
}

fn cheapest(costs: &Costs) -> ([u32; CHANNELS], u32) {
    let best = costs.map(|c| {
        (0..)
            .zip(c)
            .min_by_key(|&(_, bits)| bits)
            .unwrap_or_default()
    });
    (
        best.map(|(k, _)| k),
        best.iter().map(|&(_, bits)| bits).sum(),
    )
}
