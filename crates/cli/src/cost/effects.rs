//! The knob that does nothing where no effect is called for, measured where three are: the side of
//! the interleaving pattern, of the frameless host and of whole frames.

use anyhow::Result;
use serde::Serialize;
use unframed_host::effects::framed::{Refinement, SIDE, render_with};
use unframed_host::effects::reference::reference;
use unframed_host::trace::{World, srgb};
use unframed_metrics::{Image, rmse};

use super::knobs::{Knobs, MIDDLE, Planned};
use super::study::parallel;
use super::table::Point;
use crate::args::Size;
use crate::method::{Method, Sampling};
use crate::report::{Section, Table};
use crate::work::Stopwatch;

/// A built-in scene that calls for soft shadows, indirect light and a medium.
pub const SCENE: &str = "cornell-mist";
/// Most pixels a side of the panel, and most seconds that count: an ideal picture with effects takes
/// some fifty rays for each of a pixel's samples.
const MOST: (u16, f64) = (64, 0.2);
/// The sweep's name.
pub const SWEEP: &str = "pattern of effects";
/// Sides in pixels; 0 is random points.
const SIDES: [u16; 6] = [0, 1, 2, 4, 8, 16];

/// The panel and the seconds that count, of those that are asked for.
#[must_use]
pub fn within(size: Size, seconds: f64) -> (Size, f64) {
    let size = Size {
        width: size.width.min(MOST.0),
        height: size.height.min(MOST.0),
    };
    (size, seconds.min(MOST.1))
}

/// What a side is called.
#[must_use]
pub fn side(pixels: u16) -> String {
    match pixels {
        0 => "random points".to_owned(),
        pixels => format!("pattern of {pixels} px"),
    }
}

/// The points of the sweep.
#[must_use]
pub fn sweep() -> Vec<Planned> {
    let middle = Knobs::new(Method::Adaptive, MIDDLE);
    let of = |pattern| Planned {
        sweep: SWEEP,
        knobs: Knobs {
            sampling: Sampling {
                pattern,
                ..middle.sampling
            },
            ..middle
        },
    };
    SIDES.map(of).to_vec()
}

/// Sides of the patterns of whole frames, pixels.
const FRAMED_SIDES: [u32; 4] = [1, 3, 5, 7];
/// Paths a pixel of the picture that frames are compared with.
const PATHS: u32 = 400;
/// The instant of the frame, seconds.
const INSTANT: f64 = 1.0;

/// A whole frame by adaptive interleaved sampling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Framed {
    /// Side of the pattern and of the filter, pixels.
    pub side: u32,
    /// Against a path tracer: root of the mean of squares, displayed levels.
    pub rmse: f64,
    /// Core seconds of the frame.
    pub host_seconds: f64,
    /// Rays of the frame, of all kinds.
    pub rays: u32,
}

/// Frames by patterns of several sides, on so many threads, each on one.
///
/// # Errors
/// The picture is too small to be compared.
pub fn framed(world: &World, threads: usize) -> Result<Vec<Framed>> {
    let [width, height] = world.size().map(|side| side as usize);
    let codes = |light: &[glam::Vec3]| -> Vec<[u8; 3]> {
        light.iter().map(|light| srgb::encode8(*light)).collect()
    };
    let truth = codes(&reference(&mut world.clone(), INSTANT, PATHS));
    parallel(threads, FRAMED_SIDES.len(), |i| {
        let (side, mut world) = (FRAMED_SIDES[i], world.clone());
        let watch = Stopwatch::start();
        let frame = render_with(&mut world, INSTANT, Refinement::Adaptive, side);
        let host_seconds = watch.seconds();
        let shown = codes(&frame.light);
        let truth = Image::new(&truth, width, height)?;
        Ok(Framed {
            side,
            rmse: rmse(truth, Image::new(&shown, width, height)?)?,
            host_seconds,
            rays: frame.rays.total(),
        })
    })
}

/// A table of the sweep and one of frames.
#[must_use]
pub fn section(points: &[Point], framed: &[Framed]) -> Section {
    let mut section = Section::new("Effects: side of the pattern");
    section.paragraph(&format!(
        "By `adaptive` on `{SCENE}`, which calls for soft shadows, indirect light and a medium, on at \
         most {0} × {0} pixels for at most {1} s. Samples of a square of the pattern take the \
         points of lamps and media from one sequence. Error is against the ideal picture with \
         the same effects, and not split.",
        MOST.0, MOST.1
    ));
    let heads = [
        "points",
        "RMSE",
        "dB",
        "host, core s",
        "host, %",
        "Mray/s",
        "rays, %",
        "kB/s",
    ];
    let mut table = Table::new(heads);
    let usual = Knobs::new(Method::Adaptive, MIDDLE);
    let Some(base) = points.iter().find(|p| *p.settings() == usual) else {
        return section;
    };
    let percent = |a: f64, b: f64| format!("{:+.1}", 100.0 * (a / b - 1.0)).replace('-', "−");
    for p in points {
        let cells = [
            side(p.settings().sampling.pattern),
            format!("{:.2}", p.rmse),
            format!("{:+.2}", p.psnr - base.psnr).replace('-', "−"),
            format!("{:.3}", p.host_seconds),
            percent(p.host_seconds, base.host_seconds),
            format!("{:.2}", p.rays_per_second * 1e-6),
            percent(p.rays_per_second, base.rays_per_second),
            format!("{:.0}", p.bytes_per_second * 1e-3),
        ];
        if *p.settings() == usual {
            table.strong_row(cells);
        } else {
            table.row(cells);
        }
    }
    section.table(&table);
    section.paragraph(&format!(
        "The same scene in whole frames (Dubla et al. 2009, guided by noise): n² pixels of a \
         pattern share the virtual lights among them, and a box of n × n pixels filters. Against \
         {PATHS} paths a pixel."
    ));
    let mut table = Table::new(["pattern", "RMSE", "ms a frame, one core", "Mray a frame"]);
    for frame in framed {
        let cells = [
            format!("{0} × {0}", frame.side),
            format!("{:.2}", frame.rmse),
            format!("{:.1}", frame.host_seconds * 1e3),
            format!("{:.3}", f64::from(frame.rays) * 1e-6),
        ];
        if frame.side == SIDE {
            table.strong_row(cells);
        } else {
            table.row(cells);
        }
    }
    section.table(&table);
    section
}
