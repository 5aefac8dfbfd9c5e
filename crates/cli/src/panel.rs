//! The display hardware that a command shows on: the same bits on each.

use anyhow::{Context, Result};
use unframed_recon::heap::HeapStorage;
use unframed_recon::workers::{Threads, Workers};
use unframed_recon::{Config, Display, Fixed, Player};
use unframed_sim::gpu::Gpu;
use unframed_sim::twin::GpuPlayer;
use unframed_wire::{Counters, Refresh};

use crate::args::DisplayKind;

/// Takes bytes, shows pictures.
pub trait Panel {
    /// Takes bytes off the front of `input` up to the end of the next Refresh and makes its
    /// picture; `None` when the input is used up.
    ///
    /// # Errors
    /// When the hardware fails; what was received is not lost.
    fn push(&mut self, input: &mut &[u8]) -> Result<Option<Refresh>>;

    /// The picture shown.
    fn picture(&self) -> &[[u8; 3]];

    /// What went through the link.
    fn link(&self) -> Counters;
}

impl<W: Workers> Panel for Player<'_, Fixed, W> {
    fn push(&mut self, input: &mut &[u8]) -> Result<Option<Refresh>> {
        Ok(Self::push(self, input))
    }

    fn picture(&self) -> &[[u8; 3]] {
        self.display().picture()
    }

    fn link(&self) -> Counters {
        *self.receiver().counters()
    }
}

impl Panel for GpuPlayer<'_> {
    fn push(&mut self, input: &mut &[u8]) -> Result<Option<Refresh>> {
        Ok(Self::push(self, input)?)
    }

    fn picture(&self) -> &[[u8; 3]] {
        Self::picture(self)
    }

    fn link(&self) -> Counters {
        *self.receiver().counters()
    }
}

/// What is asked of a panel.
#[derive(Debug, Clone, Copy)]
pub struct Order {
    /// Which hardware.
    pub kind: DisplayKind,
    /// What it does.
    pub config: Config,
    /// Pixels a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// Samples remembered.
    pub samples: u32,
    /// Threads a refresh, on the CPU; the bits are those of one.
    pub threads: usize,
}

/// One thread a core: for a display that has the machine to itself.
#[must_use]
pub fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Sets up the panel and does `work` with it and its name.
///
/// # Errors
/// When there is no such hardware, and what `work` returns.
pub fn with_panel<R>(
    order: &Order,
    work: impl FnOnce(&mut dyn Panel, &str) -> Result<R>,
) -> Result<R> {
    let (width, height, samples) = (order.width, order.height, order.samples as usize);
    if let Some(gpu) = adapter(order.kind)? {
        let mut player = GpuPlayer::new(&gpu, order.config, width, height, samples)
            .context("cannot set up the display on the adapter")?;
        return work(&mut player, &format!("wgpu ({})", gpu.describe()));
    }
    let mut storage = HeapStorage::<Fixed>::new(width, height, samples);
    let workers = Threads::new(order.threads).context("cannot start the display's threads")?;
    let display = Display::with_workers(workers, order.config, width, height, storage.memory())
        .context("cannot set up the display")?;
    work(&mut Player::new(display), "cpu")
}

/// The adapter to show on, if one is asked for or worth it: a software adapter shows the same
/// bits as the CPU, later.
fn adapter(kind: DisplayKind) -> Result<Option<Gpu>> {
    static TOLD: std::sync::Once = std::sync::Once::new();
    let tell = |reason: String| TOLD.call_once(|| eprintln!("display: the CPU ({reason})"));
    match kind {
        DisplayKind::Cpu => Ok(None),
        DisplayKind::Wgpu => Ok(Some(Gpu::new().context("--display wgpu")?)),
        DisplayKind::Auto => Ok(match Gpu::new() {
            Ok(gpu) if !gpu.is_software() => Some(gpu),
            Ok(gpu) => {
                tell(format!("the only adapter is software: {}", gpu.describe()));
                None
            }
            Err(_) => {
                tell("no graphics adapter; `--display wgpu` says why".to_owned());
                None
            }
        }),
    }
}
