//! What is packed bit by bit: tiles and samples.

use super::*;

/// Single bits, most significant first.
struct Bits(std::vec::IntoIter<bool>);

impl Bits {
    fn new(f: &Fields<'_>) -> Self {
        let bits = f
            .as_slice()
            .iter()
            .flat_map(|byte| (0..8).rev().map(move |i| byte >> i & 1 == 1));
        Bits(bits.collect::<Vec<_>>().into_iter())
    }

    fn take(&mut self, n: u32) -> Option<u32> {
        let mut value = 0u64;
        for _ in 0..n {
            value = value * 2 + u64::from(self.0.next()?);
        }
        Some(value as u32)
    }

    fn rice(&mut self, k: u32, width: u32) -> Option<u32> {
        let mut ones = 0u64;
        while ones < 12 && self.0.next()? {
            ones += 1;
        }
        if ones == 12 {
            return self.take(width);
        }
        Some((ones * (1 << k) + u64::from(self.take(k)?)) as u32)
    }
}

fn unfold(u: u32) -> i64 {
    if u.is_multiple_of(2) {
        i64::from(u / 2)
    } else {
        -(i64::from(u) + 1) / 2
    }
}

pub(super) fn tiles(f: &mut Fields<'_>, out: &mut Decoded) -> Option<()> {
    let time = word(f)?;
    let rect = [short(f)?, short(f)?, short(f)?, short(f)?];
    let panel = out.hellos.last()?;
    let inside =
        |at: u16, len: u16, edge: u16| len > 0 && u32::from(at) + u32::from(len) <= u32::from(edge);
    if !inside(rect[0], rect[2], panel.width) || !inside(rect[1], rect[3], panel.height) {
        return None;
    }
    let fields = byte(f).filter(|&v| v < 8)?;
    let present = [1, 1, 1, 2, 4].map(|bit| fields & bit != 0);
    let mut bits = Bits::new(f);
    let mut k = [0; 5];
    for i in (0..5).filter(|&i| present[i]) {
        k[i] = bits.take(3)?;
    }
    let mut tree = Tree {
        bits,
        time,
        present,
        k,
        last: [128; 5],
        leaves: Vec::new(),
    };
    let whole = tree.node(rect);
    out.tiles.append(&mut tree.leaves);
    whole
}

struct Tree {
    bits: Bits,
    time: u32,
    present: [bool; 5],
    k: [u32; 5],
    last: [u8; 5],
    leaves: Vec<Tile>,
}

impl Tree {
    fn node(&mut self, rect: [u16; 4]) -> Option<()> {
        if self.bits.take(1)? == 1 {
            let axis = self.bits.take(1)? as usize;
            let (mut first, mut second) = (rect, rect);
            first[2 + axis] = rect[2 + axis] / 2;
            second[2 + axis] -= first[2 + axis];
            second[axis] += first[2 + axis];
            if first[2 + axis] == 0 {
                return None;
            }
            self.node(first)?;
            return self.node(second);
        }
        for i in (0..5).filter(|&i| self.present[i]) {
            let delta = unfold(self.bits.rice(self.k[i], 8)?);
            self.last[i] = (i64::from(self.last[i]) + delta).rem_euclid(256) as u8;
        }
        self.leaves.push(Tile {
            time: self.time,
            rect,
            codes: self.last,
        });
        Some(())
    }
}

/// Colour parameters and the colour before.
struct Colours {
    threshold: u32,
    k: [[u32; 3]; 2],
    last: Option<[u8; 3]>,
}

impl Colours {
    fn new(bits: &mut Bits) -> Option<Self> {
        let threshold = bits.take(6)?;
        let mut k = [[0; 3]; 2];
        for k in k.as_flattened_mut() {
            *k = bits.take(3)?;
        }
        Some(Colours {
            threshold,
            k,
            last: None,
        })
    }

    fn next(&mut self, bits: &mut Bits, distance: u32) -> Option<[u8; 3]> {
        let rgb = match self.last {
            None => [
                bits.take(8)? as u8,
                bits.take(8)? as u8,
                bits.take(8)? as u8,
            ],
            Some([r, g, b]) => {
                let k = self.k[usize::from(distance >= self.threshold)];
                let dg = unfold(bits.rice(k[0], 8)?);
                let dr = unfold(bits.rice(k[1], 8)?);
                let db = unfold(bits.rice(k[2], 8)?);
                let add = |c: u8, d: i64| (i64::from(c) + d).rem_euclid(256) as u8;
                [add(r, dg + dr), add(g, dg), add(b, dg + db)]
            }
        };
        self.last = Some(rgb);
        Some(rgb)
    }
}

/// Share parameters and the codes before.
struct Shares {
    lamps: usize,
    k: [u32; 2],
    last: Option<[u8; 2]>,
}

impl Shares {
    fn new(bits: &mut Bits, lamps: u8) -> Option<Self> {
        let k = match lamps {
            0 => [0; 2],
            _ => [bits.take(3)?, bits.take(3)?],
        };
        Some(Shares {
            lamps: usize::from(lamps),
            k,
            last: None,
        })
    }

    fn next(&mut self, bits: &mut Bits, near: bool) -> Option<[u8; 2]> {
        let mut codes = [0; 2];
        for (lamp, code) in codes.iter_mut().enumerate().take(self.lamps) {
            *code = match self.last {
                None => bits.take(4)? as u8,
                Some(last) => {
                    let delta = unfold(bits.rice(self.k[usize::from(!near)], 4)?);
                    (i64::from(last[lamp]) + delta).rem_euclid(16) as u8
                }
            };
        }
        self.last = Some(codes);
        Some(codes)
    }
}

pub(super) fn world_samples(f: &mut Fields<'_>, out: &mut Decoded) -> Option<()> {
    let hello = out.hellos.last().filter(|h| h.world_layout)?;
    let time = word(f)?;
    let count = usize::from(byte(f)?) + 1;
    let mut runs = Vec::new();
    for _ in 0..count {
        runs.push((byte(f)?, usize::from(byte(f)?) + 1));
    }
    let too_many = runs.iter().map(|r| r.1).sum::<usize>() > 256;
    if too_many || (!hello.objects && runs.iter().any(|r| r.0 != 0)) {
        return None;
    }
    let mut bits = Bits::new(f);
    let modes = bits.take(1)? == 1;
    let centre = bits.take(6)?;
    let k = bits.take(3)?;
    let mut colours = Colours::new(&mut bits)?;
    let mut shares = Shares::new(&mut bits, hello.lamps)?;
    for (object, length) in runs {
        let mut u = [0u32; 3];
        let mut mode = 3;
        for i in 0..length {
            let distance = if i == 0 {
                u = [bits.take(16)?, bits.take(16)?, bits.take(16)?];
                63
            } else {
                let s = i64::from(centre) - unfold(bits.rice(k, 7)?);
                let s = u32::try_from(s).ok().filter(|&s| s <= 48)?;
                if s > 0 {
                    let l = s - 1;
                    if modes && bits.take(1)? == 0 {
                        mode = bits.take(2)?;
                    }
                    for c in 0..3 {
                        let n = (l + 2 - c) / 3;
                        let axis = &mut u[c as usize];
                        if c != mode {
                            *axis = (*axis / (1 << n)) * (1 << n) + bits.take(n)?;
                        }
                        if l % 3 == c {
                            *axis |= 1 << (l / 3);
                        }
                    }
                }
                s
            };
            let rgb = colours.next(&mut bits, distance)?;
            let codes = shares.next(&mut bits, distance < colours.threshold)?;
            let place = u.map(|u| u as i32 - 32_768);
            out.samples.push(Sample {
                time,
                object,
                place,
                rgb,
                shares: codes,
            });
        }
    }
    Some(())
}

pub(super) fn screen_samples(f: &mut Fields<'_>, out: &mut Decoded) -> Option<()> {
    let hello = out.hellos.last().filter(|h| !h.world_layout)?.clone();
    let time = word(f)?;
    let count = u32::from(byte(f)?) + 1;
    let mut bits = Bits::new(f);
    let k = bits.take(5)?;
    let mut colours = Colours::new(&mut bits)?;
    let mut m = 0u64;
    for _ in 0..count {
        let gap = bits.rice(k, 32)?;
        m += u64::from(gap);
        if m >= 1 << 32 {
            return None;
        }
        let every_other = |from: u32| (0..16).map(|i| (m >> (2 * i + from) & 1) << i).sum::<u64>();
        let (x, y) = (every_other(0), every_other(1));
        if x >= 16 * u64::from(hello.width) || y >= 16 * u64::from(hello.height) {
            return None;
        }
        let rgb = colours.next(&mut bits, 32 - gap.leading_zeros())?;
        out.samples.push(Sample {
            time,
            object: 0,
            place: [x as i32, y as i32, 0],
            rgb,
            shares: [0; 2],
        });
    }
    Some(())
}
