//! Recordings (`.ufs`): the bytes of a stream, then an index as packets of the stream's own form.
//!
//! A player may ignore the index, and a file without one (cut off, or captured from a link) gets
//! its index by [`rebuild_index`]. The last frame, [`Trailer`], says where the index starts.

use std::io::{self, Write};
use std::vec::Vec;

use core::fmt;

use crate::fixed::{IndexEntry, IndexKind, Trailer};
use crate::frame::MAX_FRAME;
use crate::packet::{Kind, Packet};
use crate::receiver::{Damage, Receiver};
use crate::repr::{End, Hello, Tick};
use crate::writer::Writer;

/// Follows a stream and notes where its landmarks are.
#[derive(Debug, Default)]
struct Indexer {
    receiver: Receiver,
    entries: Vec<IndexEntry>,
    /// Time of the newest packet that has one.
    time: Tick,
    /// Bytes up to the end of the newest packet that is not part of an index.
    body: u64,
    /// Sequence number of that packet.
    sequence: Option<u16>,
}

impl Indexer {
    fn push(&mut self, mut input: &[u8]) {
        while let Some(packet) = self.receiver.push(&mut input) {
            let kind = match packet.kind() {
                Kind::Hello => Some(IndexKind::Hello),
                Kind::Refresh => Some(IndexKind::Refresh),
                Kind::Cut => Some(IndexKind::Cut),
                Kind::Index | Kind::Trailer => continue,
                _ => None,
            };
            self.time = packet.time().unwrap_or(self.time);
            self.body = self.receiver.counters().bytes;
            self.sequence = self.receiver.last_sequence();
            if let Some(kind) = kind {
                let offset = self.body - self.receiver.frame_bytes();
                self.entries.push(IndexEntry {
                    kind,
                    time: self.time,
                    offset,
                });
            }
        }
    }

    /// The frames of the index, to be written at `offset`.
    fn frames(&self, offset: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = Writer::new();
        if let Some(sequence) = self.sequence {
            writer.resume_after(sequence);
        }
        // Fails only beyond 2^32 entries; a recording without an index is legal.
        let _ = writer.index(offset, &self.entries, &mut |frame| {
            bytes.extend_from_slice(frame)
        });
        bytes
    }
}

/// Writes a recording while the stream runs: pass it every frame, then call
/// [`Recorder::finish`].
#[derive(Debug)]
pub struct Recorder<W: Write> {
    out: W,
    indexer: Indexer,
}

impl<W: Write> Recorder<W> {
    /// A recording into `out`.
    pub fn new(out: W) -> Self {
        Recorder {
            out,
            indexer: Indexer::default(),
        }
    }

    /// Records the next bytes of the stream.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.indexer.push(bytes);
        self.out.write_all(bytes)
    }

    /// Appends the index and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        let offset = self.indexer.receiver.counters().bytes;
        self.out.write_all(&self.indexer.frames(offset))?;
        self.out.flush()?;
        Ok(self.out)
    }
}

/// The index of a recording from its packets, whatever its end looks like.
#[must_use]
pub fn rebuild_index(bytes: &[u8]) -> Vec<IndexEntry> {
    let mut indexer = Indexer::default();
    indexer.push(bytes);
    indexer.entries
}

/// Replaces what follows the last packet of the stream proper (a damaged index, half a frame) by
/// a new index.
pub fn repair(bytes: &mut Vec<u8>) {
    let mut indexer = Indexer::default();
    indexer.push(bytes);
    bytes.truncate(usize::try_from(indexer.body).unwrap_or(bytes.len()));
    let index = indexer.frames(indexer.body);
    bytes.extend(index);
}

/// The index at the end of a recording; `None` if it is missing, damaged or does not add up.
#[must_use]
pub fn read_index(bytes: &[u8]) -> Option<Vec<IndexEntry>> {
    let before_last = bytes.strip_suffix(&[0])?;
    let tail = before_last.get(before_last.len().saturating_sub(MAX_FRAME)..)?;
    let frame = before_last.len() - tail.iter().rev().take_while(|&&b| b != 0).count();
    let mut input = bytes.get(frame..)?;
    let mut receiver = Receiver::new();
    let trailer = match receiver.push(&mut input) {
        Some(Packet::Trailer(trailer)) => trailer,
        _ => return None,
    };
    entries_of(bytes, frame, trailer)
}

fn entries_of(bytes: &[u8], end: usize, trailer: Trailer) -> Option<Vec<IndexEntry>> {
    let mut input = bytes.get(usize::try_from(trailer.offset).ok()?..end)?;
    let mut receiver = Receiver::new();
    let mut entries = Vec::new();
    while let Some(packet) = receiver.push(&mut input) {
        match packet {
            Packet::Index(block) => entries.extend(block),
            _ => return None,
        }
    }
    let counters = receiver.counters();
    let whole = counters.lost == 0 && counters.damaged == 0;
    let inside = entries.iter().all(|e| e.offset < trailer.offset);
    let complete = u32::try_from(entries.len()) == Ok(trailer.entries);
    (whole && inside && complete).then_some(entries)
}

/// [`read_index`], else [`rebuild_index`].
#[must_use]
pub fn index(bytes: &[u8]) -> Vec<IndexEntry> {
    read_index(bytes).unwrap_or_else(|| rebuild_index(bytes))
}

/// Why bytes are not a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotARecording {
    /// There is not one byte.
    Empty,
    /// No good Hello; the newest damage may say why.
    NoHello(Option<Damage>),
}

impl fmt::Display for NotARecording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotARecording::Empty => f.write_str("the file is empty"),
            NotARecording::NoHello(None) => {
                f.write_str("no Hello packet: not a recording of an Unframed stream")
            }
            NotARecording::NoHello(Some(damage)) => {
                write!(
                    f,
                    "no Hello packet that this program understands ({damage})"
                )
            }
        }
    }
}

impl core::error::Error for NotARecording {}

/// What happened between one Refresh and the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RefreshLine {
    /// The refresh's number.
    pub index: u32,
    /// Microseconds since the stream's first time stamp.
    pub micros: i64,
    /// Samples.
    pub samples: u64,
    /// Bytes, all packets and framing counted.
    pub bytes: u64,
    /// Packets lost.
    pub lost: u64,
    /// Frames damaged.
    pub damaged: u64,
}

/// What is in a recording, for `unframed inspect`.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The newest Hello.
    pub hello: Hello,
    /// Version of the format.
    pub version: u8,
    /// Good packets by [`Kind::index`].
    pub packets: [u64; Kind::ALL.len()],
    /// Bytes of good packets by [`Kind::index`], framing included.
    pub packet_bytes: [u64; Kind::ALL.len()],
    /// Samples that were decoded.
    pub samples: u64,
    /// Bytes of the stream, framing included, the index not.
    pub bytes: u64,
    /// Packets missing by their sequence numbers.
    pub lost: u64,
    /// Frames thrown away or packed wrongly.
    pub damaged: u64,
    /// From the first time stamp to the last, seconds.
    pub seconds: f64,
    /// The End packet, if the stream got so far.
    pub end: Option<End>,
    /// Whether a good index is there.
    pub indexed: bool,
    /// One line a Refresh.
    pub timeline: Vec<RefreshLine>,
}

impl Summary {
    /// Reads a whole recording.
    ///
    /// # Errors
    /// [`NotARecording`] if there is no Hello to start from.
    pub fn of(bytes: &[u8]) -> Result<Self, NotARecording> {
        let mut receiver = Receiver::new();
        let mut input = bytes;
        let mut tally = Tally::default();
        while let Some(packet) = receiver.push(&mut input) {
            let (kind, refresh) = tally.count(packet);
            tally.frame(kind, receiver.frame_bytes());
            if let Some((index, micros)) = refresh {
                let c = receiver.counters();
                tally.line(index, micros, c.bytes, c.lost, c.damaged);
            }
        }
        if bytes.is_empty() {
            return Err(NotARecording::Empty);
        }
        let counters = *receiver.counters();
        let Some(hello) = receiver.hello() else {
            return Err(NotARecording::NoHello(receiver.last_damage()));
        };
        let of = |kind: Kind| tally.packet_bytes.get(kind.index()).copied().unwrap_or(0);
        Ok(Summary {
            hello: *hello,
            version: crate::schema::VERSION,
            packets: tally.packets,
            packet_bytes: tally.packet_bytes,
            samples: tally.samples,
            bytes: counters.bytes - of(Kind::Index) - of(Kind::Trailer),
            lost: counters.lost,
            damaged: counters.damaged + tally.malformed,
            seconds: tally.latest as f64 / 1e6,
            end: tally.end,
            indexed: read_index(bytes).is_some(),
            timeline: tally.timeline,
        })
    }

    /// Good packets of one kind.
    #[must_use]
    pub fn packets_of(&self, kind: Kind) -> u64 {
        self.packets.get(kind.index()).copied().unwrap_or(0)
    }

    /// Good Samples packets of either layout.
    #[must_use]
    pub fn sample_packets(&self) -> u64 {
        self.packets_of(Kind::World) + self.packets_of(Kind::Screen)
    }

    /// All bytes over all samples; `None` without samples.
    #[must_use]
    pub fn bytes_per_sample(&self) -> Option<f64> {
        (self.samples > 0).then(|| self.bytes as f64 / self.samples as f64)
    }
}

#[derive(Default)]
struct Tally {
    packets: [u64; Kind::ALL.len()],
    packet_bytes: [u64; Kind::ALL.len()],
    samples: u64,
    malformed: u64,
    end: Option<End>,
    timeline: Vec<RefreshLine>,
    /// The newest time stamp, and its microseconds since the first: unwrapped step by step.
    last: Option<(Tick, i64)>,
    latest: i64,
    /// Samples, bytes, lost and damaged at the last refresh.
    before: [u64; 4],
}

impl Tally {
    /// Counts a packet; its kind, and number and time if it is a Refresh.
    fn count(&mut self, packet: Packet<'_>) -> (Kind, Option<(u32, i64)>) {
        let kind = packet.kind();
        let mut micros = 0;
        if let Some(time) = packet.time() {
            micros = self
                .last
                .map_or(0, |(tick, at)| at + i64::from(time.since(tick)));
            self.last = Some((time, micros));
            self.latest = self.latest.max(micros);
        }
        match packet {
            Packet::World(mut samples) => {
                self.samples += samples.by_ref().count() as u64;
                self.malformed += u64::from(samples.malformed());
            }
            Packet::Screen(mut samples) => {
                self.samples += samples.by_ref().count() as u64;
                self.malformed += u64::from(samples.malformed());
            }
            Packet::Tiles(mut tiles) => {
                tiles.by_ref().for_each(drop);
                self.malformed += u64::from(tiles.malformed());
            }
            Packet::End(end) => self.end = Some(end),
            Packet::Refresh(refresh) => return (kind, Some((refresh.index, micros))),
            _ => {}
        }
        (kind, None)
    }

    fn frame(&mut self, kind: Kind, bytes: u64) {
        if let (Some(n), Some(b)) = (
            self.packets.get_mut(kind.index()),
            self.packet_bytes.get_mut(kind.index()),
        ) {
            *n += 1;
            *b += bytes;
        }
    }

    fn line(&mut self, index: u32, micros: i64, bytes: u64, lost: u64, damaged: u64) {
        let now = [self.samples, bytes, lost, damaged + self.malformed];
        let [s, b, l, d] = self.before;
        let (samples, bytes, lost, damaged) = (now[0] - s, now[1] - b, now[2] - l, now[3] - d);
        self.before = now;
        self.timeline.push(RefreshLine {
            index,
            micros,
            samples,
            bytes,
            lost,
            damaged,
        });
    }
}
