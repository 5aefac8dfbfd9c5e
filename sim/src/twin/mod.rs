//! The reconstructor on the adapter: the WGSL twin of `unframed_recon::Display<Fixed>`, equal to
//! the bit for every stream and configuration.
//!
//! | here | in `unframed-recon` | shaders |
//! |---|---|---|
//! | [`GpuPlayer`] | `player` | |
//! | `display` | `display`, `deep` | `place`, `store`, `advance`; `claim`, `show` |
//! | `refresh` | `Display::refresh` | `project`, then |
//! | | `hidden`, `motion` | `far`, `nearest`, `coarser`, `limits`, `mark_movers`, `drop_hidden` |
//! | | `splat` | `scan_*`, `sort`, `masses`, `widths`, `gather` |
//! | | `solve`, `fill`, `encode` | `means` or `planes`, `pull`, `push`, `encode` |
//! | `rest` | `rest` | `rest`, `average`; `mean` |
//! | `light` | `light` | `light`, `srgb`, in `sort` and `average` |
//! | `tables`, `params`, `memory`, `stages` | `tables`, `memory` | `common`, `num`, `fixed`, `texel`, `level` |
//!
//! Packets, tiles, the composition of view and poses, the ways they travelled (a few objects a
//! refresh) and the drawing of shadow maps stay on the processor; everything that happens to each sample or pixel happens here in shaders. The deep
//! buffer is uploaded once a sample.
//!
//! The one difference in structure: Rust scatters each sample to the pixels of its footprint, the
//! adapter sorts samples by pixel and gathers, so that each pixel's 64-bit sums belong to one
//! invocation. Both add the same integers, and integer sums do not depend on the order. Measured
//! on lavapipe (400,000 samples, 256 × 256 pixels, two busy cores; `examples/twin_rate.rs`): a
//! gather bin by bin took 1090 ms, along rows of bins no longer than any sample's reach 310 ms,
//! and skipping what is out of reach before its light is loaded 220 ms.

mod display;
#[cfg(test)]
mod layout_tests;
mod light;
mod memory;
mod params;
mod probe;
mod refresh;
mod rest;
mod stages;
mod tables;

use display::GpuDisplay;
pub use probe::Probe;
pub use tables::Tables;
use unframed_recon::Config;
use unframed_recon::display::Counts;
use unframed_wire::{Receiver, Refresh, Status, Tick};

use crate::gpu::{Gpu, GpuError};

/// A display on the adapter at the end of a link. Twin of `unframed_recon::Player`.
pub struct GpuPlayer<'g> {
    receiver: Receiver,
    display: GpuDisplay<'g>,
    newest: Tick,
}

impl std::fmt::Debug for GpuPlayer<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (width, height) = self.display.size();
        write!(f, "GpuPlayer({width} x {height}, {:?})", self.display.gpu())
    }
}

impl<'g> GpuPlayer<'g> {
    /// A display of `width` × `height` pixels that remembers `samples` samples and has received
    /// nothing yet; the picture starts black.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when the size is out of range (1 to 4080 pixels, 2^30 samples), when
    /// the adapter has not the memory, or when it rejects a shader.
    pub fn new(
        gpu: &'g Gpu,
        config: Config,
        width: u16,
        height: u16,
        samples: usize,
    ) -> Result<Self, GpuError> {
        Self::with_tables(gpu, config, width, height, samples, &Tables::new(&config))
    }

    /// As [`GpuPlayer::new`], with other tables than the reconstructor's: to see that a check of
    /// equality can fail.
    ///
    /// # Errors
    /// As for [`GpuPlayer::new`].
    pub fn with_tables(
        gpu: &'g Gpu,
        config: Config,
        width: u16,
        height: u16,
        samples: usize,
        tables: &Tables,
    ) -> Result<Self, GpuError> {
        Ok(Self {
            receiver: Receiver::new(),
            display: GpuDisplay::new(gpu, config, (width, height), samples, tables)?,
            newest: Tick(0),
        })
    }

    /// Takes bytes off the front of `input` up to the end of the next Refresh, makes its picture
    /// and hands the Refresh back; `None` when the input is used up. Call until `None`.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when the device is lost or out of memory.
    pub fn push(&mut self, input: &mut &[u8]) -> Result<Option<Refresh>, GpuError> {
        while let Some(packet) = self.receiver.push(input) {
            if let Some(refresh) = self.display.receive(packet)? {
                self.newest = refresh.time;
                return Ok(Some(refresh));
            }
        }
        Ok(None)
    }

    /// The picture of the newest Refresh, row by row from the top, in the stream's encoding.
    #[must_use]
    pub fn picture(&self) -> &[[u8; 3]] {
        self.display.picture()
    }

    /// What a stage of the newest refresh left in its buffer. A buffer that the configuration does
    /// not call for holds one entry of zeros.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when the device is lost.
    pub fn probe(&self, probe: Probe) -> Result<Vec<u32>, GpuError> {
        self.display.memory.probed(probe).read(self.display.gpu())
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> (u16, u16) {
        self.display.size()
    }

    /// What was received so far. Where the adapter places samples (without reprojection), those
    /// since the newest Refresh are not counted yet.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.display.counts()
    }

    /// What went through the link.
    #[must_use]
    pub fn receiver(&self) -> &Receiver {
        &self.receiver
    }

    /// The report to the host; counts saturate.
    #[must_use]
    pub fn status(&self) -> Status {
        let buffered = self.display.buffered();
        self.receiver.counters().status(self.newest, buffered)
    }
}
