//! The buffers of a display on the adapter, and the levels of its pyramids.

use super::light::WORDS as LIGHT;
use super::params::{Level, Params, Transform};
use super::stages::{BLOCK, varies};
use super::tables::Tables;
use crate::gpu::{Gpu, GpuError};
use crate::pass::Words;
use unframed_recon::Panel;
use unframed_recon::arith::GUARD;
use unframed_recon::config::{Config, Extents, Fit, Mode};
use unframed_recon::fill::pyramid_len;
use unframed_recon::hidden::{CELLS, minima_len};
use unframed_recon::light;
use unframed_recon::motion::BUCKETS;

/// Samples that may wait for their upload.
pub(crate) const PENDING: usize = 1 << 16;

/// Words of one entry of each buffer.
pub(crate) const STORED: usize = 4;
pub(crate) const PROJECTED: usize = 3;
pub(crate) const SUMS: usize = 8;
pub(crate) const MOMENTS: usize = 22;
pub(crate) const TEXEL: usize = 2;
pub(crate) const MEAN: usize = 4;

/// A level's place in its pyramid, and the uniform that tells a stage.
#[derive(Debug)]
pub(crate) struct Step {
    pub(crate) level: Level,
    pub(crate) uniform: Words,
}

impl Step {
    pub(crate) fn fine(&self) -> usize {
        self.level.fine_columns as usize * self.level.fine_rows as usize
    }

    pub(crate) fn coarse(&self) -> usize {
        self.level.coarse_columns as usize * self.level.coarse_rows as usize
    }
}

/// All buffers. Those that a configuration does not call for hold one entry, as WebGPU has no
/// empty bindings.
#[derive(Debug)]
pub(crate) struct Memory {
    pub(crate) params: Words,
    pub(crate) tables: Words,
    pub(crate) transforms: Words,
    pub(crate) cells: Words,
    /// Next, length, placed, unplaced.
    pub(crate) ring: Words,
    pub(crate) samples: Words,
    pub(crate) projected: Words,
    pub(crate) minima: Words,
    pub(crate) minima_steps: Vec<Step>,
    pub(crate) limits: Words,
    pub(crate) movers: Words,
    /// Depths of reach: 2 words a bucket of ages.
    pub(crate) reach: Words,
    /// The number of bins, as a uniform.
    pub(crate) bins: Words,
    pub(crate) counts: Words,
    pub(crate) starts: Words,
    pub(crate) blocks: Words,
    pub(crate) sorted: Words,
    pub(crate) mass: Words,
    pub(crate) widths: Words,
    pub(crate) footprints: Words,
    pub(crate) reaches: Words,
    pub(crate) rows: Words,
    pub(crate) sums: Words,
    pub(crate) moments: Words,
    pub(crate) longest: Words,
    /// The round of gathering, as a uniform.
    pub(crate) round: Words,
    pub(crate) texels: Words,
    pub(crate) texel_steps: Vec<Step>,
    pub(crate) picture: Words,
    /// 4 words a pixel.
    pub(crate) means: Words,
    /// Which samples are new, as a uniform.
    pub(crate) fresh: Words,
    /// Lamps and what stands before them: [`LIGHT`] words, then the texels of the shadow maps.
    pub(crate) light: Words,
    /// How many samples just arrived, as a uniform.
    pub(crate) arrived: Words,
    pub(crate) pending: Words,
    pub(crate) placed: Words,
    pub(crate) ranks: Words,
    pub(crate) claims: Words,
}

/// Bins of the counting sort: the panel's pixels and the guard band's.
pub(crate) fn bins(panel: &Panel) -> usize {
    let guard = 2 * GUARD as usize;
    (usize::from(panel.width) + guard) * (usize::from(panel.height) + guard)
}

impl Memory {
    pub(crate) fn new(
        gpu: &Gpu,
        config: &Config,
        panel: &Panel,
        params: &Params,
        tables: &Tables,
    ) -> Result<Memory, GpuError> {
        let filters = config.mode == Mode::SpaceTime;
        let arrives = !filters || !config.reproject;
        // An entry at least where something is not called for.
        let of = |name: &str, called_for: bool, entries: usize, words: usize| {
            let entries = if called_for { entries.max(1) } else { 1 };
            Words::zeroed(gpu, name, entries * words)
        };
        let pixels = panel.pixels();
        let samples = params.capacity as usize;
        let hidden = filters && config.hidden;
        let density = filters && config.extents == Extents::Density;
        let varying = filters && varies(config.extents);
        let planes = filters && config.fit == Fit::Linear;
        let bins = if filters { bins(panel) } else { 1 };
        let items = bins.max(PENDING);
        let minima = minima_len(panel.width, panel.height);
        let texels = pixels + pyramid_len(panel.width, panel.height);
        Ok(Memory {
            params: Words::upload(gpu, "params", bytemuck::cast_slice(&[*params]))?,
            tables: Words::upload(gpu, "tables", bytemuck::cast_slice(&[*tables]))?,
            transforms: of("transforms", true, 256, size_of::<Transform>() / 4)?,
            cells: of("cells", true, (params.columns * params.rows) as usize, 2)?,
            ring: of("ring", true, 4, 1)?,
            samples: of("samples", filters, samples, STORED)?,
            projected: of("projected", filters, samples, PROJECTED)?,
            minima: of("minima", hidden, minima, 1)?,
            minima_steps: steps(gpu, minima_levels(panel))?,
            limits: of("limits", hidden, pixels, 1)?,
            movers: of("movers", hidden, pixels, 1)?,
            reach: of("reach", true, BUCKETS, 2)?,
            bins: Words::upload(gpu, "bins", &[bins as u32, 0, 0, 0])?,
            counts: of("counts", filters, bins, 1)?,
            starts: of("starts", filters, bins + 1, 1)?,
            blocks: of("blocks", true, items.div_ceil(BLOCK as usize), 1)?,
            sorted: of("sorted", filters, samples, 4)?,
            mass: of("mass", density, pixels, 2)?,
            widths: of("widths", density, pixels, 2)?,
            footprints: of("footprints", varying, samples, 2)?,
            reaches: of("reaches", varying, bins, 1)?,
            rows: of("rows", varying, bins, 1)?,
            sums: of("sums", filters, pixels, SUMS)?,
            moments: of("moments", planes, pixels, MOMENTS)?,
            longest: of("longest", true, 1, 1)?,
            round: of("round", true, 4, 1)?,
            texels: of("texels", filters, texels, TEXEL)?,
            texel_steps: steps(gpu, texel_levels(panel))?,
            picture: of("picture", true, pixels, 1)?,
            means: of("means", config.averages(), pixels, MEAN)?,
            fresh: of("fresh", true, 4, 1)?,
            light: of("light", filters, LIGHT + light::TEXELS.div_ceil(2), 1)?,
            arrived: of("arrived", true, 4, 1)?,
            pending: of("pending", arrives, PENDING, STORED)?,
            placed: of("placed", arrives, PENDING, 1)?,
            ranks: of("ranks", arrives, PENDING + 1, 1)?,
            claims: of("claims", !filters, pixels, 1)?,
        })
    }
}

fn steps(gpu: &Gpu, levels: Vec<Level>) -> Result<Vec<Step>, GpuError> {
    let step = |level| {
        let uniform = Words::upload(gpu, "level", bytemuck::cast_slice(&[level]))?;
        Ok(Step { level, uniform })
    };
    levels.into_iter().map(step).collect()
}

/// From the pixels' minima to those of 2 pixels, and from them to those of 4.
fn minima_levels(panel: &Panel) -> Vec<Level> {
    let size = |side: usize| {
        [panel.width, panel.height].map(|pixels| u32::from(pixels).div_ceil(side as u32))
    };
    let mut levels: Vec<Level> = Vec::new();
    let mut first = 0;
    for pair in CELLS.windows(2) {
        let (fine, coarse) = (size(pair[0]), size(pair[1]));
        let coarse_first = first + fine[0] * fine[1];
        levels.push(Level {
            fine_first: first,
            fine_columns: fine[0],
            fine_rows: fine[1],
            coarse_first,
            coarse_columns: coarse[0],
            coarse_rows: coarse[1],
            side: (pair[1] / pair[0]) as u32,
            top: 0,
        });
        first = coarse_first;
    }
    levels
}

/// From the picture to one texel.
fn texel_levels(panel: &Panel) -> Vec<Level> {
    let mut levels = Vec::new();
    let (mut first, mut fine) = (0, [panel.width, panel.height].map(u32::from));
    while fine[0] > 1 || fine[1] > 1 {
        let coarse = fine.map(|v| v.div_ceil(2));
        levels.push(Level {
            fine_first: first,
            fine_columns: fine[0],
            fine_rows: fine[1],
            coarse_first: first + fine[0] * fine[1],
            coarse_columns: coarse[0],
            coarse_rows: coarse[1],
            side: 2,
            top: 0,
        });
        first += fine[0] * fine[1];
        fine = coarse;
    }
    for level in &mut levels {
        level.top = first;
    }
    levels
}
