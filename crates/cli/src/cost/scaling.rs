//! How a refresh's cost grows with samples remembered, with pixels and with the rate, while the
//! view moves and at rest: instructions that an emulator counted, so that they repeat exactly.

use anyhow::{Context, Result};
use serde::Serialize;
use unframed_host::scene::Scene;
use unframed_host::trace::World;

use super::cores::Cores;
use super::knobs::{Knobs, PRESETS};
use super::stream::Stream;
use super::study::parallel;
use super::table::slope;
use crate::args::Size;
use crate::eval::probes::still;
use crate::measure::REFRESH_HZ;
use crate::report::{Axis, Plot, Scale};

/// What is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Along {
    /// Samples remembered.
    Samples,
    /// Pixels of the panel.
    Pixels,
    /// Samples a second.
    Rate,
}

/// Where all else stands: pixels a side, samples remembered, samples a second.
const BASE: (u16, u32, u32) = (64, 8192, 16_384);
/// Refreshes: the buffer is full and rest has settled (after 1.05 s) before the last of them.
const REFRESHES: u32 = 72;
/// The last refreshes, whose mean counts.
const COUNTED: usize = 4;

impl Along {
    const ALL: [Self; 3] = [Self::Samples, Self::Pixels, Self::Rate];

    /// For titles and axes.
    fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples remembered",
            Self::Pixels => "pixels",
            Self::Rate => "samples a second",
        }
    }

    /// Panels, samples and rates.
    fn steps(self) -> Vec<(u16, u32, u32)> {
        let (side, samples, rate) = BASE;
        match self {
            Self::Samples => [1024, 2048, 4096, 8192, 16_384]
                .map(|samples| (side, samples, rate))
                .to_vec(),
            Self::Pixels => [16, 24, 32, 48, 64]
                .map(|side| (side, samples, rate))
                .to_vec(),
            Self::Rate => [4096, 8192, 16_384, 32_768, 65_536]
                .map(|rate| (side, samples, rate))
                .to_vec(),
        }
    }

    fn value(self, step: (u16, u32, u32)) -> f64 {
        match self {
            Self::Samples => step.1.into(),
            Self::Pixels => f64::from(step.0).powi(2),
            Self::Rate => step.2.into(),
        }
    }
}

/// Instructions of a refresh, receiving included, against one quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Which quantity.
    pub along: Along,
    /// Whether everything moves, or has rested for a second.
    pub moving: bool,
    /// Quantity and instructions.
    pub points: Vec<(f64, f64)>,
    /// The slope of the line through their logarithms: 1 is in proportion, 0 is not at all.
    pub slope: f64,
}

/// Counts all curves on a core; the display is that of the preset `medium`.
///
/// # Errors
/// The emulator fails, or shows another picture than this machine.
pub fn curves(cores: &Cores, scene: &Scene, seed: u64, threads: usize) -> Result<Vec<Curve>> {
    let medium = PRESETS.iter().find(|preset| preset.name == "medium");
    let display = medium.context("no preset `medium`")?.knobs();
    let resting = still(scene, 0.0);
    let mut jobs = Vec::new();
    for along in Along::ALL {
        for moving in [true, false] {
            jobs.extend(along.steps().into_iter().map(|step| (along, moving, step)));
        }
    }
    let counted = parallel(threads, jobs.len(), |i| {
        let (_, moving, (side, samples, rate)) = jobs[i];
        let scene = if moving { scene } else { &resting };
        let knobs = Knobs {
            density: f64::from(rate) / f64::from(side).powi(2),
            ..display
        };
        let size = Size {
            width: side,
            height: side,
        };
        let world = World::new(scene.clone(), [u32::from(side); 2])?;
        let stream = Stream::record(&knobs, size, seed, &world, REFRESHES, 0)?;
        let all = cores.count(size, samples as usize, knobs.display, &stream)?;
        let last = all.iter().rev().take(COUNTED);
        Ok(last.map(|(_, effort)| effort.total()).sum::<f64>() / COUNTED as f64)
    })?;
    let mut curves: Vec<Curve> = Vec::new();
    for ((along, moving, step), instructions) in jobs.into_iter().zip(counted) {
        let point = (along.value(step), instructions);
        match curves.last_mut() {
            Some(curve) if (curve.along, curve.moving) == (along, moving) => {
                curve.points.push(point);
            }
            _ => curves.push(Curve {
                along,
                moving,
                points: vec![point],
                slope: 0.0,
            }),
        }
    }
    for curve in &mut curves {
        let logs: Vec<_> = curve.points.iter().map(|p| (p.0.ln(), p.1.ln())).collect();
        curve.slope = slope(&logs).unwrap_or(0.0);
    }
    Ok(curves)
}

/// One plot a quantity, moving and at rest: a file name and the plot.
#[must_use]
pub fn plots(curves: &[Curve]) -> Vec<(&'static str, Plot)> {
    let files = [
        "scaling-samples.svg",
        "scaling-pixels.svg",
        "scaling-rate.svg",
    ];
    let (side, samples, rate) = BASE;
    let plot = |(along, file): (Along, &'static str)| {
        let else_fixed = match along {
            Along::Samples => format!("{side} x {side} pixels, {rate} samples a second"),
            Along::Pixels => format!("N = {samples}, {rate} samples a second"),
            Along::Rate => format!("N = {samples}, {side} x {side} pixels"),
        };
        let x = Axis::new(format!("{} (log); {else_fixed}", along.name()), Scale::Log);
        let y = Axis::new("instructions a refresh on a Cortex-M7 (log)", Scale::Log);
        let title = format!("Cost against {}", along.name());
        let own = curves.iter().filter(|curve| curve.along == along);
        let plot = own.fold(Plot::new(title, x, y), |plot, curve| {
            let state = if curve.moving { "moving" } else { "at rest" };
            plot.line(
                format!("{state}: slope {:.2}", curve.slope),
                curve.points.clone(),
            )
        });
        (file, plot)
    };
    let some = |plot: &(Along, &str)| curves.iter().any(|curve| curve.along == plot.0);
    Along::ALL
        .into_iter()
        .zip(files)
        .filter(some)
        .map(plot)
        .collect()
}

const _: () = assert!(REFRESHES > REFRESH_HZ, "rest settles after a second");
