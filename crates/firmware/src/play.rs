//! A stream through the reconstructor: a hash and two counts of instructions for each refresh.

use crate::Failure;
use crate::board::{Counter, paint_stack, stack_used};
use crate::files::{FRAMES, JOB, Line, Output, PICTURE, each_chunk, read_small};
use unframed_recon::memory::Memory;
use unframed_recon::{Arith, Config, Display, frame_hash};
use unframed_wire::{Hello, Packet, Receiver};

/// What to play, and how.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// The reconstruction.
    pub config: Config,
    /// Samples remembered.
    pub samples: usize,
    /// The stream's first Hello.
    pub hello: Hello,
}

impl Job {
    /// Reads the job and the stream's first Hello.
    ///
    /// # Errors
    /// [`Failure::File`], [`Failure::Job`], [`Failure::NoHello`].
    pub fn read() -> Result<Self, Failure> {
        let mut buffer = [0; 160];
        let text = read_small(JOB, &mut buffer)?;
        let mut words = text.trim_ascii().splitn(2, |byte| *byte == b' ');
        let name = words.next().ok_or(Failure::Job)?;
        let config = Config::parse(name).ok_or(Failure::Job)?;
        let samples = decimal(words.next().ok_or(Failure::Job)?).ok_or(Failure::Job)?;
        let hello = first_hello()?.ok_or(Failure::NoHello)?;
        Ok(Self {
            config,
            samples,
            hello,
        })
    }
}

fn decimal(digits: &[u8]) -> Option<usize> {
    digits.iter().try_fold(0usize, |value, byte| {
        let digit = byte.checked_sub(b'0').filter(|digit| *digit < 10)?;
        value.checked_mul(10)?.checked_add(digit.into())
    })
}

#[inline(never)]
fn first_hello() -> Result<Option<Hello>, Failure> {
    let mut receiver = Receiver::new();
    let mut found = None;
    each_chunk(|mut input| {
        while let Some(packet) = receiver.push(&mut input) {
            if let Packet::Hello(hello) = packet {
                found = Some(hello);
                return Ok(false);
            }
        }
        Ok(true)
    })?;
    Ok(found)
}

/// Plays the stream of [`crate::files::STREAM`] and calls `shown` after each refresh.
///
/// Each line of [`FRAMES`]: `refresh INDEX hash HASH receive N show N samples N`: instructions from
/// the last refresh to this one's packet, instructions for its picture, samples remembered.
///
/// # Errors
/// [`Failure::File`], [`Failure::TooLarge`], and what `shown` returns.
pub fn play<A: Arith>(
    job: &Job,
    memory: Memory<'_, A>,
    mut shown: impl FnMut(&Display<'_, A>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    paint_stack();
    let mut display = Display::new(job.config, job.hello.width, job.hello.height, memory)
        .map_err(|_| Failure::TooLarge)?;
    let mut receiver = Receiver::new();
    let frames = Output::create(FRAMES)?;
    let mut counter = Counter::start();
    let mut since = counter.read();
    each_chunk(|mut input| {
        while let Some(packet) = receiver.push(&mut input) {
            if !matches!(packet, Packet::Refresh(_)) {
                display.receive(packet);
                continue;
            }
            let before = counter.read();
            let Some(refresh) = display.receive(packet) else {
                continue;
            };
            let after = counter.read();
            let mut line = Line::new();
            line.text("refresh ").number(refresh.index.into());
            line.text(" hash ").hex(frame_hash(display.picture()));
            line.text(" receive ").number(before.saturating_sub(since));
            line.text(" show ").number(after.saturating_sub(before));
            line.text(" samples ")
                .number(display.buffered() as u64)
                .text("\n");
            frames.write(line.as_bytes())?;
            shown(&display)?;
            since = counter.read();
        }
        Ok(true)
    })?;
    let (counts, link) = (display.counts(), receiver.counters());
    for (name, value) in [
        ("taken", counts.samples),
        ("unplaced", counts.unplaced),
        ("refused", counts.refused),
        ("refreshes", counts.refreshes),
        ("received", link.received),
        ("lost", link.lost),
        ("damaged", link.damaged),
        ("stack", stack_used() as u64),
    ] {
        let mut line = Line::new();
        line.text(name).text(" ").number(value).text("\n");
        frames.write(line.as_bytes())?;
    }
    write_picture(&display)
}

fn write_picture<A: Arith>(display: &Display<'_, A>) -> Result<(), Failure> {
    let file = Output::create(PICTURE)?;
    let (width, height) = display.size();
    let mut line = Line::new();
    line.text("P6 ")
        .number(width.into())
        .text(" ")
        .number(height.into())
        .text(" 255\n");
    file.write(line.as_bytes())?;
    file.write(display.picture().as_flattened())
}
