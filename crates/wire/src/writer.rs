//! Meanings in, frames out.

use core::fmt;

use crate::bytes::Buffer;
use crate::fixed::{self, IndexEntry, MAX_INDEX_ENTRIES, MAX_POSES, Trailer};
use crate::frame::{self, MAX_FRAME, MAX_PACKET};
use crate::ledger::Ledger;
use crate::packet::Kind;
use crate::repr::*;
use crate::samples::{self, MAX_SAMPLES, SURE_SAMPLES};
use crate::tiles::{self, Axis, TileNode, TreeError};

/// Why a packet cannot be written. Nothing was sent of it, unless stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// A field of this kind of packet is outside the range that [`crate::repr`] states.
    Range(Kind),
    /// The stream's Hello announces another layout, or no Hello was written yet.
    Layout,
    /// The stream's Hello announces no objects, and a sample has one.
    Objects,
    /// A sample has a share of a lamp that the stream's Hello does not announce.
    Shares,
    /// The nodes are not one whole preorder tree, or they split a single pixel.
    Tree,
    /// A leaf's rectangle is not the one that the splits lead to.
    LeafRect,
    /// One tile or packet does not fit [`MAX_PACKET`]; with the limits above that happens to
    /// shapes only, see [`crate::Shape::fits`].
    TooLong,
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EncodeError::Range(kind) => write!(f, "{} packet: a field out of range", kind.name()),
            EncodeError::Layout => f.write_str("samples of a layout that the Hello does not name"),
            EncodeError::Objects => f.write_str("object ids in a stream without objects"),
            EncodeError::Shares => f.write_str("shares of lamps that the Hello does not name"),
            EncodeError::Tree => f.write_str("tile nodes are not one whole tree"),
            EncodeError::LeafRect => f.write_str("a tile's rectangle does not follow its splits"),
            EncodeError::TooLong => f.write_str("packet too long"),
        }
    }
}

impl core::error::Error for EncodeError {}

impl From<TreeError> for EncodeError {
    fn from(error: TreeError) -> Self {
        match error {
            TreeError::Shape => EncodeError::Tree,
            TreeError::Rect => EncodeError::LeafRect,
        }
    }
}

/// Writes one stream: numbers the packets, frames them, hands each whole frame to a sink (any
/// `FnMut(&[u8])`), and keeps the [`Ledger`]. About 4 KiB, and 22 KiB of stack while sorting.
#[derive(Clone, Debug)]
pub struct Writer {
    packet: Buffer,
    frame: [u8; MAX_FRAME],
    sequence: u16,
    hello: Option<Hello>,
    ledger: Ledger,
}

impl Default for Writer {
    fn default() -> Self {
        Self::new()
    }
}

impl Writer {
    /// A writer at sequence number 0.
    #[must_use]
    pub fn new() -> Self {
        Writer {
            packet: Buffer::new(),
            frame: [0; MAX_FRAME],
            sequence: 0,
            hello: None,
            ledger: Ledger::default(),
        }
    }

    /// Where the bytes went so far.
    #[must_use]
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Announces the stream. Repeat it now and then, so that receivers can join.
    pub fn hello(
        &mut self,
        hello: &Hello,
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        if !fixed::hello_is_valid(hello) {
            return Err(EncodeError::Range(Kind::Hello));
        }
        self.begin(Kind::Hello);
        fixed::put_hello(&mut self.packet, hello);
        self.send(Kind::Hello, sink)?;
        self.hello = Some(*hello);
        Ok(())
    }

    /// The camera at an instant.
    pub fn view(&mut self, view: &View, sink: &mut impl FnMut(&[u8])) -> Result<(), EncodeError> {
        if view.frac_bits > 30 {
            return Err(EncodeError::Range(Kind::View));
        }
        self.begin(Kind::View);
        fixed::put_view(&mut self.packet, view);
        self.send(Kind::View, sink)
    }

    /// The transforms of objects at an instant, in as many packets as it takes.
    pub fn poses(
        &mut self,
        time: Tick,
        poses: &[Pose],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        if poses.iter().any(|pose| pose.frac_bits > 31) {
            return Err(EncodeError::Range(Kind::Poses));
        }
        for part in poses.chunks(MAX_POSES) {
            self.begin(Kind::Poses);
            self.packet.u32(time.0);
            part.iter()
                .for_each(|pose| fixed::put_pose(&mut self.packet, pose));
            self.send(Kind::Poses, sink)?;
        }
        Ok(())
    }

    /// The k-d cut of `region` at an instant, as a preorder of its nodes, in as many packets as it
    /// takes: each holds a whole subtree. The fields are those of the Hello.
    ///
    /// # Errors
    /// [`EncodeError::Tree`], [`EncodeError::LeafRect`]; [`EncodeError::Range`] if `region` is
    /// not inside the panel; [`EncodeError::Layout`] before the first Hello.
    pub fn tiles(
        &mut self,
        time: Tick,
        region: Rect,
        nodes: &[TileNode],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        let hello = self.hello.ok_or(EncodeError::Layout)?;
        let inside = |at: u16, len: u16, edge: u16| {
            len >= 1 && u32::from(at) + u32::from(len) <= u32::from(edge)
        };
        if !inside(region.x, region.w, hello.width) || !inside(region.y, region.h, hello.height) {
            return Err(EncodeError::Range(Kind::Tiles));
        }
        if tiles::check(region, nodes)? != nodes.len() {
            return Err(EncodeError::Tree);
        }
        self.subtree(time, region, hello.tile_fields, nodes, sink)
    }

    /// Sends the subtree whole if it fits, else its halves. As deep as the tree at most: 24.
    fn subtree(
        &mut self,
        time: Tick,
        region: Rect,
        fields: TileFields,
        nodes: &[TileNode],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        self.begin(Kind::Tiles);
        let bits = tiles::put(&mut self.packet, time, region, fields, nodes);
        if self.fits() {
            self.ledger.add_tiles(bits);
            return self.send(Kind::Tiles, sink);
        }
        let Some((TileNode::Split(axis), rest)) = nodes.split_first() else {
            return Err(EncodeError::TooLong);
        };
        let axis: Axis = *axis;
        let (first, second) = tiles::split(region, axis).ok_or(EncodeError::Tree)?;
        let cut = tiles::check(first, rest)?;
        let (a, b) = rest.split_at_checked(cut).ok_or(EncodeError::Tree)?;
        self.subtree(time, first, fields, a, sink)?;
        self.subtree(time, second, fields, b, sink)
    }

    /// Samples with lattice places that share one instant, in as many packets as it takes.
    ///
    /// # Errors
    /// [`EncodeError::Layout`] unless the Hello said [`Layout::World`]; [`EncodeError::Objects`];
    /// [`EncodeError::Shares`].
    pub fn world_samples(
        &mut self,
        time: Tick,
        samples: &[WorldSample],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        let hello = self.hello.filter(|h| h.layout == Layout::World);
        let hello = hello.ok_or(EncodeError::Layout)?;
        if !hello.objects && samples.iter().any(|s| s.object != 0) {
            return Err(EncodeError::Objects);
        }
        let beyond = |s: &WorldSample| u32::from(s.shares.0) >> (4 * u32::from(hello.lamps));
        if samples.iter().any(|s| beyond(s) != 0) {
            return Err(EncodeError::Shares);
        }
        let mut rest = samples;
        while !rest.is_empty() {
            let mut part = rest.get(..MAX_SAMPLES).unwrap_or(rest);
            self.begin(Kind::World);
            let mut bits = samples::put_world(&mut self.packet, time, part, hello.lamps);
            if !self.fits() {
                // Noise, not a picture.
                part = rest.get(..SURE_SAMPLES).unwrap_or(rest);
                self.begin(Kind::World);
                bits = samples::put_world(&mut self.packet, time, part, hello.lamps);
            }
            self.send(Kind::World, sink)?;
            self.ledger.add_samples(part.len(), bits);
            rest = rest.get(part.len()..).unwrap_or_default();
        }
        Ok(())
    }

    /// Samples with screen places that share one instant, in as many packets as it takes.
    ///
    /// # Errors
    /// [`EncodeError::Layout`] unless the Hello said [`Layout::Screen`]; [`EncodeError::Range`]
    /// for a place outside the panel.
    pub fn screen_samples(
        &mut self,
        time: Tick,
        samples: &[ScreenSample],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        let hello = self.hello.filter(|h| h.layout == Layout::Screen);
        let hello = hello.ok_or(EncodeError::Layout)?;
        let beyond = |at: u16, edge: u16| u32::from(at) >= 16 * u32::from(edge);
        if samples
            .iter()
            .any(|s| beyond(s.x, hello.width) || beyond(s.y, hello.height))
        {
            return Err(EncodeError::Range(Kind::Screen));
        }
        for part in samples.chunks(MAX_SAMPLES) {
            self.begin(Kind::Screen);
            let bits = samples::put_screen(&mut self.packet, time, part);
            self.send(Kind::Screen, sink)?;
            self.ledger.add_samples(part.len(), bits);
        }
        Ok(())
    }

    /// The lamps at an instant, as many as the Hello announces, in the order of the samples'
    /// [`Shares`].
    ///
    /// # Errors
    /// [`EncodeError::Layout`] before the first Hello; [`EncodeError::Range`] if their number is
    /// not that of the Hello, or 0, or a lamp is out of range.
    pub fn lamps(
        &mut self,
        time: Tick,
        lamps: &[Lamp],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        let hello = self.hello.ok_or(EncodeError::Layout)?;
        let announced = !lamps.is_empty() && lamps.len() == usize::from(hello.lamps);
        if !announced || !lamps.iter().all(Lamp::is_valid) {
            return Err(EncodeError::Range(Kind::Lamps));
        }
        self.begin(Kind::Lamps);
        self.packet.u32(time.0);
        lamps
            .iter()
            .for_each(|lamp| fixed::put_lamp(&mut self.packet, lamp));
        self.send(Kind::Lamps, sink)
    }

    /// Part `part` of the `parts` (1..=256) of an object's shape: vertices in the object's
    /// lattice, and triangles, each three indices of vertices. Repeat it now and then; it must
    /// not change within a stream.
    ///
    /// # Errors
    /// [`EncodeError::Range`] if the object does not move (0, [`SKY`]), `part` is not below
    /// `parts`, an index names no vertex, or there are none or more than 256 of vertices or
    /// triangles; [`EncodeError::TooLong`] unless [`crate::Shape::fits`].
    pub fn shape(
        &mut self,
        object: u8,
        part: u8,
        parts: u16,
        vertices: &[[i16; 3]],
        triangles: &[[u8; 3]],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        let mut corners = triangles.as_flattened().iter();
        let indexed = corners.all(|&at| usize::from(at) < vertices.len());
        let counted = [vertices.len(), triangles.len()]
            .iter()
            .all(|n| (1..=256).contains(n));
        if !fixed::shape_is_named(object, part, parts) || !indexed || !counted {
            return Err(EncodeError::Range(Kind::Shape));
        }
        self.begin(Kind::Shape);
        fixed::put_shape(&mut self.packet, [object, part], parts, vertices, triangles);
        self.send(Kind::Shape, sink)
    }

    /// Asks for a picture of an instant.
    pub fn refresh(
        &mut self,
        refresh: Refresh,
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        self.begin(Kind::Refresh);
        fixed::put_refresh(&mut self.packet, refresh);
        self.send(Kind::Refresh, sink)
    }

    /// The scene changed wholly.
    pub fn cut(&mut self, time: Tick, sink: &mut impl FnMut(&[u8])) -> Result<(), EncodeError> {
        self.begin(Kind::Cut);
        self.packet.u32(time.0);
        self.send(Kind::Cut, sink)
    }

    /// Ends the stream, with the counts of this writer.
    pub fn end(&mut self, time: Tick, sink: &mut impl FnMut(&[u8])) -> Result<End, EncodeError> {
        let end = End {
            time,
            samples: self.ledger.samples,
            packets: self.ledger.total_packets(),
        };
        self.begin(Kind::End);
        fixed::put_end(&mut self.packet, &end);
        self.send(Kind::End, sink)?;
        Ok(end)
    }

    /// Display to host: how the link is doing.
    pub fn status(
        &mut self,
        status: &Status,
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        self.begin(Kind::Status);
        fixed::put_status(&mut self.packet, status);
        self.send(Kind::Status, sink)
    }

    /// The index of a recording, whose next byte is at `offset`.
    pub fn index(
        &mut self,
        offset: u64,
        entries: &[IndexEntry],
        sink: &mut impl FnMut(&[u8]),
    ) -> Result<(), EncodeError> {
        let count = u32::try_from(entries.len()).map_err(|_| EncodeError::Range(Kind::Trailer))?;
        for part in entries.chunks(MAX_INDEX_ENTRIES) {
            self.begin(Kind::Index);
            part.iter()
                .for_each(|entry| fixed::put_index_entry(&mut self.packet, entry));
            self.send(Kind::Index, sink)?;
        }
        self.begin(Kind::Trailer);
        fixed::put_trailer(
            &mut self.packet,
            Trailer {
                offset,
                entries: count,
            },
        );
        self.send(Kind::Trailer, sink)
    }

    /// Continues a stream whose last packet had this sequence number (to append an index).
    pub fn resume_after(&mut self, sequence: u16) {
        self.sequence = sequence.wrapping_add(1);
    }

    fn begin(&mut self, kind: Kind) {
        self.packet.clear();
        self.packet.u8(kind as u8);
        self.packet.u16(self.sequence);
    }

    fn fits(&self) -> bool {
        !self.packet.overflowed() && self.packet.len() + 4 <= MAX_PACKET
    }

    fn send(&mut self, kind: Kind, sink: &mut impl FnMut(&[u8])) -> Result<(), EncodeError> {
        if !self.fits() {
            return Err(EncodeError::TooLong);
        }
        self.packet.u32(frame::checksum(self.packet.as_slice()));
        let len = frame::encode(self.packet.as_slice(), &mut self.frame);
        let frame = len
            .and_then(|len| self.frame.get(..len))
            .ok_or(EncodeError::TooLong)?;
        sink(frame);
        self.sequence = self.sequence.wrapping_add(1);
        self.ledger.count(kind, frame.len() as u64);
        Ok(())
    }
}
