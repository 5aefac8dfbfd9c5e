//! A refresh as a list of stages. Twin of `unframed_recon::Display::refresh`.

use super::memory::Memory;
use super::stages::{BLOCK, Density, Fill, GROUP, Hidden, Refreshing, Rest, Scan, Varying};
use crate::gpu::GpuError;
use crate::pass::{Batch, Stage, Words, linear_grid};

/// Stages that go into a batch, each behind parameters and tables.
struct Recorder<'r, 'g> {
    batch: &'r mut Batch<'g>,
    memory: &'r Memory,
}

impl Recorder<'_, '_> {
    /// One invocation an item.
    fn run(&mut self, stage: &Stage, buffers: &[&Words], items: usize) -> Result<(), GpuError> {
        let first = [&self.memory.params, &self.memory.tables];
        let all: Vec<&Words> = first.iter().chain(buffers).copied().collect();
        self.batch.run(stage, &all, linear_grid(items, GROUP))
    }
}

/// Appends what brings `len` samples to an instant and in order.
pub(super) fn arrange(
    batch: &mut Batch<'_>,
    stages: &Refreshing,
    scan: &Scan,
    memory: &Memory,
    len: usize,
) -> Result<(), GpuError> {
    let m = memory;
    let pixels = m.picture.len();
    let mut recorder = Recorder { batch, memory };
    let r = &mut recorder;
    let buffers = [&m.ring, &m.samples, &m.transforms, &m.cells, &m.projected];
    r.run(&stages.project, &buffers, len)?;
    if let Some(hidden) = &stages.hidden {
        limits(r, hidden, len, pixels)?;
    }
    let buffers = [
        &m.ring,
        &m.projected,
        &m.limits,
        &m.samples,
        &m.movers,
        &m.reach,
        &m.counts,
    ];
    r.run(&stages.drop_hidden, &buffers, len)?;
    let sum = [
        &m.params, &m.tables, &m.bins, &m.counts, &m.starts, &m.blocks,
    ];
    prefix_sum(r.batch, scan, sum, m.counts.len())?;
    let buffers = [
        &m.ring,
        &m.samples,
        &m.projected,
        &m.starts,
        &m.counts,
        &m.sorted,
        &m.light,
    ];
    r.run(&stages.sort, &buffers, len)?;
    if let Some(Density { masses, widths }) = &stages.density {
        r.batch.clear(&m.mass);
        r.run(masses, &[&m.ring, &m.projected, &m.mass], len)?;
        r.run(widths, &[&m.mass, &m.widths], pixels)?;
    }
    if let Some(Varying { footprints, rows }) = &stages.varying {
        r.batch.clear(&m.reaches);
        let buffers = [&m.starts, &m.sorted, &m.widths, &m.footprints, &m.reaches];
        r.run(footprints, &buffers, len)?;
        r.run(rows, &[&m.reaches, &m.rows], m.rows.len())?;
    }
    r.batch.clear(&m.longest);
    Ok(())
}

/// Appends one round of gathering; which, says the uniform.
pub(super) fn gather(
    batch: &mut Batch<'_>,
    stages: &Refreshing,
    memory: &Memory,
) -> Result<(), GpuError> {
    let m = memory;
    let buffers = [
        &m.starts,
        &m.sorted,
        &m.footprints,
        &m.rows,
        &m.sums,
        &m.moments,
        &m.longest,
        &m.round,
    ];
    Recorder { batch, memory }.run(&stages.gather, &buffers, m.picture.len())
}

/// Appends what makes the picture from the sums.
pub(super) fn show(
    batch: &mut Batch<'_>,
    stages: &Refreshing,
    memory: &Memory,
) -> Result<(), GpuError> {
    let m = memory;
    let pixels = m.picture.len();
    let mut recorder = Recorder { batch, memory };
    let r = &mut recorder;
    if stages.planes {
        r.run(&stages.solve, &[&m.sums, &m.moments, &m.texels], pixels)?;
    } else {
        r.run(&stages.solve, &[&m.sums, &m.texels], pixels)?;
    }
    if let Some(Fill { pull, push }) = &stages.fill {
        for step in &m.texel_steps {
            r.run(pull, &[&step.uniform, &m.texels], step.coarse())?;
        }
        for step in m.texel_steps.iter().rev() {
            r.run(push, &[&step.uniform, &m.texels], step.fine())?;
        }
    }
    encode(batch, stages, memory)
}

/// Appends what shows filtered and averaged light.
pub(super) fn encode(
    batch: &mut Batch<'_>,
    stages: &Refreshing,
    memory: &Memory,
) -> Result<(), GpuError> {
    let m = memory;
    let buffers = [&m.texels, &m.picture, &m.means];
    Recorder { batch, memory }.run(&stages.encode, &buffers, m.picture.len())
}

/// Appends what averages `count` new samples, those that the uniform tells.
pub(super) fn average(
    batch: &mut Batch<'_>,
    stages: &Rest,
    memory: &Memory,
    count: usize,
) -> Result<(), GpuError> {
    let m = memory;
    let mut recorder = Recorder { batch, memory };
    recorder.run(&stages.rest, &[&m.cells, &m.means], m.picture.len())?;
    let buffers = [
        &m.fresh,
        &m.samples,
        &m.transforms,
        &m.cells,
        &m.means,
        &m.light,
    ];
    recorder.run(&stages.average, &buffers, count)
}

/// The depth beyond which each pixel is hidden.
fn limits(
    r: &mut Recorder<'_, '_>,
    hidden: &Hidden,
    len: usize,
    pixels: usize,
) -> Result<(), GpuError> {
    let m = r.memory;
    r.run(&hidden.far, &[&m.minima], pixels)?;
    r.run(&hidden.nearest, &[&m.ring, &m.projected, &m.minima], len)?;
    for step in &m.minima_steps {
        r.run(&hidden.coarser, &[&step.uniform, &m.minima], step.coarse())?;
    }
    r.run(&hidden.limits, &[&m.minima, &m.limits], pixels)?;
    r.batch.clear(&m.movers);
    let buffers = [&m.ring, &m.samples, &m.projected, &m.movers];
    r.run(&hidden.mark_movers, &buffers, len)
}

/// The exclusive prefix sum of `len` items: parameters, tables, the number of items as a uniform,
/// the items, the sums, the blocks' sums.
pub(super) fn prefix_sum(
    batch: &mut Batch<'_>,
    scan: &Scan,
    [params, tables, items, counts, starts, blocks]: [&Words; 6],
    len: usize,
) -> Result<(), GpuError> {
    let buffers = [params, tables, items, counts, starts, blocks];
    batch.run(&scan.blocks, &buffers, linear_grid(len, BLOCK))?;
    let buffers = [params, tables, items, starts, blocks];
    batch.run(&scan.sums, &buffers, [1, 1, 1])?;
    batch.run(&scan.add, &buffers, linear_grid(len, GROUP))
}
