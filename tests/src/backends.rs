//! The back ends that must show the same bits, and the oracle.

use crate::accuracy::Setting;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use unframed_recon::config::NAMED;
use unframed_recon::display::Counts;
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Arith, Config, Display, Fixed, Player, frame_hash};
use unframed_sim::boards::{Board, BoardError, Firmware, Image, Job, Report};
use unframed_sim::{Gpu, GpuError, GpuPlayer};

/// What a display showed of a stream.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// The picture of every refresh.
    pub pictures: Vec<Vec<[u8; 3]>>,
    /// What was received.
    pub counts: Counts,
}

impl Outcome {
    /// The hash of every refresh.
    #[must_use]
    pub fn hashes(&self) -> Vec<u64> {
        self.pictures.iter().map(|p| frame_hash(p)).collect()
    }
}

/// A stream and how it is to be shown.
#[derive(Clone, Copy, Debug)]
pub struct Show<'a> {
    /// The stream.
    pub bytes: &'a [u8],
    /// The panel.
    pub size: (u16, u16),
    /// A name of [`NAMED`].
    pub method: &'static str,
    /// Samples remembered.
    pub samples: usize,
}

impl Show<'_> {
    /// The configuration that the method names.
    #[must_use]
    pub fn config(&self) -> Config {
        let found = NAMED.iter().find(|(name, _)| *name == self.method);
        found.expect("a known method").1
    }

    /// The display, for a comparison of arithmetics.
    #[must_use]
    pub fn setting(&self) -> Setting {
        Setting {
            config: self.config(),
            size: self.size,
            samples: self.samples,
        }
    }

    /// On this processor, in the given arithmetic.
    #[must_use]
    pub fn here<A: Arith>(&self) -> Outcome {
        let (width, height) = self.size;
        let mut storage = HeapStorage::<A>::new(width, height, self.samples);
        let display = Display::new(self.config(), width, height, storage.memory());
        let mut player = Player::new(display.expect("storage of the right size"));
        let mut outcome = Outcome::default();
        let mut input = self.bytes;
        while player.push(&mut input).is_some() {
            outcome.pictures.push(player.display().picture().to_vec());
        }
        outcome.counts = player.display().counts();
        outcome
    }

    /// On this processor in integers, the deployed code.
    #[must_use]
    pub fn fixed(&self) -> Outcome {
        self.here::<Fixed>()
    }

    /// On the adapter.
    ///
    /// # Errors
    /// Those of the adapter: it may lack memory for this panel.
    pub fn twin(&self, gpu: &Gpu) -> Result<Outcome, GpuError> {
        let (width, height) = self.size;
        let mut player = GpuPlayer::new(gpu, self.config(), width, height, self.samples)?;
        let mut outcome = Outcome::default();
        let mut input = self.bytes;
        while player.push(&mut input)?.is_some() {
            outcome.pictures.push(player.picture().to_vec());
        }
        outcome.counts = player.counts();
        Ok(outcome)
    }

    /// On an emulated board.
    ///
    /// # Errors
    /// Those of the board.
    pub fn board(&self, board: Board, image: Image) -> Result<Report, BoardError> {
        let elf = firmware()?.build(image, board.target())?;
        let job = Job {
            stream: self.bytes,
            method: self.method,
            samples: self.samples,
            timeout: Duration::from_secs(120),
        };
        board.run(&elf, &job)
    }
}

/// The images' source, found once.
///
/// # Errors
/// When it is not there.
pub fn firmware() -> Result<Firmware, BoardError> {
    Firmware::find(Path::new(env!("CARGO_MANIFEST_DIR")))
}

/// Whether something may be missing here: never in CI.
#[must_use]
pub fn may_skip() -> bool {
    std::env::var_os("CI").is_none()
}

/// The adapter, or `None` after a line that says what is left out.
///
/// # Panics
/// In CI, and when an adapter is there and does not work.
#[must_use]
pub fn adapter_or_skip(left_out: &str) -> Option<Gpu> {
    match Gpu::new() {
        Ok(gpu) => Some(gpu),
        Err(error @ GpuError::NoAdapter { .. }) if may_skip() => {
            eprintln!("SKIPPED, not tested: {left_out}: {error}");
            None
        }
        Err(error) => panic!("{left_out}: {error}"),
    }
}

/// Whether an image can be built and run, after a line that says what is left out if not.
///
/// # Panics
/// In CI when a tool is missing, and whenever the image does not build or does not run.
#[must_use]
pub fn boards_or_skip(image: Image, left_out: &str) -> bool {
    static READY: OnceLock<[OnceLock<Option<String>>; 3]> = OnceLock::new();
    let ready = &READY.get_or_init(Default::default)[image as usize];
    let missing = ready.get_or_init(|| {
        let stream = crate::stream::Stream::of_the_plane((4, 4)).bytes;
        let show = Show {
            bytes: &stream,
            size: (4, 4),
            method: "adaptive",
            samples: 16,
        };
        Board::ALL
            .iter()
            .find_map(|board| match show.board(*board, image) {
                Ok(_) => None,
                Err(error @ BoardError::Missing { .. }) if may_skip() => Some(error.to_string()),
                Err(error) => panic!("{left_out}: {error}"),
            })
    });
    if let Some(missing) = missing {
        eprintln!("SKIPPED, not tested: {left_out}: {missing}");
    }
    missing.is_none()
}
