//! What a display needs to keep, over storage that the caller owns.
//!
//! With W × H pixels, N samples and O objects the fixed-point display keeps, in bytes:
//!
//! | what | bytes | called for by |
//! |---|---|---|
//! | deep buffer | 16 N | |
//! | projected samples | 12 N, and 12 N more where they are sorted | all but [`crate::own`] |
//! | minima, limits and movers | 5.625 W H | the hidden-point test |
//! | masses | 4 W H | that test, widths by density |
//! | lifetimes, then widths | 2 W H | |
//! | sums | 32 W H | |
//! | moments | 96 W H | planes |
//! | texels with their pyramid | 8 · 4/3 W H | |
//! | means at rest | 16 W H | [`Config::rest`] |
//! | picture | 3 W H | |
//! | tile map | 5 W H / 16 | |
//! | poses and their transforms | 240 O | |
//! | triangles, texels, ways to lamps, windows | 20, 2, 96 O, 24 · 64 | [`crate::light::Memory`], not empty |

use crate::arith::{Aligned, Arith, Moments, Panel, Projected, Sums, Texel};
use crate::bins::Grid;
use crate::config::{Config, Extents};
use crate::deep::Stored;
use crate::fill::pyramid_len;
use crate::hidden::minima_len;
use crate::light;
use crate::motion::Past;
use crate::own;
use crate::rest::Mean;
use crate::tiles::{Cell, cells_along};
use unframed_wire::Pose;

/// One object's pose and what it becomes under the view.
#[derive(Clone, Copy, Debug)]
pub struct Slot<A: Arith> {
    /// The newest pose received.
    pub pose: Option<Pose>,
    /// The pose at the last refresh.
    pub shown: Option<Pose>,
    /// View and pose composed.
    pub transform: Option<A::Transform>,
}

impl<A: Arith> Default for Slot<A> {
    fn default() -> Self {
        Self {
            pose: None,
            shown: None,
            transform: None,
        }
    }
}

/// How long each slice of a [`Memory`] must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// W·H: logs, sums, texels, picture, and what [`Calls`] says.
    pub pixels: usize,
    /// Levels of minima.
    pub minima: usize,
    /// Coarser texels.
    pub pyramid: usize,
    /// Tile cells.
    pub cells: usize,
    /// For each worker: where the samples of each tile of [`crate::bins::Grid`] start. Used only
    /// where samples are sorted.
    pub starts: usize,
}

impl Needs {
    /// What a panel of this size needs.
    #[must_use]
    pub const fn of(width: u16, height: u16) -> Self {
        Self {
            pixels: width as usize * height as usize,
            minima: minima_len(width, height),
            pyramid: pyramid_len(width, height),
            cells: cells_along(width) * cells_along(height),
            starts: Grid::new(width, height).tiles() + 1,
        }
    }
}

/// How long those slices of a [`Memory`] must be that not every configuration calls for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calls {
    /// Projected samples, where none are sorted.
    pub projected: usize,
    /// Levels of minima.
    pub minima: usize,
    /// Limits and movers.
    pub hidden: usize,
    /// Masses.
    pub mass: usize,
    /// Moments.
    pub moments: usize,
    /// Means.
    pub means: usize,
}

impl Calls {
    /// What `config` calls for where `samples` are remembered.
    #[must_use]
    pub const fn of(config: &Config, needs: &Needs, samples: usize) -> Self {
        const fn only(called_for: bool, entries: usize) -> usize {
            if called_for { entries } else { 0 }
        }
        let density = matches!(config.extents, Extents::Density);
        Self {
            projected: only(!own::applies(config), samples),
            minima: only(config.hidden, needs.minima),
            hidden: only(config.hidden, needs.pixels),
            mass: only(config.hidden || density, needs.pixels),
            moments: only(config.planes(), needs.pixels),
            means: only(config.averages(), needs.pixels),
        }
    }
}

/// The storage of a display: slices of any origin, at least as long as [`Needs`] says.
#[derive(Debug)]
pub struct Memory<'a, A: Arith> {
    /// The deep buffer: as many samples as are to be remembered, at best 4 a pixel and more.
    pub samples: &'a mut [Stored],
    /// See [`Calls::projected`]; as long as `samples` where they are sorted.
    pub projected: &'a mut [Projected<A>],
    /// As long as `samples`, or empty: then samples are not sorted by tile, which costs time on
    /// machines with caches and keeps the work on one thread.
    pub sorted: &'a mut [Projected<A>],
    /// See [`Needs::starts`]: twice that a thread (fewer divide the work less evenly); 2 where
    /// nothing is sorted.
    pub starts: &'a mut [u32],
    /// See [`Calls::minima`].
    pub minima: &'a mut [A::Depth],
    /// See [`Calls::hidden`].
    pub limits: &'a mut [A::Depth],
    /// See [`Calls::hidden`].
    pub movers: &'a mut [u8],
    /// See [`Calls::mass`].
    pub mass: &'a mut [A::Mass],
    /// See [`Needs::pixels`].
    pub logs: &'a mut [A::Log],
    /// See [`Needs::pixels`].
    pub sums: &'a mut [Sums<A>],
    /// See [`Calls::moments`].
    pub moments: &'a mut [Moments<A>],
    /// See [`Needs::pixels`].
    pub texels: &'a mut [Texel<A>],
    /// See [`Needs::pyramid`].
    pub pyramid: &'a mut [Texel<A>],
    /// See [`Calls::means`].
    pub means: &'a mut [Mean],
    /// See [`Needs::cells`].
    pub cells: &'a mut [Cell],
    /// The sky's and as many objects' as are to be known, at most 256.
    pub slots: &'a mut [Slot<A>],
    /// See [`Needs::pixels`].
    pub picture: &'a mut [[u8; 3]],
    /// For lamps, or empty: then samples are shown as they come.
    pub light: light::Memory<'a>,
}

/// Why a display could not be set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupError {
    /// Width or height is 0 or beyond [`Panel::LIMIT`].
    Panel,
    /// The named slice is shorter than it must be.
    Short {
        /// Field of [`Memory`].
        slice: &'static str,
        /// Entries needed.
        needs: usize,
        /// Entries there.
        has: usize,
    },
}

impl core::fmt::Display for SetupError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Panel => {
                write!(
                    f,
                    "a panel's width and height must be 1 to {} pixels",
                    Panel::LIMIT
                )
            }
            Self::Short { slice, needs, has } => {
                write!(
                    f,
                    "display memory: `{slice}` has {has} entries and needs {needs}"
                )
            }
        }
    }
}

impl core::error::Error for SetupError {}

impl<A: Arith> Memory<'_, A> {
    /// Checks every length.
    ///
    /// # Errors
    /// Names the first slice that is too short.
    pub fn check(&self, width: u16, height: u16, config: &Config) -> Result<(), SetupError> {
        let needs = Needs::of(width, height);
        let samples = self.samples.len();
        let calls = Calls::of(config, &needs, samples);
        let (sorted, projected, starts) = if self.sorted.is_empty() {
            (0, calls.projected, 2)
        } else {
            (samples, samples, needs.starts)
        };
        let checks = [
            ("projected", projected, self.projected.len()),
            ("sorted", sorted, self.sorted.len()),
            ("starts", starts, self.starts.len()),
            ("minima", calls.minima, self.minima.len()),
            ("limits", calls.hidden, self.limits.len()),
            ("movers", calls.hidden, self.movers.len()),
            ("mass", calls.mass, self.mass.len()),
            ("logs", needs.pixels, self.logs.len()),
            ("sums", needs.pixels, self.sums.len()),
            ("moments", calls.moments, self.moments.len()),
            ("texels", needs.pixels, self.texels.len()),
            ("pyramid", needs.pyramid, self.pyramid.len()),
            ("means", calls.means, self.means.len()),
            ("cells", needs.cells, self.cells.len()),
            ("slots", 2, self.slots.len()),
            ("picture", needs.pixels, self.picture.len()),
        ];
        for (slice, needs, has) in checks {
            if has < needs {
                return Err(SetupError::Short { slice, needs, has });
            }
        }
        Ok(())
    }
}

/// Storage of fixed capacity, to be placed in a `static` or on a large stack. Samples are not
/// sorted.
///
/// `N` samples, `P` pixels, `Y` pyramid texels, `C` cells, `O` slots ([`Needs::of`] gives them in a
/// `const`); `J` projected samples, `M` minima, `H` limits and movers, `D` masses, `L` moments, `R` means
/// ([`Calls::of`]).
#[derive(Debug)]
pub struct Storage<
    A: Arith,
    const N: usize,
    const P: usize,
    const Y: usize,
    const C: usize,
    const O: usize,
    const J: usize,
    const M: usize,
    const H: usize,
    const D: usize,
    const L: usize,
    const R: usize,
> {
    samples: [Stored; N],
    projected: [Projected<A>; J],
    starts: [u32; 2],
    minima: [A::Depth; M],
    limits: [A::Depth; H],
    movers: [u8; H],
    mass: [A::Mass; D],
    logs: [A::Log; P],
    sums: [Sums<A>; P],
    moments: [Moments<A>; L],
    texels: [Texel<A>; P],
    pyramid: [Texel<A>; Y],
    means: [Mean; R],
    cells: [Cell; C],
    slots: [Slot<A>; O],
    picture: [[u8; 3]; P],
}

impl<
    A: Arith,
    const N: usize,
    const P: usize,
    const Y: usize,
    const C: usize,
    const O: usize,
    const J: usize,
    const M: usize,
    const H: usize,
    const D: usize,
    const L: usize,
    const R: usize,
> Storage<A, N, P, Y, C, O, J, M, H, D, L, R>
{
    /// The storage as a display takes it.
    pub fn memory(&mut self) -> Memory<'_, A> {
        Memory {
            samples: &mut self.samples,
            projected: &mut self.projected,
            sorted: &mut [],
            starts: &mut self.starts,
            minima: &mut self.minima,
            limits: &mut self.limits,
            movers: &mut self.movers,
            mass: &mut self.mass,
            logs: &mut self.logs,
            sums: &mut self.sums,
            moments: &mut self.moments,
            texels: &mut self.texels,
            pyramid: &mut self.pyramid,
            means: &mut self.means,
            cells: &mut self.cells,
            slots: &mut self.slots,
            picture: &mut self.picture,
            light: light::Memory::default(),
        }
    }
}

/// Empty storage as a constant whose bytes are all zero, so that a `static` of it costs RAM and no
/// flash; [`crate::Display::new`] gives what must not be zero its first value.
macro_rules! empty_storage {
    ($arith:ty, $zero:literal) => {
        impl<
            const N: usize,
            const P: usize,
            const Y: usize,
            const C: usize,
            const O: usize,
            const J: usize,
            const M: usize,
            const H: usize,
            const D: usize,
            const L: usize,
            const R: usize,
        > Storage<$arith, N, P, Y, C, O, J, M, H, D, L, R>
        {
            /// Empty storage.
            #[must_use]
            pub const fn new() -> Self {
                let texel = Texel {
                    light: [$zero; 3],
                    confidence: $zero,
                };
                Self {
                    samples: [Stored::EMPTY; N],
                    projected: [Projected {
                        x: $zero,
                        y: $zero,
                        depth: $zero,
                        weight: $zero,
                        rgb: [0; 3],
                        past: Past::NONE,
                    }; J],
                    starts: [0; 2],
                    minima: [$zero; M],
                    limits: [$zero; H],
                    movers: [0; H],
                    mass: [$zero; D],
                    logs: [$zero; P],
                    sums: [Aligned([$zero; 4]); P],
                    moments: [Aligned([$zero; 12]); L],
                    texels: [texel; P],
                    pyramid: [texel; Y],
                    means: [Mean::EMPTY; R],
                    cells: [Cell::ZERO; C],
                    slots: [Slot {
                        pose: None,
                        shown: None,
                        transform: None,
                    }; O],
                    picture: [[0; 3]; P],
                }
            }
        }

        impl<
            const N: usize,
            const P: usize,
            const Y: usize,
            const C: usize,
            const O: usize,
            const J: usize,
            const M: usize,
            const H: usize,
            const D: usize,
            const L: usize,
            const R: usize,
        > Default for Storage<$arith, N, P, Y, C, O, J, M, H, D, L, R>
        {
            fn default() -> Self {
                Self::new()
            }
        }
    };
}

empty_storage!(crate::fixed::Fixed, 0);
#[cfg(feature = "float")]
empty_storage!(f32, 0.0);
