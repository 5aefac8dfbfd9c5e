//! Each stage's buffer against the Rust stage of the same name.

use unframed_recon::arith::{ANCHOR_BITS, Arith, Moments, Panel, Projected, Sums, Texel};
use unframed_recon::config::{Config, Extents, Fit, Lifetime, Light};
use unframed_recon::deep::{Placing, Stored, age, slot};
use unframed_recon::encode::ENCODED;
use unframed_recon::fill::{self, pyramid_len};
use unframed_recon::hidden::{self, Minima, minima_len};
use unframed_recon::light::facets::Facet;
use unframed_recon::light::map::{WINDOWS, Window};
use unframed_recon::light::toward::Toward;
use unframed_recon::light::{self, Lights};
use unframed_recon::memory::Slot;
use unframed_recon::motion::{Motion, Past};
use unframed_recon::splat::{self, Filter, Target, Widths};
use unframed_recon::tables::SRGB_TO_LINEAR;
use unframed_recon::tiles::{Cell, TileMap, cells_along};
use unframed_recon::transform::Transform;
use unframed_recon::{Alone, Fixed, solve};
use unframed_sim::twin::Probe;
use unframed_wire::{LAMPS, Packet, Receiver, Tick, View};

/// What the Rust stages make of a stream up to its last refresh, as words of the shaders' layout.
pub(crate) struct Stages {
    pub(crate) expected: Vec<(Probe, Vec<u32>)>,
}

/// A stream's contents up to its last refresh.
struct Contents<'a> {
    samples: Vec<Stored>,
    slots: Vec<Slot<Fixed>>,
    lights: Lights<'a>,
    motion: Motion,
    view: Option<View>,
    now: Tick,
}

fn contents<'a>(bytes: &[u8], map: &mut TileMap<'_>, lights: Lights<'a>) -> Contents<'a> {
    let mut found = Contents {
        samples: Vec::new(),
        slots: vec![Slot::default(); 256],
        lights,
        motion: Motion::new(),
        view: None,
        now: Tick(0),
    };
    let mut receiver = Receiver::new();
    let mut input = bytes;
    while let Some(packet) = receiver.push(&mut input) {
        match packet {
            Packet::View(view) => found.view = Some(view),
            Packet::Poses(poses) => {
                poses
                    .for_each(|pose| found.slots[usize::from(slot(pose.object))].pose = Some(pose));
            }
            Packet::Tiles(tiles) => tiles.for_each(|tile| map.set(&tile)),
            Packet::World(samples) => {
                let time = samples.time().0;
                samples.for_each(|s| {
                    found.samples.push(Stored {
                        time,
                        place: s.place,
                        rgb: s.rgb,
                        slot: slot(s.object),
                        placing: Placing::Lattice,
                        shares: s.shares,
                    });
                });
            }
            Packet::Lamps(lamps) => {
                for (index, lamp) in lamps.enumerate() {
                    assert!(found.lights.lamp(index, &lamp));
                }
            }
            Packet::Shape(shape) => assert!(found.lights.shape(&shape)),
            Packet::Refresh(refresh) => {
                found.lights.prepare(&found.slots);
                found.now = refresh.time;
                let view = found.view.expect("a view");
                found.motion.refresh(found.now, &view, &mut found.slots);
            }
            _ => {}
        }
    }
    found
}

fn pair(low: u16, high: u16) -> u32 {
    u32::from(low) | u32::from(high) << 16
}

fn wide(values: &[i64]) -> impl Iterator<Item = u32> {
    values.iter().flat_map(|v| [*v as u32, (*v >> 32) as u32])
}

fn texel_words(texels: &[Texel<Fixed>]) -> impl Iterator<Item = u32> {
    texels.iter().flat_map(|t| {
        let [r, g, b] = t.light;
        [pair(r, g), pair(b, t.confidence)]
    })
}

impl Stages {
    /// The steps of `Display::refresh` one by one, for a stream of world samples.
    pub(crate) fn new(config: &Config, size: (u16, u16), bytes: &[u8]) -> Stages {
        let (width, height) = size;
        let panel = Panel::new(width, height).expect("a sound size");
        let mut cells = vec![Cell::default(); cells_along(width) * cells_along(height)];
        let mut map = TileMap::new(&mut cells, width, height).expect("enough cells");
        let mut facets = vec![Facet::EMPTY; light::FACETS];
        let mut towards = vec![[Toward::ZERO; LAMPS]; 256];
        let mut shadows = vec![0; light::TEXELS];
        let mut windows = vec![Window::EMPTY; WINDOWS];
        let lights = Lights::new(light::Memory {
            facets: &mut facets,
            towards: &mut towards,
            texels: &mut shadows,
            windows: &mut windows,
        });
        let contents = contents(bytes, &mut map, lights);
        let (mut projected, own_widths) = project(config, &panel, &map, &contents);
        let pixels = panel.pixels();
        let pixel_of = |s: &Projected<Fixed>| {
            panel.nearest(Fixed::pixel(&panel, s.x), Fixed::pixel(&panel, s.y))
        };
        let seen = |projected: &[Projected<Fixed>]| -> Vec<Projected<Fixed>> {
            projected.iter().filter(|s| s.weight > 0).copied().collect()
        };
        let mut expected = Vec::new();

        if config.hidden {
            let mut minima = vec![0; minima_len(width, height)];
            let mut limits = vec![0; pixels];
            let all = seen(&projected);
            let once = || std::iter::once(&all[..]);
            let mut movers = vec![0; pixels];
            hidden::survey::<Fixed>(&panel, once(), 0, &mut minima[..pixels], &mut movers);
            hidden::coarsen::<Fixed>(&panel, &mut Minima::of(&panel, &mut minima));
            hidden::limits::<Fixed>(&panel, &minima, 0, &mut limits);
            let reach = contents
                .motion
                .reach::<Fixed>(&contents.view.expect("a view"));
            for s in &mut projected {
                if hidden::hides(&reach, &limits, &movers, pixel_of(s), s) {
                    s.weight = 0;
                }
            }
            let words = movers.iter().map(|v| u32::from(*v)).collect();
            expected.push((Probe::Movers, words));
            expected.push((
                Probe::Minima,
                minima.iter().map(|v| u32::from(*v)).collect(),
            ));
            expected.push((
                Probe::Limits,
                limits.iter().map(|v| u32::from(*v)).collect(),
            ));
        }
        let words = |(s, widths): (&Projected<Fixed>, &[i16; 2])| {
            let [wx, wy] = widths.map(|w| w as u16);
            [pair(s.x, s.y), pair(s.depth, s.weight), pair(wx, wy)]
        };
        let words = projected.iter().zip(&own_widths).flat_map(words).collect();
        expected.insert(0, (Probe::Projected, words));
        let mut widths = Vec::new();
        if config.extents == Extents::Density {
            let mut mass = vec![0; pixels];
            for s in &projected {
                Fixed::gather(&mut mass[pixel_of(s)], s.weight);
            }
            expected.push((Probe::Masses, mass.clone()));
            let mut map = vec![0; pixels];
            splat::sum_along::<Fixed>(&panel, &mut mass);
            splat::widths::<Fixed>(&panel, 0..height.into(), &mass, &mut map);
            let words = map.iter().map(|w| i32::from(*w) as u32).collect();
            expected.push((Probe::Widths, words));
            widths = map;
        }
        let light = match config.light {
            Light::Linear => &SRGB_TO_LINEAR,
            Light::Encoded => &ENCODED,
        };
        let planes = config.fit == Fit::Linear;
        let mut sums = vec![Sums::<Fixed>::default(); pixels];
        let mut moments = vec![Moments::<Fixed>::default(); if planes { pixels } else { 0 }];
        let filter = Filter {
            panel,
            widths: Widths::new(config.extents, &widths, &map),
            light,
        };
        let mut target = Target::<Fixed> {
            lines: 0..height.into(),
            sums: &mut sums,
            moments: &mut moments,
        };
        filter.scatter(std::iter::once(&seen(&projected)[..]), &mut target);
        expected.push((
            Probe::Sums,
            sums.iter().flat_map(|sums| wide(&sums.0)).collect(),
        ));
        if planes {
            let centred = moments
                .iter()
                .zip(&sums)
                .enumerate()
                .flat_map(|(i, (m, s))| {
                    let within = |v: usize| (v % (1 << ANCHOR_BITS)) as i32;
                    let pixel = (
                        within(i % usize::from(width)),
                        within(i / usize::from(width)),
                    );
                    let moments = Fixed::centred(s, m, pixel);
                    wide(&moments.0[..11]).collect::<Vec<_>>()
                });
            expected.push((Probe::Moments, centred.collect()));
        }
        let mut texels = vec![Texel::<Fixed>::default(); pixels];
        if planes {
            solve::planes::<Fixed>(width.into(), 0, &sums, &moments, &mut texels);
        } else {
            solve::means::<Fixed>(&sums, &mut texels);
        }
        let mut pyramid = vec![Texel::<Fixed>::default(); pyramid_len(width, height)];
        if config.fill {
            fill::fill(
                width.into(),
                height.into(),
                &mut texels,
                &mut pyramid,
                &Alone,
            );
        }
        let words = texel_words(&texels).chain(texel_words(&pyramid)).collect();
        expected.push((Probe::Texels, words));
        Stages { expected }
    }
}

/// The samples at the refresh instant, as `Display::project` makes them, and the widths that they
/// have of themselves.
fn project(
    config: &Config,
    panel: &Panel,
    map: &TileMap<'_>,
    contents: &Contents<'_>,
) -> (Vec<Projected<Fixed>>, Vec<[i16; 2]>) {
    let view = contents.view.expect("a view");
    let of = |sample: &Stored| {
        let age = age(sample.time, contents.now)?;
        let pose = contents.slots[usize::from(sample.slot)].pose?;
        let transform = Transform::compose(&view, &pose);
        let (x, y, depth) = Fixed::project(&transform, panel, sample.place)?;
        let gradient = Fixed::extents(map, panel, x, y);
        let lifetime = match config.lifetime {
            Lifetime::Constant(log) => Fixed::log(log),
            Lifetime::Tiles => {
                let within = |v: u16, size: u16| {
                    let pixel = Fixed::pixel(panel, v).clamp(0, i32::from(size) - 1);
                    Fixed::centre(panel, pixel)
                };
                let at = (within(x, panel.width), within(y, panel.height));
                Fixed::lifetime(map, panel, at.0, at.1)
            }
            Lifetime::Gradient => gradient.0,
        };
        let widths = match config.extents {
            Extents::Constant(log) => [Fixed::width(log.into()); 2],
            Extents::Density | Extents::Pixel if config.lifetime != Lifetime::Gradient => [0; 2],
            _ => [gradient.1, gradient.2],
        };
        let projected = Projected {
            x,
            y,
            depth,
            weight: Fixed::decline(
                config.kernel,
                config.cutoff,
                Fixed::log_of_age(age),
                lifetime,
            ),
            rgb: contents.lights.relight(sample),
            past: Past::new(age, sample.slot > slot(0)),
        };
        Some((projected, widths))
    };
    let all = contents.samples.iter();
    all.map(|s| of(s).unwrap_or_default()).unzip()
}
