//! What a user types.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::eval::EvalMethod;
use crate::method::Method;

/// A frameless renderer and the display it feeds.
#[derive(Debug, Parser)]
#[command(name = "unframed", version, about, max_term_width = 100)]
pub struct Cli {
    /// What to do; without a command, `run --out unframed-out`.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Host and display together, measured against the ideal renderer.
    Run(RunArgs),
    /// The host alone: a stream into a file.
    Record(RecordArgs),
    /// The display alone: a recorded stream into pictures.
    Play(PlayArgs),
    /// What is in a recorded stream.
    Inspect(InspectArgs),
    /// What a scene calls for; without SCENE, the built-in scenes.
    Scenes(ScenesArgs),
    /// Every method against the ideal renderer, every refresh counted.
    Eval(EvalArgs),
    /// What accuracy costs: error against time, bytes and RAM, knob by knob.
    Cost(CostArgs),
    /// Effects by adaptive interleaved sampling of whole frames, against a path tracer.
    Effects(EffectsArgs),
    /// The display on microcontrollers, emulated by QEMU.
    #[command(subcommand)]
    Firmware(FirmwareCommand),
}

/// `unframed effects`.
#[derive(Debug, Clone, Args)]
pub struct EffectsArgs {
    /// Scenes that call for effects.
    #[arg(value_name = "SCENE", default_values = unframed_host::scene::builtin::EFFECTS)]
    pub scenes: Vec<String>,
    /// Picture size in pixels, WIDTHxHEIGHT.
    #[arg(long, default_value = "128x128", value_parser = parse_size)]
    pub size: Size,
    /// Paths a pixel of the reference.
    #[arg(long, default_value_t = 2500)]
    pub reference: u32,
    /// Frames that are timed, after one that is not; the quickest counts.
    #[arg(long, default_value_t = 5)]
    pub frames: u32,
    /// Side of the interleaving pattern, pixels, odd: 9 samples a pixel at most, whatever it is.
    #[arg(long, default_value_t = unframed_host::effects::framed::SIDE, value_parser = parse_odd)]
    pub pattern: u32,
    /// The instant of the animation, seconds.
    #[arg(long, default_value_t = 1.0)]
    pub at: f64,
    /// Also write each effect off and on with where its samples went, and how effects converge.
    #[arg(long)]
    pub pictures: bool,
    /// Folder for `report.json` and pictures.
    #[arg(long)]
    pub out: PathBuf,
}

/// The scene and how it is sampled.
#[derive(Debug, Clone, Args)]
pub struct Source {
    /// A .glb or .gltf file, or a built-in scene (see `unframed scenes`).
    #[arg(default_value = "interactive")]
    pub scene: String,
    /// Of a glTF file, the one animation clip to play (else all play together).
    #[arg(long)]
    pub clip: Option<String>,
    /// Samples a second; 400k means 400000.
    #[arg(long, default_value = "400k", value_parser = parse_rate)]
    pub rate: u32,
    /// Simulated time, seconds.
    #[arg(long, default_value_t = 3.0, value_parser = parse_seconds)]
    pub seconds: f64,
    /// Panel size in pixels, WIDTHxHEIGHT.
    #[arg(long, default_value = "256x256", value_parser = parse_size)]
    pub size: Size,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How to sample and reconstruct.
    #[arg(long, value_enum, default_value_t = Method::Adaptive)]
    pub method: Method,
    /// Leave all shadows in the samples: for displays that draw none, as the images for boards.
    #[arg(long)]
    pub no_lamps: bool,
}

/// Which display hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DisplayKind {
    /// wgpu on a hardware adapter, else the CPU.
    Auto,
    /// The firmware's code on this CPU.
    Cpu,
    /// Its twin in shaders.
    Wgpu,
}

/// The display.
#[derive(Debug, Clone, Args)]
pub struct DisplayArgs {
    /// Which display hardware: all show the same bits.
    #[arg(long, value_enum, default_value_t = DisplayKind::Auto)]
    pub display: DisplayKind,
    /// Samples that the display remembers.
    #[arg(long, default_value = "400k", value_parser = parse_rate)]
    pub samples: u32,
}

/// `unframed run`
#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// The scene and how it is sampled.
    #[command(flatten)]
    pub source: Source,
    /// The display.
    #[command(flatten)]
    pub panel: DisplayArgs,
    /// Never open a window (the default; refuses --window).
    #[arg(long, conflicts_with = "window")]
    pub headless: bool,
    /// Show it live in a window instead of measuring it. Keys: m method, t tiling, space pause,
    /// q quit.
    #[arg(long)]
    pub window: bool,
    /// Close the window after this many refreshes.
    #[arg(long, requires = "window")]
    pub frames: Option<u64>,
    /// Measure every N-th refresh against the ideal image.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,
    /// Pictures, report.html, report.json and hashes.txt go into this directory.
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `unframed record`
#[derive(Debug, Clone, Args)]
pub struct RecordArgs {
    /// The scene and how it is sampled.
    #[command(flatten)]
    pub source: Source,
    /// The file to write.
    #[arg(short, long, value_name = "FILE.ufs")]
    pub output: PathBuf,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `unframed play`
#[derive(Debug, Clone, Args)]
pub struct PlayArgs {
    /// The stream.
    #[arg(value_name = "FILE.ufs")]
    pub file: PathBuf,
    /// The display.
    #[command(flatten)]
    pub panel: DisplayArgs,
    /// How the display reconstructs.
    #[arg(long, value_enum, default_value_t = Method::Adaptive)]
    pub method: Method,
    /// Print one line a refresh: its index and the hash of its picture.
    #[arg(long)]
    pub hashes: bool,
    /// Write each picture as PNG into this directory.
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Print one JSON object instead of text.
    #[arg(long, conflicts_with = "hashes")]
    pub json: bool,
}

/// `unframed inspect`
#[derive(Debug, Clone, Args)]
pub struct InspectArgs {
    /// The stream.
    #[arg(value_name = "FILE.ufs")]
    pub file: PathBuf,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `unframed scenes`
#[derive(Debug, Clone, Args)]
pub struct ScenesArgs {
    /// A .glb or .gltf file, or a built-in scene.
    pub scene: Option<String>,
    /// Of a glTF file, the one animation clip to play.
    #[arg(long)]
    pub clip: Option<String>,
    /// Write the scene as a binary glTF file.
    #[arg(long, value_name = "NAME.glb")]
    pub export: Option<PathBuf>,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// What an evaluation finds out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EvalTable {
    /// All methods at all rates.
    Main,
    /// What each part of `adaptive` is worth, at 400k: the method without it.
    Ablation,
    /// Whether a still picture converges within 5 s, and how fast a cut is forgotten.
    Golden,
}

/// How much of an animation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stretch {
    /// All of it, once.
    Loop,
    /// Its first seconds, again from the beginning where it is shorter.
    Seconds(f64),
}

impl Stretch {
    /// In seconds, for an animation that takes `duration`; 0 does not move.
    #[must_use]
    pub fn of(self, duration: f64) -> f64 {
        /// Of what does not move.
        const STILL: f64 = 3.0;
        /// A file may say anything.
        const LONGEST: f64 = 60.0;
        match self {
            Self::Seconds(seconds) => seconds,
            Self::Loop if duration > 0.0 => duration.min(LONGEST),
            Self::Loop => STILL,
        }
    }
}

impl std::fmt::Display for Stretch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Loop => f.write_str("loop"),
            Self::Seconds(seconds) => write!(f, "{seconds}"),
        }
    }
}

/// `unframed eval`
#[derive(Debug, Clone, Args)]
pub struct EvalArgs {
    /// Built-in scenes and .glb or .gltf files.
    #[arg(value_name = "SCENE", default_values = ["interactive", "walkthrough", "toycar"])]
    pub scenes: Vec<String>,
    /// Samples a second, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "100k,400k,800k", value_parser = parse_rate)]
    pub rates: Vec<u32>,
    /// Methods, separated by commas; all without this.
    #[arg(long, value_delimiter = ',')]
    pub methods: Vec<EvalMethod>,
    /// Simulated time: seconds, or `loop` for each animation from its beginning to its end, once.
    #[arg(long, default_value_t = Stretch::Loop, value_parser = parse_stretch)]
    pub seconds: Stretch,
    /// How many seeds, from 1 on: mean and spread are reported.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub seeds: u16,
    /// Panel size in pixels, WIDTHxHEIGHT.
    #[arg(long, default_value = "256x256", value_parser = parse_size)]
    pub size: Size,
    /// Samples that a display remembers.
    #[arg(long, default_value = "400k", value_parser = parse_rate)]
    pub samples: u32,
    /// What to find out, separated by commas.
    #[arg(long, value_delimiter = ',', value_enum, default_value = "main")]
    pub tables: Vec<EvalTable>,
    /// Do not measure ColorVideoVDP (over the whole, of the first seed; 0.06 s a refresh of
    /// 256x256).
    #[arg(long)]
    pub no_cvvdp: bool,
    /// Measure FLIP at every N-th refresh (0.015 s for one of 256x256); 0: never.
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub flip_every: u32,
    /// Also find out how much of the error is age: at three refreshes all stored samples are
    /// traced again.
    #[arg(long)]
    pub causes: bool,
    /// Cells that run at once; all cores without this. Changes no result.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Numbers, plots and pictures go into this directory, and finished cells, so that the same
    /// command goes on where it was stopped.
    #[arg(long, default_value = "unframed-eval")]
    pub out: PathBuf,
    /// Keep ideal images in this directory; OUT/ideals without this.
    #[arg(long)]
    pub cache: Option<PathBuf>,
    /// Write the numbers to this file too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Measure all cells again, even finished ones.
    #[arg(long)]
    pub fresh: bool,
}

/// `unframed cost`
#[derive(Debug, Clone, Args)]
pub struct CostArgs {
    /// .glb or .gltf files, or built-in scenes: each setting is measured on all of them, but for
    /// the pattern of effects, which has a scene of its own.
    #[arg(value_name = "SCENE", default_values = ["interactive", "walkthrough", "toycar"])]
    pub scenes: Vec<String>,
    /// Panel size in pixels, WIDTHxHEIGHT. Rates and memories are set by the pixel.
    #[arg(long, default_value = "128x128", value_parser = parse_size)]
    pub size: Size,
    /// Simulated time that counts, seconds; before it half a second to fill the display.
    #[arg(long, default_value_t = 1.0, value_parser = parse_seconds)]
    pub seconds: f64,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Measure this preset alone; several, separated by commas.
    #[arg(long, value_delimiter = ',')]
    pub preset: Vec<String>,
    /// Measure the presets alone, not all sweeps.
    #[arg(long)]
    pub presets_only: bool,
    /// Find the best preset for a machine, such as "cortex-m7@480MHz link=20Mbit/s ram=1MiB
    /// 128x128@60Hz"; `cpi=1.2` says how many cycles an instruction takes (1 if not said), `this`
    /// instead of a core and its clock is this machine. Can be repeated.
    #[arg(long)]
    pub budget: Vec<String>,
    /// Points that are measured at once; all cores without this.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Numbers and plots go into this directory, and finished points, so that the same command
    /// goes on where it was stopped.
    #[arg(long, default_value = "unframed-cost")]
    pub out: PathBuf,
    /// Write the numbers to this file too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Measure all points again, even finished ones.
    #[arg(long)]
    pub fresh: bool,
}

/// `unframed firmware`
#[derive(Debug, Clone, Subcommand)]
pub enum FirmwareCommand {
    /// Build the images; says what to install where no compiler is found.
    Build(FirmwareArgs),
    /// Play a stream on the boards: hashes, instructions, stack.
    Run(FirmwareRunArgs),
    /// What the images hold. Fails where one can panic, allocates or computes with floats.
    Size(FirmwareArgs),
}

/// `unframed firmware build`, `unframed firmware size`
#[derive(Debug, Clone, Args)]
pub struct FirmwareArgs {
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// A choice of emulated boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BoardKind {
    /// All three.
    All,
    /// mps2-an386.
    CortexM4f,
    /// mps2-an500.
    CortexM7,
    /// virt.
    Rv32imac,
}

/// `unframed firmware run`
#[derive(Debug, Clone, Args)]
pub struct FirmwareRunArgs {
    /// The stream, for at most 4096 pixels.
    #[arg(value_name = "FILE.ufs")]
    pub file: PathBuf,
    /// Where.
    #[arg(long, value_enum, default_value_t = BoardKind::All)]
    pub board: BoardKind,
    /// Compute in f32 instead of integers, for comparison.
    #[arg(long)]
    pub f32: bool,
    /// How the display reconstructs: adaptive, adaptive-constant, uniform, paper or frameless, and
    /// what differs from it: adaptive,fit=mean,hidden=off,width=-295,lifetime=tiles,kernel=gaussian.
    #[arg(long, default_value = "adaptive")]
    pub method: String,
    /// Samples that the display remembers, at most 65536.
    #[arg(long, default_value = "16384", value_parser = parse_rate)]
    pub samples: u32,
    /// Print one line a refresh: board, index, hash, instructions.
    #[arg(long, conflicts_with = "json")]
    pub hashes: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub json: bool,
}

/// A panel's size, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Pixels a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
}

fn parse_rate(text: &str) -> Result<u32, String> {
    let lower = text.trim().to_ascii_lowercase();
    let (digits, factor) = match lower.strip_suffix(['k', 'm']) {
        Some(digits) if lower.ends_with('k') => (digits, 1e3),
        Some(digits) => (digits, 1e6),
        None => (lower.as_str(), 1.0),
    };
    let value: f64 = digits
        .parse()
        .map_err(|_| format!("`{text}` is not a number like 400k or 1.5m"))?;
    let value = (value * factor).round();
    if (1.0..=1e8).contains(&value) {
        Ok(value as u32)
    } else {
        Err(format!("`{text}` is out of range: 1 to 100m"))
    }
}

fn parse_odd(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(side @ 1..=15) if side % 2 == 1 => Ok(side),
        _ => Err(format!("`{text}` is not an odd number from 1 to 15")),
    }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let value: f64 = text
        .parse()
        .map_err(|_| format!("`{text}` is not a number of seconds"))?;
    if value > 0.0 && value <= 3600.0 {
        Ok(value)
    } else {
        Err(format!(
            "`{text}` is out of range: above 0, at most 3600 seconds"
        ))
    }
}

fn parse_stretch(text: &str) -> Result<Stretch, String> {
    if text == "loop" {
        return Ok(Stretch::Loop);
    }
    let seconds = parse_seconds(text).map_err(|error| format!("{error}; or say `loop`"))?;
    Ok(Stretch::Seconds(seconds))
}

fn parse_size(text: &str) -> Result<Size, String> {
    let limit = unframed_recon::Panel::LIMIT;
    let side = |side: &str| side.trim().parse::<u32>().ok();
    let (width, height) = text
        .to_ascii_lowercase()
        .split_once('x')
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| format!("`{text}` is not a size like 256x256"))?;
    let fits = |side: u32| side >= 1 && side <= u32::from(limit);
    if fits(width) && fits(height) {
        Ok(Size {
            width: width as u16,
            height: height as u16,
        })
    } else {
        Err(format!(
            "`{text}` is out of range: 1x1 to {limit}x{limit} pixels"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates() {
        assert_eq!(parse_rate("400k"), Ok(400_000));
        assert_eq!(parse_rate("1.5M"), Ok(1_500_000));
        assert_eq!(parse_rate("7"), Ok(7));
        for bad in ["0", "0k", "", "k", "-1", "nan", "inf", "1e9", "400kk"] {
            assert!(parse_rate(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes() {
        assert_eq!(
            parse_size("1x4080"),
            Ok(Size {
                width: 1,
                height: 4080
            })
        );
        for bad in [
            "0x0",
            "256",
            "256x",
            "4081x1",
            "-1x5",
            "99999999999x1",
            "axb",
        ] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn seconds() {
        assert_eq!(parse_stretch("loop"), Ok(Stretch::Loop));
        assert_eq!(parse_stretch("1.5"), Ok(Stretch::Seconds(1.5)));
        assert!(parse_stretch("lop").is_err_and(|error| error.contains("loop")));
        assert_eq!(Stretch::Loop.of(8.0), 8.0);
        assert_eq!(Stretch::Seconds(0.5).of(8.0), 0.5);
        assert!(Stretch::Loop.of(0.0) > 0.0);
        assert!(Stretch::Loop.of(1e30) < 100.0);
        assert_eq!(parse_seconds("0.5"), Ok(0.5));
        for bad in ["0", "-1", "nan", "inf", "1e9", "x"] {
            assert!(parse_seconds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_command_line_is_sound() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }
}
