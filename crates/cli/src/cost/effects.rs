//! The knob that does nothing where no effect is called for, measured where three are: the side of
//! the interleaving pattern.

use super::knobs::{Knobs, MIDDLE, Planned};
use super::table::Point;
use crate::args::Size;
use crate::method::{Method, Sampling};
use crate::report::{Section, Table};

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

/// A table of it.
#[must_use]
pub fn section(points: &[Point]) -> Section {
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
    section
}
