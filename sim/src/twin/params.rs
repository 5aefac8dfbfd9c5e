//! What is handed to the shaders, in their layout. `layout_tests.rs` compares every struct with
//! its twin in WGSL by naga's reflection.

use bytemuck::{Pod, Zeroable};
use unframed_recon::config::{Config, Extents, Lifetime, Light};
use unframed_recon::deep::Stored;
use unframed_recon::tiles::{Cell, cells_along};
use unframed_recon::{Arith, Fixed, Panel, transform};

/// The panel and its configuration, twin of `Params` in `common.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Params {
    pub(crate) width: i32,
    pub(crate) height: i32,
    pub(crate) extent_bits: u32,
    pub(crate) frac_bits: u32,
    pub(crate) columns: i32,
    pub(crate) rows: i32,
    pub(crate) now: u32,
    pub(crate) capacity: u32,
    pub(crate) lifetime: u32,
    pub(crate) lifetime_log: i32,
    pub(crate) extents: u32,
    pub(crate) width_log: i32,
    pub(crate) hidden: u32,
    pub(crate) encoded: u32,
    pub(crate) averages: u32,
    pub(crate) cutoff: u32,
}

impl Params {
    /// Of a display whose deep buffer holds `capacity` samples.
    pub(crate) fn new(config: &Config, panel: &Panel, capacity: u32) -> Params {
        let (lifetime, lifetime_log) = match config.lifetime {
            Lifetime::Constant(log) => (0, Fixed::log(log).into()),
            Lifetime::Tiles => (1, 0),
            Lifetime::Gradient => (2, 0),
        };
        let (extents, width_log) = match config.extents {
            Extents::Constant(log) => (0, Fixed::width(log.into()).into()),
            Extents::Density => (1, 0),
            Extents::Gradient => (2, 0),
            Extents::Pixel => (3, 0),
        };
        Params {
            width: panel.width.into(),
            height: panel.height.into(),
            extent_bits: panel.extent_bits.into(),
            frac_bits: panel.frac_bits.into(),
            // At most 4080/4.
            columns: cells_along(panel.width) as i32,
            rows: cells_along(panel.height) as i32,
            now: 0,
            capacity,
            lifetime,
            lifetime_log,
            extents,
            width_log,
            hidden: config.hidden.into(),
            encoded: (config.light == Light::Encoded).into(),
            averages: config.averages().into(),
            cutoff: config.cutoff.into(),
        }
    }
}

/// The new samples of a refresh in the ring, twin of `Fresh` in `average.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Fresh {
    /// Index of the first.
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) padding: [u32; 2],
}

/// View and pose composed, of one slot; twin of `Transform` in `fixed.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Transform {
    pub(crate) matrix: [i32; 9],
    pub(crate) exponent: i32,
    /// Low and high half of each.
    pub(crate) offset: [[u32; 2]; 3],
    pub(crate) known: u32,
    pub(crate) padding: u32,
}

impl From<transform::Transform> for Transform {
    fn from(from: transform::Transform) -> Transform {
        let [a, b, c] = from.matrix;
        Transform {
            matrix: [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]],
            exponent: from.exponent,
            offset: from.offset.map(|v| [v as u32, (v >> 32) as u32]),
            known: 1,
            padding: 0,
        }
    }
}

/// Two neighbouring levels of a pyramid, twin of `Level` in `level.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Level {
    pub(crate) fine_first: u32,
    pub(crate) fine_columns: u32,
    pub(crate) fine_rows: u32,
    pub(crate) coarse_first: u32,
    pub(crate) coarse_columns: u32,
    pub(crate) coarse_rows: u32,
    /// Fine cells along a coarse one.
    pub(crate) side: u32,
    /// Index of the coarsest of all.
    pub(crate) top: u32,
}

/// A stored sample as the words that its 16 bytes are.
pub(crate) fn stored(sample: &Stored) -> [u32; 4] {
    let [x, y, z] = sample.place.map(|v| u32::from(v as u16));
    let [r, g, b] = sample.rgb.map(u32::from);
    let (slot, placing) = (u32::from(sample.slot), sample.placing as u32);
    [
        sample.time,
        x | y << 16,
        z | r << 16 | g << 24,
        b | slot << 8 | placing << 16 | u32::from(sample.shares.0) << 24,
    ]
}

/// A cell of the tile map in two words: gx, gy, gt, lifetime; density.
pub(crate) fn cell(cell: &Cell) -> [u32; 2] {
    let bytes = [cell.gx.0, cell.gy.0, cell.gt.0, cell.lifetime.0];
    [u32::from_le_bytes(bytes), u32::from(cell.density.0)]
}
