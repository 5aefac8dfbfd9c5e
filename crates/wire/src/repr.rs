//! The meaning of each packet, in plain types: validated, host byte order, no layout.
//!
//! All coordinates are integers, so that every display computes the same picture:
//!
//! - **World units**: the host divides the scene by a unit of its choice ([`WorldFrame::unit`]
//!   metres) such that the static world lies within ±2^23 units; `i32` holds any place.
//! - **Lattice**: a sample's place is three `i16` in the lattice of its object; the object's
//!   [`Pose`] maps the lattice to world units. Object 0 is the static world, [`SKY`] is the sky
//!   (its pose follows the eye), the others move.
//! - **Ticks**: microseconds modulo 2^32 ([`Tick`]); compare them by serial-number arithmetic.
//! - **Log codes**: positive quantities on the tiles are one byte, see [`LogCode`].

/// The object id of samples that hit nothing: places are directions, the pose follows the eye.
pub const SKY: u8 = 255;

/// The most lamps of whose light the samples of a stream tell the shares.
pub const LAMPS: usize = 2;

/// A time in microseconds modulo 2^32 (wraps after 71.6 minutes).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Tick(pub u32);

impl Tick {
    /// `self − earlier` in microseconds, in −2^31..2^31, by serial-number arithmetic (RFC 1982).
    #[must_use]
    pub const fn since(self, earlier: Tick) -> i32 {
        self.0.wrapping_sub(earlier.0) as i32
    }

    /// The tick `micros` later, modulo 2^32.
    #[must_use]
    pub const fn after(self, micros: u32) -> Tick {
        Tick(self.0.wrapping_add(micros))
    }
}

/// How the place of a sample is coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Places are screen coordinates at the sample's instant: nothing can be reprojected.
    Screen,
    /// Places are object-local lattice points: the display reprojects to the refresh instant.
    World,
}

/// How the colour bytes of samples encode light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColourEncoding {
    /// IEC 61966-2-1 sRGB, 8 bits a channel.
    Srgb8,
}

/// Where the lattice of the static world lies in the author's coordinates. For tools that want
/// metres: nothing that the display computes depends on it.
#[derive(Clone, Copy, Debug)]
pub struct WorldFrame {
    /// The author's coordinates of the world-unit origin, metres.
    pub origin: [f32; 3],
    /// Metres in one world unit; finite and positive.
    pub unit: f32,
}

/// Equal are frames of the same bits: a display compares Hellos, and does so without floats.
impl PartialEq for WorldFrame {
    fn eq(&self, other: &Self) -> bool {
        self.unit.to_bits() == other.unit.to_bits()
            && self.origin.map(f32::to_bits) == other.origin.map(f32::to_bits)
    }
}

/// What the stream carries; repeated, so that a receiver can join at any time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hello {
    /// Panel width in pixels, 1..=4096.
    pub width: u16,
    /// Panel height in pixels, 1..=4096.
    pub height: u16,
    /// How places are coded in every Samples packet of the stream.
    pub layout: Layout,
    /// Whether samples carry object ids (without: all are object 0).
    pub objects: bool,
    /// Which fields the tiles of the stream carry.
    pub tile_fields: TileFields,
    /// How the colour bytes encode light.
    pub encoding: ColourEncoding,
    /// Nominal samples a second; 1 or more.
    pub rate: u32,
    /// Nominal refreshes in 1000 seconds (60 Hz is 60_000); 1 or more.
    pub refresh_millihertz: u32,
    /// Where the world units lie.
    pub world: WorldFrame,
    /// Of how many lamps samples tell the [`Shares`], 0..=[`LAMPS`]; 0 unless the layout is
    /// [`Layout::World`].
    pub lamps: u8,
}

/// The camera at an instant: maps world units to pixels.
///
/// With `d = p − eye` (world units) and `r_k = Σ_j rows[k][j]·d_j`, a point is seen at pixel
/// coordinates `x = r_0/r_2`, `y = r_1/r_2` (origin at the top left corner of the panel, pixel
/// centres at halves) when its depth `r_2/2^frac_bits` (world units along the axis) is positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// The instant at which this is the view.
    pub time: Tick,
    /// The eye, world units.
    pub eye: [i32; 3],
    /// Rows for x·depth, y·depth and depth, with `frac_bits` fractional bits.
    pub rows: [[i32; 3]; 3],
    /// Fractional bits of `rows`, 0..=30.
    pub frac_bits: u8,
}

/// The transform of an object at an instant: lattice to world units.
///
/// `world_k = translation_k + (Σ_j matrix[k][j]·q_j) / 2^frac_bits`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pose {
    /// Which object; 0 is the static world.
    pub object: u8,
    /// Lattice steps to world units, with `frac_bits` fractional bits.
    pub matrix: [[i32; 3]; 3],
    /// Fractional bits of `matrix`, 0..=31.
    pub frac_bits: u8,
    /// World units of the lattice's origin.
    pub translation: [i32; 3],
}

/// What kind of light a [`Lamp`] gives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LampKind {
    /// From one point.
    #[default]
    Point,
    /// Parallel, from infinitely far away.
    Directional,
}

/// A lamp at an instant: where its shadows fall from, and the hue of what they take away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Lamp {
    /// What kind of light it gives.
    pub kind: LampKind,
    /// Of a point lamp its place in world units, each within ±2^29; of a directional one the
    /// direction *towards* the light times 2^30, each within ±2^30 and not all zero.
    pub place: [i32; 3],
    /// By how much more of red and of blue than of green it brings, compared with all other
    /// light of the scene: 8 fractional bits, 1 or more.
    pub tint: [u16; 2],
}

impl Lamp {
    /// Largest distance of a point lamp from the origin along an axis, world units.
    pub const MAX_PLACE: i32 = 1 << 29;

    /// What stands for 1 in a direction.
    pub const UNIT: i32 = 1 << 30;

    /// Whether every field is in the range that its documentation states.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let within = |edge: i32| self.place.iter().all(|c| (-edge..=edge).contains(c));
        let placed = match self.kind {
            LampKind::Point => within(Self::MAX_PLACE),
            LampKind::Directional => within(Self::UNIT) && self.place != [0; 3],
        };
        placed && !self.tint.contains(&0)
    }
}

/// How much of a sample's light comes from each lamp, in a code of 4 bits each: lamp `l` in bits
/// `4l..4l + 4`.
///
/// Code `c` says that without the lamp the sample would have `((15 − c)/15)²` of its light (0:
/// the lamp brings nothing; 15: it brings all), which are steps that look alike. The sample shows
/// its surface as if no other moving object stood before the lamps: a display that knows where
/// they stand takes the light away itself. Codes of lamps that the stream does not have are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Shares(pub u8);

impl Shares {
    /// The largest code.
    pub const MAX: u8 = 15;

    /// The codes of all lamps; of each its low 4 bits.
    #[must_use]
    pub const fn new(codes: [u8; LAMPS]) -> Self {
        let [first, second] = codes;
        Shares((first & Self::MAX) | (second & Self::MAX) << 4)
    }

    /// The code of a lamp, 0..=15; 0 of a lamp beyond [`LAMPS`].
    #[must_use]
    pub const fn code(self, lamp: usize) -> u8 {
        if lamp < LAMPS {
            self.0 >> (4 * lamp) & Self::MAX
        } else {
            0
        }
    }
}

/// A sample that can be reprojected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct WorldSample {
    /// Lattice point in its object.
    pub place: [i16; 3],
    /// Red, green, blue in the stream's encoding.
    pub rgb: [u8; 3],
    /// Object id; 0 the static world, [`SKY`] the sky.
    pub object: u8,
    /// What the lamps bring of its light.
    pub shares: Shares,
}

/// A sample on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ScreenSample {
    /// x in 1/16 pixel from the left edge, below 16·width.
    pub x: u16,
    /// y in 1/16 pixel from the top edge, below 16·height.
    pub y: u16,
    /// Red, green, blue in the stream's encoding.
    pub rgb: [u8; 3],
}

/// A positive quantity in one byte: code `c` means `2^((c − 128)/8)`, so 1.5e-5 to 6.0e4 in
/// steps of 9 %. Code 0 also stands for zero and anything below, 255 for infinity and anything
/// above: in the log domain both are ordinary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LogCode(pub u8);

impl LogCode {
    /// log2 of the quantity with 8 fractional bits.
    #[must_use]
    pub const fn log2_q8(self) -> i32 {
        (self.0 as i32 - 128) * 32
    }
}

/// A rectangle of pixels: `x..x+w`, `y..y+h`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Rect {
    /// Left edge, pixels.
    pub x: u16,
    /// Top edge, pixels.
    pub y: u16,
    /// Width, pixels.
    pub w: u16,
    /// Height, pixels.
    pub h: u16,
}

/// Which quantities the tiles of a stream carry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct TileFields {
    /// Spatial and temporal gradients (Dayal 2005 §4.1).
    pub gradients: bool,
    /// Lifetime along reprojected hits.
    pub lifetime: bool,
    /// Sampling density.
    pub density: bool,
}

/// One leaf of the k-d cut. Fields that the stream does not carry are `LogCode(128)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Tile {
    /// The pixels it covers.
    pub rect: Rect,
    /// Mean |dL/dx|, luminance (0..1) a pixel.
    pub gx: LogCode,
    /// Mean |dL/dy|, luminance (0..1) a pixel.
    pub gy: LogCode,
    /// Mean |dL/dt|, luminance (0..1) a second.
    pub gt: LogCode,
    /// How long a sample stays true, seconds.
    pub lifetime: LogCode,
    /// Samples a pixel and second.
    pub density: LogCode,
}

/// The display shall show a picture of this instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refresh {
    /// The instant to show.
    pub time: Tick,
    /// Counts refreshes from 0, modulo 2^32.
    pub index: u32,
}

/// The last packet: what was sent before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct End {
    /// When the stream ended.
    pub time: Tick,
    /// Samples sent.
    pub samples: u64,
    /// Packets sent, this one not counted.
    pub packets: u64,
}

/// Display to host: how the link is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// The instant of the newest refresh shown.
    pub refresh_time: Tick,
    /// Good packets received.
    pub received: u32,
    /// Packets missing by their sequence numbers.
    pub lost: u32,
    /// Frames thrown away: bad framing, check or contents.
    pub damaged: u32,
    /// Samples in the display's deep buffer.
    pub buffered: u32,
}
