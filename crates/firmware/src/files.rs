//! Files of the host: the stream in, text and pictures out. All names are fixed; whoever starts the
//! image chooses the directory.

use crate::Failure;
use crate::host::{Handle, Mode};
use core::ffi::CStr;

/// What to do: `CONFIG SAMPLES`, what [`unframed_recon::Config::parse`] reads and how many samples
/// are remembered.
pub const JOB: &CStr = c"job";
/// The stream to play.
pub const STREAM: &CStr = c"stream.ufs";
/// One line for each refresh, then what was counted.
pub const FRAMES: &CStr = c"frames.txt";
/// The last picture (binary PPM).
pub const PICTURE: &CStr = c"frame.ppm";
/// What went over the SPI bus: records of a kind (0 command, 1 data, 2 end of a refresh), a length
/// of 16 bits, low byte first, and so many bytes.
pub const BUS: &CStr = c"bus.bin";

/// Bytes read at once: semihosting costs much a call.
pub const CHUNK: usize = 4096;

/// Reads a whole small file; the bytes read.
///
/// # Errors
/// [`Failure::File`].
pub fn read_small<'b>(name: &CStr, buffer: &'b mut [u8]) -> Result<&'b [u8], Failure> {
    let file = Handle::open(name, Mode::Read)?;
    let len = file.read(buffer)?;
    buffer.get(..len).ok_or(Failure::File)
}

/// Hands the stream's bytes to `take`, chunk by chunk, as long as it says so.
///
/// # Errors
/// [`Failure::File`], and what `take` returns.
pub fn each_chunk(mut take: impl FnMut(&[u8]) -> Result<bool, Failure>) -> Result<(), Failure> {
    let file = Handle::open(STREAM, Mode::Read)?;
    let mut chunk = [0; CHUNK];
    loop {
        let len = file.read(&mut chunk)?;
        let bytes = chunk.get(..len).unwrap_or_default();
        if bytes.is_empty() || !take(bytes)? {
            return Ok(());
        }
    }
}

/// A file being written.
pub struct Output(Handle);

impl Output {
    /// Creates the file.
    ///
    /// # Errors
    /// [`Failure::File`].
    pub fn create(name: &CStr) -> Result<Self, Failure> {
        Handle::open(name, Mode::Write).map(Self)
    }

    /// Writes all bytes.
    ///
    /// # Errors
    /// [`Failure::File`].
    pub fn write(&self, bytes: &[u8]) -> Result<(), Failure> {
        self.0.write(bytes)
    }
}

/// A line of text under construction; what does not fit is cut off. (`core::fmt` can panic.)
pub struct Line {
    bytes: [u8; 160],
    len: usize,
}

impl Default for Line {
    fn default() -> Self {
        Self::new()
    }
}

impl Line {
    /// An empty line.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [0; 160],
            len: 0,
        }
    }

    /// Appends text.
    pub fn text(&mut self, text: &str) -> &mut Self {
        text.bytes().for_each(|byte| self.byte(byte));
        self
    }

    /// Appends a number, decimal.
    pub fn number(&mut self, v: u64) -> &mut Self {
        let mut rest = v;
        // The last digit comes first: no number of 64 bits has more than 20.
        let mut digits = [b'0'; 20];
        let mut len = 0;
        for digit in digits.iter_mut().rev() {
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
            len += 1;
            if rest == 0 {
                break;
            }
        }
        digits
            .iter()
            .skip(20 - len)
            .for_each(|byte| self.byte(*byte));
        self
    }

    /// Appends 16 hexadecimal digits.
    pub fn hex(&mut self, v: u64) -> &mut Self {
        for digit in (0..16).rev().map(|i| (v >> (4 * i)) as u8 & 15) {
            self.byte(if digit < 10 {
                b'0' + digit
            } else {
                b'a' - 10 + digit
            });
        }
        self
    }

    /// The line so far.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }

    fn byte(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(self.len) {
            *place = byte;
            self.len += 1;
        }
    }
}
