//! A stream in memory, refresh by refresh, so that many displays can be shown the same.

use anyhow::Result;
use unframed_host::trace::World;

use super::knobs::Knobs;
use crate::args::{Size, Source};
use crate::measure::{REFRESH_HZ, host};
use crate::work::Stopwatch;

/// What one host sent.
#[derive(Debug)]
pub struct Stream {
    /// The bytes up to and with each Refresh.
    pub refreshes: Vec<Vec<u8>>,
    /// Core seconds of the host for a second of animation, from `first` on.
    pub host_seconds: f64,
    /// Bytes a second of animation, from `first` on.
    pub bytes_per_second: f64,
}

impl Stream {
    /// Runs the host of a setting for `refreshes`; costs are counted from refresh `first` on.
    /// To be called on a pool of one thread, or other threads' work is not counted.
    ///
    /// # Errors
    /// The scene cannot be sent.
    pub fn record(
        knobs: &Knobs,
        size: Size,
        seed: u64,
        world: &World,
        refreshes: u32,
        first: u32,
    ) -> Result<Self> {
        let source = Source {
            scene: String::new(),
            clip: None,
            rate: knobs.rate(u32::from(size.width) * u32::from(size.height)),
            seconds: f64::from(refreshes) / f64::from(REFRESH_HZ),
            size,
            seed,
            method: knobs.method,
        };
        let mut host = host(&source, knobs.method, world.clone());
        let mut stream = Self {
            refreshes: Vec::new(),
            host_seconds: 0.0,
            bytes_per_second: 0.0,
        };
        for index in 0..refreshes {
            let mut bytes = Vec::new();
            let watch = Stopwatch::start();
            host.advance(&mut bytes)?;
            if index >= first {
                stream.host_seconds += watch.seconds();
                stream.bytes_per_second += bytes.len() as f64;
            }
            stream.refreshes.push(bytes);
        }
        let seconds = f64::from(refreshes.saturating_sub(first).max(1)) / f64::from(REFRESH_HZ);
        stream.host_seconds /= seconds;
        stream.bytes_per_second /= seconds;
        Ok(stream)
    }
}
