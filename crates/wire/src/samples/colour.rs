//! Colours against the sample before: green, then red and blue less green's change.
//!
//! The differences are modulo 256, so the transform is reversible in bytes. Measured on textured
//! rooms it costs 19.3 bits a sample, plain RGB differences 21.9, YCoCg-R 19.2: not worth its
//! shifts. Each packet carries Rice parameters for two cases, because neighbours in the sorted
//! order are either members of one cluster (a crosshair) or strangers: samples whose place is less
//! than `threshold` bits from the one before are near. That saves 3 bits a sample with crosshairs.

use crate::bits::{BitReader, BitWriter, fold, rice_len, unfold};

/// Largest Rice parameter, in 3 bits.
const MAX_K: u32 = 7;

/// Distances are below this; it is also the distance of a sample that has no neighbour.
pub(super) const FAR: u32 = 63;

/// Rice parameters of a packet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parameters {
    /// Distances below this are near, 0..=63.
    threshold: u32,
    near: [u32; 3],
    far: [u32; 3],
}

impl Parameters {
    pub(super) fn get(bits: &mut BitReader<'_>) -> Option<Self> {
        let threshold = bits.bits(6)?;
        let near = [bits.bits(3)?, bits.bits(3)?, bits.bits(3)?];
        let far = [bits.bits(3)?, bits.bits(3)?, bits.bits(3)?];
        Some(Parameters {
            threshold,
            near,
            far,
        })
    }

    pub(super) fn put(&self, w: &mut BitWriter<'_>) {
        w.bits(self.threshold, 6);
        self.near
            .into_iter()
            .chain(self.far)
            .for_each(|k| w.bits(k, 3));
    }

    fn of(&self, distance: u32) -> [u32; 3] {
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
        let [kg, kr, kb] = self.of(distance);
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
}

/// Folded differences of green, red and blue.
pub(super) fn residual(last: [u8; 3], now: [u8; 3]) -> [u8; 3] {
    let [r, g, b] = [0, 1, 2].map(|c: usize| now[c].wrapping_sub(last[c]));
    [g, r.wrapping_sub(g), b.wrapping_sub(g)].map(|d| fold(i32::from(d as i8)) as u8)
}

type Costs = [[u32; MAX_K as usize + 1]; 3];

/// What each parameter would cost, by distance.
pub(super) struct Histogram([Costs; FAR as usize + 1]);

impl Histogram {
    pub(super) fn new() -> Self {
        Histogram([[[0; MAX_K as usize + 1]; 3]; FAR as usize + 1])
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

    /// The threshold and the parameters that make the packet shortest.
    pub(super) fn best(&self) -> Parameters {
        let mut far = [[0; MAX_K as usize + 1]; 3];
        self.0
            .iter()
            .for_each(|costs| accumulate(&mut far, costs, u32::wrapping_add));
        let mut near = [[0; MAX_K as usize + 1]; 3];
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

fn cheapest(costs: &Costs) -> ([u32; 3], u32) {
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
