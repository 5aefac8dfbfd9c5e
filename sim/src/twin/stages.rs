//! The compiled stages of a refresh, in the order in which they run.

use crate::gpu::{Gpu, GpuError};
use crate::pass::Access::{self, Read, Uniform, Write};
use crate::pass::{INT64, Stage};
use unframed_recon::config::{Config, Extents, Fit, Mode};

const COMMON: &str = include_str!("shaders/common.wgsl");
const NUM: &str = include_str!("shaders/num.wgsl");
const FIXED: &str = include_str!("shaders/fixed.wgsl");
const TEXEL: &str = include_str!("shaders/texel.wgsl");
const LEVEL: &str = include_str!("shaders/level.wgsl");

/// Invocations a workgroup in all stages over items: `GROUP` of `common.wgsl`.
pub(crate) const GROUP: u32 = 64;
/// Samples of a row that one round of gathering looks at: `LOOK` of `gather.wgsl`.
pub(crate) const LOOK: u32 = 7000;
/// Items of a block of the prefix sum.
pub(crate) const BLOCK: u32 = 2048;

/// Whether samples' footprints differ in size.
pub(crate) fn varies(extents: Extents) -> bool {
    matches!(extents, Extents::Density | Extents::Gradient)
}

/// What stands before every stage.
pub(crate) const PRELUDE: [&str; 4] = [INT64, COMMON, NUM, FIXED];

/// One stage's source and, after parameters and tables, its bindings.
pub(crate) struct Source {
    pub(crate) name: &'static str,
    pub(crate) parts: &'static [&'static str],
    pub(crate) bindings: &'static [Access],
}

macro_rules! source {
    ($name:ident, [$($part:expr),*], $bindings:expr) => {
        pub(crate) const $name: Source = Source {
            name: concat!("twin/", stringify!($name)),
            parts: &[$($part),*],
            bindings: &$bindings,
        };
    };
}

/// The source of one shader file.
macro_rules! file {
    ($name:literal) => {
        include_str!(concat!("shaders/", $name, ".wgsl"))
    };
}

/// What [`SORT`], [`AVERAGE`] and [`ENCODE`] know of codes.
const SRGB: &str = file!("srgb");

source!(
    PROJECT,
    [file!("project")],
    [Read, Write, Read, Read, Write]
);
source!(FAR, [file!("far")], [Write]);
source!(NEAREST, [file!("nearest")], [Read, Read, Write]);
source!(COARSER, [LEVEL, file!("coarser")], [Uniform, Write]);
source!(LIMITS, [file!("limits")], [Read, Write]);
source!(
    MARK_MOVERS,
    [file!("mark_movers")],
    [Read, Read, Read, Write]
);
source!(
    DROP_HIDDEN,
    [file!("drop_hidden")],
    [Read, Write, Read, Read, Read, Read, Write]
);
source!(
    SCAN_BLOCKS,
    [file!("scan_blocks")],
    [Uniform, Read, Write, Write]
);
source!(SCAN_SUMS, [file!("scan_sums")], [Uniform, Write, Write]);
source!(SCAN_ADD, [file!("scan_add")], [Uniform, Write, Read]);
source!(
    SORT,
    [SRGB, file!("light"), file!("sort")],
    [Read, Read, Read, Read, Write, Write, Read]
);
source!(MASSES, [file!("masses")], [Read, Read, Write]);
source!(WIDTHS, [file!("widths")], [Read, Write]);
source!(
    FOOTPRINTS,
    [file!("footprints")],
    [Read, Read, Read, Write, Write]
);
source!(ROWS, [file!("rows")], [Read, Write]);
source!(
    GATHER_MEANS,
    ["const PLANES: bool = false;", file!("gather")],
    [Read, Read, Read, Read, Write, Write, Write, Uniform]
);
source!(
    GATHER_PLANES,
    ["const PLANES: bool = true;", file!("gather")],
    [Read, Read, Read, Read, Write, Write, Write, Uniform]
);
source!(MEANS, [TEXEL, file!("means")], [Read, Write]);
source!(PLANES, [TEXEL, file!("planes")], [Read, Read, Write]);
source!(PULL, [TEXEL, LEVEL, file!("pull")], [Uniform, Write]);
source!(PUSH, [TEXEL, LEVEL, file!("push")], [Uniform, Write]);
/// What [`REST`], [`AVERAGE`] and [`ENCODE`] know of a mean.
const MEAN: &str = file!("mean");

source!(REST, [MEAN, file!("rest")], [Read, Write]);
source!(
    AVERAGE,
    [MEAN, SRGB, file!("light"), file!("average")],
    [Uniform, Read, Read, Read, Write, Read]
);
source!(
    ENCODE,
    [TEXEL, MEAN, SRGB, file!("encode")],
    [Read, Write, Read]
);
source!(PLACE, [file!("place")], [Uniform, Write, Read, Write]);
source!(
    STORE,
    [file!("store")],
    [Uniform, Read, Read, Read, Read, Write]
);
source!(ADVANCE, [file!("advance")], [Uniform, Read, Write]);
source!(CLAIM, [file!("claim")], [Uniform, Read, Read, Write]);
source!(SHOW, [file!("show")], [Read, Read, Write]);

/// Every stage there is.
#[cfg(test)]
pub(crate) const ALL: [&Source; 29] = [
    &PROJECT,
    &FAR,
    &NEAREST,
    &COARSER,
    &LIMITS,
    &MARK_MOVERS,
    &DROP_HIDDEN,
    &SCAN_BLOCKS,
    &SCAN_SUMS,
    &SCAN_ADD,
    &SORT,
    &MASSES,
    &WIDTHS,
    &FOOTPRINTS,
    &ROWS,
    &GATHER_MEANS,
    &GATHER_PLANES,
    &MEANS,
    &PLANES,
    &PULL,
    &PUSH,
    &REST,
    &AVERAGE,
    &ENCODE,
    &PLACE,
    &STORE,
    &ADVANCE,
    &CLAIM,
    &SHOW,
];

impl Source {
    /// All of it, as it is compiled.
    pub(crate) fn whole(&self) -> Vec<&'static str> {
        PRELUDE.iter().chain(self.parts).copied().collect()
    }

    fn compile(&self, gpu: &Gpu) -> Result<Stage, GpuError> {
        let bindings: Vec<Access> = [Uniform, Read]
            .iter()
            .chain(self.bindings)
            .copied()
            .collect();
        Stage::new(gpu, self.name, &self.whole(), &bindings)
    }
}

/// The prefix sum.
#[derive(Debug)]
pub(crate) struct Scan {
    pub(crate) blocks: Stage,
    pub(crate) sums: Stage,
    pub(crate) add: Stage,
}

/// What samples go through that stay where they fell.
#[derive(Debug)]
pub(crate) struct Arrival {
    pub(crate) place: Stage,
    pub(crate) advance: Stage,
    /// Into the ring, with space-time filtering.
    pub(crate) store: Option<Stage>,
    /// Onto the picture, without.
    pub(crate) newest: Option<(Stage, Stage)>,
}

/// The hidden-point test.
#[derive(Debug)]
pub(crate) struct Hidden {
    pub(crate) far: Stage,
    pub(crate) nearest: Stage,
    pub(crate) coarser: Stage,
    pub(crate) limits: Stage,
    pub(crate) mark_movers: Stage,
}

/// Filter widths by density.
#[derive(Debug)]
pub(crate) struct Density {
    pub(crate) masses: Stage,
    pub(crate) widths: Stage,
}

/// Footprints that differ between samples.
#[derive(Debug)]
pub(crate) struct Varying {
    pub(crate) footprints: Stage,
    pub(crate) rows: Stage,
}

/// Hole filling.
#[derive(Debug)]
pub(crate) struct Fill {
    pub(crate) pull: Stage,
    pub(crate) push: Stage,
}

/// Averaging what rests.
#[derive(Debug)]
pub(crate) struct Rest {
    pub(crate) rest: Stage,
    pub(crate) average: Stage,
}

/// What a refresh with space-time filtering goes through.
#[derive(Debug)]
pub(crate) struct Refreshing {
    pub(crate) project: Stage,
    pub(crate) hidden: Option<Hidden>,
    pub(crate) drop_hidden: Stage,
    pub(crate) sort: Stage,
    pub(crate) density: Option<Density>,
    pub(crate) varying: Option<Varying>,
    pub(crate) gather: Stage,
    /// Whether planes are solved, from moments.
    pub(crate) planes: bool,
    pub(crate) solve: Stage,
    pub(crate) fill: Option<Fill>,
    pub(crate) rest: Option<Rest>,
    pub(crate) encode: Stage,
}

/// The stages that a configuration calls for.
#[derive(Debug)]
pub(crate) struct Stages {
    pub(crate) scan: Scan,
    /// `None` where all samples are reprojected at each refresh.
    pub(crate) arrival: Option<Arrival>,
    /// `None` where the picture shows the newest samples.
    pub(crate) refreshing: Option<Refreshing>,
}

impl Stages {
    pub(crate) fn new(gpu: &Gpu, config: &Config) -> Result<Stages, GpuError> {
        let newest = config.mode == Mode::Newest;
        let compile = |source: &Source| source.compile(gpu);
        let arrival = (newest || !config.reproject).then(|| {
            Ok(Arrival {
                place: compile(&PLACE)?,
                advance: compile(&ADVANCE)?,
                store: (!newest).then(|| compile(&STORE)).transpose()?,
                newest: newest
                    .then(|| Ok((compile(&CLAIM)?, compile(&SHOW)?)))
                    .transpose()?,
            })
        });
        let refreshing = (!newest).then(|| Refreshing::new(gpu, config));
        Ok(Stages {
            scan: Scan {
                blocks: compile(&SCAN_BLOCKS)?,
                sums: compile(&SCAN_SUMS)?,
                add: compile(&SCAN_ADD)?,
            },
            arrival: arrival.transpose()?,
            refreshing: refreshing.transpose()?,
        })
    }
}

impl Refreshing {
    fn new(gpu: &Gpu, config: &Config) -> Result<Refreshing, GpuError> {
        let compile = |source: &Source| source.compile(gpu);
        let hidden = config.hidden.then(|| {
            Ok(Hidden {
                far: compile(&FAR)?,
                nearest: compile(&NEAREST)?,
                coarser: compile(&COARSER)?,
                limits: compile(&LIMITS)?,
                mark_movers: compile(&MARK_MOVERS)?,
            })
        });
        let density = (config.extents == Extents::Density).then(|| {
            Ok(Density {
                masses: compile(&MASSES)?,
                widths: compile(&WIDTHS)?,
            })
        });
        let varying = varies(config.extents).then(|| {
            Ok(Varying {
                footprints: compile(&FOOTPRINTS)?,
                rows: compile(&ROWS)?,
            })
        });
        let fill = config.fill.then(|| {
            Ok(Fill {
                pull: compile(&PULL)?,
                push: compile(&PUSH)?,
            })
        });
        let rest = config.averages().then(|| {
            Ok(Rest {
                rest: compile(&REST)?,
                average: compile(&AVERAGE)?,
            })
        });
        let (gather, solve) = match config.fit {
            Fit::Constant => (GATHER_MEANS, MEANS),
            Fit::Linear => (GATHER_PLANES, PLANES),
        };
        Ok(Refreshing {
            project: compile(&PROJECT)?,
            hidden: hidden.transpose()?,
            drop_hidden: compile(&DROP_HIDDEN)?,
            sort: compile(&SORT)?,
            density: density.transpose()?,
            varying: varying.transpose()?,
            gather: compile(&gather)?,
            planes: config.fit == Fit::Linear,
            solve: compile(&solve)?,
            fill: fill.transpose()?,
            rest: rest.transpose()?,
            encode: compile(&ENCODE)?,
        })
    }
}
