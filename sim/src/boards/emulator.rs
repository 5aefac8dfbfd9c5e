//! Runs an image under QEMU in a directory of its own.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

use super::{Board, BoardError};

/// What to play, and how.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The stream.
    pub stream: &'a [u8],
    /// What the display does, as [`unframed_recon::Config::parse`] reads it.
    pub method: &'a str,
    /// Samples remembered.
    pub samples: usize,
    /// When to give up: an image that hangs is an error.
    pub timeout: Duration,
}

/// One refresh on a board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shown {
    /// The refresh, as the stream counts it.
    pub index: u32,
    /// Hash of its picture.
    pub hash: u64,
    /// Instructions since the refresh before: receiving and storing.
    pub receive: u64,
    /// Instructions of making the picture.
    pub show: u64,
    /// Samples in the deep buffer.
    pub samples: u64,
}

/// What a board did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Every refresh.
    pub shown: Vec<Shown>,
    /// Samples stored or shown.
    pub taken: u64,
    /// Samples that could not be placed.
    pub unplaced: u64,
    /// Packets out of range.
    pub refused: u64,
    /// Good packets.
    pub received: u64,
    /// Packets missing by their sequence numbers.
    pub lost: u64,
    /// Frames thrown away.
    pub damaged: u64,
    /// The most bytes of stack in use at once.
    pub stack: u64,
    /// The last picture.
    pub picture: Vec<[u8; 3]>,
    /// What went over the SPI bus, see `firmware::panel`; empty without one.
    pub bus: Vec<u8>,
}

impl Board {
    /// Runs an image. The same job gives the same report, counts included.
    ///
    /// # Errors
    /// [`BoardError::Missing`] without QEMU, [`BoardError::Run`] when the image fails, panics,
    /// faults or hangs, [`BoardError::File`].
    pub fn run(self, elf: &Path, job: &Job<'_>) -> Result<Report, BoardError> {
        let file = |name: &str| {
            let name = name.to_owned();
            move |error: io::Error| BoardError::File {
                file: name,
                reason: error.to_string(),
            }
        };
        let dir = tempfile::tempdir().map_err(file("a temporary directory"))?;
        let path = |name: &str| dir.path().join(name);
        fs::write(path("stream.ufs"), job.stream).map_err(file("stream.ufs"))?;
        let line = format!("{} {}\n", job.method, job.samples);
        fs::write(path("job"), line).map_err(file("job"))?;
        self.emulate(elf, dir.path(), job.timeout)?;
        let text = fs::read_to_string(path("frames.txt")).map_err(file("frames.txt"))?;
        let mut report = parse(&text).ok_or_else(|| BoardError::File {
            file: "frames.txt".to_owned(),
            reason: format!("not what the image writes:\n{text}"),
        })?;
        let picture = fs::read(path("frame.ppm")).map_err(file("frame.ppm"))?;
        let header = picture.iter().position(|byte| *byte == b'\n');
        let pixels = header.map_or(&[][..], |end| &picture[end + 1..]);
        report.picture = pixels.as_chunks::<3>().0.to_vec();
        report.bus = fs::read(path("bus.bin")).unwrap_or_default();
        Ok(report)
    }

    /// Whether there is an emulator of the board.
    ///
    /// # Errors
    /// [`BoardError::Missing`] with what to install.
    pub fn emulator_is_there(self) -> Result<(), BoardError> {
        let (program, package, _) = self.emulator();
        let version = Command::new(program).arg("--version").output();
        version
            .map(|_| ())
            .map_err(|error| missing(program, package, &error))
    }

    /// The program, the package that has it, its arguments.
    fn emulator(self) -> (&'static str, &'static str, &'static [&'static str]) {
        match self {
            Self::CortexM4F => (
                "qemu-system-arm",
                "qemu-system-arm",
                &["-M", "mps2-an386", "-icount", "shift=6"],
            ),
            Self::CortexM7 => (
                "qemu-system-arm",
                "qemu-system-arm",
                &["-M", "mps2-an500", "-icount", "shift=6"],
            ),
            Self::RiscV => (
                "qemu-system-riscv32",
                "qemu-system-misc",
                &[
                    "-M", "virt", "-cpu", "rv32", "-bios", "none", "-icount", "shift=0",
                ],
            ),
        }
    }

    fn emulate(self, elf: &Path, dir: &Path, timeout: Duration) -> Result<(), BoardError> {
        let (program, package, machine) = self.emulator();
        let child = Command::new(program)
            .args(machine)
            .args(["-nographic", "-monitor", "none", "-serial", "none"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(elf)
            .current_dir(dir)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        let child = child.map_err(|error| missing(program, package, &error))?;
        let status = wait(child, timeout).map_err(|reason| self.failed(reason))?;
        match status {
            0 => Ok(()),
            3 => Err(self.failed("a file cannot be read or written")),
            4 => Err(self.failed("it does not understand the job")),
            5 => Err(self.failed("the stream has no Hello")),
            6 => Err(self.failed("the panel or the deep buffer is beyond its memory")),
            7 => Err(self.failed("the display driver failed")),
            101 => Err(self.failed("the processor met a fault")),
            102 => Err(self.failed("the image panicked")),
            other => Err(self.failed(format!("the emulator ended with status {other}"))),
        }
    }

    fn failed(self, reason: impl Into<String>) -> BoardError {
        BoardError::Run {
            board: self.name(),
            reason: reason.into(),
        }
    }
}

/// The exit status, unless that takes too long.
fn wait(mut child: Child, timeout: Duration) -> Result<i32, String> {
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return status.code().ok_or_else(|| status.to_string()),
            Ok(None) if start.elapsed() < timeout => thread::sleep(Duration::from_millis(5)),
            Ok(None) => {
                let ended = child.kill().and_then(|()| child.wait());
                let trouble = ended.err().map(|error| format!(" ({error})"));
                return Err(format!(
                    "no result after {timeout:?}{}",
                    trouble.unwrap_or_default()
                ));
            }
            Err(error) => return Err(error.to_string()),
        }
    }
}

fn missing(program: &str, package: &str, error: &io::Error) -> BoardError {
    BoardError::Missing {
        what: format!("{program} ({error})"),
        remedy: format!("apt-get install {package}"),
    }
}

fn parse(text: &str) -> Option<Report> {
    let mut report = Report::default();
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            [
                "refresh",
                index,
                "hash",
                hash,
                "receive",
                receive,
                "show",
                show,
                "samples",
                samples,
            ] => {
                report.shown.push(Shown {
                    index: index.parse().ok()?,
                    hash: u64::from_str_radix(hash, 16).ok()?,
                    receive: receive.parse().ok()?,
                    show: show.parse().ok()?,
                    samples: samples.parse().ok()?,
                });
            }
            [name, value] => {
                let value = value.parse().ok()?;
                match name {
                    "taken" => report.taken = value,
                    "unplaced" => report.unplaced = value,
                    "refused" => report.refused = value,
                    "received" => report.received = value,
                    "lost" => report.lost = value,
                    "damaged" => report.damaged = value,
                    "stack" => report.stack = value,
                    "refreshes" if value == report.shown.len() as u64 => {}
                    _ => return None,
                }
            }
            _ => return None,
        }
    }
    (report.stack > 0).then_some(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read_whole_or_not_at_all() {
        let text = "refresh 7 hash 00000000000000ff receive 1 show 2 samples 3\n\
                    taken 4\nunplaced 5\nrefused 6\nrefreshes 1\nreceived 8\nlost 9\ndamaged 10\nstack 11\n";
        let report = parse(text).expect("sound");
        let shown = Shown {
            index: 7,
            hash: 255,
            receive: 1,
            show: 2,
            samples: 3,
        };
        assert_eq!(report.shown, [shown]);
        assert_eq!((report.taken, report.stack), (4, 11));
        assert_eq!(parse(&text.replace("refreshes 1", "refreshes 2")), None);
        assert_eq!(parse(&text.replace("stack 11\n", "")), None);
        assert_eq!(parse(&text.replace("hash", "cash")), None);
    }
}
