//! Builds an image: by the target of rustup where it is installed, else by Debian's compiler with
//! the source of core.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

use super::{BoardError, Target};
use unframed_recon::Config;
use unframed_recon::config::Extents;

/// Debian's compiler, whose package `rust-web-src` holds the source of core.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// One of the images of `crates/firmware`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Image {
    /// The display in integers.
    Play,
    /// The display in `f32`.
    PlayF32,
    /// The display in integers, shown through a driver on a recorded SPI bus.
    Panel,
}

impl Image {
    /// All images.
    pub const ALL: [Self; 3] = [Self::Play, Self::PlayF32, Self::Panel];

    /// The name of its file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Play => "play",
            Self::PlayF32 => "play-f32",
            Self::Panel => "panel",
        }
    }

    fn features(self) -> &'static str {
        match self {
            Self::Play => "",
            Self::PlayF32 => "float",
            Self::Panel => "panel,panics",
        }
    }
}

/// What the image `fitted` has room for: one panel, one preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fitted {
    /// Pixels a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// Samples remembered.
    pub samples: usize,
    /// Objects, and one for the sky.
    pub slots: usize,
    /// What the display does: planes, the hidden-point test, filters and means at rest take room.
    pub config: Config,
}

impl Fitted {
    fn environment(&self) -> [(&'static str, usize); 8] {
        let pixels = self.config.extents == Extents::Pixel;
        [
            ("UNFRAMED_WIDTH", self.width.into()),
            ("UNFRAMED_HEIGHT", self.height.into()),
            ("UNFRAMED_SAMPLES", self.samples),
            ("UNFRAMED_SLOTS", self.slots),
            ("UNFRAMED_PLANES", self.config.planes().into()),
            ("UNFRAMED_PIXELS", pixels.into()),
            ("UNFRAMED_HIDDEN", self.config.hidden.into()),
            ("UNFRAMED_REST", self.config.averages().into()),
        ]
    }
}

/// The source of the images.
#[derive(Clone, Debug)]
pub struct Firmware {
    source: PathBuf,
}

impl Firmware {
    /// Finds `crates/firmware` in `start` or a directory above it.
    ///
    /// # Errors
    /// [`BoardError::Missing`].
    pub fn find(start: &Path) -> Result<Self, BoardError> {
        start
            .ancestors()
            .map(|dir| dir.join("crates/firmware"))
            .find(|dir| dir.join("Cargo.toml").is_file())
            .map(|source| Self { source })
            .ok_or_else(|| BoardError::Missing {
                what: format!("crates/firmware in or above {}", start.display()),
                remedy: "run this in the project's directory".to_owned(),
            })
    }

    /// Builds an image; the path of its ELF file. Does nothing where it is up to date. An image
    /// beyond its budget of flash or RAM, or (but for [`Image::Panel`]) with a path that panics,
    /// does not link.
    ///
    /// # Errors
    /// [`BoardError::Missing`] without a compiler for the target, [`BoardError::Build`].
    pub fn build(&self, image: Image, target: Target) -> Result<PathBuf, BoardError> {
        self.build_with(image, target, image.features())
    }

    /// As [`Firmware::build`], with these features of `crates/firmware`: without `panics` any image
    /// that can panic does not link.
    ///
    /// # Errors
    /// As for [`Firmware::build`].
    pub fn build_with(
        &self,
        image: Image,
        target: Target,
        features: &str,
    ) -> Result<PathBuf, BoardError> {
        self.cargo(image.name(), target, features, &[])
    }

    /// Builds the image that has room for this and nothing else; the path of its ELF file, which
    /// no other build overwrites.
    ///
    /// # Errors
    /// As for [`Firmware::build`], and [`BoardError::File`].
    pub fn build_fitted(&self, target: Target, fitted: &Fitted) -> Result<PathBuf, BoardError> {
        let dir = self.source.join("target/fitted");
        let failed = |error: io::Error| BoardError::File {
            file: dir.display().to_string(),
            reason: error.to_string(),
        };
        fs::create_dir_all(&dir).map_err(failed)?;
        // All sizes have one name at cargo: nobody else may build before this one is put away.
        let lock = fs::File::create(dir.join("lock")).map_err(failed)?;
        lock.lock().map_err(failed)?;
        let sizes = fitted.environment();
        let words = sizes.map(|(name, value)| (name, value.to_string()));
        let elf = self.cargo("fitted", target, "fitted", &words)?;
        let name = sizes.map(|(_, value)| value.to_string()).join("-");
        let kept = dir.join(format!("{}-{name}", target.triple()));
        fs::copy(elf, &kept).map_err(failed)?;
        Ok(kept)
    }

    fn cargo(
        &self,
        image: &'static str,
        target: Target,
        features: &str,
        environment: &[(&str, String)],
    ) -> Result<PathBuf, BoardError> {
        let mut cargo = Command::new("cargo");
        // What a surrounding cargo says concerns another build.
        for (name, _) in env::vars_os() {
            let text = name.to_string_lossy();
            let ours = text == "CARGO_HOME" || text.starts_with("CARGO_HTTP");
            if !ours
                && (text.starts_with("CARGO") || text.starts_with("RUSTC") || text == "RUSTFLAGS")
            {
                cargo.env_remove(name);
            }
        }
        let triple = target.triple();
        cargo.current_dir(&self.source);
        cargo.args([
            "build",
            "--release",
            "--quiet",
            "--locked",
            "--color",
            "never",
        ]);
        cargo.args(["--bin", image, "--target", triple]);
        cargo.args(["--features", features]);
        cargo.envs(environment.iter().map(|(name, value)| (name, value)));
        if !rustup_has(triple) {
            self.use_debian(&mut cargo, triple)?;
        }
        let output = cargo.output().map_err(|error| BoardError::Missing {
            what: format!("cargo ({error})"),
            remedy: "install Rust from rustup.rs".to_owned(),
        })?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            return Err(BoardError::Build {
                image,
                target: triple,
                output: text.trim_end().to_owned(),
            });
        }
        let elf = format!("target/{triple}/release/{image}");
        Ok(self.source.join(elf))
    }

    /// Lets cargo build core from source with Debian's compiler and rustup's linker.
    fn use_debian(&self, cargo: &mut Command, triple: &str) -> Result<(), BoardError> {
        let missing = |what: &str| BoardError::Missing {
            what: what.to_owned(),
            remedy: format!(
                "rustup target add {triple}, or apt-get install rustc-web rust-web-src"
            ),
        };
        let source = "/usr/lib/rustlib/src/rust/library/core";
        if !Path::new(DEBIAN_RUSTC).exists() || !Path::new(source).exists() {
            return Err(missing(&format!("a compiler for {triple}")));
        }
        let sysroot = rustc(&["--print", "sysroot"]).ok_or_else(|| missing("rustc"))?;
        let linker = find_lld(Path::new(&sysroot)).ok_or_else(|| missing("rust-lld"))?;
        let variable = triple.replace('-', "_").to_uppercase();
        cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTC", DEBIAN_RUSTC);
        cargo.env(format!("CARGO_TARGET_{variable}_LINKER"), linker);
        cargo.arg("-Zbuild-std=core");
        Ok(())
    }
}

/// What `rustc` prints; `None` where it fails.
fn rustc(arguments: &[&str]) -> Option<String> {
    let output = Command::new("rustc").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// Whether the compiler has the target's core.
fn rustup_has(triple: &str) -> bool {
    rustc(&["--print", "target-libdir", "--target", triple])
        .is_some_and(|dir| Path::new(&dir).is_dir())
}

/// The linker that rustup's toolchain brings along.
fn find_lld(sysroot: &Path) -> Option<PathBuf> {
    let hosts = fs::read_dir(sysroot.join("lib/rustlib")).ok()?;
    hosts
        .flatten()
        .map(|host| host.path().join("bin/rust-lld"))
        .find(|lld| lld.is_file())
}
