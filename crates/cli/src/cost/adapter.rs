//! The presets on the graphics adapter: what a refresh of the shader twin takes, and the same
//! refresh of the processor beside it.

use std::time::Instant;

use anyhow::{Context, Result, ensure};
use serde::Serialize;
use unframed_host::trace::World;
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Display, Fixed, Player, frame_hash};
use unframed_sim::{Gpu, GpuPlayer};

use super::knobs::Preset;
use super::stream::Stream;
use super::table::Point;
use crate::args::Size;
use crate::report::{Axis, Plot, Scale, Section, Table};

/// Times of a preset, milliseconds on the clock for the median refresh, what it receives included.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timed {
    /// The preset.
    pub preset: &'static str,
    /// On the adapter, until the picture is back.
    pub adapter_ms: f64,
    /// On one thread of the processor.
    pub processor_ms: f64,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct OnAdapter {
    /// The adapter.
    pub name: String,
    /// The presets, in their order.
    pub presets: Vec<Timed>,
}

/// Plays the stream of each preset on both. One after the other: they share the machine.
///
/// # Errors
/// The scene cannot be sent, a display not be set up, the adapter fails or shows another picture.
pub fn measure(
    gpu: &Gpu,
    presets: &[&Preset],
    world: &World,
    size: Size,
    seed: u64,
    [first, refreshes]: [u32; 2],
) -> Result<OnAdapter> {
    let Size { width, height } = size;
    let time = |preset: &&Preset| {
        let knobs = preset.knobs();
        let samples = knobs.samples(u32::from(width) * u32::from(height)) as usize;
        let stream = Stream::record(&knobs, size, seed, world, refreshes, first)?;
        let mut twin = GpuPlayer::new(gpu, knobs.display, width, height, samples)
            .context("cannot set up the display on the adapter")?;
        let mut storage = HeapStorage::<Fixed>::new(width, height, samples);
        let display = Display::new(knobs.display, width, height, storage.memory())
            .context("cannot set up the display")?;
        let mut player = Player::new(display);
        let mut times = [Vec::new(), Vec::new()];
        for bytes in &stream.refreshes {
            let [on_adapter, on_processor] = &mut times;
            let begin = Instant::now();
            twin.push(&mut &bytes[..])?;
            on_adapter.push(begin.elapsed().as_secs_f64());
            let begin = Instant::now();
            player.push(&mut &bytes[..]);
            on_processor.push(begin.elapsed().as_secs_f64());
        }
        ensure!(
            frame_hash(twin.picture()) == frame_hash(player.display().picture()),
            "preset `{}`: {} shows another picture than the processor",
            preset.name,
            gpu.describe()
        );
        let [adapter_ms, processor_ms] = times.map(|times| 1e3 * median(&times, first as usize));
        Ok(Timed {
            preset: preset.name,
            adapter_ms,
            processor_ms,
        })
    };
    Ok(OnAdapter {
        name: gpu.describe(),
        presets: presets.iter().map(time).collect::<Result<_>>()?,
    })
}

/// The median from entry `first` on; 0 of none.
fn median(times: &[f64], first: usize) -> f64 {
    let mut times = times.get(first..).unwrap_or(&[]).to_vec();
    times.sort_unstable_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}

/// A table and a plot of them.
///
/// # Errors
/// The plot cannot be drawn.
pub fn section(found: &OnAdapter, points: &[&Point]) -> Result<Section> {
    let mut section = Section::new("On the graphics adapter");
    let heads = ["preset", "RMSE", "adapter, ms", "processor, ms", "ratio"];
    let mut table = Table::new(heads).caption(
        "The median refresh on the first scene, on the clock; one thread of the processor. Both \
         show the same bits.",
    );
    let mut lines = [Vec::new(), Vec::new()];
    for timed in &found.presets {
        let point = points.iter().find(|p| p.preset == Some(timed.preset));
        let Some(rmse) = point.map(|p| p.rmse) else {
            continue;
        };
        table.row([
            timed.preset.to_owned(),
            format!("{rmse:.2}"),
            format!("{:.1}", timed.adapter_ms),
            format!("{:.1}", timed.processor_ms),
            format!("{:.2}", timed.adapter_ms / timed.processor_ms.max(1e-9)),
        ]);
        lines[0].push((timed.adapter_ms, rmse));
        lines[1].push((timed.processor_ms, rmse));
    }
    section.paragraph(&found.name);
    section.table(&table);
    let [adapter, processor] = lines;
    let plot = Plot::new(
        "Error against a refresh's time",
        Axis::new("ms a refresh (log)", Scale::Log),
        Axis::new("RMSE of displayed sRGB values", Scale::Linear),
    )
    .line("adapter", adapter)
    .line("processor", processor);
    section.plot(&plot, "")?;
    Ok(section)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::knobs::PRESETS;
    use crate::measure::open_scene;

    #[test]
    fn a_median_leaves_the_warm_up_out() {
        assert_eq!(median(&[9.0, 9.0, 1.0, 3.0, 2.0], 2), 2.0);
        assert_eq!(median(&[9.0], 2), 0.0);
    }

    #[test]
    fn presets_are_timed_on_both() {
        let Ok(gpu) = Gpu::new() else {
            assert!(std::env::var_os("CI").is_none(), "no adapter");
            println!("left out: there is no graphics adapter");
            return;
        };
        let size = Size {
            width: 32,
            height: 24,
        };
        let world = open_scene("interactive", size).unwrap();
        let found = measure(&gpu, &[&PRESETS[0]], &world, size, 1, [2, 5]).unwrap();
        assert_eq!(found.presets[0].preset, PRESETS[0].name);
        assert!(found.presets[0].adapter_ms > 0.0 && found.presets[0].processor_ms > 0.0);
    }
}
