//! Averaging what rests. Twin of `unframed_recon::rest` and of what `Display` does with it.

use super::display::GpuDisplay;
use super::params::Fresh;
use super::refresh;
use crate::gpu::GpuError;
use crate::pass::Batch;
use unframed_recon::rest::{MOST, Step};
use unframed_recon::tiles::TileMap;
use unframed_wire::Tick;

impl GpuDisplay<'_> {
    /// What this refresh has to do, and the means brought up to date.
    pub(super) fn step(&mut self, now: Tick) -> Result<Step, GpuError> {
        let stages = self.stages.refreshing.as_ref();
        let Some(stages) = stages.and_then(|stages| stages.rest.as_ref()) else {
            return Ok(Step::Filter);
        };
        let (Some(view), (width, height)) = (&self.view, (self.panel.width, self.panel.height))
        else {
            return Ok(Step::Filter);
        };
        let quiet =
            TileMap::resume(&mut self.cells, width, height).is_some_and(|tiles| tiles.rests());
        let step = self.rest.step(now, view, &self.slots, quiet);
        let fresh = std::mem::take(&mut self.fresh);
        let mut batch = Batch::new(self.gpu);
        if step == Step::Filter {
            if self.averaged {
                batch.clear(&self.memory.means);
                batch.submit()?;
                self.averaged = false;
            }
            return Ok(step);
        }
        self.averaged = true;
        let count = fresh.min(MOST);
        let capacity = self.params.capacity.max(1);
        let told = Fresh {
            // Both below 2^31.
            first: (self.next as u32 + capacity - count as u32) % capacity,
            count: count as u32,
            padding: [0; 2],
        };
        let words = bytemuck::cast_slice(std::slice::from_ref(&told));
        self.memory.fresh.write(self.gpu, 0, words)?;
        refresh::average(&mut batch, stages, &self.memory, count)?;
        batch.submit()?;
        Ok(step)
    }

    /// Shows what was filtered before and averaged since.
    pub(super) fn show(&self) -> Result<(), GpuError> {
        let Some(stages) = &self.stages.refreshing else {
            return Ok(());
        };
        let mut batch = Batch::new(self.gpu);
        refresh::encode(&mut batch, stages, &self.memory)?;
        batch.submit()
    }
}
