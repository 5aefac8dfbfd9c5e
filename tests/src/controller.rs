//! A model of the ST7789 display controller, stricter than the chip: what it does not know, or what
//! would be undefined, is an error. Sitronix, *ST7789V datasheet* 1.0, chapter 9.

use std::fmt;

/// Columns and rows of the controller's memory.
pub const MEMORY: (usize, usize) = (240, 320);

/// What the controller does not accept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The controller.
#[derive(Clone, Debug)]
pub struct Controller {
    /// 16-bit colours (5, 6, 5 bits), row by row.
    memory: Vec<u16>,
    columns: (u16, u16),
    rows: (u16, u16),
    /// The next pixel to be written; `None` outside a memory write.
    next: Option<(u16, u16)>,
    /// The first byte of a colour whose second is to come.
    half: Option<u8>,
    command: u8,
    arguments: Vec<u8>,
    awake: bool,
    on: bool,
    sixteen_bits: bool,
    /// Windows written since the last refresh, and pixels in them.
    written: (usize, usize),
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            // Not black: what is never written shows.
            memory: vec![0xf81f; MEMORY.0 * MEMORY.1],
            columns: (0, 0),
            rows: (0, 0),
            next: None,
            half: None,
            command: 0,
            arguments: Vec::new(),
            awake: false,
            on: false,
            sixteen_bits: false,
            written: (0, 0),
        }
    }
}

impl Controller {
    /// Replays records of a bus (see `firmware::files::BUS`) and calls `refreshed` after each
    /// refresh with windows and pixels written for it.
    ///
    /// # Errors
    /// The first thing that the controller does not accept.
    pub fn replay(
        &mut self,
        mut bus: &[u8],
        mut refreshed: impl FnMut(&Self, usize, usize),
    ) -> Result<(), Refused> {
        while let Some(([kind, low, high], rest)) = bus.split_first_chunk::<3>() {
            let len = usize::from(u16::from_le_bytes([*low, *high]));
            let cut = || Refused("a record is cut off".to_owned());
            let (bytes, rest) = rest.split_at_checked(len).ok_or_else(cut)?;
            bus = rest;
            match (kind, bytes) {
                (0, [command]) => self.command(*command)?,
                (1, bytes) => bytes.iter().try_for_each(|byte| self.data(*byte))?,
                (2, []) => {
                    self.finish()?;
                    let (windows, pixels) = std::mem::take(&mut self.written);
                    refreshed(self, windows, pixels);
                }
                _ => return Err(Refused(format!("a record of kind {kind}, {len} bytes"))),
            }
        }
        if bus.is_empty() {
            Ok(())
        } else {
            Err(Refused("bytes at the end".to_owned()))
        }
    }

    /// The colours shown in the top left corner, row by row.
    ///
    /// # Errors
    /// When the display shows nothing.
    pub fn shown(&self, (width, height): (u16, u16)) -> Result<Vec<u16>, Refused> {
        if !(self.awake && self.on && self.sixteen_bits) {
            return Err(Refused("asleep, off, or not at 16 bits a pixel".to_owned()));
        }
        let rows = self.memory.chunks(MEMORY.0).take(height.into());
        Ok(rows
            .flat_map(|row| &row[..usize::from(width)])
            .copied()
            .collect())
    }

    fn command(&mut self, command: u8) -> Result<(), Refused> {
        self.finish()?;
        self.command = command;
        match command {
            // SWRESET forgets all settings, but not the memory.
            0x01 => {
                *self = Self {
                    memory: std::mem::take(&mut self.memory),
                    ..Self::default()
                }
            }
            // SLPOUT, DISPON; NORON and INVOFF are the state after reset.
            0x11 => self.awake = true,
            0x29 => self.on = true,
            0x13 | 0x20 => {}
            // CASET, RASET, MADCTL, COLMOD: arguments follow.
            0x2a | 0x2b | 0x36 | 0x3a => {}
            // RAMWR.
            0x2c => {
                let ((left, right), (top, bottom)) = (self.columns, self.rows);
                self.written.0 += 1;
                self.written.1 += usize::from(right - left + 1) * usize::from(bottom - top + 1);
                self.next = Some((left, top));
            }
            other => return Err(Refused(format!("command {other:#04x}"))),
        }
        Ok(())
    }

    /// What a command's end demands.
    fn finish(&mut self) -> Result<(), Refused> {
        let arguments = std::mem::take(&mut self.arguments);
        match (self.command, &arguments[..]) {
            (0x2a | 0x2b, &[a, b, c, d]) => {
                let range = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
                let limit = if self.command == 0x2a {
                    MEMORY.0
                } else {
                    MEMORY.1
                };
                if range.0 > range.1 || usize::from(range.1) >= limit {
                    return Err(Refused(format!("a window over {range:?} of {limit}")));
                }
                match self.command {
                    0x2a => self.columns = range,
                    _ => self.rows = range,
                }
            }
            (0x36, [0]) => {}
            // 16 bits a pixel, on both interfaces.
            (0x3a, [0x55]) => self.sixteen_bits = true,
            (0x2c, []) => match (self.next.take(), self.half.take()) {
                (None, None) => {}
                (next, _) => return Err(Refused(format!("a window not filled: {next:?}"))),
            },
            (0x2a | 0x2b | 0x36 | 0x3a, other) | (_, other @ [_, ..]) => {
                let command = self.command;
                return Err(Refused(format!("command {command:#04x} with {other:x?}")));
            }
            _ => {}
        }
        self.command = 0;
        Ok(())
    }

    fn data(&mut self, byte: u8) -> Result<(), Refused> {
        if self.command != 0x2c {
            self.arguments.push(byte);
            return Ok(());
        }
        let Some(high) = self.half.take() else {
            self.half = Some(byte);
            return Ok(());
        };
        let beyond = || Refused("a pixel beyond its window".to_owned());
        let (x, y) = self.next.ok_or_else(beyond)?;
        self.memory[usize::from(y) * MEMORY.0 + usize::from(x)] = u16::from_be_bytes([high, byte]);
        self.next = if x < self.columns.1 {
            Some((x + 1, y))
        } else if y < self.rows.1 {
            Some((self.columns.0, y + 1))
        } else {
            None
        };
        Ok(())
    }
}
