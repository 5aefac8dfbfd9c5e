//! The kinds of packets and the view of one received packet.

use crate::fixed::{self, IndexBlock, Lamps, Poses, Shape, Trailer};
use crate::receiver::Damage;
use crate::repr::*;
use crate::samples::{ScreenSamples, WorldSamples};
use crate::tiles::Tiles;

/// The kind of a packet; its type byte on the wire is its discriminant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Kind {
    /// [`Packet::Hello`]
    Hello = 1,
    /// [`Packet::View`]
    View = 2,
    /// [`Packet::Poses`]
    Poses = 3,
    /// [`Packet::Tiles`]
    Tiles = 4,
    /// [`Packet::World`]
    World = 5,
    /// [`Packet::Screen`]
    Screen = 6,
    /// [`Packet::Refresh`]
    Refresh = 7,
    /// [`Packet::Cut`]
    Cut = 8,
    /// [`Packet::End`]
    End = 9,
    /// [`Packet::Status`]
    Status = 10,
    /// [`Packet::Index`]
    Index = 11,
    /// [`Packet::Trailer`]
    Trailer = 12,
    /// [`Packet::Lamps`]
    Lamps = 13,
    /// [`Packet::Shape`]
    Shape = 14,
}

impl Kind {
    /// All kinds, in the order of their type bytes from 1.
    pub const ALL: [Kind; 14] = [
        Kind::Hello,
        Kind::View,
        Kind::Poses,
        Kind::Tiles,
        Kind::World,
        Kind::Screen,
        Kind::Refresh,
        Kind::Cut,
        Kind::End,
        Kind::Status,
        Kind::Index,
        Kind::Trailer,
        Kind::Lamps,
        Kind::Shape,
    ];

    /// Position in [`Kind::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize - 1
    }

    /// A lower-case name for reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Hello => "hello",
            Kind::View => "view",
            Kind::Poses => "poses",
            Kind::Tiles => "tiles",
            Kind::World => "world",
            Kind::Screen => "screen",
            Kind::Refresh => "refresh",
            Kind::Cut => "cut",
            Kind::End => "end",
            Kind::Status => "status",
            Kind::Index => "index",
            Kind::Trailer => "trailer",
            Kind::Lamps => "lamps",
            Kind::Shape => "shape",
        }
    }

    pub(crate) fn from_byte(byte: u8) -> Option<Kind> {
        Kind::ALL.get(usize::from(byte).checked_sub(1)?).copied()
    }

    /// Whether the packet can be understood without a Hello.
    pub(crate) const fn stands_alone(self) -> bool {
        matches!(
            self,
            Kind::Hello | Kind::End | Kind::Status | Kind::Index | Kind::Trailer
        )
    }
}

/// One good packet, borrowed from the receiver. Fixed contents are validated; [`Tiles`],
/// [`WorldSamples`] and [`ScreenSamples`] decode as they are iterated, yield only values in range
/// and stop early if the sender packed them wrongly.
#[derive(Clone, Debug)]
pub enum Packet<'a> {
    /// What the stream carries.
    Hello(Hello),
    /// The camera at an instant.
    View(View),
    /// The transforms of objects at an instant.
    Poses(Poses<'a>),
    /// A part of the k-d cut.
    Tiles(Tiles<'a>),
    /// Samples with lattice places.
    World(WorldSamples<'a>),
    /// Samples with screen places.
    Screen(ScreenSamples<'a>),
    /// Show a picture of this instant.
    Refresh(Refresh),
    /// The scene changed wholly at this instant: what was before is worth nothing.
    Cut(Tick),
    /// The stream is over.
    End(End),
    /// Display to host.
    Status(Status),
    /// A part of the index of a recording.
    Index(IndexBlock<'a>),
    /// The end of an indexed recording.
    Trailer(Trailer),
    /// The lamps at an instant.
    Lamps(Lamps<'a>),
    /// A part of the surface of an object that throws shadows.
    Shape(Shape<'a>),
}

impl<'a> Packet<'a> {
    /// The packet's kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Packet::Hello(_) => Kind::Hello,
            Packet::View(_) => Kind::View,
            Packet::Poses(_) => Kind::Poses,
            Packet::Tiles(_) => Kind::Tiles,
            Packet::World(_) => Kind::World,
            Packet::Screen(_) => Kind::Screen,
            Packet::Refresh(_) => Kind::Refresh,
            Packet::Cut(_) => Kind::Cut,
            Packet::End(_) => Kind::End,
            Packet::Status(_) => Kind::Status,
            Packet::Index(_) => Kind::Index,
            Packet::Trailer(_) => Kind::Trailer,
            Packet::Lamps(_) => Kind::Lamps,
            Packet::Shape(_) => Kind::Shape,
        }
    }

    /// The instant that the packet is about, where it has one.
    #[must_use]
    pub fn time(&self) -> Option<Tick> {
        match self {
            Packet::View(view) => Some(view.time),
            Packet::Poses(poses) => Some(poses.time()),
            Packet::Tiles(tiles) => Some(tiles.time()),
            Packet::World(samples) => Some(samples.time()),
            Packet::Screen(samples) => Some(samples.time()),
            Packet::Refresh(refresh) => Some(refresh.time),
            Packet::Cut(time) => Some(*time),
            Packet::End(end) => Some(end.time),
            Packet::Lamps(lamps) => Some(lamps.time()),
            Packet::Hello(_)
            | Packet::Status(_)
            | Packet::Index(_)
            | Packet::Trailer(_)
            | Packet::Shape(_) => None,
        }
    }

    /// Parses the payload of a packet whose CRC was right. `hello` says what the stream carries;
    /// only kinds that stand alone may come before it.
    pub(crate) fn parse(
        kind: Kind,
        payload: &'a [u8],
        hello: Option<&Hello>,
    ) -> Result<Self, Damage> {
        if kind == Kind::Hello {
            return fixed::get_hello(payload).map(Packet::Hello);
        }
        Self::parse_body(kind, payload, hello).ok_or(Damage::Contents)
    }

    fn parse_body(kind: Kind, payload: &'a [u8], hello: Option<&Hello>) -> Option<Self> {
        Some(match kind {
            Kind::Hello => Packet::Hello(fixed::get_hello(payload).ok()?),
            Kind::View => Packet::View(fixed::get_view(payload)?),
            Kind::Poses => Packet::Poses(Poses::parse(payload)?),
            Kind::Tiles => {
                let hello = hello?;
                Packet::Tiles(Tiles::parse(payload, hello.width, hello.height)?)
            }
            Kind::World => {
                let hello = hello.filter(|h| h.layout == Layout::World)?;
                Packet::World(WorldSamples::parse(payload, hello.objects, hello.lamps)?)
            }
            Kind::Screen => {
                let hello = hello.filter(|h| h.layout == Layout::Screen)?;
                Packet::Screen(ScreenSamples::parse(payload, hello.width, hello.height)?)
            }
            Kind::Refresh => Packet::Refresh(fixed::get_refresh(payload)?),
            Kind::Cut => Packet::Cut(fixed::get_cut(payload)?),
            Kind::End => Packet::End(fixed::get_end(payload)?),
            Kind::Status => Packet::Status(fixed::get_status(payload)?),
            Kind::Index => Packet::Index(IndexBlock::parse(payload)?),
            Kind::Trailer => Packet::Trailer(fixed::get_trailer(payload)?),
            Kind::Lamps => Packet::Lamps(Lamps::parse(payload, hello?.lamps)?),
            Kind::Shape => Packet::Shape(Shape::parse(payload)?),
        })
    }
}
