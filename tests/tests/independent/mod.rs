//! A decoder of the stream written from `docs/STREAM.md` alone: it shares nothing with
//! `unframed-wire`, and prefers the plainest way to the fast one (CRC bit by bit, a vector of
//! single bits, recursion over the tile tree).

mod packed;

use packed::{screen_samples, tiles, world_samples};

/// Where fields of a packet come from.
type Fields<'a> = std::slice::Iter<'a, u8>;

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Hello {
    pub(crate) width: u16,
    pub(crate) height: u16,
    pub(crate) world_layout: bool,
    pub(crate) objects: bool,
    pub(crate) tile_fields: u8,
    pub(crate) rate: u32,
    pub(crate) refresh_millihertz: u32,
    pub(crate) origin: [f32; 3],
    pub(crate) unit: f32,
    pub(crate) lamps: u8,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    pub(crate) time: u32,
    pub(crate) eye: [i32; 3],
    pub(crate) rows: [[i32; 3]; 3],
    pub(crate) frac_bits: u8,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pose {
    pub(crate) time: u32,
    pub(crate) object: u8,
    pub(crate) frac_bits: u8,
    pub(crate) matrix: [[i32; 3]; 3],
    pub(crate) translation: [i32; 3],
}

/// A leaf: time, x, y, width, height, and gx, gy, gt, lifetime, density.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    pub(crate) time: u32,
    pub(crate) rect: [u16; 4],
    pub(crate) codes: [u8; 5],
}

/// A sample of either layout: `place` is x, y, z of the lattice, or x, y in 1/16 pixel and 0.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Sample {
    pub(crate) time: u32,
    pub(crate) object: u8,
    pub(crate) place: [i32; 3],
    pub(crate) rgb: [u8; 3],
    /// The code of each lamp, 0 without it.
    pub(crate) shares: [u8; 2],
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lamp {
    pub(crate) time: u32,
    pub(crate) directional: bool,
    pub(crate) place: [i32; 3],
    pub(crate) tint: [u16; 2],
}

/// A part of a shape: its triangles, corner by corner.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) object: u8,
    pub(crate) part: u16,
    pub(crate) parts: u16,
    pub(crate) triangles: Vec<[[i16; 3]; 3]>,
}

/// All that a stream says, in its order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Decoded {
    pub(crate) hellos: Vec<Hello>,
    pub(crate) views: Vec<View>,
    pub(crate) poses: Vec<Pose>,
    pub(crate) tiles: Vec<Tile>,
    pub(crate) samples: Vec<Sample>,
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) shapes: Vec<Shape>,
    /// Time and index.
    pub(crate) refreshes: Vec<(u32, u32)>,
    pub(crate) cuts: Vec<u32>,
    /// Time, samples, packets.
    pub(crate) end: Option<(u32, u64, u64)>,
    /// Entries of the index: kind, time, offset.
    pub(crate) index: Vec<(u8, u32, u64)>,
    /// Offset and entries.
    pub(crate) trailer: Option<(u64, u32)>,
    pub(crate) packets: u64,
    pub(crate) lost: u64,
    pub(crate) damaged: u64,
}

/// Decodes the bytes of a stream or of a recording.
pub(crate) fn decode(bytes: &[u8]) -> Decoded {
    let mut out = Decoded::default();
    let mut expected: Option<u16> = None;
    let mut frames: Vec<&[u8]> = bytes.split(|&b| b == 0).collect();
    frames.pop();
    for frame in frames.into_iter().filter(|f| !f.is_empty()) {
        let Some((kind, sequence, payload)) = open(frame) else {
            out.damaged += 1;
            continue;
        };
        let ahead = expected.map_or(0, |e| sequence.wrapping_sub(e));
        if ahead >= 65_472 {
            continue;
        }
        if ahead < 0x8000 {
            out.lost += u64::from(ahead);
        }
        expected = Some(sequence.wrapping_add(1));
        let alone = matches!(kind, 1 | 9 | 10 | 11 | 12);
        if !(1..=14).contains(&kind) || (out.hellos.is_empty() && !alone) {
            continue;
        }
        match packet(kind, &payload, &mut out) {
            Some(()) => out.packets += 1,
            None => out.damaged += 1,
        }
    }
    out
}

/// Undoes COBS, checks the CRC: type, sequence number, payload.
fn open(frame: &[u8]) -> Option<(u8, u16, Vec<u8>)> {
    let mut bytes = Vec::new();
    let mut at = 0;
    while at < frame.len() {
        let code = usize::from(frame[at]);
        bytes.extend(frame.get(at + 1..at + code)?);
        at += code;
        if code < 255 && at < frame.len() {
            bytes.push(0);
        }
    }
    if bytes.len() < 7 || bytes.len() > 2048 {
        return None;
    }
    let crc = bytes.split_off(bytes.len() - 4);
    if crc32c(&bytes).to_le_bytes() != crc[..] {
        return None;
    }
    let payload = bytes.split_off(3);
    Some((bytes[0], u16::from_le_bytes([bytes[1], bytes[2]]), payload))
}

pub(crate) fn crc32c(bytes: &[u8]) -> u32 {
    // 0x82F63B78 is 0x1EDC6F41 with its bits reversed, for reflected input.
    let mut crc = !0u32;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ if crc & 1 == 1 { 0x82F6_3B78 } else { 0 };
        }
    }
    !crc
}

fn number(f: &mut Fields<'_>, bytes: u32) -> Option<u64> {
    let mut value = 0;
    for i in 0..bytes {
        value |= u64::from(*f.next()?) << (8 * i);
    }
    Some(value)
}

fn byte(f: &mut Fields<'_>) -> Option<u8> {
    f.next().copied()
}

fn short(f: &mut Fields<'_>) -> Option<u16> {
    number(f, 2).map(|v| v as u16)
}

fn word(f: &mut Fields<'_>) -> Option<u32> {
    number(f, 4).map(|v| v as u32)
}

fn vector(f: &mut Fields<'_>) -> Option<[i32; 3]> {
    Some([word(f)? as i32, word(f)? as i32, word(f)? as i32])
}

fn matrix(f: &mut Fields<'_>) -> Option<[[i32; 3]; 3]> {
    Some([vector(f)?, vector(f)?, vector(f)?])
}

fn finite(f: &mut Fields<'_>) -> Option<f32> {
    word(f).map(f32::from_bits).filter(|v| v.is_finite())
}

fn packet(kind: u8, payload: &[u8], out: &mut Decoded) -> Option<()> {
    let f = &mut payload.iter();
    match kind {
        1 => out.hellos.push(hello(f)?),
        2 => {
            let time = word(f)?;
            let (eye, rows) = (vector(f)?, matrix(f)?);
            let frac_bits = byte(f).filter(|&b| b <= 30)?;
            out.views.push(View {
                time,
                eye,
                rows,
                frac_bits,
            });
        }
        3 => {
            let time = word(f)?;
            let count = f.len() / 50;
            if !f.len().is_multiple_of(50) || !(1..=40).contains(&count) {
                return None;
            }
            for _ in 0..count {
                let (object, frac_bits) = (byte(f)?, byte(f).filter(|&b| b <= 31)?);
                let (matrix, translation) = (matrix(f)?, vector(f)?);
                out.poses.push(Pose {
                    time,
                    object,
                    frac_bits,
                    matrix,
                    translation,
                });
            }
        }
        4 => return tiles(f, out),
        5 => return world_samples(f, out),
        6 => return screen_samples(f, out),
        7 => out.refreshes.push((word(f)?, word(f)?)),
        8 => out.cuts.push(word(f)?),
        9 => out.end = Some((word(f)?, number(f, 8)?, number(f, 8)?)),
        10 => {
            number(f, 20)?;
        }
        11 => {
            while f.len() > 0 {
                out.index
                    .push((byte(f).filter(|&k| k < 3)?, word(f)?, number(f, 8)?));
            }
        }
        12 => out.trailer = Some((number(f, 8)?, word(f)?)),
        13 => lamps(f, out)?,
        _ => out.shapes.push(shape(f)?),
    }
    f.next().is_none().then_some(())
}

fn hello(f: &mut Fields<'_>) -> Option<Hello> {
    let magic = [byte(f)?, byte(f)?, byte(f)?, byte(f)?];
    if magic != *b"UFRM" || byte(f)? != 1 || word(f)? != 0x5666_3bd1 {
        return None;
    }
    let edge = 1..=4096;
    let width = short(f).filter(|v| edge.contains(v))?;
    let height = short(f).filter(|v| edge.contains(v))?;
    let flags = byte(f).filter(|&v| v < 4 && v != 2)?;
    let tile_fields = byte(f).filter(|&v| v < 8)?;
    byte(f).filter(|&v| v == 0)?;
    let most_lamps = if flags & 1 == 1 { 2 } else { 0 };
    Some(Hello {
        width,
        height,
        world_layout: flags & 1 == 1,
        objects: flags & 2 == 2,
        tile_fields,
        rate: word(f).filter(|&v| v >= 1)?,
        refresh_millihertz: word(f).filter(|&v| v >= 1)?,
        origin: [finite(f)?, finite(f)?, finite(f)?],
        unit: finite(f).filter(|&v| v > 0.0)?,
        lamps: byte(f).filter(|&v| v <= most_lamps)?,
    })
}

fn lamps(f: &mut Fields<'_>, out: &mut Decoded) -> Option<()> {
    let count = out.hellos.last()?.lamps;
    let time = word(f)?;
    if count == 0 || f.len() != 17 * usize::from(count) {
        return None;
    }
    let mut found = Vec::new();
    for _ in 0..count {
        let directional = byte(f).filter(|&kind| kind < 2)? == 1;
        let place = vector(f)?;
        let most = if directional { 1i64 << 30 } else { 1 << 29 };
        let outside = place.iter().any(|&c| i64::from(c).abs() > most);
        if outside || (directional && place == [0, 0, 0]) {
            return None;
        }
        let tint = [short(f).filter(|&t| t >= 1)?, short(f).filter(|&t| t >= 1)?];
        found.push(Lamp {
            time,
            directional,
            place,
            tint,
        });
    }
    out.lamps.append(&mut found);
    Some(())
}

fn shape(f: &mut Fields<'_>) -> Option<Shape> {
    let object = byte(f).filter(|&id| id != 0 && id != 255)?;
    let part = u16::from(byte(f)?);
    let parts = u16::from(byte(f)?) + 1;
    if part >= parts {
        return None;
    }
    let counts = [u16::from(byte(f)?) + 1, u16::from(byte(f)?) + 1];
    let mut vertices = Vec::new();
    for _ in 0..counts[0] {
        vertices.push([short(f)? as i16, short(f)? as i16, short(f)? as i16]);
    }
    let mut triangles = Vec::new();
    for _ in 0..counts[1] {
        let mut corner = || vertices.get(usize::from(byte(f)?)).copied();
        triangles.push([corner()?, corner()?, corner()?]);
    }
    // Bytes left over make it none.
    (f.len() == 0).then_some(Shape {
        object,
        part,
        parts,
        triangles,
    })
}
